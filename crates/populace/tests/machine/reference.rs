//! What machines do is what an interpreter says, and what they show is what the same clips played
//! by hand do.

use populace::clip::ticks_from_secs;
use populace::{MachinePlayback, MemberId};
use populace_testkit::Rng;

use crate::rig::{FRAME_SECS, Interpreter, STATES, Stage, everywhere};

/// Parameters that let members do all that there is.
fn steer(random: &mut Rng, own: &mut Interpreter) {
    if random.chance(0.03) {
        own.speed = [-1.0, 0.0, 0.3, 1.0, 2.5][random.below(5)];
    }
    if random.chance(0.02) {
        own.jump = [0.0, 0.0, 1.0][random.below(3)];
    }
}

/// Plays what a state does.
fn play(stage: &mut Stage, member: MemberId, state: &str, fade_secs: f32) {
    let (_, clip, _, play) = STATES.into_iter().find(|(name, ..)| *name == state).unwrap();
    stage
        .crowd
        .member_mut(member)
        .unwrap()
        .play(stage.clips[clip], play.fade_in_secs(fade_secs))
        .unwrap();
}

#[test]
fn a_machine_shows_what_the_same_clips_played_by_hand_do() {
    for builder in everywhere() {
        let mut stage = Stage::new(&builder);
        for body in [0, 1] {
            let (machine, hand) = (stage.machine_instance(body), stage.member(body));
            play(&mut stage, hand, "idle", 0.0);
            let (mut random, mut own) = (Rng::new(5 + body as u64), Interpreter::new());
            let mut seen = std::collections::HashSet::new();
            for frame in 0..700 {
                steer(&mut random, &mut own);
                own.tell(&mut stage.crowd, machine);
                stage.frame();
                let taken = own.step(ticks_from_secs(FRAME_SECS.into()));
                // A cut shows at once; by hand nobody could have known of it before the frame.
                if taken != Some(0.0) && (frame % 3 == 0 || taken.is_some()) {
                    let (wanted, found) = (stage.bits(hand), stage.bits(machine));
                    assert_eq!(
                        found,
                        wanted,
                        "frame {frame}, {own:?}, {:?}",
                        stage.crowd.schedule()
                    );
                }
                if let Some(fade_secs) = taken {
                    seen.insert(own.state);
                    play(&mut stage, hand, own.state, fade_secs);
                }
            }
            assert_eq!(seen.len(), STATES.len(), "{seen:?}");
        }
    }
}

#[test]
fn a_thousand_members_go_their_own_ways_on_every_device() {
    let mut first: Option<Vec<u32>> = None;
    for builder in everywhere() {
        let mut stage = Stage::new(&builder);
        let mut random = Rng::new(7);
        let mut members: Vec<_> =
            (0..1000).map(|n| (stage.machine_instance(n % 2), Interpreter::new())).collect();
        let mut bits = Vec::new();
        for frame in 0..300 {
            for (member, own) in &mut members {
                steer(&mut random, own);
                own.tell(&mut stage.crowd, *member);
            }
            // Now and then a step of many frames: one transition at most all the same.
            let secs = if frame % 50 == 49 { 0.75 } else { FRAME_SECS };
            stage.crowd.update(secs).unwrap();
            for (_, own) in &mut members {
                own.step(ticks_from_secs(secs.into()));
            }
            for _ in 0..3 {
                let (member, own) = &members[random.below(1000)];
                assert_eq!(
                    &*stage.crowd.member_mut(*member).unwrap().machine_state(0).unwrap(),
                    own.state,
                    "frame {frame}, {own:?}"
                );
            }
            if frame % 60 == 59 {
                bits.extend((0..1000).step_by(50).flat_map(|n| stage.bits(members[n].0)));
            }
        }
        for (member, own) in &members {
            assert_eq!(
                &*stage.crowd.member_mut(*member).unwrap().machine_state(0).unwrap(),
                own.state
            );
        }
        let expected = first.get_or_insert_with(|| bits.clone());
        let apart = expected.iter().zip(&bits).filter(|(a, b)| a != b).count();
        assert_eq!((apart, expected.len()), (0, bits.len()), "{:?}", stage.crowd.schedule());
    }
}

#[test]
fn machines_of_two_layers_share_parameters_by_name() {
    let mut stage = Stage::new(&crate::rig::on_native());
    let member = stage.machine_instance(0);
    stage
        .crowd
        .member_mut(member)
        .unwrap()
        .play_machine(stage.machine, MachinePlayback::new().on_layer(2))
        .unwrap();
    assert_eq!(
        &*stage.crowd.member_mut(member).unwrap().machine_state(2).unwrap(),
        "idle",
        "before any frame"
    );
    stage.crowd.member_mut(member).unwrap().set_parameter("speed", -1.0).unwrap();
    stage.frame();
    for layer in [0, 2] {
        assert_eq!(&*stage.crowd.member_mut(member).unwrap().machine_state(layer).unwrap(), "back");
    }
    stage.crowd.member_mut(member).unwrap().stop(2, 0.0).unwrap();
    stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(2)).unwrap_err();
    assert_eq!(&*stage.crowd.member_mut(member).unwrap().machine_state(0).unwrap(), "back");
}

#[test]
fn a_machine_that_waits_takes_parameters_and_begins_on_its_tick() {
    let mut stage = Stage::new(&crate::rig::on_native());
    let member = stage.member(0);
    stage
        .crowd
        .member_mut(member)
        .unwrap()
        .play_machine(stage.machine, MachinePlayback::new().after_secs(0.5))
        .unwrap();
    stage.crowd.member_mut(member).unwrap().set_parameter("speed", 1.0).unwrap();
    stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
    stage.crowd.update(0.4).unwrap();
    stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
    stage.crowd.update(0.1).unwrap();
    assert_eq!(&*stage.crowd.member_mut(member).unwrap().machine_state(0).unwrap(), "walk");
}

#[test]
fn a_machine_in_the_place_of_one_that_is_gone_begins_anew() {
    for builder in everywhere() {
        let mut stage = Stage::new(&builder);
        let gone = stage.machine_instance(0);
        stage.crowd.member_mut(gone).unwrap().set_parameter("speed", 1.0).unwrap();
        stage.frame();
        assert_eq!(&*stage.crowd.member_mut(gone).unwrap().machine_state(0).unwrap(), "walk");
        stage.crowd.despawn(gone).unwrap();
        let (machine, hand) = (stage.machine_instance(0), stage.member(0));
        play(&mut stage, hand, "idle", 0.0);
        stage.frame();
        assert_eq!(&*stage.crowd.member_mut(machine).unwrap().machine_state(0).unwrap(), "idle");
        assert_eq!(stage.bits(machine), stage.bits(hand));
    }
}
