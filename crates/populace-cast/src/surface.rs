//! The closed surface of a body: vertices with weights, and triangles of regions.

mod arm;
mod hand;
mod head;
mod leg;
mod parts;
mod trunk;

use glam::DVec3;

use crate::anatomy::{Body, Segment};

pub(crate) use parts::{narrow, narrow_one, parts};

/// What a triangle shows; each region is a material of its own.
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

/// What moves a vertex: segments and weights, not yet normalised.
pub(crate) type Weights = Vec<(Segment, f64)>;

/// A surface under construction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub(crate) points: Vec<DVec3>,
    pub(crate) weights: Vec<Weights>,
    /// Regions of which a vertex is part or border; a triangle whose corners share one is drawn as
    /// that.
    marks: Vec<u16>,
    pub(crate) triangles: Vec<([usize; 3], Region)>,
}

impl Surface {
    /// The whole body.
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

    pub(crate) fn point(&mut self, place: DVec3, weights: Weights) -> usize {
        self.points.push(place);
        self.weights.push(weights);
        self.marks.push(0);
        self.points.len() - 1
    }

    fn mark(&mut self, point: usize, region: Region) {
        self.marks[point] |= region.bit();
    }

    /// A triangle; of a region that its corners are marked with, or else of `region`.
    fn triangle(&mut self, corners: [usize; 3], region: Region) {
        self.triangles.push((corners, self.region(corners).unwrap_or(region)));
    }

    fn region(&self, corners: [usize; 3]) -> Option<Region> {
        let shared = corners.iter().fold(u16::MAX, |bits, &c| bits & self.marks[c]);
        use Region::{Brow, EyeWhite, Hair, Iris, Lips};
        [Iris, EyeWhite, Lips, Brow, Hair].into_iter().find(|r| shared & r.bit() != 0)
    }

    /// Two triangles between four corners, counter-clockwise, cut where regions meet, else from the
    /// first corner, or from the second where `mirrored`, so that both halves of a body are cut
    /// alike.
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

    /// A band of quads between two rings of equally many points. Seen from outside, with `to` above
    /// `from`, the rings run to the right, or to the left where `mirrored`.
    fn bridge(&mut self, from: &[usize], to: &[usize], region: Region, mirrored: bool) {
        let next = |k: usize| (k + 1) % from.len();
        for k in 0..from.len() {
            let [a, b, c, d] = [from[k], from[next(k)], to[next(k)], to[k]];
            self.quad(if mirrored { [b, a, d, c] } else { [a, b, c, d] }, region, mirrored);
        }
    }

    /// Closes a ring with a point; as [`Self::bridge`].
    fn cap(&mut self, from: &[usize], tip: usize, region: Region, mirrored: bool) {
        for k in 0..from.len() {
            let [a, b] = [from[k], from[(k + 1) % from.len()]];
            self.triangle(if mirrored { [b, a, tip] } else { [a, b, tip] }, region);
        }
    }
}

/// Cubic step from 0 at `low` to 1 at `high`.
pub(crate) fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Weights along a chain: `bounds` are where one segment ends and the next begins, and over how
/// much either side.
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

/// Mixes weights: `part` of the second, the rest of the first.
fn mixed(first: Weights, second: &[(Segment, f64)], part: f64) -> Weights {
    let mut weights: Weights = first.into_iter().map(|(s, w)| (s, w * (1.0 - part))).collect();
    for &(segment, weight) in second {
        match weights.iter_mut().find(|(s, _)| *s == segment) {
            Some((_, w)) => *w += weight * part,
            None => weights.push((segment, weight * part)),
        }
    }
    weights.retain(|(_, w)| *w > 1e-9);
    weights
}
