//! `.scb` of Menge: frames of the same number of agents, in single precision, little-endian.

use std::io::{BufRead, Read};

use crate::input::Input;
use crate::rows::{Clock, Found, Rows};
use crate::{Error, Fact, Format, Location, Place, ReadSettings, Recording, Unit};

/// Seconds between frames where the file does not say it, as in Menge by default.
const ASSUMED_SECS: f32 = 0.1;
/// Files with more agents are taken to be something else.
const MOST_AGENTS: u32 = 1 << 24;

/// The meaning of one number of an agent in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    X,
    Y,
    Elevation,
    /// An angle in radians.
    Heading,
    HeadingX,
    HeadingY,
    Extra(&'static str),
}

use Part::{Elevation, Extra, Heading, HeadingX, HeadingY, X, Y};

/// Versions, and the numbers of an agent in each frame.
const VERSIONS: &[((u8, u8), &[Part])] = &[
    ((1, 0), &[X, Y, Heading]),
    ((2, 0), &[X, Y, Heading]),
    ((2, 1), &[X, Y, Heading, Extra("state")]),
    (
        (2, 2),
        &[
            X,
            Y,
            Heading,
            Extra("state"),
            Extra("preferred_vx"),
            Extra("preferred_vy"),
            Extra("vx"),
            Extra("vy"),
        ],
    ),
    ((2, 3), &[X, Y, HeadingX, HeadingY]),
    ((2, 4), &[X, Elevation, Y, Heading]),
];

/// The bytes before the frames.
struct Header {
    version: (u8, u8),
    parts: &'static [Part],
    secs: Option<f32>,
    classes: Vec<u32>,
    /// Its length in bytes.
    bytes: u64,
}

/// Returns true if bytes begin as such a file does.
pub(crate) fn is_one(head: &[u8]) -> bool {
    match head {
        [major @ b'0'..=b'9', b'.', minor @ b'0'..=b'9', 0, a, b, c, d, ..] => {
            let agents = u32::from_le_bytes([*a, *b, *c, *d]);
            parts((major - b'0', minor - b'0')).is_some() && (1..=MOST_AGENTS).contains(&agents)
        }
        _ => false,
    }
}

fn parts(version: (u8, u8)) -> Option<&'static [Part]> {
    VERSIONS.iter().find(|(known, _)| *known == version).map(|(_, parts)| *parts)
}

pub(crate) fn read(input: &Input, settings: &ReadSettings) -> Result<Recording, Error> {
    let mut from = input.open()?;
    let header = header(input, &mut *from)?;
    let mut rows = Rows::default();
    let class = rows.add_numbers("class");
    let extras: Vec<_> = (header.parts.iter())
        .map(|part| match part {
            Extra(name) => rows.add_numbers(name),
            _ => 0,
        })
        .collect();
    let agents: Vec<_> =
        (0..header.classes.len()).map(|index| rows.agent(&index.to_string())).collect();
    let per_agent = 4 * header.parts.len();
    let mut bytes = Vec::new();
    for frame in 0_u32.. {
        let at = header.bytes + u64::from(frame) * (per_agent * agents.len()) as u64;
        bytes.clear();
        let length = (per_agent * agents.len()) as u64;
        (&mut from).take(length).read_to_end(&mut bytes).map_err(input.unreadable())?;
        if bytes.len() as u64 != length {
            if !bytes.is_empty() {
                let text = "the last frame is cut off and was left out".to_owned();
                rows.warnings.row(&text, Some(Location::Byte(at)));
            }
            break;
        }
        for (index, values) in bytes.chunks_exact(per_agent).enumerate() {
            let values = values.as_chunks().0;
            take(&mut rows, agents[index], frame, header.parts, values, &extras);
            rows.set_number(class, f64::from(header.classes[index]));
        }
    }
    let secs = header.secs.map_or_else(|| Fact::assumed(ASSUMED_SECS), Fact::of_file);
    let fps = Fact { value: 1.0 / f64::from(secs.value), origin: secs.origin };
    let version = format!("version {}.{}", header.version.0, header.version.1);
    let (unit, place) = (Fact::of_file(Unit::Metres), Place::default());
    let (format, clock) = ((Format::Menge, version), Clock::Frames(fps));
    rows.finish(Found { format, unit, clock, place }, input.path(), settings)
}

/// Adds the row of an agent in a frame.
fn take(
    rows: &mut Rows,
    agent: u32,
    frame: u32,
    parts: &[Part],
    values: &[[u8; 4]],
    extras: &[usize],
) {
    let value = |part| {
        let value = parts.iter().zip(values).find(|(p, _)| **p == part);
        value.map(|(_, bytes)| f64::from(f32::from_le_bytes(*bytes)))
    };
    let at = [X, Y].map(|part| value(part).unwrap_or(f64::NAN));
    rows.push(agent, f64::from(frame), at, Some(Location::Row(u64::from(frame) + 1)));
    if let Some(elevation) = value(Elevation) {
        rows.set_elevation(elevation);
    }
    if let Some(angle) = value(Heading) {
        rows.set_heading(angle);
    }
    if let (Some(x), Some(y)) = (value(HeadingX), value(HeadingY)) {
        rows.set_heading_vector([x, y]);
    }
    for (column, part) in extras.iter().zip(parts) {
        if let (Extra(_), Some(value)) = (part, value(*part)) {
            rows.set_number(*column, value);
        }
    }
}

fn header(input: &Input, from: &mut dyn BufRead) -> Result<Header, Error> {
    let mut bytes = 0;
    let mut read = |count: u64, what: &str| {
        let at = Some(Location::Byte(bytes));
        let mut part = Vec::new();
        from.take(count).read_to_end(&mut part).map_err(input.unreadable())?;
        bytes += count;
        if part.len() as u64 == count {
            return Ok(part);
        }
        Err(input.malformed(at, format!("the file ends within {what}; write it again")))
    };
    let version = read(4, "the version")?;
    let known = match version[..] {
        [major, b'.', minor, 0] => {
            let version = (major.wrapping_sub(b'0'), minor.wrapping_sub(b'0'));
            parts(version).map(|parts| (version, parts))
        }
        _ => None,
    };
    let Some((version, parts)) = known else {
        let problem = "the version is none of 1.0 and 2.0 to 2.4; write it with Menge's default";
        return Err(input.malformed(Some(Location::Byte(0)), problem));
    };
    let count = number(&read(4, "the number of agents")?);
    if !(1..=MOST_AGENTS).contains(&count) {
        let problem = format!("{count} agents are not possible; is the file little-endian?");
        return Err(input.malformed(Some(Location::Byte(4)), problem));
    }
    let secs = if version.0 == 1 {
        None
    } else {
        Some(f32::from_bits(number(&read(4, "the time of a frame")?)))
    };
    if let Some(secs) = secs.filter(|secs| !(secs.is_finite() && *secs > 0.0)) {
        let problem = format!("frames of {secs} s are not possible");
        return Err(input.malformed(Some(Location::Byte(8)), problem));
    }
    let classes = read(u64::from(count) * 4, "the classes of agents")?;
    let classes = classes.chunks_exact(4).map(number).collect();
    Ok(Header { version, parts, secs, classes, bytes })
}

/// Returns the number in the first 4 bytes.
fn number(bytes: &[u8]) -> u32 {
    bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
