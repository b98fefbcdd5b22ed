//! Things that the people of scene files hold.
#![allow(clippy::unwrap_used, reason = "a scene that cannot be made fails the test")]

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use populace::model::{Role, Side};
use populace::{Affine, Crowd, Device, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::plan::ScenePlan;
use populace_scene::{Behaviours, Person, Stage};

/// A man and what he has, in his model space.
struct Bearer {
    wrists: [Vec3; 2],
    head: Vec3,
    things: Vec<Affine>,
}

/// Returns a man of a scene, who stands or walks and holds a thing.
fn bearer(thing: &str, does: &str) -> Bearer {
    let plan = ScenePlan::parse(&format!(
        "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\nholds = [\"{thing}\"]\n[[crowd]]\n\
         cast = \"a\"\ncount = 1\n{does}\n"
    ));
    let plan = plan.unwrap();
    let builder = Crowd::builder().device(Device::native()).capacity(100).slots_per_member(8);
    let mut crowd = builder.build().unwrap();
    let man = populace_cast::person(&populace_cast::Look::man()).unwrap();
    let character = crowd.add_character(man).unwrap();
    let gaits = GaitSpace::of_all(&mut crowd, &[character]).into_iter().flatten().collect();
    let person = Person { character, scale: 1.0, look: None };
    let prepare = |character| Ok(Arc::new(character));
    let stage = Stage::new(&mut crowd, &plan, &BTreeMap::new(), &prepare).unwrap();
    let mut behaviours =
        Behaviours::new(&mut crowd, &plan, &stage, &[vec![person]], gaits).unwrap();
    behaviours.advance(&mut crowd, 0.1).unwrap();
    crowd.update(0.1).unwrap();
    let man = behaviours.people().next().unwrap();
    let held = crowd.members().filter(|member| member.attached_to().is_some());
    let held: Vec<MemberId> = held.map(|member| member.id()).collect();
    let mut model_of = |member| crowd.member_mut(member).unwrap().model_from_joints().unwrap();
    let joints = model_of(man);
    let things = held.into_iter().map(|held| model_of(held)[0]).collect();
    let place = |role| {
        let joint = crowd.member(man).unwrap().joint(role).unwrap();
        Vec3::from(joints[joint.index()].transform_point([0.0; 3]))
    };
    let wrists = [Side::Left, Side::Right].map(|side| place(Role::Hand(side)));
    Bearer { wrists, head: place(Role::Head), things }
}

/// Returns true if a single box stands upright with its sides at both hands.
fn is_between_both_hands(stand: &str) -> bool {
    let Bearer { wrists, things: boxes, .. } = bearer("box", stand);
    assert_eq!(boxes.len(), 1, "{stand}");
    let at = |point| Vec3::from(boxes[0].transform_point(point));
    let up = (at([0.0, 1.0, 0.0]) - at([0.0; 3])).normalize();
    let side = 0.5 * populace_props::PARCEL_WIDTH_M;
    let sides = [at([side, 0.1, 0.0]), at([-side, 0.1, 0.0])];
    let is_near = wrists.iter().zip(sides).all(|(wrist, side)| wrist.distance(side) < 0.2);
    up.y > 0.97 && is_near
}

#[test]
fn a_box_lies_between_both_hands_of_who_plays_the_clip_of_carrying() {
    assert!(is_between_both_hands("does.stand = { clip = \"Carry\" }"));
    assert!(is_between_both_hands("does.stand = {}\nlayers = [{ clip = \"Carry\" }]"));
}

#[test]
fn a_box_is_in_the_right_hand_of_others() {
    for stand in [
        "does.stand = {}",
        "does.stand = {}\nlayers = [{ clip = \"Carry\", share = 0 }]",
        "does.stand = {}\nlayers = [{ clip = \"Carry\", mask = \"left_arm\" }]",
    ] {
        assert!(!is_between_both_hands(stand), "{stand}");
        let Bearer { wrists: [_, right], things: boxes, .. } = bearer("box", stand);
        let at = Vec3::from(boxes[0].transform_point([0.0; 3]));
        assert!(at.distance(right) < 0.2, "{stand}: {at}, {right}");
    }
}

/// A stroller with a parcel of its own has no second box in the same place.
#[test]
fn who_carries_a_parcel_has_one_box() {
    let stroll = "does.stroll = { carry = 1 }\n[[footway]]\nname = \"f\"\n\
                  points = [[-6, 3], [6, 3]]\nwidth_m = 2";
    assert_eq!(bearer("box", stroll).things.len(), 1);
}

/// Returns the cosine between where the screen of a phone faces and the way from there to the head.
fn screen_to_head(does: &str) -> f32 {
    let Bearer { head, things: phones, .. } = bearer("phone", does);
    let at = |point| Vec3::from(phones[0].transform_point(point));
    let (middle, ahead) = (at([0.0; 3]), at([0.0, 0.0, 1.0]));
    (ahead - middle).normalize().dot((head - middle).normalize())
}

#[test]
fn the_screen_of_a_phone_faces_the_head_of_who_reads_and_telephones() {
    for does in [
        "does.stand = { clip = \"Text\" }",
        "does.stand = { clip = \"Phone\" }",
        "does.stand = {}\nlayers = [{ clip = \"Text\", mask = \"right_arm\" }]",
    ] {
        let cosine = screen_to_head(does);
        assert!(cosine > 0.5, "{does}: {cosine}");
    }
}
