//! The glyphs.

use super::marks;
use super::outline::{self, Line};

/// A glyph.
pub(super) struct Glyph {
    /// Space before the first and after the last stroke's middle, in units.
    bearings: [f64; 2],
    /// The lines in the notation of `outline`.
    notation: &'static str,
    /// A mark over or under the letter, with where it goes.
    mark: Option<(&'static str, [f64; 2])>,
}

/// Width of a digit in units. Equal, so that a clock that runs stands still.
const DIGIT: f64 = 58.0;
const SPACE: f64 = 28.0;
/// Space on either side of each glyph, added to its own, in units.
const TRACKING: f64 = 1.2;

impl Glyph {
    /// Returns the glyph of a character; an empty box for one that the font does not have.
    pub(super) fn of(letter: char) -> Self {
        if letter == ' ' || letter == '\u{a0}' {
            return Self { bearings: [SPACE, 0.0], notation: "", mark: None };
        }
        if let Some((base, mark)) = marks::parts(letter) {
            let mut glyph = Self::of(base);
            let lines = outline::lines(glyph.notation, [0.0; 2]);
            let span = outline::span(&lines);
            let rise = if base.is_uppercase() { 19.0 } else { 0.0 };
            glyph.mark = Some((mark, [0.5 * (span[0] + span[1]), rise]));
            return glyph;
        }
        let found = GLYPHS.iter().find(|(letters, ..)| letters.contains(letter));
        let (_, bearings, notation) = *found.unwrap_or(&UNKNOWN);
        let bearings = bearings.map(|b| f64::from(b) + TRACKING);
        let mut glyph = Self { bearings, notation, mark: None };
        if letter.is_ascii_digit() {
            let span = outline::span(&glyph.lines());
            let free = 0.5 * (DIGIT - (span[1] - span[0]));
            let shift = if letter == '1' { -2.0 } else { 0.0 };
            glyph.bearings = [free + shift, free - shift];
        }
        glyph
    }

    /// Space before the first stroke's middle in units.
    pub(super) fn bearing(&self) -> f64 {
        self.bearings[0]
    }

    /// Returns the lines in units.
    pub(super) fn lines(&self) -> Vec<Line> {
        let mut lines = outline::lines(self.notation, [0.0; 2]);
        if let Some((mark, at)) = self.mark {
            lines.extend(outline::lines(mark, at));
        }
        lines
    }

    /// Returns the way to the next glyph in units.
    pub(super) fn advance(&self) -> f64 {
        let span = outline::span(&self.lines());
        self.bearings[0] + (span[1] - span[0]) + self.bearings[1]
    }
}

type Entry = (&'static str, [i8; 2], &'static str);

const UNKNOWN: Entry = ("", [9, 9], "m 0 0 l 0 66 l 36 66 l 36 0 l 0 0");

/// Characters that share a glyph, the space before and after, and the lines.
const GLYPHS: &[Entry] = &[
    ("A", [5, 5], "m 0 0 l 25 66 l 50 0 m 9 24 l 41 24"),
    ("B", [10, 8], "m 0 0 l 0 66 l 21 66 h 38 50 v 21 34 l 0 34 m 21 34 h 42 17 v 21 0 l 0 0"),
    ("C", [8, 6], "m 47 54 c 43 62 36 66 27 66 h 0 33 v 27 0 c 36 0 43 4 47 12"),
    ("D", [10, 8], "m 0 0 l 0 66 l 19 66 h 47 33 v 19 0 l 0 0"),
    ("E", [10, 6], "m 37 66 l 0 66 l 0 0 l 37 0 m 0 34 l 33 34"),
    ("F", [10, 5], "m 36 66 l 0 66 l 0 0 m 0 34 l 32 34"),
    ("G", [8, 9], "m 47 55 c 43 62 36 66 27 66 h 0 33 v 27 0 c 40 0 49 9 49 22 l 49 34 l 29 34"),
    ("H", [10, 10], "m 0 0 l 0 66 m 45 0 l 45 66 m 0 34 l 45 34"),
    ("I", [10, 10], "m 0 0 l 0 66"),
    ("J", [5, 10], "m 27 66 l 27 17 v 12 0 c 6 0 2 3 0 8"),
    ("K", [10, 4], "m 0 0 l 0 66 m 41 66 l 0 24 m 14 38.3 l 43 0"),
    ("L", [10, 5], "m 0 66 l 0 0 l 35 0"),
    ("M", [10, 10], "m 0 0 l 0 66 l 27 18 l 54 66 l 54 0"),
    ("N", [10, 10], "m 0 0 l 0 66 l 45 0 l 45 66"),
    ("O", [8, 8], "m 27 66 h 54 33 v 27 0 h 0 33 v 27 66"),
    ("P", [10, 6], "m 0 0 l 0 66 l 23 66 h 41 50 v 23 34 l 0 34 m 0 34 l 23 34"),
    ("Q", [8, 8], "m 27 66 h 54 33 v 27 0 h 0 33 v 27 66 m 34 16 l 52 -4"),
    ("R", [10, 5], "m 0 0 l 0 66 l 23 66 h 41 50 v 23 34 l 0 34 m 22 34 l 43 0"),
    (
        "S",
        [7, 7],
        "m 41 56 c 37 63 30 66 22 66 c 10 66 2 59 2 49.5 c 2 39 11 36.5 22 34 \
         c 33 31.5 43 28 43 17 \
         c 43 7 34 0 22 0 c 12 0 4 4 0 11",
    ),
    ("T", [4, 4], "m 0 66 l 48 66 m 24 66 l 24 0"),
    ("U", [9, 9], "m 0 66 l 0 22 v 23 0 h 46 22 l 46 66"),
    ("V", [4, 4], "m 0 66 l 24 0 l 48 66"),
    ("W", [5, 5], "m 0 66 l 17 0 l 36 66 l 55 0 l 72 66"),
    ("X", [5, 5], "m 0 66 l 44 0 m 44 66 l 0 0"),
    ("Y", [4, 4], "m 0 66 l 23 31 l 46 66 m 23 31 l 23 0"),
    ("Z", [6, 6], "m 1 66 l 43 66 l 0 0 l 44 0"),
    (
        "a",
        [7, 9],
        "m 3 39 c 7 45 12 47 18 47 h 34 32 l 34 0 m 34 26 l 17 26 h 0 13 v 15 0 c 24 0 31 4 34 12",
    ),
    ("b", [9, 7], "m 0 70 l 0 0 m 0 23.5 v 20 47 h 39 23.5 v 20 0 h 0 23.5"),
    ("c", [7, 5], "m 36 38 c 33 44 27 47 20 47 h 0 23.5 v 20 0 c 27 0 33 3 36 9"),
    ("d", [7, 9], "m 39 70 l 39 0 m 39 23.5 v 19 47 h 0 23.5 v 19 0 h 39 23.5"),
    ("e", [7, 6], "m 0 26 l 39 26 c 39 39 31 47 20 47 h 0 23.5 v 20.5 0 c 27 0 33 3 37 9"),
    ("f", [4, 3], "m 27 70 l 24 70 h 10 56 l 10 0 m 0 47 l 25 47"),
    (
        "g",
        [7, 9],
        "m 39 47 l 39 -2 v 20 -19 c 12 -19 6 -17 3 -13 m 39 23.5 v 19 47 h 0 23.5 v 19 0 h 39 23.5",
    ),
    ("h", [9, 9], "m 0 70 l 0 0 m 0 26 v 19 47 h 36 29 l 36 0"),
    ("i", [9, 9], "m 0 47 l 0 0 d 0 65"),
    ("ı", [9, 9], "m 0 47 l 0 0"),
    ("j", [2, 9], "m 12 47 l 12 -8 v 1 -19 l 0 -19 d 12 65"),
    ("k", [9, 3], "m 0 70 l 0 0 m 32 47 l 0 17 m 11 27.3 l 34 0"),
    ("l", [9, 4], "m 0 70 l 0 11 v 10 0 l 12 0"),
    ("m", [9, 9], "m 0 47 l 0 0 m 0 27 v 16 47 h 30 31 l 30 0 m 30 27 v 46 47 h 60 31 l 60 0"),
    ("n", [9, 9], "m 0 47 l 0 0 m 0 26 v 19 47 h 36 29 l 36 0"),
    ("o", [7, 7], "m 20 47 h 40 23.5 v 20 0 h 0 23.5 v 20 47"),
    ("p", [9, 7], "m 0 47 l 0 -19 m 0 23.5 v 20 47 h 39 23.5 v 20 0 h 0 23.5"),
    ("q", [7, 9], "m 39 47 l 39 -19 m 39 23.5 v 19 47 h 0 23.5 v 19 0 h 39 23.5"),
    ("r", [9, 3], "m 0 47 l 0 0 m 0 25 v 18 47 l 23 47"),
    (
        "s",
        [6, 6],
        "m 31 39 c 28 44 23 47 17 47 c 8 47 2 42 2 35 c 2 27 9 25.5 17 24 c 26 22 33 20 33 12 \
         c 33 5 26 0 17 0 c 9 0 3 3 0 9",
    ),
    ("t", [4, 4], "m 10 61 l 10 14 v 22 0 l 25 0 m 0 47 l 24 47"),
    ("u", [9, 9], "m 0 47 l 0 18 v 17 0 h 36 21 m 36 47 l 36 0"),
    ("v", [4, 4], "m 0 47 l 18 0 l 36 47"),
    ("w", [5, 5], "m 0 47 l 14 0 l 29 47 l 44 0 l 58 47"),
    ("x", [5, 5], "m 0 47 l 34 0 m 34 47 l 0 0"),
    ("y", [4, 4], "m 0 47 l 18.5 1 m 37 47 l 16 -9 c 13 -16 9 -19 2 -19"),
    ("z", [6, 6], "m 1 47 l 33 47 l 0 0 l 34 0"),
    ("ß", [9, 7], "m 0 0 l 0 52 v 18 70 h 35 54 v 22 39 h 41 19 v 22 0 l 14 0"),
    ("0", [0, 0], "m 20 66 h 40 33 v 20 0 h 0 33 v 20 66"),
    ("1", [0, 0], "m 0 51 l 18 66 l 18 0"),
    ("2", [0, 0], "m 1 50 c 3 60 10 66 20 66 c 31 66 38 59 38 49 c 38 40 32 34 26 27 l 0 0 l 40 0"),
    (
        "3",
        [0, 0],
        "m 2 55 c 6 63 12 66 19 66 h 37 50 v 20 34 l 13 34 m 20 34 h 40 17 v 19 0 c 10 0 3 5 0 13",
    ),
    ("4", [0, 0], "m 31 0 l 31 66 l 0 18 l 43 18"),
    ("5", [0, 0], "m 36 66 l 6 66 l 3 34 c 7 39 13 42 20 42 h 40 21 v 19 0 c 10 0 3 4 0 12"),
    ("6", [0, 0], "m 29 66 c 16 55 0 40 0 20.5 v 20 0 h 40 20.5 v 20 41 h 0 20.5"),
    ("7", [0, 0], "m 0 66 l 40 66 l 14 0"),
    ("8", [0, 0], "m 20 66 h 37 50 v 20 34 h 3 50 v 20 66 m 20 34 h 40 17 v 20 0 h 0 17 v 20 34"),
    ("9", [0, 0], "m 11 0 c 24 11 40 26 40 45.5 v 20 66 h 0 45.5 v 20 25 h 40 45.5"),
    (".", [9, 9], "d 0 1"),
    (",", [9, 9], "m 4 2 l 0 -10"),
    (":", [10, 10], "d 0 1 d 0 43"),
    (";", [9, 9], "m 4 2 l 0 -10 d 4 43"),
    ("!", [10, 10], "m 0 66 l 0 21 d 0 1"),
    (
        "?",
        [6, 6],
        "m 0 53 c 2 61 9 66 17 66 c 27 66 34 60 34 50 c 34 41 28 37 23 32 c 19 28 17 25 17 19 \
         d 17 1",
    ),
    ("'’‘", [8, 8], "m 0 66 l 0 50"),
    ("\"”“", [8, 8], "m 0 66 l 0 50 m 14 66 l 14 50"),
    ("-", [7, 7], "m 0 26 l 21 26"),
    ("–", [7, 7], "m 0 26 l 38 26"),
    ("—", [7, 7], "m 0 26 l 66 26"),
    ("−", [8, 8], "m 0 34 l 40 34"),
    ("+", [8, 8], "m 0 34 l 40 34 m 20 14 l 20 54"),
    ("=", [8, 8], "m 0 26 l 40 26 m 0 44 l 40 44"),
    ("*", [6, 6], "m 13 66 l 13 40 m 2 59.5 l 24 46.5 m 24 59.5 l 2 46.5"),
    ("/", [4, 4], "m 0 -8 l 27 72"),
    ("\\", [4, 4], "m 0 72 l 27 -8"),
    ("|", [11, 11], "m 0 74 l 0 -12"),
    ("_", [2, 2], "m 0 -9 l 46 -9"),
    ("(", [9, 5], "m 14 74 c 4 63 0 49 0 31 c 0 13 4 -1 14 -12"),
    (")", [5, 9], "m 0 74 c 10 63 14 49 14 31 c 14 13 10 -1 0 -12"),
    ("[", [10, 5], "m 13 74 l 0 74 l 0 -12 l 13 -12"),
    ("]", [5, 10], "m 0 74 l 13 74 l 13 -12 l 0 -12"),
    ("{", [5, 5], "m 18 74 l 16 74 h 8 64 l 8 41 v 0 31 h 8 21 l 8 -2 v 16 -12 l 18 -12"),
    ("}", [5, 5], "m 0 74 l 2 74 h 10 64 l 10 41 v 18 31 h 10 21 l 10 -2 v 2 -12 l 0 -12"),
    ("<", [8, 8], "m 38 54 l 0 34 l 38 14"),
    (">", [8, 8], "m 0 54 l 38 34 l 0 14"),
    ("#", [6, 6], "m 17 66 l 9 0 m 37 66 l 29 0 m 3 47 l 46 47 m 0 18 l 43 18"),
    (
        "$",
        [7, 7],
        "m 41 56 c 37 63 30 66 22 66 c 10 66 2 59 2 49.5 c 2 39 11 36.5 22 34 \
         c 33 31.5 43 28 43 17 \
         c 43 7 34 0 22 0 c 12 0 4 4 0 11 m 22 75 l 22 -9",
    ),
    (
        "%",
        [6, 6],
        "m 12 66 h 24 52 v 12 38 h 0 52 v 12 66 m 50 28 h 62 14 v 50 0 h 38 14 v 50 28 m 49 66 \
         l 13 0",
    ),
    (
        "&",
        [7, 4],
        "m 47 0 l 12 46 c 4 57 10 66 20 66 c 30 66 36 57 29 47 c 26 43 20 39 14 36 \
         c 4 31 0 25 0 17 \
         c 0 7 8 0 19 0 c 31 0 41 10 43 28",
    ),
    (
        "@",
        [8, 8],
        "m 43 42 l 43 20 c 43 14 46 11 50 11 c 57 11 61 19 61 29 v 31 62 h 0 27 v 31 -8 \
         c 39 -8 45 -6 50 -3 m 43 27 v 30 42 h 17 27 v 30 12 h 43 27",
    ),
    ("^", [6, 6], "m 0 47 l 17 66 l 34 47"),
    ("~", [7, 7], "m 0 29 c 2 36 6 39 11 39 c 19 39 22 28 30 28 c 35 28 39 31 41 38"),
    ("`", [8, 8], "m 0 70 l 10 58"),
    ("°", [6, 6], "m 10 66 h 20 56 v 10 46 h 0 56 v 10 66"),
    ("·", [9, 9], "d 0 30"),
    ("×", [8, 8], "m 0 50 l 32 18 m 32 50 l 0 18"),
    ("µμ", [9, 9], "m 0 47 l 0 -19 m 0 18 v 17 0 h 36 21 m 36 47 l 36 0"),
    (
        "²",
        [6, 6],
        "m 0 59 c 1 63 5 66 10 66 c 16 66 20 63 20 58 c 20 53 16 49 12 45 l 0 34 l 22 34",
    ),
    (
        "³",
        [6, 6],
        "m 1 61 c 3 65 6 66 10 66 c 16 66 19 63 19 59 c 19 54 15 51 9 51 c 16 51 21 48 21 43 \
         c 21 37 16 34 10 34 c 5 34 2 36 0 40",
    ),
    ("…", [9, 9], "d 0 1 d 20 1 d 40 1"),
];

/// Returns all characters that have a glyph, in their order.
pub(super) fn letters() -> Vec<char> {
    let own = GLYPHS.iter().flat_map(|(letters, ..)| letters.chars());
    let mut letters: Vec<char> = own.chain(marks::letters()).chain([' ', '\u{a0}']).collect();
    letters.sort_unstable();
    letters.dedup();
    letters
}
