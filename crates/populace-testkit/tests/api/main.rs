//! Compares the public items of the libraries with the lists in `docs/api`, so that a change to
//! them shows in a diff.
//!
//! The lists come from the sources alone. A macro whose input is Rust items counts as those items;
//! of other macros that declare public functions, the functions and the calls are listed.

mod items;
mod library;
mod lines;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use library::Library;

const RENEW: &str = "POPULACE_RENEW_API=1 cargo test -p populace-testkit --test api";

#[test]
fn public_items_are_those_of_the_lists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let lists = root.join("docs/api");
    let mut wrong = String::new();
    let mut expected = BTreeSet::new();
    for (name, folder) in published_libraries(&root) {
        let found = Library::read(&name, &folder).public_lines();
        let list = lists.join(format!("{name}.txt"));
        if std::env::var_os("POPULACE_RENEW_API").is_some() {
            let text: String = found.iter().map(|line| format!("{line}\n")).collect();
            std::fs::create_dir_all(&lists).expect("a folder");
            std::fs::write(&list, text).expect("the list is writable");
        }
        let listed = std::fs::read_to_string(&list).unwrap_or_default();
        let listed: BTreeSet<String> = listed.lines().map(str::to_owned).collect();
        listed.difference(&found).for_each(|line| wrong += &format!("- {line}\n"));
        found.difference(&listed).for_each(|line| wrong += &format!("+ {line}\n"));
        expected.insert(list);
    }
    for file in std::fs::read_dir(&lists).expect("docs/api") {
        let file = file.expect("a file").path();
        assert!(expected.contains(&file), "{} is of no published library", file.display());
    }
    assert!(wrong.is_empty(), "docs/api differs from the sources; renew it by {RENEW}\n{wrong}");
}

/// Returns the name and the folder of each library that is not marked `publish = false`.
fn published_libraries(root: &Path) -> BTreeMap<String, PathBuf> {
    let mut all = BTreeMap::new();
    for folder in std::fs::read_dir(root.join("crates")).expect("crates") {
        let folder = folder.expect("a crate").path();
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("Cargo.toml");
        if folder.join("src/lib.rs").exists() && !manifest.contains("publish = false") {
            let name = folder.file_name().and_then(|name| name.to_str()).expect("a name");
            all.insert(name.to_owned(), folder);
        }
    }
    all
}
