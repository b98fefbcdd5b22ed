//! Names that were asked for and are not there, and those that may have been meant.

use std::collections::HashSet;
use std::fmt;

/// The three names most like the one given, nearest first; those with nothing in common are left
/// out.
#[must_use]
pub fn nearest_names<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let wanted = name.to_lowercase();
    let likeness = |candidate: &str| {
        let candidate = candidate.to_lowercase();
        let inside =
            !wanted.is_empty() && (candidate.contains(&wanted) || wanted.contains(&candidate));
        strsim::jaro_winkler(&wanted, &candidate) + if inside { 0.5 } else { 0.0 }
    };
    let mut seen = HashSet::new();
    let different = names.into_iter().filter(|name| seen.insert(*name));
    let mut scored: Vec<_> =
        different.map(|n| (likeness(n), n)).filter(|(score, _)| *score > 0.6).collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.into_iter().take(3).map(|(_, n)| n.to_owned()).collect()
}

/// The end of a message that refuses a name: `; did you mean "this" or "that"?`, or nothing.
#[must_use]
pub fn did_you_mean(nearest: &[String]) -> String {
    let quoted: Vec<_> = nearest.iter().map(|name| format!("\"{name}\"")).collect();
    match quoted.as_slice() {
        [] => String::new(),
        [one] => format!("; did you mean {one}?"),
        [most @ .., last] => format!("; did you mean {} or {last}?", most.join(", ")),
    }
}

/// A name that does not exist, and those most like it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The name asked for.
    pub name: String,
    /// Names like it, nearest first.
    pub nearest: Vec<String>,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no joint \"{}\"{}", self.name, did_you_mean(&self.nearest))
    }
}
