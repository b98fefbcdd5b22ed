//! Closed surface of a body: weighted vertices, and triangles grouped in regions.

mod arm;
mod bags;
mod collar;
mod covers;
mod ear;
mod extras;
mod eyes;
mod hair;
mod hand;
mod head;
mod layers;
mod leg;
mod parts;
mod skirt;
mod skull;
mod trunk;
mod wardrobe;
mod wrist;

use std::collections::BTreeMap;

use glam::DVec3;

use crate::anatomy::Segment;

pub(crate) use parts::{narrow, parts};
pub(crate) use wardrobe::{Item, Wardrobe};

/// Region of the surface; each region has its own material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Region {
    Skin,
    Eyes,
    Hair,
    Top,
    Trousers,
    Shoes,
    Accessory,
}

impl Region {
    pub(crate) const ALL: [Self; 7] = [
        Self::Skin,
        Self::Eyes,
        Self::Hair,
        Self::Top,
        Self::Trousers,
        Self::Shoes,
        Self::Accessory,
    ];
}

/// Linear colour that multiplies the colour of a region.
pub(crate) type Paint = [f64; 3];

/// The paint that leaves the colour of a region.
pub(crate) const PLAIN: Paint = [1.0; 3];

/// Cover of a triangle of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cover {
    pub(crate) region: Region,
    /// Distance from the surface in metres. Borders between covers of different lifts get walls,
    /// so that hems have an edge.
    pub(crate) lift: f64,
    pub(crate) paint: Paint,
}

impl From<Region> for Cover {
    fn from(region: Region) -> Self {
        Self { region, lift: 0.0, paint: PLAIN }
    }
}

/// Skinning weights of a vertex by segment, not normalised.
pub(crate) type Weights = Vec<(Segment, f64)>;

/// A surface under construction.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub(crate) points: Vec<DVec3>,
    pub(crate) weights: Vec<Weights>,
    pub(crate) paints: Vec<Paint>,
    /// Paint of the points that are added next.
    brush: Paint,
    pub(crate) triangles: Vec<([usize; 3], Cover)>,
}

impl Default for Surface {
    fn default() -> Self {
        let (points, weights, paints) = (Vec::new(), Vec::new(), Vec::new());
        Self { points, weights, paints, brush: PLAIN, triangles: Vec::new() }
    }
}

impl Surface {
    /// Adds a vertex and returns its index.
    pub(crate) fn point(&mut self, position: DVec3, weights: Weights) -> usize {
        self.points.push(position);
        self.weights.push(weights);
        self.paints.push(self.brush);
        self.points.len() - 1
    }

    /// Adds two triangles between four corners in counter-clockwise order. The diagonal starts at
    /// the first corner, or at the second if `mirrored`, so that both halves of a body are
    /// symmetric.
    fn quad(&mut self, [a, b, c, d]: [usize; 4], cover: impl Into<Cover>, mirrored: bool) {
        let cover = cover.into();
        let cut = if mirrored { [[b, c, d], [b, d, a]] } else { [[a, b, c], [a, c, d]] };
        self.triangles.extend(cut.map(|corners| (corners, cover)));
    }

    /// Adds a band of quads between two rings with the same number of points. Seen from outside,
    /// with `to` above `from`, the rings run to the right, or to the left if `mirrored`.
    fn bridge(&mut self, from: &[usize], to: &[usize], cover: impl Into<Cover>, mirrored: bool) {
        let cover = cover.into();
        let next = |k: usize| (k + 1) % from.len();
        for k in 0..from.len() {
            let [a, b, c, d] = [from[k], from[next(k)], to[next(k)], to[k]];
            self.quad(if mirrored { [b, a, d, c] } else { [a, b, c, d] }, cover, mirrored);
        }
    }

    /// Closes a ring with triangles to the point `tip`. The order is that of [`Self::bridge`].
    fn cap(&mut self, from: &[usize], tip: usize, cover: impl Into<Cover>, mirrored: bool) {
        let cover = cover.into();
        for k in 0..from.len() {
            let [a, b] = [from[k], from[(k + 1) % from.len()]];
            self.triangles.push((if mirrored { [b, a, tip] } else { [a, b, tip] }, cover));
        }
    }

    /// Closes a ring with triangles to its middle, which gets the mean of the ring's weights.
    fn close(&mut self, ring: &[usize], cover: impl Into<Cover>, mirrored: bool) {
        let share = 1.0 / ring.len() as f64;
        let middle = ring.iter().map(|&p| self.points[p] * share).sum();
        let mut weights = Weights::new();
        for &p in ring {
            weights = mixed_in(weights, &self.weights[p], share);
        }
        let tip = self.point(middle, weights);
        self.cap(ring, tip, cover, mirrored);
    }

    /// Adds a closed tube through rings of points, whose ends are closed to their middles. The
    /// rings may run either way.
    fn tube(&mut self, rings: &[Vec<usize>], cover: impl Into<Cover>) {
        let cover = cover.into();
        self.shell(|surface| {
            for pair in rings.windows(2) {
                surface.bridge(&pair[0], &pair[1], cover, false);
            }
            if let [first, .., last] = rings {
                surface.close(first, cover, true);
                surface.close(last, cover, false);
            }
        });
    }

    /// Adds a closed surface and turns it so that it faces outwards.
    fn shell(&mut self, build: impl FnOnce(&mut Self)) {
        let first = self.triangles.len();
        build(self);
        let six_volumes: f64 = self.triangles[first..]
            .iter()
            .map(|(corners, _)| {
                let [a, b, c] = corners.map(|corner| self.points[corner]);
                a.dot(b.cross(c))
            })
            .sum();
        if six_volumes < 0.0 {
            for (corners, _) in &mut self.triangles[first..] {
                corners.swap(1, 2);
            }
        }
    }

    /// Adds another surface.
    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.points.len();
        self.points.extend(&other.points);
        self.weights.extend(other.weights.iter().cloned());
        self.paints.extend(&other.paints);
        let moved = |&(corners, cover): &([usize; 3], Cover)| (corners.map(|c| c + first), cover);
        self.triangles.extend(other.triangles.iter().map(moved));
    }

    /// Returns unit normals of the points: area-weighted sums of the triangles' normals, over all
    /// points of equal position.
    pub(crate) fn normals(&self) -> Vec<DVec3> {
        let place = |p: usize| self.points[p].to_array().map(|v| (v + 0.0).to_bits());
        let mut sums: BTreeMap<[u64; 3], DVec3> = BTreeMap::new();
        for (corners, _) in &self.triangles {
            let [a, b, c] = corners.map(|corner| self.points[corner]);
            let normal = (b - a).cross(c - a);
            for &corner in corners {
                *sums.entry(place(corner)).or_default() += normal;
            }
        }
        (0..self.points.len())
            .map(|p| sums.get(&place(p)).map_or(DVec3::Y, |n| n.normalize_or(DVec3::Y)))
            .collect()
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

/// Adds weights times a factor.
fn mixed_in(mut weights: Weights, added: &[(Segment, f64)], factor: f64) -> Weights {
    for &(segment, weight) in added {
        match weights.iter_mut().find(|(s, _)| *s == segment) {
            Some((_, w)) => *w += weight * factor,
            None => weights.push((segment, weight * factor)),
        }
    }
    weights
}

/// Interpolates weights: the result is `first` at a fraction of 0, and `second` at 1.
fn mixed(first: Weights, second: &[(Segment, f64)], fraction: f64) -> Weights {
    let weights = first.into_iter().map(|(s, w)| (s, w * (1.0 - fraction))).collect();
    let mut weights = mixed_in(weights, second, fraction);
    weights.retain(|(_, w)| *w > 1e-9);
    weights
}
