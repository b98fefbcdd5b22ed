//! Strokes with round ends as a field of distances, from which ink and halos are painted.

/// A straight stroke with round ends, in pixels; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    pub(crate) radius: f64,
}

impl Segment {
    pub(crate) fn new(from: [f64; 2], to: [f64; 2], radius: f64) -> Self {
        Self { from, to, radius }
    }

    pub(crate) fn dot(at: [f64; 2], radius: f64) -> Self {
        Self { from: at, to: at, radius }
    }

    /// Returns the distance of a point from the stroke's edge, negative inside, and how far along
    /// the stroke the nearest point is, 0 to 1.
    pub(crate) fn distance(&self, at: [f64; 2]) -> (f64, f64) {
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let out = [at[0] - self.from[0], at[1] - self.from[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        let along = match square {
            0.0 => 0.0,
            _ => ((out[0] * way[0] + out[1] * way[1]) / square).clamp(0.0, 1.0),
        };
        let off = [out[0] - along * way[0], out[1] - along * way[1]];
        ((off[0] * off[0] + off[1] * off[1]).sqrt() - self.radius, along)
    }

    /// Returns the pixels of a picture that are at most `reach` from the stroke; `None` if there
    /// are none.
    pub(crate) fn pixels(&self, reach: f64, size: [u32; 2]) -> Option<Window> {
        let around = self.radius + reach;
        let low = [0, 1].map(|i| self.from[i].min(self.to[i]) - around);
        let high = [0, 1].map(|i| self.from[i].max(self.to[i]) + around);
        let finite = [self.from, self.to].as_flattened().iter().all(|v| v.is_finite());
        finite.then(|| Window::around(low, high, size)).flatten()
    }
}

/// A rectangle of pixels within a picture: the first column and row, and those after the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) first: [u32; 2],
    pub(crate) end: [u32; 2],
}

impl Window {
    /// Returns the pixels of a picture that touch a rectangle; `None` if there are none.
    pub(crate) fn around(low: [f64; 2], high: [f64; 2], size: [u32; 2]) -> Option<Self> {
        let first = [0, 1].map(|i| pixel(low[i].floor(), size[i]));
        let end = [0, 1].map(|i| pixel(high[i].ceil(), size[i]));
        (first[0] < end[0] && first[1] < end[1]).then_some(Self { first, end })
    }

    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            first: [0, 1].map(|i| self.first[i].min(other.first[i])),
            end: [0, 1].map(|i| self.end[i].max(other.end[i])),
        }
    }

    /// Columns and rows.
    pub(crate) fn size(self) -> [usize; 2] {
        [0, 1].map(|i| (self.end[i] - self.first[i]) as usize)
    }

    /// Returns the index of a pixel among those of the window, row by row.
    pub(crate) fn index(self, pixel: [u32; 2]) -> usize {
        let [x, y] = [0, 1].map(|i| (pixel[i] - self.first[i]) as usize);
        y * self.size()[0] + x
    }
}

/// Returns a coordinate within a side of a picture.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to whole numbers of pixels"
)]
fn pixel(v: f64, side: u32) -> u32 {
    v.clamp(0.0, f64::from(side)) as u32
}

/// Distances of the pixels of a window from the edge of the nearest stroke, negative inside.
pub(crate) struct Field {
    pub(crate) window: Window,
    distances: Vec<f64>,
}

impl Field {
    /// Returns the field of some strokes, right up to a distance of `reach`; `None` if no pixel of
    /// the picture is as near.
    pub(crate) fn new(segments: &[Segment], reach: f64, size: [u32; 2]) -> Option<Self> {
        let windows: Vec<_> = segments.iter().map(|s| s.pixels(reach, size)).collect();
        let window = windows.iter().flatten().copied().reduce(Window::with)?;
        let [width, height] = window.size();
        let mut field = Self { window, distances: vec![f64::INFINITY; width * height] };
        for (segment, pixels) in segments.iter().zip(windows) {
            let Some(pixels) = pixels else { continue };
            for y in pixels.first[1]..pixels.end[1] {
                for x in pixels.first[0]..pixels.end[0] {
                    let distance = segment.distance([f64::from(x) + 0.5, f64::from(y) + 0.5]).0;
                    let at = window.index([x, y]);
                    field.distances[at] = field.distances[at].min(distance);
                }
            }
        }
        Some(field)
    }

    /// Returns the distance at a pixel of the window.
    pub(crate) fn at(&self, pixel: [u32; 2]) -> f64 {
        self.distances[self.window.index(pixel)]
    }
}

/// Returns how much of a pixel is covered, 0 to 1, whose middle is at a distance from an edge.
pub(crate) fn coverage(distance: f64) -> f64 {
    (0.5 - distance).clamp(0.0, 1.0)
}
