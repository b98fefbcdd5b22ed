//! Bodies, members, and the constraint programs that move members besides clips.

use super::*;

device_struct! {
    /// A body: a skeleton and the palette entries of its meshes.
    ///
    /// A reduced body has the first joints of a body, and all of its entries: those of the other
    /// joints hang, at rest, from the nearest ancestor that is left. It shares the body's parents,
    /// rest pose and clips.
    pub struct Body {
        /// Offset into `parents`.
        pub joint_first: u32,
        /// Number of joints.
        pub joint_count: u32,
        /// Number of joints, padded to whole blocks of [`JOINT_BLOCK`]: the joint buffer holds as
        /// many for each member. Reduced bodies have that of the whole body.
        pub padded_count: u32,
        /// Offset into `levels`: `level_count + 1` joint indices, the first of each level and the
        /// end of the last.
        pub level_first: u32,
        /// Number of levels.
        pub level_count: u32,
        /// Offset into `poses`: the rest pose, the planes of [`POSE_PLANES`].
        pub rest_first: u32,
        /// Offset into `entries`.
        pub entry_first: u32,
        /// Number of palette entries.
        pub entry_count: u32,
    }
}

device_struct! {
    /// A palette entry: `joint_from_bind` as three rows, for one joint.
    pub struct Entry {
        /// First row of `joint_from_bind`.
        pub row0: Float4,
        /// Second row.
        pub row1: Float4,
        /// Third row.
        pub row2: Float4,
        /// The joint, in level order.
        pub joint: u32,
        /// Zero.
        pub unused0: u32,
        /// Zero.
        pub unused1: u32,
        /// Zero.
        pub unused2: u32,
    }
}

device_struct! {
    /// One character of the crowd.
    ///
    /// Packed fields:
    ///
    /// | Field | Bits | Content |
    /// |---|---|---|
    /// | `palette_first` | 20 to 31 | palette page |
    /// | `palette_first` | 0 to 19 | first palette entry within the page |
    /// | `layers_and_phase` | 31 | 1 if the member is hidden: no frame evaluates it |
    /// | `layers_and_phase` | 8 to 30 | phase, 0 to [`MAX_PHASES`]` - 1` |
    /// | `layers_and_phase` | 0 to 7 | layers in use, 1 to [`LAYERS_PER_MEMBER`] |
    ///
    /// A page has [`PAGE_ENTRIES`] entries, and [`MEMBER_LAYER_BITS`] bits count layers. The phase
    /// says when within a frame the member is evaluated: phase 0 if it is attached to nothing, else
    /// one phase after its parent.
    pub struct Member {
        /// Index into `bodies`, or [`NONE`] for an unused entry.
        pub body: u32,
        /// Offset into the joint buffer: the member's first joint, at a block boundary.
        pub joint_first: u32,
        /// The member's first palette entry over all pages, at a block boundary; see the table
        /// above.
        pub palette_first: u32,
        /// Layers in use and phase; see the table above.
        pub layers_and_phase: u32,
        /// Index into `controls`, or [`NONE`] if only clips move the member.
        pub control: u32,
        /// Index into `bodies`: what frames evaluate. It is `body`, or one of the reduced bodies
        /// that follow it.
        pub posed: u32,
        /// Shape of the constraint program, [`NONE`] without one. Members of one body and shape can
        /// take each step side by side.
        pub shape: u32,
    }
}

device_struct! {
    /// The constraint program of a member, and the member's place in the world.
    pub struct Control {
        /// `x y z` of the model space's origin in the world, in metres, and the member's scale.
        pub place: Float4,
        /// How planted feet step: `x` and `z` where a step of the clips that leads one metre along
        /// +Z leads instead; then the tangent of half the angle that the member turns per metre of
        /// the clips' strides; then 0. A clip as it is has `0 1 0 0`.
        pub stride: Float4,
        /// Sine of the heading about +Y. Heading 0 faces +Z, a quarter turn +X.
        pub sine: f32,
        /// Cosine of the heading.
        pub cosine: f32,
        /// Offset into `steps`. Members with equal programs have the same steps.
        pub step_first: u32,
        /// Number of steps that run during Transform, sorted by joint.
        pub step_count: u32,
        /// Offset into `overrides`: the overrides in local space.
        pub local_first: u32,
        /// Number of overrides in local space.
        pub local_count: u32,
        /// Identifies the owner. History state with another epoch belongs to an earlier member and
        /// is ignored.
        pub epoch: u32,
        /// Offset into `targets`: those of the member's constraints.
        pub target_first: u32,
        /// Identifies the use of root motion. History state with another epoch belongs to an
        /// earlier one and is ignored.
        pub motion_epoch: u32,
        /// Offset into `joint_scales`: a length factor for each joint's translation, padded to
        /// whole blocks, or [`NONE`].
        pub scale_first: u32,
        /// Number of steps after the first `step_count`, sorted by joint: user stages that work on
        /// local transforms.
        pub pose_step_count: u32,
        /// The member's index in `members`.
        pub member: u32,
    }
}

device_struct! {
    /// One operation of a constraint program, run once the joint's model transform is known.
    pub struct Step {
        /// The joint that triggers the step.
        pub joint: u32,
        /// A `STEP_` constant.
        pub kind: u32,
        /// Depends on `kind`: index into `constraints`, `overrides` or watched joints, or number of
        /// a user stage.
        pub index: u32,
        /// The first of the member's rotations that the step writes, or the one that it applies.
        /// [`STEP_STAGE`]: offset into `stage_values`. [`STEP_ATTACH`]: index into `overrides`.
        pub operand: u32,
    }
}

device_struct! {
    /// A transform that the host sets on a joint.
    pub struct Override {
        /// Translation `x y z`, and the weight from 0 to 1.
        pub translation_and_weight: Float4,
        /// Unit quaternion.
        pub rotation: Float4,
        /// `x y z 0`.
        pub scale: Float4,
        /// The joint.
        pub joint: u32,
        /// Zero.
        pub unused0: u32,
        /// Zero.
        pub unused1: u32,
        /// Zero.
        pub unused2: u32,
    }
}

device_struct! {
    /// A constraint on a chain of joints.
    ///
    /// | Field | `x y z` | `w` |
    /// |---|---|---|
    /// | `axis`, gaze | facing of the last joint, in its own space | tangent of maximum yaw |
    /// | `axis`, limb and foot | bend direction, in the first joint's space | 0 |
    /// | `front`, gaze | front, in the space of the first joint's parent | tangent of maximum up |
    /// | `front`, limb | pole direction in model space, or 0 | 1 if there is a pole, else 0 |
    /// | `up`, gaze | up, in the space of the first joint's parent | tangent of maximum down |
    pub struct Constraint {
        /// See the table above.
        pub axis: Float4,
        /// See the table above.
        pub front: Float4,
        /// Gaze: see the table above. Foot, in metres: height of the ankle at rest; height above it
        /// up to which the foot counts as planted, and from which it follows only the clip, if the
        /// contacts of the clips are not known; maximum lag behind the clip.
        pub up: Float4,
        /// Gaze: maximum yaw, pitch up and pitch down, in radians. Limb, chain and foot: fraction
        /// of the length over which the chain straightens, then the constraint's weight. Foot: then
        /// `z` of the middle of its steps, and the ankle's height above the sole if no point of the
        /// sole is known.
        pub limits: Float4,
        /// Offset into `links`: the chain, every joint from the first to the last. Foot: the joints
        /// from the pelvis to the ankle, then those to the toes.
        pub link_first: u32,
        /// Number of joints of the chain.
        pub link_count: u32,
        /// Limb and foot: index of the link that bends.
        pub middle: u32,
        /// Foot: index of the link where the leg begins; the links before it lead down from the
        /// pelvis.
        pub upper: u32,
        /// Offset into the targets of the member.
        pub target_first: u32,
        /// Number of targets. Foot: number of the member's feet.
        pub target_count: u32,
        /// Limb and foot: 1 if the last joint keeps the rotation that it has without the
        /// constraint.
        pub keeps_end: u32,
        /// First foot: 1 if no other step moves the legs after the pelvis, so that they are solved
        /// with it.
        pub at_once: u32,
        /// Foot: offset into `soles` of the points that the ankle carries.
        pub sole_first: u32,
        /// Foot: number of these points.
        pub sole_count: u32,
        /// Foot: offset into `soles` of the points that the last link carries.
        pub toe_first: u32,
        /// Foot: number of these points.
        pub toe_count: u32,
        /// Foot: number of links below the ankle.
        pub toe_links: u32,
        /// Zero.
        pub unused0: u32,
        /// Zero.
        pub unused1: u32,
        /// Zero.
        pub unused2: u32,
    }
}

device_struct! {
    /// A joint of a chain.
    pub struct Link {
        /// The joint.
        pub joint: u32,
        /// Fraction of the chain's total rotation that this joint takes.
        pub share: f32,
    }
}

device_struct! {
    /// A target to look at or to reach. Its weight is a closed-form ramp like that of a slot, eased
    /// at both ends.
    pub struct Target {
        /// A point in metres or a direction, by `kind`. [`TARGET_WATCHED`]: offset added in world
        /// space.
        pub point: Float4,
        /// Clock tick at which the weight begins to change.
        pub weight_tick: u64,
        /// Weight at `weight_tick`.
        pub start_weight: f32,
        /// Change of the weight per second.
        pub weight_rate: f32,
        /// Weight at which the ramp ends.
        pub end_weight: f32,
        /// A `TARGET_` constant.
        pub kind: u32,
        /// [`TARGET_WATCHED`]: index of the watched joint.
        pub watched: u32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// The ground in world space: `height = offset + slope_x * x + slope_z * z`, plus the
    /// bilinearly interpolated height of a sample grid if there is one.
    pub struct Ground {
        /// Height in metres at the origin.
        pub offset: f32,
        /// Metres per metre along +X.
        pub slope_x: f32,
        /// Metres per metre along +Z.
        pub slope_z: f32,
        /// World x of the grid's first sample, in metres.
        pub grid_x: f32,
        /// World z of the grid's first sample, in metres.
        pub grid_z: f32,
        /// Samples per metre; 0 if there is no grid.
        pub per_metre: f32,
        /// Number of samples along +X, which vary fastest.
        pub count_x: u32,
        /// Number of samples along +Z.
        pub count_z: u32,
    }
}
