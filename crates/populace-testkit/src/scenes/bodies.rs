//! Skeletons and palette entries.

use populace_character::PaletteEntry;
use populace_model::convert::single;
use populace_model::{Affine, JointSource, Skeleton, Trs};

use super::SceneBody;
use crate::Rng;
use crate::oracle::OracleBody;

pub(super) fn all() -> Vec<SceneBody> {
    let plans = [
        (2, 1, false),
        (24, 1, false),
        (54, 2, false),
        (54, 1, true),
        (300, 1, false),
        (17, 1, false),
    ];
    let mut seed = 0;
    plans
        .map(|(count, roots, scaled)| {
            seed += 1;
            let mut rng = Rng::new(seed);
            let joints = joints(&mut rng, count, roots, scaled);
            body(&mut rng, joints, count != 17)
        })
        .into()
}

pub(super) fn body(rng: &mut Rng, joints: Vec<JointSource>, has_palette: bool) -> SceneBody {
    let skeleton = Skeleton::new(&joints).expect("generated skeletons are valid");
    let mut palette = Vec::new();
    for joint in skeleton.joints().filter(|_| has_palette) {
        let least = palette.is_empty() && joint.index() + 1 == skeleton.joint_count();
        for _ in 0..[0, 1, 1, 1, 2, 3][rng.below(6)].max(usize::from(least)) {
            let rows = [(); 3].map(|()| [(); 4].map(|()| single(rng.between(-1.0, 1.0))));
            palette.push(PaletteEntry { joint, joint_from_bind: Affine { rows } });
        }
    }
    rng.shuffle(&mut palette);
    let entry = |e: &PaletteEntry| {
        let flat = e.joint_from_bind.rows.as_flattened();
        let wide = std::array::from_fn(|element| f64::from(flat[element]));
        (skeleton.source_from_joint(e.joint), wide)
    };
    let oracle =
        OracleBody { joints: joints.clone(), palette: palette.iter().map(entry).collect() };
    SceneBody { joints, skeleton, palette, oracle, roles: Vec::new() }
}

/// Creates a random tree in shuffled order. Joints of the same number have the same name and a
/// similar rest rotation on all bodies, so that a clip of least body suits the others.
fn joints(rng: &mut Rng, count: usize, roots: usize, scaled: bool) -> Vec<JointSource> {
    let mut index: Vec<usize> = (0..count).collect();
    rng.shuffle(&mut index);
    let mut joints: Vec<Option<JointSource>> = vec![None; count];
    for number in 0..count {
        let parent = (number >= roots)
            .then(|| index[number - 1 - rng.below(number.min((count / 7).max(3)))]);
        joints[index[number]] = Some(JointSource {
            name: format!("joint {number}"),
            parent,
            rest: rest(rng, number, scaled),
        });
    }
    joints.into_iter().flatten().collect()
}

fn rest(rng: &mut Rng, number: usize, scaled: bool) -> Trs {
    let common = Rng::new(10_000 + number as u64).rotation();
    let (angle, length) = (rng.between(0.0, 0.35), rng.between(0.05, 0.25));
    let rotation = common * rng.turn(angle);
    let translation = rng.direction() * length;
    let scale = if scaled { rng.vector(0.85, 1.2).to_array().map(single) } else { [1.0; 3] };
    Trs {
        translation: translation.to_array().map(single),
        rotation: rotation.to_array().map(single),
        scale,
    }
}
