//! Letters with marks: a base letter, and lines over or under its middle.

const DIAERESIS: &str = "d -10 64 d 10 64";
const ACUTE: &str = "m -4 59 l 7 70";
const GRAVE: &str = "m 4 59 l -7 70";
const CIRCUMFLEX: &str = "m -11 59 l 0 69 l 11 59";
const TILDE: &str = "m -13 60 c -11 65 -8 67 -5 67 c 1 67 1 60 6 60 c 9 60 12 62 13 67";
const RING: &str = "m 0 71 h 8 64 v 0 57 h -8 64 v 0 71";
const CEDILLA: &str = "m 0 0 l -1 -6 c 4 -6 7 -9 7 -12 c 7 -17 3 -19 -5 -18";
const CARON: &str = "m -11 69 l 0 59 l 11 69";

/// Letters with the mark, and those without, in the same order.
const MARKED: &[(&str, &str, &str)] = &[
    ("äëïöüÿÄËÏÖÜ", "aeıouyAEIOU", DIAERESIS),
    ("áéíóúýćńśźÁÉÍÓÚÝ", "aeıouycnszAEIOUY", ACUTE),
    ("àèìòùÀÈÌÒÙ", "aeıouAEIOU", GRAVE),
    ("âêîôûÂÊÎÔÛ", "aeıouAEIOU", CIRCUMFLEX),
    ("ãñõÃÑÕ", "anoANO", TILDE),
    ("åůÅ", "auA", RING),
    ("çşÇŞ", "csCS", CEDILLA),
    ("čěřšžČŘŠŽ", "cerszCRSZ", CARON),
];

/// Returns the base letter and the mark of a letter that has one.
pub(super) fn parts(letter: char) -> Option<(char, &'static str)> {
    MARKED.iter().find_map(|(marked, plain, mark)| {
        let at = marked.chars().position(|c| c == letter)?;
        Some((plain.chars().nth(at)?, *mark))
    })
}

/// Returns all letters that have a mark.
pub(super) fn letters() -> impl Iterator<Item = char> {
    MARKED.iter().flat_map(|(marked, ..)| marked.chars())
}
