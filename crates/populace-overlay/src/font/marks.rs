//! Letters with marks: a base letter, and lines over or under its middle.

const DIAERESIS: &str = "d -10 64 d 10 64";
const ACUTE: &str = "m -4 59 l 7 70";
const GRAVE: &str = "m 4 59 l -7 70";
const CIRCUMFLEX: &str = "m -11 59 l 0 69 l 11 59";
const TILDE: &str = "m -13 60 c -11 65 -8 67 -5 67 c 1 67 1 60 6 60 c 9 60 12 62 13 67";
const RING: &str = "m 0 71 h 8 64 v 0 57 h -8 64 v 0 71";
const CEDILLA: &str = "m 0 0 l -1 -6 c 4 -6 7 -9 7 -12 c 7 -17 3 -19 -5 -18";
const CARON: &str = "m -11 69 l 0 59 l 11 69";

const BREVE: &str = "m -11 69 c -10 62 -5 59 0 59 c 5 59 10 62 11 69";
const DOT: &str = "d 0 64";
const DOUBLE_ACUTE: &str = "m -8 59 l -2 70 m 6 59 l 12 70";
const MACRON: &str = "m -11 64 l 11 64";
const OGONEK: &str = "m 4 0 c -1 -5 -3 -9 -2 -13 c 0 -18 5 -19 9 -16";
const COMMA: &str = "m 1 -9 l -3 -19";

/// Marks under letters, which capitals have where small letters have them.
const UNDER: [&str; 3] = [CEDILLA, OGONEK, COMMA];

/// Letters with the mark, and those without, in the same order.
const MARKED: &[(&str, &str, &str)] = &[
    ("äëïöüÿÄËÏÖÜŸ", "aeıouyAEIOUY", DIAERESIS),
    ("áéíóúýćńśźÁÉÍÓÚÝĆŃŚŹ", "aeıouycnszAEIOUYCNSZ", ACUTE),
    ("àèìòùÀÈÌÒÙ", "aeıouAEIOU", GRAVE),
    ("âêîôûÂÊÎÔÛ", "aeıouAEIOU", CIRCUMFLEX),
    ("ãñõÃÑÕ", "anoANO", TILDE),
    ("åůÅŮ", "auAU", RING),
    ("çşÇŞ", "csCS", CEDILLA),
    ("čěňřšžČĎĚŇŘŠŤŽ", "cenrszCDENRSTZ", CARON),
    ("ăğĂĞ", "agAG", BREVE),
    ("ėżĖİŻ", "ezEIZ", DOT),
    ("őűŐŰ", "ouOU", DOUBLE_ACUTE),
    ("āēīūĀĒĪŪ", "aeıuAEIU", MACRON),
    ("ąęįųĄĘĮŲ", "aeiuAEIU", OGONEK),
    ("șțķļņȘȚĶĻŅ", "stklnSTKLN", COMMA),
];

/// Returns the base letter of a letter that has a mark, the mark, and how far it rises over that of
/// a small letter.
pub(super) fn parts(letter: char) -> Option<(char, &'static str, f64)> {
    MARKED.iter().find_map(|(marked, plain, mark)| {
        let at = marked.chars().position(|c| c == letter)?;
        let base = plain.chars().nth(at)?;
        let rises = base.is_uppercase() && !UNDER.contains(mark);
        Some((base, *mark, if rises { 19.0 } else { 0.0 }))
    })
}

/// Returns all letters that have a mark.
pub(super) fn letters() -> impl Iterator<Item = char> {
    MARKED.iter().flat_map(|(marked, ..)| marked.chars())
}
