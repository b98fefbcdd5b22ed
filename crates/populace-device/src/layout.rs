//! Structs and constants shared by the host and the devices, each declared once.
//!
//! `device_struct!` emits a `#[repr(C)]` [`bytemuck::Pod`] type, the same declaration as OpenCL C
//! text, and a table of field offsets. A test compares that table with the `sizeof` and offsets
//! that a probe kernel reports. `device_consts!` emits a constant and its `#define`.
//! [`opencl_prelude`] joins all of them into the head of every OpenCL program.
//!
//! `Pod` rejects hidden padding. There is no three-component vector type because it occupies 16
//! bytes on a device.

/// Four floats, aligned to 16 bytes as an OpenCL `float4`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Float4(pub [f32; 4]);

impl Float4 {
    /// Builds the vector from three components; the fourth is zero.
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

/// A struct with the same memory layout on the host and on devices.
pub trait DeviceStruct: bytemuck::Pod {
    /// The struct's name in Rust and in OpenCL C.
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
    ($(#[$doc:meta])* pub struct $name:ident {
        $( $(#[$field_doc:meta])* pub $field:ident : $ty:ident ),* $(,)?
    }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $( $(#[$field_doc])* pub $field: $ty ),* }
        impl DeviceStruct for $name {
            const NAME: &'static str = stringify!($name);
            const OPENCL_C: &'static str = concat!("typedef struct {",
                $( " ", opencl_type!($ty), " ", stringify!($field), ";", )*
                " } ", stringify!($name), ";\n");
            const FIELDS: &'static [(&'static str, usize)] =
                &[$( (stringify!($field), std::mem::offset_of!($name, $field)) ),*];
        }
    };
}

/// A constant's value, as OpenCL C writes it.
enum Const {
    U32(u32),
    F32(f32),
}

impl std::fmt::Display for Const {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::U32(value) => write!(f, "{value}u"),
            // The shortest decimal that reads as the same number.
            Self::F32(value) => write!(f, "{value:e}f"),
        }
    }
}

macro_rules! device_const {
    (u32, $value:expr) => {
        Const::U32($value)
    };
    (f32, $value:expr) => {
        Const::F32($value)
    };
}

macro_rules! device_consts {
    ($( $(#[$doc:meta])* pub const $name:ident : $ty:ident = $value:expr; )*) => {
        $( $(#[$doc])* pub const $name: $ty = $value; )*
        const CONSTS: &[(&str, Const)] = &[$( (stringify!($name), device_const!($ty, $value)) ),*];
    };
}

device_consts! {
    /// Marks a missing index: no parent, no mask, no clip, or an unused table entry.
    pub const NONE: u32 = u32::MAX;
    /// Joints per block. Each member's arrays in the joint buffer are padded to whole blocks: 16
    /// elements of 16 bytes are 256 bytes (Lister & Day 2012, section 3.1, fig. 3). Columns of clip
    /// rows are stored in blocks of 16 as well.
    pub const JOINT_BLOCK: u32 = populace_clip::COLUMNS_PER_BLOCK;
    /// Palette entries per block. Each member's palette starts at a block boundary.
    pub const PALETTE_BLOCK: u32 = 4;
    /// Palette entries per page. A page is 48 MiB, within the allocation limit of every OpenCL and
    /// OpenGL device.
    pub const PAGE_ENTRIES: u32 = 1 << 20;
    /// [`Slot::mode`]: the clip loops.
    pub const SLOT_LOOP: u32 = 0;
    /// [`Slot::mode`]: the clip runs once and then holds its end.
    pub const SLOT_ONCE: u32 = 1;
    /// [`Slot::mode`]: the clip is sampled at the fixed time [`Slot::held_secs`] on its own axis.
    pub const SLOT_HELD: u32 = 2;
    /// [`Slot::mode`]: a live clip ([`ClipRows::ring_rows`]), sampled [`Slot::delay_ticks`] in the
    /// past. Before its oldest row that row holds, after its newest row the newest holds.
    pub const SLOT_LIVE: u32 = 3;
    /// [`Slot::mode`]: one of the two slots of a state machine. [`Slot::bound_clip`] is `2 *
    /// machine instance + which`. Each of the two slots has half the machine's weight; [`Running`]
    /// says which clip it plays and at which weight.
    pub const SLOT_MACHINE: u32 = 4;
    /// [`Slot::mode`]: the decaying difference between an outgoing clip and the clip that replaced
    /// it. The slot has weight 0 and is read as an [`InertializationSlot`].
    pub const SLOT_INERTIALIZATION: u32 = 5;
    /// Low bits of [`Slot::layer_and_mode`] that hold the mode; the layer is in the bits above.
    pub const SLOT_MODE_BITS: u32 = 8;
    /// Flag in [`Layer::mask_and_mode`]: the layer is additive. The difference of each clip from
    /// its first row is added to the layers below. Without the flag the layer's mix replaces the
    /// layers below, by weight and mask.
    pub const LAYER_ADDITIVE: u32 = 1 << 31;
    /// Bits of [`Layer::mask_and_mode`] that hold the mask's offset; all of them are set if the
    /// layer has no mask.
    pub const LAYER_MASK: u32 = (1 << 31) - 1;
    /// Maximum number of slots of a member.
    pub const MAX_SLOTS: u32 = 8;
    /// Layers per member.
    pub const LAYERS_PER_MEMBER: u32 = 4;
    /// Low bits of [`Member::layers_and_phase`] that count layers; the phase is in the bits above.
    pub const MEMBER_LAYER_BITS: u32 = 8;
    /// [`Member::layers_and_phase`]: set if no frame evaluates the member.
    pub const MEMBER_HIDDEN: u32 = 0x8000_0000;
    /// Maximum number of phases per frame: one for members attached to nothing, and four levels of
    /// attached members.
    pub const MAX_PHASES: u32 = 5;
    /// Flag in a [`BoundBlock`]: all translations are at the body's rest.
    pub const REST_TRANSLATION: u32 = 1;
    /// Flag in a [`BoundBlock`]: all scales are at the body's rest.
    pub const REST_SCALE: u32 = 2;
    /// Flag in a [`BoundBlock`]: all rotations lie in the hemisphere of the body's rest, whatever
    /// numbers rows hold.
    pub const NEAR_REST: u32 = 4;
    /// Flag in a [`BoundBlock`]: rotations are stored as floats, one plane per component. The next
    /// bit tells it of translations, the bit after that of scales.
    pub const FLOATS: u32 = 8;
    /// [`Step::kind`]: applies a rotation to the joint that an earlier step has written.
    pub const STEP_ROTATION: u32 = 0;
    /// [`Step::kind`]: turns a chain to look at its targets.
    pub const STEP_GAZE: u32 = 1;
    /// [`Step::kind`]: solves a two-bone limb to reach its targets.
    pub const STEP_REACH: u32 = 2;
    /// [`Step::kind`]: solves a chain of any length to reach its targets.
    pub const STEP_CHAIN: u32 = 3;
    /// [`Step::kind`]: finds where the feet go, lowers the pelvis so that they can get there, and
    /// solves the legs right away if possible. The constraints of a member's feet are consecutive,
    /// and each foot owns three rotations, starting at the step's `operand`.
    pub const STEP_PELVIS: u32 = 4;
    /// [`Step::kind`]: solves one leg towards the place that the pelvis step found. Used if other
    /// steps move the leg after the pelvis.
    pub const STEP_FOOT: u32 = 5;
    /// [`Step::kind`]: applies an override in model space.
    pub const STEP_OVERRIDE: u32 = 6;
    /// [`Step::kind`]: writes the joint's world transform for other members or for readback.
    pub const STEP_WATCH: u32 = 7;
    /// [`Step::kind`]: runs a user stage, with the member's values at `operand`.
    pub const STEP_STAGE: u32 = 8;
    /// [`Step::kind`]: writes the joint's model transform for members of later phases that are
    /// attached to it.
    pub const STEP_CARRY: u32 = 9;
    /// [`Step::kind`]: places a root relative to the joint that the member is attached to.
    pub const STEP_ATTACH: u32 = 10;
    /// [`Step::kind`]: moves the whole body by root motion, continuing from the previous frame if
    /// `operand` is unchanged.
    pub const STEP_MOTION: u32 = 11;
    /// First element of root motion in a member's history state.
    ///
    /// A member with a control has [`STATES_PER_CONTROL`] history elements:
    ///
    /// | Element | `x` | `y` | `z` | `w` |
    /// |---|---|---|---|---|
    /// | `PELVIS_STATE` | drop | stood | 0 | bits: `epoch` |
    /// | `FOOT_STATE + 2 i`, planted | anchor x | height of the ground | anchor z | bits |
    /// | `FOOT_STATE + 2 i`, lifted | lag x | height of the ground | lag z | bits |
    /// | `FOOT_STATE + 2 i + 1`, planted | direction x | direction z | height | climb |
    /// | `FOOT_STATE + 2 i + 1`, lifted | lag of the turn | 0 | 0 | climb |
    /// | `MOTION_STATE` | offset x | offset y | offset z | bits: [`Control::motion_epoch`] |
    /// | `MOTION_STATE + 1` | sine of heading | cosine of heading | 0 | 0 |
    /// | `MOTION_STATE + 2` | velocity x | velocity y | velocity z | sine of turn per tick |
    /// | `MOTION_STATE + 3` | excess x | excess y | excess z | sine of turn per tick |
    /// | `MOTION_STATE + 4` | rest x | rest y | rest z | 0 |
    ///
    /// Lengths are in metres, velocities in metres per tick. Feet `i` from 0 to [`MAX_FEET`]` - 1`
    /// have theirs in world space; a member with two feet has all of them within 80 bytes. The
    /// *anchor* is where the sole's pivot stands, and the *direction* that from heel to toes. The
    /// *lag* of a foot is how far it trails behind the clip; that of its turn is the tangent of
    /// half the angle. *Stood* is the time for which all feet have stood, in seconds, at most
    /// [`FOOT_SETTLE_SECS`]. *Height* is that above the ground, and *climb* the speed at which the
    /// foot rises to the ground, in metres per second. The bits of a foot are `epoch <<
    /// FOOT_STATE_BITS`, bit 5 for a lock that was let go within its contact, the index of the
    /// pivot among the points of the sole in bits 1 to 4, and bit 0 for a planted foot. *Velocity*
    /// is that of the last frame. *Excess* is the velocity at the start of an inertialization minus
    /// the velocity of the clips that play since. The *rest* is the part of the offset
    /// that rounding has left out. `epoch` is [`Control::epoch`].
    pub const MOTION_STATE: u32 = FOOT_STATE + 2 * MAX_FEET;
    /// Element of the pelvis in a member's history state; see [`MOTION_STATE`].
    pub const PELVIS_STATE: u32 = 0;
    /// First element of feet in a member's history state, two for each foot; see [`MOTION_STATE`].
    pub const FOOT_STATE: u32 = 1;
    /// Elements per row of root motion: an offset, then sine and cosine of a heading.
    pub const MOTION_ELEMENTS: u32 = 2;
    /// Maximum number of user stages.
    pub const MAX_STAGES: u32 = 8;
    /// Parameters per user stage.
    pub const STAGE_PARAMETERS: u32 = 16;
    /// [`Target::kind`]: a point in the member's model space.
    pub const TARGET_MODEL: u32 = 0;
    /// [`Target::kind`]: a point in the world.
    pub const TARGET_WORLD: u32 = 1;
    /// [`Target::kind`]: a direction in the world.
    pub const TARGET_DIRECTION: u32 = 2;
    /// [`Target::kind`]: a joint of another member, as of the previous frame.
    pub const TARGET_WATCHED: u32 = 3;
    /// Maximum number of rotations that the steps of one member can write for later steps.
    pub const MAX_STEP_ROTATIONS: u32 = 48;
    /// Maximum number of links of one chain.
    pub const MAX_LINKS: u32 = 24;
    /// Maximum number of feet of a member.
    pub const MAX_FEET: u32 = 4;
    /// History elements per control, see [`MOTION_STATE`].
    pub const STATES_PER_CONTROL: u32 = 14;
    /// Elements per watched joint: three rows of its matrix, in world space, or in model space for
    /// joints that members are attached to.
    pub const WATCHED_ELEMENTS: u32 = 3;
    /// Elements per [`Running`].
    pub const RUNNING_ELEMENTS: u32 = 3;
    /// Parameters per state machine.
    pub const MACHINE_PARAMETERS: u32 = 8;
    /// [`Condition::kind`]: the parameter is above the value.
    pub const CONDITION_ABOVE: u32 = 0;
    /// [`Condition::kind`]: the parameter is below the value.
    pub const CONDITION_BELOW: u32 = 1;
    /// [`Condition::kind`]: at least this many ticks have passed since the state was entered.
    pub const CONDITION_AFTER: u32 = 2;
    /// Sum of the weights of two rows of 16-bit numbers, which are whole numbers.
    pub const ROW_PARTS: f32 = 32767.0;
    /// Planes of a stored pose: rotation `x y z w`, translation `x y z`, scale `x y z`. Blocks of
    /// [`JOINT_BLOCK`] joints follow one another. Within a block, planes follow one another, each
    /// with one number for each joint.
    pub const POSE_PLANES: u32 = 10;
    /// Planes of a bound clip, in blocks like those of [`POSE_PLANES`]: ranges, and the pose in the
    /// clip's first row, from which additive layers take differences.
    ///
    /// | Planes | Content |
    /// |---|---|
    /// | 0 to 3, 4 | rotation: offsets `x y z w`, part |
    /// | 5 to 7, 8 | translation: offsets `x y z`, part |
    /// | 9 to 11, 12 | scale: offsets `x y z`, part |
    /// | 13 to 22 | first pose, in the order of [`POSE_PLANES`] |
    ///
    /// A part is a step divided by [`ROW_PARTS`]. A component is `offset + part * n`, where `n` is
    /// the sum of the numbers that are stored in two rows, each times its weight in [`ROW_PARTS`].
    /// With a part of 0 the value is constant: the clip's constant, or the body's rest if the clip
    /// does not drive the joint.
    pub const BOUND_PLANES: u32 = FIRST_POSE_PLANE + POSE_PLANES;
    /// The first of the [`BOUND_PLANES`] that hold the first pose.
    pub const FIRST_POSE_PLANE: u32 = 13;
    /// Weights that sum to less count as none: the inverse of the sum would overflow.
    pub const LEAST_WEIGHT: f32 = 1e-20;
    /// A member is at rest if the weights of layer 0 do not sum to more.
    pub const LEAST_TOTAL: f32 = 1e-3;
    /// Squared lengths below this count as none.
    pub const LEAST_SQUARE: f32 = 1e-20;
    /// First guess of an inverse square root: halves the exponent and balances the error.
    pub const INVERSE_SQRT_BITS: u32 = populace_model::math::INVERSE_SQRT_BITS;
    /// Pi.
    pub const HALF_TURN: f32 = populace_model::math::angle::HALF_TURN;
    /// Pi / 2.
    pub const QUARTER_TURN: f32 = std::f32::consts::FRAC_PI_2;
    /// Directions are looked along to this distance, in metres.
    pub const TARGET_FAR_M: f32 = 1000.0;
    /// Sine of the angle to straight up or down below which the side of a gaze's target counts for
    /// less and less.
    pub const GAZE_STEEP: f32 = 0.17;
    /// Level part of a unit direction below which a gaze has no side to turn from.
    pub const GAZE_UPRIGHT: f32 = 1e-3;
    /// Part of the first bone by which a limb's own bend must stand out to decide where the middle
    /// joint goes.
    pub const LIMB_OWN_BEND: f32 = 0.05;
    /// Largest square in the solution of a limb, above which single precision overflows. Bones of
    /// 1e9 metres reach it when their lengths differ by a factor of a million.
    pub const LIMB_LARGEST_SQUARE: f32 = 1e38;
    /// Passes of the chain solver, always as many, so that the result follows targets smoothly.
    pub const CHAIN_PASSES: u32 = 16;
    /// Time in which a lifted foot makes up for half of what it was held back, in seconds.
    pub const FOOT_RELEASE_SECS: f32 = 0.08;
    /// Time in which a pelvis that was lowered rises again, in seconds.
    pub const PELVIS_RISE_SECS: f32 = 0.12;
    /// Largest lag of a foot's turn: the tangent of half the angle.
    pub const FOOT_MAX_TURN: f32 = 0.35;
    /// Height by which the ground under a sole is off the plane through its pivot, from which it is
    /// on the edge of a step and stands level, in parts of the maximum lag.
    pub const FOOT_EDGE: f32 = 0.1;
    /// Time around a contact in which a foot comes down to the ground or leaves it, in seconds.
    pub const FOOT_NEAR_SECS: f32 = 0.12;
    /// Fastest rise or fall of the ground beneath a lifted foot that the foot follows, in metres
    /// per second.
    pub const FOOT_CLIMB_M_PER_SEC: f32 = 1.5;
    /// Gain and loss of that speed, in metres per second squared.
    pub const FOOT_CLIMB_GAIN: f32 = 15.0;
    /// Distance in front of a lifted foot at which it looks for higher ground, in parts of the
    /// maximum lag.
    pub const FOOT_AHEAD: f32 = 0.5;
    /// Height by which another point of the sole must be lower to become the pivot, in parts of the
    /// maximum lag.
    pub const FOOT_PIVOT_SLACK: f32 = 0.002;
    /// Horizontal distance of the ankle from the hip beyond which a lag lets the lock go, in parts
    /// of the maximum lag.
    pub const FOOT_REACH: f32 = 1.4;
    /// Length of a leg, in parts of the maximum lag.
    pub const FOOT_LEG: f32 = 2.0;
    /// Distance by which the pelvis would have to sink for a lag alone, beyond which the lag lets
    /// the lock go, in parts of the maximum lag. Walkers that set off need that much.
    pub const FOOT_SINK: f32 = 0.26;
    /// The same for a foot whose contacts no clip knows: its lock begins too early.
    pub const FOOT_SINK_UNKNOWN: f32 = 0.08;
    /// Time for which all feet have stood after which one that lags steps below the body, in
    /// seconds. No multiple of usual frames, so that no rounding decides in which it steps.
    pub const FOOT_SETTLE_SECS: f32 = 0.87;
    /// Lag from which a foot does so, in parts of the maximum lag.
    pub const FOOT_SETTLE: f32 = 0.25;
    /// Height to which a foot is lifted that was let go within its contact, in parts of its lag.
    /// Only where clips know contacts: the height of the ankle alone lets feet go in every step.
    pub const FOOT_LIFT: f32 = 0.2;
    /// Part of a clip's length from which a contact counts as one that does not end.
    pub const CONTACT_WHOLE: f32 = 0.999;
    /// Lag of a foot that was let go within its contact at which it is locked again, in parts of
    /// the maximum lag.
    pub const FOOT_RELOCK: f32 = 0.1;
    /// Share of the clips with lift-offs in a layer's weight below which both feet stand.
    pub const FOOT_STEPPING: f32 = 0.02;
    /// Bits of a foot's state below the epoch.
    pub const FOOT_STATE_BITS: u32 = 6;
    /// Maximum number of points of a sole that one joint carries.
    pub const MAX_SOLE_POINTS: u32 = 6;
    /// Largest distance that a pelvis sinks, in parts of a leg's length.
    pub const MAX_PELVIS_SINK: f32 = 0.5;
    /// Largest size of a number that a user's stage may leave; larger ones are refused.
    pub const STAGE_LARGEST: f32 = populace_model::LARGEST;
}

mod clips;
mod members;
mod playing;

pub use clips::*;
pub use members::*;
pub use playing::*;

/// Layout of a shared struct in Rust, for comparison with a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The struct's name.
    pub name: &'static str,
    /// Its size in bytes.
    pub size: usize,
    /// Each field's name and offset in bytes.
    pub fields: &'static [(&'static str, usize)],
}

/// Calls a macro with the name of every shared struct, in the order of [`opencl_prelude`]. What
/// follows the macro's name is passed on before the list.
#[macro_export]
macro_rules! with_device_structs {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            Body, Entry, ClipRows, BoundClip, Contact, BoundBlock, Slot, InertializationSlot,
            Layer, Member, SlotSample, Control, Step, Override, Constraint,
            Link, Target, Ground, MachineState, Transition, Condition, MachineInstance, Running
        }
    };
}

macro_rules! layouts {
    (; $($name:ident),*) => {
        vec![$(StructLayout {
            name: $name::NAME,
            size: size_of::<$name>(),
            fields: $name::FIELDS,
        }),*]
    };
}

macro_rules! declarations {
    (; $($name:ident),*) => {
        [$($name::OPENCL_C),*]
    };
}

/// The layout of every shared struct.
#[must_use]
pub fn device_structs() -> Vec<StructLayout> {
    crate::with_device_structs!(layouts)
}

/// All constants and structs as OpenCL C, to stand before the kernels.
#[must_use]
pub fn opencl_prelude() -> String {
    let mut text: String =
        CONSTS.iter().map(|(name, value)| format!("#define {name} {value}\n")).collect();
    text += &format!("#define TICK_SECS {:.12e}f\n", populace_clip::TICK_SECS);
    text += &format!("#define TICKS_PER_SEC {}.0f\n", populace_clip::TICKS_PER_SEC);
    text += &format!("#define FIRST_TICK {}ul\n", populace_clip::FIRST_TICK);
    for declaration in crate::with_device_structs!(declarations) {
        text += declaration;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opencl_text_matches_rust_declarations() {
        assert_eq!(
            Member::OPENCL_C,
            "typedef struct { uint body; uint joint_first; uint palette_first; uint \
             layers_and_phase; uint control; uint posed; uint shape; } Member;\n"
        );
        assert!(opencl_prelude().contains("#define JOINT_BLOCK 16u\n"));
    }

    #[test]
    fn float_constants_read_the_same_in_opencl() {
        let text = opencl_prelude();
        for (name, value) in [("LEAST_WEIGHT", LEAST_WEIGHT), ("STAGE_LARGEST", STAGE_LARGEST)] {
            let line = format!("#define {name} ");
            let line = text.lines().find_map(|l| l.strip_prefix(&line)).unwrap();
            let read: f32 = line.strip_suffix('f').unwrap().parse().unwrap();
            assert_eq!(read.to_bits(), value.to_bits(), "{name}");
        }
    }

    #[test]
    fn every_device_struct_is_listed() {
        let files = [
            include_str!("layout/clips.rs"),
            include_str!("layout/members.rs"),
            include_str!("layout/playing.rs"),
        ];
        let declared: usize =
            files.iter().map(|file| file.matches("device_struct! {").count()).sum();
        assert_eq!(declared, device_structs().len(), "with_device_structs! lists them all");
    }

    #[test]
    fn a_member_of_four_slots_keeps_within_its_memory() {
        // The fourth number is the member's entry in the list of its page.
        let bytes =
            size_of::<Member>() + 4 * size_of::<Slot>() + 4 * size_of::<Layer>() + size_of::<u32>();
        assert!(bytes <= 256, "{bytes}");
    }

    #[test]
    fn tick_secs_parses_to_the_same_bits_in_opencl() {
        let text = opencl_prelude();
        let line = text.lines().find(|l| l.starts_with("#define TICK_SECS")).unwrap();
        let value: f32 =
            line.split(' ').next_back().unwrap().trim_end_matches('f').parse().unwrap();
        assert_eq!(value.to_bits(), populace_clip::TICK_SECS.to_bits());
    }
}
