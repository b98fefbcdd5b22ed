//! Fields of a line of text.

use std::ops::Range;

/// A separator of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separator {
    /// Any number of blanks and tabs.
    Blanks,
    /// One of this sign. Fields may be in double quotes, which then are not part of them.
    Sign(u8),
}

/// Splits lines without memory of its own for each.
pub(crate) struct Splitter {
    separator: Separator,
    ranges: Vec<Range<usize>>,
}

/// The fields of one line.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'a> {
    line: &'a str,
    ranges: &'a [Range<usize>],
}

impl Splitter {
    pub(crate) fn new(separator: Separator) -> Self {
        Self { separator, ranges: Vec::new() }
    }

    /// Returns the fields of a line, without blanks around them.
    pub(crate) fn split<'a>(&'a mut self, line: &'a str) -> Fields<'a> {
        self.ranges.clear();
        match self.separator {
            Separator::Blanks => {
                let start = line.as_ptr().addr();
                self.ranges.extend(line.split_ascii_whitespace().map(|field| {
                    let from = field.as_ptr().addr() - start;
                    from..from + field.len()
                }));
            }
            Separator::Sign(sign) => split_signs(line, sign, &mut self.ranges),
        }
        Fields { line, ranges: &self.ranges }
    }
}

/// Splits at a sign outside double quotes.
fn split_signs(line: &str, sign: u8, ranges: &mut Vec<Range<usize>>) {
    let bytes = line.as_bytes();
    let (mut from, mut opened, mut quoted) = (0, false, false);
    for (at, byte) in bytes.iter().enumerate() {
        if *byte == b'"' {
            // A quote within a word is a letter, for example that of inches.
            opened = opened || line[from..at].trim().is_empty();
            quoted = opened && !quoted;
        } else if *byte == sign && !quoted {
            ranges.push(trimmed(line, from..at));
            (from, opened) = (at + 1, false);
        }
    }
    ranges.push(trimmed(line, from..bytes.len()));
}

/// Returns a field without the blanks and quotes around it.
fn trimmed(line: &str, range: Range<usize>) -> Range<usize> {
    let field = &line[range.clone()];
    let from = range.start + (field.len() - field.trim_start().len());
    let until = from + field.trim().len();
    let is_quoted = line[from..until].len() >= 2
        && line[from..until].starts_with('"')
        && line[from..until].ends_with('"');
    if is_quoted { from + 1..until - 1 } else { from..until }
}

impl<'a> Fields<'a> {
    /// Returns a field; nothing if the line has fewer.
    pub(crate) fn get(self, index: usize) -> &'a str {
        self.ranges.get(index).map_or("", |range| &self.line[range.clone()])
    }

    pub(crate) fn len(self) -> usize {
        self.ranges.len()
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = &'a str> {
        self.ranges.iter().map(move |range| &self.line[range.clone()])
    }
}

/// Returns the number in a field, or NaN. A comma between digits is a decimal point if asked for.
pub(crate) fn number(field: &str, decimal_comma: bool) -> f64 {
    if let Ok(number) = field.parse() {
        return number;
    }
    let mut bytes = [0; 40];
    let Some(bytes) = bytes.get_mut(..field.len()).filter(|_| decimal_comma) else {
        return f64::NAN;
    };
    bytes.copy_from_slice(field.as_bytes());
    for byte in &mut *bytes {
        if *byte == b',' {
            *byte = b'.';
        }
    }
    std::str::from_utf8(bytes).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

/// Returns the seconds of a time, or NaN: seconds alone, or days, hours, minutes and seconds with
/// colons between. A comma is a decimal point if asked for.
pub(crate) fn seconds(field: &str, decimal_comma: bool) -> f64 {
    const PARTS: [f64; 4] = [1.0, 60.0, 3600.0, 86400.0];
    let mut all = 0.0;
    for (index, part) in field.rsplit(':').enumerate() {
        all += PARTS.get(index).map_or(f64::NAN, |secs| secs * number(part, decimal_comma));
    }
    all
}

/// Returns true if a field says that there is no value.
pub(crate) fn is_missing(field: &str) -> bool {
    const WORDS: [&str; 7] = ["", "?", "-", "nan", "na", "null", "none"];
    WORDS.iter().any(|word| field.eq_ignore_ascii_case(word))
}

/// Returns an id without the fraction that programs add to whole numbers: `7` for `7.0` and for
/// `7.000e+00`.
pub(crate) fn whole_id<'a>(id: &'a str, buffer: &'a mut String) -> &'a str {
    use std::fmt::Write;

    if !id.contains('.') {
        return id;
    }
    match id.parse::<f64>() {
        Ok(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
            buffer.clear();
            // Writing to a string cannot fail.
            let _ = write!(buffer, "{number}");
            buffer
        }
        _ => id,
    }
}

/// Returns the beginning of a text of the file, fit for a message.
pub(crate) fn shortened(text: &str) -> String {
    const LONGEST: usize = 48;
    let printable = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let mut short: String = printable.take(LONGEST).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str, separator: Separator) -> Vec<String> {
        Splitter::new(separator).split(line).iter().map(str::to_owned).collect()
    }

    #[test]
    fn quotes_guard_separators_and_are_removed() {
        let fields = split("1,\"Hall, north\", x ,,\"\"", Separator::Sign(b','));
        assert_eq!(fields, ["1", "Hall, north", "x", "", ""]);
        assert_eq!(split(r#""a ""b"", c",d"#, Separator::Sign(b','))[1], "d");
        assert_eq!(split("6' 2\";b", Separator::Sign(b';')), ["6' 2\"", "b"]);
        assert_eq!(split(" a\t b ", Separator::Blanks), ["a", "b"]);
    }

    #[test]
    fn an_open_quote_ends_with_its_line() {
        assert_eq!(split("1,\"x,2", Separator::Sign(b',')), ["1", "\"x,2"]);
    }

    #[test]
    fn a_comma_is_decimal_only_if_asked_for() {
        assert_eq!(number("1,5", true), 1.5);
        assert!(number("1,5", false).is_nan());
        assert!(number("1,5,2", true).is_nan());
        assert!(number(&"1".repeat(60).replace("11", "1,"), true).is_nan());
    }

    #[test]
    fn times_with_colons_are_seconds() {
        assert_eq!(seconds("12.50", false), 12.5);
        assert_eq!(seconds("01:02:03.5", false), 3723.5);
        assert_eq!(seconds("00:01:02,5", true), 62.5);
        assert_eq!(seconds("1:00:00:00", false), 86400.0);
        for other in ["1:0:0:0:0", "noon", "", "::", "1:-", "2024-01-01T00:00:01"] {
            assert!(seconds(other, false).is_nan(), "{other}");
        }
    }

    #[test]
    fn whole_ids_lose_their_fraction() {
        let mut buffer = String::new();
        for (id, whole) in [("7.000e+00", "7"), ("7.0", "7"), ("7.5", "7.5"), ("A.1", "A.1")] {
            assert_eq!(whole_id(id, &mut buffer), whole);
        }
    }
}
