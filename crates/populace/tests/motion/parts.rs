//! Frames in which clips start, end or are cut.

use populace::MachinePlayback;

use super::*;

#[test]
fn long_frames_ends_and_reverse_playback_move_correctly() {
    everywhere(|scene| {
        let (_, clip) = add(scene, curve());
        let plays = [
            ClipPlayback::looping().phase(0.5),
            ClipPlayback::looping().speed(-1.3),
            ClipPlayback::once(),
            ClipPlayback::once().speed(-0.6),
        ];
        let cycles = [7.2, -7.2 * 1.3, 1.0, -1.0];
        let members = plays.map(|play| {
            let member = scene.member(Placement::at([0.0; 3]));
            scene.edit(member).play(clip, play).expect("a clip");
            scene.edit(member).start_root_motion().expect("a member");
            member
        });
        scene.update(7.2 * SECS);
        for ((member, cycles), start) in
            members.into_iter().zip(cycles).zip([0.5_f32, 1.0, 0.0, 1.0])
        {
            let wanted = motion_after(-start).mul(&motion_after(start + cycles));
            let found = scene.edit(member).moved_placement().expect("a member").world_from_model();
            assert!(
                largest_distance(&[wanted], &[found]) < 3e-3,
                "{cycles} cycles: {found:?} instead of {wanted:?}"
            );
        }
        // A clip that has ended moves its member no further.
        let before = scene.crowd.member_mut(members[2]).and_then(|mut m| m.moved_placement());
        scene.update(1.0);
        assert_eq!(
            scene.crowd.member_mut(members[2]).and_then(|mut m| m.moved_placement()),
            before
        );
    });
}

#[test]
fn root_motion_is_blended_like_poses() {
    everywhere(|scene| {
        let (_, fast) = add(scene, straight("fast", 2.0));
        let (_, slow) = add(scene, straight("slow", 0.5));
        let still = scene.clip("sway");
        let member = scene.member(Placement::at([0.0; 3]));
        let close = |found: f32, wanted: f32| {
            assert!((found - wanted).abs() < 2e-5, "moved {found} m instead of {wanted} m")
        };
        scene.edit(member).play(fast, ClipPlayback::looping()).expect("a clip");
        scene.edit(member).start_root_motion().expect("a member");
        close(step_of(scene, member, 0.01), 0.02);
        scene.edit(member).crossfade(slow, 1.0).expect("a clip");
        scene.update(0.49);
        // From 0.49 to 0.5 of the fade.
        close(step_of(scene, member, 0.01), 0.02 - 0.015 * 0.495);
        scene.update(0.51);
        close(step_of(scene, member, 0.01), 0.005);
        // Layers: with a mask without the root, with weight 0.5 for all joints, and additive.
        let legs = Mask::of_subtrees(&character().skeleton, ["leftUpperLeg"]).expect("a joint");
        let legs = scene
            .crowd
            .character_mut(scene.body)
            .expect("enough capacity")
            .add_mask(&legs)
            .expect("enough capacity");
        let settings = LayerSettings::default();
        scene.edit(member).set_layer(1, settings, Some(legs)).expect("a layer");
        scene.edit(member).play(still, ClipPlayback::looping().on_layer(1)).expect("a clip");
        close(step_of(scene, member, 0.01), 0.005);
        scene
            .edit(member)
            .set_layer(1, LayerSettings { weight: 0.5, ..settings }, None)
            .expect("a layer");
        close(step_of(scene, member, 0.01), 0.0025);
        scene
            .edit(member)
            .set_layer(1, LayerSettings { mode: LayerMode::Additive, ..settings }, None)
            .expect("a layer");
        scene.edit(member).play(fast, ClipPlayback::looping().on_layer(1)).expect("a clip");
        close(step_of(scene, member, 0.01), 0.005);
    });
}

#[test]
fn start_within_a_long_frame_keeps_the_motion_before_it() {
    let cut = ClipPlayback::looping().after_secs(0.3);
    let faded = ClipPlayback::looping().fade_in_secs(0.2);
    everywhere(|scene| {
        let (_, fast) = add(scene, straight("fast", 2.0));
        let (_, slow) = add(scene, straight("slow", 0.5));
        let machine = StateMachine::new().state("slow", slow, StatePlayback::looping());
        let machine = scene.crowd.add_machine(&machine).expect("a machine");
        let [late, cuts, fades, above, left, entering, leaving] = [(); 7].map(|()| {
            let member = scene.member(Placement::at([0.0; 3]));
            scene.edit(member).start_root_motion().expect("a member");
            member
        });
        scene.edit(late).play(slow, cut).expect("a clip");
        for member in [cuts, fades, above, left, entering] {
            scene.edit(member).play(fast, ClipPlayback::looping()).expect("a clip");
        }
        scene.edit(cuts).play(slow, cut).expect("a clip");
        scene.edit(fades).play(slow, faded.after_secs(0.1)).expect("a clip");
        scene.edit(above).set_layer(1, LayerSettings::default(), None).expect("a layer");
        scene.edit(above).play(slow, cut.on_layer(1)).expect("a clip");
        scene.edit(left).play(slow, cut.inertialize_in_secs(0.1)).expect("a clip");
        scene
            .edit(entering)
            .play_machine(machine, MachinePlayback::new().after_secs(0.3))
            .expect("a machine");
        scene.edit(leaving).play_machine(machine, MachinePlayback::new()).expect("a machine");
        scene.edit(leaving).play(fast, faded.after_secs(0.1)).expect("a clip");
        scene.update(0.5);
        for (member, wanted) in [
            (late, 0.1),
            (cuts, 0.7),
            (fades, 0.55),
            (above, 0.7),
            (left, 0.7),
            (entering, 0.7),
            (leaving, 0.05 + 0.25 + 0.4),
        ] {
            let found = scene.edit(member).moved_placement().expect("a member").position()[2];
            assert!((found - wanted).abs() < 1e-4, "moved {found} m instead of {wanted} m");
        }
    });
}

#[test]
fn cut_in_a_machine_moves_its_member_in_the_same_frame() {
    everywhere(|scene| {
        let (_, fast) = add(scene, straight("fast", 2.0));
        let (_, slow) = add(scene, straight("slow", 0.5));
        let machine = StateMachine::new()
            .parameter("tired", 0.0)
            .state("fast", fast, StatePlayback::looping())
            .state("slow", slow, StatePlayback::looping())
            .transition("fast", "slow", 0.0, &[Condition::above("tired", 0.5)])
            .transition("slow", "fast", 0.1, &[Condition::below("tired", 0.5)]);
        let machine = scene.crowd.add_machine(&machine).expect("a machine");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play_machine(machine, MachinePlayback::new()).expect("a machine");
        scene.edit(member).start_root_motion().expect("a member");
        let mut assert_moves = |tired: f32, wanted: [f32; 3]| {
            scene.edit(member).set_parameter("tired", tired).expect("a parameter");
            for wanted in wanted {
                let found = step_of(scene, member, 0.04);
                assert!((found - 0.04 * wanted).abs() < 2e-5, "{found} m at {wanted} m/s");
            }
        };
        assert_moves(0.0, [2.0; 3]);
        assert_moves(1.0, [2.0, 0.5, 0.5]); // cut at the end of the first frame
        assert_moves(0.0, [0.5, 0.5 + 1.5 * 0.2, 0.5 + 1.5 * 0.6]);
        assert_moves(0.0, [2.0 - 1.5 * 0.05, 2.0, 2.0]);
    });
}
