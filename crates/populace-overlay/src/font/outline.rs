//! Centre lines of glyphs from their short notation.
//!
//! A glyph is a list of commands with coordinates in units, x to the right and y up:
//! `m x y` begins a line, `l x y` draws straight, `h x y` draws a quarter of an ellipse that leaves
//! horizontally and arrives vertically, `v x y` one that leaves vertically and arrives horizontally,
//! `c x y x y x y` draws a cubic curve, and `d x y` a dot.

/// Pieces of a curve.
const PIECES: u32 = 10;
/// Distance of the control points of a quarter of an ellipse, as part of the radius. That of an
/// ellipse is 0.552; a little more makes rounds somewhat square.
const ROUND: f64 = 0.575;

/// A line of a glyph.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Line {
    /// Points that strokes connect.
    Path(Vec<[f64; 2]>),
    /// A dot.
    Dot([f64; 2]),
}

/// Returns the lines of a glyph in the notation of this file, moved by `by`. Reads as far as the
/// notation holds.
pub(super) fn lines(notation: &str, by: [f64; 2]) -> Vec<Line> {
    let mut words = notation.split_ascii_whitespace();
    let mut lines = Vec::new();
    let mut path: Vec<[f64; 2]> = Vec::new();
    while let Some(command) = words.next() {
        let mut point = || -> Option<[f64; 2]> {
            let (x, y) = (words.next()?.parse::<f64>().ok()?, words.next()?.parse::<f64>().ok()?);
            Some([x + by[0], y + by[1]])
        };
        let Some(to) = point() else { break };
        let from = path.last().copied().unwrap_or(to);
        match command {
            "m" => {
                lines.extend(finished(&mut path));
                path.push(to);
            }
            "l" => path.push(to),
            "h" => {
                let a = [from[0] + ROUND * (to[0] - from[0]), from[1]];
                let b = [to[0], to[1] + ROUND * (from[1] - to[1])];
                curve(&mut path, [from, a, b, to]);
            }
            "v" => {
                let a = [from[0], from[1] + ROUND * (to[1] - from[1])];
                let b = [to[0] + ROUND * (from[0] - to[0]), to[1]];
                curve(&mut path, [from, a, b, to]);
            }
            "c" => {
                let (Some(b), Some(end)) = (point(), point()) else { break };
                curve(&mut path, [from, to, b, end]);
            }
            "d" => lines.push(Line::Dot(to)),
            _ => break,
        }
    }
    lines.extend(finished(&mut path));
    lines
}

fn finished(path: &mut Vec<[f64; 2]>) -> Option<Line> {
    (!path.is_empty()).then(|| Line::Path(std::mem::take(path)))
}

fn curve(path: &mut Vec<[f64; 2]>, [a, b, c, d]: [[f64; 2]; 4]) {
    for piece in 1..=PIECES {
        let t = f64::from(piece) / f64::from(PIECES);
        let s = 1.0 - t;
        path.push([0, 1].map(|i| {
            s * s * s * a[i] + 3.0 * s * s * t * b[i] + 3.0 * s * t * t * c[i] + t * t * t * d[i]
        }));
    }
}

/// Returns the least and the greatest x of lines; zeros without any.
pub(super) fn span(lines: &[Line]) -> [f64; 2] {
    let points = lines.iter().flat_map(|line| match line {
        Line::Path(points) => points.as_slice(),
        Line::Dot(at) => std::slice::from_ref(at),
    });
    points
        .fold(None, |span: Option<[f64; 2]>, [x, _]| {
            let [low, high] = span.unwrap_or([*x; 2]);
            Some([low.min(*x), high.max(*x)])
        })
        .unwrap_or_default()
}

/// Returns true if a vertical stroke stands in the middle of a glyph between other strokes.
pub(super) fn has_middle_stem(lines: &[Line], span: [f64; 2]) -> bool {
    let middle = 0.5 * (span[0] + span[1]);
    let stands = |p: &[[f64; 2]]| p[0][0] == p[1][0] && p[0][0] == middle && p[0][1] != p[1][1];
    span[0] < span[1]
        && lines.iter().any(|line| match line {
            Line::Path(points) => points.windows(2).any(stands),
            Line::Dot(_) => false,
        })
}
