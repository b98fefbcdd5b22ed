//! Places on a person where props are attached: the hands' grips, and the head.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_character::Character;
use populace_model::convert::single;
use populace_model::{JointIndex, Skeleton, Trs};

use crate::anatomy::{ELBOW, Side, WRIST};

/// Place of the fist's axis: distances from the wrist along the hand and out of the palm, as
/// fractions of the forearm's length.
const FIST: [f64; 2] = [0.40, 0.135];
/// How far the underside of a carried box is beneath the palms, as a fraction of the body's height.
const UNDER_PALMS: f64 = 0.045;
/// Height of an adult's head in metres, from chin to crown.
const ADULT_HEAD_M: f64 = 0.235;

/// Returns where a prop is attached to a hand: the joint, and `joint_from_prop`.
///
/// The prop's origin comes to the middle of its handle in the fist. Its +Y runs along the fist's
/// axis and leaves the hand at the thumb. Its +Z points out of the back of the hand, and +X from
/// the wrist to the elbow on the left, and to the fingers on the right. So a spear along its own +Y
/// points forward in `Spear_Thrust`, and a shield whose face looks along its own +Z faces forward in
/// `Shield`, on the left hand. It is not scaled.
///
/// `None` if the character is not one of this crate's people, or has another skeleton.
#[must_use]
pub fn grip(character: &Character, side: Side) -> Option<(JointIndex, Trs)> {
    let [full, lean] = match side {
        Side::Left => [["LeftForearm", "LeftHand"], ["l_forearm", "l_hand"]],
        Side::Right => [["RightForearm", "RightHand"], ["r_forearm", "r_hand"]],
    };
    let [elbow, wrist] = joints(&character.skeleton, full, lean)?;
    let models = character.skeleton.rest_models();
    let [from, to] = [elbow, wrist].map(|joint| models[joint.index()].translation);
    let forearm = (to - from).length();
    let along = (to - from).normalize_or(DVec3::NEG_Y);
    // Arms at rest lie in the plane of the body, with the thumbs forward.
    let back = DVec3::Z.cross(along) * side.sign();
    let [ahead, inwards] = FIST.map(|part| part * forearm);
    let at = to + along * ahead - back * inwards;
    let axes = DMat3::from_cols(DVec3::Z.cross(back), DVec3::Z, back);
    place(character, wrist, at, DQuat::from_mat3(&axes), 1.0)
}

/// Returns where a helmet is attached to the head: the joint, and `joint_from_prop`.
///
/// The prop's origin comes to the middle of the skull, between the ears. Its +Y points to the crown
/// and its +Z to where the face looks. It is scaled so that a helmet for an adult's head of 0.235 m
/// from chin to crown fits.
///
/// `None` if the character is not one of this crate's people, or has another skeleton.
#[must_use]
pub fn helmet(character: &Character) -> Option<(JointIndex, Trs)> {
    let [neck, head] = joints(&character.skeleton, ["Neck1", "Head"], ["neck", "head"])?;
    let [elbow, wrist] =
        joints(&character.skeleton, ["LeftForearm", "LeftHand"], ["l_forearm", "l_hand"])?;
    let models = character.skeleton.rest_models();
    let at = |joint: JointIndex| models[joint.index()].translation;
    let body = at(elbow).distance(at(wrist)) / (WRIST - ELBOW);
    // The chin is 0.016 of the body's height above the neck, and 0.2 heads beneath the joint.
    let size = (at(head).y - at(neck).y - 0.016 * body) / 0.2;
    let middle = at(head) + DVec3::new(0.0, 0.38 * size, 0.004 * body);
    place(character, head, middle, DQuat::IDENTITY, size / ADULT_HEAD_M)
}

/// Returns where a phone is attached to the right hand of somebody who plays `Phone`: the joint, and
/// `joint_from_prop`.
///
/// The phone's origin, its middle, comes before the palm. Its +Z, the screen, faces as the palm does,
/// to the head, and its +Y points along the fingers. It is not scaled.
///
/// `None` if the character is not one of this crate's people, or has another skeleton.
#[must_use]
pub fn phone_at_ear(character: &Character) -> Option<(JointIndex, Trs)> {
    in_palm(character, [0.30, 0.105], 0.0)
}

/// Returns where a phone is attached to the right hand of somebody who plays `Text`: the joint, and
/// `joint_from_prop`.
///
/// The phone's origin, its middle, comes before the palm. Its +Z, the screen, faces as the palm does,
/// and its +Y points between the fingers and the thumb, away from who reads it. It is not scaled.
///
/// `None` if the character is not one of this crate's people, or has another skeleton.
#[must_use]
pub fn phone_to_read(character: &Character) -> Option<(JointIndex, Trs)> {
    in_palm(character, [0.38, 0.105], 1.0)
}

/// Returns a place in the right hand, at `[ahead, inwards]` as in [`FIST`], with +Z out of the palm,
/// and +Y along the fingers and by `turned` of it to the thumb.
fn in_palm(
    character: &Character,
    place_in_hand: [f64; 2],
    turned: f64,
) -> Option<(JointIndex, Trs)> {
    let [elbow, wrist] =
        joints(&character.skeleton, ["RightForearm", "RightHand"], ["r_forearm", "r_hand"])?;
    let models = character.skeleton.rest_models();
    let [from, to] = [elbow, wrist].map(|joint| models[joint.index()].translation);
    let forearm = (to - from).length();
    let fingers = (to - from).normalize_or(DVec3::NEG_Y);
    // Arms at rest lie in the plane of the body, with the thumbs forward.
    let palm = -DVec3::Z.cross(fingers) * Side::Right.sign();
    let [ahead, inwards] = place_in_hand.map(|part| part * forearm);
    let at = to + fingers * ahead + palm * inwards;
    let up = (fingers + DVec3::Z * turned).normalize();
    let axes = DMat3::from_cols(up.cross(palm), up, palm);
    place(character, wrist, at, DQuat::from_mat3(&axes), 1.0)
}

/// Returns where a box is attached to the chest of somebody who plays `Carry`: the joint, and
/// `joint_from_prop`.
///
/// The origin of the box, the middle of its underside, comes between the hands, and its +Z points
/// forward. It is scaled so that a box of `width_m` along X fits between the palms. It is not for
/// other clips: the hands hold it by what they play.
///
/// `None` if the character is not one of this crate's people, or has another skeleton, and for a
/// width that is not above 0.
#[must_use]
pub fn carried(character: &Character, width_m: f32) -> Option<(JointIndex, Trs)> {
    if width_m.is_nan() || width_m <= 0.0 {
        return None;
    }
    let [chest, elbow] =
        joints(&character.skeleton, ["Spine4", "LeftForearm"], ["chest", "l_forearm"])?;
    let clip = character.clips.iter().find(|clip| clip.name() == "Carry")?;
    let mut models: Vec<DAffine3> = Vec::new();
    for (joint, local) in clip.skeleton().joints().zip(clip.row_poses(1).next()?) {
        let parent = clip.skeleton().parent(joint).and_then(|parent| models.get(parent.index()));
        models.push(parent.map_or(local, |parent| *parent * local));
    }
    let palm = |side| {
        let (wrist, Trs { translation, .. }) = grip(character, side)?;
        let at = DVec3::from(translation.map(f64::from));
        Some((models.get(wrist.index())?.transform_point3(at), wrist))
    };
    let ((left, wrist), (right, _)) = (palm(Side::Left)?, palm(Side::Right)?);
    let rest = character.skeleton.rest_models();
    let forearm = rest[elbow.index()].translation.distance(rest[wrist.index()].translation);
    let body = forearm / (WRIST - ELBOW);
    let underside = 0.5 * (left + right) - DVec3::Y * UNDER_PALMS * body;
    let chest_model = models.get(chest.index())?;
    let scale = f64::from(crate::CARRY_WIDTH) * body / f64::from(width_m.max(1e-3));
    let local = Trs {
        translation: chest_model.inverse().transform_point3(underside).to_array().map(single),
        rotation: DQuat::from_mat3(&chest_model.matrix3).inverse().to_array().map(single),
        scale: [single(scale); 3],
    };
    Some((chest, local))
}

/// Returns two joints by their names on the full rig or on the lean one.
fn joints(skeleton: &Skeleton, full: [&str; 2], lean: [&str; 2]) -> Option<[JointIndex; 2]> {
    [full, lean].iter().find_map(|[a, b]| Some([skeleton.find(a)?, skeleton.find(b)?]))
}

/// Returns a joint, and a place of model space at rest relative to it.
fn place(
    character: &Character,
    joint: JointIndex,
    at: DVec3,
    turn: DQuat,
    scale: f64,
) -> Option<(JointIndex, Trs)> {
    let rest = *character.skeleton.rest_models().get(joint.index())?;
    let rotation = DQuat::from_mat3(&rest.matrix3);
    let translation = rest.inverse().transform_point3(at);
    let local = Trs {
        translation: translation.to_array().map(single),
        rotation: (rotation.inverse() * turn).normalize().to_array().map(single),
        scale: [single(scale); 3],
    };
    Some((joint, local))
}
