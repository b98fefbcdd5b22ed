//! Feet as they are drawn: every vertex that a foot carries, over a cycle.

use libtest_mimic::Failed;
use populace::character::{Character, Part};
use populace::clip::Clip;
use populace::model::{Affine, JointIndex, Role, RoleMap, Side};
use populace::{ClipId, Crowd, Member, Play};

/// Moments of a cycle.
const MOMENTS: u32 = 96;

/// What the feet of a body were found to do over a cycle.
pub(crate) struct Seen {
    /// How far below where they rest they come at most, in parts of the body's height.
    pub(crate) sunk: f64,
    /// When, in parts of the cycle.
    pub(crate) at: f32,
    /// How far a foot or its toes turn from one moment to the next at most, in radians.
    pub(crate) turned: f64,
}

/// A body's feet, toes included.
pub(crate) struct Soles<'a> {
    body: &'a Character,
    joints: Vec<JointIndex>,
    /// That they carry.
    vertices: Vec<(&'a Part, usize)>,
}

impl<'a> Soles<'a> {
    pub(crate) fn of(body: &'a Character, roles: &RoleMap) -> Self {
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

    /// How high the lowest vertex is.
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

    /// Looks at a member that is at rest, through a cycle of a clip.
    pub(crate) fn watch(
        &self,
        crowd: &mut Crowd,
        member: Member,
        (clip, motion): (ClipId, &Clip),
    ) -> Result<Seen, Failed> {
        crowd.update(0.0)?;
        let rest = self.lowest(&crowd.palette(member)?);
        let mut seen = Seen { sunk: f64::NEG_INFINITY, at: 0.0, turned: 0.0 };
        let mut before: Option<Vec<Affine>> = None;
        for moment in 0..=MOMENTS {
            let part = moment as f32 / MOMENTS as f32;
            let secs = motion.start_secs() + part * motion.duration_secs();
            crowd.play(member, clip, Play::held_at_secs(secs))?;
            crowd.update(0.0)?;
            let sunk =
                (rest - self.lowest(&crowd.palette(member)?)) / f64::from(self.body.height_m());
            if sunk > seen.sunk {
                (seen.sunk, seen.at) = (sunk, part);
            }
            let now = crowd.model_from_joints(member)?;
            for joint in &self.joints {
                let turned =
                    before.as_ref().map_or(0.0, |b| turned(&b[joint.index()], &now[joint.index()]));
                seen.turned = seen.turned.max(turned);
            }
            before = Some(now);
        }
        Ok(seen)
    }
}

fn influences(part: &Part, vertex: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
    let of = &part.mesh.influences;
    let range = vertex * of.per_vertex..(vertex + 1) * of.per_vertex;
    of.entries[range.clone()].iter().zip(&of.weights[range]).map(|(e, w)| (usize::from(*e), *w))
}

/// How far the axes of a joint turn, at most.
fn turned(from: &Affine, to: &Affine) -> f64 {
    let axis = |m: &Affine, axis: usize| {
        let v = m.rows.map(|row| f64::from(row[axis]));
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    };
    let cosine = |n: usize| axis(from, n).iter().zip(axis(to, n)).map(|(a, b)| a * b).sum::<f64>();
    (0..3).map(|n| cosine(n).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max)
}
