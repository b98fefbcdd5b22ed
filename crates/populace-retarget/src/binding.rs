//! Binding of clips to skeletons, by joint names or by humanoid roles.

use glam::DQuat;
use populace_clip::{Clip, MotionOrigin, Range, RowBlock, Storage};
use populace_model::humanoid::RoleMap;
use populace_model::{JointIndex, Property, Skeleton, Trs, f64math};

use crate::common::{Chain, ColumnMotion, Common, Figure, Soles, Value};
use crate::fit::BindingReport;
use crate::{BindingFault, Error};

/// Flag in a joint map: the rotation comes from the clip's rows.
pub const MAP_ROTATION: u32 = 1 << 31;
/// Flag in a joint map: the translation comes from the clip's rows.
pub const MAP_TRANSLATION: u32 = 1 << 30;
/// Flag in a joint map: the scale comes from the clip's rows.
pub const MAP_SCALE: u32 = 1 << 29;
/// The bits of a joint map that name the clip's column.
pub const MAP_COLUMN: u32 = (1 << 29) - 1;

/// Number of poses, at most, from which the lift of the hips and the pace of the feet are found.
const GROUND_POSES: usize = 128;

/// A clip bound to a skeleton: the column that each joint follows, and the range of its stored
/// components.
///
/// Joints and properties that the clip does not drive keep the rest of the bound skeleton; the rest
/// of the clip's own skeleton has no effect on them.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    joint_map: Vec<u32>,
    ranges: Vec<[Range; 3]>,
    corrections: Vec<Vec<Correction>>,
    foot_correction: Option<FootCorrection>,
    bound_joint_count: usize,
    /// Scale of root motion: distance moved by the body per distance moved by the clip's own
    /// skeleton.
    motion_scale: f32,
    report: BindingReport,
}

/// A retarget correction of one joint; see `CORRECTION_PLANES` of populace-device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// The clip's column and `MAP_` flags of what its rows drive.
    pub map: u32,
    /// The range of the clip's rotation that the correction applies.
    pub rotation: Range,
    /// The step of the rotation's w.
    pub step_w: f32,
    /// The range of the arm, which is added to the translation after rotation.
    pub arm: Range,
    /// The rotation applied last.
    pub after: [f32; 4],
}

impl Correction {
    /// The correction that changes nothing.
    pub const NONE: Self = Self {
        map: 0,
        rotation: Range { offset: [0.0, 0.0, 0.0, 1.0], step: 0.0 },
        step_w: 0.0,
        arm: Range { offset: [0.0; 4], step: 0.0 },
        after: [0.0, 0.0, 0.0, 1.0],
    };

    /// Returns whether the correction changes the translation.
    #[must_use]
    pub fn has_arm(&self) -> bool {
        self.arm != Self::NONE.arm
    }
}

/// The correction that keeps the feet of a retargeted clip above the ground. It comes last and has
/// its own rows, one for each row of the clip.
#[derive(Clone, Debug, PartialEq)]
pub struct FootCorrection {
    /// One correction per joint.
    pub corrections: Vec<Correction>,
    /// All rows, one after the other; empty if the correction is constant.
    pub rows: Vec<u32>,
    /// Words from one row to the next.
    pub stride: usize,
    /// Location of each block of 16 columns within a row.
    pub blocks: Vec<RowBlock>,
}

impl FootCorrection {
    /// Returns `None` if no foot needs a correction.
    fn new(clip: &Clip, soles: &Soles<'_>, joint_count: usize) -> Option<Self> {
        // Live clips have no rows yet.
        if clip.ring().is_some() {
            return None;
        }
        let rows: Vec<Vec<DQuat>> = clip.row_poses(1).map(|pose| soles.rotations(&pose)).collect();
        if rows.iter().all(|row| Soles::are_negligible(row)) {
            return None;
        }
        let mut corrections = vec![Correction::NONE; joint_count];
        let joints = soles.joints();
        if clip.row_stride() == 0 {
            // The clip does not move, so that all rows are equal.
            for (joint, correction) in joints.iter().zip(&rows[0]) {
                corrections[joint.index()].after = f64math::to_f32(correction.to_array());
            }
            return Some(Self { corrections, rows: Vec::new(), stride: 0, blocks: Vec::new() });
        }
        let Storage { words, stride, blocks, ranges, .. } = Storage::of_rotations(&rows);
        for ((column, joint), [_, rotation, _]) in (0..).zip(joints).zip(ranges) {
            let map = column | MAP_ROTATION;
            corrections[joint.index()] =
                Correction { map, rotation, step_w: rotation.step, ..Correction::NONE };
        }
        Some(Self { corrections, rows: words, stride, blocks })
    }
}

impl Binding {
    fn empty(motion_scale: f32, report: BindingReport) -> Self {
        let (joint_map, ranges, corrections) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            joint_map,
            ranges,
            corrections,
            foot_correction: None,
            bound_joint_count: 0,
            motion_scale,
            report,
        }
    }

    /// Binds a clip by joint names.
    #[must_use]
    pub fn new(clip: &Clip, skeleton: &Skeleton) -> Self {
        let mut binding = Self::empty(1.0, BindingReport::by_name(clip, skeleton));
        for joint in skeleton.joints() {
            let column = clip.skeleton().find(skeleton.name(joint));
            let column = column.filter(|&column| clip.drives(column));
            binding.bound_joint_count += usize::from(column.is_some());
            let (map, ranges) = bind(clip, column, skeleton.rest(joint));
            binding.joint_map.push(map);
            binding.ranges.push(ranges);
        }
        binding
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
        let by_name = Self::new(clip, skeleton);
        if clip.is_made_for(skeleton) {
            return Ok(by_name);
        }
        if let (Some(clip_roles), Some(roles)) = (clip_roles, roles)
            && let Ok(binding) = Self::retarget(clip, clip_roles, skeleton, roles)
        {
            return Ok(binding);
        }
        let driven = clip.skeleton().joints().find(|joint| clip.drives(*joint));
        match driven.filter(|_| by_name.bound_joint_count == 0) {
            None => Ok(by_name),
            Some(first) => {
                let fault = BindingFault::NoCommonName {
                    joint: clip.skeleton().name(first).to_owned(),
                    skeleton_has_roles: roles.is_some(),
                    clip_has_roles: clip_roles.is_some(),
                };
                Err(Error::CannotBind { clip: clip.name().to_owned(), fault })
            }
        }
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
        let refused = |fault| Err(Error::CannotBind { clip: clip.name().to_owned(), fault });
        for (map, own) in [(clip_roles, clip.skeleton()), (roles, skeleton)] {
            if map.joint_count() != own.joint_count() {
                let (wanted, joints) = (map.joint_count(), own.joint_count());
                return refused(BindingFault::OtherSkeleton { wanted, joints });
            }
        }
        let source = Figure::new(clip.skeleton().in_bind_pose(), clip_roles);
        let standing = skeleton.in_bind_pose();
        let mut common = Common::new(source, Figure::new(standing, roles));
        let driven =
            |joint: JointIndex| common.partner(joint).is_some_and(|source| clip.drives(source));
        let bound_joint_count = skeleton.joints().filter(|joint| driven(*joint)).count();
        if bound_joint_count == 0 {
            return refused(BindingFault::NoCommonRole);
        }
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
        let foot_correction =
            soles.and_then(|soles| FootCorrection::new(clip, &soles, skeleton.joint_count()));
        let report = BindingReport::by_roles(clip, skeleton, &common);
        let mut binding =
            Self { bound_joint_count, foot_correction, ..Self::empty(motion_scale, report) };
        let motion = |joint: JointIndex| motion(clip, joint);
        for joint in skeleton.joints() {
            binding.push(clip, standing.rest(joint), common.chain(joint, &motion));
        }
        Ok(binding)
    }

    /// Adds a joint with its chain of corrections, or one at rest.
    fn push(&mut self, clip: &Clip, rest: &Trs, chain: Option<Chain>) {
        let joint = self.joint_map.len();
        let (mut at_rest, mut links) = (*rest, Vec::new());
        if let Some(chain) = chain {
            at_rest.rotation = f64math::to_f32(chain.before.normalize().to_array());
            at_rest.translation =
                chain.base.map_or(rest.translation, |base| f64math::to_f32(base.to_array()));
            links = chain.links;
        }
        let (map, ranges) = bind(clip, None, &at_rest);
        self.joint_map.push(map);
        self.ranges.push(ranges);
        for correction in &mut self.corrections {
            correction.push(Correction::NONE);
        }
        for (at, link) in links.iter().enumerate() {
            if self.corrections.len() <= at {
                self.corrections.push(vec![Correction::NONE; joint + 1]);
            }
            let mut correction = Correction { map: link.column.0, ..Correction::NONE };
            correction.after = f64math::to_f32(link.after.normalize().to_array());
            let [translation, rotation, _] = clip.ranges()[link.column.index()];
            if link.rotates {
                let [x, y, z, w] = rotation.offset;
                let sign = if link.undone { -1.0 } else { 1.0 };
                let offset = [sign * x, sign * y, sign * z, w];
                correction.rotation = Range { offset, step: sign * rotation.step };
                correction.step_w = rotation.step;
                correction.map |= MAP_ROTATION;
            }
            let mut arm = link.arm;
            if link.arm_scale != 0.0 {
                let [x, y, z, _] = translation.offset;
                arm += link.arm_scale * f64math::vec3([x, y, z]);
                [correction.arm.step] =
                    f64math::to_f32([link.arm_scale * f64::from(translation.step)]);
                correction.map |= MAP_TRANSLATION;
            }
            let [x, y, z] = f64math::to_f32(arm.to_array());
            correction.arm.offset = [x, y, z, 0.0];
            self.corrections[at][joint] = correction;
        }
    }

    /// For each joint, in level order, the clip's column, and `MAP_` flags for the properties that
    /// the clip's rows drive.
    #[must_use]
    pub fn joint_map(&self) -> &[u32] {
        &self.joint_map
    }

    /// The range of each joint and [`Property`].
    #[must_use]
    pub fn ranges(&self) -> &[[Range; 3]] {
        &self.ranges
    }

    /// The corrections that poses go through one after the other, each with one element per joint;
    /// empty if the clip is bound by name.
    #[must_use]
    pub fn corrections(&self) -> &[Vec<Correction>] {
        &self.corrections
    }

    /// The foot correction, which comes after those.
    #[must_use]
    pub fn foot_correction(&self) -> Option<&FootCorrection> {
        self.foot_correction.as_ref()
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

/// Returns what the clip does to a column: constant values or motion.
fn motion(clip: &Clip, column: JointIndex) -> ColumnMotion {
    let [translation, rotation, _] = clip.ranges()[column.index()];
    let [x, y, z, _] = translation.offset;
    let still = f64math::vec3([x, y, z]);
    ColumnMotion {
        rotation: if rotation.step > 0.0 {
            Value::Moving
        } else {
            Value::Still(f64math::quat(rotation.offset).normalize())
        },
        translation: if translation.step > 0.0 { Value::Moving } else { Value::Still(still) },
    }
}

/// Returns the joint map and the ranges of a joint with rest `rest` that follows `column`.
fn bind(clip: &Clip, column: Option<JointIndex>, rest: &Trs) -> (u32, [Range; 3]) {
    let mut map = column.map_or(0, |column| column.0);
    let ranges = [Property::Translation, Property::Rotation, Property::Scale].map(|property| {
        let driven = column.filter(|&column| clip.drives_property(column, property));
        let range = driven.map_or_else(
            || Range::still(property.of(rest)),
            |column| clip.ranges()[column.index()][property as usize],
        );
        if range.step > 0.0 {
            map |= match property {
                Property::Rotation => MAP_ROTATION,
                Property::Translation => MAP_TRANSLATION,
                Property::Scale => MAP_SCALE,
            };
        }
        range
    });
    (map, ranges)
}
