//! A place in the JSON of a file: reads typed values and logs what is not as it should be.

use crate::log::{Checked, Log, Reported};
use crate::tree::Value;

/// Largest size of a number in transforms, keys and vertices. Products of several stay within
/// single precision.
pub(crate) const LARGEST: f64 = populace_model::LARGEST as f64;

/// A JSON value, where it stands, and the log that its problems go to.
#[derive(Clone)]
pub(crate) struct Cursor<'a> {
    value: &'a Value<'a>,
    place: String,
    log: &'a Log,
}

impl<'a> Cursor<'a> {
    pub(crate) fn root(value: &'a Value<'a>, log: &'a Log) -> Self {
        let place = String::new();
        Self { value, place, log }
    }

    /// The path, as `animations[2].channels[0]`.
    pub(crate) fn place(&self) -> &str {
        if self.place.is_empty() { "file" } else { &self.place }
    }

    pub(crate) fn problem(&self, what: impl Into<String>) -> Reported {
        self.log.problem(self.place(), what)
    }

    pub(crate) fn note(&self, what: impl Into<String>) {
        self.log.note(self.place(), what);
    }

    /// A property, if it is there. Something that is no object has none.
    pub(crate) fn get(&self, key: &str) -> Option<Self> {
        let Value::Object(object) = self.value else { return None };
        let value = object.get(key)?;
        Some(Self { value, place: self.place_of(key), log: self.log })
    }

    fn place_of(&self, key: &str) -> String {
        if self.place.is_empty() { key.to_owned() } else { format!("{}.{key}", self.place) }
    }

    /// A property that must be there.
    pub(crate) fn require(&self, key: &str) -> Checked<Self> {
        self.object()?;
        self.get(key)
            .ok_or_else(|| self.log.problem(self.place_of(key), "is missing; it is required"))
    }

    /// A property that may be left out, read by `read`.
    pub(crate) fn optional<T>(
        &self,
        key: &str,
        read: impl Fn(&Self) -> Checked<T>,
    ) -> Checked<Option<T>> {
        self.get(key).map(|at| read(&at)).transpose()
    }

    /// An extension's object.
    pub(crate) fn extension(&self, name: &str) -> Option<Self> {
        self.get("extensions")?.get(name)
    }

    fn wrong_type(&self, wanted: &str) -> Reported {
        let is = match self.value {
            Value::Null => "null",
            Value::Bool(_) => "a boolean",
            Value::Number(_) => "a number",
            Value::Text(_) => "a string",
            Value::Array(_) => "an array",
            Value::Object(_) => "an object",
        };
        self.problem(format!("must be {wanted}, but is {is}"))
    }

    /// That this is an object.
    pub(crate) fn object(&self) -> Checked<()> {
        matches!(self.value, Value::Object(_))
            .then_some(())
            .ok_or_else(|| self.wrong_type("an object"))
    }

    /// The property names of an object.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> {
        let object = if let Value::Object(object) = self.value { Some(object) } else { None };
        object.into_iter().flat_map(|o| o.keys())
    }

    /// The items of an array.
    pub(crate) fn items(&self) -> Checked<Vec<Self>> {
        let Value::Array(items) = self.value else { return Err(self.wrong_type("an array")) };
        if items.is_empty() {
            self.note("is empty; glTF wants empty arrays left out");
        }
        Ok(items
            .iter()
            .enumerate()
            .map(|(index, value)| Self {
                value,
                place: format!("{}[{index}]", self.place),
                log: self.log,
            })
            .collect())
    }

    /// How many items an array has; none where this is no array.
    pub(crate) fn item_count(&self) -> usize {
        if let Value::Array(items) = self.value { items.len() } else { 0 }
    }

    /// The items of an array property; none if it is not there or is no array.
    pub(crate) fn list(&self, key: &str) -> Vec<Self> {
        self.get(key).and_then(|at| at.items().ok()).unwrap_or_default()
    }

    /// Like [`Self::list`], and each item must be an object.
    pub(crate) fn objects(&self, key: &str) -> Vec<Self> {
        let list = self.list(key);
        for item in &list {
            item.object().ok();
        }
        list
    }

    /// A whole number that is not negative. `3.0` is one too.
    pub(crate) fn uint(&self) -> Checked<usize> {
        const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53: above it, doubles skip whole numbers
        let Value::Number(written) = self.value else {
            return Err(self.wrong_type("a whole number"));
        };
        let whole = written.as_u64().or_else(|| {
            let number = written.as_f64()?;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "just checked to be a whole number in range"
            )]
            let whole =
                (number.fract() == 0.0 && (0.0..=EXACT).contains(&number)).then_some(number as u64);
            whole
        });
        match whole.map(usize::try_from) {
            Some(Ok(whole)) => Ok(whole),
            _ => Err(self.problem(format!(
                "is {written}; it must be a whole number from 0 on, of a size that a file can have"
            ))),
        }
    }

    /// The index of one of `count` things called `what`.
    pub(crate) fn index(&self, count: usize, what: &str) -> Checked<usize> {
        let index = self.uint()?;
        if index < count {
            return Ok(index);
        }
        Err(self.problem(match count {
            0 => format!("names {what} {index}, but there is none"),
            1 => format!("names {what} {index}, but there is only {what} 0"),
            _ => format!("names {what} {index}, but there are only {what} 0 to {}", count - 1),
        }))
    }

    /// A number of at most [`LARGEST`] in size.
    pub(crate) fn number(&self) -> Checked<f64> {
        let Value::Number(written) = self.value else { return Err(self.wrong_type("a number")) };
        let number = written.as_f64().unwrap_or(f64::INFINITY);
        if number.abs() <= LARGEST {
            return Ok(number);
        }
        Err(self.problem(format!("is {written}; numbers may be at most {LARGEST:e} in size")))
    }

    /// An array of exactly `N` numbers.
    pub(crate) fn numbers<const N: usize>(&self) -> Checked<[f64; N]> {
        let Value::Array(items) = self.value else {
            return Err(self.wrong_type(&format!("an array of {N} numbers")));
        };
        if items.len() != N {
            return Err(self.problem(format!("has {} numbers; it must have {N}", items.len())));
        }
        let mut numbers = [0.0; N];
        for (to, item) in numbers.iter_mut().zip(self.items()?) {
            *to = item.number()?;
        }
        Ok(numbers)
    }

    pub(crate) fn text(&self) -> Checked<&'a str> {
        let Value::Text(text) = self.value else { return Err(self.wrong_type("a string")) };
        Ok(text)
    }

    pub(crate) fn flag(&self) -> Checked<bool> {
        let Value::Bool(flag) = self.value else { return Err(self.wrong_type("true or false")) };
        Ok(*flag)
    }

    /// The `name` property, empty where there is none.
    pub(crate) fn name(&self) -> String {
        let name = self.optional("name", Self::text);
        name.ok().flatten().unwrap_or_default().to_owned()
    }
}

/// Rounds to the nearest `f32`.
#[expect(clippy::cast_possible_truncation, reason = "rounding is what is wanted")]
pub(crate) fn to_f32(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::tests::tree;

    fn problems(value: &Value, read: impl Fn(&Cursor)) -> Vec<String> {
        let log = Log::default();
        read(&Cursor::root(value, &log));
        let problems = log.finish().err().unwrap_or_default();
        problems.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn every_problem_has_its_path() {
        let value = tree(r#"{"a": [{"i": 7}, 3, {"i": "x"}, {"i": -1}, {}]}"#);
        let found = problems(&value, |root| {
            for item in root.objects("a") {
                item.require("i").and_then(|i| i.index(2, "node")).ok();
            }
        });
        assert_eq!(
            found,
            [
                "a[1]: must be an object, but is a number",
                "a[0].i: names node 7, but there are only node 0 to 1",
                "a[2].i: must be a whole number, but is a string",
                "a[3].i: is -1; it must be a whole number from 0 on, of a size that a file can \
                 have",
                "a[4].i: is missing; it is required",
            ]
        );
    }

    #[test]
    fn whole_numbers_may_be_written_as_floats_but_not_beyond_reason() {
        let value = tree(r#"{"a": 3.0, "b": 3.5, "c": 1e300}"#);
        let log = Log::default();
        let root = Cursor::root(&value, &log);
        assert_eq!(root.require("a").unwrap().uint().unwrap(), 3);
        assert!(root.require("b").unwrap().uint().is_err());
        assert!(root.require("c").unwrap().uint().is_err());
    }

    #[test]
    fn arrays_of_numbers_have_a_length_and_fit_floats() {
        let value = tree(r#"{"short": [1, 2], "wide": [1, 1e39, 2], "good": [1, 2.5, -3]}"#);
        let log = Log::default();
        let root = Cursor::root(&value, &log);
        assert!(root.get("short").unwrap().numbers::<3>().is_err());
        assert!(root.get("wide").unwrap().numbers::<3>().is_err());
        assert_eq!(root.get("good").unwrap().numbers().unwrap(), [1.0, 2.5, -3.0]);
        let problems = log.finish().unwrap_err();
        assert_eq!(problems[0].place, "short");
        assert_eq!(problems[1].place, "wide[1]");
    }
}
