//! Getting up: no jump on the way, and exactly the clips at the end.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use common::{DT, Scene, length, minus};
use populace_physics::{Error, State};

#[test]
fn getting_up_ends_bitwise_at_the_clip_and_keeps_buffers() {
    let mut scene = Scene::walking_man();
    let mut twin = Scene::walking_man();
    let buffers = |scene: &Scene| {
        let members = scene.crowd.members().map(|m| m.id());
        members.zip(scene.crowd.instances().map(|i| i.palette_first)).collect::<Vec<_>>()
    };
    let initial_buffers = buffers(&scene);
    scene.go_limp();
    for _ in 0..180 {
        scene.frame();
        twin.frame();
        assert_eq!(buffers(&scene), initial_buffers);
    }
    scene.ragdolls.get_up(&mut scene.crowd, scene.member, 1.0).unwrap();
    for _ in 0..59 {
        scene.frame();
        twin.frame();
        assert!(scene.joints() != twin.joints(), "still blending");
        assert_eq!(buffers(&scene), initial_buffers);
    }
    for _ in 0..2 {
        scene.frame();
        twin.frame();
    }
    assert_eq!(scene.ragdolls.state(scene.member), State::Animated);
    assert_eq!(scene.joints(), twin.joints());
    assert_eq!(
        scene.crowd.member_mut(scene.member).unwrap().palette().unwrap(),
        twin.crowd.member_mut(twin.member).unwrap().palette().unwrap()
    );
}

#[test]
fn getting_up_starts_where_the_body_lies() {
    for push in [[0.0, 0.0, -150.0], [120.0, 0.0, 60.0]] {
        let mut scene = Scene::walking_man();
        let (chest, hips) = (scene.joint("Spine4"), scene.joint("Pelvis"));
        let from = scene.position(hips);
        scene.go_limp();
        scene.ragdolls.push(scene.member, chest, push, None).unwrap();
        scene.frames(240);
        let lying = scene.positions();
        scene.ragdolls.get_up(&mut scene.crowd, scene.member, 1.5).unwrap();
        let mut before = lying.clone();
        let mut fastest: f32 = 0.0;
        let mut first = None;
        for _ in 0..95 {
            scene.frame();
            let now = scene.positions();
            let moved = now
                .iter()
                .zip(&before)
                .map(|(a, b)| length(minus(*a, *b)) / DT)
                .fold(0.0, f32::max);
            first.get_or_insert(moved);
            fastest = fastest.max(moved);
            before = now;
        }
        let up = before[hips.index()];
        let aside = length(minus([up[0], 0.0, up[2]], [lying[0][0], 0.0, lying[0][2]]));
        let away = length(minus(lying[0], from));
        println!(
            "fell at {away} m; joints start at {first:?} m/s and reach {fastest} m/s; hips end \
             {aside} m from where they lay"
        );
        // The speed depends on the pose that he lies in: 4.2 to 6.5 m/s after forty pushes.
        assert!(away > 0.3 && aside < 0.15 && fastest < 7.0);
        assert!(first.unwrap() < 0.2);
        assert!(before.iter().map(|p| p[1]).fold(f32::MIN, f32::max) > 1.4, "he stands up");
    }
}

#[test]
fn falling_again_while_getting_up_has_no_jump() {
    let mut scene = Scene::walking_man();
    scene.go_limp();
    scene.frames(120);
    scene.ragdolls.get_up(&mut scene.crowd, scene.member, 1.0).unwrap();
    scene.frames(45);
    assert!(
        matches!(scene.ragdolls.state(scene.member), State::GettingUp { weight } if weight < 0.3)
    );
    scene.go_limp();
    let mut before = scene.positions();
    let mut fastest: f32 = 0.0;
    for _ in 0..180 {
        scene.frame();
        let now = scene.positions();
        fastest = fastest.max(
            now.iter().zip(&before).map(|(a, b)| length(minus(*a, *b)) / DT).fold(0.0, f32::max),
        );
        before = now;
    }
    println!("fastest joint at {fastest} m/s");
    assert!(fastest < 9.0 && before[0][1] < 0.4);
}

#[test]
fn get_up_of_a_member_that_is_not_limp_is_refused() {
    let mut scene = Scene::walking_man();
    let refused = scene.ragdolls.get_up(&mut scene.crowd, scene.member, 1.0);
    assert_eq!(refused, Err(Error::NotLimp));
    scene.go_limp();
    scene.ragdolls.get_up(&mut scene.crowd, scene.member, 0.0).unwrap();
    scene.frames(5);
    assert_eq!(scene.ragdolls.state(scene.member), State::Animated);
    scene.go_limp();
    scene.frames(5);
    scene.ragdolls.get_up(&mut scene.crowd, scene.member, 0.0).unwrap();
    scene.frame();
    assert_eq!(scene.ragdolls.state(scene.member), State::Animated);
}
