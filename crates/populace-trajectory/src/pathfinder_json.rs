//! JSON of Pathfinder: agents, each with its times, each with what holds then.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::extra::Extras;
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut file = File::default();
    let mut json = serde_json::Deserializer::from_reader(input.open_text()?);
    let read = Part { file: &mut file, depth: Depth::Agents }.deserialize(&mut json);
    match read.and_then(|()| json.end()) {
        Ok(()) => {}
        // A file that was cut off, also within what gzip compressed.
        Err(error) if file.rows.len() > 0 && (error.is_eof() || error.is_io()) => {
            let line = error.line();
            file.rows.warnings.whole(format!("the file is cut off in line {line}"));
        }
        Err(error) => {
            let at = Some(Location::Line(error.line() as u64));
            let problem = format!(
                "it is no JSON of Pathfinder ({error}); expected are agents, each with times, each \
                 with a position"
            );
            return Err(input.malformed(at, problem));
        }
    }
    let found = Found {
        format: (Format::PathfinderJson, String::new()),
        unit: Fact::of_file(Unit::Metres),
        clock: Clock::Seconds,
        place: Place::default(),
    };
    file.rows.finish(found, input.path(), settings)
}

/// The rows so far, and the entry that is being read.
#[derive(Default)]
struct File {
    rows: Rows,
    extras: Extras,
    agent: String,
    secs: f64,
    /// Entries so far.
    entries: u64,
    position: [f64; 3],
    is_hidden: bool,
    /// Room for keys.
    key: [String; 2],
    /// Columns and values of the entry.
    values: Vec<(usize, Value)>,
    /// The words among the values, one behind the other.
    words: String,
}

enum Value {
    Number(f64),
    /// The length of a word.
    Word(usize),
}

impl File {
    /// Adds the entry as a row.
    fn add(&mut self) {
        self.entries += 1;
        if self.is_hidden {
            return;
        }
        let at = Some(Location::Row(self.entries));
        let agent = self.rows.agent(&self.agent);
        let [x, y, z] = self.position;
        self.rows.push(agent, self.secs, [x, y], at);
        if z.is_finite() {
            self.rows.set_elevation(z);
        }
        let mut words = &*self.words;
        for (column, value) in &self.values {
            let column = self.extras.get(*column);
            match value {
                Value::Number(number) => column.set_number(&mut self.rows, *number),
                Value::Word(bytes) => {
                    let (word, rest) = words.split_at(*bytes);
                    column.set_word(&mut self.rows, word);
                    words = rest;
                }
            }
        }
    }

    fn begin(&mut self) {
        self.position = [f64::NAN; 3];
        self.is_hidden = false;
        self.values.clear();
        self.words.clear();
    }

    /// Takes a value of the entry. `path` is its key, or two.
    fn take(&mut self, path: &[&str], value: &Scalar<'_>) {
        match (path, value) {
            (["position", axis], Scalar::Number(number)) => {
                if let Some(axis) = ["x", "y", "z"].iter().position(|name| name == axis) {
                    self.position[axis] = *number;
                }
            }
            (["isActive" | "active"], Scalar::Flag(is_active)) => self.is_hidden = !is_active,
            (["isActive" | "active"], Scalar::Number(number)) => self.is_hidden = *number == 0.0,
            (["velocity", "magnitude"], value) => self.keep("velocity", value),
            (["velocity" | "position", _], _) => {}
            ([name], value) => self.keep(name, value),
            _ => {}
        }
    }

    fn keep(&mut self, name: &str, value: &Scalar<'_>) {
        let Some(column) = self.extras.index(name, &mut self.rows) else { return };
        match value {
            Scalar::Number(number) => self.values.push((column, Value::Number(*number))),
            Scalar::Flag(flag) => {
                self.values.push((column, Value::Number(f64::from(u8::from(*flag)))));
            }
            Scalar::Word(word) => {
                self.words.push_str(word);
                self.values.push((column, Value::Word(word.len())));
            }
        }
    }
}

/// A value that has no parts.
enum Scalar<'a> {
    Number(f64),
    Flag(bool),
    Word(&'a str),
}

/// The level of the file at which a part is.
#[derive(Clone, Copy, PartialEq)]
enum Depth {
    Agents,
    Times,
    Entry,
    /// A value of an entry.
    Value,
    /// A value of a value, such as an axis of the position.
    Inner,
}

/// A part of the file, read where it is needed and nowhere else.
struct Part<'a> {
    file: &'a mut File,
    depth: Depth,
}

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        from.deserialize_any(self)
    }
}

impl Part<'_> {
    /// Takes a value without parts.
    fn scalar<E: serde::de::Error>(self, value: &Scalar<'_>) -> Result<(), E> {
        let file = self.file;
        match self.depth {
            Depth::Agents | Depth::Times => {
                return Err(E::custom("a value where an object is expected"));
            }
            // Without a position it is left out with a warning.
            Depth::Entry => file.add(),
            Depth::Value | Depth::Inner => {
                let keys = std::mem::take(&mut file.key);
                match self.depth {
                    Depth::Value => file.take(&[&keys[0]], value),
                    _ => file.take(&[&keys[0], &keys[1]], value),
                }
                file.key = keys;
            }
        }
        Ok(())
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Self { file, depth } = self;
        let next = match depth {
            Depth::Agents => Depth::Times,
            Depth::Times => Depth::Entry,
            Depth::Entry => Depth::Value,
            Depth::Value => Depth::Inner,
            Depth::Inner => {
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                return Ok(());
            }
        };
        if depth == Depth::Entry {
            file.begin();
        }
        while map.next_key_seed(Key { file: &mut *file, depth })?.is_some() {
            if depth == Depth::Times {
                file.begin();
            }
            map.next_value_seed(Part { file: &mut *file, depth: next })?;
        }
        if depth == Depth::Entry {
            file.add();
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        if self.depth == Depth::Value { Ok(()) } else { self.visit_unit() }
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        match self.depth {
            Depth::Value | Depth::Inner => Ok(()),
            _ => self.scalar(&Scalar::Flag(false)),
        }
    }

    fn visit_bool<E: serde::de::Error>(self, flag: bool) -> Result<(), E> {
        self.scalar(&Scalar::Flag(flag))
    }

    fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<(), E> {
        self.scalar(&Scalar::Number(number))
    }

    #[expect(clippy::cast_precision_loss, reason = "coordinates and counts are far below 2^53")]
    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    #[expect(clippy::cast_precision_loss, reason = "coordinates and counts are far below 2^53")]
    fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<(), E> {
        match word.parse() {
            // An axis of the position.
            Ok(number) if self.depth == Depth::Inner => self.scalar(&Scalar::Number(number)),
            _ => self.scalar(&Scalar::Word(word)),
        }
    }
}

/// A key of an object, kept where the parts beneath find it.
struct Key<'a> {
    file: &'a mut File,
    depth: Depth,
}

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        from.deserialize_str(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E: serde::de::Error>(self, key: &str) -> Result<(), E> {
        let into = match self.depth {
            Depth::Agents => &mut self.file.agent,
            Depth::Times => {
                self.file.secs = key.trim().parse().unwrap_or(f64::NAN);
                return Ok(());
            }
            Depth::Entry => &mut self.file.key[0],
            Depth::Value | Depth::Inner => &mut self.file.key[1],
        };
        into.clear();
        into.push_str(key);
        Ok(())
    }
}
