//! Inertialized transitions: pose and speed are continuous and decay to the new clip.

use glam::{Quat, Vec3};
use populace::{
    BlendSpace, BlendSpacePlayback, ClipPlayback, Crowd, CrowdBuilder, Device, Error, LayerMode,
    LayerSettings, Mask, MemberId, Placement, Split,
};

use crate::fixture::{
    JOINTS, Motion, character, crowd_of, moving, one_member, rotations, step_rad,
};
use crate::on_every_device;

/// Time over which speeds are measured.
const PROBE_SECS: f32 = 1.0 / 480.0;
/// Duration of inertialization.
const SECS: f32 = 0.25;
/// Largest angular acceleration of a joint, in rad/s².
const MAX_ACCELERATION: f32 = 400.0;
/// Largest jump of a pose at the start, in radians.
const ROUNDING: f32 = 3e-6;

/// Clips that move all joints, with poses far apart.
fn motions() -> Vec<Motion> {
    moving(64, |joint, nth, phase| 0.2 * (joint + nth) + 0.3 * f32::sin(phase + joint * nth))
}

/// Returns the angular velocity of each joint between two poses, in model space.
fn speeds(before: &[Quat], after: &[Quat]) -> Vec<Vec3> {
    let speed = |(a, b): (&Quat, &Quat)| {
        let turn = (*b * a.inverse()).normalize();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        2.0 * turn.xyz() / PROBE_SECS
    };
    before.iter().zip(after).map(speed).collect()
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// Returns the jump in a member's pose, in radians, and the change of its joints' speeds, in rad/s,
/// across a start.
fn change_across(
    crowd: &mut Crowd,
    member: MemberId,
    start: impl FnOnce(&mut Crowd),
) -> (f32, f32) {
    let earlier = rotations(crowd, member);
    crowd.update(PROBE_SECS).unwrap();
    let before = rotations(crowd, member);
    start(crowd);
    crowd.update(0.0).unwrap();
    let after = rotations(crowd, member);
    crowd.update(PROBE_SECS).unwrap();
    let later = rotations(crowd, member);
    let changes = largest_difference(&speeds(&earlier, &before), &speeds(&after, &later));
    (step_rad(&before, &after), changes)
}

/// Asserts that a start keeps pose and speeds continuous, by [`change_across`].
#[track_caller]
fn assert_inertializes(
    crowd: &mut Crowd,
    member: MemberId,
    case: &str,
    start: impl FnOnce(&mut Crowd),
) {
    let (jump, change) = change_across(crowd, member, start);
    assert!(jump < ROUNDING, "{case}: the pose jumps by {jump} rad");
    assert!(change < MAX_ACCELERATION * PROBE_SECS, "{case}: speeds change by {change} rad/s");
}

fn pose_and_speed_are_continuous(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(8), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping().phase(0.4)).unwrap();
    crowd.update(0.1).unwrap();
    let cases = [
        ("looping", clips[1], ClipPlayback::looping().phase(0.3)),
        ("interrupted", clips[2], ClipPlayback::looping().speed(-1.3).phase(0.0)),
        ("once", clips[3], ClipPlayback::once().speed(1.5)),
        ("backwards", clips[0], ClipPlayback::once().speed(-1.0)),
        ("held", clips[1], ClipPlayback::held_at_secs(0.6)),
        ("from a held clip", clips[2], ClipPlayback::looping()),
    ];
    for (case, clip, play) in cases {
        assert_inertializes(&mut crowd, member, case, |crowd| {
            crowd.member_mut(member).unwrap().play(clip, play.inertialize_in_secs(SECS)).unwrap();
        });
        assert_eq!(
            crowd.member(member).unwrap().active_clips().len(),
            1,
            "the old clip is still active"
        );
        assert_eq!(crowd.member(member).unwrap().active_clips()[0].weight, 1.0);
        crowd.update(0.04).unwrap();
    }
    // A cut for comparison.
    crowd.update(0.1).unwrap();
    let cut = change_across(&mut crowd, member, |crowd| {
        crowd.member_mut(member).unwrap().play(clips[3], ClipPlayback::looping()).unwrap();
    });
    assert!(
        cut.0 > 0.2 && cut.1 > 2.0 * MAX_ACCELERATION * PROBE_SECS,
        "a cut does not jump: {cut:?}"
    );
}

fn crossfade_can_be_inertialized_midway(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(8), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.2).unwrap();
    crowd.member_mut(member).unwrap().crossfade(clips[2], 0.3).unwrap();
    crowd.update(0.12).unwrap();
    assert_inertializes(&mut crowd, member, "a crossfade", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[1], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
    crowd.update(0.05).unwrap();
    // A crossfade that starts during inertialization changes speeds, but not the pose.
    let (jump, _) = change_across(&mut crowd, member, |crowd| {
        crowd.member_mut(member).unwrap().crossfade(clips[3], 0.3).unwrap();
    });
    assert!(jump < ROUNDING, "the pose jumps by {jump} rad");
    crowd.update(0.1).unwrap();
    assert_inertializes(&mut crowd, member, "a crossfade during inertialization", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[0], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
}

fn blend_space_can_be_inertialized(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(8), &motions());
    let line = BlendSpace::line(&[(clips[0], 0.0), (clips[1], 1.0)]).unwrap();
    let space = crowd.add_blend_space(line).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, 0.4, BlendSpacePlayback::new())
        .unwrap();
    crowd.update(0.2).unwrap();
    crowd.member_mut(member).unwrap().set_blend_parameter(0.8, 0.5).unwrap();
    crowd.update(0.1).unwrap();
    assert_inertializes(&mut crowd, member, "a blend space", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[2], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
    assert!(
        crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1)).is_err(),
        "the space still plays"
    );
}

/// Masked and weighted layers, override and additive, over another layer.
fn layers_can_be_inertialized(builder: &CrowdBuilder) {
    for mode in [LayerMode::Override, LayerMode::Additive] {
        let (mut crowd, id, clips) = crowd_of(&builder.clone().slots_per_member(8), &motions());
        let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
        let skeleton = crowd.character(id).unwrap().asset().skeleton.clone();
        let mask =
            Mask::of_subtrees(&skeleton, ["joint 1"]).unwrap().with_falloff(&skeleton, 2).unwrap();
        let mask = crowd.character_mut(id).unwrap().add_mask(&mask).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .set_layer(1, LayerSettings { mode, weight: 0.8 }, Some(mask))
            .unwrap();
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
        let upper = |play: ClipPlayback| play.on_layer(1).weight(0.9);
        crowd.member_mut(member).unwrap().play(clips[1], upper(ClipPlayback::looping())).unwrap();
        crowd.update(0.3).unwrap();
        for (clip, phase) in [(2, 0.1), (3, 0.6), (1, 0.3)] {
            assert_inertializes(&mut crowd, member, &format!("{mode:?}"), |crowd| {
                let play = upper(ClipPlayback::looping().phase(phase)).inertialize_in_secs(SECS);
                crowd.member_mut(member).unwrap().play(clips[clip], play).unwrap();
            });
            crowd.update(0.05).unwrap();
        }
        // Neither a change of weight nor a start on an empty layer jumps.
        let (jump, _) = change_across(&mut crowd, member, |crowd| {
            let play = ClipPlayback::looping().on_layer(1).weight(0.3).inertialize_in_secs(SECS);
            crowd.member_mut(member).unwrap().play(clips[0], play).unwrap();
        });
        assert!(jump < ROUNDING, "{mode:?}: the pose jumps by {jump} rad");
        let (jump, _) = change_across(&mut crowd, member, |crowd| {
            crowd
                .member_mut(member)
                .unwrap()
                .play(clips[0], ClipPlayback::looping().on_layer(2).inertialize_in_secs(SECS))
                .unwrap();
        });
        assert!(jump < ROUNDING, "{mode:?}: the pose jumps by {jump} rad");
    }
}

fn pose_equals_the_new_clip_after_inertialization(builder: &CrowdBuilder) {
    let run = |is_inertialized: bool| {
        let (mut crowd, clips, member) = one_member(builder, &motions());
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[1], ClipPlayback::looping().on_layer(1))
            .unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .set_layer(1, LayerSettings { mode: LayerMode::Additive, weight: 0.5 }, None)
            .unwrap();
        crowd.update(0.5).unwrap();
        for (layer, clip) in [(0, clips[2]), (1, clips[3])] {
            let play = ClipPlayback::once().on_layer(layer);
            let play = if is_inertialized { play.inertialize_in_secs(SECS) } else { play };
            crowd.member_mut(member).unwrap().play(clip, play).unwrap();
        }
        let halves = [0.125, 0.125, 0.1].map(|secs| {
            crowd.update(secs).unwrap();
            crowd.member_mut(member).unwrap().palette().unwrap()
        });
        // The slots of the old clips are free again.
        for layer in [2, 3] {
            crowd
                .member_mut(member)
                .unwrap()
                .play(clips[0], ClipPlayback::looping().on_layer(layer))
                .unwrap();
        }
        (halves, crowd.member(member).unwrap().active_clips().len())
    };
    let ((inertialized, playing), (plain, _)) = (run(true), run(false));
    assert!(inertialized[0] != plain[0] && playing == 4);
    assert!(inertialized[1..] == plain[1..], "palettes differ");
}

/// Queued and delayed starts inertialize from their tick on, whatever the frame length.
fn queued_and_delayed_starts_inertialize_on_their_tick(builder: &CrowdBuilder) {
    let run = |steps: u16| {
        let (mut crowd, clips, member) = one_member(builder, &motions());
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once()).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .queue(clips[1], ClipPlayback::once().inertialize_in_secs(SECS))
            .unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .queue(clips[2], ClipPlayback::looping().inertialize_in_secs(0.4).phase(0.3))
            .unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .play(
                clips[3],
                ClipPlayback::looping().on_layer(1).after_secs(0.5).inertialize_in_secs(0.2),
            )
            .unwrap();
        (0..steps).for_each(|_| crowd.update(2.625 / f32::from(steps)).unwrap());
        (
            crowd.member_mut(member).unwrap().palette().unwrap(),
            crowd.member(member).unwrap().active_clips().len(),
        )
    };
    let once = run(1);
    assert_eq!(once.1, 2);
    assert!(run(7) == once && run(28) == once, "palettes differ");
}

/// Of several starts in one frame, only the last is shown. The old clip inertializes into it.
fn only_the_last_start_of_a_frame_is_inertialized_into(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.3).unwrap();
    assert_inertializes(&mut crowd, member, "three starts at once", |crowd| {
        for (clip, secs) in [(clips[3], 0.1), (clips[2], 0.7), (clips[1], SECS)] {
            crowd
                .member_mut(member)
                .unwrap()
                .play(clip, ClipPlayback::looping().inertialize_in_secs(secs))
                .unwrap();
        }
    });
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!((playing.len(), playing[0].clip), (1, clips[1]));
}

/// Runs 60 frames with twenty starts, each inertialized in `secs`. Returns the largest change of a
/// joint's rotation per frame from one frame to the next, and the smallest angle of the last joint
/// from its rest pose, in radians.
fn run_through_starts(
    builder: &CrowdBuilder,
    slots: usize,
    (stride, secs): (usize, f32),
) -> (f32, f32) {
    let (mut crowd, clips, member) =
        one_member(&builder.clone().slots_per_member(slots), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.1).unwrap();
    let mut poses = vec![rotations(&mut crowd, member)];
    for frame in 1..=60_usize {
        if (3..23).contains(&frame) {
            let clip = clips[frame * stride % clips.len()];
            crowd
                .member_mut(member)
                .unwrap()
                .play(clip, ClipPlayback::looping().phase(0.5).inertialize_in_secs(secs))
                .unwrap();
        }
        crowd.update(0.015).unwrap();
        poses.push(rotations(&mut crowd, member));
    }
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!(
        (playing.len(), playing[0].clip),
        (1, clips[22 * stride % clips.len()]),
        "a clip other than the last one plays"
    );
    let velocities: Vec<_> = poses.windows(2).map(|pair| speeds(&pair[0], &pair[1])).collect();
    let changes =
        velocities.windows(2).map(|pair| PROBE_SECS * largest_difference(&pair[0], &pair[1]));
    let from_rest = poses.iter().map(|pose| step_rad(&pose[JOINTS - 1..], &[Quat::IDENTITY]));
    (changes.fold(0.0, f32::max), from_rest.fold(f32::MAX, f32::min))
}

fn twenty_inertialized_starts_within_300_ms_never_jump(builder: &CrowdBuilder) {
    let (cut, _) = run_through_starts(builder, 4, (1, 0.0));
    for slots in [2, 3, 4, 8] {
        for stride in [1, 3] {
            let (change, from_rest) = run_through_starts(builder, slots, (stride, SECS));
            assert!(change < 0.1 && cut > 1.0, "{slots} slots: {change} rad, {cut} rad with cuts");
            assert!(from_rest > 0.3, "{slots} slots: {from_rest} rad from rest");
        }
    }
}

fn start_waits_for_an_inertializing_slot(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.1).unwrap();
    let old = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[1], ClipPlayback::looping().inertialize_in_secs(SECS))
        .unwrap();
    crowd.update(0.1).unwrap();
    let scheduled = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[2], ClipPlayback::looping().inertialize_in_secs(SECS))
        .unwrap();
    crowd.update(0.14).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips()[0].id, Some(old));
    crowd.update(0.02).unwrap();
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!((playing.len(), playing[0].id), (1, Some(scheduled)));
    assert_eq!(
        crowd.member_mut(old.member()).and_then(|mut m| m.set_weight(old, 1.0, 0.0)),
        Err(Error::StalePlayback),
        "the old clip is still active"
    );
    // A cut starts at once and does not inertialize.
    crowd.member_mut(member).unwrap().play(clips[3], ClipPlayback::held_at_secs(0.5)).unwrap();
    crowd.update(0.0).unwrap();
    let cut = crowd.member_mut(member).unwrap().palette().unwrap();
    crowd.update(1.0).unwrap();
    assert!(crowd.member_mut(member).unwrap().palette().unwrap() == cut, "palettes differ");
}

on_every_device!(
    pose_and_speed_are_continuous,
    crossfade_can_be_inertialized_midway,
    blend_space_can_be_inertialized,
    layers_can_be_inertialized,
    pose_equals_the_new_clip_after_inertialization,
    queued_and_delayed_starts_inertialize_on_their_tick,
    only_the_last_start_of_a_frame_is_inertialized_into,
    twenty_inertialized_starts_within_300_ms_never_jump,
    start_waits_for_an_inertializing_slot,
);

/// Returns all palettes of 24 frames of a crowd whose members inertialize. Calls `before_update` in
/// each frame.
fn frames(
    mut crowd: Crowd,
    mut before_update: impl FnMut(&mut Crowd, u8),
) -> Vec<Vec<populace::Affine>> {
    let id = crowd.add_character(character(&motions())).unwrap();
    let clips: Vec<_> =
        crowd.character(id).unwrap().clips().into_iter().map(|(clip, _)| clip).collect();
    let members: Vec<_> =
        (0..12).map(|_| crowd.spawn(id, Placement::at([0.0; 3])).unwrap()).collect();
    let mut all = Vec::new();
    for frame in 0..24_u8 {
        for (nth, &member) in
            members.iter().enumerate().filter(|(nth, _)| nth % 3 == usize::from(frame % 3))
        {
            let play =
                ClipPlayback::looping().phase(0.1 * f32::from(frame)).inertialize_in_secs(0.2);
            crowd
                .member_mut(member)
                .unwrap()
                .play(clips[(nth + usize::from(frame)) % clips.len()], play)
                .unwrap();
        }
        before_update(&mut crowd, frame);
        crowd.update(0.03).unwrap();
        all.extend(
            members.iter().map(|member| crowd.member_mut(*member).unwrap().palette().unwrap()),
        );
    }
    all
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn moved_and_split_crowds_inertialize_equally() {
    let native = || Crowd::builder().device(Device::native());
    let stays = frames(native().build().unwrap(), |_, _| ());
    let moves = frames(native().build().unwrap(), |crowd, frame| {
        if frame % 5 == 4 {
            let device = if frame % 2 == 0 { Device::opencl(0) } else { Device::native() };
            crowd.move_to(device).unwrap();
        }
    });
    assert!(moves == stays, "palettes differ");
    let shared = Crowd::builder()
        .devices([Device::native(), Device::opencl(0)])
        .capacity(12)
        .build()
        .unwrap();
    let split = frames(shared, |crowd, frame| {
        let share = f64::from(frame % 7 + 1) / 9.0;
        crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).unwrap();
    });
    assert!(split == stays, "palettes differ");
}

#[test]
fn only_bad_inertialization_times_are_refused() {
    let native = Crowd::builder().device(Device::native());
    let (mut crowd, clips, member) = one_member(&native, &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    for bad in [f32::NAN, f32::INFINITY, f32::MAX, -1.0] {
        let refused = crowd
            .member_mut(member)
            .and_then(|mut m| m.play(clips[1], ClipPlayback::looping().inertialize_in_secs(bad)))
            .unwrap_err();
        assert!(refused.to_string().contains("inertialize"), "{refused}");
        assert!(
            crowd
                .member_mut(member)
                .and_then(|mut m| m.queue(clips[1], ClipPlayback::once().inertialize_in_secs(bad)))
                .is_err()
        );
    }
    for secs in [0.0, 1e-30, 1e-6, 1e9] {
        crowd.update(0.1).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[1], ClipPlayback::looping().inertialize_in_secs(secs))
            .unwrap();
        crowd.update(0.1).unwrap();
        let palette = crowd.member_mut(member).unwrap().palette().unwrap();
        assert!(palette.iter().flat_map(|m| m.rows).flatten().all(f32::is_finite), "{secs}");
    }
    // The later of two settings replaces the earlier.
    assert_eq!(
        ClipPlayback::once().inertialize_in_secs(0.3).fade_in_secs(0.2),
        ClipPlayback::once().fade_in_secs(0.2)
    );
}
