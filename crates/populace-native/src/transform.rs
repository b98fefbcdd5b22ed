//! Transform: local transforms down the hierarchy; the twin of `kernels/transform.cl`.

use populace_core::layout::{Float4, NONE};
use populace_core::{Affine, Tables, Trs};

use crate::{JointBuffer, ModelRows, split};

pub(crate) fn run(tables: &Tables, joints: &JointBuffer, models: &mut ModelRows) {
    let arrays = models.0.each_mut().map(Vec::as_mut_slice);
    split::for_each_member(tables.joint_blocks().as_slice(), arrays, &|place, first, [row0, row1, row2]| {
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
    });
}
