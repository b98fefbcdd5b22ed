//! Trails: lines behind people that fade.

use crate::canvas::Canvas;
use crate::strokes::{Segment, Window, coverage};

/// A line through points of the picture that fades towards its beginning.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// Points in pixels, the newest last. A point that is not finite is a gap.
    pub points: Vec<[f64; 2]>,
    /// Colour in sRGB of each part between two points; the last one repeats. White without any.
    pub colors: Vec<[u8; 3]>,
    /// Distances of the points along the view direction in metres, by which surfaces before them
    /// hide them. Without any, nothing does.
    pub depths_m: Vec<f64>,
    /// Opacity at the newest point, 0 to 1; it falls to 0 along the line.
    pub opacity: f64,
    /// Width in pixels.
    pub width_px: f64,
}

/// A part of a trail: the stroke, its opacities at the ends, its colour.
struct Part {
    stroke: Segment,
    opacity: [f64; 2],
    color: [u8; 3],
    /// Inverse distances of the ends, which lie on a line in a picture; `None` if nothing hides it.
    nearness: Option<[f64; 2]>,
}

/// The part of the opacity that a hidden trail keeps, so that the eye can follow it.
const HIDDEN: f64 = 0.12;
/// How far before a trail surfaces hide it, in metres and as a part of its distance: shoes that
/// stand on it, and the width of its line, do not.
const BEFORE_M: f64 = 0.06;
const BEFORE: f64 = 0.006;

impl Canvas<'_> {
    /// Draws trails in the order given. A trail that crosses itself is not darker there. It is
    /// faint behind surfaces, by `depths_m`: the distance along the view direction of the nearest
    /// surface of each pixel in metres, top row first; empty if that is not known.
    pub fn trails(&mut self, trails: &[Trail], depths_m: &[f32]) {
        for trail in trails {
            self.trail(trail, depths_m);
        }
    }

    fn trail(&mut self, trail: &Trail, depths_m: &[f32]) {
        let width_px = self.size()[0] as usize;
        let parts = trail.parts();
        let windows: Vec<_> =
            parts.iter().map(|part| part.stroke.pixels(1.0, self.size())).collect();
        let Some(all) = windows.iter().flatten().copied().reduce(Window::with) else { return };
        let [width, height] = all.size();
        // Parts overlap at their round ends; the strongest counts there, once.
        let mut ink = vec![([0_u8; 3], 0.0_f64); width * height];
        for (part, window) in parts.iter().zip(windows) {
            let Some(window) = window else { continue };
            for y in window.first[1]..window.end[1] {
                for x in window.first[0]..window.end[0] {
                    let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let (distance, along) = part.stroke.distance(at);
                    let [from, to] = part.opacity;
                    let mut strength = coverage(distance) * (from + along * (to - from));
                    let surface = depths_m.get(y as usize * width_px + x as usize);
                    if surface.is_some_and(|depth_m| part.is_hidden(along, *depth_m)) {
                        strength *= HIDDEN;
                    }
                    let pixel = &mut ink[all.index([x, y])];
                    if strength > pixel.1 {
                        *pixel = (part.color, strength);
                    }
                }
            }
        }
        self.paint(all, |pixel| {
            let ([red, green, blue], strength) = ink[all.index(pixel)];
            ([red, green, blue, 255], strength)
        });
    }
}

impl Part {
    /// Returns whether a surface at a distance in metres hides the part, a share of the way along.
    fn is_hidden(&self, along: f64, depth_m: f32) -> bool {
        self.nearness.is_some_and(|[from, to]| {
            let own_m = 1.0 / (from + along * (to - from));
            f64::from(depth_m) < own_m * (1.0 - BEFORE) - BEFORE_M
        })
    }
}

impl Trail {
    fn parts(&self) -> Vec<Part> {
        let lengths: Vec<_> = self
            .points
            .windows(2)
            .map(|p| {
                let way = [p[1][0] - p[0][0], p[1][1] - p[0][1]];
                let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
                if length.is_finite() { length } else { 0.0 }
            })
            .collect();
        let all = lengths.iter().sum::<f64>().max(1e-9);
        let mut gone = 0.0;
        let mut parts = Vec::new();
        for (index, (pair, length)) in self.points.windows(2).zip(lengths).enumerate() {
            let ends = [gone, gone + length];
            gone += length;
            let color = self.colors.get(index).or(self.colors.last()).copied();
            let depths = self.depths_m.get(index).zip(self.depths_m.get(index + 1));
            parts.push(Part {
                nearness: depths.map(|(from, to)| [1.0 / from, 1.0 / to]),
                stroke: Segment::new(pair[0], pair[1], 0.5 * self.width_px.max(1.0)),
                opacity: ends.map(|v| self.opacity.clamp(0.0, 1.0) * v / all),
                color: color.unwrap_or([255; 3]),
            });
        }
        parts
    }
}
