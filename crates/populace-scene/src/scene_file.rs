//! Scene files: plans of scenes as TOML.

mod doubts;
mod fault;
mod limits;
mod people;
mod place;
mod props;
mod view;

use std::ops::Range;

use populace::model::{did_you_mean, nearest_names};

use crate::plan::{SCHEMA, ScenePlan};
use fault::Fault;

/// The reason why a scene file was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct SceneFileError {
    /// The line, from 1 on.
    pub line: usize,
    /// The key and the reason.
    pub message: String,
}

impl SceneFileError {
    /// Names the line of `file` of the prop `nth` of a file's text, from 0 on.
    #[must_use]
    pub fn of_prop_file(text: &str, nth: usize, reason: &str) -> Self {
        Fault::of("file", "").nth("prop", nth).because(text, reason)
    }

    /// Names the line of `clip` of the crowd `nth` of a file's text, from 0 on: that of its layer
    /// with a number from 0 on, or that of `does.stand`.
    #[must_use]
    pub fn of_clip(text: &str, (nth, layer): (usize, Option<usize>), reason: &str) -> Self {
        let clip = Fault::of("clip", "");
        let clip = match layer {
            Some(layer) => clip.nth("layers", layer),
            None => clip.within("does.stand"),
        };
        clip.nth("crowd", nth).because(text, reason)
    }
}

impl ScenePlan {
    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// Text that is no TOML, unknown and missing keys, numbers out of range, and names that nothing
    /// in the file has. The message names the key and, for a misspelt one, the nearest.
    pub fn parse(text: &str) -> Result<Self, SceneFileError> {
        let plan: Self = toml::from_str(text).map_err(|error| refused(text, &error))?;
        match plan.check() {
            Some(fault) => Err(fault.at_its_line(text)),
            None => Ok(plan),
        }
    }

    /// Returns the text of a scene file.
    ///
    /// # Errors
    ///
    /// [`parse`](Self::parse)'s error for a plan that it would refuse.
    pub fn to_toml(&self) -> Result<String, SceneFileError> {
        let unwritten = |message| SceneFileError { line: 1, message };
        if let Some(fault) = self.check() {
            return Err(unwritten(fault.message()));
        }
        toml::to_string(self).map_err(|error| unwritten(error.to_string()))
    }

    /// Finds the first value that is out of range, or that names what is not there.
    fn check(&self) -> Option<Fault> {
        if self.schema != SCHEMA {
            let rule = format!("{SCHEMA}; this program reads no other version");
            return Some(Fault::of("schema", rule));
        }
        self.check_names()
            .or_else(|| people::check(self))
            .or_else(|| place::check(self))
            .or_else(|| view::check(self))
    }

    fn check_names(&self) -> Option<Fault> {
        let of = |table: &'static str, names: Vec<&str>| -> Option<Fault> {
            let twice = names.iter().enumerate().find(|(nth, name)| names[..*nth].contains(name));
            let (nth, name) = twice?;
            let rule = format!("unique, and another is \"{name}\"");
            Some(Fault::of("name", rule).nth(table, nth))
        };
        of("cast", self.casts.iter().map(|cast| cast.name.as_str()).collect())
            .or_else(|| of("footway", self.footways.iter().map(|of| of.name.as_str()).collect()))
            .or_else(|| of("lane", self.lanes.iter().map(|lane| lane.name.as_str()).collect()))
            .or_else(|| of("camera", self.cameras.iter().map(|of| of.name.as_str()).collect()))
    }
}

fn line(text: &str, span: Range<usize>) -> usize {
    text.get(..span.start).unwrap_or(text).matches('\n').count() + 1
}

/// Says what a reader of TOML refused, with the nearest key for one that is unknown.
fn refused(text: &str, error: &toml::de::Error) -> SceneFileError {
    let mut message = error.message().to_owned();
    let span = error.span().unwrap_or_default();
    // A value stands in quotes; a key need not, and is followed by its value.
    let is_value = text.get(span.clone()).is_some_and(|it| it.starts_with(['"', '\'']));
    let what = if is_value { "value" } else { "key" };
    for unknown in ["unknown field `", "unknown variant `"] {
        let Some(rest) = message.strip_prefix(unknown) else { continue };
        let mut quoted = rest.split('`');
        let name = quoted.next().unwrap_or_default().to_owned();
        // Every second part after the name is quoted.
        let known = quoted.skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
        let nearest = nearest_names(&name, known.iter().map(String::as_str));
        message = format!("there is no {what} `{name}` here{}", did_you_mean(&nearest));
        if nearest.is_empty() {
            message = format!("{message}; there are {}", known.join(", "));
        }
        break;
    }
    if let Some(rule) = of_another_type(&message)
        && let Some(key) = fault::key_at(text, span.start)
    {
        message = format!("`{key}` must be {rule}{}", in_double_brackets(&key));
        if let (Some((whole, seen)), true) = (rule.split_once(" from 0 on"), is_from_1(&key)) {
            message = format!("`{key}` must be {whole} from 1 on{seen}");
        }
    }
    if message == "duplicate key" {
        let key = text.get(span.clone()).unwrap_or_default().trim_matches(['[', ']', ' ']);
        message = format!("`{key}` is written a second time here{}", in_double_brackets(key));
    }
    SceneFileError { line: line(text, span), message }
}

/// Tables of which a scene has any number.
const LISTS: [&str; 12] = [
    "cast", "crowd", "footway", "spot", "lean", "seat", "crossing", "lane", "bay", "wall", "prop",
    "camera",
];

/// Says how a table of a list is written; nothing for other keys.
fn in_double_brackets(key: &str) -> String {
    let is_list = LISTS.contains(&key);
    if is_list { format!("; each is written as `[[{key}]]`") } else { String::new() }
}

/// Returns true for numbers of members, of which there is at least one.
fn is_from_1(key: &str) -> bool {
    ["count", "row", "rank"].contains(&key)
}

/// Returns the rule that a value of another type or length breaks, from a message of the reader,
/// which has Rust's names of types.
fn of_another_type(message: &str) -> Option<String> {
    let kinds = ["invalid type: ", "invalid value: ", "invalid length "];
    let rest = kinds.iter().find_map(|kind| message.strip_prefix(kind))?;
    let (seen, expected) = rest.split_once(", expected ")?;
    let seen = match seen.split_once(' ') {
        None if seen == "sequence" => "a list".to_owned(),
        None if seen == "map" => "a table".to_owned(),
        None => format!("of {seen}"),
        Some(("string", value)) => format!("the text {value}"),
        // Numbers stand in quotes: integer `3`, floating point `2.5`.
        Some((_, value)) => value.trim_start_matches("point ").trim_matches('`').to_owned(),
    };
    let expected = match expected {
        "f32" | "f64" => "a number".to_owned(),
        "usize" | "u32" | "u64" => "a whole number from 0 on".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        _ if expected.starts_with("struct ") => "a table".to_owned(),
        _ => expected.to_owned(),
    };
    Some(format!("{expected}, not {seen}"))
}
