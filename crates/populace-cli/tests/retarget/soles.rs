//! Feet as they are drawn: every vertex that a foot carries, over a cycle.

use libtest_mimic::Failed;
use populace::core::{Affine, Character, Clip, JointIndex, Part, Role, RoleMap, Side};
use populace::{ClipId, Crowd, Member, Play};

/// Moments of a cycle.
const MOMENTS: u32 = 96;

/// The vertices that a body's feet carry, toes included.
pub(crate) struct Soles<'a> {
    vertices: Vec<(&'a Part, usize)>,
}

impl<'a> Soles<'a> {
    pub(crate) fn of(body: &'a Character, roles: &RoleMap) -> Self {
        let skeleton = &body.skeleton;
        let feet: Vec<_> =
            [Side::Left, Side::Right].iter().filter_map(|side| roles.joint(Role::Foot(*side))).collect();
        let is_foot = |joint: JointIndex| {
            feet.iter().any(|foot| joint == *foot || skeleton.is_below(joint, *foot))
        };
        let carried = |part: &Part, vertex: usize| {
            let influences = &part.mesh.influences;
            let range = vertex * influences.per_vertex..(vertex + 1) * influences.per_vertex;
            let of = influences.entries[range.clone()].iter().zip(&influences.weights[range]);
            let part: f32 =
                of.filter(|(e, _)| is_foot(body.palette[usize::from(**e)].joint)).map(|(_, w)| w).sum();
            part >= 0.5
        };
        let all = body.parts.iter().flat_map(|part| (0..part.mesh.positions.len()).map(move |v| (part, v)));
        Self { vertices: all.filter(|(part, vertex)| carried(part, *vertex)).collect() }
    }

    /// How high the lowest of them is.
    fn lowest(&self, palette: &[Affine]) -> f64 {
        let height = |(part, vertex): &(&Part, usize)| {
            let influences = &part.mesh.influences;
            let range = vertex * influences.per_vertex..(vertex + 1) * influences.per_vertex;
            let of = influences.entries[range.clone()].iter().zip(&influences.weights[range]);
            let place = part.mesh.positions[*vertex];
            of.map(|(entry, weight)| {
                let [_, row, _] = palette[usize::from(*entry)].rows;
                let y = row[0] * place[0] + row[1] * place[1] + row[2] * place[2] + row[3];
                f64::from(*weight) * f64::from(y)
            })
            .sum::<f64>()
        };
        self.vertices.iter().map(height).fold(f64::INFINITY, f64::min)
    }

    /// How far below where they rest they come in a cycle at most, and when, in parts of it. The member is at rest.
    pub(crate) fn sink(
        &self,
        crowd: &mut Crowd,
        member: Member,
        (clip, motion): (ClipId, &Clip),
    ) -> Result<(f64, f32), Failed> {
        crowd.update(0.0)?;
        let rest = self.lowest(&crowd.palette(member)?);
        let mut worst = (f64::NEG_INFINITY, 0.0);
        for moment in 0..MOMENTS {
            let part = moment as f32 / MOMENTS as f32;
            let secs = motion.start_secs() + part * motion.duration_secs();
            crowd.play(member, clip, Play::held_at_secs(secs))?;
            crowd.update(0.0)?;
            let sunk = rest - self.lowest(&crowd.palette(member)?);
            if sunk > worst.0 {
                worst = (sunk, part);
            }
        }
        Ok(worst)
    }
}
