//! Pose stage: each member's slots mixed layer by layer, as local transforms. Twin of
//! `kernels/pose.cl`.
//!
//! Reads the samples of the evaluate stage, and all that [`joint`](crate::joint) reads. Writes
//! translations, rotations and scales of every joint; padding stays untouched.

use populace_device::MAX_SLOTS;
use populace_device::layout::{Float4, JOINT_BLOCK, SlotSample};

use crate::buffers::JointBuffer;
use crate::frame::FrameInputs;
use crate::joint::Posing;
use crate::machines::slot_now;
use crate::members::{control_of, member_layers};
use crate::playback::{Playing, alone_in_layers, inertialization_of};
use crate::processor::Dispatch;
use crate::rows::Joints;
use crate::split;

const BLOCK: usize = JOINT_BLOCK as usize;

/// Poses the frame's members.
pub(crate) fn pose(inputs: &FrameInputs, samples: &[SlotSample], joints: &mut JointBuffer) {
    let FrameInputs { tables, frame, history, .. } = *inputs;
    let arrays = [&mut joints.translations[..], &mut joints.rotations[..], &mut joints.scales[..]];
    let job = |index: u32, _, [translations, rotations, scales]: [&mut [Float4]; 3]| {
        if !frame.evaluates(index) {
            return;
        }
        let member = &tables.members().as_slice()[index as usize];
        let body = &tables.bodies().as_slice()[member.posed as usize];
        let range = tables.slot_range(index);
        let (slots, samples) = (&tables.slots().as_slice()[range.clone()], &samples[range]);
        let mut playing = [Playing::default(); MAX_SLOTS];
        for ((playing, slot), at) in playing.iter_mut().zip(slots).zip(samples) {
            let bound_clip = slot_now(tables, &history.running, slot, frame.tick).bound_clip;
            *playing = Playing::new(at, bound_clip, slot.layer());
        }
        let mut posing = Posing {
            inputs,
            joints: Joints { tables, body, first: 0, registers: Dispatch::Baseline },
            playing: &playing[..slots.len()],
            alone: alone_in_layers(&playing[..slots.len()]),
            inertialization: inertialization_of(tables, index, frame.tick),
            layers: member_layers(tables, index),
            control: control_of(tables, index),
        };
        for joint in 0..body.joint_count as usize {
            posing.joints.first = joint;
            let local = posing.pose_joint();
            translations[joint] = Float4::from_xyz(local.t);
            rotations[joint] = Float4(local.r);
            scales[joint] = Float4::from_xyz(local.s);
        }
    };
    split::for_each_member::<BLOCK, 3>(tables.joint_blocks().as_slice(), arrays, &job);
}
