//! Parts of the tables that belong to a member, given by its index. Twin of `kernels/members.cl`.

use populace_device::Tables;
use populace_device::layout::{Body, Control, Layer, NONE, Slot, Step};

/// Returns the body that a member is evaluated with.
pub(crate) fn body_of(tables: &Tables, member: u32) -> &Body {
    &tables.bodies().as_slice()[tables.members().as_slice()[member as usize].posed as usize]
}

/// Returns the parent of each joint of a body, [`NONE`] for roots.
#[inline(always)]
pub(crate) fn parents_of<'a>(tables: &'a Tables, body: &Body) -> &'a [u32] {
    let first = body.joint_first as usize;
    &tables.parents().as_slice()[first..first + body.joint_count as usize]
}

/// Returns the member's control; `None` if only clips move the member.
#[inline(always)]
pub(crate) fn control_of(tables: &Tables, member: u32) -> Option<&Control> {
    let index = tables.members().as_slice()[member as usize].control;
    if index == NONE { None } else { tables.controls().as_slice().get(index as usize) }
}

/// Returns the steps of a member's program; none if only clips move the member.
#[inline(always)]
pub(crate) fn steps_of(tables: &Tables, member: u32) -> &[Step] {
    control_of(tables, member).map_or(&[], |control| {
        let first = control.step_first as usize;
        &tables.steps().as_slice()[first..first + control.step_count as usize]
    })
}

/// Returns all slots of a member, empty ones included.
pub(crate) fn member_slots(tables: &Tables, member: u32) -> &[Slot] {
    &tables.slots().as_slice()[tables.slot_range(member)]
}

/// Returns the layers that a member uses.
pub(crate) fn member_layers(tables: &Tables, member: u32) -> &[Layer] {
    let in_use = tables.members().as_slice()[member as usize].layer_count() as usize;
    &tables.layers().as_slice()[tables.layer_range(member)][..in_use]
}
