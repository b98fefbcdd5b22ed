//! The modules of a library, and the way from its root to each public item.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use syn::{Item, ItemImpl, ItemUse};

use crate::items::{attributes, is_left_out, is_public, leaves, name_of, named, names};
use crate::lines::{impl_lines, item_lines, macro_lines};

/// The path of a module from its crate's root.
type ModulePath = Vec<String>;

/// The `impl` blocks of each type, by its module and index.
type Impls = BTreeMap<(ModulePath, usize), Vec<ItemImpl>>;

/// The target of a path.
enum Target {
    Module(ModulePath),
    /// A module, and the index of one of its items.
    Item(ModulePath, usize),
    /// Something of another crate, by its path.
    Foreign(String),
}

/// The items of all modules of a crate.
pub(crate) struct Library {
    root: String,
    modules: BTreeMap<ModulePath, Vec<Item>>,
    /// The first public path of each item that is listed.
    listed: BTreeMap<(ModulePath, usize), String>,
    lines: BTreeSet<String>,
}

/// Gives up on paths that lead round in a circle.
const MOST_STEPS: usize = 16;

impl Library {
    pub(crate) fn read(name: &str, folder: &Path) -> Self {
        let root = name.replace('-', "_");
        let (modules, listed, lines) = Default::default();
        let mut library = Self { root, modules, listed, lines };
        library.read_file(Vec::new(), &folder.join("src/lib.rs"), &folder.join("src"));
        library
    }

    /// Reads a module's file; `folder` holds the files of its own modules.
    fn read_file(&mut self, path: ModulePath, file: &Path, folder: &Path) {
        let text = std::fs::read_to_string(file);
        let text = text.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed = syn::parse_file(&text);
        let items = parsed.unwrap_or_else(|error| panic!("{}: {error}", file.display())).items;
        self.add_module(path, items, folder);
    }

    fn add_module(&mut self, path: ModulePath, items: Vec<Item>, folder: &Path) {
        let mut own = Vec::new();
        for item in items.into_iter().filter(|item| !is_left_out(attributes(item))) {
            match item {
                Item::Macro(call) => match syn::parse2::<syn::File>(call.mac.tokens.clone()) {
                    Ok(file) if call.ident.is_none() => own.extend(file.items),
                    _ => own.push(Item::Macro(call)),
                },
                other => own.push(other),
            }
        }
        for item in &mut own {
            let Item::Mod(module) = item else { continue };
            let name = module.ident.to_string();
            let inner: ModulePath = path.iter().chain([&name]).cloned().collect();
            let below = folder.join(&name);
            match module.content.take() {
                Some((_, items)) => self.add_module(inner, items, &below),
                None => {
                    let file = [below.with_extension("rs"), below.join("mod.rs")];
                    let file = file.iter().find(|file| file.exists()).expect("a module's file");
                    self.read_file(inner, file, &below);
                }
            }
        }
        self.modules.insert(path, own);
    }

    /// Returns one line for each item that users can reach.
    pub(crate) fn public_lines(mut self) -> BTreeSet<String> {
        let impls = self.impls();
        self.expose(&Vec::new(), &self.root.clone(), &impls);
        let macros = self.modules.values().flatten().filter_map(|item| match item {
            Item::Macro(of) => Some(macro_lines(&self.root, of)),
            _ => None,
        });
        let (lines, calls): (Vec<_>, Vec<_>) =
            macros.flatten().partition(|line| !line.contains("!: called with "));
        // Calls count only of macros that declare something public.
        let declares = |call: &String| {
            let name = call.split("!: ").next().unwrap_or_default();
            lines.iter().any(|line| line.starts_with(&format!("{name}!: declares")))
        };
        let calls: Vec<_> = calls.into_iter().filter(declares).collect();
        self.lines.extend(lines.into_iter().chain(calls));
        self.lines
    }

    /// Returns the `impl` blocks of each type, by its module and index.
    fn impls(&self) -> Impls {
        let mut all = BTreeMap::<_, Vec<_>>::new();
        for (path, items) in &self.modules {
            for item in items {
                let Item::Impl(block) = item else { continue };
                let syn::Type::Path(of) = &*block.self_ty else { continue };
                if let Target::Item(module, index) = self.resolve(path, &names(&of.path), 0) {
                    all.entry((module, index)).or_default().push(block.clone());
                }
            }
        }
        all.into_iter().map(|(of, blocks)| (of, self.without_private_traits(blocks))).collect()
    }

    fn without_private_traits(&self, mut blocks: Vec<ItemImpl>) -> Vec<ItemImpl> {
        blocks.retain(|block| {
            let Some((_, of, _)) = &block.trait_ else { return true };
            let own = |item: &Item| matches!(item, Item::Trait(own) if own.ident == *name_of(of));
            let mut own = self.modules.values().flatten().filter(|item| own(item)).peekable();
            own.peek().is_none()
                || own.any(|item| named(item).is_some_and(|(_, visible)| is_public(visible)))
        });
        blocks
    }

    /// Lists the public items of a module, which users reach by the path `shown`.
    fn expose(&mut self, path: &ModulePath, shown: &str, impls: &Impls) {
        for index in 0..self.modules[path].len() {
            let item = self.modules[path][index].clone();
            match &item {
                Item::Use(uses) if is_public(&uses.vis) => {
                    self.expose_use(path, shown, uses, impls);
                }
                item if !named(item).is_some_and(|(_, visible)| is_public(visible)) => {}
                Item::Mod(module) => {
                    let name = module.ident.to_string();
                    let inner = path.iter().chain([&name]).cloned().collect();
                    self.expose(&inner, &format!("{shown}::{name}"), impls);
                }
                _ => self.list(path, index, shown, None, impls),
            }
        }
    }

    fn expose_use(&mut self, path: &ModulePath, shown: &str, uses: &ItemUse, impls: &Impls) {
        for (name, from) in leaves(&uses.tree) {
            let alias = name.clone().map_or(shown.to_owned(), |name| format!("{shown}::{name}"));
            match self.resolve(path, &from, 0) {
                Target::Module(inner) => self.expose(&inner, &alias, impls),
                Target::Item(module, index) => {
                    self.list(&module, index, shown, name.as_deref(), impls);
                }
                Target::Foreign(from) if name.is_some() => {
                    self.lines.insert(format!("{alias}: pub use {from}"));
                }
                Target::Foreign(from) => {
                    self.lines.insert(format!("{alias}: pub use {from}::*"));
                }
            }
        }
    }

    /// Lists an item of a module, its parts, and what is implemented for it.
    fn list(
        &mut self,
        path: &ModulePath,
        index: usize,
        shown: &str,
        alias: Option<&str>,
        impls: &Impls,
    ) {
        let item = &self.modules[path][index];
        let Some((own, _)) = named(item) else { return };
        let name = format!("{shown}::{}", alias.map_or(own.to_string(), str::to_owned));
        if let Some(first) = self.listed.get(&(path.clone(), index)) {
            self.lines.insert(format!("{name}: pub use {first}"));
            return;
        }
        let mut lines = item_lines(&name, item);
        for block in impls.get(&(path.clone(), index)).into_iter().flatten() {
            lines.extend(impl_lines(&name, block));
        }
        self.lines.extend(lines);
        self.listed.insert((path.clone(), index), name);
    }

    /// Follows a path that is written in the module `from`.
    fn resolve(&self, from: &ModulePath, path: &[String], steps: usize) -> Target {
        let foreign = || Target::Foreign(path.join("::"));
        let (first, mut rest) = path.split_first().expect("paths have names");
        let mut at = match first.as_str() {
            "crate" => Target::Module(Vec::new()),
            "self" => Target::Module(from.clone()),
            "super" => Target::Module(from[..from.len() - 1].to_vec()),
            name => self.find(from, name, steps).unwrap_or_else(foreign),
        };
        while let (Target::Module(module), Some((name, more))) = (&at, rest.split_first()) {
            at = match name.as_str() {
                "super" => Target::Module(module[..module.len() - 1].to_vec()),
                name => self.find(module, name, steps).unwrap_or_else(foreign),
            };
            rest = more;
        }
        match at {
            Target::Foreign(start) if !rest.is_empty() && start != path.join("::") => {
                Target::Foreign(format!("{start}::{}", rest.join("::")))
            }
            at => at,
        }
    }

    /// Finds a name in a module: an item, or what a `use` brings.
    fn find(&self, module: &ModulePath, name: &str, steps: usize) -> Option<Target> {
        let items = self.modules.get(module)?;
        let own = |item: &Item| named(item).is_some_and(|(own, _)| own == name);
        match items.iter().position(own) {
            Some(at) if matches!(items[at], Item::Mod(_)) => {
                return Some(Target::Module(module.iter().cloned().chain([name.into()]).collect()));
            }
            Some(at) => return Some(Target::Item(module.clone(), at)),
            None if steps == MOST_STEPS => return None,
            None => {}
        }
        let uses = items.iter().filter_map(|item| match item {
            Item::Use(uses) => Some(leaves(&uses.tree)),
            _ => None,
        });
        let (named, globs): (Vec<_>, Vec<_>) = uses.flatten().partition(|(own, _)| own.is_some());
        if let Some((_, from)) = named.into_iter().find(|(own, _)| own.as_deref() == Some(name)) {
            return Some(self.resolve(module, &from, steps + 1));
        }
        globs.into_iter().find_map(|(_, from)| match self.resolve(module, &from, steps + 1) {
            Target::Module(inner) => self.find(&inner, name, steps + 1),
            _ => None,
        })
    }
}
