//! Text of TrajNet: rows of frame, id, x and y, in metres.

use crate::fields::{Separator, Splitter, is_missing, number, whole_id};
use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::steps::Steps;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Rows of an agent in a second.
const ROWS_PER_SEC: f64 = 2.5;

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let (mut rows, mut steps) = (Rows::default(), Steps::default());
    let mut splitter = Splitter::new(Separator::Blanks);
    let mut buffer = String::new();
    input.for_each_line(|line, number_of_line| {
        let fields = splitter.split(line);
        let is_row = fields.len() > 0 && !fields.get(0).starts_with('#');
        // A question mark stands for a position that is to be predicted.
        if !is_row || [2, 3].iter().any(|column| fields.get(*column) == "?") {
            return Ok(());
        }
        let place = Some(Location::Line(number_of_line));
        let [frame, x, y] = [0, 2, 3].map(|column| number(fields.get(column), false));
        if is_missing(fields.get(1)) {
            rows.leave_out("rows without an id were left out", place);
            return Ok(());
        }
        let agent = rows.agent(whole_id(fields.get(1), &mut buffer));
        rows.push(agent, frame, [x, y], place);
        steps.take(agent, frame);
        Ok(())
    })?;
    let (unit, place) = (Fact::of_file(Unit::Metres), Place::default());
    let clock = Clock::Frames(Fact::assumed(steps.usual() * ROWS_PER_SEC));
    let format = (Format::TrajNet, String::new());
    rows.finish(Found { format, unit, clock, place }, input.path(), settings)
}
