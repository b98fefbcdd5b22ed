//! Areas as well-known text: `POLYGON`, `MULTIPOLYGON` and `GEOMETRYCOLLECTION`.

use std::fmt;

use crate::Polygon;

/// Collections may hold collections, so deep.
const DEEPEST: usize = 32;
/// Coordinates are nearer to the origin than this.
const FARTHEST: f64 = 1e9;

/// The reason why a text is no area.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WktError {
    /// The byte at which it fails, counted from 0.
    pub(crate) at: usize,
    pub(crate) problem: String,
}

impl fmt::Display for WktError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at byte {} of the WKT", self.problem, self.at)
    }
}

/// Returns the polygons of a text that holds one or several geometries. Coordinates beyond x and y
/// are left out.
pub(crate) fn polygons(text: &str) -> Result<Vec<Polygon>, WktError> {
    let mut parser = Parser { text, at: 0, found: Vec::new() };
    parser.skip_reference_system();
    loop {
        parser.geometry(DEEPEST)?;
        while parser.take(';') {}
        if parser.peek().is_none() {
            break;
        }
    }
    if parser.found.is_empty() {
        return Err(parser.error("no polygon"));
    }
    Ok(parser.found)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    found: Vec<Polygon>,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn error(&self, problem: impl Into<String>) -> WktError {
        WktError { at: self.at, problem: problem.into() }
    }

    /// Returns the next character that is no space.
    fn peek(&mut self) -> Option<char> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start().len();
        self.rest().chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let is_next = self.peek() == Some(wanted);
        self.at += if is_next { wanted.len_utf8() } else { 0 };
        is_next
    }

    fn expect(&mut self, wanted: char) -> Result<(), WktError> {
        if self.take(wanted) {
            return Ok(());
        }
        let found = self.peek().map_or("the end".to_owned(), |c| format!("\"{c}\""));
        Err(self.error(format!("\"{wanted}\" expected, {found} found")))
    }

    fn word(&mut self) -> &'a str {
        self.peek();
        let rest = self.rest();
        let word = &rest[..rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    /// Skips `SRID=4326;`, with which some programs begin.
    fn skip_reference_system(&mut self) {
        let starts = self.text.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("SRID="));
        if let Some(end) = self.text.find(';').filter(|_| starts) {
            self.at = end + 1;
        }
    }

    fn geometry(&mut self, deepest: usize) -> Result<(), WktError> {
        self.peek();
        let start = self.at;
        let kind = self.word().to_ascii_uppercase();
        if !matches!(&*kind, "POLYGON" | "MULTIPOLYGON" | "GEOMETRYCOLLECTION") || deepest == 0 {
            self.at = start;
            return Err(self.error(match &*kind {
                "" => "the name of a geometry expected".to_owned(),
                _ if deepest == 0 => "too many collections within collections".to_owned(),
                _ => format!("{kind} is no area; POLYGON and MULTIPOLYGON are"),
            }));
        }
        // `POLYGON Z (...)` and `POLYGON EMPTY`, in any order that programs write.
        while self.peek().is_some_and(|c| c.is_ascii_alphabetic()) {
            let start = self.at;
            match &*self.word().to_ascii_uppercase() {
                "EMPTY" => return Ok(()),
                "Z" | "M" | "ZM" => {}
                _ => {
                    self.at = start;
                    return Err(self.error("\"(\" expected"));
                }
            }
        }
        match &*kind {
            "POLYGON" => self.polygon(),
            "MULTIPOLYGON" => self.list(Self::polygon),
            _ => self.list(|parser| parser.geometry(deepest - 1)),
        }
    }

    /// Reads parts between parentheses, with commas between them.
    fn list(
        &mut self,
        mut part: impl FnMut(&mut Self) -> Result<(), WktError>,
    ) -> Result<(), WktError> {
        self.expect('(')?;
        part(self)?;
        while self.take(',') {
            part(self)?;
        }
        self.expect(')')
    }

    fn polygon(&mut self) -> Result<(), WktError> {
        let mut rings = Vec::new();
        self.list(|parser| {
            rings.push(parser.ring()?);
            Ok(())
        })?;
        let mut rings = rings.into_iter();
        let outline = rings.next().unwrap_or_default();
        self.found.push(Polygon { outline, holes: rings.collect() });
        Ok(())
    }

    fn ring(&mut self) -> Result<Vec<[f64; 2]>, WktError> {
        self.peek();
        let start = self.at;
        let mut points: Vec<[f64; 2]> = Vec::new();
        self.list(|parser| {
            let point = [parser.number()?, parser.number()?];
            while parser.peek().is_some_and(|c| c != ',' && c != ')') {
                parser.number()?;
            }
            if points.last() != Some(&point) {
                points.push(point);
            }
            Ok(())
        })?;
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        if points.len() < 3 {
            self.at = start;
            return Err(self.error("a ring with fewer than 3 points"));
        }
        Ok(points)
    }

    fn number(&mut self) -> Result<f64, WktError> {
        self.peek();
        let rest = self.rest();
        let ends = |c: char| c.is_whitespace() || matches!(c, ',' | '(' | ')');
        let word = &rest[..rest.find(ends).unwrap_or(rest.len())];
        let number = word.parse().ok().filter(|v: &f64| v.abs() < FARTHEST).ok_or_else(|| {
            let short: String = word.chars().take(20).collect();
            self.error(format!("a number expected, \"{short}\" found"))
        })?;
        self.at += word.len();
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{WktError, polygons};

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(POLYGON|MULTI|[ (),;Z]|[0-9.e-]{1,4}|é){0,40}") {
            match polygons(&text) {
                Ok(found) => {
                    prop_assert!(found.iter().all(|polygon| polygon.outline.len() > 2));
                }
                Err(error) => prop_assert!(error.at <= text.len()),
            }
        }
    }

    fn problem(text: &str) -> (usize, String) {
        let WktError { at, problem } = polygons(text).unwrap_err();
        (at, problem)
    }

    #[test]
    fn holes_follow_the_outline() {
        let found = polygons(
            "POLYGON ((0 8, 0 0, 18 0, 18 8, 0 8), (10 3.4, 10.4 3.4, 1.04e1 1e-2, 10 3.4))",
        )
        .unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].outline, [[0.0, 8.0], [0.0, 0.0], [18.0, 0.0], [18.0, 8.0]]);
        assert_eq!(found[0].holes, [[[10.0, 3.4], [10.4, 3.4], [10.4, 0.01]]]);
    }

    #[test]
    fn collections_and_several_geometries_give_all_their_polygons() {
        let square = "((0 0,1 0,1 1,0 1,0 0))";
        let text = format!(
            "SRID=4326;geometrycollection(POLYGON{square}, MULTIPOLYGON ({square},{square}),\n\
             GEOMETRYCOLLECTION (POLYGON Z((0 0 5, 1 0 5, 1 1 5))), POLYGON EMPTY);\n\
             Polygon{square}\n"
        );
        let found = polygons(&text).unwrap();
        assert_eq!(found.len(), 5);
        assert_eq!(found[3].outline, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    }

    #[test]
    fn problems_name_the_byte() {
        let expected = |at: usize, text: &str| (at, text.to_owned());
        assert_eq!(
            problem("POLYGON ((0 0, 1 x, 1 1))"),
            expected(17, "a number expected, \"x\" found")
        );
        assert_eq!(
            problem("POLYGON ((0 0, NaN 1, 1 1))"),
            expected(15, "a number expected, \"NaN\" found")
        );
        assert_eq!(
            problem("POLYGON ((0 0, 1 0, 0 0))"),
            expected(9, "a ring with fewer than 3 points")
        );
        assert_eq!(
            problem("POLYGON ((0 0, 1 0, 1 1)"),
            expected(24, "\")\" expected, the end found")
        );
        assert_eq!(
            problem("LINESTRING (0 0, 1 1)"),
            expected(0, "LINESTRING is no area; POLYGON and MULTIPOLYGON are")
        );
        assert_eq!(problem("POLYGON EMPTY"), expected(13, "no polygon"));
        assert_eq!(problem(""), expected(0, "the name of a geometry expected"));
        let deep = "GEOMETRYCOLLECTION(".repeat(100_000);
        assert_eq!(problem(&deep).1, "too many collections within collections");
    }
}
