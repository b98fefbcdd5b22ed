//! Typed access to the JSON of a file. Mismatches are logged with their JSON path.

use crate::log::{Checked, Log, Reported};
use crate::tree::Value;

/// Largest magnitude of a number in transforms, keys and vertices. Products of several such numbers
/// stay within single precision.
pub(crate) const LARGEST: f64 = populace_model::LARGEST as f64;

/// A JSON value with its path and the log for its problems.
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

    /// Returns the JSON path, such as `animations[2].channels[0]`, or `file` for the root.
    pub(crate) fn place(&self) -> &str {
        if self.place.is_empty() { "file" } else { &self.place }
    }

    pub(crate) fn problem(&self, what: impl Into<String>) -> Reported {
        self.log.problem(self.place(), what)
    }

    pub(crate) fn note(&self, what: impl Into<String>) {
        self.log.note(self.place(), what);
    }

    /// Returns a property, or `None` if it is missing or this is not an object.
    pub(crate) fn get(&self, key: &str) -> Option<Self> {
        let Value::Object(object) = self.value else { return None };
        let value = object.get(key)?;
        Some(Self { value, place: self.place_of(key), log: self.log })
    }

    fn place_of(&self, key: &str) -> String {
        // Not `format!`, which takes several times as long: a file has many properties.
        if self.place.is_empty() { key.to_owned() } else { [&self.place, ".", key].concat() }
    }

    /// Returns a required property.
    pub(crate) fn require(&self, key: &str) -> Checked<Self> {
        self.object()?;
        self.get(key)
            .ok_or_else(|| self.log.problem(self.place_of(key), "is missing; it is required"))
    }

    /// Reads an optional property with `read`.
    pub(crate) fn optional<T>(
        &self,
        key: &str,
        read: impl Fn(&Self) -> Checked<T>,
    ) -> Checked<Option<T>> {
        self.get(key).map(|at| read(&at)).transpose()
    }

    /// Returns the object of an extension.
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

    /// Checks that this is an object.
    pub(crate) fn object(&self) -> Checked<()> {
        matches!(self.value, Value::Object(_))
            .then_some(())
            .ok_or_else(|| self.wrong_type("an object"))
    }

    /// Returns the property names of an object.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'a str> {
        let object = if let Value::Object(object) = self.value { Some(object) } else { None };
        object.into_iter().flat_map(|o| o.keys())
    }

    /// Returns the items of an array.
    pub(crate) fn items(&self) -> Checked<Vec<Self>> {
        let Value::Array(items) = self.value else { return Err(self.wrong_type("an array")) };
        if items.is_empty() {
            self.note("is empty; glTF requires that empty arrays are omitted");
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

    /// Returns the length of an array, or 0 if this is not an array.
    pub(crate) fn item_count(&self) -> usize {
        if let Value::Array(items) = self.value { items.len() } else { 0 }
    }

    /// Returns the items of an array property, or none if it is missing or not an array.
    pub(crate) fn list(&self, key: &str) -> Vec<Self> {
        self.get(key).and_then(|at| at.items().ok()).unwrap_or_default()
    }

    /// Returns [`Self::list`] and checks that each item is an object.
    pub(crate) fn objects(&self, key: &str) -> Vec<Self> {
        let list = self.list(key);
        for item in &list {
            item.object().ok();
        }
        list
    }

    /// Reads a non-negative whole number. `3.0` is accepted too.
    pub(crate) fn uint(&self) -> Checked<usize> {
        const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53: not all whole numbers above are doubles
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
                "is {written}; it must be a whole number from 0 to {}",
                usize::MAX
            ))),
        }
    }

    /// Reads the index of one of `count` objects; `what` names their kind in the problem.
    pub(crate) fn index(&self, count: usize, what: &str) -> Checked<usize> {
        let index = self.uint()?;
        if index < count {
            return Ok(index);
        }
        Err(self.problem(match count {
            0 => format!("refers to {what} {index}, but there is none"),
            _ => format!("refers to {what} {index}, but the last one is {what} {}", count - 1),
        }))
    }

    /// Reads a number whose magnitude is at most [`LARGEST`].
    pub(crate) fn number(&self) -> Checked<f64> {
        let Value::Number(written) = self.value else { return Err(self.wrong_type("a number")) };
        let number = written.as_f64().unwrap_or(f64::INFINITY);
        if number.abs() <= LARGEST {
            return Ok(number);
        }
        Err(self.problem(format!("is {written}; the magnitude must be at most {LARGEST:e}")))
    }

    /// Reads an array of exactly `N` numbers.
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

    /// Returns the `name` property, or an empty string if it is missing.
    pub(crate) fn name(&self) -> String {
        let name = self.optional("name", Self::text);
        name.ok().flatten().unwrap_or_default().to_owned()
    }
}

/// Rounds to the nearest `f32`.
#[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
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
    fn problems_have_json_paths() {
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
                "a[0].i: refers to node 7, but the last one is node 1",
                "a[2].i: must be a whole number, but is a string",
                &format!("a[3].i: is -1; it must be a whole number from 0 to {}", usize::MAX),
                "a[4].i: is missing; it is required",
            ]
        );
    }

    #[test]
    fn uint_accepts_whole_floats_up_to_2_pow_53() {
        let value = tree(r#"{"a": 3.0, "b": 3.5, "c": 1e300}"#);
        let log = Log::default();
        let root = Cursor::root(&value, &log);
        assert_eq!(root.require("a").unwrap().uint().unwrap(), 3);
        assert!(root.require("b").unwrap().uint().is_err());
        assert!(root.require("c").unwrap().uint().is_err());
    }

    #[test]
    fn numbers_checks_length_and_magnitude() {
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
