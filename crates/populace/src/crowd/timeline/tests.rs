use populace_model::{Affine, JointIndex, Trs};

use super::super::tests::lift;
use super::*;
use crate::{
    ClipPlayback, Device, JointOverride, MachinePlayback, Placement, Space, StateMachine,
    StatePlayback,
};

/// A crowd of one member, and a clip that lifts it by 1 m in a second.
fn crowd() -> (Crowd, MemberId, crate::ClipId) {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(lift()).unwrap();
    let clip = crowd.clip(id, "Lift").unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    (crowd, member, clip)
}

fn palette(crowd: &mut Crowd, member: MemberId) -> Vec<Affine> {
    crowd.member_mut(member).unwrap().palette().unwrap()
}

fn kinds(report: &SeekReport) -> Vec<History> {
    report.inexact.iter().map(|(kind, _)| *kind).collect()
}

#[test]
fn seeking_equals_updating_for_functions_of_time() {
    let (mut crowd, member, clip) = crowd();
    let mut view = crowd.member_mut(member).unwrap();
    view.play(clip, ClipPlayback::looping().speed(0.7)).unwrap();
    view.play(clip, ClipPlayback::once().speed(0.3).on_layer(1).fade_in_secs(2.0)).unwrap();
    view.play(clip, ClipPlayback::looping().after_secs(1.5).fade_in_secs(0.4)).unwrap();
    let frames: Vec<_> = (0..60)
        .map(|_| {
            crowd.update(0.05).unwrap();
            (crowd.time_secs(), palette(&mut crowd, member))
        })
        .collect();
    for at in [59, 3, 40, 0, 20, 58] {
        let (secs, expected) = &frames[at];
        crowd.seek(*secs).unwrap();
        assert_eq!(palette(&mut crowd, member), *expected, "at {secs} s");
    }
    assert!(kinds(&crowd.seek(0.5).unwrap()) == [History::Playbacks], "the last clip is later");
    assert!(crowd.seek(5.0).unwrap().inexact.is_empty());
}

#[test]
fn a_jump_starts_what_is_due_and_a_jump_back_reports_no_event() {
    let (mut crowd, member, clip) = crowd();
    let mut view = crowd.member_mut(member).unwrap();
    view.subscribe_events();
    view.play(clip, ClipPlayback::once().after_secs(10.0)).unwrap();
    crowd.seek(10.25).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips().len(), 1);
    crowd.seek(20.0).unwrap();
    assert_eq!(crowd.events().len(), 1, "the end of the clip");
    crowd.seek(10.5).unwrap();
    assert!(crowd.events().is_empty());
    for bad in [-1.0, f64::NAN, f64::INFINITY, 2e9] {
        assert!(matches!(crowd.seek(bad), Err(Error::BadValue { .. })));
    }
    assert!((crowd.time_secs() - 10.5).abs() < 1e-9, "a refused jump changes nothing");
}

#[test]
fn state_that_depends_on_earlier_frames_is_reported() {
    let (mut crowd, member, clip) = crowd();
    let machine = StateMachine::new().state("lifts", clip, StatePlayback::looping());
    let machine = crowd.add_machine(&machine).unwrap();
    let mut view = crowd.member_mut(member).unwrap();
    view.play_machine(machine, MachinePlayback::new()).unwrap();
    view.start_root_motion().unwrap();
    let transform = Trs::IDENTITY;
    let joint = JointIndex(0);
    let set = JointOverride { joint, space: Space::Local, transform, weight: 0.5 };
    view.override_joints(&[set]).unwrap();
    crowd.update(1.0).unwrap();
    let forwards = crowd.seek(3.0).unwrap();
    let both = [History::Overrides, History::StateMachines].map(|kind| (kind, vec![member]));
    assert_eq!(forwards.inexact, both);
    let back = kinds(&crowd.seek(2.0).unwrap());
    assert_eq!(back, [History::Overrides, History::RootMotion, History::StateMachines]);
    assert!(crowd.seek(2.0).unwrap().inexact.is_empty(), "no jump");
}

/// A machine takes at most one transition in a jump, so the report names it: while it runs, and if
/// it starts on the way.
#[test]
fn a_jump_past_several_transitions_is_reported() {
    for delay_secs in [0.0, 1.0] {
        let run =
            |jumps: bool| {
                let (mut crowd, member, clip) = crowd();
                let machine =
                    ["a", "b", "c"].into_iter().fold(StateMachine::new(), |machine, name| {
                        machine.state(name, clip, StatePlayback::once())
                    });
                let machine = machine
                    .transition("a", "b", 0.0, &[crate::Condition::Ended])
                    .transition("b", "c", 0.0, &[crate::Condition::Ended]);
                let machine = crowd.add_machine(&machine).unwrap();
                let play = MachinePlayback::new().after_secs(delay_secs);
                crowd.member_mut(member).unwrap().play_machine(machine, play).unwrap();
                let early = crowd.seek(0.5).unwrap();
                assert_eq!(early.inexact.is_empty(), delay_secs > 0.5, "{early:?}");
                let report = if jumps {
                    crowd.seek(5.0).unwrap()
                } else {
                    (0..45).for_each(|_| crowd.update(0.1).unwrap());
                    SeekReport::default()
                };
                let state = crowd.member_mut(member).unwrap().machine_state(0).unwrap();
                (state, kinds(&report))
            };
        let (exact, jumped) = (run(false).0, run(true));
        assert!(exact != jumped.0, "a jump of one frame takes both transitions");
        assert_eq!(jumped.1, [History::StateMachines], "after {delay_secs} s");
    }
}
