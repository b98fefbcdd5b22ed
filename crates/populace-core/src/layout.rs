//! The structs and constants that host and devices share, each declared once.
//!
//! `device_struct!` emits a `#[repr(C)]` [`bytemuck::Pod`] type, its OpenCL C twin as text, and the table of its
//! fields, which a probe kernel's `sizeof` and offsets are compared with in a test. `device_consts!` emits a constant
//! and its `#define`. [`opencl_prelude`] joins them all into the head of every OpenCL program.
//!
//! `Pod` refuses hidden padding, and there is no three-component vector to declare: it is 16 bytes on a device.

/// Four floats, aligned to 16 bytes as an OpenCL `float4`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Float4(pub [f32; 4]);

impl Float4 {
    /// From three components and a fourth of zero.
    #[must_use]
    pub const fn from_xyz(v: [f32; 3]) -> Self {
        Self([v[0], v[1], v[2], 0.0])
    }

    /// The first three components.
    #[must_use]
    pub const fn xyz(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }
}

/// A struct that host and devices lay out alike.
pub trait DeviceStruct: bytemuck::Pod {
    /// The name in both languages.
    const NAME: &'static str;
    /// The declaration in OpenCL C.
    const OPENCL_C: &'static str;
    /// Each field's name and offset in bytes.
    const FIELDS: &'static [(&'static str, usize)];
}

macro_rules! opencl_type {
    (f32) => {
        "float"
    };
    (u32) => {
        "uint"
    };
    (u64) => {
        "ulong"
    };
    (Float4) => {
        "float4"
    };
}

macro_rules! device_struct {
    ($(#[$doc:meta])* pub struct $name:ident { $( $(#[$field_doc:meta])* pub $field:ident : $ty:ident ),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $( $(#[$field_doc])* pub $field: $ty ),* }
        impl DeviceStruct for $name {
            const NAME: &'static str = stringify!($name);
            const OPENCL_C: &'static str = concat!("typedef struct {",
                $( " ", opencl_type!($ty), " ", stringify!($field), ";", )* " } ", stringify!($name), ";\n");
            const FIELDS: &'static [(&'static str, usize)] =
                &[$( (stringify!($field), std::mem::offset_of!($name, $field)) ),*];
        }
    };
}

macro_rules! device_consts {
    ($( $(#[$doc:meta])* pub const $name:ident : u32 = $value:expr; )*) => {
        $( $(#[$doc])* pub const $name: u32 = $value; )*
        const CONSTS: &[(&str, u32)] = &[$( (stringify!($name), $value) ),*];
    };
}

device_consts! {
    /// Stands for "no index": no parent, no mask, no clip, a free place.
    pub const NONE: u32 = u32::MAX;
    /// Joints per block. Each member's arrays in the joint buffer are padded to whole blocks: 16 elements of 16 bytes
    /// are 256 bytes (Lister & Day 2012, section 3, "bone buffer"). Rows of clips are stored in blocks of 16 as well.
    pub const JOINT_BLOCK: u32 = 16;
    /// Members whose gazes, limbs and feet one work-item of the wide schedule solves at once: with two legs each, as many legs
    /// as there are lanes. Each has matrices of its own meanwhile.
    pub const MEMBERS_ABREAST: u32 = 8;
    /// Palette entries per block; each member's palette starts at a whole block.
    pub const PALETTE_BLOCK: u32 = 4;
    /// Palette entries per page: 48 MiB a page, within what every OpenCL and OpenGL device allows at once.
    pub const PAGE_ENTRIES: u32 = 1 << 20;
    /// [`Slot::mode`]: the clip starts again at its end.
    pub const SLOT_LOOP: u32 = 0;
    /// [`Slot::mode`]: the clip runs one whole cycle and holds its end.
    pub const SLOT_ONCE: u32 = 1;
    /// [`Slot::mode`]: the clip stands at [`Slot::held_secs`] on its own axis.
    pub const SLOT_HELD: u32 = 2;
    /// [`Slot::mode`]: a live clip ([`ClipRows::ring_rows`]), as it stood [`Slot::phase_rate`] ticks ago; its oldest row holds
    /// before that, its newest after.
    pub const SLOT_LIVE: u32 = 3;
    /// [`Slot::mode`]: one of the two slots of a state machine. [`Slot::bound_clip`] is twice its runner, and which of the two;
    /// each has half the machine's weight, and what it plays and how much of it stands in [`Running`].
    pub const SLOT_MACHINE: u32 = 4;
    /// [`Slot::mode`]: a clip that was left, of which only that remains in which it differed from what took its place. It
    /// weighs nothing; its fields have other meanings, see [`Slot::settling`].
    pub const SLOT_SETTLING: u32 = 5;
    /// The bits of [`Slot::layer_and_mode`] that hold the mode; the layer stands above them.
    pub const SLOT_MODE_BITS: u32 = 8;
    /// Flag in [`Layer::mask_and_mode`]: the layer's differences from each clip's first row are laid over what lies
    /// beneath. Without it the layer's mix replaces that, by weight and mask.
    pub const LAYER_ADDITIVE: u32 = 1 << 31;
    /// The bits of [`Layer::mask_and_mode`] that name the mask; all of them set where the layer has none.
    pub const LAYER_MASK: u32 = (1 << 31) - 1;
    /// The most slots that a member can have.
    pub const SLOTS_MOST: u32 = 8;
    /// Layers of each member.
    pub const LAYERS_PER_MEMBER: u32 = 4;
    /// The bits of [`Member::layers_and_phase`] that count layers; the phase stands above them.
    pub const MEMBER_LAYER_BITS: u32 = 8;
    /// Phases of a frame at most: members attached to nothing, and four levels of what is attached to others.
    pub const PHASES_MOST: u32 = 5;
    /// Flag in a joint map: the rotation comes from the clip's rows.
    pub const MAP_ROTATION: u32 = 1 << 31;
    /// Flag in a joint map: the translation comes from the clip's rows.
    pub const MAP_TRANSLATION: u32 = 1 << 30;
    /// Flag in a joint map: the scale comes from the clip's rows.
    pub const MAP_SCALE: u32 = 1 << 29;
    /// Flag in a [`RowBlock`]'s lanes: the planes hold floats, one for each component.
    pub const ROW_FLOATS: u32 = 1 << 31;
    /// Flag in a [`BoundBlock`]: each joint follows the column of its own lane, all in one block.
    pub const BLOCK_STRAIGHT: u32 = 4;
    /// Flag in a [`BoundBlock`]: what was sampled goes on through the [`BoundClip::next`] clip.
    pub const BLOCK_TURNED: u32 = 8;
    /// Flag in a [`BoundBlock`]: all translations stand at the body's rest; of a turn, it adds nothing to them.
    pub const REST_TRANSLATION: u32 = 1;
    /// Flag in a [`BoundBlock`]: all scales stand at the body's rest.
    pub const REST_SCALE: u32 = 2;
    /// [`Step::kind`]: the joint is turned by a turn that an earlier step wrote.
    pub const STEP_TURN: u32 = 0;
    /// [`Step::kind`]: a chain looks at its targets.
    pub const STEP_GAZE: u32 = 1;
    /// [`Step::kind`]: a limb of two bones reaches for its targets.
    pub const STEP_REACH: u32 = 2;
    /// [`Step::kind`]: a chain of any length reaches for its targets.
    pub const STEP_CHAIN: u32 = 3;
    /// [`Step::kind`]: finds where feet go, sinks the pelvis so that they get there, and solves the legs if they can be at
    /// once. Constraints of a member's feet follow each other, and each has three turns from the step's on.
    pub const STEP_PELVIS: u32 = 4;
    /// [`Step::kind`]: a leg that something moves after the pelvis goes where the pelvis found.
    pub const STEP_FOOT: u32 = 5;
    /// [`Step::kind`]: an override in model space.
    pub const STEP_OVERRIDE: u32 = 6;
    /// [`Step::kind`]: others look at this joint.
    pub const STEP_WATCH: u32 = 7;
    /// [`Step::kind`]: a user's stage, with the member's values at `turn`.
    pub const STEP_STAGE: u32 = 8;
    /// [`Step::kind`]: members of the next phases are attached to this joint.
    pub const STEP_CARRY: u32 = 9;
    /// [`Step::kind`]: a root follows the joint that the member is attached to.
    pub const STEP_ATTACH: u32 = 10;
    /// [`Step::kind`]: clips move the whole body, on from where the frame before left it if `turn` is still the same.
    pub const STEP_MOTION: u32 = 11;
    /// Of a member's state, the first of four elements of its root motion: where its clips have moved it, its heading, how fast
    /// they last did, and how much faster than what it plays it was when something began to settle: shift and turn in a tick.
    pub const MOTION_STATE: u32 = FEET_MOST;
    /// Elements of a row of root motion: a shift, then sine and cosine of a heading.
    pub const MOTION_ELEMENTS: u32 = 2;
    /// The most stages of users.
    pub const STAGES_MOST: u32 = 8;
    /// Parameters of each.
    pub const STAGE_PARAMETERS: u32 = 16;
    /// [`Target::kind`]: a point in the member's model space.
    pub const TARGET_MODEL: u32 = 0;
    /// [`Target::kind`]: a point in the world.
    pub const TARGET_WORLD: u32 = 1;
    /// [`Target::kind`]: a direction in the world.
    pub const TARGET_DIRECTION: u32 = 2;
    /// [`Target::kind`]: a joint of another member, where it was in the frame before.
    pub const TARGET_WATCHED: u32 = 3;
    /// Turns that a member's steps can hand down.
    pub const TURNS_MOST: u32 = 48;
    /// Links of one chain.
    pub const LINKS_MOST: u32 = 24;
    /// Feet of a member.
    pub const FEET_MOST: u32 = 4;
    /// Elements of a member's state.
    pub const STATES_PER_CONTROL: u32 = 8;
    /// Elements of what is watched of a joint: three rows of its matrix, in the world, or in model space for what is attached
    /// to it.
    pub const WATCHED_ELEMENTS: u32 = 3;
    /// Elements of a [`Running`].
    pub const RUNNING_ELEMENTS: u32 = 3;
    /// Parameters of a state machine.
    pub const MACHINE_PARAMETERS: u32 = 8;
    /// [`Condition::kind`]: the parameter is above the value.
    pub const CONDITION_ABOVE: u32 = 0;
    /// [`Condition::kind`]: the parameter is below the value.
    pub const CONDITION_BELOW: u32 = 1;
    /// [`Condition::kind`]: the state was entered so many ticks ago, or more.
    pub const CONDITION_AFTER: u32 = 2;
    /// The bits of a joint map that name the clip's column.
    pub const MAP_COLUMN: u32 = (1 << 29) - 1;
}

device_struct! {
    /// A body: a skeleton and the palette entries of the meshes on it. Offsets count elements of the tables named.
    pub struct Body {
        /// Into `parents`.
        pub joint_first: u32,
        /// Joints.
        pub joint_count: u32,
        /// Joints, padded to whole blocks of [`JOINT_BLOCK`].
        pub padded_count: u32,
        /// Into `levels`: `level_count + 1` joint indices, the first of each level and the end of the last.
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
    /// A clip's rows and where to find the row of a time.
    ///
    /// Of a live clip, which rows come into while it plays, they are a ring after the first row, which stays: additive layers
    /// measure from it. Rows stand [`row_ticks`](Self::row_ticks) apart on the crowd's clock, the newest less than that after
    /// the one before it. Devices count back from it in whole ticks, so nothing is lost however long the stream goes on.
    pub struct ClipRows {
        /// Live clips: the clock at the newest row.
        pub newest_tick: u64,
        /// Into `rows`, in words: the first row.
        pub row_first: u32,
        /// Words from one row to the next.
        pub row_stride: u32,
        /// Rows, at least one; of a live clip those of the ring that have come in.
        pub row_count: u32,
        /// Into `row_blocks`: one for each block of 16 columns.
        pub block_first: u32,
        /// Into `row_times`.
        pub time_first: u32,
        /// Into `buckets`: for each, a row at or before the bucket's start.
        pub bucket_first: u32,
        /// Buckets; 0 where rows are evenly spaced.
        pub bucket_count: u32,
        /// Buckets per second.
        pub buckets_per_sec: f32,
        /// Time of the first row on the clip's own axis.
        pub start_secs: f32,
        /// From the first row to the last.
        pub duration_secs: f32,
        /// Rows per second where they are evenly spaced, else 0.
        pub rows_per_sec: f32,
        /// Rows of a live clip's ring; 0 for others.
        pub ring_rows: u32,
        /// Live clips: ticks from one row to the next.
        pub row_ticks: u32,
        /// Live clips: the newest row's place in the ring.
        pub newest_row: u32,
        /// Live clips: ticks from the row before the newest to that, 1 to [`row_ticks`](Self::row_ticks).
        pub newest_ticks: u32,
        /// Live clips: 1 divided by [`row_ticks`](Self::row_ticks).
        pub per_row_tick: f32,
        /// Live clips: 1 divided by [`newest_ticks`](Self::newest_ticks).
        pub per_newest_tick: f32,
        /// Into `motions`: the first row of its root motion.
        pub motion_first: u32,
        /// Rows of its root motion; 0 where it has none.
        pub motion_count: u32,
        /// Such rows per second.
        pub motion_rows_per_sec: f32,
    }
}

device_struct! {
    /// Where in a row a block of 16 columns stands: for each property the first word, or [`NONE`] where nothing moves,
    /// and the lanes: columns in each plane, with [`ROW_FLOATS`] where planes hold floats instead of 16-bit steps.
    pub struct RowBlock {
        /// First word of the rotations.
        pub rotation_first: u32,
        /// Columns in each of their planes.
        pub rotation_lanes: u32,
        /// First word of the translations.
        pub translation_first: u32,
        /// Columns in each of their planes.
        pub translation_lanes: u32,
        /// First word of the scales.
        pub scale_first: u32,
        /// Columns in each of their planes.
        pub scale_lanes: u32,
    }
}

impl RowBlock {
    /// A block in which nothing moves.
    pub const STILL: Self = Self {
        rotation_first: NONE,
        rotation_lanes: 0,
        translation_first: NONE,
        translation_lanes: 0,
        scale_first: NONE,
        scale_lanes: 0,
    };

    /// What moves in either block, and whether either holds floats; where it stands is that of one.
    #[must_use]
    pub const fn or_moving(mut self, other: &Self) -> Self {
        if other.rotation_first != NONE {
            (self.rotation_first, self.rotation_lanes) =
                (other.rotation_first, self.rotation_lanes | other.rotation_lanes);
        }
        if other.translation_first != NONE {
            (self.translation_first, self.translation_lanes) =
                (other.translation_first, other.translation_lanes);
        }
        if other.scale_first != NONE {
            (self.scale_first, self.scale_lanes) = (other.scale_first, self.scale_lanes | other.scale_lanes);
        }
        self
    }
}

device_struct! {
    /// A clip bound to a body.
    pub struct BoundClip {
        /// Into `clips`.
        pub clip: u32,
        /// Into `joint_maps`: for each joint the clip's column and `MAP_` flags of what its rows drive.
        pub map_first: u32,
        /// Into `poses`: thirteen planes of what the joints' stored components mean (see [`RANGE_PLANES`]).
        pub range_first: u32,
        /// Into `bound_blocks`: one for each block of 16 joints of the body.
        pub block_first: u32,
        /// The body it is bound to; [`NONE`] for a turn, which no slot may name.
        pub body: u32,
        /// Into `bound_clips`: the turn that what was sampled goes through next, or [`NONE`]. A turn is a bound clip whose
        /// ranges are those of [`TURN_PLANES`]; blocks that have no [`BLOCK_TURNED`] do not look at it.
        pub next: u32,
        /// How far root motion takes the body, in parts of how far it takes that of the clip.
        pub motion_scale: f32,
        /// Into `row_blocks`: where in a row the first 16 columns stand.
        pub row_block_first: u32,
        /// Into `rows`, in words: where the rows of a turn begin that has its own, one for each of the clip's.
        pub row_first: u32,
        /// Words from one of these to the next; 0 where the clip's rows are taken.
        pub row_stride: u32,
    }
}

device_struct! {
    /// Where 16 neighbouring joints of a body find their columns in a clip's rows. The first six are those of a
    /// [`RowBlock`]: where [`BLOCK_STRAIGHT`] is set, of the one that the joints follow; else a first word only tells
    /// whether anything moves, and lanes whether any of it is held as floats.
    pub struct BoundBlock {
        /// First word of the rotations.
        pub rotation_first: u32,
        /// Columns in each of their planes.
        pub rotation_lanes: u32,
        /// First word of the translations.
        pub translation_first: u32,
        /// Columns in each of their planes.
        pub translation_lanes: u32,
        /// First word of the scales.
        pub scale_first: u32,
        /// Columns in each of their planes.
        pub scale_lanes: u32,
        /// [`BLOCK_STRAIGHT`], [`BLOCK_TURNED`], [`REST_TRANSLATION`] and [`REST_SCALE`].
        pub flags: u32,
        /// Into `sources`.
        pub source_first: u32,
        /// Blocks of the clip that the joints follow; 0 where nothing moves.
        pub source_count: u32,
    }
}

impl BoundBlock {
    /// Where the columns stand if they stand in one block.
    #[inline]
    #[must_use]
    pub const fn rows(&self) -> RowBlock {
        RowBlock {
            rotation_first: self.rotation_first,
            rotation_lanes: self.rotation_lanes,
            translation_first: self.translation_first,
            translation_lanes: self.translation_lanes,
            scale_first: self.scale_first,
            scale_lanes: self.scale_lanes,
        }
    }
}

device_struct! {
    /// A block of columns that some of 16 neighbouring joints follow.
    pub struct Source {
        /// Into `row_blocks`.
        pub block: u32,
        /// Into `source_lanes`: for each of the 16 joints its lane in the block, or [`NONE`] where it follows another.
        pub lanes_first: u32,
    }
}

device_struct! {
    /// One playing clip of a member, in closed form: devices evaluate it from the clock and never write it.
    ///
    /// The phase is a 64-bit fraction of the clip's cycle, `start_phase + elapsed * phase_rate`, wrapping: exact for
    /// all time, and equal on every device. [`SLOT_ONCE`] is at its end when `elapsed * |phase_rate|` fills a cycle,
    /// which the upper half of the 128-bit product tells.
    pub struct Slot {
        /// The clock when the slot began.
        pub start_tick: u64,
        /// Phase per tick, in 2^-64 of the clip's length, two's complement: negative plays backwards. [`SLOT_LIVE`]: how many
        /// ticks ago is shown. [`SLOT_SETTLING`]: how the clip stood when it was left, two floats: in the lower half where in
        /// its rows, in the upper how many times the way to the far row ([`far_row`](crate::far_row)) it would have gone
        /// while the slot settles.
        pub phase_rate: u64,
        /// The clock when the weight began to move. [`SLOT_SETTLING`]: how the clip stood that took this one's place, alike.
        pub weight_tick: u64,
        /// [`SLOT_LOOP`]: the phase at `start_tick`, in 2^-32 of the clip's length. [`SLOT_HELD`]: the bits of the
        /// time that the slot stands at, a single-precision number of seconds on the clip's own axis.
        /// [`SLOT_ONCE`] begins at the clip's start, or at its end where it plays backwards, and has zero here.
        /// [`SLOT_SETTLING`]: into `bound_clips`, the clip that took this one's place.
        pub start_phase: u32,
        /// Into `bound_clips`, or [`NONE`] for an empty slot.
        pub bound_clip: u32,
        /// The `SLOT_` mode in the lower [`SLOT_MODE_BITS`], above them the layer that the slot is mixed in.
        pub layer_and_mode: u32,
        /// Weight up to `weight_tick`. [`SLOT_SETTLING`]: the clip's part of what the layer showed.
        pub start_weight: f32,
        /// Weight per second; 0 where it is at its end from `weight_tick` on. [`SLOT_SETTLING`]: by how much that part would have changed while the slot settles.
        pub weight_rate: f32,
        /// Where the weight stops. [`SLOT_SETTLING`]: 1 divided by the ticks that it settles in.
        pub end_weight: f32,
    }
}

device_struct! {
    /// A state of a machine, for members of one body: what of a [`Slot`] is the same whenever the state is entered.
    pub struct MachineState {
        /// As [`Slot::phase_rate`].
        pub phase_rate: u64,
        /// As [`Slot::start_phase`].
        pub start_phase: u32,
        /// Into `bound_clips`.
        pub bound_clip: u32,
        /// A `SLOT_` mode.
        pub mode: u32,
        /// Into `transitions`: those that lead out of the state, the first that holds is taken.
        pub transition_first: u32,
        /// How many those are.
        pub transition_count: u32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A way out of a state.
    pub struct Transition {
        /// Into `machine_states`.
        pub to: u32,
        /// Into `conditions`: all must hold.
        pub condition_first: u32,
        /// How many those are.
        pub condition_count: u32,
        /// Ticks that the crossfade takes.
        pub fade_ticks: u32,
        /// What the new state's weight rises by in a second; 0 where `fade_ticks` is.
        pub fade_rate: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// What must hold for a transition to be taken.
    pub struct Condition {
        /// [`CONDITION_AFTER`]: ticks since the state was entered.
        pub ticks: u64,
        /// A `CONDITION_` kind.
        pub kind: u32,
        /// Which of the machine's parameters.
        pub parameter: u32,
        /// What it is compared with.
        pub value: f32,
        /// Zero.
        pub unused: u32,
    }
}

device_struct! {
    /// A state machine that a member runs.
    pub struct Runner {
        /// The clock when it began.
        pub start_tick: u64,
        /// Into `machine_states`: the state that it begins in, or [`NONE`] for a free place.
        pub state: u32,
        /// Changes with whose runner this is, so that nobody goes on in another's state; never 0.
        pub epoch: u32,
    }
}

device_struct! {
    /// Where a [`Runner`] is: written by devices once a frame, and as whole ticks and comparisons alone lead there, the same
    /// on all of them.
    pub struct Running {
        /// The clock when the state was entered.
        pub entry_tick: u64,
        /// The clock when the state before was.
        pub previous_tick: u64,
        /// Into `machine_states`.
        pub state: u32,
        /// The state before, which fades out; [`NONE`] in the first.
        pub previous: u32,
        /// Which of the runner's two slots plays the state, 0 or 1; the other plays the one before.
        pub which: u32,
        /// Ticks that the crossfade from the one before takes.
        pub fade_ticks: u32,
        /// What the state's weight rises by in a second.
        pub fade_rate: f32,
        /// That of the runner when this was written; another one's starts anew.
        pub epoch: u32,
        /// Zero.
        pub unused0: u32,
        /// Zero.
        pub unused1: u32,
    }
}

device_struct! {
    /// One layer of a member.
    pub struct Layer {
        /// From 0 to 1; not looked at in layer 0.
        pub weight: f32,
        /// [`LAYER_ADDITIVE`] or not, and in the bits of [`LAYER_MASK`] where in `masks` a weight per joint stands, or
        /// all of them for all joints.
        pub mask_and_mode: u32,
    }
}

device_struct! {
    /// One character of the crowd.
    pub struct Member {
        /// Into `bodies`, or [`NONE`] for a free place.
        pub body: u32,
        /// Into the joint buffer: the member's first joint, at a whole block.
        pub joint_first: u32,
        /// The member's first palette entry: page times [`PAGE_ENTRIES`] plus the place within the page.
        pub palette_first: u32,
        /// Layers in use, 1 to [`LAYERS_PER_MEMBER`], in the lower [`MEMBER_LAYER_BITS`]; above them the phase in which the
        /// member is evaluated: 0, or one after that of the member that it is attached to.
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
        /// Into `joint_scales`: a factor for the length of each joint's translation, padded, or [`NONE`].
        pub scale_first: u32,
        /// Steps after those of `step_count`, by joint: users' stages that work on local transforms.
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
        /// The first of the member's turns that it writes, or the one that it takes; [`STEP_STAGE`]: into `stage_values`;
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
        /// Gaze: where the last joint faces, in its own space, and the tangent of the most to turn to either side. Limbs:
        /// where the middle joint bends to, in the first joint's space.
        pub axis: Float4,
        /// Gaze: the front of the first joint's parent, in that one's space, and the tangent of the most to turn up. Limbs:
        /// the pole, a direction in model space, and 1 where there is one.
        pub front: Float4,
        /// Gaze: up for the first joint's parent, in that one's space, and the tangent of the most to turn down. Feet: rest
        /// height in metres, the height up to which a foot is planted, the one from which it follows the clip alone, and
        /// how far it may be held back.
        pub up: Float4,
        /// Gaze: the most to turn to either side, up, down, in radians. Limbs: the part of the length in which the chain
        /// straightens, then the constraint's weight.
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
    /// Something to look at or to reach, with a weight in closed form as that of a slot, eased at both ends.
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
    /// The ground that feet stand on, in world space: `height = offset + slope_x * x + slope_z * z`, and on a grid of
    /// samples within it what these hold besides.
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

device_struct! {
    /// What the evaluate stage finds for one slot: two neighbouring rows, how far between them, and the weight.
    pub struct SlotSample {
        /// Into `rows`, in words.
        pub row0: u32,
        /// Into `rows`, in words.
        pub row1: u32,
        /// 0 at `row0`, 1 at `row1`.
        pub between: f32,
        /// The slot's weight now; 0 where the slot is empty.
        pub weight: f32,
    }
}

/// Planes of a stored pose, each of `padded_count` floats with joints varying fastest: rotation x y z w, translation
/// x y z, scale x y z.
pub const POSE_PLANES: usize = 10;
/// Planes of a bound clip's ranges, laid out alike: offsets of rotation x y z w and their step, of translation x y z and
/// their step, of scale x y z and their step. A component is `offset + step * n` for the `n` that a row holds; a step of 0
/// leaves the clip's constant, or the body's rest where the clip does not drive the joint.
pub const RANGE_PLANES: usize = 13;
/// Planes of a turn, laid out alike: offsets of a rotation x y z w, the step of x y z, that of w (their signs differ where the
/// rotation is undone), offsets of an arm x y z and their step, and a rotation x y z w that comes after. The pose that goes
/// through a turn has the arm, turned by its rotation so far, added to its translation; then its rotation is multiplied from
/// the right by the turn's two. All of it leaves joints as they are where the rotations are those that change nothing and
/// the arm is 0.
pub const TURN_PLANES: usize = 14;

/// How Rust lays a shared struct out, for comparison with a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The struct's name.
    pub name: &'static str,
    /// Its size in bytes.
    pub size: usize,
    /// Each field's name and offset in bytes.
    pub fields: &'static [(&'static str, usize)],
}

/// The layout of every shared struct.
#[must_use]
pub fn device_structs() -> Vec<StructLayout> {
    fn of<T: DeviceStruct>() -> StructLayout {
        StructLayout { name: T::NAME, size: size_of::<T>(), fields: T::FIELDS }
    }
    vec![
        of::<Body>(),
        of::<Entry>(),
        of::<ClipRows>(),
        of::<RowBlock>(),
        of::<BoundClip>(),
        of::<BoundBlock>(),
        of::<Source>(),
        of::<Slot>(),
        of::<Layer>(),
        of::<Member>(),
        of::<SlotSample>(),
        of::<Control>(),
        of::<Step>(),
        of::<Override>(),
        of::<Constraint>(),
        of::<Link>(),
        of::<Target>(),
        of::<Ground>(),
        of::<MachineState>(),
        of::<Transition>(),
        of::<Condition>(),
        of::<Runner>(),
        of::<Running>(),
    ]
}

/// All constants and structs as OpenCL C, to stand before the kernels.
#[must_use]
pub fn opencl_prelude() -> String {
    let mut text: String = CONSTS.iter().map(|(name, value)| format!("#define {name} {value}u\n")).collect();
    text += &format!("#define TICK_SECS {:.12e}f\n", crate::playback::TICK_SECS);
    text += &format!("#define TICKS_PER_SEC {}.0f\n", crate::playback::TICKS_PER_SEC);
    text += &format!("#define FIRST_TICK {}ul\n", crate::playback::FIRST_TICK);
    for declaration in [
        Body::OPENCL_C,
        Entry::OPENCL_C,
        ClipRows::OPENCL_C,
        RowBlock::OPENCL_C,
        BoundClip::OPENCL_C,
        BoundBlock::OPENCL_C,
        Source::OPENCL_C,
        Slot::OPENCL_C,
        Layer::OPENCL_C,
        Member::OPENCL_C,
        SlotSample::OPENCL_C,
        Control::OPENCL_C,
        Step::OPENCL_C,
        Override::OPENCL_C,
        Constraint::OPENCL_C,
        Link::OPENCL_C,
        Target::OPENCL_C,
        Ground::OPENCL_C,
        MachineState::OPENCL_C,
        Transition::OPENCL_C,
        Condition::OPENCL_C,
        Runner::OPENCL_C,
        Running::OPENCL_C,
    ] {
        text += declaration;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opencl_text_declares_what_rust_declares() {
        assert_eq!(
            Member::OPENCL_C,
            "typedef struct { uint body; uint joint_first; uint palette_first; uint layers_and_phase; uint control; } \
             Member;\n"
        );
        assert!(opencl_prelude().contains("#define JOINT_BLOCK 16u\n"));
    }

    #[test]
    fn a_member_of_four_slots_keeps_within_its_memory() {
        // The fourth number is the member's entry in the list of its page.
        let bytes = size_of::<Member>() + 4 * size_of::<Slot>() + 4 * size_of::<Layer>() + size_of::<u32>();
        assert!(bytes <= 256, "{bytes}");
    }

    #[test]
    fn the_tick_reads_the_same_in_both_languages() {
        let text = opencl_prelude();
        let line = text.lines().find(|l| l.starts_with("#define TICK_SECS")).unwrap();
        let value: f32 = line.split(' ').next_back().unwrap().trim_end_matches('f').parse().unwrap();
        assert_eq!(value.to_bits(), crate::playback::TICK_SECS.to_bits());
    }
}
