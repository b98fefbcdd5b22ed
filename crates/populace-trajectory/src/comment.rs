//! Facts in comments.

use crate::Unit;

/// Returns true for the line by which spreadsheets note how fields are separated, such as `sep=;`.
pub(crate) fn names_separator(line: &str) -> bool {
    let sign = line.trim().to_ascii_lowercase();
    sign.strip_prefix("sep=").is_some_and(|sign| sign.chars().count() <= 1)
}

/// Returns the frame rate that a comment names: its first number after the word, perhaps with a
/// decimal comma.
pub(crate) fn frame_rate(comment: &str) -> Option<f64> {
    let lower = comment.to_lowercase();
    let (_, rest) = ["framerate", "frame rate", "fps"].iter().find_map(|w| lower.split_once(w))?;
    let words = rest.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == ','));
    words.map(|word| word.trim_matches(',')).find_map(|word| word.replace(',', ".").parse().ok())
}

/// Returns the unit of length that a comment names as `x/cm` or `in cm`.
pub(crate) fn unit(comment: &str) -> Option<Unit> {
    let names = |word: &str| {
        comment
            .match_indices(word)
            .any(|(at, _)| !comment[at + word.len()..].starts_with(|c: char| c.is_alphanumeric()))
    };
    let units: [(Unit, &[&str]); 4] = [
        (Unit::Centimetres, &["x/cm", "in cm"]),
        (Unit::Millimetres, &["x/mm", "in mm"]),
        (Unit::Feet, &["x/ft", "in ft", "in feet"]),
        (Unit::Metres, &["x/m", "in m"]),
    ];
    units.iter().find(|(_, words)| words.iter().any(|word| names(word))).map(|(unit, _)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates_are_found_in_every_spelling() {
        for comment in ["#framerate: 8.00", "# framerate: 8 fps", "# Frame rate = 8", "# fps: 8."] {
            assert_eq!(frame_rate(comment), Some(8.0), "{comment}");
        }
        assert_eq!(frame_rate("# framerate: 12,5 fps"), Some(12.5));
        assert_eq!(frame_rate("# framerate: 25, 3 cameras"), Some(25.0));
        assert_eq!(frame_rate("# frame 8"), None);
        assert_eq!(frame_rate("# framerate: unknown"), None);
    }

    #[test]
    fn units_are_found_as_words() {
        assert_eq!(unit("# id frame x/cm y/cm"), Some(Unit::Centimetres));
        assert_eq!(unit("<number> <x> [in m] <y> [in m]"), Some(Unit::Metres));
        assert_eq!(unit("# x/mm"), Some(Unit::Millimetres));
        assert_eq!(unit("# id frame x/ft y/ft"), Some(Unit::Feet));
        assert_eq!(unit("# positions in feet"), Some(Unit::Feet));
        assert_eq!(unit("# measured in my garden"), None);
    }
}
