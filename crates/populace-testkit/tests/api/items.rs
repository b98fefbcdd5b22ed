//! Names, visibility and attributes of items.

use syn::{Attribute, Ident, Item, UseTree, Visibility};

/// Returns the name and the path of each item of a `use`; the name of `*` is `None`.
pub(crate) fn leaves(tree: &UseTree) -> Vec<(Option<String>, Vec<String>)> {
    let named = |own: &Ident, from: &Ident| vec![(Some(own.to_string()), vec![from.to_string()])];
    match tree {
        UseTree::Name(name) => named(&name.ident, &name.ident),
        UseTree::Rename(name) => named(&name.rename, &name.ident),
        UseTree::Glob(_) => vec![(None, Vec::new())],
        UseTree::Group(group) => group.items.iter().flat_map(leaves).collect(),
        UseTree::Path(path) => {
            let below = |(own, from): (Option<String>, Vec<String>)| {
                let first = path.ident.to_string();
                if from == ["self"] {
                    (Some(first.clone()), vec![first])
                } else {
                    (own, std::iter::once(first).chain(from).collect())
                }
            };
            leaves(&path.tree).into_iter().map(below).collect()
        }
    }
}

pub(crate) fn names(path: &syn::Path) -> Vec<String> {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect()
}

pub(crate) fn name_of(path: &syn::Path) -> &Ident {
    &path.segments.last().expect("paths have names").ident
}

pub(crate) fn is_public(visibility: &Visibility) -> bool {
    matches!(visibility, Visibility::Public(_))
}

/// Returns whether attributes hide an item from users: `doc(hidden)`, `cfg(test)`, `cfg(doctest)`.
pub(crate) fn is_left_out(attributes: &[Attribute]) -> bool {
    attributes.iter().filter_map(|attribute| attribute.meta.require_list().ok()).any(|list| {
        let inner = list.tokens.to_string();
        list.path.is_ident("doc") && inner == "hidden"
            || list.path.is_ident("cfg") && (inner == "test" || inner == "doctest")
    })
}

pub(crate) fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(of) => &of.attrs,
        Item::Enum(of) => &of.attrs,
        Item::Fn(of) => &of.attrs,
        Item::Impl(of) => &of.attrs,
        Item::Macro(of) => &of.attrs,
        Item::Mod(of) => &of.attrs,
        Item::Static(of) => &of.attrs,
        Item::Struct(of) => &of.attrs,
        Item::Trait(of) => &of.attrs,
        Item::Type(of) => &of.attrs,
        Item::Use(of) => &of.attrs,
        _ => &[],
    }
}

/// Returns the name and the visibility of an item that has both.
pub(crate) fn named(item: &Item) -> Option<(&Ident, &Visibility)> {
    Some(match item {
        Item::Const(of) => (&of.ident, &of.vis),
        Item::Enum(of) => (&of.ident, &of.vis),
        Item::Fn(of) => (&of.sig.ident, &of.vis),
        Item::Mod(of) => (&of.ident, &of.vis),
        Item::Static(of) => (&of.ident, &of.vis),
        Item::Struct(of) => (&of.ident, &of.vis),
        Item::Trait(of) => (&of.ident, &of.vis),
        Item::Type(of) => (&of.ident, &of.vis),
        _ => return None,
    })
}
