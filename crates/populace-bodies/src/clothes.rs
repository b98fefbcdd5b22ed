//! Clothes: regions of the body pushed out along its normals, and a skirt.

use glam::{Vec2, Vec3};

use crate::body::{Body, nearest_weights};
use crate::marks::Marks;
use crate::person::{Bottom, Neckline, Outfit, Sleeves};
use crate::rig_file::Weights;
use crate::surface::{Surface, Vertex, grid, smoothstep};

/// Columns and rows of a skirt.
const SKIRT: [usize; 2] = [44, 10];
/// Part of a turn in radians by which columns of a skirt move towards its front and back.
const DENSER: f32 = 0.35;

/// How close smoothed cloth may come to the body, as a part of how far it was pushed out.
const LEAST_PUSH: f32 = 0.6;

/// Regions of the body that clothes cover, as fields over the base mesh: about the distance in
/// decimetres from the edge of the garment, positive under it.
pub(crate) struct Cover<'a> {
    pub(crate) marks: &'a Marks,
    pub(crate) outfit: &'a Outfit,
}

impl Cover<'_> {
    /// Under the top.
    pub(crate) fn top(&self, v: &Vertex) -> f32 {
        let [upper, whole] = self.marks.arm_lengths();
        let sleeve = match self.outfit.sleeves {
            Sleeves::Short => 0.62 * upper,
            Sleeves::Long => whole - 0.12,
        };
        let sleeve = sleeve - self.marks.along_arm(v);
        sleeve.min(self.below_neck(v)).min(v.base.y - self.top_hem())
    }

    /// Outside the opening for the neck: below a plane that leans forward, or away from the neck.
    fn below_neck(&self, v: &Vertex) -> f32 {
        let from = v.base - self.marks.neck_at;
        let away = Vec2::new(from.x, from.z).length();
        let front = smoothstep(0.2, 0.9, from.z / away.max(1e-3));
        let notch = match self.outfit.neckline {
            Neckline::Vee => 0.9 * front * (1.0 - v.base.x.abs() / 0.5).max(0.0),
            Neckline::Round => 0.0,
        };
        let plane = -0.14 - 0.5 * from.z - notch - from.y;
        let ring = away - 0.66 - 0.35 * front - 1.4 * notch;
        plane.max(ring).min(0.1 - from.y)
    }

    fn top_hem(&self) -> f32 {
        match self.outfit.bottom {
            Bottom::Skirt => self.marks.hip_y + 0.1,
            _ => self.marks.hip_y + 0.05,
        }
    }

    fn bottom_hem(&self) -> f32 {
        let marks = self.marks;
        match self.outfit.bottom {
            Bottom::Trousers => marks.ankle_y - 0.05,
            Bottom::Shorts => marks.knee_y + 0.45,
            Bottom::Skirt => marks.knee_y + 0.6,
        }
    }

    /// Under trousers, shorts or skirt.
    pub(crate) fn bottom(&self, v: &Vertex) -> f32 {
        let waist = self.marks.waist_y + 0.1 - v.base.y;
        let not_hand = (0.5 - self.marks.arm_share(v)) * 4.0;
        waist.min(v.base.y - self.bottom_hem()).min(not_hand)
    }

    /// Inside a shoe.
    pub(crate) fn shoe(&self, v: &Vertex) -> f32 {
        (self.shoe_top() - v.base.y).min((0.5 - self.marks.arm_share(v)) * 4.0)
    }

    /// Height of the upper edge of shoes on the base mesh.
    pub(crate) fn shoe_top(&self) -> f32 {
        self.marks.ankle_y + 0.12
    }
}

/// Returns the top: pushed out 9 mm, and further at the hem, where it lies over what is below.
pub(crate) fn top(body: &Body, cover: &Cover) -> Surface {
    let marks = cover.marks;
    let [upper, _] = marks.arm_lengths();
    let cuff = match cover.outfit.sleeves {
        Sleeves::Short => 0.005,
        Sleeves::Long => 0.001,
    };
    let push = |v: &Vertex| {
        let hem = match cover.outfit.bottom {
            // Tucked in.
            Bottom::Skirt => -0.005 * smoothstep(-0.3, 0.0, cover.bottom(v)),
            _ => 0.008 * smoothstep(marks.waist_y + 1.0, marks.hip_y, v.base.y),
        };
        let sleeve = smoothstep(0.2 * upper, 0.6 * upper, marks.along_arm(v));
        0.008 + hem + cuff * sleeve
    };
    // A skirt is worn over it.
    let part = body.skin.kept(|v| match cover.outfit.bottom {
        Bottom::Skirt => cover.top(v).min(0.2 - cover.bottom(v)),
        _ => cover.top(v),
    });
    garment(
        part,
        10,
        |v| push(v) * body.size.max(0.8),
        |v| 0.25 + 0.25 * (1.0 - marks.arm_share(v)),
    )
}

/// Returns trousers, shorts or skirt.
pub(crate) fn bottom(body: &Body, cover: &Cover) -> Surface {
    let marks = cover.marks;
    if cover.outfit.bottom == Bottom::Skirt {
        let tube = marks.hip_y - 0.6;
        let part = body.skin.kept(|v| cover.bottom(v).min(v.base.y - tube));
        let mut skirt = garment(part, 20, |_| 0.013 * body.size.max(0.8), |_| 0.5);
        skirt.add(&hanging(body, cover));
        return skirt;
    }
    let push = |v: &Vertex| {
        let thigh = smoothstep(marks.crotch_y + 0.2, marks.crotch_y - 1.2, v.base.y);
        let shin = smoothstep(marks.knee_y + 0.3, marks.ankle_y + 0.6, v.base.y);
        let wide = if cover.outfit.bottom == Bottom::Shorts { 0.013 } else { 0.008 };
        0.007 + wide * thigh + 0.016 * shin
    };
    // What lies well under the top cannot be seen.
    let part = body.skin.kept(|v| cover.bottom(v).min(0.45 - cover.top(v)));
    garment(part, 16, |v| push(v) * body.size.max(0.8), |_| 0.4)
}

/// Pushes a part of the body out by `push` metres, and smooths it, by which it may come closer.
fn garment(
    mut part: Surface,
    rounds: usize,
    push: impl Fn(&Vertex) -> f32,
    soft: impl Fn(&Vertex) -> f32,
) -> Surface {
    let outside = |part: &mut Surface, least: f32| {
        for v in &mut part.vertices {
            let short = push(v) * least - (v.at - v.body).dot(v.normal);
            v.at += v.normal * short.max(0.0);
        }
    };
    outside(&mut part, 1.0);
    for _ in 0..rounds {
        part.smooth(1, &soft);
        outside(&mut part, LEAST_PUSH);
    }
    // The edge has depth, down to just over the skin.
    part.close_border(|v| v.at - v.normal * ((v.at - v.body).dot(v.normal) - 0.001));
    part.set_normals();
    part
}

/// A row of a skirt: where it lies, and how far the body reaches in each direction.
struct Ring {
    base_y: f32,
    center: Vec3,
    reach: Vec<f32>,
}

/// Returns what hangs from the hips: a tube around both thighs.
fn hanging(body: &Body, cover: &Cover) -> Surface {
    let [columns, rows] = SKIRT;
    let (high, low) = (cover.marks.hip_y + 0.25, cover.bottom_hem());
    // Columns are dense in front and behind, where the cloth passes from one thigh to the other.
    let direction = |column: usize| {
        let turn = (column as f32 + 0.5) / columns as f32 * std::f32::consts::TAU;
        Vec2::from((turn - DENSER * (2.0 * turn).sin_cos().0).sin_cos())
    };
    let directions: Vec<Vec2> = (0..columns).map(direction).collect();
    let mut rings: Vec<Ring> = Vec::new();
    for row in 0..rows {
        let down = row as f32 / (rows - 1) as f32;
        let base_y = high + (low - high) * down;
        let near = |v: &&Vertex| (v.base.y - base_y).abs() < 0.25 && cover.marks.arm_share(v) < 0.5;
        let near: Vec<&Vertex> = body.skin.vertices.iter().filter(near).collect();
        let Some(center) = row_center(&near, base_y) else { continue };
        let slack = (0.008 + 0.012 * smoothstep(0.0, 0.2, down) + 0.04 * down) * body.size;
        let mut reach = hull_reach(&near, center, &directions);
        for (column, reach) in reach.iter_mut().enumerate() {
            // It hangs from where the body is widest.
            let above = rings.last().map_or(0.0, |above: &Ring| above.reach[column]);
            *reach = (*reach + slack).max(above);
        }
        rings.push(Ring { base_y, center, reach });
    }
    let row = |ring: &Ring| {
        let vertex = |(d, reach): (&Vec2, &f32)| {
            let at = ring.center + Vec3::new(d.x, 0.0, d.y) * *reach;
            Vertex {
                base: Vec3::new(at.x * 10.0, ring.base_y, at.z * 10.0),
                body: at,
                at,
                normal: Vec3::new(d.x, 0.0, d.y),
                color: Vec3::ONE,
                weights: skirt_weights(body, cover.marks, at, ring.base_y),
            }
        };
        directions.iter().zip(&ring.reach).map(vertex).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<Vertex>> = rings.iter().map(row).collect();
    let mut skirt = grid(&rows, true);
    skirt.set_normals();
    skirt
}

/// Returns how far the convex hull of vertices reaches from a point in each direction.
fn hull_reach(near: &[&Vertex], center: Vec3, directions: &[Vec2]) -> Vec<f32> {
    let offset = |v: &&Vertex| Vec2::new(v.body.x - center.x, v.body.z - center.z);
    let support: Vec<f32> = directions
        .iter()
        .map(|d| near.iter().map(|v| offset(v).dot(*d)).fold(0.0, f32::max))
        .collect();
    let reach = |d: &Vec2| {
        let tangents = directions.iter().zip(&support);
        let along = tangents.filter(|(e, _)| e.dot(*d) > 0.1).map(|(e, h)| h / e.dot(*d));
        along.fold(f32::MAX, f32::min)
    };
    directions.iter().map(reach).collect()
}

/// Returns the middle of the body at a height of the base mesh; `None` if nothing is there.
fn row_center(near: &[&Vertex], base_y: f32) -> Option<Vec3> {
    let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
    for v in near {
        (low, high) = (low.min(v.body), high.max(v.body));
    }
    let span: f32 = near.iter().map(|v| (v.base.y - base_y).abs()).fold(f32::MAX, f32::min);
    let level: Vec<f32> = near
        .iter()
        .filter(|v| (v.base.y - base_y).abs() <= span + 0.15)
        .map(|v| v.body.y)
        .collect();
    let y = level.iter().sum::<f32>() / level.len().max(1) as f32;
    (!near.is_empty()).then(|| Vec3::new((low.x + high.x) / 2.0, y, (low.z + high.z) / 2.0))
}

/// Weights of a skirt: those of the waist at the top, and those of the thighs from the hips down.
/// Between the thighs it passes from one to the other within 24 mm, so that it is drawn tight between
/// the legs of a step, and no leg comes through it.
fn skirt_weights(body: &Body, marks: &Marks, at: Vec3, base_y: f32) -> Weights {
    let waist = nearest_weights(&body.skin, at);
    let thighs = smoothstep(marks.hip_y + 0.3, marks.crotch_y - 0.6, base_y);
    let left = smoothstep(-0.012, 0.012, at.x);
    let upper = smoothstep(marks.hip_y, marks.waist_y, base_y);
    Weights::mix(&[
        (waist, (1.0 - thighs) * upper),
        (Weights::one(marks.hips), (1.0 - thighs) * (1.0 - upper)),
        (Weights::one(marks.thighs[0]), thighs * left),
        (Weights::one(marks.thighs[1]), thighs * (1.0 - left)),
    ])
}
