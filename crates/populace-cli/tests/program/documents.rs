//! Runs the commands of `docs/trajectories.md` on small files with the names that they use.

mod examples;

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A fenced block of the page, with its language.
struct Block {
    language: String,
    lines: Vec<String>,
}

fn page() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::fs::read_to_string(root.join("docs/trajectories.md")).expect("docs/trajectories.md")
}

fn blocks(page: &str) -> Vec<Block> {
    let (mut blocks, mut open): (Vec<Block>, Option<Block>) = (Vec::new(), None);
    for line in page.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(language), None) => {
                open = Some(Block { language: language.to_owned(), lines: Vec::new() });
            }
            (None, Some(block)) => block.lines.push(line.to_owned()),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

/// Returns the arguments of a command of the program, without its comment.
fn arguments(line: &str) -> Vec<String> {
    let command = line.split(" #").next().unwrap_or_default();
    let mut words = command.split_whitespace().map(str::to_owned);
    assert_eq!(words.next().as_deref(), Some("populace"), "{line}");
    words.collect()
}

/// Returns the arguments with small pictures, a short film and a small cast.
fn shortened(mut args: Vec<String>) -> Vec<String> {
    if args[0] != "render" {
        return args;
    }
    if let Some(at) = args.iter().position(|arg| arg == "--size") {
        args.drain(at..at + 2);
    }
    let has = |flags: &[&str]| args.iter().any(|arg| flags.contains(&arg.as_str()));
    let mut more = vec!["--device", "native", "--size", "64x36"];
    if !has(&["--frames", "--at"]) {
        more.extend(["--frames", "2"]);
    }
    if !has(&["--cast"]) {
        more.extend(["--cast", "@child"]);
    }
    args.extend(more.into_iter().map(str::to_owned));
    args
}

/// Runs a command of the page in a folder.
fn run(folder: &Path, line: &str) {
    let args = shortened(arguments(line));
    let mut command = Command::new(env!("CARGO_BIN_EXE_populace"));
    let output = command.args(&args).current_dir(folder).output().expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}\n{stderr}");
    assert!(!stderr.contains("warning"), "{line}\n{stderr}");
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!stdout.is_empty(), "{line}");
    let Some(out) = args.iter().position(|arg| arg == "--out") else { return };
    let written = if args.iter().any(|arg| arg == "--json") {
        let document: serde_json::Value = serde_json::from_str(&stdout).expect("a document");
        PathBuf::from(document["out"].as_str().expect("a path"))
    } else {
        PathBuf::from(stdout.trim_end())
    };
    assert!(folder.join(&written).is_file(), "{line}: no {}", written.display());
    assert_eq!(written.extension(), Path::new(&args[out + 1]).extension(), "{line}");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn commands_of_the_page_on_trajectories_run() {
    let folder = TempDir::new().expect("a temporary folder");
    examples::write(folder.path());
    let blocks = blocks(&page());
    let shell = blocks.iter().filter(|block| block.language == "sh");
    let lines: Vec<&String> = shell.flat_map(|block| &block.lines).collect();
    assert!(lines.len() > 15, "only {} commands", lines.len());
    lines.iter().for_each(|line| run(folder.path(), line));
    // Every example is used.
    for name in examples::names() {
        let is_used = lines.iter().any(|line| line.split_whitespace().any(|word| word == name));
        assert!(is_used, "no command with {name}");
    }
}

/// The formats that the page names are those of the program.
#[test]
fn the_page_has_a_section_for_each_format() {
    let page = page();
    let refused = crate::populace(&["inspect", "x", "--format", "none"]);
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    let names = message.split("the formats are ").nth(1).expect("the names");
    let names = names.lines().next().expect("a line").split(", ");
    let names: Vec<&str> = names.map(|name| name.trim()).collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        assert!(page.contains(&format!("`{name}`")), "docs/trajectories.md does not name {name}");
    }
}
