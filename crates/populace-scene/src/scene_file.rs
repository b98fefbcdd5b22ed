//! Scene files: plans of scenes as TOML.

use std::ops::Range;

use populace::model::{did_you_mean, nearest_names};
use toml::de::{DeTable, DeValue};

use crate::PROP_KINDS;
use crate::plan::{BehaviourPlan, PropPlan, SCHEMA, ScenePlan};

/// The largest coordinate in metres, and the most members of a crowd.
const LARGEST: f32 = 1e6;
const MOST_MEMBERS: usize = 10_000_000;

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
        let fault = Fault::nth("prop", nth, "file", "");
        let message = format!("`file` of a [[prop]]: {reason}");
        Self { message, ..fault.at_its_line(text) }
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
            return Some(Fault::at("schema", rule));
        }
        None.or_else(|| self.check_names())
            .or_else(|| self.check_people())
            .or_else(|| self.check_place())
            .or_else(|| self.check_view())
    }

    fn check_names(&self) -> Option<Fault> {
        let of = |table: &'static str, names: Vec<&str>| -> Option<Fault> {
            let twice = names.iter().enumerate().find(|(nth, name)| names[..*nth].contains(name));
            let (nth, name) = twice?;
            Some(Fault::nth(table, nth, "name", format!("unique, and another is \"{name}\"")))
        };
        of("cast", self.casts.iter().map(|cast| cast.name.as_str()).collect())
            .or_else(|| of("footway", self.footways.iter().map(|of| of.name.as_str()).collect()))
            .or_else(|| of("lane", self.lanes.iter().map(|lane| lane.name.as_str()).collect()))
            .or_else(|| of("camera", self.cameras.iter().map(|of| of.name.as_str()).collect()))
    }

    fn check_people(&self) -> Option<Fault> {
        for (nth, cast) in self.casts.iter().enumerate() {
            if cast.from.is_empty() {
                let rule = "a list of files or built-in people, such as [\"@people\"]";
                return Some(Fault::nth("cast", nth, "from", rule));
            }
        }
        for (nth, crowd) in self.crowds.iter().enumerate() {
            let fault = |key, rule: String| Some(Fault::nth("crowd", nth, key, rule));
            let casts = self.casts.iter().map(|cast| cast.name.as_str());
            if let Some(rule) = unknown("a cast of the file", &crowd.cast, casts) {
                return fault("cast", rule);
            }
            if !(1..=MOST_MEMBERS).contains(&crowd.count) {
                return fault("count", format!("from 1 to {MOST_MEMBERS}"));
            }
            if let BehaviourPlan::Stroll(stroll) = &crowd.does {
                for name in &stroll.footways {
                    let footways = self.footways.iter().map(|footway| footway.name.as_str());
                    if let Some(rule) = unknown("names of footways of the file", name, footways) {
                        return fault("does", rule);
                    }
                }
                if self.footways.is_empty() {
                    return fault("does", "another kind: `stroll` needs a [[footway]]".into());
                }
            }
            if let Some(layer) = crowd.layers.iter().find(|layer| !is_part(layer.weight)) {
                return fault("layers", format!("of weights from 0 to 1, not {}", layer.weight));
            }
        }
        None
    }

    fn check_place(&self) -> Option<Fault> {
        let far = |points: &[[f32; 2]]| !points.iter().flatten().all(|value| is_near(*value));
        for (nth, footway) in self.footways.iter().enumerate() {
            if footway.points.len() < 2 || far(&footway.points) {
                let rule = "at least two points of at most 1000000 metres";
                return Some(Fault::nth("footway", nth, "points", rule));
            }
            if !(0.2..=1000.0).contains(&footway.width_m) {
                return Some(Fault::nth("footway", nth, "width_m", "from 0.2 to 1000 metres"));
            }
        }
        for (nth, wall) in self.walls.iter().enumerate() {
            if wall.points.len() < 2 || far(&wall.points) {
                let rule = "at least two points of at most 1000000 metres";
                return Some(Fault::nth("wall", nth, "points", rule));
            }
        }
        for (nth, bay) in self.bays.iter().enumerate() {
            let lanes = self.lanes.iter().map(|lane| lane.name.as_str());
            if let Some(rule) = unknown("a lane of the file", &bay.lane, lanes) {
                return Some(Fault::nth("bay", nth, "lane", rule));
            }
        }
        for (nth, lane) in self.lanes.iter().enumerate() {
            if far(&lane.ends) || lane.ends[0] == lane.ends[1] {
                return Some(Fault::nth("lane", nth, "ends", "two different points"));
            }
        }
        for (nth, prop) in self.props.iter().enumerate() {
            if let Some(fault) = check_kind(nth, prop) {
                return Some(fault);
            }
            if !prop.at.iter().chain(&prop.size_m).all(|value| is_near(*value)) {
                return Some(Fault::nth("prop", nth, "at", "of numbers of at most 1000000 metres"));
            }
            if prop.crossing.is_some_and(|crossing| crossing >= self.crossings.len()) {
                let rule = format!("below {}, the number of crossings", self.crossings.len());
                return Some(Fault::nth("prop", nth, "crossing", rule));
            }
        }
        None
    }

    fn check_view(&self) -> Option<Fault> {
        for (nth, camera) in self.cameras.iter().enumerate() {
            if camera.keys.is_empty() {
                return Some(Fault::nth("camera", nth, "key", "at least one key"));
            }
            if camera.keys.windows(2).any(|pair| pair[0].time >= pair[1].time) {
                return Some(Fault::nth("camera", nth, "key", "in the order of their times"));
            }
            if camera.keys.iter().any(|key| !(1.0..=170.0).contains(&key.fov)) {
                return Some(Fault::nth("camera", nth, "key", "of `fov` from 1 to 170 degrees"));
            }
        }
        let size = self.output.size;
        if size.iter().any(|side| !(1..=16384).contains(side)) {
            return Some(Fault::within("output", "size", "from 1 to 16384 pixels"));
        }
        if !(0.001..=1000.0).contains(&self.output.fps) {
            return Some(Fault::within("output", "fps", "from 0.001 to 1000"));
        }
        None
    }
}

/// Finds a prop that is neither of a kind nor of a file, or of both.
fn check_kind(nth: usize, prop: &PropPlan) -> Option<Fault> {
    match (prop.kind.as_str(), &prop.file) {
        ("", None) => {
            let rule = "a kind of thing, or there must be a `file` in its place";
            Some(Fault::nth("prop", nth, "kind", rule))
        }
        ("", Some(_)) => None,
        (_, Some(_)) => {
            let rule = "left out: the prop has a `kind`, and is one or the other";
            Some(Fault::nth("prop", nth, "file", rule))
        }
        (kind, None) => unknown("one of the kinds", kind, PROP_KINDS.into_iter())
            .map(|rule| Fault::nth("prop", nth, "kind", rule)),
    }
}

fn is_near(value: f32) -> bool {
    value.abs() <= LARGEST
}

fn is_part(value: f32) -> bool {
    (0.0..=1.0).contains(&value)
}

/// Says that a name is not among those that are known.
fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    let known: Vec<&str> = known.collect();
    if known.contains(&name) {
        return None;
    }
    let nearest = did_you_mean(&nearest_names(name, known));
    Some(format!("{what}, and none is \"{name}\"{nearest}"))
}

/// A value that is refused.
struct Fault {
    /// Its table and the number of the table among those of its name, from 0 on.
    table: Option<(&'static str, usize)>,
    key: &'static str,
    rule: String,
}

impl Fault {
    fn at(key: &'static str, rule: impl Into<String>) -> Self {
        Self { table: None, key, rule: rule.into() }
    }

    fn within(table: &'static str, key: &'static str, rule: impl Into<String>) -> Self {
        Self { table: Some((table, 0)), key, rule: rule.into() }
    }

    fn nth(table: &'static str, nth: usize, key: &'static str, rule: impl Into<String>) -> Self {
        Self { table: Some((table, nth)), key, rule: rule.into() }
    }

    fn message(&self) -> String {
        let Self { table, key, rule } = self;
        match table {
            Some((table, _)) => format!("`{key}` of a [[{table}]] must be {rule}"),
            None => format!("`{key}` must be {rule}"),
        }
    }

    /// Finds the line of the value, or of its table if it is not written there.
    fn at_its_line(&self, text: &str) -> SceneFileError {
        let span = DeTable::parse(text).ok().and_then(|root| self.span(root.get_ref()));
        SceneFileError { line: line(text, span.unwrap_or_default()), message: self.message() }
    }

    fn span(&self, root: &DeTable<'_>) -> Option<Range<usize>> {
        let Some((table, nth)) = self.table else {
            return Some(root.get(self.key)?.span());
        };
        let mut within = root.get(table)?;
        if let DeValue::Array(all) = within.get_ref() {
            within = all.get(nth)?;
        }
        let key = within.get_ref().as_table().and_then(|table| table.get(self.key));
        Some(key.unwrap_or(within).span())
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
    SceneFileError { line: line(text, span), message }
}
