//! Imports small generated files that each follow or break one rule.

mod accessors;
mod animations;
mod builder;
mod containers;
mod extensions;
mod folders;
mod limits;
mod materials;
mod meshes;
mod mutations;
mod nodes;
mod skins;
mod written;

use populace_assets::{Error, Imported, load_from_slice};

/// Loads a valid file.
fn loaded(file: &[u8]) -> Imported {
    load_from_slice(file, None).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns all problems of a refused file.
fn problems(file: &[u8]) -> Vec<String> {
    match load_from_slice(file, None) {
        Err(Error::Rejected { problems, .. }) => problems.iter().map(ToString::to_string).collect(),
        Err(other) => panic!("{other}"),
        Ok(imported) => panic!("it loads, with {:?}", imported.notes),
    }
}

/// Asserts that a file has exactly one problem and that it begins with `begins`.
#[track_caller]
fn assert_problem(file: &[u8], begins: &str) {
    let problems = problems(file);
    assert!(
        problems.len() == 1 && problems[0].starts_with(begins),
        "not `{begins}`: {problems:#?}"
    );
}

/// Asserts that a file loads and that one of its notes begins with `begins`.
#[track_caller]
fn assert_note(file: &[u8], begins: &str) {
    let notes: Vec<_> = loaded(file).notes.iter().map(ToString::to_string).collect();
    assert!(notes.iter().any(|n| n.starts_with(begins)), "not `{begins}`: {notes:#?}");
}
