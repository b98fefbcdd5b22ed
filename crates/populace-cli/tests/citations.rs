//! Checks citations in sources and documents.

use std::fs;
use std::path::{Path, PathBuf};

/// The paper that is cited by section, figure and equation. Only its first pages were available.
const PAPER: &str = concat!("Lister & Day", " 2012");

/// The known parts of the paper: words that precede numbers, and the valid numbers.
const KNOWN: [(&[&str], &[&str]); 3] = [
    (&["section", "sections"], &["1", "2", "3", "3.1", "3.2"]),
    (&["fig", "figs"], &["1", "2", "3", "4"]),
    (&["eq", "equation"], &["1"]),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns the files below a folder with one of the given extensions.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("target") {
            found.extend(files(&path, extensions));
        } else if path
            .extension()
            .is_some_and(|e| extensions.iter().any(|extension| e == *extension))
        {
            found.push(path);
        }
    }
    found
}

/// Returns a file's text as one line, without comment marks.
fn joined_text(path: &Path) -> String {
    let text =
        fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines =
        text.lines().map(|line| line.trim_start().trim_start_matches(['/', '*', '!']).trim());
    lines.collect::<Vec<_>>().join(" ")
}

/// Returns the numbers that follow one of the words in a citation.
fn numbers<'a>(citation: &'a str, words: &[&str]) -> Vec<&'a str> {
    let mut found = Vec::new();
    let mut follows = false;
    for word in citation.split([' ', ',', '(', ')', ';', ':']).map(|w| w.trim_end_matches('.')) {
        let is_number = word.starts_with(|c: char| c.is_ascii_digit());
        follows = words.contains(&word) || follows && (is_number || matches!(word, "" | "and"));
        if follows && is_number {
            found.push(word);
        }
    }
    found
}

#[test]
fn paper_is_cited_by_known_sections() {
    let endings = ["rs", "cl", "glsl", "md"];
    let mut count = 0;
    for path in
        files(&root().join("crates"), &endings).iter().chain(&files(&root().join("docs"), &endings))
    {
        for citation in joined_text(path).split(PAPER).skip(1) {
            let citation: String = citation.chars().take(40).collect();
            let place = format!("{}: {PAPER}{citation}", path.display());
            assert!(!numbers(&citation, KNOWN[0].0).is_empty(), "names no section: {place}");
            for (words, known) in KNOWN {
                let unknown = numbers(&citation, words).into_iter().find(|n| !known.contains(n));
                assert_eq!(unknown, None, "{} not known: {place}", words[0]);
            }
            count += 1;
        }
    }
    assert!(count > 5, "{count} citations of the paper are too few to trust this test");
}

#[test]
fn twins_name_each_other() {
    let crates = root().join("crates");
    let kernels = crates.join("populace-opencl/kernels");
    let mut count = 0;
    for path in files(&crates, &["rs"]) {
        let text = fs::read_to_string(&path).expect("a source");
        let head: Vec<_> =
            text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).collect();
        let own = path.strip_prefix(&crates).expect("a path below crates").to_string_lossy();
        let own = own.split_once("src/").map_or(&*own, |(_, file)| file).to_owned();
        for named in head.join(" ").to_lowercase().split("twin of ").skip(1) {
            let Some(kernel) = named.split("`kernels/").nth(1) else { continue };
            let kernel = kernel.split('`').next().expect("a name");
            let text = joined_text(&kernels.join(kernel));
            assert!(text.contains(&own), "{kernel} does not name {}", path.display());
            count += 1;
        }
    }
    assert!(count > 20, "{count} twins are too few to trust this test");
    for path in files(&kernels, &["cl"]) {
        for named in joined_text(&path).split("populace-").skip(1) {
            let file: String =
                named.chars().take_while(|c| c.is_alphanumeric() || "/_.-".contains(*c)).collect();
            let file = file.trim_end_matches('.');
            let file_path = crates.join(format!("populace-{file}"));
            assert!(file_path.exists(), "{} names {}", path.display(), file_path.display());
        }
    }
}
