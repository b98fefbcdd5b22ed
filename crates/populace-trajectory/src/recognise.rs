//! Formats by their content.

use std::collections::BTreeMap;

use crate::comment;
use crate::fields::{Fields, Separator, Splitter, number, shortened};
use crate::input::Input;
use crate::{Error, Format, jpscore, menge, named, petrack, vadere};

/// Beginnings of binary files that can be read.
const BINARY: [(&[u8], Format); 2] =
    [(b"SQLite format 3\0", Format::JuPedSim), (b"\x89HDF\r\n\x1a\n", Format::Hdf5)];

/// Beginnings of binary files that cannot be read, with their names and hints.
const REFUSED_BINARY: [(&[u8], &str, &str); 10] = [
    (b"PAR1", "Parquet", "write it as CSV, for example with pandas' to_csv"),
    (b"\x93NUMPY", "a NumPy array", "write it as CSV with a line of names: id,frame,x,y"),
    (b"PK\x03\x04", "a ZIP archive", "unpack it first"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard", "decompress it first"),
    (b"\xfd7zXZ\0", "compressed by xz", "decompress it first"),
    (b"BZh", "compressed by bzip2", "decompress it first"),
    (b"\x89PNG", "a PNG picture", "name a file with the positions of people"),
    (b"\xff\xd8\xff", "a JPEG picture", "name a file with the positions of people"),
    (b"\xff\xfe", "text in UTF-16", "save it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16", "save it as UTF-8"),
];

/// Root elements of XML that cannot be read, with their names and hints.
const REFUSED_XML: [(&str, &str, &str); 4] = [
    (
        "trajectories",
        "XML of the former JuPedSim",
        "let it write plain text, or convert the file to rows of ID, FR, X, Y and Z",
    ),
    (
        "trajectoriesDataset",
        "XML of the former JuPedSim",
        "let it write plain text, or convert the file to rows of ID, FR, X, Y and Z",
    ),
    ("sumo-netstate", "SUMO's raw output", "let SUMO write --fcd-output"),
    ("netstate", "SUMO's raw output", "let SUMO write --fcd-output"),
];

/// Words by which text files are known that cannot be read, with their names and hints.
const REFUSED_TEXT: [(&[&str], &str, &str); 3] = [
    (
        &["the number of splines"],
        "splines of the UCY data set (.vsp), in pixels",
        "take obsmat.txt of the same scene, which is in metres",
    ),
    (
        &["recordingId", "trackId", "xCenter"],
        "tracks of the inD data set or its relatives",
        "their classes are in another file; write a CSV with the columns id,frame,x,y,heading",
    ),
    (&["$VEHICLE:"], "vehicles of Vissim (.fzp)", "let Viswalk record pedestrians (.pp)"),
];

/// Reasons why no format fits: what was seen, and a hint.
type Refusal = (String, String);

/// Returns the format of a file.
pub(crate) fn recognise(input: &Input) -> Result<Format, Error> {
    let head = input.head()?;
    format(&head).map_err(|(seen, remedy)| {
        let path = input.path().to_owned();
        if head.trim_ascii().is_empty() {
            Error::Empty { path }
        } else {
            Error::Unknown { path, seen, remedy }
        }
    })
}

fn refused(name: &str, hint: &str) -> Refusal {
    (format!("it is {name}"), hint.to_owned())
}

fn unknown(seen: String) -> Refusal {
    let names: Vec<_> = Format::ALL.iter().map(|(_, name, _)| *name).collect();
    let remedy = format!(
        "--format NAME reads it as one of {}; or put a line with names above the columns, such as \
         id,frame,x,y",
        names.join(", ")
    );
    (seen, remedy)
}

fn format(head: &[u8]) -> Result<Format, Refusal> {
    if let Some((_, format)) = BINARY.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Ok(*format);
    }
    if let Some((_, name, hint)) = REFUSED_BINARY.iter().find(|(m, ..)| head.starts_with(m)) {
        return Err(refused(name, hint));
    }
    if menge::is_one(head) {
        return Ok(Format::Menge);
    }
    if head.contains(&0) {
        return Err(unknown("a binary file".to_owned()));
    }
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with('<') {
        return xml(text);
    }
    if text.starts_with(['{', '[']) {
        return json(text);
    }
    for (words, name, hint) in REFUSED_TEXT {
        if words.iter().all(|word| text.contains(word)) {
            return Err(refused(name, hint));
        }
    }
    lines(text)
}

/// Returns the format of XML, by its root element.
fn xml(text: &str) -> Result<Format, Refusal> {
    let mut rest = text;
    // Declarations and comments come first.
    let root = loop {
        rest = rest.trim_start();
        let end = match rest {
            _ if rest.starts_with("<!--") => "-->",
            _ if rest.starts_with("<?") => "?>",
            _ if rest.starts_with("<!") => ">",
            _ => break rest.strip_prefix('<').unwrap_or_default(),
        };
        rest = rest.split_once(end).map_or("", |(_, rest)| rest);
    };
    let name = root.split(|c: char| c.is_whitespace() || "/>".contains(c)).next();
    let name = name.unwrap_or_default();
    if name == "fcd-export" {
        return Ok(Format::Sumo);
    }
    match REFUSED_XML.iter().find(|(root, ..)| *root == name) {
        Some((_, name, hint)) => Err(refused(name, hint)),
        None => Err(unknown(format!("XML with the root \"{}\"", shortened(name)))),
    }
}

fn json(text: &str) -> Result<Format, Refusal> {
    let first = text.lines().next().unwrap_or_default();
    if first.contains("\"scene\"") || first.contains("\"track\"") {
        return Ok(Format::TrajNetPlusPlus);
    }
    if text.contains("\"position\"") {
        return Ok(Format::PathfinderJson);
    }
    Err(unknown("JSON without the keys \"position\", \"scene\" or \"track\"".to_owned()))
}

/// Returns the format of lines of text.
fn lines(text: &str) -> Result<Format, Refusal> {
    if text.starts_with("$VISION") || text.contains("$PEDESTRIAN:") {
        return Ok(Format::Viswalk);
    }
    let comments = || text.lines().filter(|line| line.trim_start().starts_with('#'));
    let mut rows = text.lines().filter(|line| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#') && !comment::names_separator(line)
    });
    let first = rows.next().unwrap_or_default();
    let is_vadere = text.starts_with("#IDXCOL") || first.contains("-PID");
    if is_vadere || vadere::is_header(first) {
        return Ok(Format::Vadere);
    }
    if comments().any(|text| jpscore::names_columns(text) || text.contains("jpscore")) {
        return Ok(Format::Jpscore);
    }
    if comments().any(petrack::names_columns) {
        return Ok(Format::PeTrack);
    }
    let lower = first.to_lowercase();
    let has = |names: &[&str]| names.iter().all(|name| lower.contains(name));
    if has(&["name", "active", "location"]) && named::is_header(first) {
        return Ok(Format::PathfinderCsv);
    }
    if has(&["pedid", "time", "posx", "posy"]) {
        return Ok(Format::CrowdIt);
    }
    if named::is_header(first) || comments().any(named::is_header) {
        return Ok(Format::Csv);
    }
    if first.is_empty() {
        return Err(unknown("comments alone".to_owned()));
    }
    let rows: Vec<_> = std::iter::once(first).chain(rows.take(200)).collect();
    let has_rate = comments().any(|text| comment::frame_rate(text).is_some());
    if let Some(format) = by_numbers(&rows, has_rate)? {
        return Ok(format);
    }
    if let Some(problem) = named::problem_of_header(first) {
        let hint = "name the columns id, frame (or t), x and y".to_owned();
        return Err((problem, hint));
    }
    Err(unknown(format!("its first line is \"{}\"", shortened(first))))
}

/// Returns the format of rows of numbers without names, by their columns. `has_rate`: a comment
/// says the frame rate.
fn by_numbers(rows: &[&str], has_rate: bool) -> Result<Option<Format>, Refusal> {
    let mut splitter = Splitter::new(Separator::Blanks);
    // The last row may be cut off.
    let whole = &rows[..rows.len().max(2) - 1];
    let mut columns = None;
    for row in whole {
        let fields = splitter.split(row);
        if fields.len() == 10 && row.ends_with('"') {
            let hint = "positions are in pixels; write a CSV in metres with id,frame,x,y";
            return Err(refused("annotations of the Stanford Drone data set", hint));
        }
        if *columns.get_or_insert(fields.len()) != fields.len() || !are_numbers(fields) {
            return Ok(None);
        }
    }
    let mut all =
        |test: &dyn Fn(Fields<'_>) -> bool| whole.iter().all(|row| test(splitter.split(row)));
    let is_whole = |field: &str| number(field, false).fract() == 0.0;
    let begins_whole = all(&|fields| is_whole(fields.get(0)) && is_whole(fields.get(1)));
    let is_flat = all(&|fields| number(fields.get(3), false).abs() < 0.5);
    Ok(match columns {
        _ if !begins_whole => None,
        Some(4) if has_rate || begin_with_ids(whole) => Some(Format::PeTrack),
        Some(4) => Some(Format::TrajNet),
        Some(8) if is_flat => Some(Format::Obsmat),
        Some(5..=8) => Some(Format::PeTrack),
        Some(9) => Some(Format::Jpscore),
        _ => None,
    })
}

/// Returns true if rows of 4 begin with id and frame rather than with frame and id: if positions of
/// the same number in the first column follow each other more closely.
fn begin_with_ids(rows: &[&str]) -> bool {
    let mut splitter = Splitter::new(Separator::Blanks);
    let [by_first, by_second] = [0, 1].map(|column| {
        let mut last = BTreeMap::new();
        let mut lengths: Vec<f64> = Vec::new();
        for row in rows {
            let fields = splitter.split(row);
            let [x, y] = [2, 3].map(|column| number(fields.get(column), false));
            let id = number(fields.get(column), false).to_bits();
            if let Some([from_x, from_y]) = last.insert(id, [x, y]) {
                lengths.push((x - from_x).hypot(y - from_y));
            }
        }
        lengths.retain(|length| length.is_finite());
        lengths.sort_by(f64::total_cmp);
        lengths.get(lengths.len() / 2).copied().unwrap_or(f64::MAX)
    });
    by_first < by_second
}

fn are_numbers(fields: Fields<'_>) -> bool {
    fields.iter().all(|field| field == "?" || !number(field, false).is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beginnings_of_files_are_recognised() {
        let traj = "#IDXCOL=2,DATACOL=6,SEP=' '\npedestrianId simTime endTime-PID1 startX-PID1\n";
        let fcd = "\u{feff}<?xml version=\"1.0\"?>\n\n<!-- <a> -->\n<fcd-export>";
        for (head, expected) in [
            ("SQLite format 3\0", Format::JuPedSim),
            (traj, Format::Vadere),
            (traj.split_once('\n').expect("lines").1, Format::Vadere),
            (fcd, Format::Sumo),
            ("{\"0\": {\"1.0\": {\"position\": {\"x\": 1}}}}", Format::PathfinderJson),
            ("780 1 8.4 3.6\n780 2 1.4 5.8\n790 1 9.1 3.7\n790 2 1.9 5.8\n7", Format::TrajNet),
            ("1 780 8.4 3.6\n1 790 9.1 3.7\n2 780 1.4 5.8\n2 790 1.9 5.8\n2", Format::PeTrack),
            ("1 1 8.4 3.6\n2 1 9.1 3.7\n3 1 9.4 3.8\n", Format::TrajNet),
            ("#description: jpscore\n1 1 8.4 3.6 0\n2 1 9.1 3.7 0\n", Format::Jpscore),
            ("# framerate: 8\n1 1 8.4 3.6\n2 1 9.1 3.7\n", Format::PeTrack),
        ] {
            assert_eq!(format(head.as_bytes()), Ok(expected), "{head}");
        }
        assert_eq!(format(b"\x89HDF\r\n\x1a\n"), Ok(Format::Hdf5));
    }
}
