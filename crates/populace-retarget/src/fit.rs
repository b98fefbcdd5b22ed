//! How well a clip fits a skeleton that it is bound to.

use populace_clip::Clip;
use populace_model::{JointIndex, Skeleton, f64math};

use crate::Error;
use crate::common::Common;

/// How a clip's joints were brought together with those of a skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingMethod {
    /// By name, and the skeleton rests as the clip's own does ([`Clip::is_made_for`]).
    SameRest,
    /// By humanoid roles, which bring both bodies to a common pose.
    Roles,
    /// By name alone, whatever the rest poses.
    Names,
}

/// How well a clip fits a skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BindingReport {
    /// How its joints were found.
    pub way: BindingMethod,
    /// Joints that the clip moves; of one that moves none, those that it sets.
    pub moving_joints: usize,
    /// Those of them that move the skeleton.
    pub bound_joints: usize,
    /// How far the rest poses are turned from each other in radians, in the mean over bound joints:
    /// by names, local rotations; by roles, what brings the body from its rest to the common pose.
    pub rest_turn_rad: f32,
    /// How far local translations at rest differ, in parts of the larger body's size and in the
    /// mean over bound joints; 0 by roles, which keep the body's own.
    pub rest_shift: f32,
}

impl BindingReport {
    /// The least share of a clip's moving joints that names alone must bind, unless a part of the
    /// clip is asked for.
    pub const LEAST_SHARE: f32 = 0.3;

    /// The share of the clip's moving joints that move the skeleton, 0 to 1; 1 for a clip that sets
    /// nothing.
    #[must_use]
    pub fn share(&self) -> f32 {
        if self.moving_joints == 0 {
            1.0
        } else {
            self.bound_joints as f32 / self.moving_joints as f32
        }
    }

    /// Refuses a clip of which names alone bind too little.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] below [`LEAST_SHARE`](Self::LEAST_SHARE).
    pub fn check(&self, clip: &str) -> Result<(), Error> {
        if self.way != BindingMethod::Names || self.share() >= Self::LEAST_SHARE {
            return Ok(());
        }
        let what = format!(
            "it has the names of {} of the {} joints that the clip moves, less than {:.0} %, and \
             not both have humanoid roles. RoleMap::from_names gives roles; Play::partial plays \
             such a clip as it is",
            self.bound_joints,
            self.moving_joints,
            100.0 * Self::LEAST_SHARE
        );
        Err(Error::CannotBind { clip: clip.to_owned(), what })
    }

    pub(crate) fn by_name(clip: &Clip, skeleton: &Skeleton) -> Self {
        let own = clip.skeleton();
        let found = |joint: JointIndex| skeleton.find(own.name(joint)).map(|bound| (joint, bound));
        let moving = moving(clip);
        let pairs: Vec<_> = moving.iter().filter_map(|joint| found(*joint)).collect();
        let size = f64::from(skeleton.size_m().max(own.size_m()));
        let apart = |(a, b): &(JointIndex, JointIndex)| {
            let (a, b) = (own.rest(*a), skeleton.rest(*b));
            let turned = f64math::quat(a.rotation).angle_between(f64math::quat(b.rotation));
            let shifted = f64math::vec3(a.translation).distance(f64math::vec3(b.translation));
            [turned, shifted / size]
        };
        let [rest_turn_rad, rest_shift] = mean(pairs.iter().map(apart));
        let way =
            if clip.is_made_for(skeleton) { BindingMethod::SameRest } else { BindingMethod::Names };
        Self {
            way,
            moving_joints: moving.len(),
            bound_joints: pairs.len(),
            rest_turn_rad,
            rest_shift,
        }
    }

    pub(crate) fn by_roles(clip: &Clip, skeleton: &Skeleton, common: &Common<'_>) -> Self {
        let partners: Vec<_> =
            skeleton.joints().filter_map(|joint| common.partner(joint)).collect();
        // What lies above a partner turns it too.
        let leads = |joint: &JointIndex| {
            partners
                .iter()
                .any(|partner| joint == partner || clip.skeleton().is_below(*partner, *joint))
        };
        let moving = moving(clip);
        let bound_joints = moving.iter().filter(|joint| leads(joint)).count();
        let paired = skeleton.joints().filter(|joint| common.partner(*joint).is_some());
        let [rest_turn_rad, _] = mean(paired.map(|joint| [common.turned_rad(joint), 0.0]));
        Self {
            way: BindingMethod::Roles,
            moving_joints: moving.len(),
            bound_joints,
            rest_turn_rad,
            rest_shift: 0.0,
        }
    }
}

/// Joints of its own skeleton that a clip moves, or those that it sets where it moves none.
fn moving(clip: &Clip) -> Vec<JointIndex> {
    let driven = || clip.skeleton().joints().filter(|joint| clip.drives(*joint));
    let moves =
        |joint: &JointIndex| clip.ranges()[joint.index()].iter().any(|range| range.step > 0.0);
    let moving: Vec<_> = driven().filter(moves).collect();
    if moving.is_empty() { driven().collect() } else { moving }
}

fn mean(values: impl Iterator<Item = [f64; 2]>) -> [f32; 2] {
    let (sum, count) =
        values.fold(([0.0; 2], 0.0), |([a, b], n), [x, y]| ([a + x, b + y], n + 1.0));
    f64math::to_f32(sum.map(|sum| sum / f64::max(count, 1.0)))
}
