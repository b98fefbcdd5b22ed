//! The structs and constants that host and devices share, each declared once.
//!
//! `device_struct!` emits a `#[repr(C)]` [`bytemuck::Pod`] type, its OpenCL C twin as text, and the
//! table of its fields, which a probe kernel's `sizeof` and offsets are compared with in a test.
//! `device_consts!` emits a constant and its `#define`. [`opencl_prelude`] joins them all into the
//! head of every OpenCL program.
//!
//! `Pod` refuses hidden padding, and there is no three-component vector to declare: it is 16 bytes
//! on a device.

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
    /// Stands for "no index": no parent, no mask, no clip, a free place.
    pub const NONE: u32 = u32::MAX;
    /// Joints per block. Each member's arrays in the joint buffer are padded to whole blocks: 16
    /// elements of 16 bytes are 256 bytes (Lister & Day 2012, section 3.1, fig. 3). Rows of clips
    /// are stored in blocks of 16 as well.
    pub const JOINT_BLOCK: u32 = populace_clip::COLUMNS_PER_BLOCK;
    /// Members whose gazes, limbs and feet one work-item of the wide schedule solves at once: with
    /// two legs each, as many legs as there are lanes. Each has matrices of its own meanwhile.
    pub const MEMBERS_PER_BATCH: u32 = 8;
    /// Palette entries per block; each member's palette starts at a whole block.
    pub const PALETTE_BLOCK: u32 = 4;
    /// Palette entries per page: 48 MiB a page, within what every OpenCL and OpenGL device allows
    /// at once.
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
    /// [`Slot::mode`]: one of the two slots of a state machine. [`Slot::bound_clip`] is twice its machine instance, and which of the two;
    /// each has half the machine's weight, and what it plays and how much of it stands in
    /// [`Running`].
    pub const SLOT_MACHINE: u32 = 4;
    /// [`Slot::mode`]: a clip that was left, of which only that remains in which it differed from what took its place. It
    /// weighs nothing; its fields have other meanings, see [`Slot::inertialization`].
    pub const SLOT_INERTIALIZATION: u32 = 5;
    /// The bits of [`Slot::layer_and_mode`] that hold the mode; the layer stands above them.
    pub const SLOT_MODE_BITS: u32 = 8;
    /// Flag in [`Layer::mask_and_mode`]: the layer's differences from each clip's first row are
    /// laid over what lies beneath. Without it the layer's mix replaces that, by weight and mask.
    pub const LAYER_ADDITIVE: u32 = 1 << 31;
    /// The bits of [`Layer::mask_and_mode`] that name the mask; all of them set where the layer has
    /// none.
    pub const LAYER_MASK: u32 = (1 << 31) - 1;
    /// The most slots that a member can have.
    pub const SLOTS_MOST: u32 = 8;
    /// Layers of each member.
    pub const LAYERS_PER_MEMBER: u32 = 4;
    /// The bits of [`Member::layers_and_phase`] that count layers; the phase stands above them.
    pub const MEMBER_LAYER_BITS: u32 = 8;
    /// Phases of a frame at most: members attached to nothing, and four levels of what is attached
    /// to others.
    pub const PHASES_MOST: u32 = 5;
    /// Flag in a joint map: the rotation comes from the clip's rows.
    pub const MAP_ROTATION: u32 = populace_retarget::MAP_ROTATION;
    /// Flag in a joint map: the translation comes from the clip's rows.
    pub const MAP_TRANSLATION: u32 = populace_retarget::MAP_TRANSLATION;
    /// Flag in a joint map: the scale comes from the clip's rows.
    pub const MAP_SCALE: u32 = populace_retarget::MAP_SCALE;
    /// Flag in a [`RowBlock`]'s lanes: the planes hold floats, one for each component.
    pub const ROW_FLOATS: u32 = populace_clip::ROW_FLOATS;
    /// Flag in a [`BoundBlock`]: each joint follows the column of its own lane, all in one block.
    pub const BLOCK_STRAIGHT: u32 = 4;
    /// Flag in a [`BoundBlock`]: what was sampled goes on through the [`BoundClip::next`] clip.
    pub const BLOCK_TURNED: u32 = 8;
    /// Flag in a [`BoundBlock`]: all translations stand at the body's rest; of a turn, it adds
    /// nothing to them.
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
    /// once. Constraints of a member's feet follow each other, and each has three turns from the
    /// step's on.
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
    /// Of a member's state, the first of four elements of its root motion: where its clips have
    /// moved it, its heading, how fast they last did, and how much faster than what it plays it was
    /// when something began to inertialize: shift and turn in a tick.
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
    /// Elements of what is watched of a joint: three rows of its matrix, in the world, or in model
    /// space for what is attached to it.
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
    pub const MAP_COLUMN: u32 = populace_retarget::MAP_COLUMN;
    /// Weights that sum to less count as none: the inverse of the sum would overflow.
    pub const LEAST_WEIGHT: f32 = 1e-20;
    /// Squared lengths below this count as none.
    pub const LEAST_SQUARE: f32 = 1e-20;
    /// First guess of an inverse square root: halves the exponent and balances the error.
    pub const INVERSE_SQRT_BITS: u32 = populace_model::math::INVERSE_SQRT_BITS;
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
    /// Passes of the chain solver, always as many, so that the result follows targets smoothly.
    pub const CHAIN_PASSES: u32 = 16;
    /// Time in which a lifted foot makes up for half of what it was held back, in seconds.
    pub const FOOT_RELEASE_SECS: f32 = 0.06;
    /// Largest distance that a pelvis sinks, in parts of a leg's length.
    pub const PELVIS_SINK_MOST: f32 = 0.5;
    /// Largest size of a number that a user's stage may leave; larger ones are refused.
    pub const STAGE_LARGEST: f32 = populace_model::LARGEST;
}

mod clips;
mod members;
mod playing;

pub use clips::*;
pub use members::*;
pub use playing::*;

/// Planes of a stored pose, each of `padded_count` floats with joints varying fastest: rotation x y
/// z w, translation x y z, scale x y z.
pub const POSE_PLANES: usize = 10;
/// Planes of a bound clip's ranges, laid out alike: offsets of rotation x y z w and their step, of
/// translation x y z and their step, of scale x y z and their step. A component is
/// `offset + step * n` for the `n` that a row holds; a step of 0 leaves the clip's constant, or the
/// body's rest where the clip does not drive the joint.
pub const RANGE_PLANES: usize = 13;
/// Planes of a turn, laid out alike: offsets of a rotation x y z w, the step of x y z, that of w
/// (their signs differ where the rotation is undone), offsets of an arm x y z and their step, and a
/// rotation x y z w that comes after. The pose that goes through a turn has the arm, turned by its
/// rotation so far, added to its translation; then its rotation is multiplied from the right by the
/// turn's two. All of it leaves joints as they are where the rotations are those that change
/// nothing and the arm is 0.
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

/// Calls a macro with the name of every shared struct, in the order of [`opencl_prelude`]. What
/// follows the macro's name is passed on before the list.
#[macro_export]
macro_rules! with_device_structs {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            Body, Entry, ClipRows, RowBlock, BoundClip, BoundBlock, Source, Slot, Layer, Member,
            SlotSample, Control, Step, Override, Constraint, Link, Target, Ground, MachineState,
            Transition, Condition, MachineInstance, Running
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
    fn the_opencl_text_declares_what_rust_declares() {
        assert_eq!(
            Member::OPENCL_C,
            "typedef struct { uint body; uint joint_first; uint palette_first; uint \
             layers_and_phase; uint control; } Member;\n"
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
    fn the_tick_reads_the_same_in_both_languages() {
        let text = opencl_prelude();
        let line = text.lines().find(|l| l.starts_with("#define TICK_SECS")).unwrap();
        let value: f32 =
            line.split(' ').next_back().unwrap().trim_end_matches('f').parse().unwrap();
        assert_eq!(value.to_bits(), populace_clip::TICK_SECS.to_bits());
    }
}
