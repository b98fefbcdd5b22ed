//! Getting up with motions: the right one, without a jump, standing at the end.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use std::f32::consts::TAU;
use std::sync::Arc;

use common::{DT, Scene, chain, length, minus};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Track, Trs};
use populace::{ActiveClip, ClipId, ClipPlayback, Crowd, JointIndex, Placement};
use populace_cast::{Look, person};
use populace_physics::{Error, GetUp, RagdollPlan, State};

const NAMES: [&str; 4] = ["GetUp_Back", "GetUp_Front", "GetUp_Left", "GetUp_Right"];

/// Returns a scene in which a person lies as at the start of a motion.
fn lying(look: &Look, name: &str, placement: Placement) -> Scene {
    let mut scene = Scene::new(person(look).unwrap(), Some("Idle"), placement);
    let clip = scene.crowd.clip(scene.character, name).unwrap();
    let held = ClipPlayback::held_at_secs(0.0).on_layer(1);
    scene.crowd.member_mut(scene.member).unwrap().play(clip, held).unwrap();
    scene.crowd.update(0.0).unwrap();
    scene.go_limp();
    scene.frames(8);
    scene.crowd.member_mut(scene.member).unwrap().stop(1, 0.0).unwrap();
    scene
}

fn get_up(scene: &mut Scene) -> GetUp {
    let get_up = GetUp::find(&scene.crowd, scene.character);
    scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &get_up).unwrap();
    get_up
}

/// Returns the name of the motion that the member plays.
fn motion(scene: &Scene) -> String {
    let member = scene.crowd.member(scene.member).unwrap();
    let active = member.active_clips();
    let playing = active.iter().find(|playing| playing.layer == 3).unwrap().clip;
    let clips = scene.crowd.character(scene.character).unwrap().clips();
    clips.into_iter().find(|(id, _)| *id == playing).unwrap().1.name().to_owned()
}

/// Steps until the member is animated, and checks that no joint sinks lower than `before`, where
/// the ragdoll lies. Returns the speed of the fastest joint in m/s and the time at which it was
/// that fast.
fn follow(scene: &mut Scene, mut before: Vec<[f32; 3]>) -> (f32, f32) {
    let mut fastest = (0.0, 0.0);
    let lowest = before.iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    for frame in 0..400_u16 {
        scene.frame();
        let now = scene.positions();
        let moved = now.iter().zip(&before).map(|(a, b)| length(minus(*a, *b)));
        let speed = moved.fold(0.0, f32::max) / DT;
        let low = now.iter().map(|p| p[1]).fold(f32::MAX, f32::min);
        assert!(low > lowest.min(0.0) - 0.04, "a joint is at {low} m after {frame} frames");
        if speed > fastest.0 {
            fastest = (speed, f32::from(frame) * DT);
        }
        before = now;
        if scene.ragdolls.state(scene.member) == State::Animated {
            return fastest;
        }
    }
    panic!("the member never gets up");
}

#[test]
fn the_side_on_the_ground_chooses_the_motion_for_every_heading() {
    for look in [Look::man(), Look::child()] {
        for name in NAMES {
            for turn in 0..8_u8 {
                let place = Placement::at([3.0, 0.0, -2.0]).facing(TAU * f32::from(turn) / 8.0);
                let mut scene = lying(&look, name, place);
                get_up(&mut scene);
                scene.frame();
                assert_eq!(motion(&scene), name, "{} {turn}", look.name);
                let now = scene.crowd.member(scene.member).unwrap().placement();
                let moved = length(minus(now.position(), place.position()));
                let turned = (now.yaw_rad() - place.yaw_rad() + 0.5 * TAU).rem_euclid(TAU);
                println!(
                    "{} {name} {turn}: moved {moved}, turned {}",
                    look.name,
                    turned - 0.5 * TAU
                );
                assert!(moved < 0.05 && (turned - 0.5 * TAU).abs() < 0.1);
            }
        }
    }
}

#[test]
fn falls_end_standing_without_a_jump() {
    let mut chosen = std::collections::BTreeSet::new();
    for look in Look::presets() {
        for push in [[0.0, 0.0, -2.5], [0.0, 0.0, 2.5], [2.5, 0.0, 0.3], [-2.5, 0.0, 0.3]] {
            let mut scene =
                Scene::new(person(&look).unwrap(), Some("Idle"), Placement::at([2.0, 0.0, -1.0]));
            let stands = scene.positions();
            scene.go_limp();
            let chest = ["Spine4", "chest"].iter().find_map(|name| scene.skeleton().find(name));
            let impulse = push.map(|v| v * scene.plan.mass_kg());
            scene.ragdolls.push(scene.member, chest.unwrap(), impulse, None).unwrap();
            scene.frames(240);
            let lay = scene.positions();
            get_up(&mut scene);
            let kind = motion(&scene);
            let fastest = follow(&mut scene, lay.clone());
            println!("{} {push:?} {kind}: {fastest:.2?}", look.name);
            chosen.insert(kind);
            let up = scene.positions();
            let [tall, now] = [&stands, &up].map(|p| p.iter().map(|p| p[1]).fold(0.0, f32::max));
            assert!((tall - now).abs() < 0.03, "{} stands", look.name);
            let away = length(minus([up[0][0], 0.0, up[0][2]], [lay[0][0], 0.0, lay[0][2]]));
            assert!(away < 0.5 * tall, "{} gets up {away} m from where they lay", look.name);
            assert!(fastest.0 < 5.0, "{} {push:?}: {fastest:?}", look.name);
            scene.frame();
            let active = scene.crowd.member(scene.member).unwrap().active_clips();
            assert_eq!(active.len(), 1, "only what the member played goes on");
        }
    }
    assert!(chosen.len() >= 3, "falls end in {chosen:?} only");
}

#[test]
fn members_return_bitwise_to_what_they_played() {
    let place = Placement::at([1.0, 0.0, 0.5]).facing(0.4);
    let mut scene = lying(&Look::woman(), "GetUp_Right", place);
    get_up(&mut scene);
    let before = scene.positions();
    follow(&mut scene, before);
    let mut twin = Scene::new(person(&Look::woman()).unwrap(), Some("Idle"), place);
    #[expect(clippy::cast_possible_truncation, reason = "a few seconds")]
    let rest_secs = (scene.crowd.time_secs() - twin.crowd.time_secs()) as f32;
    twin.crowd.update(rest_secs).unwrap();
    assert_eq!(scene.crowd.time_secs(), twin.crowd.time_secs());
    assert_eq!(scene.joints(), twin.joints());
}

#[test]
fn equal_falls_give_equal_motions() {
    let run = || {
        let mut scene = lying(&Look::old_man(), "GetUp_Left", Placement::at([0.5, 0.0, 0.0]));
        get_up(&mut scene);
        let mut bits = Vec::new();
        for _ in 0..300 {
            scene.frame();
            bits.extend(scene.joints().iter().flat_map(|m| m.rows).flatten().map(f32::to_bits));
        }
        bits
    };
    assert!(run() == run());
}

#[test]
fn motions_of_another_body_start_where_the_member_lies() {
    let mut scene = lying(&Look::child(), "GetUp_Front", Placement::at([0.0; 3]).scaled(0.8));
    let lay = scene.positions();
    let man = person(&Look::man()).unwrap();
    let mut add = |name: &str| {
        let clip = man.clips.iter().find(|clip| clip.name() == name).unwrap();
        Some(scene.crowd.character_mut(scene.character).unwrap().add_clip(clip).unwrap())
    };
    let get_up = GetUp { back: add("GetUp_Back"), front: add("GetUp_Front"), ..GetUp::default() };
    scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &get_up).unwrap();
    let hips = scene.plan.bodies()[0].joint();
    scene.frames(48);
    let eased = scene.position(hips);
    assert!(length(minus(eased, lay[hips.index()])) < 0.05, "{eased:?} {:?}", lay[hips.index()]);
    let before = scene.positions();
    assert!(follow(&mut scene, before).0 < 5.0);
}

#[test]
fn members_fall_again_while_they_get_up() {
    let mut scene = lying(&Look::man(), "GetUp_Back", Placement::at([0.0; 3]));
    let get_up = get_up(&mut scene);
    scene.frames(170);
    assert_eq!(scene.ragdolls.state(scene.member), State::GettingUp { weight: 0.0 });
    assert_eq!(scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &get_up), Ok(()));
    scene.go_limp();
    let mut before = scene.positions();
    let mut fastest: f32 = 0.0;
    for _ in 0..150 {
        scene.frame();
        let now = scene.positions();
        let moved = now.iter().zip(&before).map(|(a, b)| length(minus(*a, *b)));
        fastest = fastest.max(moved.fold(0.0, f32::max) / DT);
        before = now;
    }
    assert!(fastest < 9.0 && before[0][1] < 0.4, "{fastest} m/s");
    let member = scene.crowd.member(scene.member).unwrap();
    assert!(member.active_clips().iter().all(|clip| clip.layer == 0), "the motion has ended");
    assert!(matches!(scene.ragdolls.state(scene.member), State::Limp { .. }));
}

/// Returns what the member plays, its placement, and its state.
fn shown(scene: &Scene) -> (Vec<ActiveClip>, Placement, State) {
    let member = scene.crowd.member(scene.member).unwrap();
    (member.active_clips(), member.placement(), scene.ragdolls.state(scene.member))
}

/// Adds a character that shares no joint with a person, and returns its clip.
fn stray_motion(crowd: &mut Crowd) -> ClipId {
    let stick = chain(&[[0.0; 3]; 3]);
    let track = Track {
        joint: "joint 0".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0; 6],
    };
    let source = ClipSource { name: "Stray".into(), tracks: vec![track] };
    let clip = Arc::new(Clip::new(source, &stick.skeleton).unwrap());
    let stick = crowd.add_character(stick).unwrap();
    crowd.character_mut(stick).unwrap().add_clip(&clip).unwrap()
}

#[test]
fn refused_motions_change_nothing() {
    let mut scene = lying(&Look::man(), "GetUp_Back", Placement::at([0.0; 3]));
    let own = GetUp::find(&scene.crowd, scene.character);
    let stray = stray_motion(&mut scene.crowd);
    let plan = Arc::new(RagdollPlan::from_skeleton(scene.skeleton()));
    scene.ragdolls.go_limp(&scene.crowd, scene.member, &plan).unwrap();
    let before = shown(&scene);
    assert_eq!(before.2, State::GoingLimp);
    let misfit = GetUp { back: Some(stray), ..GetUp::default() };
    let refused = scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &misfit);
    assert!(matches!(refused, Err(Error::Crowd(_))), "{refused:?}");
    assert_eq!(shown(&scene), before);
    let parent = scene.crowd.spawn(scene.character, Placement::at([3.0, 0.0, 0.0])).unwrap();
    let mut member = scene.crowd.member_mut(scene.member).unwrap();
    member.attach_to(parent, JointIndex(0), Trs::IDENTITY).unwrap();
    let before = shown(&scene);
    let refused = scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &own);
    let is_expected = matches!(refused, Err(Error::Crowd(populace::Error::BadAttachment(_))));
    assert!(is_expected, "{refused:?}");
    assert_eq!(shown(&scene), before);
    scene.crowd.member_mut(scene.member).unwrap().detach().unwrap();
    scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &own).unwrap();
    assert!(matches!(scene.ragdolls.state(scene.member), State::GettingUp { .. }));
}

#[test]
fn without_motions_members_blend_and_bad_settings_are_refused() {
    let mut scene = lying(&Look::man(), "GetUp_Front", Placement::at([0.0; 3]));
    let bad = |scene: &mut Scene, get_up: GetUp| {
        let result = scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &get_up);
        assert!(matches!(result, Err(Error::BadValue { .. })), "{result:?}");
    };
    for layer in [0, 4] {
        bad(&mut scene, GetUp { layer, ..GetUp::default() });
    }
    bad(&mut scene, GetUp { ease_secs: -1.0, ..GetUp::default() });
    bad(&mut scene, GetUp { ease_secs: 1e30, ..GetUp::default() });
    bad(&mut scene, GetUp { return_secs: f32::NAN, ..GetUp::default() });
    let none = GetUp { ease_secs: 0.5, return_secs: 0.5, ..GetUp::default() };
    scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &none).unwrap();
    scene.frames(30);
    let State::GettingUp { weight } = scene.ragdolls.state(scene.member) else { panic!() };
    assert!((0.4..0.6).contains(&weight));
    scene.frames(31);
    assert_eq!(scene.ragdolls.state(scene.member), State::Animated);
    let again = scene.ragdolls.get_up_with(&mut scene.crowd, scene.member, &none);
    assert_eq!(again, Err(Error::NotLimp));
}
