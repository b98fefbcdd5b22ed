//! Tests of `--cache-levels`.

use populace::character::Character;
use populace_assets::{WriteOptions, to_glb};
use tempfile::TempDir;

use crate::{json_of, populace};

fn glb(character: &Character, generator: &str) -> Vec<u8> {
    let options = WriteOptions { generator, ..WriteOptions::default() };
    to_glb(character, &options).expect("a file")
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn levels_are_kept_beside_a_file_until_it_changes() {
    let folder = TempDir::new().expect("a temporary folder");
    let text = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (source, cache, out) = (text("one.glb"), text("one.levels.glb"), text("one.png"));
    let args = [
        "render",
        &source,
        "--cache-levels",
        "--members",
        "40",
        "--size",
        "160x90",
        "--device",
        "native",
        "--json",
        "--out",
        &out,
    ];
    let level_count = || json_of(&args)["levels"].as_array().expect("numbers").len();
    let mut people = populace_cast::cast().expect("people");
    let (man, woman) = (people.swap_remove(1), people.swap_remove(0));
    std::fs::write(&source, glb(&man, "")).expect("written");

    let all = level_count();
    assert!(all > 2, "{all} levels are seen");
    let kept = populace_assets::load(&cache).expect("a cache");
    let errors_m = |character: &Character| -> Vec<f32> {
        character.levels().iter().map(|level| level.error_m).collect()
    };
    let made = populace_lod::with_levels(man.clone()).expect("levels");
    assert_eq!(errors_m(&kept.character), errors_m(&made));

    // A cache with one level shows that it is read, and left as it is.
    let generator = kept.generator.expect("the digest of the source");
    let first = made.levels()[..1].to_vec();
    let one = glb(&made.with_levels(first).expect("a level"), &generator);
    std::fs::write(&cache, &one).expect("written");
    assert_eq!(level_count(), 2);
    assert!(std::fs::read(&cache).expect("a file") == one);

    std::fs::write(&source, glb(&woman, "")).expect("written");
    assert!(level_count() > 2, "the cache of another file was read");
    let renewed = populace_assets::load(&cache).expect("a cache");
    assert_ne!(renewed.generator.as_ref(), Some(&generator));

    let other = glb(&man, "another program");
    std::fs::write(&cache, &other).expect("written");
    let output = populace(&args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("one.levels.glb is another file"), "{stderr}");
    assert!(std::fs::read(&cache).expect("a file") == other, "it is left as it was");

    std::fs::remove_file(&cache).expect("removed");
    std::fs::create_dir(&cache).expect("a folder in its place");
    let output = populace(&args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("are not cached") && stderr.contains("one.levels.glb"), "{stderr}");
}
