//! Holds the order of the modules within each crate: no circles between siblings.
//!
//! The rule: modules that are declared side by side, each with its own children, must not use each
//! other in a circle. A module and its children are one unit and may use each other, because
//! children extend their parent's types and the parent calls its children. A path counts for the
//! module that declares the item, so a circle through re-exports of the crate root is a circle too.
//! Tests are left out: they use everything.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Circles that are known: the crate, and the modules of one circle. To be emptied, never extended.
const KNOWN: &[(&str, &[&str])] = &[
    ("populace-cast", &["motion", "rig", "surface"]),
    ("populace-testkit", &["oracle", "tolerance"]),
];

/// A module's path in its crate; empty for the root.
type Module = Vec<String>;

/// One module as far as this test needs it.
#[derive(Default)]
struct Source {
    text: String,
    /// Paths that `use` brings in, by the name that they have here; globs under `*`.
    imports: Vec<(String, Vec<String>)>,
}

/// The modules of a crate.
struct Sources(BTreeMap<Module, Source>);

impl Sources {
    fn new(texts: impl IntoIterator<Item = (Module, String)>) -> Self {
        let source = |(module, text): (Module, String)| {
            let text = without_comments_and_tests(&text);
            (module, Source { imports: imports(&text), text })
        };
        Self(texts.into_iter().map(source).collect())
    }

    fn of_crate(folder: &Path) -> Self {
        let mut texts = Vec::new();
        read(&folder.join("src"), &[], &mut texts);
        Self::new(texts)
    }

    /// The module that declares what a path names, as seen from a module; `None` for other crates.
    fn declaring(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let (mut at, rest) = self.start(from, path)?;
        for (index, name) in rest.iter().enumerate() {
            let child: Module = at.iter().chain([name]).cloned().collect();
            if self.0.contains_key(&child) {
                at = child;
                continue;
            }
            if declares(&self.0[&at].text, name) || depth == 0 {
                return Some(at);
            }
            let imports = self.0[&at].imports.iter().filter(|(n, _)| n == name || n == "*");
            let mut found = imports.filter_map(|(known, path)| {
                let tail = if known == "*" { &rest[index..] } else { &rest[index + 1..] };
                let target: Vec<_> = path.iter().chain(tail).cloned().collect();
                self.declaring(&at, &target, depth - 1)
            });
            return found.find(|module| declares(&self.0[module].text, name)).or(Some(at));
        }
        Some(at)
    }

    /// The module at which a path begins, and what is left of the path.
    fn start<'a>(&self, from: &Module, path: &'a [String]) -> Option<(Module, &'a [String])> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some((Module::new(), rest)),
            "self" => Some((from.clone(), rest)),
            "super" => {
                let up = path.iter().take_while(|name| *name == "super").count();
                let length = from.len().checked_sub(up)?;
                Some((from[..length].to_vec(), &path[up..]))
            }
            child => {
                let module: Module = from.iter().cloned().chain([child.to_owned()]).collect();
                self.0.contains_key(&module).then_some((module, rest))
            }
        }
    }

    /// Pairs of siblings, the first of which uses the second.
    fn uses(&self) -> BTreeSet<(Module, Module)> {
        let mut uses = BTreeSet::new();
        for (module, source) in &self.0 {
            let inline = inline_paths(&source.text);
            for path in source.imports.iter().map(|(_, path)| path).chain(&inline) {
                let Some(to) = self.declaring(module, path, 4) else { continue };
                let shared = module.iter().zip(&to).take_while(|(a, b)| a == b).count();
                if shared < module.len() && shared < to.len() {
                    uses.insert((module[..=shared].to_vec(), to[..=shared].to_vec()));
                }
            }
        }
        uses
    }

    /// The modules of each circle, as `a::b`.
    fn circles(&self) -> BTreeSet<Vec<String>> {
        let uses = self.uses();
        let reached = |from: &Module| {
            let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
            while let Some(next) = open.pop() {
                for (_, to) in uses.iter().filter(|(user, _)| user == next) {
                    if reached.insert(to) {
                        open.push(to);
                    }
                }
            }
            reached
        };
        let modules: BTreeSet<_> = uses.iter().map(|(user, _)| user).collect();
        let all: BTreeMap<_, _> = modules.iter().map(|module| (*module, reached(module))).collect();
        let circle = |module: &Module| {
            let others =
                all.iter().filter(|(to, from)| from.contains(module) && all[module].contains(**to));
            others.map(|(module, _)| module.join("::")).collect::<Vec<_>>()
        };
        modules.into_iter().map(circle).filter(|circle| !circle.is_empty()).collect()
    }
}

/// Reads the modules of a folder.
fn read(folder: &Path, module: &[String], texts: &mut Vec<(Module, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("a name").to_owned();
        if stem == "tests" {
            continue;
        }
        let mut own = module.to_vec();
        if path.is_dir() {
            own.push(stem);
            read(&path, &own, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            if !matches!(stem.as_str(), "lib" | "main" | "mod") {
                own.push(stem);
            }
            texts.push((own, std::fs::read_to_string(&path).expect("a source")));
        }
    }
}

/// Cuts comments, and the inline tests that end a file.
fn without_comments_and_tests(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns whether a text declares an item of a name.
fn declares(text: &str, name: &str) -> bool {
    let kinds =
        ["struct", "enum", "trait", "type", "fn", "const", "static", "macro_rules!", "union"];
    kinds.iter().any(|kind| {
        text.match_indices(&format!("{kind} {name}")).any(|(at, found)| {
            let next = text[at + found.len()..].chars().next();
            !next.is_some_and(|c| c.is_alphanumeric() || c == '_')
        })
    })
}

/// Returns what `use` imports: the local name and the path.
fn imports(text: &str) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    for statement in text.split(';') {
        let Some(at) = statement.rfind("use ") else { continue };
        let before = statement[..at].trim_end();
        let starts = before.is_empty()
            || before.ends_with(['}', ']', ')', '{', ';', '\n'])
            || before.ends_with("pub");
        if starts {
            leaves(&statement[at + 4..], &[], &mut found);
        }
    }
    found
}

/// The paths of a tree of a `use`.
fn leaves(tree: &str, base: &[String], found: &mut Vec<(String, Vec<String>)>) {
    let tree = tree.trim();
    let (head, group) = match tree.split_once('{') {
        Some((head, group)) => (head, group.rsplit_once('}').map(|(group, _)| group)),
        None => (tree, None),
    };
    let (head, renamed) = match head.split_once(" as ") {
        Some((head, name)) => (head, Some(name.trim().to_owned())),
        None => (head, None),
    };
    let mut path = base.to_vec();
    path.extend(head.split("::").map(str::trim).filter(|s| !s.is_empty()).map(str::to_owned));
    if let Some(group) = group {
        let (mut depth, mut from) = (0, 0);
        for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    leaves(&group[from..at], &path, found);
                    from = at + 1;
                }
                _ => {}
            }
        }
        return;
    }
    let Some(last) = path.pop() else { return };
    match last.as_str() {
        "self" if !path.is_empty() => {
            found.push((renamed.unwrap_or(path[path.len() - 1].clone()), path))
        }
        "*" => found.push((last, path)),
        _ => {
            path.push(last.clone());
            found.push((renamed.unwrap_or(last), path));
        }
    }
}

/// Paths outside of `use` that begin with `crate::` or `super::`.
fn inline_paths(text: &str) -> Vec<Vec<String>> {
    let starts = ["crate::", "super::"].into_iter().flat_map(|start| {
        text.match_indices(start)
            .map(|(at, _)| at)
            .filter(|&at| !text[..at].ends_with("::") && !text[..at].ends_with('$'))
    });
    let path = |at: usize| {
        let end = text[at..].find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
        let path = &text[at..end.map_or(text.len(), |end| at + end)];
        path.split("::").filter(|s| !s.is_empty()).map(str::to_owned).collect()
    };
    starts.map(path).collect()
}

fn artificial(files: &[(&str, &str)]) -> BTreeSet<Vec<String>> {
    let module =
        |path: &str| path.split("::").filter(|s| !s.is_empty()).map(str::to_owned).collect();
    Sources::new(files.iter().map(|(path, text)| (module(path), (*text).to_owned()))).circles()
}

#[test]
fn circle_through_re_exports_and_children_is_found() {
    let circle = artificial(&[
        ("", "mod a; mod b; pub use a::A; pub use b::inner::{B, C};"),
        ("a", "use crate::{B, other::Thing};\npub struct A(B);"),
        ("b", "mod inner;\npub use inner::B;"),
        ("b::inner", "pub struct B;\nfn f() { let _ = crate::A; }"),
    ]);
    assert_eq!(circle, BTreeSet::from([vec!["a".to_owned(), "b".to_owned()]]));
}

#[test]
fn parent_and_children_may_use_each_other() {
    let none = artificial(&[
        ("", "mod a; mod b;"),
        ("a", "mod child;\npub use child::Child;\npub struct A;\nuse crate::b::B;"),
        ("a::child", "use super::A;\npub struct Child(A); // crate::b uses crate::a\n"),
        ("b", "pub struct B;\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}"),
    ]);
    assert_eq!(none, BTreeSet::new());
}

#[test]
fn modules_of_a_crate_form_no_circles() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("crates");
    let mut found = BTreeSet::new();
    for folder in std::fs::read_dir(crates).expect("crates") {
        let folder = folder.expect("a crate").path();
        let name = folder.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let circles = Sources::of_crate(&folder).circles();
        found.extend(circles.into_iter().map(|circle| (name.clone(), circle)));
    }
    let known = |(name, circle): &(&str, &[&str])| {
        ((*name).to_owned(), circle.iter().map(|&module| module.to_owned()).collect::<Vec<_>>())
    };
    let known: BTreeSet<_> = KNOWN.iter().map(known).collect();
    let new: Vec<_> = found.difference(&known).collect();
    let gone: Vec<_> = known.difference(&found).collect();
    assert!(new.is_empty(), "modules use each other in circles: {new:#?}");
    assert!(gone.is_empty(), "these circles are gone: strike them from KNOWN: {gone:#?}");
}
