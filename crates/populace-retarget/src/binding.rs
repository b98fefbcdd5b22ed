//! Binding of clips to skeletons, by joint names or by humanoid roles.

use populace_clip::{COLUMNS_PER_BLOCK, Clip, MotionOrigin, Range, RowBlock};
use populace_model::humanoid::RoleMap;
use populace_model::{JointIndex, Property, Skeleton, Trs};

use crate::Error;
use crate::common::{Common, Soles};
use crate::fit::{BindingReport, Match, columns_by_name, common_of};
use crate::retarget::Retarget;

/// Number of poses, at most, from which the lift of the hips and the pace of the feet are found.
const GROUND_POSES: usize = 128;

/// A clip bound to a skeleton: the rows that the joints follow, the range of each joint, and the
/// pose in the first row.
///
/// Each joint follows the column of its own number. If the clip has other joints, or the same in
/// another order, its rows are converted.
/// Joints and properties that the clip does not drive keep the rest of the bound skeleton; the rest
/// of the clip's own skeleton has no effect on them.
#[derive(Clone, Debug)]
pub struct Binding {
    ranges: Vec<[Range; 3]>,
    blocks: Vec<RowBlock>,
    first_pose: Vec<Trs>,
    converted: Option<Converted>,
    bound_joint_count: usize,
    /// Scale of root motion: distance moved by the body per distance moved by the clip's own
    /// skeleton.
    motion_scale: f32,
    report: BindingReport,
}

/// A clip converted to the skeleton that it is bound to.
#[derive(Clone, Debug)]
pub struct Converted {
    /// Takes the place of the clip. It has no root motion.
    pub clip: Clip,
    /// Converts poses that arrive for a live clip.
    pub retarget: Retarget,
}

impl Binding {
    /// Binds a clip by joint names.
    #[must_use]
    pub fn new(clip: &Clip, skeleton: &Skeleton) -> Self {
        let report = BindingReport::by_name(clip, skeleton);
        let columns = columns_by_name(clip, skeleton);
        let in_order = |(joint, column): (JointIndex, &Option<JointIndex>)| {
            column.is_none_or(|column| column == joint)
        };
        let converted = (!skeleton.joints().zip(&columns).all(in_order)).then(|| Converted {
            clip: clip.arranged(skeleton, &columns),
            retarget: Retarget::by_names(clip, skeleton, &columns),
        });
        let bound_joint_count = columns.iter().flatten().count();
        let drives = |joint: JointIndex, property| {
            columns[joint.index()].is_some_and(|column| clip.drives_property(column, property))
        };
        let rows = converted.as_ref().map_or(clip, |converted| &converted.clip);
        let Places { ranges, blocks, first_pose } = Places::new(rows, skeleton, drives);
        Self { ranges, blocks, first_pose, converted, bound_joint_count, motion_scale: 1.0, report }
    }

    /// Binds a clip by the method that suits: by name if the skeleton is the clip's own
    /// ([`Clip::is_made_for`]), by humanoid roles if both have them, else by name regardless of
    /// rest poses.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] if a binding by name only covers less than
    /// [`BindingReport::LEAST_SHARE`] of the joints that the clip moves.
    pub fn fitting(
        clip: &Clip,
        clip_roles: Option<&RoleMap>,
        skeleton: &Skeleton,
        roles: Option<&RoleMap>,
    ) -> Result<Self, Error> {
        let binding = Self::partial(clip, clip_roles, skeleton, roles)?;
        binding.report.check(clip.name())?;
        Ok(binding)
    }

    /// Like [`fitting`](Self::fitting), but for clips of which only a part is needed, for example
    /// through a mask: a binding by name only may cover any share of the joints.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] if the clip drives joints, but none of this skeleton.
    pub fn partial(
        clip: &Clip,
        clip_roles: Option<&RoleMap>,
        skeleton: &Skeleton,
        roles: Option<&RoleMap>,
    ) -> Result<Self, Error> {
        Ok(match Match::new(clip, clip_roles, skeleton, roles)? {
            Match::Roles(common) => Self::by_common_pose(clip, skeleton, *common),
            Match::Names => Self::new(clip, skeleton),
        })
    }

    /// Binds a clip by humanoid roles: the skeleton's limbs point in the directions of the limbs of
    /// the clip's own skeleton, and the body keeps its own proportions. Both skeletons must face +Z
    /// with +Y up.
    ///
    /// The skeleton is first brought to a common pose: its own rest, with arms and legs rotated to
    /// the directions they have at rest in the clip's own skeleton. The rest is the bind pose
    /// ([`Skeleton::in_bind_pose`]) for both, also in what follows. Head, feet, back and the shape
    /// of the hands stay as they are. Then each joint with a role rotates away from that pose as
    /// its partner rotates away from rest, regardless of the joints in between on either side.
    /// Other joints keep their local rest. Translations move only the root and the hips. They are
    /// scaled by the ratio of the heights of the hips above the feet, and the hips of the common
    /// pose are raised so that the feet are on the ground. Feet and fingers that do not descend
    /// from their limbs follow them.
    ///
    /// If the soles of the skeleton are known ([`Skeleton::with_soles`]), feet, then toes, roll
    /// about their own left-right axes by the smallest angle that keeps the mesh above the ground,
    /// row by row. If the feet of the clip's own body are in the ground by more than a few
    /// hundredths of its size, those of the skeleton may be as well.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] if a map belongs to another skeleton, or the clip drives no joint with
    /// a role that both have.
    pub fn retarget(
        clip: &Clip,
        clip_roles: &RoleMap,
        skeleton: &Skeleton,
        roles: &RoleMap,
    ) -> Result<Self, Error> {
        let common = common_of(clip, clip_roles, skeleton, roles)?;
        Ok(Self::by_common_pose(clip, skeleton, common))
    }

    fn by_common_pose(clip: &Clip, skeleton: &Skeleton, mut common: Common<'_>) -> Self {
        let bound_joint_count = common.driven_joints(clip).count();
        let every = clip.row_count().div_ceil(GROUND_POSES).max(1);
        let poses: Vec<_> = clip.row_poses(every).collect();
        common.keep_above_ground(&poses);
        let heels = Soles::new(&common).map_or(0.0, |soles| soles.heel_lift(&poses));
        common.lift_by(heels);
        let soles = Soles::new(&common);
        let by_feet =
            clip.root_motion().is_some_and(|motion| *motion.origin() == MotionOrigin::Feet);
        let motion_scale = if by_feet {
            common.ground_speed_ratio(&poses, soles.as_ref())
        } else {
            common.leg_ratio()
        };
        let report = BindingReport::by_roles(clip, skeleton, &common);
        let retarget = Retarget::by_roles(&common);
        let clip = retarget.clip(clip, &common, soles.as_ref());
        let skeleton = skeleton.in_bind_pose();
        let drives = |joint, property| clip.drives_property(joint, property);
        let Places { ranges, blocks, first_pose } = Places::new(&clip, skeleton, drives);
        let converted = Some(Converted { clip, retarget });
        Self { ranges, blocks, first_pose, converted, bound_joint_count, motion_scale, report }
    }

    /// The range of each joint and [`Property`].
    #[must_use]
    pub fn ranges(&self) -> &[[Range; 3]] {
        &self.ranges
    }

    /// Location within a row of each 16 joints. Properties that none of them follows have no
    /// planes.
    #[must_use]
    pub fn blocks(&self) -> &[RowBlock] {
        &self.blocks
    }

    /// Local transforms of all joints in the clip's first row, from which additive layers take
    /// differences. For a live clip, it is the pose before the first one arrives.
    #[must_use]
    pub fn first_pose(&self) -> &[Trs] {
        &self.first_pose
    }

    /// The clip converted to the skeleton, whose rows the joints follow; `None` if the clip has
    /// them in the skeleton's order.
    #[must_use]
    pub fn converted(&self) -> Option<&Converted> {
        self.converted.as_ref()
    }

    /// Scale of root motion: distance moved by the body per distance moved by the clip's skeleton.
    #[must_use]
    pub fn motion_scale(&self) -> f32 {
        self.motion_scale
    }

    /// Report on how well the clip fits the skeleton.
    #[must_use]
    pub fn report(&self) -> &BindingReport {
        &self.report
    }

    /// Number of joints that the clip drives, moving or not.
    #[must_use]
    pub fn bound_joint_count(&self) -> usize {
        self.bound_joint_count
    }
}

/// Ranges, row blocks and first pose of the joints of a skeleton that a clip is bound to.
struct Places {
    ranges: Vec<[Range; 3]>,
    blocks: Vec<RowBlock>,
    first_pose: Vec<Trs>,
}

impl Places {
    /// Each joint follows the column of its own number in the properties of which `drives` is true.
    fn new(
        clip: &Clip,
        skeleton: &Skeleton,
        drives: impl Fn(JointIndex, Property) -> bool,
    ) -> Self {
        let range = |joint: JointIndex, property: Property| match drives(joint, property) {
            true => clip.ranges()[joint.index()][property as usize],
            false => Range::still(property.of(skeleton.rest(joint))),
        };
        let ranges: Vec<_> =
            skeleton.joints().map(|joint| Property::ALL.map(|p| range(joint, p))).collect();
        let first = clip.first_pose();
        let first_pose = skeleton.joints().map(|joint| {
            let from = |property| match drives(joint, property) {
                true => &first[joint.index()],
                false => skeleton.rest(joint),
            };
            Trs {
                translation: from(Property::Translation).translation,
                rotation: from(Property::Rotation).rotation,
                scale: from(Property::Scale).scale,
            }
        });
        let first_pose = first_pose.collect();
        let blocks =
            ranges.chunks(COLUMNS_PER_BLOCK as usize).enumerate().map(|(block, joints)| {
                let moves =
                    |property: Property| joints.iter().any(|j| j[property as usize].step > 0.0);
                clip.row_blocks()
                    .get(block)
                    .map_or(RowBlock::STILL, |rows| rows.with_planes_of(moves))
            });
        let blocks = blocks.collect();
        Self { ranges, blocks, first_pose }
    }
}
