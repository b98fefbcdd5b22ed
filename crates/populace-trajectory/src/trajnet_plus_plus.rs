//! Lines of JSON of TrajNet++: scenes, and rows of frame, pedestrian, x and y in metres.

use serde::Deserialize;

use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::steps::Steps;
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Rows of an agent in a second, where no scene says it.
const ROWS_PER_SEC: f64 = 2.5;

#[derive(Deserialize)]
struct Line {
    scene: Option<Scene>,
    track: Option<Track>,
}

#[derive(Deserialize)]
struct Scene {
    fps: Option<f64>,
}

#[derive(Deserialize)]
struct Track {
    f: f64,
    p: f64,
    x: Option<f64>,
    y: Option<f64>,
    /// The number of a prediction; observed rows have none.
    #[serde(alias = "pred_number")]
    prediction_number: Option<f64>,
}

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let (mut rows, mut steps) = (Rows::default(), Steps::default());
    let (mut rate, mut id, mut rates_differ) = (None, String::new(), false);
    input.for_each_line(|line, number| {
        let place = Some(Location::Line(number));
        if line.trim().is_empty() {
            return Ok(());
        }
        let Ok(line) = serde_json::from_str::<Line>(line) else {
            rows.leave_out("lines that are no scene or track were left out", place);
            return Ok(());
        };
        if let Some(fps) = line.scene.and_then(|scene| scene.fps) {
            rates_differ |= *rate.get_or_insert(fps) != fps;
        }
        let Some(track) = line.track else { return Ok(()) };
        if track.prediction_number.is_some() {
            rows.warnings.row("rows of predictions were left out", place);
            return Ok(());
        }
        // Numbers that are not finite are written as null.
        let (Some(x), Some(y)) = (track.x, track.y) else { return Ok(()) };
        id.clear();
        // Writing to a string cannot fail.
        let _ = std::fmt::Write::write_fmt(&mut id, format_args!("{}", track.p));
        let agent = rows.agent(&id);
        rows.push(agent, track.f, [x, y], place);
        steps.take(agent, track.f);
        Ok(())
    })?;
    if rates_differ {
        rows.warnings.whole("scenes have different frame rates; that of the first was taken");
    }
    // The rate of a scene is that of its rows, while frames are those of the video.
    let fps = rate.map_or_else(|| Fact::assumed(ROWS_PER_SEC), Fact::of_file);
    let clock = Clock::Frames(Fact { value: fps.value * steps.usual(), ..fps });
    let (unit, place) = (Fact::of_file(Unit::Metres), Place::default());
    let format = (Format::TrajNetPlusPlus, String::new());
    rows.finish(Found { format, unit, clock, place }, input.path(), settings)
}
