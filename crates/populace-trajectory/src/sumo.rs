//! Floating car data of SUMO: XML of time steps with vehicles and persons.

use std::borrow::Cow;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use crate::extra::Extras;
use crate::fields::seconds;
use crate::input::Input;
use crate::recording::Kind;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

mod lines;

use lines::Lines;

/// Attributes that are words even where they look like numbers.
const WORDS: [&str; 9] =
    ["type", "edge", "lane", "vehicle", "arrivalLane", "departLane", "leaderID", "stopEdge", "tag"];
/// Agents that move at less than this part of the speed that their file states have coordinates in
/// degrees: a degree is some 100 km.
const LEAST_PART: f64 = 0.01;
/// Metres that a file's agents must have gone, by their stated speeds, for that to be a test.
const LEAST_WAY_M: f64 = 2.0;

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut reader = Reader::from_reader(Lines::new(input.open()?));
    let mut file = Fcd::default();
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = reader.read_event_into(&mut buffer);
        let line = reader.get_mut().end_event();
        match event {
            Ok(Event::Eof) if file.root == Root::Open => file.cut_off(line),
            Ok(Event::Eof) => break,
            Ok(event) => file
                .take(&event, line)
                .map_err(|problem| input.malformed(Some(Location::Line(line)), problem))?,
            // Files of simulations that were stopped end anywhere.
            Err(_) if file.rows.len() > 0 && reader.get_mut().is_at_end() => file.cut_off(line),
            Err(error) => {
                let problem = format!("the XML is broken: {error}");
                return Err(input.malformed(Some(Location::Line(line)), problem));
            }
        }
        if file.root == Root::Closed {
            break;
        }
    }
    if file.root == Root::Missing {
        return Err(input.malformed(None, "has no element fcd-export, so SUMO did not write it"));
    }
    if file.is_in_degrees() {
        return Err(input.malformed(None, IN_DEGREES));
    }
    let found = Found {
        format: (Format::Sumo, String::new()),
        unit: Fact::of_file(Unit::Metres),
        clock: Clock::Seconds,
        place: Place::default(),
    };
    file.rows.finish(found, input.path(), settings)
}

const IN_DEGREES: &str = "its positions are longitudes and latitudes; let SUMO write it without \
                          --fcd-output.geo, so that they are in metres";

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum Root {
    #[default]
    Missing,
    Open,
    Closed,
}

#[derive(Default)]
struct Fcd {
    rows: Rows,
    root: Root,
    /// The time of the open time step; nothing if it has none or none is open.
    secs: Option<f64>,
    /// The id of the open vehicle, in which persons ride.
    vehicle: Option<String>,
    extras: Extras,
    /// Last time and position of each agent.
    last: Vec<Option<(f64, [f64; 2])>>,
    /// The way of all agents in units of the file, and by their speeds in metres.
    ways: [f64; 2],
}

impl Fcd {
    /// Takes the next part of the file. Returns what is wrong with it as a whole.
    fn take(&mut self, event: &Event<'_>, line: u64) -> Result<(), String> {
        match event {
            Event::Start(element) => self.start(element, line)?,
            Event::Empty(element) => {
                self.start(element, line)?;
                self.end(element.name().0);
            }
            Event::End(element) => self.end(element.name().0),
            // SUMO writes its configuration as a comment.
            Event::Comment(comment) => {
                let is_set = |line: &str| {
                    line.contains("fcd-output.geo ")
                        && ["\"true\"", "\"1\"", "\"yes\"", "\"on\"", "\"t\"", "\"x\""]
                            .iter()
                            .any(|word| line.contains(word))
                };
                if comment.lines().any(is_set) {
                    return Err(IN_DEGREES.to_owned());
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn start(&mut self, element: &BytesStart<'_>, line: u64) -> Result<(), String> {
        let name = element.name().0;
        if self.root == Root::Missing {
            if name != "fcd-export" {
                return Err(format!("\"{name}\" is no root of SUMO's fcd-export"));
            }
            self.root = Root::Open;
            return Ok(());
        }
        match name {
            "timestep" => {
                let secs = attribute(element, "time").map(|time| seconds(time.trim(), false));
                self.secs = secs.filter(|secs| !secs.is_nan());
            }
            "vehicle" => {
                self.add(element, Kind::Vehicle, line);
                self.vehicle = attribute(element, "id");
            }
            "person" => self.add(element, Kind::Person, line),
            _ => {}
        }
        Ok(())
    }

    fn end(&mut self, name: &str) {
        match name {
            "fcd-export" => self.root = Root::Closed,
            "timestep" => self.secs = None,
            "vehicle" => self.vehicle = None,
            _ => {}
        }
    }

    /// Adds a row.
    fn add(&mut self, element: &BytesStart<'_>, kind: Kind, line: u64) {
        let at = Some(Location::Line(line));
        let attributes: Vec<_> = attributes(element).collect();
        let text = |wanted: &str| {
            attributes.iter().find(|(name, _)| *name == wanted).map_or("", |(_, value)| value)
        };
        let number = |name: &str| text(name).parse().unwrap_or(f64::NAN);
        if text("id").is_empty() {
            self.rows.leave_out("persons and vehicles without an id were left out", at);
            return;
        }
        let agent = self.rows.agent_of(kind, text("id"));
        let (secs, position) = (self.secs.unwrap_or(f64::NAN), [number("x"), number("y")]);
        if !self.rows.push(agent, secs, position, at) {
            return;
        }
        self.measure(agent, secs, position, number("speed"));
        let (z, angle) = (number("z"), number("angle"));
        if z.is_finite() {
            self.rows.set_elevation(z);
        }
        if angle.is_finite() {
            self.rows.set_heading(wrapped(90.0 - angle).to_radians());
        }
        self.set_extras(&attributes, kind);
    }

    /// Keeps the attributes without a meaning of their own as columns, and the vehicle in which a
    /// person rides.
    fn set_extras(&mut self, attributes: &[(&str, Cow<'_, str>)], kind: Kind) {
        for (name, value) in attributes {
            if ["id", "x", "y", "z", "angle"].contains(name) {
                continue;
            }
            let Some(column) = self.extras.index(name, &mut self.rows) else { continue };
            let column = self.extras.get(column);
            if WORDS.contains(name) {
                column.set_word(&mut self.rows, value);
            } else {
                column.set_text(&mut self.rows, value);
            }
        }
        if let (Kind::Person, Some(vehicle)) = (kind, &self.vehicle)
            && let Some(column) = self.extras.index("vehicle", &mut self.rows)
        {
            self.extras.get(column).set_word(&mut self.rows, vehicle);
        }
    }

    /// Adds to the ways by positions and by speeds.
    fn measure(&mut self, agent: u32, secs: f64, at: [f64; 2], speed: f64) {
        let index = agent as usize;
        self.last.resize(self.last.len().max(index + 1), None);
        if let Some((last_secs, last)) = self.last[index].replace((secs, at))
            && speed.is_finite()
        {
            self.ways[0] += (at[0] - last[0]).hypot(at[1] - last[1]);
            self.ways[1] += speed.abs() * (secs - last_secs).abs();
        }
    }

    fn is_in_degrees(&self) -> bool {
        self.ways[1] > LEAST_WAY_M && self.ways[0] < LEAST_PART * self.ways[1]
    }

    fn cut_off(&mut self, line: u64) {
        self.root = Root::Closed;
        self.rows.warnings.whole(format!("the file is cut off in line {line}"));
    }
}

/// Returns the attributes of an element that can be read.
fn attributes<'a>(element: &'a BytesStart<'_>) -> impl Iterator<Item = (&'a str, Cow<'a, str>)> {
    let mut attributes = element.attributes();
    // Looking for twins takes long where there are many attributes.
    attributes.with_checks(false);
    attributes.flatten().filter_map(|attribute| {
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?;
        Some((attribute.key.0, value))
    })
}

fn attribute(element: &BytesStart<'_>, wanted: &str) -> Option<String> {
    attributes(element).find(|(name, _)| *name == wanted).map(|(_, value)| value.into_owned())
}

/// Returns an angle in degrees within -180 and 180.
fn wrapped(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_wrapped() {
        assert_eq!(wrapped(90.0 - 0.0), 90.0);
        assert_eq!(wrapped(90.0 - 335.5), 114.5);
        assert_eq!(wrapped(90.0 - 270.0), -180.0);
    }
}
