//! Closed surface of a body: weighted vertices, and triangles grouped in regions.

mod arm;
mod hand;
mod head;
mod leg;
mod parts;
mod trunk;
mod wrist;

use glam::DVec3;

use crate::anatomy::{Body, Segment};

pub(crate) use parts::{narrow, parts};

/// Region of the surface; each region has its own material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Region {
    Skin,
    Hair,
    Brow,
    Lips,
    EyeWhite,
    Iris,
    Shirt,
    Trousers,
    Shoes,
}

impl Region {
    pub(crate) const ALL: [Self; 9] = [
        Self::Skin,
        Self::Hair,
        Self::Brow,
        Self::Lips,
        Self::EyeWhite,
        Self::Iris,
        Self::Shirt,
        Self::Trousers,
        Self::Shoes,
    ];

    const fn bit(self) -> u16 {
        1 << self as u8
    }
}

/// Skinning weights of a vertex by segment, not normalised.
pub(crate) type Weights = Vec<(Segment, f64)>;

/// A surface under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub(crate) points: Vec<DVec3>,
    pub(crate) weights: Vec<Weights>,
    /// Bit set of each vertex: the regions that it belongs to or borders. A triangle is in the
    /// region that its corners have in common.
    marks: Vec<u16>,
    pub(crate) triangles: Vec<([usize; 3], Region)>,
}

impl Surface {
    /// Builds the surface of the whole body.
    pub(crate) fn of(body: &Body) -> Self {
        let mut surface = Self::default();
        let trunk = trunk::build(&mut surface, body);
        head::build(&mut surface, body, &trunk.neck);
        for (limb, side) in trunk.arms.iter().zip(crate::anatomy::Side::BOTH) {
            arm::build(&mut surface, body, side, limb);
        }
        for (limb, side) in trunk.legs.iter().zip(crate::anatomy::Side::BOTH) {
            leg::build(&mut surface, body, side, limb);
        }
        surface
    }

    /// Adds a vertex and returns its index.
    pub(crate) fn point(&mut self, position: DVec3, weights: Weights) -> usize {
        self.points.push(position);
        self.weights.push(weights);
        self.marks.push(0);
        self.points.len() - 1
    }

    fn mark(&mut self, point: usize, region: Region) {
        self.marks[point] |= region.bit();
    }

    /// Adds a triangle in the region that all its corners are marked with, or else in `region`.
    fn triangle(&mut self, corners: [usize; 3], region: Region) {
        self.triangles.push((corners, self.region(corners).unwrap_or(region)));
    }

    /// Returns the region that all corners are marked with, small regions first.
    fn region(&self, corners: [usize; 3]) -> Option<Region> {
        let shared = corners.iter().fold(u16::MAX, |bits, &c| bits & self.marks[c]);
        use Region::{Brow, EyeWhite, Hair, Iris, Lips};
        [Iris, EyeWhite, Lips, Brow, Hair].into_iter().find(|r| shared & r.bit() != 0)
    }

    /// Adds two triangles between four corners in counter-clockwise order. The diagonal follows the
    /// border of regions. Without a border it starts at the first corner, or at the second if
    /// `mirrored`, so that both halves of a body are symmetric.
    fn quad(&mut self, [a, b, c, d]: [usize; 4], region: Region, mirrored: bool) {
        let cuts = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
        let marked =
            |cut: &[[usize; 3]; 2]| cut.iter().filter(|t| self.region(**t).is_some()).count();
        let default = usize::from(mirrored);
        let other = 1 - default;
        let cut =
            if marked(&cuts[other]) > marked(&cuts[default]) { cuts[other] } else { cuts[default] };
        for corners in cut {
            self.triangle(corners, region);
        }
    }

    /// Adds a band of quads between two rings with the same number of points. Seen from outside,
    /// with `to` above `from`, the rings run to the right, or to the left if `mirrored`.
    fn bridge(&mut self, from: &[usize], to: &[usize], region: Region, mirrored: bool) {
        let next = |k: usize| (k + 1) % from.len();
        for k in 0..from.len() {
            let [a, b, c, d] = [from[k], from[next(k)], to[next(k)], to[k]];
            self.quad(if mirrored { [b, a, d, c] } else { [a, b, c, d] }, region, mirrored);
        }
    }

    /// Closes a ring with triangles to the point `tip`. The order is that of [`Self::bridge`].
    fn cap(&mut self, from: &[usize], tip: usize, region: Region, mirrored: bool) {
        for k in 0..from.len() {
            let [a, b] = [from[k], from[(k + 1) % from.len()]];
            self.triangle(if mirrored { [b, a, tip] } else { [a, b, tip] }, region);
        }
    }
}

/// Returns the cubic smooth step from 0 at `low` to 1 at `high`.
pub(crate) fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the weights at the position `at` along a chain of segments. Each of `bounds` is the
/// border between two neighbouring segments and the half width of the blend.
fn chain(at: f64, segments: &[Segment], bounds: &[(f64, f64)]) -> Weights {
    let mut rest = 1.0;
    let mut weights = Vec::new();
    for (&segment, &(bound, half)) in segments.iter().zip(bounds) {
        let beyond = rest * smooth(bound - half, bound + half, at);
        weights.push((segment, rest - beyond));
        rest = beyond;
    }
    weights.push((segments[bounds.len()], rest));
    weights.retain(|(_, w)| *w > 1e-9);
    weights
}

/// Interpolates weights: the result is `first` at a fraction of 0, and `second` at 1.
fn mixed(first: Weights, second: &[(Segment, f64)], fraction: f64) -> Weights {
    let mut weights: Weights = first.into_iter().map(|(s, w)| (s, w * (1.0 - fraction))).collect();
    for &(segment, weight) in second {
        match weights.iter_mut().find(|(s, _)| *s == segment) {
            Some((_, w)) => *w += weight * fraction,
            None => weights.push((segment, weight * fraction)),
        }
    }
    weights.retain(|(_, w)| *w > 1e-9);
    weights
}
