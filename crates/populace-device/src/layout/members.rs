//! Bodies, the members that have them, and what beside clips moves these.

use super::*;

device_struct! {
    /// A body: a skeleton and the palette entries of the meshes on it. Offsets count elements of
    /// the tables named.
    pub struct Body {
        /// Into `parents`.
        pub joint_first: u32,
        /// Joints.
        pub joint_count: u32,
        /// Joints, padded to whole blocks of [`JOINT_BLOCK`].
        pub padded_count: u32,
        /// Into `levels`: `level_count + 1` joint indices, the first of each level and the end of
        /// the last.
        pub level_first: u32,
        /// Levels.
        pub level_count: u32,
        /// Into `poses`: the rest pose, ten planes of `padded_count` floats (see [`POSE_PLANES`]).
        pub rest_first: u32,
        /// Into `entries`.
        pub entry_first: u32,
        /// Palette entries.
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
    pub struct Member {
        /// Into `bodies`, or [`NONE`] for a free place.
        pub body: u32,
        /// Into the joint buffer: the member's first joint, at a whole block.
        pub joint_first: u32,
        /// The member's first palette entry: page times [`PAGE_ENTRIES`] plus the place within the
        /// page.
        pub palette_first: u32,
        /// Layers in use, 1 to [`LAYERS_PER_MEMBER`], in the lower [`MEMBER_LAYER_BITS`]; above
        /// them the phase in which the member is evaluated: 0, or one after that of the member that
        /// it is attached to.
        pub layers_and_phase: u32,
        /// Into `controls`, or [`NONE`] where nothing but clips moves the member.
        pub control: u32,
    }
}

device_struct! {
    /// What beside clips moves a member, and where it stands.
    pub struct Control {
        /// Where in the world its model space lies: position in metres, and scale.
        pub place: Float4,
        /// Sine and cosine of its heading about +Y: 0 faces +Z, a quarter turn +X.
        pub facing: Float4,
        /// Into `steps`.
        pub step_first: u32,
        /// Steps, by joint.
        pub step_count: u32,
        /// Into `overrides`: those in local space.
        pub local_first: u32,
        /// How many those are.
        pub local_count: u32,
        /// Changes with whose control this is, so that nobody takes over another's state.
        pub epoch: u32,
        /// Into `joint_scales`: a factor for the length of each joint's translation, padded, or
        /// [`NONE`].
        pub scale_first: u32,
        /// Steps after those of `step_count`, by joint: users' stages that work on local
        /// transforms.
        pub pose_step_count: u32,
        /// The member's place.
        pub member: u32,
    }
}

device_struct! {
    /// Something to be done on the way down a hierarchy, once a joint's model transform is known.
    pub struct Step {
        /// The joint.
        pub joint: u32,
        /// A `STEP_` kind.
        pub kind: u32,
        /// Into `constraints`, `overrides` or `watched`, or a stage's number, by kind.
        pub index: u32,
        /// The first of the member's turns that it writes, or the one that it takes;
        /// [`STEP_STAGE`]: into `stage_values`;
        /// [`STEP_ATTACH`]: into `overrides`.
        pub turn: u32,
    }
}

device_struct! {
    /// A transform that the host gives a joint.
    pub struct Override {
        /// `x y z`, and the weight from 0 to 1.
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
    pub struct Constraint {
        /// Gaze: where the last joint faces, in its own space, and the tangent of the most to turn
        /// to either side. Limbs: where the middle joint bends to, in the first joint's space.
        pub axis: Float4,
        /// Gaze: the front of the first joint's parent, in that one's space, and the tangent of the
        /// most to turn up. Limbs: the pole, a direction in model space, and 1 where there is one.
        pub front: Float4,
        /// Gaze: up for the first joint's parent, in that one's space, and the tangent of the most
        /// to turn down. Feet: rest height in metres, the height up to which a foot is planted, the
        /// one from which it follows the clip alone, and how far it may be held back.
        pub up: Float4,
        /// Gaze: the most to turn to either side, up, down, in radians. Limbs: the part of the
        /// length in which the chain straightens, then the constraint's weight.
        pub limits: Float4,
        /// Into `links`: the chain, every joint from the first to the last.
        pub link_first: u32,
        /// Joints of the chain.
        pub link_count: u32,
        /// Limbs: the link that bends.
        pub middle: u32,
        /// Feet: the link where the leg begins; those before it lead from the pelvis.
        pub upper: u32,
        /// Into `targets`.
        pub target_first: u32,
        /// Targets; of the first foot, the member's feet.
        pub target_count: u32,
        /// Limbs: 1 where the last joint keeps the rotation that it has without the constraint.
        pub keeps_end: u32,
        /// Of the first foot: 1 where nothing else moves the legs after the pelvis.
        pub at_once: u32,
    }
}

device_struct! {
    /// A joint of a chain.
    pub struct Link {
        /// The joint.
        pub joint: u32,
        /// Its part of a turn that the chain shares.
        pub share: f32,
    }
}

device_struct! {
    /// Something to look at or to reach, with a weight in closed form as that of a slot, eased at
    /// both ends.
    pub struct Target {
        /// A point in metres, or a direction.
        pub point: Float4,
        /// The clock when the weight began to move.
        pub weight_tick: u64,
        /// Weight at `weight_tick`.
        pub start_weight: f32,
        /// Weight per second.
        pub weight_rate: f32,
        /// Where the weight stops.
        pub end_weight: f32,
        /// A `TARGET_` kind.
        pub kind: u32,
        /// [`TARGET_WATCHED`]: into `watched`; `point` is then added, in world space.
        pub watched: u32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// The ground that feet stand on, in world space:
    /// `height = offset + slope_x * x + slope_z * z`, and on a grid of samples within it what these
    /// hold besides.
    pub struct Ground {
        /// Metres at the origin.
        pub offset: f32,
        /// Metres per metre along +X.
        pub slope_x: f32,
        /// Metres per metre along +Z.
        pub slope_z: f32,
        /// Where the grid begins.
        pub grid_x: f32,
        /// Where the grid begins.
        pub grid_z: f32,
        /// Samples per metre; 0 where there is no grid.
        pub per_metre: f32,
        /// Samples along +X, which vary fastest.
        pub count_x: u32,
        /// Samples along +Z.
        pub count_z: u32,
    }
}
