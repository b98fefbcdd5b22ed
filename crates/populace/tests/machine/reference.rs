//! Machines take the transitions of the interpreter and show the poses of the same clips played
//! directly.

use populace::clip::ticks_from_secs;
use populace::{MachinePlayback, MemberId};
use populace_testkit::Rng;

use crate::fixture::{FRAME_SECS, Interpreter, STATES, Scene, everywhere};

/// Changes parameters at random so that members reach all states.
fn randomize(random: &mut Rng, own: &mut Interpreter) {
    if random.chance(0.03) {
        own.speed = [-1.0, 0.0, 0.3, 1.0, 2.5][random.below(5)];
    }
    if random.chance(0.02) {
        own.jump = [0.0, 0.0, 1.0][random.below(3)];
    }
}

/// Plays the clip of a state directly.
fn play_state(scene: &mut Scene, member: MemberId, state: &str, fade_secs: f32) {
    let (_, clip, _, play) = STATES.into_iter().find(|(name, ..)| *name == state).unwrap();
    scene
        .crowd
        .member_mut(member)
        .unwrap()
        .play(scene.clips[clip], play.fade_in_secs(fade_secs))
        .unwrap();
}

#[test]
fn machine_shows_the_same_poses_as_its_clips_played_directly() {
    for builder in everywhere() {
        let mut scene = Scene::new(&builder);
        for character in [0, 1] {
            let (machine, direct) = (scene.machine_instance(character), scene.member(character));
            play_state(&mut scene, direct, "idle", 0.0);
            let (mut random, mut own) = (Rng::new(5 + character as u64), Interpreter::new());
            let mut seen = std::collections::HashSet::new();
            for frame in 0..700 {
                randomize(&mut random, &mut own);
                own.set_parameters(&mut scene.crowd, machine);
                scene.frame();
                let taken = own.step(ticks_from_secs(FRAME_SECS.into()));
                // A cut shows at once; the clip can only be played directly after the frame.
                if taken != Some(0.0) && (frame % 3 == 0 || taken.is_some()) {
                    let (wanted, found) = (scene.bits(direct), scene.bits(machine));
                    assert_eq!(
                        found,
                        wanted,
                        "frame {frame}, {own:?}, {:?}",
                        scene.crowd.device_info().schedule
                    );
                }
                if let Some(fade_secs) = taken {
                    seen.insert(own.state);
                    play_state(&mut scene, direct, own.state, fade_secs);
                }
            }
            assert_eq!(seen.len(), STATES.len(), "{seen:?}");
        }
    }
}

#[test]
fn thousand_members_follow_the_interpreter_on_every_device() {
    let mut first: Option<Vec<u32>> = None;
    for builder in everywhere() {
        let mut scene = Scene::new(&builder);
        let mut random = Rng::new(7);
        let mut members: Vec<_> =
            (0..1000).map(|n| (scene.machine_instance(n % 2), Interpreter::new())).collect();
        let mut bits = Vec::new();
        for frame in 0..300 {
            for (member, own) in &mut members {
                randomize(&mut random, own);
                own.set_parameters(&mut scene.crowd, *member);
            }
            // Every 50th step is 36 frames long; it takes at most one transition too.
            let secs = if frame % 50 == 49 { 0.75 } else { FRAME_SECS };
            scene.crowd.update(secs).unwrap();
            for (_, own) in &mut members {
                own.step(ticks_from_secs(secs.into()));
            }
            for _ in 0..3 {
                let (member, own) = &members[random.below(1000)];
                assert_eq!(
                    &*scene.edit(*member).machine_state(0).unwrap(),
                    own.state,
                    "frame {frame}, {own:?}"
                );
            }
            if frame % 60 == 59 {
                bits.extend((0..1000).step_by(50).flat_map(|n| scene.bits(members[n].0)));
            }
        }
        for (member, own) in &members {
            assert_eq!(&*scene.edit(*member).machine_state(0).unwrap(), own.state);
        }
        let expected = first.get_or_insert_with(|| bits.clone());
        let apart = expected.iter().zip(&bits).filter(|(a, b)| a != b).count();
        assert_eq!(
            (apart, expected.len()),
            (0, bits.len()),
            "{:?}",
            scene.crowd.device_info().schedule
        );
    }
}

#[test]
fn machines_on_two_layers_share_parameters_by_name() {
    let mut scene = Scene::new(&crate::fixture::on_native());
    let member = scene.machine_instance(0);
    scene
        .crowd
        .member_mut(member)
        .unwrap()
        .play_machine(scene.machine, MachinePlayback::new().on_layer(2))
        .unwrap();
    assert_eq!(
        &*scene.edit(member).machine_state(2).unwrap(),
        "idle",
        "the state before any frame"
    );
    scene.edit(member).set_parameter("speed", -1.0).unwrap();
    scene.frame();
    for layer in [0, 2] {
        assert_eq!(&*scene.edit(member).machine_state(layer).unwrap(), "back");
    }
    scene.edit(member).stop(2, 0.0).unwrap();
    scene.crowd.member_mut(member).and_then(|mut m| m.machine_state(2)).unwrap_err();
    assert_eq!(&*scene.edit(member).machine_state(0).unwrap(), "back");
}

#[test]
fn scheduled_machine_takes_parameters_and_starts_on_time() {
    let mut scene = Scene::new(&crate::fixture::on_native());
    let member = scene.member(0);
    scene
        .crowd
        .member_mut(member)
        .unwrap()
        .play_machine(scene.machine, MachinePlayback::new().after_secs(0.5))
        .unwrap();
    scene.edit(member).set_parameter("speed", 1.0).unwrap();
    scene.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
    scene.crowd.update(0.4).unwrap();
    scene.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
    scene.crowd.update(0.1).unwrap();
    assert_eq!(&*scene.edit(member).machine_state(0).unwrap(), "walk");
}

#[test]
fn machine_in_a_reused_slot_starts_in_its_first_state() {
    for builder in everywhere() {
        let mut scene = Scene::new(&builder);
        let gone = scene.machine_instance(0);
        scene.edit(gone).set_parameter("speed", 1.0).unwrap();
        scene.frame();
        assert_eq!(&*scene.edit(gone).machine_state(0).unwrap(), "walk");
        scene.crowd.despawn(gone).unwrap();
        let (machine, direct) = (scene.machine_instance(0), scene.member(0));
        play_state(&mut scene, direct, "idle", 0.0);
        scene.frame();
        assert_eq!(&*scene.edit(machine).machine_state(0).unwrap(), "idle");
        assert_eq!(scene.bits(machine), scene.bits(direct));
    }
}
