//! Refused machines, and error messages that say how to fix them.

use populace::{Condition, Error, MachinePlayback, StateMachine, StatePlayback};

use crate::fixture::{Scene, machine, on_native};

#[track_caller]
fn assert_says<T: std::fmt::Debug>(result: Result<T, Error>, words: &str) {
    let said = result.unwrap_err().to_string();
    assert!(said.contains(words), "{said:?} does not contain {words:?}");
}

#[test]
fn invalid_machines_are_refused() {
    let mut scene = Scene::new(&on_native());
    let clip = scene.clips[0];
    let plain =
        StateMachine::new().parameter("speed", 0.0).state("idle", clip, StatePlayback::looping());
    let eight = (0..8).fold(plain.clone(), |machine, n| machine.parameter(&format!("p{n}"), 0.0));
    let to_idle = |condition| plain.clone().transition("idle", "idle", 0.1, &[condition]);
    let with = |play| plain.clone().state("other", clip, play);
    for (machine, words) in [
        (StateMachine::new(), "has no states"),
        (plain.clone().state("idle", clip, StatePlayback::once()), "two states \"idle\""),
        (plain.clone().parameter("speed", 1.0), "two parameters \"speed\""),
        (plain.clone().parameter("turn", f32::NAN), "is NaN"),
        (eight, "has 9 parameters"),
        (
            plain.clone().transition("idle", "idel", 0.1, &[]),
            "no state \"idel\"; did you mean \"idle\"",
        ),
        (plain.clone().transition("walk", "idle", 0.1, &[]), "no state \"walk\""),
        (plain.clone().transition_from_any("run", 0.1, &[]), "no state \"run\""),
        (
            plain.clone().transition("idle", "idle", f32::NAN, &[]),
            "the fade of a transition is NaN",
        ),
        (plain.clone().transition("idle", "idle", -0.1, &[]), "the fade of a transition is -0.1"),
        (to_idle(Condition::above("sped", 0.1)), "no parameter \"sped\"; did you mean \"speed\""),
        (to_idle(Condition::above("speed", f32::INFINITY)), "is inf"),
        (to_idle(Condition::AfterSecs(f32::NAN)), "the time in a state is NaN"),
        (to_idle(Condition::Ended), "waits in \"idle\" for the end"),
        (with(StatePlayback::looping().speed(f32::NAN)), "the speed of a clip is NaN"),
        (with(StatePlayback::live(0.1)), "is not live"),
    ] {
        assert_says(scene.crowd.add_machine(&machine), words);
    }
    let other = Scene::new(&on_native());
    assert_says(scene.crowd.add_machine(&machine(&other.clips)), "there is no clip");
    let member = scene.member(0);
    assert_says(
        scene
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.play_machine(other.machine, MachinePlayback::new())),
        "there is no state machine",
    );
}

#[test]
fn invalid_machine_playbacks_are_refused() {
    let mut scene = Scene::new(&on_native());
    let (member, machine) = (scene.member(0), scene.machine);
    let run = |scene: &mut Scene, play| {
        scene.crowd.member_mut(member).and_then(|mut m| m.play_machine(machine, play))
    };
    let set = |scene: &mut Scene, name, value| {
        scene.crowd.member_mut(member).and_then(|mut m| m.set_parameter(name, value))
    };
    let state = |scene: &mut Scene, layer| {
        scene.crowd.member_mut(member).and_then(|mut m| m.machine_state(layer))
    };
    assert_says(run(&mut scene, MachinePlayback::new().on_layer(4)), "the layer is 4");
    assert_says(set(&mut scene, "speed", 1.0), "runs no state machine");
    assert_says(state(&mut scene, 0), "of layer 0 has no state");
    run(&mut scene, MachinePlayback::new()).unwrap();
    assert_says(set(&mut scene, "sped", 1.0), "did you mean \"speed\"");
    assert_says(set(&mut scene, "speed", f32::NAN), "is NaN");
    assert_says(state(&mut scene, 1), "of layer 1 has no state");
    assert_says(state(&mut scene, 9), "the layer is 9");
    scene.edit(member).stop(0, 0.0).unwrap();
    assert_says(set(&mut scene, "speed", 1.0), "runs no state machine");
    assert_says(set(&mut scene, "sped", 1.0), "runs no state machine");
    run(&mut scene, MachinePlayback::new().after_secs(1.0)).unwrap();
    set(&mut scene, "speed", 1.0).unwrap();
    assert_says(set(&mut scene, "sped", 1.0), "did you mean \"speed\"");
    assert_says(state(&mut scene, 0), "has not started yet");
    scene.crowd.despawn(member).unwrap();
    assert_says(set(&mut scene, "speed", 1.0), "stale");
    assert_says(state(&mut scene, 0), "stale");
    assert_says(run(&mut scene, MachinePlayback::new()), "stale");

    let mut narrow = Scene::new(&on_native().slots_per_member(1));
    let (member, machine) = (narrow.member(0), narrow.machine);
    let play = MachinePlayback::new();
    assert_says(
        narrow.crowd.member_mut(member).and_then(|mut m| m.play_machine(machine, play)),
        "takes 2 slots",
    );
}
