//! What machines are refused for, and that the words say how to mend it.

use populace::{Condition, Error, MachinePlayback, StateMachine, StatePlayback};

use crate::rig::{Stage, machine, on_native};

#[track_caller]
fn assert_says<T: std::fmt::Debug>(result: Result<T, Error>, words: &str) {
    let said = result.unwrap_err().to_string();
    assert!(said.contains(words), "{said:?} does not say {words:?}");
}

#[test]
fn machines_that_cannot_be() {
    let mut stage = Stage::new(&on_native());
    let clip = stage.clips[0];
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
        assert_says(stage.crowd.add_machine(&machine), words);
    }
    let other = Stage::new(&on_native());
    assert_says(stage.crowd.add_machine(&machine(&other.clips)), "there is no clip");
    let member = stage.member(0);
    assert_says(
        stage
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.play_machine(other.machine, MachinePlayback::new())),
        "there is no state machine",
    );
}

#[test]
fn machines_that_cannot_run_so() {
    let mut stage = Stage::new(&on_native());
    let (member, machine) = (stage.member(0), stage.machine);
    let mut run =
        |play| stage.crowd.member_mut(member).and_then(|mut m| m.play_machine(machine, play));
    assert_says(run(MachinePlayback::new().on_layer(4)), "the layer is 4");
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("speed", 1.0)),
        "runs no state machine",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)),
        "of layer 0 has no state",
    );
    stage.crowd.member_mut(member).unwrap().play_machine(machine, MachinePlayback::new()).unwrap();
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("sped", 1.0)),
        "did you mean \"speed\"",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("speed", f32::NAN)),
        "is NaN",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(1)),
        "of layer 1 has no state",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(9)),
        "the layer is 9",
    );
    stage.crowd.member_mut(member).unwrap().stop(0, 0.0).unwrap();
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("speed", 1.0)),
        "runs no state machine",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("sped", 1.0)),
        "runs no state machine",
    );
    stage
        .crowd
        .member_mut(member)
        .unwrap()
        .play_machine(machine, MachinePlayback::new().after_secs(1.0))
        .unwrap();
    stage.crowd.member_mut(member).unwrap().set_parameter("speed", 1.0).unwrap();
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("sped", 1.0)),
        "did you mean \"speed\"",
    );
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)),
        "has not started yet",
    );
    stage.crowd.despawn(member).unwrap();
    assert_says(
        stage.crowd.member_mut(member).and_then(|mut m| m.set_parameter("speed", 1.0)),
        "stale",
    );
    assert_says(stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)), "stale");
    assert_says(
        stage
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.play_machine(machine, MachinePlayback::new())),
        "stale",
    );

    let mut narrow = Stage::new(&on_native().slots_per_member(1));
    let member = narrow.member(0);
    assert_says(
        narrow
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.play_machine(narrow.machine, MachinePlayback::new())),
        "takes 2 slots",
    );
}
