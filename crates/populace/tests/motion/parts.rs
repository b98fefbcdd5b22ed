//! Frames in which something starts, ends or is cut.

use populace::MachinePlayback;

use super::*;

#[test]
fn long_steps_runs_that_end_and_runs_backwards_arrive_where_short_ones_do() {
    everywhere(|stage| {
        let (_, taken) = add(stage, curve());
        let plays = [
            ClipPlayback::looping().phase(0.5),
            ClipPlayback::looping().speed(-1.3),
            ClipPlayback::once(),
            ClipPlayback::once().speed(-0.6),
        ];
        let cycles = [7.2, -7.2 * 1.3, 1.0, -1.0];
        let members = plays.map(|play| {
            let member = stage.member(Placement::at([0.0; 3]));
            stage.crowd.member_mut(member).expect("a clip").play(taken, play).expect("a clip");
            stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .start_root_motion()
                .expect("a member");
            member
        });
        stage.update(7.2 * SECS);
        for ((member, cycles), start) in
            members.into_iter().zip(cycles).zip([0.5_f32, 1.0, 0.0, 1.0])
        {
            let wanted = carried(-start).mul(&carried(start + cycles));
            let found = stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .moved_placement()
                .expect("a member")
                .world_from_model();
            assert!(
                apart(&[wanted], &[found]) < 3e-3,
                "{cycles} cycles: {found:?} is not {wanted:?}"
            );
        }
        // What has ended, and what stands, stays.
        let before = stage.crowd.member_mut(members[2]).and_then(|mut m| m.moved_placement());
        stage.update(1.0);
        assert_eq!(
            stage.crowd.member_mut(members[2]).and_then(|mut m| m.moved_placement()),
            before
        );
    });
}

#[test]
fn motion_is_mixed_as_poses_are() {
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let still = stage.clip("sway");
        let member = stage.member(Placement::at([0.0; 3]));
        let close = |found: f32, wanted: f32| {
            assert!((found - wanted).abs() < 2e-5, "{found} m is not {wanted} m")
        };
        stage
            .crowd
            .member_mut(member)
            .expect("a clip")
            .play(fast, ClipPlayback::looping())
            .expect("a clip");
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        close(step_of(stage, member, 0.01), 0.02);
        stage.crowd.member_mut(member).expect("a clip").crossfade(slow, 1.0).expect("a clip");
        stage.update(0.49);
        // Between 0.49 and 0.5 of the fade.
        close(step_of(stage, member, 0.01), 0.02 - 0.015 * 0.495);
        stage.update(0.51);
        close(step_of(stage, member, 0.01), 0.005);
        // Layers: through a mask without the root, for the whole body by half, and adding.
        let legs = Mask::of_subtrees(&character().skeleton, ["leftUpperLeg"]).expect("a joint");
        let legs = stage.crowd.add_mask(stage.body, &legs).expect("room");
        let settings = LayerSettings::default();
        stage
            .crowd
            .member_mut(member)
            .expect("a layer")
            .set_layer(1, settings, Some(legs))
            .expect("a layer");
        stage
            .crowd
            .member_mut(member)
            .expect("a clip")
            .play(still, ClipPlayback::looping().on_layer(1))
            .expect("a clip");
        close(step_of(stage, member, 0.01), 0.005);
        stage
            .crowd
            .member_mut(member)
            .expect("a layer")
            .set_layer(1, LayerSettings { weight: 0.5, ..settings }, None)
            .expect("a layer");
        close(step_of(stage, member, 0.01), 0.0025);
        stage
            .crowd
            .member_mut(member)
            .expect("a layer")
            .set_layer(1, LayerSettings { mode: LayerMode::Additive, ..settings }, None)
            .expect("a layer");
        stage
            .crowd
            .member_mut(member)
            .expect("a clip")
            .play(fast, ClipPlayback::looping().on_layer(1))
            .expect("a clip");
        close(step_of(stage, member, 0.01), 0.005);
    });
}

#[test]
fn a_start_within_a_long_step_leaves_what_was_played_before_it() {
    let cut = ClipPlayback::looping().after_secs(0.3);
    let faded = ClipPlayback::looping().fade_in_secs(0.2);
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let machine = StateMachine::new().state("slow", slow, StatePlayback::looping());
        let machine = stage.crowd.add_machine(&machine).expect("a machine");
        let [late, cuts, fades, above, left, entering, leaving] = [(); 7].map(|()| {
            let member = stage.member(Placement::at([0.0; 3]));
            stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .start_root_motion()
                .expect("a member");
            member
        });
        let crowd = &mut stage.crowd;
        crowd.member_mut(late).expect("a clip").play(slow, cut).expect("a clip");
        for member in [cuts, fades, above, left, entering] {
            crowd
                .member_mut(member)
                .expect("a clip")
                .play(fast, ClipPlayback::looping())
                .expect("a clip");
        }
        crowd.member_mut(cuts).expect("a clip").play(slow, cut).expect("a clip");
        crowd.member_mut(fades).expect("a clip").play(slow, faded.after_secs(0.1)).expect("a clip");
        crowd
            .member_mut(above)
            .expect("a layer")
            .set_layer(1, LayerSettings::default(), None)
            .expect("a layer");
        crowd.member_mut(above).expect("a clip").play(slow, cut.on_layer(1)).expect("a clip");
        crowd
            .member_mut(left)
            .expect("a clip")
            .play(slow, cut.inertialize_in_secs(0.1))
            .expect("a clip");
        crowd
            .member_mut(entering)
            .expect("a machine")
            .play_machine(machine, MachinePlayback::new().after_secs(0.3))
            .expect("a machine");
        crowd
            .member_mut(leaving)
            .expect("a machine")
            .play_machine(machine, MachinePlayback::new())
            .expect("a machine");
        crowd
            .member_mut(leaving)
            .expect("a clip")
            .play(fast, faded.after_secs(0.1))
            .expect("a clip");
        stage.update(0.5);
        for (member, wanted) in [
            (late, 0.1),
            (cuts, 0.7),
            (fades, 0.55),
            (above, 0.7),
            (left, 0.7),
            (entering, 0.7),
            (leaving, 0.05 + 0.25 + 0.4),
        ] {
            let found = stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .moved_placement()
                .expect("a member")
                .position()[2];
            assert!((found - wanted).abs() < 1e-4, "{found} m is not {wanted} m");
        }
    });
}

#[test]
fn a_machine_that_cuts_moves_its_member_in_that_frame_too() {
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let machine = StateMachine::new()
            .parameter("tired", 0.0)
            .state("fast", fast, StatePlayback::looping())
            .state("slow", slow, StatePlayback::looping())
            .transition("fast", "slow", 0.0, &[Condition::above("tired", 0.5)])
            .transition("slow", "fast", 0.1, &[Condition::below("tired", 0.5)]);
        let machine = stage.crowd.add_machine(&machine).expect("a machine");
        let member = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(member)
            .expect("a machine")
            .play_machine(machine, MachinePlayback::new())
            .expect("a machine");
        stage.crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
        let mut goes = |tired: f32, wanted: [f32; 3]| {
            stage
                .crowd
                .member_mut(member)
                .expect("a parameter")
                .set_parameter("tired", tired)
                .expect("a parameter");
            for wanted in wanted {
                let found = step_of(stage, member, 0.04);
                assert!((found - 0.04 * wanted).abs() < 2e-5, "{found} m at {wanted} m/s");
            }
        };
        goes(0.0, [2.0; 3]);
        goes(1.0, [2.0, 0.5, 0.5]); // cut as of the end of the first
        goes(0.0, [0.5, 0.5 + 1.5 * 0.2, 0.5 + 1.5 * 0.6]);
        goes(0.0, [2.0 - 1.5 * 0.05, 2.0, 2.0]);
    });
}
