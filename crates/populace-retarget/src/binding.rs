//! Clips bound to skeletons: by joint names, or by humanoid roles.

use glam::DQuat;
use populace_clip::{Clip, MotionOrigin, Range, RowBlock, Storage};
use populace_model::humanoid::RoleMap;
use populace_model::{JointIndex, Property, Skeleton, Trs, f64math};

use crate::Error;
use crate::common::{Chain, ColumnMotion, Common, Figure, Soles, Value};
use crate::fit::BindingReport;

/// Flag in a joint map: the rotation comes from the clip's rows.
pub const MAP_ROTATION: u32 = 1 << 31;
/// Flag in a joint map: the translation comes from the clip's rows.
pub const MAP_TRANSLATION: u32 = 1 << 30;
/// Flag in a joint map: the scale comes from the clip's rows.
pub const MAP_SCALE: u32 = 1 << 29;
/// The bits of a joint map that name the clip's column.
pub const MAP_COLUMN: u32 = (1 << 29) - 1;

/// Poses by which hips are lifted, and the pace of feet is found: some hundred.
const GROUND_POSES: usize = 128;

/// A clip bound to a skeleton: which column each joint follows, and what its stored components
/// mean.
///
/// Joints and properties that the clip does not drive keep the rest of the skeleton bound to,
/// whatever the clip's own skeleton says there.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    joint_map: Vec<u32>,
    ranges: Vec<[Range; 3]>,
    turns: Vec<Vec<Turn>>,
    footing: Option<Footing>,
    bound_joint_count: usize,
    /// How far root motion takes the body, in parts of how far it takes the clip's own.
    motion_scale: f32,
    report: BindingReport,
}

/// What a joint's pose goes through where a clip is retargeted; see
/// `TURN_PLANES` of `populace-device`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The clip's column and `MAP_` flags of what its rows drive.
    pub map: u32,
    /// The rotation of the clip that it goes through.
    pub rotation: Range,
    /// The step of the rotation's w.
    pub step_w: f32,
    /// Added to the translation, turned by the rotation so far.
    pub arm: Range,
    /// A rotation that comes after.
    pub after: [f32; 4],
}

impl Turn {
    /// Changes nothing.
    pub const NONE: Self = Self {
        map: 0,
        rotation: Range { offset: [0.0, 0.0, 0.0, 1.0], step: 0.0 },
        step_w: 0.0,
        arm: Range { offset: [0.0; 4], step: 0.0 },
        after: [0.0, 0.0, 0.0, 1.0],
    };

    /// Whether it adds to the translation.
    #[must_use]
    pub fn has_arm(&self) -> bool {
        self.arm != Self::NONE.arm
    }
}

/// What keeps the feet of a retargeted clip above the ground: a last turn with rows of its own, as
/// many as the clip has.
#[derive(Clone, Debug, PartialEq)]
pub struct Footing {
    /// One for each joint.
    pub turns: Vec<Turn>,
    /// All rows, one after the other; none where it stands still.
    pub rows: Vec<u32>,
    /// Words from one row to the next.
    pub stride: usize,
    /// Where in a row each block of 16 columns stands.
    pub blocks: Vec<RowBlock>,
}

impl Footing {
    /// `None` where nothing would sink.
    fn new(clip: &Clip, soles: &Soles<'_>, joint_count: usize) -> Option<Self> {
        // Rows of live clips are still to come.
        if clip.ring().is_some() {
            return None;
        }
        let rows: Vec<Vec<DQuat>> = clip.row_poses(1).map(|pose| soles.turns(&pose)).collect();
        if rows.iter().all(|row| Soles::are_none(row)) {
            return None;
        }
        let mut turns = vec![Turn::NONE; joint_count];
        let joints = soles.joints();
        if clip.row_stride() == 0 {
            // All rows are one.
            for (joint, turn) in joints.iter().zip(&rows[0]) {
                turns[joint.index()].after = f64math::to_f32(turn.to_array());
            }
            return Some(Self { turns, rows: Vec::new(), stride: 0, blocks: Vec::new() });
        }
        let Storage { words, stride, blocks, ranges, .. } = Storage::of_turns(&rows);
        for ((column, joint), [_, rotation, _]) in (0..).zip(joints).zip(ranges) {
            let map = column | MAP_ROTATION;
            turns[joint.index()] = Turn { map, rotation, step_w: rotation.step, ..Turn::NONE };
        }
        Some(Self { turns, rows: words, stride, blocks })
    }
}

impl Binding {
    fn empty(motion_scale: f32, report: BindingReport) -> Self {
        let (joint_map, ranges, turns) = (Vec::new(), Vec::new(), Vec::new());
        Self { joint_map, ranges, turns, footing: None, bound_joint_count: 0, motion_scale, report }
    }

    /// Binds by name.
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

    /// Binds in the way that suits: by name where the skeleton is that of the clip
    /// ([`Clip::is_made_for`]); by humanoid roles where both have them; else by name, whatever the
    /// rests.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] where names alone bind less than [`BindingReport::LEAST_SHARE`] of the
    /// joints that the clip moves.
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

    /// As [`fitting`](Self::fitting), of a clip of which no more than a part is wanted, such as
    /// through a mask: names alone may bind any share of its joints.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] where the clip drives something, but nothing of this skeleton.
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
                let first = clip.skeleton().name(first);
                let has = |roles: Option<&RoleMap>| if roles.is_some() { "has" } else { "has not" };
                let what = format!(
                    "none of its joints has the name of one that the clip drives, such as \
                     \"{first}\", and humanoid roles, which this skeleton {} and the clip's own \
                     {}, are needed on both; RoleMap::from_names gives them",
                    has(roles),
                    has(clip_roles)
                );
                Err(Error::CannotBind { clip: clip.name().to_owned(), what })
            }
        }
    }

    /// Binds by humanoid roles: the skeleton's limbs point where those of the clip's own skeleton
    /// do, and the body keeps its own proportions. Both skeletons face +Z with +Y up.
    ///
    /// The skeleton is first brought to a common pose, its own rest with arms and legs turned to
    /// where the clip's own skeleton has them at rest; heads, feet, backs and the shape of hands
    /// stay. Then each joint with a role turns away from that pose as its partner turns away from
    /// rest, whatever joints lie between on either side; other joints keep their local rest.
    /// Translations move the root and the hips alone, scaled by how high the hips stand above the
    /// feet on either body, and hips stand so high in the common pose that feet do on the ground.
    /// Feet and fingers that do not hang on their limbs follow these.
    ///
    /// Where the skeleton knows its soles ([`Skeleton::with_soles`]), feet, and then toes, roll
    /// about their own left-right axes by as little as keeps the mesh out of the ground, row by
    /// row; those of the clip's own body may be in it by more than a few hundredths of its size,
    /// and the others then are too.
    ///
    /// # Errors
    ///
    /// [`Error::CannotBind`] where a map is not that of its skeleton, or the clip moves no joint
    /// that both have.
    pub fn retarget(
        clip: &Clip,
        clip_roles: &RoleMap,
        skeleton: &Skeleton,
        roles: &RoleMap,
    ) -> Result<Self, Error> {
        let refused = |what: String| Err(Error::CannotBind { clip: clip.name().to_owned(), what });
        for (map, own) in [(clip_roles, clip.skeleton()), (roles, skeleton)] {
            if map.joint_count() != own.joint_count() {
                let (wanted, has) = (map.joint_count(), own.joint_count());
                return refused(format!(
                    "its roles are those of {wanted} joints, but there are {has}"
                ));
            }
        }
        let mut common =
            Common::new(Figure::new(clip.skeleton(), clip_roles), Figure::new(skeleton, roles));
        let driven =
            |joint: JointIndex| common.partner(joint).is_some_and(|source| clip.drives(source));
        let bound_joint_count = skeleton.joints().filter(|joint| driven(*joint)).count();
        if bound_joint_count == 0 {
            return refused("it drives no joint with a humanoid role that both bodies have".into());
        }
        let every = clip.row_count().div_ceil(GROUND_POSES).max(1);
        let poses: Vec<_> = clip.row_poses(every).collect();
        common.keep_above_ground(&poses);
        let heels = Soles::new(&common).map_or(0.0, |soles| soles.heels(&poses));
        common.lift_by(heels);
        let soles = Soles::new(&common);
        let by_feet =
            clip.root_motion().is_some_and(|motion| *motion.origin() == MotionOrigin::Feet);
        let motion_scale =
            if by_feet { common.pace(&poses, soles.as_ref()) } else { common.legs() };
        let footing = soles.and_then(|soles| Footing::new(clip, &soles, skeleton.joint_count()));
        let report = BindingReport::by_roles(clip, skeleton, &common);
        let mut binding = Self { bound_joint_count, footing, ..Self::empty(motion_scale, report) };
        let motion = |joint: JointIndex| motion(clip, joint);
        for joint in skeleton.joints() {
            binding.push(clip, skeleton.rest(joint), common.chain(joint, &motion));
        }
        Ok(binding)
    }

    /// Adds a joint that goes through a chain, or stays at rest.
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
        for turn in &mut self.turns {
            turn.push(Turn::NONE);
        }
        for (at, link) in links.iter().enumerate() {
            if self.turns.len() <= at {
                self.turns.push(vec![Turn::NONE; joint + 1]);
            }
            let mut turn = Turn { map: link.column.0, ..Turn::NONE };
            turn.after = f64math::to_f32(link.after.normalize().to_array());
            let [translation, rotation, _] = clip.ranges()[link.column.index()];
            if link.turns {
                let [x, y, z, w] = rotation.offset;
                let sign = if link.undone { -1.0 } else { 1.0 };
                let offset = [sign * x, sign * y, sign * z, w];
                turn.rotation = Range { offset, step: sign * rotation.step };
                turn.step_w = rotation.step;
                turn.map |= MAP_ROTATION;
            }
            let mut arm = link.arm;
            if link.arm_scale != 0.0 {
                let [x, y, z, _] = translation.offset;
                arm += link.arm_scale * f64math::vec3([x, y, z]);
                [turn.arm.step] = f64math::to_f32([link.arm_scale * f64::from(translation.step)]);
                turn.map |= MAP_TRANSLATION;
            }
            let [x, y, z] = f64math::to_f32(arm.to_array());
            turn.arm.offset = [x, y, z, 0.0];
            self.turns[at][joint] = turn;
        }
    }

    /// For each joint, in level order, the clip's column and `MAP_` flags of what its rows drive.
    #[must_use]
    pub fn joint_map(&self) -> &[u32] {
        &self.joint_map
    }

    /// For each joint and [`Property`] what its stored components mean.
    #[must_use]
    pub fn ranges(&self) -> &[[Range; 3]] {
        &self.ranges
    }

    /// What poses go through one after the other, of all joints each; empty where the clip is bound
    /// by name.
    #[must_use]
    pub fn turns(&self) -> &[Vec<Turn>] {
        &self.turns
    }

    /// The turn after those.
    #[must_use]
    pub fn footing(&self) -> Option<&Footing> {
        self.footing.as_ref()
    }

    /// How far root motion takes the body, in parts of how far it takes that of the clip.
    #[must_use]
    pub fn motion_scale(&self) -> f32 {
        self.motion_scale
    }

    /// How well the clip fits the skeleton.
    #[must_use]
    pub fn report(&self) -> &BindingReport {
        &self.report
    }

    /// Joints that the clip drives, moving or not.
    #[must_use]
    pub fn bound_joint_count(&self) -> usize {
        self.bound_joint_count
    }
}

/// What a clip does to a column.
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

/// The joint map and ranges of a joint at rest `rest` that follows `column`.
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
