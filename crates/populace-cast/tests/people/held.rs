//! Places of phones in hands, and of skirts on laps.

use glam::{DAffine3, DQuat, DVec3};
use populace_cast::{Bottom, Look, carried, phone_at_ear, phone_to_read};
use populace_character::Character;
use populace_model::{JointIndex, Trs};

use crate::acts::{clip, joint};
use crate::people;
use crate::skinning::{Surface, models, times};

/// The most by which a skirt is over the middles of the knees, as a part of the height.
const LAP: f64 = 0.10;

/// Returns the model space of a phone in a pose.
fn phone(pose: &[DAffine3], place: Option<(JointIndex, Trs)>) -> DAffine3 {
    let (joint, trs) = place.unwrap();
    let rotation = DQuat::from_array(trs.rotation.map(f64::from));
    let translation = DVec3::from(trs.translation.map(f64::from));
    pose[joint.index()] * DAffine3::from_rotation_translation(rotation, translation)
}

/// Returns the middle of a head in a pose.
fn head(character: &Character, pose: &[DAffine3]) -> DVec3 {
    let joint = joint(character, ["Head", "head"]);
    pose[joint].translation + DVec3::Y * 0.05 * f64::from(character.height_m())
}

#[test]
fn a_phone_at_the_ear_faces_the_head_and_points_up() {
    for character in people() {
        let call = clip(character, "Phone");
        for secs in times(call).into_iter().step_by(8) {
            let pose = models(character, Some((call, secs)));
            let phone = phone(&pose, phone_at_ear(character));
            let to = head(character, &pose) - phone.translation;
            let near = to.length() / f64::from(character.height_m());
            assert!(near < 0.105, "{}: {near:.3} of the height", character.name);
            let facing = to.normalize().dot(phone.z_axis);
            assert!(facing > 0.5, "{}: the screen faces {facing:.2}", character.name);
            assert!(phone.y_axis.y > 0.7, "{}: {:.2}", character.name, phone.y_axis);
        }
    }
}

#[test]
fn a_phone_that_is_read_faces_the_eyes_before_the_chest() {
    for character in people() {
        let text = clip(character, "Text");
        for secs in times(text).into_iter().step_by(8) {
            let pose = models(character, Some((text, secs)));
            let phone = phone(&pose, phone_to_read(character));
            let to = head(character, &pose) - phone.translation;
            assert!(to.y > 0.1 && to.z < -0.1, "{}: the head is {to:.2} away", character.name);
            let facing = to.normalize().dot(phone.z_axis);
            assert!(facing > 0.7, "{}: the screen faces {facing:.2}", character.name);
            // The top of the screen is farther from the reader than its lower edge.
            assert!(phone.y_axis.z > 0.4, "{}: {:.2}", character.name, phone.y_axis);
        }
    }
}

/// Over the knees of who sits, a skirt is no higher than a fold of cloth.
#[test]
fn skirts_lie_on_the_thighs_of_who_sits() {
    for (character, look) in people().iter().zip(Look::presets()) {
        if !matches!(look.bottom, Bottom::Skirt | Bottom::Dress) {
            continue;
        }
        let surface = Surface::bare(character);
        let pose = models(character, Some((clip(character, "Sit"), 0.0)));
        let knees = [["LeftShin", "l_lower_leg"], ["RightShin", "r_lower_leg"]]
            .map(|names| pose[joint(character, names)].translation);
        let middle = 0.5 * (knees[0] + knees[1]);
        let height = f64::from(character.height_m());
        let skinned = surface.skinned(&pose);
        let lap = skinned.iter().filter(|p| p.x.abs() < 0.04 && (p.z - middle.z).abs() < 0.05);
        let top = lap.map(|p| p.y - middle.y).fold(f64::MIN, f64::max);
        assert!(top < LAP * height, "{}: {:.4}", character.name, top / height);
        assert!(top > 0.02 * height, "{}: {:.4}", character.name, top / height);
    }
}

#[test]
fn boxes_without_a_width_are_not_carried() {
    for width_m in [f32::NAN, 0.0, -1.0] {
        assert!(people().iter().all(|person| carried(person, width_m).is_none()), "{width_m}");
    }
}
