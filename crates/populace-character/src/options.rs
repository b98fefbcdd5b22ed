//! Parts of a character that a member shows or not, such as one of several hats.

/// Most options of a character. The parts of further ones are always shown.
pub const MAX_OPTIONS: usize = 32;

/// Parts that a member can show or not. Nodes named `Option:<group>:<name>` have them; all parts of
/// nodes with the same name are one option.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PartOption {
    /// The kind of thing, such as `hair`. Members usually show one option of a group.
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

/// Returns the first [`MAX_OPTIONS`] options that nodes' names tell, in order of appearance.
pub(crate) fn find_options<'a>(node_names: impl Iterator<Item = &'a str>) -> Vec<PartOption> {
    let mut options: Vec<PartOption> = Vec::new();
    for option in node_names.filter_map(PartOption::of_node) {
        if options.len() < MAX_OPTIONS && !options.contains(&option) {
            options.push(option);
        }
    }
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_numbered_by_appearance() {
        let names = ["body", "Option:hair:bun", "Option:hat:cap", "Option:hair:bun", "Option:hair"];
        let options = find_options(names.into_iter());
        let option =
            |group: &str, name: &str| PartOption { group: group.into(), name: name.into() };
        assert_eq!(options, [option("hair", "bun"), option("hat", "cap")]);
    }

    #[test]
    fn options_past_the_last_bit_are_always_shown() {
        let names: Vec<String> = (0..40).map(|i| format!("Option:hat:{i}")).collect();
        assert_eq!(find_options(names.iter().map(String::as_str)).len(), MAX_OPTIONS);
    }
}
