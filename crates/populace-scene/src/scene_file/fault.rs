//! Values of scene files that are refused, and the lines on which they stand.

use std::borrow::Cow;
use std::ops::Range;

use populace::model::{did_you_mean, nearest_names};
use toml::de::{DeTable, DeValue};

use super::{SceneFileError, line};

/// A value that is refused.
pub(super) struct Fault {
    key: Cow<'static, str>,
    /// The tables around the value, from the innermost on. One of a list has a number from 0 on.
    around: Vec<(&'static str, Option<usize>)>,
    rule: String,
}

impl Fault {
    /// The value of a key, which must be as a rule says.
    pub(super) fn of(key: impl Into<Cow<'static, str>>, rule: impl Into<String>) -> Self {
        Self { key: key.into(), around: Vec::new(), rule: rule.into() }
    }

    /// Puts a table around the value. Dots stand between the names of several.
    pub(super) fn within(mut self, table: &'static str) -> Self {
        self.around.push((table, None));
        self
    }

    /// Puts a table of a list around the value.
    pub(super) fn nth(mut self, table: &'static str, nth: usize) -> Self {
        self.around.push((table, Some(nth)));
        self
    }

    pub(super) fn message(&self) -> String {
        format!("{} must be {}", self.place(), self.rule)
    }

    /// Returns the value's key and the tables around it.
    fn place(&self) -> String {
        let Self { key, around, .. } = self;
        let mut of = String::new();
        for (table, _) in around.split_last().map_or(&[][..], |(_, inner)| inner) {
            of += &format!(" of `{table}`");
        }
        of += &match around.last() {
            Some((table, Some(_))) => format!(" of a [[{table}]]"),
            Some((table, None)) => format!(" of [{table}]"),
            None => String::new(),
        };
        format!("`{key}`{of}")
    }

    /// Finds the line of a value that is refused for a reason which only its use shows.
    pub(super) fn because(&self, text: &str, reason: &str) -> SceneFileError {
        let message = format!("{}: {reason}", self.place());
        SceneFileError { message, ..self.at_its_line(text) }
    }

    /// Finds the line of the value, or of the table around it if it is not written there.
    pub(super) fn at_its_line(&self, text: &str) -> SceneFileError {
        let span = DeTable::parse(text).ok().and_then(|root| self.span(root.get_ref()));
        SceneFileError { line: line(text, span.unwrap_or_default()), message: self.message() }
    }

    /// Returns where the innermost of the tables and the value is written that is.
    fn span(&self, root: &DeTable<'_>) -> Option<Range<usize>> {
        let (mut table, mut span) = (Some(root), None);
        let own = (self.key.as_ref(), None);
        for (names, nth) in self.around.iter().rev().copied().chain([own]) {
            for name in names.split('.') {
                let Some(mut value) = table.and_then(|table| table.get(name)) else { return span };
                if let (DeValue::Array(all), Some(nth)) = (value.get_ref(), nth) {
                    value = all.get(nth)?;
                }
                span = Some(value.span());
                table = value.get_ref().as_table();
            }
        }
        span
    }
}

/// Returns the first fault of the entries of a list of tables.
pub(super) fn first_of<'a, T: 'a>(
    table: &'static str,
    all: impl IntoIterator<Item = &'a T>,
    check: impl Fn(&'a T) -> Option<Fault>,
) -> Option<Fault> {
    let mut all = all.into_iter().enumerate();
    all.find_map(|(nth, one)| check(one).map(|fault| fault.nth(table, nth)))
}

/// Returns the first fault.
pub(super) fn first(faults: impl IntoIterator<Item = Option<Fault>>) -> Option<Fault> {
    faults.into_iter().flatten().next()
}

/// Returns the innermost key whose value is written at a place of a file's text.
pub(super) fn key_at(text: &str, at: usize) -> Option<String> {
    fn within(value: &DeValue<'_>, at: usize) -> Option<String> {
        match value {
            DeValue::Table(table) => of_table(table, at),
            DeValue::Array(all) => all.iter().find_map(|one| within(one.get_ref(), at)),
            _ => None,
        }
    }
    // Tables with headers span their headers alone.
    fn of_table(table: &DeTable<'_>, at: usize) -> Option<String> {
        table.iter().find_map(|(key, value)| {
            let own = value.span().contains(&at).then(|| key.get_ref().to_string());
            within(value.get_ref(), at).or(own)
        })
    }
    of_table(DeTable::parse(text).ok()?.get_ref(), at)
}

/// Says that a name is not among those that are known.
pub(super) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let known: Vec<&str> = known.into_iter().collect();
    if known.contains(&name) {
        return None;
    }
    let nearest = nearest_names(name, known.iter().copied());
    let remedy = match nearest.is_empty() && !known.is_empty() {
        true => format!("; there are {}", known.join(", ")),
        false => did_you_mean(&nearest),
    };
    Some(format!("{what}, and none is \"{name}\"{remedy}"))
}
