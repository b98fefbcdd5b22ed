//! Layers and constraints of loaded members, and the check of their results.

use glam::{DAffine3, DVec3};
use populace::character::Character;
use populace::model::Skeleton;
use populace::{
    ConstraintFault, Crowd, Error, Feet, Foot, Gaze, GazeLimits, JointIndex, LayerMode,
    LayerSettings, Mask, MaskId, MemberId, Target, Weight,
};
use populace_testkit::oracle::{OracleLayer, OraclePose};

use crate::errors::larger;
use crate::rigs::{LEGS, TRUNK};

/// The largest height of a foot above rest at which it is fully planted, in leg lengths, less a
/// margin.
const PLANTED_HEIGHT: f64 = 0.029;

fn joint(skeleton: &Skeleton, source: usize) -> Result<JointIndex, Error> {
    if source < skeleton.joint_count() {
        return Ok(skeleton.joint_from_source(source));
    }
    let fault = ConstraintFault::TooFewJoints { needed: 11, count: skeleton.joint_count() };
    Err(populace::TablesError::from(fault).into())
}

/// Returns a mask of the upper body.
pub(crate) fn mask(skeleton: &Skeleton) -> Result<Mask, Error> {
    Ok(Mask::subtree(skeleton, joint(skeleton, TRUNK[0])?))
}

/// Sets a masked override layer and an additive layer.
pub(crate) fn set_layers(crowd: &mut Crowd, member: MemberId, mask: MaskId) -> Result<(), Error> {
    let masked = LayerSettings { mode: LayerMode::Override, weight: 0.7 };
    crowd.member_mut(member)?.set_layer(1, masked, Some(mask))?;
    crowd.member_mut(member).and_then(|mut m| {
        m.set_layer(2, LayerSettings { mode: LayerMode::Additive, weight: 0.6 }, None)
    })
}

/// Returns the same layers for the oracle.
pub(crate) fn oracle_layers(character: &Character) -> Result<Vec<OracleLayer>, Error> {
    let mask = mask(&character.skeleton)?;
    let skeleton = &character.skeleton;
    let by_source = (0..skeleton.joint_count()).map(|source| {
        let joint = skeleton.joint_from_source(source);
        f64::from(mask.weights()[joint.index()])
    });
    let masked = OracleLayer {
        mode: LayerMode::Override,
        weight: f64::from(0.7_f32),
        mask: Some(by_source.collect()),
    };
    let added = OracleLayer { mode: LayerMode::Additive, weight: f64::from(0.6_f32), mask: None };
    Ok(vec![OracleLayer::default(), masked, added])
}

/// Makes a member look at a point in its model space and plant both feet.
pub(crate) fn constrain(
    crowd: &mut Crowd,
    member: MemberId,
    skeleton: &Skeleton,
    target: [f32; 3],
) -> Result<(), Error> {
    let shares = [0.15, 0.15, 0.3, 0.4];
    let mut chain = Vec::new();
    for (source, share) in TRUNK.into_iter().zip(shares) {
        chain.push((joint(skeleton, source)?, share));
    }
    let limits = GazeLimits { yaw_rad: 1.5, up_rad: 1.0, down_rad: 1.0 };
    let gaze = Gaze { chain, facing: [0.0, 0.0, 1.0], limits };
    crowd.member_mut(member)?.look_at_with(
        &gaze,
        Target::InModel(target),
        Weight::FULL.over_secs(0.0),
    )?;
    let mut feet = Vec::new();
    for [hip, knee, ankle] in LEGS {
        let [hip, knee, ankle] =
            [joint(skeleton, hip)?, joint(skeleton, knee)?, joint(skeleton, ankle)?];
        feet.push(Foot { hip, knee, ankle });
    }
    crowd.member_mut(member).and_then(|mut m| {
        m.plant_feet_with(&Feet { pelvis: joint(skeleton, 0)?, feet, weight: 1.0 })
    })
}

/// Returns the largest error of a constrained member in metres; `found` is in source order.
///
/// Joints without a constraint keep the transform to their parent that the clips give them. A point
/// `probe` metres in front of the head lies in the direction of the target. Planted feet are at
/// rest height.
pub(crate) fn worst_error_m(
    character: &Character,
    found: &[DAffine3],
    clips: &OraclePose,
    target: [f32; 3],
    probe: f64,
) -> f64 {
    let skeleton = &character.skeleton;
    let constrained: Vec<usize> =
        TRUNK.into_iter().chain(LEGS.into_iter().flatten()).chain([0]).collect();
    let mut worst: f64 = 0.0;
    for source in (0..found.len()).filter(|source| !constrained.contains(source)) {
        let parent = skeleton.parent(skeleton.joint_from_source(source));
        let Some(parent) = parent.map(|parent| skeleton.source_from_joint(parent)) else {
            continue;
        };
        let relative = |models: &[DAffine3]| models[parent].inverse() * models[source];
        let (is, was) = (relative(found), relative(&clips.model_from_joint));
        for point in [DVec3::ZERO, DVec3::X * probe, DVec3::Y * probe, DVec3::Z * probe] {
            worst = larger(worst, is.transform_point3(point).distance(was.transform_point3(point)));
        }
    }
    let head = found[TRUNK[3]];
    let wanted = (DVec3::from_array(target.map(f64::from)) - head.translation).normalize();
    // The rest rotation of the head is the identity, so it faces its own +Z.
    let facing = head.transform_vector3(DVec3::Z).normalize();
    worst = larger(worst, facing.distance(wanted) * probe);
    for [hip, knee, ankle] in LEGS {
        let position = |joint: usize| {
            skeleton.rest_model(skeleton.joint_from_source(joint)).origin().map(f64::from)
        };
        let [hip, knee, rest] = [hip, knee, ankle].map(|joint| DVec3::from_array(position(joint)));
        let length = hip.distance(knee) + knee.distance(rest);
        if clips.model_from_joint[ankle].translation.y - rest.y < PLANTED_HEIGHT * length {
            worst = larger(worst, (found[ankle].translation.y - rest.y).abs());
        }
    }
    worst
}
