//! A compact JSON tree that is built within the memory budget.

use std::borrow::Cow;
use std::fmt;

use serde::Deserializer;
use serde::de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};
use serde_json::Number;

use crate::budget::Budget;
use crate::log::{Checked, Log, Reported};

/// A JSON value. Strings without escapes borrow from the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value<'a> {
    Null,
    Bool(bool),
    Number(Number),
    Text(Cow<'a, str>),
    Array(Box<[Value<'a>]>),
    Object(Object<'a>),
}

/// Properties sorted by name, without duplicates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Object<'a>(Box<[(Cow<'a, str>, Value<'a>)]>);

impl<'a> Object<'a> {
    /// Sorts the properties. If a name occurs several times, the last one is kept.
    fn new(mut properties: Vec<(Cow<'a, str>, Value<'a>)>) -> Self {
        properties.reverse();
        properties.sort_by(|a, b| a.0.cmp(&b.0));
        properties.dedup_by(|later, kept| later.0 == kept.0);
        Self(properties.into_boxed_slice())
    }

    pub(crate) fn get(&self, key: &str) -> Option<&Value<'a>> {
        let at = self.0.binary_search_by(|(name, _)| name.as_ref().cmp(key)).ok()?;
        Some(&self.0[at].1)
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_ref())
    }
}

/// Overhead of a heap allocation in bytes.
const BLOCK_BYTES: u64 = 16;

/// Parses the JSON of a file.
pub(crate) fn parse<'a>(json: &'a [u8], budget: &Budget, log: &Log) -> Checked<Value<'a>> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let parsed = Builder { budget }.deserialize(&mut deserializer);
    parsed.and_then(|value| deserializer.end().map(|()| value)).map_err(|error| {
        // Data errors come only from the budget, which has logged them.
        if error.is_data() {
            Reported
        } else {
            log.problem("file", format!("is not valid JSON: {error}"))
        }
    })
}

/// Builds values and reserves their memory.
#[derive(Clone, Copy)]
struct Builder<'b> {
    budget: &'b Budget<'b>,
}

impl Builder<'_> {
    fn take<E: Error>(self, bytes: u64) -> Result<(), E> {
        self.budget.take("file", "its JSON", bytes).map_err(|Reported| E::custom("too large"))
    }
}

impl<'de> DeserializeSeed<'de> for Builder<'_> {
    type Value = Value<'de>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value<'de>, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Builder<'_> {
    type Value = Value<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value<'de>, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value<'de>, E> {
        Ok(Value::Bool(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value<'de>, E> {
        Ok(Value::Number(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value<'de>, E> {
        Ok(Value::Number(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value<'de>, E> {
        Ok(Number::from_f64(value).map_or(Value::Null, Value::Number))
    }

    fn visit_borrowed_str<E>(self, value: &'de str) -> Result<Value<'de>, E> {
        Ok(Value::Text(Cow::Borrowed(value)))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value<'de>, E> {
        self.take(value.len() as u64 + BLOCK_BYTES)?;
        Ok(Value::Text(Cow::Owned(value.to_owned())))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value<'de>, A::Error> {
        self.take(BLOCK_BYTES)?;
        let mut items = Vec::new();
        while let Some(item) = list.next_element_seed(self)? {
            self.take(size_of::<Value>() as u64)?;
            items.push(item);
        }
        Ok(Value::Array(items.into_boxed_slice()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value<'de>, A::Error> {
        self.take(BLOCK_BYTES)?;
        let mut properties = Vec::new();
        while let Some(name) = map.next_key_seed(Name)? {
            let owned =
                if matches!(name, Cow::Owned(_)) { name.len() as u64 + BLOCK_BYTES } else { 0 };
            self.take(size_of::<(Cow<str>, Value)>() as u64 + owned)?;
            properties.push((name, map.next_value_seed(self)?));
        }
        Ok(Value::Object(Object::new(properties)))
    }
}

/// Deserializes a property name.
struct Name;

impl<'de> DeserializeSeed<'de> for Name {
    type Value = Cow<'de, str>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Cow<'de, str>, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl<'de> Visitor<'de> for Name {
    type Value = Cow<'de, str>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_borrowed_str<E>(self, value: &'de str) -> Result<Cow<'de, str>, E> {
        Ok(Cow::Borrowed(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Cow<'de, str>, E> {
        Ok(Cow::Owned(value.to_owned()))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Parses valid JSON.
    pub(crate) fn tree(text: &str) -> Value<'_> {
        let log = Log::default();
        parse(text.as_bytes(), &Budget::new(u64::MAX, &log), &log).unwrap()
    }

    #[test]
    fn all_kinds_of_values_parse() {
        let root =
            tree(r#"{"b": [1, -2, 2.5, "x", "\n", null, true], "a": {}, "b\u0061": 1, "ba": 2}"#);
        let Value::Object(root) = root else { panic!("{root:?}") };
        assert_eq!(root.keys().collect::<Vec<_>>(), ["a", "b", "ba"]);
        assert_eq!(root.get("a"), Some(&Value::Object(Object::default())));
        assert_eq!(root.get("ba"), Some(&Value::Number(2.into())), "the last duplicate is kept");
        assert_eq!(root.get("c"), None);
        let items = [
            Value::Number(1.into()),
            Value::Number((-2).into()),
            Value::Number(Number::from_f64(2.5).unwrap()),
            Value::Text("x".into()),
            Value::Text("\n".into()),
            Value::Null,
            Value::Bool(true),
        ];
        assert_eq!(root.get("b"), Some(&Value::Array(items.into())));
    }

    #[test]
    fn invalid_json_is_reported() {
        for text in ["", "{", "[1,]", "{} x", "{\"a\": 1e999}", "nul"] {
            let log = Log::default();
            parse(text.as_bytes(), &Budget::new(u64::MAX, &log), &log).unwrap_err();
            let problem = log.finish().unwrap_err()[0].to_string();
            assert!(problem.starts_with("file: is not valid JSON"), "{text}: {problem}");
        }
    }

    #[test]
    fn parsing_stops_at_the_memory_limit() {
        let many = format!("[{}0]", "{\"a\":[0]},".repeat(1000));
        let log = Log::default();
        parse(many.as_bytes(), &Budget::new(50_000, &log), &log).unwrap_err();
        let problems = log.finish().unwrap_err();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert!(problems[0].to_string().contains("for its JSON"), "{problems:?}");
    }
}
