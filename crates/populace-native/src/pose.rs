//! Pose: each member's slots, mixed layer by layer, as local transforms; the twin of `kernels/pose.cl`.

use populace_core::Tables;
use populace_core::layout::{Float4, LAYERS_PER_MEMBER, SlotSample};

use crate::joint::{Playing, Posing};
use crate::{JointBuffer, split};

pub(crate) fn run(tables: &Tables, samples: &[SlotSample], joints: &mut JointBuffer) {
    let arrays = [&mut joints.translations[..], &mut joints.rotations[..], &mut joints.scales[..]];
    split::for_each_member(
        tables.joint_blocks().as_slice(),
        arrays,
        &|place, _, [translations, rotations, scales]| {
            let member = &tables.members().as_slice()[place as usize];
            let body = &tables.bodies().as_slice()[member.body as usize];
            let mut playing = [Playing::default(); populace_core::MAX_SLOTS];
            let slots = tables.slot_range(place);
            let count = slots.len();
            for ((playing, slot), at) in
                playing.iter_mut().zip(&tables.slots().as_slice()[slots.clone()]).zip(&samples[slots])
            {
                *playing = Playing { at: *at, bound_clip: slot.bound_clip, layer: slot.layer() };
            }
            let layers = place as usize * LAYERS_PER_MEMBER as usize;
            let layers = &tables.layers().as_slice()[layers..layers + member.layer_count as usize];
            for joint in 0..body.joint_count as usize {
                let local = Posing { tables, playing: &playing[..count], layers, body, joint }.pose::<f32>();
                translations[joint] = Float4::from_xyz(local.t);
                rotations[joint] = Float4(local.r);
                scales[joint] = Float4::from_xyz(local.s);
            }
        },
    );
}
