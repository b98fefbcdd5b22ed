//! The tables, listed once: host and devices make theirs from the same list.

use super::{Table, Tables};
use crate::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Condition, Constraint, Control, Entry, Float4, Ground,
    Layer, Link, MachineInstance, MachineState, Member, Override, RowBlock, Slot, Source, Step,
    Target, Transition,
};

/// Calls a macro with every table that all schedules read: its documentation, its name, and the
/// type of its elements (types of [`layout`](crate::layout), which must be in scope where it is
/// called). What follows the macro's name is passed on before the list.
#[macro_export]
macro_rules! with_tables {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            /// Bodies.
            bodies: Body,
            /// Parents of the joints of all bodies, in level order within each; `NONE` for roots.
            parents: u32,
            /// First joint of each level of all bodies, and the end of the last.
            levels: u32,
            /// Palette entries of all bodies.
            entries: Entry,
            /// Rest poses, `POSE_PLANES` planes each, the ranges of bound clips, `RANGE_PLANES`
            /// planes each, and of their turns, `TURN_PLANES` planes each.
            poses: f32,
            /// Clips.
            clips: ClipRows,
            /// Rows of the root motion of clips, `MOTION_ELEMENTS` each: `x y z 0`, sine and cosine
            /// of the heading.
            motions: Float4,
            /// Rows of all clips, and at the end of each what 16 lanes may read past it.
            rows: u32,
            /// Times of the rows of clips that are not evenly spaced, on each clip's own axis.
            row_times: f32,
            /// Buckets of such clips.
            buckets: u32,
            /// Where in a row each block of 16 columns stands.
            row_blocks: RowBlock,
            /// Clips bound to bodies.
            bound_clips: BoundClip,
            /// Where 16 neighbouring joints of a bound clip's body find their columns.
            bound_blocks: BoundBlock,
            /// Blocks of columns that they follow.
            sources: Source,
            /// For each source and each of 16 joints its lane in it, or `NONE`.
            source_lanes: u32,
            /// For each joint of each bound clip its column and `MAP_` flags.
            joint_maps: u32,
            /// Masks: a weight per joint, padded to whole blocks of `JOINT_BLOCK`.
            masks: f32,
            /// Members, by place.
            members: Member,
            /// `members x slots_per_member`, slots fastest.
            slots: Slot,
            /// `members x LAYERS_PER_MEMBER`, layers fastest.
            layers: Layer,
            /// What beside clips moves members, for those that have any.
            controls: Control,
            /// Steps of all controls.
            steps: Step,
            /// Transforms that the host gives joints.
            overrides: Override,
            /// Constraints of all controls.
            constraints: Constraint,
            /// Chains of all constraints.
            links: Link,
            /// Targets of all constraints.
            targets: Target,
            /// Factors for the lengths of joints, padded to whole blocks of `JOINT_BLOCK`.
            joint_scales: f32,
            /// The ground: one element.
            ground: Ground,
            /// Heights of the ground's grid.
            heights: f32,
            /// Parameters of users' stages, four elements each, then values of the members that use
            /// them.
            stage_values: Float4,
            /// States of machines, for each body that runs them.
            machine_states: MachineState,
            /// Ways out of them.
            transitions: Transition,
            /// What must hold for those.
            conditions: Condition,
            /// Machines that members run.
            machine_instances: MachineInstance,
            /// `machine instances x MACHINE_PARAMETERS`, parameters fastest.
            machine_parameters: f32,
        }
    };
}

/// As [`with_tables`], with the tables that only the staged schedule reads: a device that does not
/// run it needs no copy of them.
#[macro_export]
macro_rules! with_block_tables {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            /// The member of each block of `JOINT_BLOCK` joints in the joint buffer, `NONE` where
            /// it is free. Only the staged schedule reads it.
            joint_blocks: u32,
            /// The member of each block of `PALETTE_BLOCK` palette entries, `NONE` where it is
            /// free. Only the staged schedule reads it.
            palette_blocks: u32,
        }
    };
}

macro_rules! table_set {
    ($set:ident $field:ident; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
        #[derive(Clone, Debug)]
        pub(super) struct $set {
            $(pub(super) $name: Table<$element>,)*
        }

        impl $set {
            pub(super) fn new() -> Self {
                Self { $($name: Table::new(stringify!($name)),)* }
            }

            pub(super) fn mark_clean(&mut self) {
                $(self.$name.mark_clean();)*
            }

            pub(super) fn mark_dirty(&mut self) {
                $(self.$name.mark_dirty();)*
            }

            pub(super) fn revert(&mut self) {
                $(self.$name.revert();)*
            }

            pub(super) fn restore(&mut self) {
                $(self.$name.restore();)*
            }
        }

        /// What devices read. Elements change only through methods that check them: a device
        /// follows every index.
        impl Tables {
            $($(#[$doc])* #[must_use] pub fn $name(&self) -> &Table<$element> { &self.$field.$name })*
        }
    };
}
crate::with_tables!(table_set, TableSet, all);
crate::with_block_tables!(table_set, BlockTableSet, blocks);
