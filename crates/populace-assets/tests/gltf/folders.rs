//! Access to files: only regular files in the folder of the file that refers to them are read.

use std::path::Path;

use populace_assets::{Error, LoadOptions, load, load_from_reader, load_with};
use serde_json::json;

use super::builder::{File, rigid};

const OUTSIDE: LoadOptions = LoadOptions { allow_outside: true, memory_limit_bytes: 1 << 30 };

/// Creates the folder `model` with `file.gltf`, whose buffer and image both have `uri`.
fn model(root: &Path, uri: &str) -> (File, std::path::PathBuf) {
    let mut file = rigid();
    file.json["images"] = json!([{"uri": uri}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    let path = root.join("model/file.gltf");
    std::fs::create_dir_all(root.join("model")).expect("a folder");
    std::fs::write(&path, file.gltf_with_buffer_uri(uri)).expect("written");
    (file, path)
}

#[test]
fn outside_files_are_read_only_with_allow_outside() {
    let root = tempfile::tempdir().unwrap();
    let absolute = root.path().join("secret").to_string_lossy().into_owned();
    for uri in ["../secret", "a/../../secret", "%2E%2E/secret", &absolute] {
        let (file, path) = model(root.path(), uri);
        std::fs::create_dir_all(root.path().join("model/a")).unwrap();
        std::fs::write(root.path().join("secret"), &file.bin).unwrap();
        let there = load(&path).unwrap_err().to_string();
        assert!(
            there.contains("buffers[0].uri: refers to") && there.contains("--allow-outside"),
            "{there}"
        );
        assert_eq!(load_with(&path, &OUTSIDE).unwrap().character.parts.len(), 1, "{uri}");
        // The message does not reveal whether the file exists.
        std::fs::remove_file(root.path().join("secret")).unwrap();
        assert_eq!(load(&path).unwrap_err().to_string(), there, "{uri}");
        assert_ne!(load_with(&path, &OUTSIDE).unwrap_err().to_string(), there);
    }
}

#[test]
fn image_notes_do_not_reveal_outside_files() {
    let root = tempfile::tempdir().unwrap();
    let (mut file, path) = model(root.path(), "../secret");
    file.json["buffers"] = json!(null);
    std::fs::write(&path, file.glb()).unwrap();
    let notes = || load(&path).unwrap().notes;
    let gone = notes();
    assert!(
        gone.iter().any(|n| n.place == "images[0]" && n.what.contains("is outside")),
        "{gone:?}"
    );
    std::fs::write(root.path().join("secret"), "no image").unwrap();
    assert_eq!(notes(), gone);
    let allowed = load_with(&path, &OUTSIDE).unwrap().notes;
    assert!(allowed.iter().any(|n| n.what.contains("is not a PNG")), "{allowed:?}");
}

#[cfg(unix)]
#[test]
fn symbolic_links_are_resolved_before_the_check() {
    use std::os::unix::fs::symlink;
    let root = tempfile::tempdir().unwrap();
    let (file, path) = model(root.path(), "link");
    let link = root.path().join("model/link");
    std::fs::write(root.path().join("model/inside"), &file.bin).unwrap();
    symlink("inside", &link).unwrap();
    assert_eq!(load(&path).unwrap().character.parts.len(), 1);
    let refused = |target: &str| {
        std::fs::remove_file(&link).unwrap();
        symlink(target, &link).unwrap();
        load(&path).unwrap_err().to_string()
    };
    std::fs::write(root.path().join("secret"), &file.bin).unwrap();
    let there = refused("../secret");
    assert!(there.contains("is outside"), "{there}");
    assert_eq!(there, refused("../gone"));
    // If the glTF file itself is a link, its folder is that of the link.
    symlink(&path, root.path().join("named.gltf")).unwrap();
    std::fs::write(root.path().join("link"), &file.bin).unwrap();
    assert_eq!(load(root.path().join("named.gltf")).unwrap().character.parts.len(), 1);
}

#[cfg(unix)]
#[test]
fn pipes_devices_sockets_and_folders_are_not_read() {
    let root = tempfile::tempdir().unwrap();
    let pipe = root.path().join("model/pipe");
    let (_, path) = model(root.path(), "pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let socket = root.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for other in [&pipe, &socket, Path::new("/dev/zero"), root.path()] {
        let Err(Error::Io { source, .. }) = load(other) else { panic!("{other:?} was read") };
        assert_eq!(source.to_string(), "it is not a regular file", "{other:?}");
    }
    let error = load(&path).unwrap_err().to_string();
    assert!(
        error.contains("refers to \"pipe\", which cannot be read: it is not a regular file"),
        "{error}"
    );
}

#[test]
fn stream_loads_without_other_files() {
    let options = LoadOptions::default();
    let bytes = rigid().glb();
    let imported = load_from_reader(&bytes[..], "a stream", &options).unwrap();
    assert_eq!((imported.character.name.as_str(), imported.character.parts.len()), ("a stream", 1));
    let error = load_from_reader(&bytes[..99], "a stream", &options).unwrap_err().to_string();
    assert!(error.starts_with("a stream is refused:\nheader: says the file has"), "{error}");
    let error =
        load_from_reader(&rigid().gltf_with_buffer_uri("Cargo.toml")[..], "a stream", &OUTSIDE)
            .unwrap_err();
    assert!(error.to_string().contains("this input has no folder to find it in"), "{error}");
    let error = load_from_reader(std::io::repeat(0), "a stream", &options).unwrap_err().to_string();
    assert!(error.contains("file: is not a glTF file"), "{error}");
}
