//! Frames in which something starts, ends or is cut.

use super::*;

#[test]
fn long_steps_runs_that_end_and_runs_backwards_arrive_where_short_ones_do() {
    everywhere(|stage| {
        let (_, taken) = add(stage, curve());
        let plays = [
            Play::looping().phase(0.5),
            Play::looping().speed(-1.3),
            Play::once(),
            Play::once().speed(-0.6),
        ];
        let cycles = [7.2, -7.2 * 1.3, 1.0, -1.0];
        let members = plays.map(|play| {
            let member = stage.member(Placement::at([0.0; 3]));
            stage.crowd.play(member, taken, play).expect("a clip");
            stage.crowd.move_by_clips(member, true).expect("a member");
            member
        });
        stage.update(7.2 * SECS);
        for ((member, cycles), start) in
            members.into_iter().zip(cycles).zip([0.5_f32, 1.0, 0.0, 1.0])
        {
            let wanted = carried(-start).mul(&carried(start + cycles));
            let found = stage.crowd.moved(member).expect("a member").world_from_model();
            assert!(
                apart(&[wanted], &[found]) < 3e-3,
                "{cycles} cycles: {found:?} is not {wanted:?}"
            );
        }
        // What has ended, and what stands, stays.
        let before = stage.crowd.moved(members[2]);
        stage.update(1.0);
        assert_eq!(stage.crowd.moved(members[2]), before);
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
        stage.crowd.play(member, fast, Play::looping()).expect("a clip");
        stage.crowd.move_by_clips(member, true).expect("a member");
        close(step_of(stage, member, 0.01), 0.02);
        stage.crowd.crossfade(member, slow, 1.0).expect("a clip");
        stage.update(0.49);
        // Between 0.49 and 0.5 of the fade.
        close(step_of(stage, member, 0.01), 0.02 - 0.015 * 0.495);
        stage.update(0.51);
        close(step_of(stage, member, 0.01), 0.005);
        // Layers: through a mask without the root, for the whole body by half, and adding.
        let legs = Mask::of_subtrees(&character().skeleton, ["leftUpperLeg"]).expect("a joint");
        let legs = stage.crowd.add_mask(stage.body, &legs).expect("room");
        let settings = LayerSettings::default();
        stage.crowd.set_layer(member, 1, settings, Some(legs)).expect("a layer");
        stage.crowd.play(member, still, Play::looping().on_layer(1)).expect("a clip");
        close(step_of(stage, member, 0.01), 0.005);
        stage
            .crowd
            .set_layer(member, 1, LayerSettings { weight: 0.5, ..settings }, None)
            .expect("a layer");
        close(step_of(stage, member, 0.01), 0.0025);
        stage
            .crowd
            .set_layer(member, 1, LayerSettings { mode: LayerMode::Additive, ..settings }, None)
            .expect("a layer");
        stage.crowd.play(member, fast, Play::looping().on_layer(1)).expect("a clip");
        close(step_of(stage, member, 0.01), 0.005);
    });
}

#[test]
fn a_start_within_a_long_step_leaves_what_was_played_before_it() {
    let cut = Play::looping().after_secs(0.3);
    let faded = Play::looping().fade_in_secs(0.2);
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let machine = StateMachine::new().state("slow", slow, Play::looping());
        let machine = stage.crowd.add_machine(&machine).expect("a machine");
        let [late, cuts, fades, above, left, entering, leaving] = [(); 7].map(|()| {
            let member = stage.member(Placement::at([0.0; 3]));
            stage.crowd.move_by_clips(member, true).expect("a member");
            member
        });
        let crowd = &mut stage.crowd;
        crowd.play(late, slow, cut).expect("a clip");
        for member in [cuts, fades, above, left, entering] {
            crowd.play(member, fast, Play::looping()).expect("a clip");
        }
        crowd.play(cuts, slow, cut).expect("a clip");
        crowd.play(fades, slow, faded.after_secs(0.1)).expect("a clip");
        crowd.set_layer(above, 1, LayerSettings::default(), None).expect("a layer");
        crowd.play(above, slow, cut.on_layer(1)).expect("a clip");
        crowd.play(left, slow, cut.inertialize_in_secs(0.1)).expect("a clip");
        crowd.run_machine(entering, machine, cut).expect("a machine");
        crowd.run_machine(leaving, machine, Play::looping()).expect("a machine");
        crowd.play(leaving, fast, faded.after_secs(0.1)).expect("a clip");
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
            let found = stage.crowd.moved(member).expect("a member").position()[2];
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
            .state("fast", fast, Play::looping())
            .state("slow", slow, Play::looping())
            .transition("fast", "slow", 0.0, &[Condition::above("tired", 0.5)])
            .transition("slow", "fast", 0.1, &[Condition::below("tired", 0.5)]);
        let machine = stage.crowd.add_machine(&machine).expect("a machine");
        let member = stage.member(Placement::at([0.0; 3]));
        stage.crowd.run_machine(member, machine, Play::looping()).expect("a machine");
        stage.crowd.move_by_clips(member, true).expect("a member");
        let mut goes = |tired: f32, wanted: [f32; 3]| {
            stage.crowd.set_parameter(member, "tired", tired).expect("a parameter");
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
