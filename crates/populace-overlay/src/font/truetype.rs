//! The stroke font as a TrueType font: outlines around the centre lines.
//!
//! Tables are those that the OpenType specification (version 1.9) requires of TrueType outlines, as
//! far as programs that draw text read them.

use super::glyphs::Glyph;
use super::outline::Line;
use super::{DOT, STROKE, glyphs};

/// Units of the font file in one unit of the glyphs.
const FINE: f64 = 10.0;
/// Units of the font file in one size of the font.
const EM: i16 = 1000;
/// Extent above and below the base line in units of the font file.
const ASCENT: i16 = 960;
const DESCENT: i16 = -240;
/// Corners of a dot, and of half a turn at the end of a stroke.
const DOT_CORNERS: u32 = 16;
const CAP_CORNERS: u32 = 6;
/// Greatest length of a corner's point, in radii of the stroke.
const MITRE: f64 = 1.7;

/// A closed outline; its inside is to the right of its way.
type Contour = Vec<[f64; 2]>;

/// Returns the file of a TrueType font with the strokes that this crate draws text with, for
/// programs that lay out text themselves. It holds the printable characters of ASCII, and the
/// letters and signs of [`Canvas::text`](crate::Canvas::text).
#[must_use]
pub fn truetype() -> Vec<u8> {
    let letters = glyphs::letters();
    let mut glyf = Vec::new();
    let mut loca = Vec::new();
    let mut hmtx = Vec::new();
    let mut largest = [0_u16; 2];
    // The first glyph stands for characters that the font does not have.
    for letter in std::iter::once('\u{fffd}').chain(letters.iter().copied()) {
        let glyph = Glyph::of(letter);
        loca.extend(word32(glyf.len()).to_be_bytes());
        let contours = contours(&glyph);
        let points: usize = contours.iter().map(Vec::len).sum();
        largest = [largest[0].max(word(points)), largest[1].max(word(contours.len()))];
        let left = write_glyph(&mut glyf, &contours);
        hmtx.extend(word(rounded(glyph.advance()).unsigned_abs().into()).to_be_bytes());
        hmtx.extend(left.to_be_bytes());
    }
    loca.extend(word32(glyf.len()).to_be_bytes());
    let count = word(letters.len() + 1);
    file(&[
        (*b"cmap", cmap(&letters)),
        (*b"glyf", glyf),
        (*b"head", head()),
        (*b"hhea", hhea(count)),
        (*b"hmtx", hmtx),
        (*b"loca", loca),
        (*b"maxp", maxp(count, largest)),
    ])
}

/// Returns the outlines of a glyph in units of the font file.
fn contours(glyph: &Glyph) -> Vec<Contour> {
    let lines = glyph.lines();
    let shift = glyph.bearing() - super::outline::span(&lines)[0];
    let radius = 0.5 * STROKE * FINE;
    let place = |[x, y]: [f64; 2]| [(x + shift) * FINE, y * FINE];
    let mut contours = Vec::new();
    for line in lines {
        match line {
            Line::Dot(at) => contours.push(circle(place(at), DOT * radius)),
            Line::Path(points) => {
                let points: Vec<_> = points.into_iter().map(place).collect();
                contours.extend(around(&points, radius));
            }
        }
    }
    contours
}

fn circle(at: [f64; 2], radius: f64) -> Contour {
    let corner = |nth: u32| {
        let angle = -std::f64::consts::TAU * f64::from(nth) / f64::from(DOT_CORNERS);
        [at[0] + radius * angle.cos(), at[1] + radius * angle.sin()]
    };
    (0..DOT_CORNERS).map(corner).collect()
}

/// Returns the outlines of a stroke along points: one with round ends, or two if it is closed.
fn around(points: &[[f64; 2]], radius: f64) -> Vec<Contour> {
    let mut path: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for point in points {
        if path.last().is_none_or(|last| distance(*last, *point) > 1e-6) {
            path.push(*point);
        }
    }
    let [Some(first), Some(last)] = [path.first().copied(), path.last().copied()] else {
        return Vec::new();
    };
    if path.len() == 1 {
        return vec![circle(first, radius)];
    }
    let is_closed = path.len() > 2 && distance(first, last) < 1e-6;
    if is_closed {
        path.pop();
    }
    let back: Vec<_> = path.iter().rev().copied().collect();
    let [out, home] = [path, back].map(|path| side(&path, radius, is_closed));
    if is_closed { vec![out, home] } else { vec![[out, home].concat()] }
}

/// Returns the left side of a stroke, with a round end if it is open.
fn side(path: &[[f64; 2]], radius: f64, is_closed: bool) -> Contour {
    let count = path.len();
    let direction = |from: [f64; 2], to: [f64; 2]| {
        let length = distance(from, to);
        [(to[0] - from[0]) / length, (to[1] - from[1]) / length]
    };
    let mut contour = Vec::new();
    for (nth, point) in path.iter().enumerate() {
        let before = (nth > 0 || is_closed).then(|| path[(nth + count - 1) % count]);
        let after = (nth + 1 < count || is_closed).then(|| path[(nth + 1) % count]);
        let [came, goes] =
            [before.map(|p| direction(p, *point)), after.map(|p| direction(*point, p))];
        match (came, goes) {
            (Some(came), Some(goes)) => corner(&mut contour, *point, [came, goes], radius),
            (None, Some(goes)) => contour.push(offset(*point, left(goes), radius)),
            (Some(came), None) => cap(&mut contour, *point, came, radius),
            (None, None) => {}
        }
    }
    contour
}

/// Adds the points of a corner: one where the sides of both strokes meet, or two that cut its point
/// off.
fn corner(contour: &mut Contour, at: [f64; 2], [came, goes]: [[f64; 2]; 2], radius: f64) {
    let [a, b] = [left(came), left(goes)];
    let sum = [a[0] + b[0], a[1] + b[1]];
    // Twice the squared cosine of half the turn.
    let cosine = 1.0 + a[0] * b[0] + a[1] * b[1];
    let turns_left = came[0] * goes[1] - came[1] * goes[0] > 0.0;
    let reach = if cosine > 1e-3 { (2.0 / cosine).sqrt() } else { f64::INFINITY };
    if turns_left && reach < 6.0 || reach < MITRE {
        contour.push([at[0] + radius * sum[0] / cosine, at[1] + radius * sum[1] / cosine]);
    } else {
        contour.extend([offset(at, a, radius), offset(at, b, radius)]);
    }
}

/// Adds the round end of a stroke, from its left to its right side.
fn cap(contour: &mut Contour, at: [f64; 2], came: [f64; 2], radius: f64) {
    let across = left(came);
    for nth in 0..=CAP_CORNERS {
        let angle = std::f64::consts::PI * f64::from(nth) / f64::from(CAP_CORNERS);
        let (sine, cosine) = angle.sin_cos();
        let way = [0, 1].map(|i| across[i] * cosine + came[i] * sine);
        contour.push(offset(at, way, radius));
    }
}

fn left([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

fn offset(at: [f64; 2], way: [f64; 2], by: f64) -> [f64; 2] {
    [at[0] + by * way[0], at[1] + by * way[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Appends a glyph, and returns its least x.
fn write_glyph(glyf: &mut Vec<u8>, contours: &[Contour]) -> i16 {
    let points: Vec<[i16; 2]> =
        contours.iter().flatten().map(|[x, y]| [*x / FINE, *y / FINE].map(rounded)).collect();
    let (Some(low), Some(high)) = (
        points.iter().copied().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]),
        points.iter().copied().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]),
    ) else {
        return 0;
    };
    glyf.extend(word(contours.len()).to_be_bytes());
    glyf.extend([low, high].into_iter().flatten().flat_map(i16::to_be_bytes));
    let mut end = 0;
    for contour in contours {
        end += contour.len();
        glyf.extend(word(end - 1).to_be_bytes());
    }
    // No instructions. Each point is on the outline, and its coordinates take two bytes.
    glyf.extend(0_u16.to_be_bytes());
    glyf.extend(points.iter().map(|_| 1_u8));
    for axis in [0, 1] {
        let mut last = 0;
        for point in &points {
            glyf.extend(point[axis].wrapping_sub(last).to_be_bytes());
            last = point[axis];
        }
    }
    while !glyf.len().is_multiple_of(4) {
        glyf.push(0);
    }
    low[0]
}

/// Maps characters to glyphs: a segment of one character each (format 4).
fn cmap(letters: &[char]) -> Vec<u8> {
    let codes: Vec<u16> =
        letters.iter().filter_map(|letter| u16::try_from(u32::from(*letter)).ok()).collect();
    let segments = codes.len() + 1;
    let power = 1_usize << segments.ilog2();
    let mut table = Vec::new();
    let mut push = |value: usize| table.extend(word(value).to_be_bytes());
    [0, 1, 3, 1, 0, 12].into_iter().for_each(&mut push);
    [4, 16 + 8 * segments, 0, 2 * segments, 2 * power].into_iter().for_each(&mut push);
    [power.ilog2() as usize, 2 * (segments - power)].into_iter().for_each(&mut push);
    let each = |push: &mut dyn FnMut(usize)| {
        codes.iter().for_each(|code| push(usize::from(*code)));
        push(0xffff);
    };
    each(&mut push);
    push(0);
    each(&mut push);
    for (nth, code) in codes.iter().enumerate() {
        push(usize::from(word(nth + 1).wrapping_sub(*code)));
    }
    push(1);
    (0..segments).for_each(|_| push(0));
    table
}

fn head() -> Vec<u8> {
    let mut table = Vec::new();
    table.extend([0, 1, 0, 0, 0, 1, 0, 0]);
    table.extend([0; 4]);
    table.extend(0x5f0f_3cf5_u32.to_be_bytes());
    table.extend(0_u16.to_be_bytes());
    table.extend(EM.to_be_bytes());
    table.extend([0; 16]);
    table.extend([0, DESCENT, EM, ASCENT].into_iter().flat_map(i16::to_be_bytes));
    // No style, smallest size in pixels, left to right, long offsets, outlines as they are.
    table.extend([0_i16, 8, 2, 1, 0].into_iter().flat_map(i16::to_be_bytes));
    table
}

fn hhea(count: u16) -> Vec<u8> {
    let mut table = vec![0, 1, 0, 0];
    table.extend([ASCENT, DESCENT, 0, EM].into_iter().flat_map(i16::to_be_bytes));
    table.extend([0; 22]);
    table.extend(count.to_be_bytes());
    table
}

fn maxp(count: u16, [points, contours]: [u16; 2]) -> Vec<u8> {
    let mut table = vec![0, 1, 0, 0];
    table.extend([count, points, contours, 0, 0, 1].into_iter().flat_map(u16::to_be_bytes));
    table.extend([0; 16]);
    table
}

/// Puts tables together, which are in the order of their tags.
fn file(tables: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
    let power = 1_usize << tables.len().ilog2();
    let mut file = vec![0, 1, 0, 0];
    let sizes = [tables.len(), 16 * power, power.ilog2() as usize, 16 * (tables.len() - power)];
    file.extend(sizes.into_iter().flat_map(|size| word(size).to_be_bytes()));
    let mut at = file.len() + 16 * tables.len();
    for (tag, table) in tables {
        file.extend(tag);
        file.extend(checksum(table).to_be_bytes());
        file.extend([at, table.len()].into_iter().flat_map(|v| word32(v).to_be_bytes()));
        at += table.len().next_multiple_of(4);
    }
    for (_, table) in tables {
        file.extend(table);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    file
}

fn checksum(table: &[u8]) -> u32 {
    table.chunks(4).fold(0, |sum: u32, bytes| {
        let mut word = [0; 4];
        word[..bytes.len()].copy_from_slice(bytes);
        sum.wrapping_add(u32::from_be_bytes(word))
    })
}

fn word(value: usize) -> u16 {
    u16::try_from(value).unwrap_or(u16::MAX)
}

fn word32(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// Returns a length in units of the font file.
fn rounded(units: f64) -> i16 {
    #[expect(clippy::cast_possible_truncation, reason = "glyphs are below 3,000 units")]
    let rounded = (units * FINE).round() as i16;
    rounded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::font::text_width;

    fn u16_at(bytes: &[u8], at: usize) -> usize {
        usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]]))
    }

    fn u32_at(bytes: &[u8], at: usize) -> usize {
        u16_at(bytes, at) << 16 | u16_at(bytes, at + 2)
    }

    fn table<'a>(file: &'a [u8], tag: &[u8]) -> &'a [u8] {
        let entries = file[12..].chunks(16).take(u16_at(file, 4));
        let entry = entries.into_iter().find(|entry| &entry[..4] == tag).expect("a table");
        &file[u32_at(entry, 8)..][..u32_at(entry, 12)]
    }

    /// Returns the glyph of a character by the map of format 4.
    fn glyph_of(cmap: &[u8], letter: char) -> usize {
        let map = &cmap[12..];
        let segments = u16_at(map, 6) / 2;
        let code = letter as usize;
        let segment =
            (0..segments).find(|nth| u16_at(map, 14 + 2 * nth) >= code).expect("a segment");
        let start = u16_at(map, 16 + 2 * segments + 2 * segment);
        let delta = u16_at(map, 16 + 4 * segments + 2 * segment);
        if start > code { 0 } else { (code + delta) & 0xffff }
    }

    #[test]
    fn characters_are_found_and_as_wide_as_text() {
        let file = truetype();
        let (cmap, hmtx, loca) =
            (table(&file, b"cmap"), table(&file, b"hmtx"), table(&file, b"loca"));
        for letter in (' '..='~').chain("äÅç×…".chars()) {
            let glyph = glyph_of(cmap, letter);
            let width = text_width(&letter.to_string(), f64::from(EM));
            #[expect(clippy::cast_precision_loss, reason = "below 65,536")]
            let advance = u16_at(hmtx, 4 * glyph) as f64;
            assert!(glyph > 0 && (advance - width).abs() <= 0.5, "{letter}: {advance}, {width}");
            let has_outline = u32_at(loca, 4 * glyph + 4) > u32_at(loca, 4 * glyph);
            assert_eq!(has_outline, letter != ' ', "{letter}");
        }
        assert_eq!(glyph_of(cmap, '語'), 0);
    }

    /// What is to the right of its way is inside: contours that turn right have a negative area.
    #[test]
    fn outlines_enclose_their_strokes() {
        for (letter, counts) in [('l', 1), ('O', 2), ('i', 2), ('T', 2)] {
            let contours = contours(&Glyph::of(letter));
            assert_eq!(contours.len(), counts, "{letter}");
            let area: f64 = contours
                .iter()
                .map(|c| {
                    let next = c.iter().cycle().skip(1);
                    c.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>() / 2.0
                })
                .sum();
            assert!(area < -10_000.0, "{letter}: {area}");
        }
    }
}
