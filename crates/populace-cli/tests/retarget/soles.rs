//! Measures drawn feet: all vertices that are skinned to a foot, over a clip's cycle.

use libtest_mimic::Failed;
use populace::character::{Character, Part};
use populace::clip::Clip;
use populace::model::{Affine, JointIndex, Role, RoleMap, Side};
use populace::{ClipId, ClipPlayback, Crowd, MemberId};

/// Samples of a cycle.
const SAMPLES: u32 = 96;

/// Measurements of a body's feet over a cycle.
pub(crate) struct FeetMeasurement {
    /// The largest distance below rest height, in units of the body's height.
    pub(crate) sinking: f64,
    /// The phase of that sample, from 0 to 1.
    pub(crate) phase: f32,
    /// The largest rotation of a foot or its toes between two samples.
    pub(crate) rotation_rad: f64,
}

/// A body's feet, including toes.
pub(crate) struct Feet<'a> {
    body: &'a Character,
    joints: Vec<JointIndex>,
    /// Vertices skinned to the feet.
    vertices: Vec<(&'a Part, usize)>,
}

impl<'a> Feet<'a> {
    pub(crate) fn new(body: &'a Character, roles: &RoleMap) -> Self {
        let sides = [Side::Left, Side::Right];
        let feet: Vec<_> = sides.iter().filter_map(|side| roles.joint(Role::Foot(*side))).collect();
        let toes = sides.iter().filter_map(|side| roles.joint(Role::Toes(*side)));
        let is_foot = |joint: JointIndex| {
            feet.iter().any(|foot| joint == *foot || body.skeleton.is_below(joint, *foot))
        };
        let carried = |part: &Part, vertex: usize| {
            let of = influences(part, vertex).filter(|(e, _)| is_foot(body.palette[*e].joint));
            of.map(|(_, weight)| weight).sum::<f32>() >= 0.5
        };
        let all = body
            .parts
            .iter()
            .flat_map(|part| (0..part.mesh.positions.len()).map(move |v| (part, v)));
        let vertices = all.filter(|(part, vertex)| carried(part, *vertex)).collect();
        Self { body, vertices, joints: feet.iter().copied().chain(toes).collect() }
    }

    /// Returns the height of the lowest vertex.
    fn lowest(&self, palette: &[Affine]) -> f64 {
        let height = |(part, vertex): &(&Part, usize)| {
            let [x, y, z] = part.mesh.positions[*vertex];
            let moved = influences(part, *vertex).map(|(entry, weight)| {
                let [_, row, _] = palette[entry].rows;
                f64::from(weight) * f64::from(row[0] * x + row[1] * y + row[2] * z + row[3])
            });
            moved.sum::<f64>()
        };
        self.vertices.iter().map(height).fold(f64::INFINITY, f64::min)
    }

    /// Measures a member over a cycle of a clip. The member must be at rest.
    pub(crate) fn measure(
        &self,
        crowd: &mut Crowd,
        member: MemberId,
        (clip, motion): (ClipId, &Clip),
    ) -> Result<FeetMeasurement, Failed> {
        crowd.update(0.0)?;
        let rest = self.lowest(&crowd.member_mut(member)?.palette()?);
        let mut result =
            FeetMeasurement { sinking: f64::NEG_INFINITY, phase: 0.0, rotation_rad: 0.0 };
        let mut before: Option<Vec<Affine>> = None;
        for sample in 0..=SAMPLES {
            let part = sample as f32 / SAMPLES as f32;
            let secs = motion.start_secs() + part * motion.duration_secs();
            crowd.member_mut(member)?.play(clip, ClipPlayback::held_at_secs(secs))?;
            crowd.update(0.0)?;
            let sinking = (rest - self.lowest(&crowd.member_mut(member)?.palette()?))
                / f64::from(self.body.height_m());
            if sinking > result.sinking {
                (result.sinking, result.phase) = (sinking, part);
            }
            let now = crowd.member_mut(member)?.model_from_joints()?;
            for joint in &self.joints {
                let rotation = before
                    .as_ref()
                    .map_or(0.0, |b| rotation_rad(&b[joint.index()], &now[joint.index()]));
                result.rotation_rad = result.rotation_rad.max(rotation);
            }
            before = Some(now);
        }
        Ok(result)
    }
}

fn influences(part: &Part, vertex: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    let of = &part.mesh.influences;
    let range = vertex * of.per_vertex..(vertex + 1) * of.per_vertex;
    of.entries[range.clone()].iter().zip(&of.weights[range]).map(|(e, w)| (usize::from(*e), *w))
}

/// Returns the largest rotation of a joint's axes.
fn rotation_rad(from: &Affine, to: &Affine) -> f64 {
    let axis = |m: &Affine, axis: usize| {
        let v = m.rows.map(|row| f64::from(row[axis]));
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    };
    let cosine = |n: usize| axis(from, n).iter().zip(axis(to, n)).map(|(a, b)| a * b).sum::<f64>();
    (0..3).map(|n| cosine(n).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max)
}
