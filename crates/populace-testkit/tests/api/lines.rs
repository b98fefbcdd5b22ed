//! The lines of items.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::{Attribute, Fields, ImplItem, Item, ItemImpl, ItemMacro, TraitItem};

use crate::items::{attributes, is_left_out, is_public, name_of};

/// Returns the lines of an item itself.
pub(crate) fn item_lines(name: &str, item: &Item) -> Vec<String> {
    let line = |path: &str, text: String| format!("{path}: {text}");
    let mut lines: Vec<_> = derived(name, attributes(item)).into_iter().collect();
    match item.clone() {
        Item::Fn(of) => {
            let (visible, signature) = (of.vis, of.sig);
            lines.push(line(name, text(&quote!(#visible #signature {}))));
        }
        Item::Struct(mut of) => {
            for (index, field) in of.fields.iter().enumerate() {
                let own = field.ident.as_ref().map_or(index.to_string(), ToString::to_string);
                if is_public(&field.vis) {
                    let ty = &field.ty;
                    let ty = text(&quote!(type Of = #ty;));
                    let ty = ty.trim_start_matches("type Of = ");
                    lines.push(line(&format!("{name}::{own}"), format!("pub {own}: {ty}")));
                }
            }
            of.attrs.retain(is_shown);
            of.fields = Fields::Unit;
            of.semi_token = Some(Default::default());
            lines.push(line(name, text(&of)));
        }
        Item::Enum(mut of) => {
            for variant in std::mem::take(&mut of.variants) {
                let mut variant = variant;
                variant.attrs.clear();
                variant.fields.iter_mut().for_each(|field| field.attrs.clear());
                let own = variant.ident.to_string();
                lines.push(line(&format!("{name}::{own}"), inner(&quote!(enum Of { #variant }))));
            }
            of.attrs.retain(is_shown);
            lines.push(line(name, text(&of)));
        }
        Item::Trait(mut of) => {
            for item in std::mem::take(&mut of.items) {
                lines.extend(trait_line(name, item));
            }
            of.attrs.clear();
            lines.push(line(name, text(&of)));
        }
        Item::Const(mut of) => {
            of.attrs.clear();
            lines.push(line(name, text(&of)));
        }
        Item::Type(mut of) => {
            of.attrs.clear();
            lines.push(line(name, text(&of)));
        }
        other => panic!("{name}: {} is not supported", other.to_token_stream()),
    }
    lines
}

fn trait_line(name: &str, item: TraitItem) -> Option<String> {
    let (own, item) = match item {
        TraitItem::Fn(mut of) if !is_left_out(&of.attrs) => {
            of.attrs.clear();
            let provided = of.default.take().is_some();
            of.semi_token = Some(Default::default());
            let own = of.sig.ident.to_string();
            let provided = if provided { "provided " } else { "" };
            return Some(format!("{name}::{own}: {provided}{}", inner(&quote!(trait T { #of }))));
        }
        TraitItem::Const(mut of) if !is_left_out(&of.attrs) => {
            of.attrs.clear();
            (of.ident.to_string(), TraitItem::Const(of))
        }
        TraitItem::Type(mut of) if !is_left_out(&of.attrs) => {
            of.attrs.clear();
            (of.ident.to_string(), TraitItem::Type(of))
        }
        _ => return None,
    };
    Some(format!("{name}::{own}: {}", inner(&quote!(trait T { #item }))))
}

/// Returns the lines of an `impl` block: the trait, or the public functions and constants.
pub(crate) fn impl_lines(name: &str, block: &ItemImpl) -> Vec<String> {
    if block.trait_.is_some() {
        let mut block = block.clone();
        block.attrs.clear();
        block.items.clear();
        return vec![format!("{name}: {}", text(&block))];
    }
    let public = block.items.iter().filter_map(|item| match item {
        ImplItem::Fn(of) if is_public(&of.vis) && !is_left_out(&of.attrs) => {
            let (visible, signature) = (&of.vis, &of.sig);
            let text = inner(&quote!(impl T { #visible #signature {} }));
            Some(format!("{name}::{}: {text}", of.sig.ident))
        }
        ImplItem::Const(of) if is_public(&of.vis) && !is_left_out(&of.attrs) => {
            let mut of = of.clone();
            of.attrs.clear();
            Some(format!("{name}::{}: {}", of.ident, inner(&quote!(impl T { #of }))))
        }
        _ => None,
    });
    public.collect()
}

/// Returns a line with the traits that are derived.
fn derived(name: &str, attributes: &[Attribute]) -> Option<String> {
    let mut traits = Vec::new();
    for attribute in attributes.iter().filter(|a| a.path().is_ident("derive")) {
        let parsed = attribute.parse_nested_meta(|of| {
            traits.push(name_of(&of.path).to_string());
            Ok(())
        });
        parsed.expect("a list of traits");
    }
    (!traits.is_empty()).then(|| format!("{name}: derive({})", traits.join(", ")))
}

/// Returns the public functions that a macro declares, or the call of a macro of this crate.
pub(crate) fn macro_lines(root: &str, of: &ItemMacro) -> Vec<String> {
    let Some(name) = &of.ident else {
        let call = of.mac.tokens.to_string().replace(" : ", ": ");
        return vec![format!("{root}::{}!: called with {call}", name_of(&of.mac.path))];
    };
    let exported = of.attrs.iter().any(|a| a.path().is_ident("macro_export"));
    let mut lines: Vec<_> =
        exported.then(|| format!("{root}::{name}!: macro")).into_iter().collect();
    let mut found = Vec::new();
    public_functions(of.mac.tokens.clone(), &mut found);
    lines.extend(found.into_iter().map(|text| format!("{root}::{name}!: declares {text}")));
    lines
}

/// Collects the heads of public functions, which start with `pub` and end before the body.
fn public_functions(tokens: TokenStream, found: &mut Vec<String>) {
    let mut head: Option<TokenStream> = None;
    for token in tokens {
        match (&token, &mut head) {
            (TokenTree::Ident(word), None) if word == "pub" => head = Some(token.into()),
            (TokenTree::Group(body), Some(_)) if body.delimiter() == Delimiter::Brace => {
                let head = head.take().unwrap_or_default();
                let of = syn::parse2::<syn::ItemFn>(quote!(#head {}));
                found.extend(of.iter().filter(|of| is_public(&of.vis)).map(text));
            }
            (TokenTree::Group(inner), None) => public_functions(inner.stream(), found),
            (_, Some(head)) => head.extend([token]),
            _ => {}
        }
    }
}

/// Writes an item on one line, without its empty body.
fn text(item: &impl ToTokens) -> String {
    let file = syn::parse2(item.to_token_stream()).expect("items parse");
    let text = prettyplease::unparse(&file);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = text.replace("( ", "(").replace(", )", ")").replace(" )", ")").replace(", }", " }");
    text.trim_end_matches(" {}").trim_end_matches(';').to_owned()
}

/// Writes the one item within braces on one line.
fn inner(item: &impl ToTokens) -> String {
    let whole = text(item);
    let (_, text) = whole.split_once('{').expect("braces");
    let text = text.trim().strip_suffix('}').expect("braces").trim_end();
    text.trim_end_matches(" {}").trim_end_matches([',', ';']).to_owned()
}

fn is_shown(attribute: &Attribute) -> bool {
    attribute.path().is_ident("non_exhaustive")
}
