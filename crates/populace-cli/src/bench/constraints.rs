//! What beside clips moves members under load, and whether they do as they are told.

use glam::{DAffine3, DVec3};
use populace::character::Character;
use populace::model::Skeleton;
use populace::{
    Crowd, Error, Feet, Foot, Gaze, GazeLimits, JointIndex, LayerMode, LayerSettings, Mask, MaskId,
    Member, Target, Weight,
};
use populace_testkit::oracle::{OracleLayer, OraclePose};

use super::rigs::{LEGS, TRUNK};

/// How far a foot may be lifted and still count as planted, in parts of its leg's length, less a
/// margin.
const PLANTED: f64 = 0.029;

fn joint(skeleton: &Skeleton, source: usize) -> Result<JointIndex, Error> {
    if source < skeleton.joint_count() {
        return Ok(skeleton.joint_from_source(source));
    }
    let what =
        format!("constraints take bodies of 11 joints or more, not of {}", skeleton.joint_count());
    Err(populace_device::Error::BadConstraint { what }.into())
}

/// The upper body.
pub(super) fn mask(skeleton: &Skeleton) -> Result<Mask, Error> {
    Ok(Mask::subtree(skeleton, joint(skeleton, TRUNK[0])?))
}

/// One layer through a mask, and one that adds.
pub(super) fn set_layers(crowd: &mut Crowd, member: Member, mask: MaskId) -> Result<(), Error> {
    let masked = LayerSettings { mode: LayerMode::Override, weight: 0.7 };
    crowd.set_layer(member, 1, masked, Some(mask))?;
    crowd.set_layer(member, 2, LayerSettings { mode: LayerMode::Additive, weight: 0.6 }, None)
}

/// The same for the oracle.
pub(super) fn oracle_layers(character: &Character) -> Result<Vec<OracleLayer>, Error> {
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

/// Lets a member look at a point of its model space, and keep both feet to the ground.
pub(super) fn constrain(
    crowd: &mut Crowd,
    member: Member,
    skeleton: &Skeleton,
    target: [f32; 3],
) -> Result<(), Error> {
    let shares = [0.15, 0.15, 0.3, 0.4];
    let mut chain = Vec::new();
    for (source, share) in TRUNK.into_iter().zip(shares) {
        chain.push((joint(skeleton, source)?, share));
    }
    let limits = GazeLimits { yaw_rad: 1.5, up_rad: 1.0, down_rad: 1.0 };
    let gaze = Gaze { chain, facing: [0.0, 0.0, 1.0], limits, targets: Vec::new() };
    crowd.look_with(member, &gaze, Target::InModel(target), Weight::FULL.over_secs(0.0))?;
    let mut feet = Vec::new();
    for [hip, knee, ankle] in LEGS {
        let [hip, knee, ankle] =
            [joint(skeleton, hip)?, joint(skeleton, knee)?, joint(skeleton, ankle)?];
        feet.push(Foot { hip, knee, ankle });
    }
    crowd.plant_with(member, &Feet { pelvis: joint(skeleton, 0)?, feet, weight: 1.0 })
}

/// How far a constrained member's joints, in the order of the source, are from what it was told, in
/// metres: joints that no constraint turns stand to their parents as the clips have them; a point
/// at `probe` before the head lies towards its target; planted feet are at rest height.
pub(super) fn worst_error_m(
    character: &Character,
    found: &[DAffine3],
    clips: &OraclePose,
    target: [f32; 3],
    probe: f64,
) -> f64 {
    let skeleton = &character.skeleton;
    let turned: Vec<usize> =
        TRUNK.into_iter().chain(LEGS.into_iter().flatten()).chain([0]).collect();
    let mut worst: f64 = 0.0;
    for source in (0..found.len()).filter(|source| !turned.contains(source)) {
        let parent = skeleton.parent(skeleton.joint_from_source(source));
        let Some(parent) = parent.map(|parent| skeleton.source_from_joint(parent)) else {
            continue;
        };
        let relative = |models: &[DAffine3]| models[parent].inverse() * models[source];
        let (is, was) = (relative(found), relative(&clips.model_from_joint));
        for point in [DVec3::ZERO, DVec3::X * probe, DVec3::Y * probe, DVec3::Z * probe] {
            worst = worst.max(is.transform_point3(point).distance(was.transform_point3(point)));
        }
    }
    let head = found[TRUNK[3]];
    let wanted = (DVec3::from_array(target.map(f64::from)) - head.translation).normalize();
    // Rest rotations of the core are none, so the head faces its own +Z.
    let facing = head.transform_vector3(DVec3::Z).normalize();
    worst = worst.max(facing.distance(wanted) * probe);
    for [hip, knee, ankle] in LEGS {
        let place = |joint: usize| {
            skeleton.rest_model(skeleton.joint_from_source(joint)).origin().map(f64::from)
        };
        let [hip, knee, rest] = [hip, knee, ankle].map(|joint| DVec3::from_array(place(joint)));
        let length = hip.distance(knee) + knee.distance(rest);
        if clips.model_from_joint[ankle].translation.y - rest.y < PLANTED * length {
            worst = worst.max((found[ankle].translation.y - rest.y).abs());
        }
    }
    worst
}
