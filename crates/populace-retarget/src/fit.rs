//! Reports of how well a clip fits the skeleton that it is bound to.

use populace_clip::Clip;
use populace_model::humanoid::RoleMap;
use populace_model::{JointIndex, Skeleton, f64math};

use crate::common::{Common, Figure};
use crate::{BindingFault, Error};

/// Method of matching a clip's joints with those of a skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingMethod {
    /// By name; the skeleton has the same rest pose as the clip's own ([`Clip::is_made_for`]).
    SameRest,
    /// By humanoid roles, through a common pose of both bodies.
    Roles,
    /// By name only, regardless of rest poses.
    Names,
}

/// Report on the fit of a clip to a skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BindingReport {
    /// Method by which joints were matched.
    pub method: BindingMethod,
    /// Number of joints that the clip moves; for a clip that moves none, those that it sets.
    pub moving_joints: usize,
    /// Number of these joints that affect the skeleton.
    pub bound_joints: usize,
    /// Mean angle between the rest poses over bound joints, in radians. By names: between local
    /// rotations. By roles: between the body's rest and the common pose.
    pub rest_angle_rad: f32,
    /// Mean difference of local translations at rest over bound joints, as a fraction of the larger
    /// body's size. 0 by roles, which keep the body's own translations.
    pub rest_shift: f32,
}

/// Match of a clip's joints with those of a skeleton.
pub(crate) enum Match<'a> {
    /// By humanoid roles, in a common pose.
    Roles(Box<Common<'a>>),
    Names,
}

impl<'a> Match<'a> {
    /// See [`Binding::partial`](crate::Binding::partial).
    pub(crate) fn new(
        clip: &'a Clip,
        clip_roles: Option<&'a RoleMap>,
        skeleton: &'a Skeleton,
        roles: Option<&'a RoleMap>,
    ) -> Result<Self, Error> {
        if !clip.is_made_for(skeleton)
            && let (Some(clip_roles), Some(roles)) = (clip_roles, roles)
            && let Ok(common) = common_of(clip, clip_roles, skeleton, roles)
        {
            return Ok(Self::Roles(Box::new(common)));
        }
        let driven = clip.skeleton().joints().find(|joint| clip.drives(*joint));
        let Some(first) = driven else { return Ok(Self::Names) };
        if columns_by_name(clip, skeleton).iter().any(Option::is_some) {
            return Ok(Self::Names);
        }
        let fault = BindingFault::NoCommonName {
            joint: clip.skeleton().name(first).to_owned(),
            skeleton_has_roles: roles.is_some(),
            clip_has_roles: clip_roles.is_some(),
        };
        Err(Error::CannotBind { clip: clip.name().to_owned(), fault })
    }
}

impl BindingReport {
    /// Minimum share of a clip's moving joints that must be bound by name only, unless a partial
    /// binding is asked for.
    pub const LEAST_SHARE: f32 = 0.3;

    /// Reports how [`Binding::partial`](crate::Binding::partial) binds a clip. Converts nothing.
    ///
    /// # Errors
    ///
    /// As `Binding::partial`.
    pub fn new(
        clip: &Clip,
        clip_roles: Option<&RoleMap>,
        skeleton: &Skeleton,
        roles: Option<&RoleMap>,
    ) -> Result<Self, Error> {
        Ok(match Match::new(clip, clip_roles, skeleton, roles)? {
            Match::Roles(common) => Self::by_roles(clip, skeleton, &common),
            Match::Names => Self::by_name(clip, skeleton),
        })
    }

    /// Share of the clip's moving joints that affect the skeleton, 0 to 1; 1 for a clip without
    /// joints.
    #[must_use]
    pub fn share(&self) -> f32 {
        if self.moving_joints == 0 {
            1.0
        } else {
            self.bound_joints as f32 / self.moving_joints as f32
        }
    }

    /// Checks that a binding by name only covers enough of the clip.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] if the share is below [`LEAST_SHARE`](Self::LEAST_SHARE).
    pub fn check(&self, clip: &str) -> Result<(), Error> {
        if self.method != BindingMethod::Names || self.share() >= Self::LEAST_SHARE {
            return Ok(());
        }
        let (bound, moving) = (self.bound_joints, self.moving_joints);
        let fault = BindingFault::FewJoints { bound, moving, least_share: Self::LEAST_SHARE };
        Err(Error::CannotBind { clip: clip.to_owned(), fault })
    }

    pub(crate) fn by_name(clip: &Clip, skeleton: &Skeleton) -> Self {
        let own = clip.skeleton();
        let found = |joint: JointIndex| skeleton.find(own.name(joint)).map(|bound| (joint, bound));
        let moving = moving(clip);
        let pairs: Vec<_> = moving.iter().filter_map(|joint| found(*joint)).collect();
        let size = f64::from(skeleton.size_m().max(own.size_m()));
        let apart = |(a, b): &(JointIndex, JointIndex)| {
            let (a, b) = (own.rest(*a), skeleton.rest(*b));
            let rotated = f64math::quat(a.rotation).angle_between(f64math::quat(b.rotation));
            let shifted = f64math::vec3(a.translation).distance(f64math::vec3(b.translation));
            [rotated, shifted / size]
        };
        let [rest_angle_rad, rest_shift] = mean(pairs.iter().map(apart));
        let method =
            if clip.is_made_for(skeleton) { BindingMethod::SameRest } else { BindingMethod::Names };
        Self {
            method,
            moving_joints: moving.len(),
            bound_joints: pairs.len(),
            rest_angle_rad,
            rest_shift,
        }
    }

    pub(crate) fn by_roles(clip: &Clip, skeleton: &Skeleton, common: &Common<'_>) -> Self {
        let partners: Vec<_> =
            skeleton.joints().filter_map(|joint| common.partner(joint)).collect();
        // Joints above a partner turn it as well.
        let leads = |joint: &JointIndex| {
            partners
                .iter()
                .any(|partner| joint == partner || clip.skeleton().is_below(*partner, *joint))
        };
        let moving = moving(clip);
        let bound_joints = moving.iter().filter(|joint| leads(joint)).count();
        let paired = skeleton.joints().filter(|joint| common.partner(*joint).is_some());
        let [rest_angle_rad, _] = mean(paired.map(|joint| [common.rotated_rad(joint), 0.0]));
        Self {
            method: BindingMethod::Roles,
            moving_joints: moving.len(),
            bound_joints,
            rest_angle_rad,
            rest_shift: 0.0,
        }
    }
}

/// Returns the joint of the clip's own skeleton that each joint follows by its name.
pub(crate) fn columns_by_name(clip: &Clip, skeleton: &Skeleton) -> Vec<Option<JointIndex>> {
    let column = |joint| {
        let column = clip.skeleton().find(skeleton.name(joint));
        column.filter(|&column| clip.drives(column))
    };
    skeleton.joints().map(column).collect()
}

/// Returns both bodies in their common pose, before the hips are raised.
pub(crate) fn common_of<'a>(
    clip: &'a Clip,
    clip_roles: &'a RoleMap,
    skeleton: &'a Skeleton,
    roles: &'a RoleMap,
) -> Result<Common<'a>, Error> {
    let refused = |fault| Err(Error::CannotBind { clip: clip.name().to_owned(), fault });
    for (map, own) in [(clip_roles, clip.skeleton()), (roles, skeleton)] {
        if map.joint_count() != own.joint_count() {
            let (wanted, joints) = (map.joint_count(), own.joint_count());
            return refused(BindingFault::OtherSkeleton { wanted, joints });
        }
    }
    let source = Figure::new(clip.skeleton().in_bind_pose(), clip_roles);
    let common = Common::new(source, Figure::new(skeleton.in_bind_pose(), roles));
    if common.driven_joints(clip).next().is_none() {
        return refused(BindingFault::NoCommonRole);
    }
    Ok(common)
}

/// Returns the joints of its own skeleton that a clip moves, or those that it sets if it moves
/// none.
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
