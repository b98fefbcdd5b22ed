//! Text of PeTrack and of the Jülich archive: rows of id, frame, x, y and z.

use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Frames per second of files that do not say it: those of the archive's experiments.
const ASSUMED_FPS: f64 = 25.0;

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut rows = Rows::default();
    let (mut unit, mut fps) = (Fact::assumed(Unit::Metres), Fact::assumed(ASSUMED_FPS));
    input.for_each_line(|line, number| {
        if let Some(comment) = line.trim().strip_prefix('#') {
            if comment.contains("x/cm") || comment.contains("in cm") {
                unit = Fact::of_file(Unit::Centimetres);
            } else if comment.contains("x/m") || comment.contains("in m") {
                unit = Fact::of_file(Unit::Metres);
            }
            if let Some(rate) = frame_rate(comment) {
                fps = Fact::of_file(rate);
            }
            return Ok(());
        }
        let at = Some(Location::Line(number));
        let mut fields = line.split_ascii_whitespace();
        let Some(id) = fields.next() else { return Ok(()) };
        let mut next = || fields.next().and_then(|field| field.parse::<f64>().ok());
        let (frame, x, y, z) = (next(), next(), next(), next());
        let agent = rows.agent(id);
        let [frame, x, y] = [frame, x, y].map(|value| value.unwrap_or(f64::NAN));
        rows.push(agent, frame, [x, y], at);
        let _ = z;
        Ok(())
    })?;
    let format = (Format::PeTrack, String::new());
    let found = Found { format, unit, clock: Clock::Frames(fps), place: Place::default() };
    rows.finish(found, input.path(), settings)
}

/// Returns the first number of a comment on the frame rate.
fn frame_rate(comment: &str) -> Option<f64> {
    let words = comment.split_once("framerate")?.1;
    words.split(|c: char| !(c.is_ascii_digit() || c == '.')).find_map(|word| word.parse().ok())
}
