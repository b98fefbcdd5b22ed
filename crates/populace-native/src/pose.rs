//! Pose: each member's slots, mixed layer by layer, as local transforms; the twin of
//! `kernels/pose.cl`.

use populace_device::layout::{Float4, JOINT_BLOCK, SlotSample};
use populace_device::{Frame, MAX_SLOTS, Tables};

use crate::controls::{Clock, control_of};
use crate::dispatch::Dispatch;
use crate::inertialize::inertialization_slots;
use crate::joint::{Playing, Posing};
use crate::machines::slot_now;
use crate::stages::Stages;
use crate::{JointBuffer, split};

pub(crate) fn run(
    tables: &Tables,
    frame: Frame,
    stages: &Stages,
    (running, samples): (&[Float4], &[SlotSample]),
    joints: &mut JointBuffer,
) {
    let clock = Clock::of(frame, stages);
    let arrays = [&mut joints.translations[..], &mut joints.rotations[..], &mut joints.scales[..]];
    let job = |place: u32, _, [translations, rotations, scales]: [&mut [Float4]; 3]| {
        if !frame.evaluates(place) {
            return;
        }
        let member = &tables.members().as_slice()[place as usize];
        let body = &tables.bodies().as_slice()[member.body as usize];
        let range = tables.slot_range(place);
        let (slots, samples) = (&tables.slots().as_slice()[range.clone()], &samples[range]);
        let mut playing = [Playing::default(); MAX_SLOTS];
        for ((playing, slot), at) in playing.iter_mut().zip(slots).zip(samples) {
            let bound_clip = slot_now(tables, running, slot, frame.tick).bound_clip;
            *playing = Playing { at: *at, bound_clip, layer: slot.layer() };
        }
        let (playing, layers) = (&playing[..slots.len()], member_layers(tables, place));
        let inertialization = inertialization_slots(tables, place, frame.tick);
        let control = control_of(tables, place);
        for joint in 0..body.joint_count as usize {
            let dispatch = Dispatch::Baseline;
            let posing = Posing {
                tables,
                playing,
                inertialization,
                layers,
                body,
                control,
                joint,
                clock,
                dispatch,
            };
            let local = posing.pose::<f32>();
            translations[joint] = Float4::from_xyz(local.t);
            rotations[joint] = Float4(local.r);
            scales[joint] = Float4::from_xyz(local.s);
        }
    };
    split::for_each_member::<{ JOINT_BLOCK as usize }, 3>(
        tables.joint_blocks().as_slice(),
        arrays,
        &job,
    );
}

/// The layers that a member uses.
pub(crate) fn member_layers(tables: &Tables, place: u32) -> &[populace_device::layout::Layer] {
    let in_use = tables.members().as_slice()[place as usize].layer_count() as usize;
    &tables.layers().as_slice()[tables.layer_range(place)][..in_use]
}
