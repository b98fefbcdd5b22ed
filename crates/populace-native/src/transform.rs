//! Transform: local transforms down the hierarchy; the twin of `kernels/transform.cl`.

use populace_core::layout::{Float4, JOINT_BLOCK, NONE};
use populace_core::{Affine, Frame, Tables, Trs};

use crate::{JointBuffer, ModelRows, split};

const BLOCK: usize = JOINT_BLOCK as usize;

pub(crate) fn run(tables: &Tables, frame: Frame, joints: &JointBuffer, models: &mut ModelRows) {
    let arrays = models.0.each_mut().map(Vec::as_mut_slice);
    let job = |place: u32, first: usize, [row0, row1, row2]: [&mut [Float4]; 3]| {
        if !frame.evaluates(place) {
            return;
        }
        let first = first * BLOCK;
        let member = &tables.members().as_slice()[place as usize];
        let body = &tables.bodies().as_slice()[member.body as usize];
        let parents = &tables.parents().as_slice()[body.joint_first as usize..];
        for joint in 0..body.joint_count as usize {
            let at = first + joint;
            let local = Affine::from_trs(&Trs {
                translation: joints.translations[at].xyz(),
                rotation: joints.rotations[at].0,
                scale: joints.scales[at].xyz(),
            });
            let model = match parents[joint] {
                NONE => local,
                parent => {
                    let parent = parent as usize;
                    Affine { rows: [row0[parent].0, row1[parent].0, row2[parent].0] }.mul(&local)
                }
            };
            let [a, b, c] = model.rows;
            row0[joint] = Float4(a);
            row1[joint] = Float4(b);
            row2[joint] = Float4(c);
        }
    };
    split::for_each_member::<BLOCK, 3>(tables.joint_blocks().as_slice(), arrays, &job);
}
