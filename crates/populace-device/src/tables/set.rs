//! The list of all tables, from which the host and the devices declare theirs.

use std::ops::Range;

use super::{Table, Tables};
use crate::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Condition, Constraint, Contact, Control, Entry, Float4,
    Ground, Layer, Link, MachineInstance, MachineState, Member, Override, Slot, Step, Target,
    Transition,
};

/// Calls a macro with every table that all schedules read: its documentation, its name and its
/// element type. The element types are those of [`layout`](crate::layout) and must be in scope at
/// the call. Arguments after the macro's name are passed on before the list.
#[macro_export]
macro_rules! with_tables {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            /// Bodies.
            bodies: Body,
            /// Parents of the joints of all bodies, in level order within each body; `NONE` for
            /// roots.
            parents: u32,
            /// First joint of each level of all bodies; after the last level, its end.
            levels: u32,
            /// Palette entries of all bodies.
            entries: Entry,
            /// Rest poses (`POSE_PLANES` planes each) and planes of bound clips (`BOUND_PLANES`
            /// planes each), in blocks of `JOINT_BLOCK` joints.
            poses: f32,
            /// Clips, and clips converted to bodies.
            clips: ClipRows,
            /// Root-motion rows of clips, `MOTION_ELEMENTS` each: `x y z 0`, then sine and cosine
            /// of the heading.
            motions: Float4,
            /// Rows of all clips. Each clip is followed by padding, because 16 lanes may read past
            /// its end.
            rows: u32,
            /// Row times of clips whose rows are not evenly spaced, on each clip's own axis.
            row_times: f32,
            /// Buckets of those clips.
            buckets: u32,
            /// Clips bound to bodies.
            bound_clips: BoundClip,
            /// Contacts of feet, for each bound clip whose contacts are known.
            contacts: Contact,
            /// Location of the columns of 16 neighbouring joints, for each bound clip.
            bound_blocks: BoundBlock,
            /// Masks: a weight per joint, padded to whole blocks of `JOINT_BLOCK`.
            masks: f32,
            /// Members, by member index.
            members: Member,
            /// Slots, `members x slots_per_member`, slots fastest.
            slots: Slot,
            /// Layers, `members x LAYERS_PER_MEMBER`, layers fastest.
            layers: Layer,
            /// Constraint programs of the members that have one.
            controls: Control,
            /// Steps of all constraint programs.
            steps: Step,
            /// Transforms that the host sets on joints.
            overrides: Override,
            /// Constraints of all constraint programs.
            constraints: Constraint,
            /// Chains of all constraints.
            links: Link,
            /// Targets of all constraints.
            targets: Target,
            /// Length factors of joints, padded to whole blocks of `JOINT_BLOCK`.
            joint_scales: f32,
            /// The ground: one element.
            ground: Ground,
            /// Points of the soles of bodies, in the spaces of the joints that carry them: `x y z
            /// 0`.
            soles: Float4,
            /// Height samples of the ground's grid.
            heights: f32,
            /// Parameters of user stages, `STAGE_PARAMETERS / 4` elements each, then the values of
            /// members that use them.
            stage_values: Float4,
            /// States of state machines, for each body that runs them.
            machine_states: MachineState,
            /// Transitions between those states.
            transitions: Transition,
            /// Conditions of those transitions.
            conditions: Condition,
            /// State machines that run on members.
            machine_instances: MachineInstance,
            /// `machine_instances x MACHINE_PARAMETERS`, parameters fastest.
            machine_parameters: f32,
        }
    };
}

/// Like [`with_tables`], for the tables that only the staged schedule reads. Devices that do not
/// run it need no copy of them.
#[macro_export]
macro_rules! with_block_tables {
    ($callback:ident $(, $more:tt)*) => {
        $callback! {
            $($more)*;
            /// Member index of each block of `JOINT_BLOCK` joints in the joint buffer, `NONE` if
            /// unused.
            joint_blocks: u32,
            /// Member index of each block of `PALETTE_BLOCK` palette entries, `NONE` if unused.
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

        /// The tables that devices read. Elements change only through methods that check every
        /// index, because devices follow all of them.
        impl Tables {
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $name(&self) -> &Table<$element> { &self.$field.$name }
            )*
        }
    };
}
crate::with_tables!(table_set, TableSet, all);

macro_rules! release {
    (; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
        impl TableSet {
            /// Frees a run of the table of a name.
            pub(super) fn release(&mut self, table: &str, run: Range<usize>) {
                match table {
                    $(stringify!($name) => self.$name.release(run),)*
                    _ => {}
                }
            }
        }
    };
}
crate::with_tables!(release);
crate::with_block_tables!(table_set, BlockTableSet, blocks);
