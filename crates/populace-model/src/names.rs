//! Suggestions for names that do not exist.

use std::collections::HashSet;
use std::fmt;

/// Letters of a word, at least.
const WORD: usize = 3;

/// Returns up to three of `names` that are most similar to `name`, nearest first. Names without
/// similarity are left out.
#[must_use]
pub fn nearest_names<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let wanted = name.to_lowercase();
    let likeness = |candidate: &str| {
        let candidate = candidate.to_lowercase();
        let has_word = wanted.chars().count() >= WORD && candidate.contains(&wanted);
        let is_part =
            !wanted.is_empty() && (candidate.contains(&wanted) || wanted.contains(&candidate));
        // A longer name is like the word that it contains, wherever that stands.
        let inside = if has_word { 0.65 } else { 0.5 * f64::from(u8::from(is_part)) };
        strsim::jaro_winkler(&wanted, &candidate) + inside
    };
    let mut seen = HashSet::new();
    let different = names.into_iter().filter(|name| seen.insert(*name));
    let mut scored: Vec<_> =
        different.map(|n| (likeness(n), n)).filter(|(score, _)| *score > 0.6).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(3).map(|(_, n)| n.to_owned()).collect()
}

/// Returns the end of an error message, `; did you mean "this" or "that"?`, or an empty string.
#[must_use]
pub fn did_you_mean(nearest: &[String]) -> String {
    let quoted: Vec<_> = nearest.iter().map(|name| format!("\"{name}\"")).collect();
    match quoted.as_slice() {
        [] => String::new(),
        [one] => format!("; did you mean {one}?"),
        [most @ .., last] => format!("; did you mean {} or {last}?", most.join(", ")),
    }
}

/// A name that does not exist, with similar names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The name that was asked for.
    pub name: String,
    /// Similar names, nearest first.
    pub nearest: Vec<String>,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no joint \"{}\"{}", self.name, did_you_mean(&self.nearest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_contain_the_word_are_near() {
        let names = ["Robot_Walking", "Robot_Dance", "Robot_Idle"];
        assert_eq!(nearest_names("Dance", names), ["Robot_Dance"]);
        assert_eq!(nearest_names("dance", names), ["Robot_Dance"]);
        assert_eq!(nearest_names("Swim", names), [""; 0]);
    }
}
