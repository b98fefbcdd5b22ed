//! Messages for unknown names, with suggestions.

use populace::model::{JointIndex, Skeleton, did_you_mean};
use populace::nearest_names;

use crate::failure::Failure;

/// Names listed if no name is similar to the one typed.
const MAX_LISTED: usize = 8;

/// Returns the end of a message that refuses `name`: the most similar of `names`, or the first of
/// them if none is similar.
pub(crate) fn hint<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let mut known = Vec::new();
    for name in names {
        if !known.contains(&name) {
            known.push(name);
        }
    }
    let nearest = nearest_names(name, known.iter().copied());
    if !nearest.is_empty() || known.is_empty() {
        return did_you_mean(&nearest);
    }
    let quoted: Vec<_> = known.iter().take(MAX_LISTED).map(|name| format!("\"{name}\"")).collect();
    let more = known.len().saturating_sub(MAX_LISTED);
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("; known are {}{more}", quoted.join(", "))
}

/// Finds a joint by its name.
pub(crate) fn joint(skeleton: &Skeleton, name: &str) -> Result<JointIndex, Failure> {
    skeleton.find(name).ok_or_else(|| {
        let hint = hint(name, skeleton.joints().map(|joint| skeleton.name(joint)));
        Failure::usage(format!("there is no joint \"{name}\"{hint}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn similar_names_are_suggested_once_or_else_all_are_listed() {
        assert_eq!(hint("mehs", ["mesh", "mesh", "rock"]), "; did you mean \"mesh\"?");
        assert_eq!(hint("zz", ["mesh", "rock", "mesh"]), "; known are \"mesh\", \"rock\"");
        let many: Vec<_> = (10..20).map(|n| n.to_string()).collect();
        assert!(hint("zz", many.iter().map(String::as_str)).ends_with("\"17\" and 2 more"));
        assert_eq!(hint("zz", []), "");
    }
}
