//! Parts of a character that a member shows or not, such as one of several hats.

use crate::Part;

/// Most options of a character. The parts of further ones are always shown.
pub const MAX_OPTIONS: usize = 32;

/// Parts that a member can show or not. Nodes named `Option:<group>:<name>` have them; all parts of
/// nodes with the same name are one option.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PartOption {
    /// What the option is one of, such as `hair`. Members usually show one option of a group.
    pub group: String,
    /// The option's name within its group.
    pub name: String,
}

impl PartOption {
    /// Returns the option that a node's name tells; `None` for other names.
    #[must_use]
    pub fn of_node(node_name: &str) -> Option<Self> {
        let (group, name) = node_name.strip_prefix("Option:")?.split_once(':')?;
        Some(Self { group: group.to_owned(), name: name.to_owned() })
    }
}

/// Returns the first [`MAX_OPTIONS`] options, in order of appearance.
pub(crate) fn find_options(parts: &[Part]) -> Vec<PartOption> {
    let mut options: Vec<PartOption> = Vec::new();
    for option in parts.iter().filter_map(|part| PartOption::of_node(&part.node_name)) {
        if options.len() < MAX_OPTIONS && !options.contains(&option) {
            options.push(option);
        }
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Influences, Mesh};

    fn part(node_name: &str) -> Part {
        let influences = Influences { per_vertex: 4, entries: Vec::new(), weights: Vec::new() };
        let (positions, normals, uvs) = (Vec::new(), Vec::new(), Vec::new());
        let (colors, indices) = (Vec::new(), Vec::new());
        let mesh = Mesh { positions, normals, uvs, colors, influences, indices };
        Part { node: 0, node_name: node_name.into(), primitive: 0, material: None, mesh }
    }

    #[test]
    fn options_are_numbered_by_appearance() {
        let names = ["body", "Option:hair:bun", "Option:hat:cap", "Option:hair:bun", "Option:hair"];
        let options = find_options(&names.map(part));
        let option =
            |group: &str, name: &str| PartOption { group: group.into(), name: name.into() };
        assert_eq!(options, [option("hair", "bun"), option("hat", "cap")]);
    }

    #[test]
    fn options_past_the_last_bit_are_always_shown() {
        let parts: Vec<Part> = (0..40).map(|i| part(&format!("Option:hat:{i}"))).collect();
        assert_eq!(find_options(&parts).len(), MAX_OPTIONS);
    }
}
