use populace_device::layout::NONE;
use populace_testkit::Rng;

use super::*;
use crate::{ClipPlayback, Crowd, Device, MachinePlayback, Placement, StateMachine, StatePlayback};

/// Runs random starts of clips and machines and calls `look` after each frame.
fn run(slots: usize, mut look: impl FnMut(&Crowd, u32)) {
    let builder = Crowd::builder().device(Device::native()).slots_per_member(slots);
    let mut crowd = builder.build().unwrap();
    let lift = crowd.add_character(crate::crowd::tests::lift()).unwrap();
    let clip: ClipId = crowd.character(lift).unwrap().clips()[0].0;
    let machine = StateMachine::new().state("lifts", clip, StatePlayback::looping());
    let machine = crowd.add_machine(&machine).unwrap();
    let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
    crowd.member_mut(member).unwrap().play(clip, ClipPlayback::looping()).unwrap();
    let mut random = Rng::new(slots as u64);
    for _ in 0..6000 {
        let secs = u8::try_from(2 + random.below(4)).map_or(0.2, |tenths| f32::from(tenths) / 10.0);
        let play = ClipPlayback::looping().fade_in_secs(secs);
        match random.below(20) {
            0 => drop(crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
            1 => drop(
                crowd
                    .member_mut(member)
                    .unwrap()
                    .play_machine(machine, MachinePlayback::new().fade_in_secs(secs))
                    .unwrap(),
            ),
            _ => {}
        }
        crowd.update(0.01).unwrap();
        look(&crowd, member.number());
    }
}

#[test]
fn machine_slots_have_equal_weights_and_layers_keep_their_sum() {
    for slots in [4, 5, 8] {
        let mut most = 0;
        run(slots, |crowd, member_index| {
            let tick = crowd.state.base.clock.tick;
            let ramp = |s: &Slot| (s.weight_tick, s.start_weight, s.weight_rate, s.end_weight);
            // Slots of lower weight count as free, one at a time.
            let taken = |slot: &&Slot| slot.bound_clip != NONE && slot.weight_at(tick) > 2e-3;
            let all = crowd.state.base.slots(member_index);
            for slot in all.iter().filter(taken).filter(|slot| slot.machine_instance().is_some()) {
                let is_mate = |other: &&Slot| {
                    other.machine_instance() == slot.machine_instance()
                        && other.bound_clip != slot.bound_clip
                };
                assert_eq!(
                    all.iter().find(is_mate).map(ramp),
                    Some(ramp(slot)),
                    "{slots} slots: {all:?}"
                );
            }
            let total: f32 = all.iter().filter(taken).map(|slot| slot.weight_at(tick)).sum();
            // The sum is lower when a start cuts a fade short.
            assert!(total > 0.7 && total < 1.03, "{total} of {slots} slots: {all:?}");
            most = most.max(all.iter().filter(taken).count());
        });
        assert!(most >= slots.min(5), "{most} of {slots} slots were taken at once");
    }
}

/// A machine that starts without weight keeps both of its slots, and plays when it gets weight.
#[test]
fn a_machine_that_starts_at_weight_0_plays_once_it_has_weight() {
    for weight in [0.5, 0.0] {
        let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
        let lift = crowd.add_character(crate::crowd::tests::lift()).unwrap();
        let clip = crowd.character(lift).unwrap().clips()[0].0;
        let machine = StateMachine::new().state("up", clip, StatePlayback::held_at_secs(1.0));
        let machine = crowd.add_machine(&machine).unwrap();
        let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
        let mut view = crowd.member_mut(member).unwrap();
        let id = view.play_machine(machine, MachinePlayback::new().weight(weight)).unwrap();
        view.set_weight(id, 1.0, 0.1).unwrap();
        crowd.update(0.5).unwrap();
        let slots = crowd.state.base.slots(member.number());
        let own = slots.iter().filter(|slot| slot.machine_instance().is_some());
        assert_eq!(own.map(|slot| slot.end_weight).collect::<Vec<_>>(), [0.5; 2]);
        let joints = crowd.member_mut(member).unwrap().model_from_joints().unwrap();
        assert!((joints[0].rows[1][3] - 1.0).abs() < 1e-3, "weight {weight}: {joints:?}");
    }
}

#[test]
fn parameters_of_another_crowd_are_refused() {
    let of_a_crowd = || {
        let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
        let lift = crowd.add_character(crate::crowd::tests::lift()).unwrap();
        let clip = crowd.character(lift).unwrap().clips()[0].0;
        let machine = StateMachine::new().parameter("speed", 0.0);
        let machine = machine.state("lifts", clip, StatePlayback::looping());
        let machine = crowd.add_machine(&machine).unwrap();
        let member = crowd.spawn(lift, Placement::at([0.0; 3])).unwrap();
        let play = MachinePlayback::new();
        crowd.member_mut(member).unwrap().play_machine(machine, play).unwrap();
        let parameter = crowd.parameter(machine, "speed").unwrap();
        (crowd, member, parameter)
    };
    let ((mut crowd, member, own), (_, _, foreign)) = (of_a_crowd(), of_a_crowd());
    crowd.member_mut(member).unwrap().set_parameter(own, 1.0).unwrap();
    crowd.set_parameters(own, &[(member, 1.0)]).unwrap();
    let unknown = Error::UnknownId { what: IdKind::Machine, index: 0 };
    assert_eq!(crowd.member_mut(member).unwrap().set_parameter(foreign, 2.0), Err(unknown.clone()));
    assert_eq!(crowd.set_parameters(foreign, &[(member, 2.0)]), Err(unknown));
}
