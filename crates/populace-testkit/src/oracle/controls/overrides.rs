//! Overrides of local and of model transforms.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_device::{After, Space};
use populace_model::Trs;

use super::{OracleMember, OracleStage, OracleStageInputs, short_part_of};
use crate::oracle::Local;
use crate::oracle::noise::Noise;
use crate::oracle::transform::parent_from_joint;

/// Returns a transform that the host gives.
pub(super) fn given(trs: &Trs) -> Local {
    Local {
        translation: DVec3::from_array(trs.translation.map(f64::from)),
        rotation: DQuat::from_array(trs.rotation.map(f64::from)).normalize(),
        scale: DVec3::from_array(trs.scale.map(f64::from)),
    }
}

impl OracleMember<'_> {
    /// Applies overrides in local space, then stages after Pose, to the local transforms of clips.
    pub(super) fn override_locals(&self, locals: &mut [Local], tick: u64, noise: &mut Noise) {
        for o in self.controls.overrides.iter().filter(|o| o.space == Space::Local) {
            let (local, part) = (&mut locals[self.source(o.joint)], f64::from(o.weight));
            let to = given(&o.transform);
            if part > 0.0 {
                *local = mixed(local, &to, part, noise);
            }
        }
        for used in self.controls.stages.iter().filter(|used| used.after == After::Pose) {
            let OracleStage::Pose(run) = self.stages[used.stage as usize] else { continue };
            for joint in &used.joints {
                let local = &mut locals[self.source(*joint)];
                run(local, &OracleStageInputs::new(used.values, *joint, tick));
                local.translation = noise.vector(local.translation);
                local.rotation = noise.rotation(local.rotation.normalize());
                local.scale = noise.vector(local.scale);
            }
        }
    }
}

/// Mixes two local transforms: rotations by the shorter way.
fn mixed(from: &Local, to: &Local, part: f64, noise: &mut Noise) -> Local {
    let to_rotation = if from.rotation.dot(to.rotation) < 0.0 { -to.rotation } else { to.rotation };
    let rotation = (from.rotation * (1.0 - part) + to_rotation * part).normalize();
    let between = |a: DVec3, b: DVec3| a * (1.0 - part) + b * part;
    Local {
        translation: noise.vector(between(from.translation, to.translation)),
        rotation: noise.rotation(rotation),
        scale: noise.vector(between(from.scale, to.scale)),
    }
}

/// Returns the directions of a transform's axes, made orthonormal from x to y (Gram and Schmidt).
fn axes(m: &DMat3) -> DMat3 {
    let x = m.x_axis.normalize();
    let y = (m.y_axis - x * x.dot(m.y_axis)).normalize();
    DMat3::from_cols(x, y, x.cross(y))
}

/// Returns a transform between two: the position on the straight line, the axes by the shorter
/// rotation, and their lengths in proportion. A whole part is the given transform itself.
pub(super) fn part_of_the_way(
    from: &DAffine3,
    to: &Local,
    part: f64,
    noise: &mut Noise,
) -> DAffine3 {
    let to = parent_from_joint(to);
    if part >= 1.0 {
        return DAffine3 { matrix3: noise.matrix(to.matrix3), ..to };
    }
    let between = DQuat::from_mat3(&(axes(&to.matrix3) * axes(&from.matrix3).transpose()));
    // Devices turn x onto x, then y onto y. The first of these turns loses digits if both are
    // nearly opposite: its quaternion is `2 cos(angle / 2)` long before it is normalised.
    let [x, to_x] = [from.matrix3.x_axis, to.matrix3.x_axis].map(DVec3::normalize);
    let grown = (0.5 * (1.0 + x.dot(to_x))).sqrt().max(1e-6).recip();
    let rotation = noise.rotation_by(short_part_of(between.normalize(), part), grown);
    let turned = DMat3::from_quat(rotation) * from.matrix3;
    let column = |c: usize| {
        let (old, new) = (from.matrix3.col(c).length(), to.matrix3.col(c).length());
        turned.col(c) * (1.0 + (new / old - 1.0) * part)
    };
    let matrix3 = noise.matrix(DMat3::from_cols(column(0), column(1), column(2)));
    let translation = from.translation.lerp(to.translation, part);
    let scale = from.translation.abs() + to.translation.abs();
    DAffine3 { matrix3, translation: translation + noise.vector(scale) - scale }
}

/// Half a turn has two shorter ways; the tests of [`part_of`] keep to one.
#[cfg(test)]
mod tests {
    use super::super::part_of;
    use super::*;

    #[test]
    fn half_of_the_way_is_in_the_middle() {
        let from = DAffine3::from_rotation_z(0.2);
        let to = Local {
            translation: DVec3::X * 2.0,
            rotation: DQuat::from_rotation_z(1.0),
            scale: DVec3::splat(3.0),
        };
        let half = part_of_the_way(&from, &to, 0.5, &mut Noise::none());
        let wanted = DAffine3::from_scale_rotation_translation(
            DVec3::splat(2.0),
            DQuat::from_rotation_z(0.6),
            DVec3::X,
        );
        assert!(half.abs_diff_eq(wanted, 1e-12), "{half:?}");
        let longer = part_of(-DQuat::from_rotation_x(0.5), 0.5);
        assert!(longer.x < 0.0, "a rotation of negative w goes the longer way: {longer:?}");
    }
}
