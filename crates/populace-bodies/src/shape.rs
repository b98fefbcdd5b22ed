//! Shapes: how targets move the base mesh for a phenotype.

use std::collections::{BTreeMap, HashMap};
use std::path::{Component, Path};

use glam::Vec3;
use serde_json::Value;

use crate::Error;
use crate::mesh_file::numbers;
use crate::source::Source;

/// The age at which bodies cease to be those of children, and that of a young adult.
pub(crate) const CHILDHOOD_ENDS: f32 = 0.36;
const YOUNG: f32 = 0.5;

const RULES: &str = "targets/macrodetails/macro.json";

/// Values of a body, each from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Phenotype {
    /// 0 is female, 1 male.
    pub gender: f32,
    /// 0 is a baby, 0.19 a child, 0.5 a young adult, 1 an old person.
    pub age: f32,
    /// Muscles, 0.5 on average.
    pub muscle: f32,
    /// Weight for the height, 0.5 on average.
    pub weight: f32,
    /// Height, 0.5 on average for gender and age.
    pub height: f32,
    /// Proportions; 1 is ideal.
    pub proportions: f32,
    /// Shares of African, Asian and Caucasian ancestors, each 0 or more. They count relative to
    /// their sum, which is above 0.
    pub ancestry: [f32; 3],
    /// Single targets beyond those, such as `nose/nose-hump-incr`, with their weights. Names that
    /// the body system lacks are ignored.
    pub details: Vec<(String, f32)>,
}

impl Phenotype {
    /// Refuses numbers out of their ranges, and targets that could lie elsewhere.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { gender, age, muscle, weight, height, proportions, .. } = *self;
        let values = [
            ("the gender", gender),
            ("the age", age),
            ("the muscle", muscle),
            ("the weight", weight),
            ("the height", height),
            ("the proportions", proportions),
        ];
        let details = self.details.iter().map(|(_, weight)| ("the weight of a target", *weight));
        for (what, value) in values.into_iter().chain(details) {
            if !(0.0..=1.0).contains(&value) {
                return Err(Error::BadValue { what, value, rule: "from 0 to 1" });
            }
        }
        for value in self.ancestry {
            if !(0.0..=1e6).contains(&value) {
                let what = "a share of the ancestry";
                return Err(Error::BadValue { what, value, rule: "from 0 to 1e6" });
            }
        }
        let value = self.ancestry.iter().sum();
        if value <= 0.0 {
            let what = "the sum of the ancestry";
            return Err(Error::BadValue { what, value, rule: "above 0" });
        }
        let leads_out = |name: &str| {
            Path::new(name).components().any(|part| !matches!(part, Component::Normal(_)))
        };
        match self.details.iter().find(|(name, _)| leads_out(name)) {
            Some((name, _)) => Err(Error::BadTarget { name: name.clone() }),
            None => Ok(()),
        }
    }

    /// How far the body is from a child's to a young adult's, from 0 to 1.
    pub(crate) fn maturity(&self) -> f32 {
        ((self.age - CHILDHOOD_ENDS) / (YOUNG - CHILDHOOD_ENDS)).clamp(0.0, 1.0)
    }

    fn value(&self, name: &str) -> f32 {
        match name {
            "gender" => self.gender,
            "age" => self.age,
            "muscle" => self.muscle,
            "weight" => self.weight,
            "height" => self.height,
            "proportions" => self.proportions,
            "cupsize" => 0.5 * self.maturity(),
            _ => 0.5,
        }
    }
}

/// A range of a value between two named ends.
struct Range {
    lowest: f32,
    highest: f32,
    ends: [String; 2],
}

/// The rules by which values become weights of targets: products of the weights of the ends of
/// ranges, for each combination of values.
pub(crate) struct Rules {
    ranges: HashMap<String, Vec<Range>>,
    combinations: Vec<(String, Vec<String>)>,
}

/// Targets by file name, read once.
#[derive(Default)]
pub(crate) struct Targets {
    read: HashMap<String, Option<Vec<(u32, Vec3)>>>,
}

impl Rules {
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let bad = |what: &str| Error::bad(RULES, what);
        let value: Value =
            serde_json::from_str(text).map_err(|e| bad(&format!("is not JSON: {e}")))?;
        let macros =
            value["macrotargets"].as_object().ok_or_else(|| bad("has no \"macrotargets\""))?;
        let number = |v: &Value| v.as_f64().map_or(0.0, populace_model::convert::single);
        let range = |part: &Value| Range {
            lowest: number(&part["lowest"]),
            highest: number(&part["highest"]),
            ends: ["low", "high"].map(|end| part[end].as_str().unwrap_or_default().to_owned()),
        };
        let ranges = macros.iter().map(|(name, of)| {
            let parts = of["parts"].as_array().into_iter().flatten();
            (name.clone(), parts.map(range).collect())
        });
        let combinations = value["combinations"].as_object();
        let combinations =
            combinations.ok_or_else(|| bad("has no \"combinations\""))?.iter().map(|(name, of)| {
                let values = of.as_array().into_iter().flatten();
                (name.clone(), values.filter_map(Value::as_str).map(str::to_owned).collect())
            });
        Ok(Self { ranges: ranges.collect(), combinations: combinations.collect() })
    }

    /// Returns the weights of the ends of a value. Ends without a name count as `""`.
    fn ends(&self, name: &str, who: &Phenotype) -> Vec<(String, f32)> {
        if name == "race" {
            let sum: f32 = who.ancestry.iter().sum();
            let names = ["african", "asian", "caucasian"].map(str::to_owned);
            return names.into_iter().zip(who.ancestry.map(|share| share / sum)).collect();
        }
        let value = who.value(name);
        let ranges = self.ranges.get(name).map_or(&[][..], Vec::as_slice);
        let Some(range) = ranges.iter().find(|r| (r.lowest..=r.highest).contains(&value)) else {
            return vec![(String::new(), 1.0)];
        };
        let high = (value - range.lowest) / (range.highest - range.lowest).max(1e-6);
        let [low_end, high_end] = range.ends.clone();
        vec![(low_end, 1.0 - high), (high_end, high)]
    }

    /// Returns the names of targets, without folder and suffix, and their weights.
    fn weights(&self, who: &Phenotype) -> BTreeMap<String, f32> {
        let mut weights = BTreeMap::new();
        for (combination, values) in &self.combinations {
            let universal = combination == "genderagemuscleweight";
            let start = if universal { "universal" } else { "" };
            let mut products = vec![(start.to_owned(), 1.0_f32)];
            for value in values {
                let ends = self.ends(value, who);
                let with = |(name, weight): &(String, f32)| {
                    let joined = |end: &String| match (name.is_empty(), end.is_empty()) {
                        (true, _) => end.clone(),
                        // A value in the middle has no target of its own.
                        (false, true) => "-".to_owned(),
                        (false, false) => format!("{name}-{end}"),
                    };
                    ends.iter().map(|(end, w)| (joined(end), weight * w)).collect::<Vec<_>>()
                };
                products = products.iter().flat_map(with).filter(|(_, w)| *w > 1e-4).collect();
            }
            weights.extend(products.into_iter().filter(|(name, _)| !name.starts_with("-")));
        }
        weights
    }
}

/// Returns the base mesh's positions, in its own units, for a phenotype.
pub(crate) fn positions(
    base: &[Vec3],
    who: &Phenotype,
    rules: &Rules,
    targets: &mut Targets,
    source: &mut Source,
) -> Result<Vec<Vec3>, Error> {
    who.check()?;
    let mut positions = base.to_vec();
    let folders = ["macrodetails/", "macrodetails/height/", "macrodetails/proportions/", "breast/"];
    for (name, weight) in rules.weights(who) {
        for folder in folders {
            targets.add(&format!("{folder}{name}"), weight, source, &mut positions)?;
        }
    }
    for (name, weight) in &who.details {
        targets.add(name, *weight, source, &mut positions)?;
    }
    Ok(positions)
}

impl Targets {
    /// Moves vertices by a target times a weight, if there is such a target.
    fn add(
        &mut self,
        name: &str,
        weight: f32,
        source: &mut Source,
        positions: &mut [Vec3],
    ) -> Result<(), Error> {
        if !self.read.contains_key(name) {
            let target = read_target(name, source)?;
            self.read.insert(name.to_owned(), target);
        }
        for (vertex, offset) in self.read[name].iter().flatten() {
            if let Some(position) = positions.get_mut(*vertex as usize) {
                *position += *offset * weight;
            }
        }
        Ok(())
    }
}

/// Reads lines of a vertex and its offset.
fn read_target(name: &str, source: &mut Source) -> Result<Option<Vec<(u32, Vec3)>>, Error> {
    let files = [format!("targets/{name}.target.gz"), format!("targets/{name}.target")];
    let Some(file) = files.iter().find(|file| source.has(file)) else { return Ok(None) };
    let text = source.text(file)?;
    let lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let offset = |line: &str| {
        let mut words = line.split_whitespace();
        let vertex = words.next()?.parse().ok()?;
        Some((vertex, Vec3::from(numbers::<3>(&mut words)?)))
    };
    let offsets: Option<Vec<_>> = lines.map(offset).collect();
    let wrong = || Error::bad(file, "must hold lines of a vertex and three numbers");
    offsets.map(Some).ok_or_else(wrong)
}
