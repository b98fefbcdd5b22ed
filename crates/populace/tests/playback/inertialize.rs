//! Inertialised transitions: pose and speed go on, and decay to the new clip.

use glam::{Quat, Vec3};
use populace::{
    BlendSpace, BlendSpacePlayback, ClipPlayback, Crowd, CrowdBuilder, Device, Error, LayerMode,
    LayerSettings, Mask, MemberId, Placement, Split,
};

use crate::on_every_way;
use crate::rig::{JOINTS, Motion, character, crowd_of, moving, one_member, step_rad, turns};

/// Time over which speeds are measured, and in which what is left inertializes.
const BIT_SECS: f32 = 1.0 / 480.0;
const SECS: f32 = 0.25;
/// How fast the rotation of any joint may become another, and how far a pose may be off at the
/// start, in radians.
const PULL: f32 = 400.0;
const ROUNDING: f32 = 3e-6;

/// Turns of all joints about axes of their own, far apart and all on the move.
fn motions() -> Vec<Motion> {
    moving(64, |joint, nth, phase| 0.2 * (joint + nth) + 0.3 * f32::sin(phase + joint * nth))
}

/// How fast each joint turns from one pose to the next, in model space.
fn speeds(before: &[Quat], after: &[Quat]) -> Vec<Vec3> {
    let speed = |(a, b): (&Quat, &Quat)| {
        let turn = (*b * a.inverse()).normalize();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        2.0 * turn.xyz() / BIT_SECS
    };
    before.iter().zip(after).map(speed).collect()
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// What a start does to a member's pose and to the speeds of its joints.
fn across(crowd: &mut Crowd, member: MemberId, start: impl FnOnce(&mut Crowd)) -> (f32, f32) {
    let earlier = turns(crowd, member);
    crowd.update(BIT_SECS).unwrap();
    let before = turns(crowd, member);
    start(crowd);
    crowd.update(0.0).unwrap();
    let after = turns(crowd, member);
    crowd.update(BIT_SECS).unwrap();
    let later = turns(crowd, member);
    let changes = largest_difference(&speeds(&earlier, &before), &speeds(&after, &later));
    (step_rad(&before, &after), changes)
}

/// As [`across`], held to what an inertialised transition may do.
#[track_caller]
fn inertializes(crowd: &mut Crowd, member: MemberId, what: &str, start: impl FnOnce(&mut Crowd)) {
    let (jump, change) = across(crowd, member, start);
    assert!(jump < ROUNDING, "{what}: the pose jumps by {jump} rad");
    assert!(change < PULL * BIT_SECS, "{what}: speeds change by {change} rad/s");
}

fn pose_and_speed_go_on(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(8), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping().phase(0.4)).unwrap();
    crowd.update(0.1).unwrap();
    let kinds = [
        ("looping", clips[1], ClipPlayback::looping().phase(0.3)),
        ("interrupted at once", clips[2], ClipPlayback::looping().speed(-1.3).phase(0.0)),
        ("once", clips[3], ClipPlayback::once().speed(1.5)),
        ("backwards", clips[0], ClipPlayback::once().speed(-1.0)),
        ("held", clips[1], ClipPlayback::held_at_secs(0.6)),
        ("from a held one", clips[2], ClipPlayback::looping()),
    ];
    for (what, clip, play) in kinds {
        inertializes(&mut crowd, member, what, |crowd| {
            crowd.member_mut(member).unwrap().play(clip, play.inertialize_in_secs(SECS)).unwrap();
        });
        assert_eq!(
            crowd.member(member).unwrap().active_clips().len(),
            1,
            "what inertializes plays no longer"
        );
        assert_eq!(crowd.member(member).unwrap().active_clips()[0].weight, 1.0);
        crowd.update(0.04).unwrap();
    }
    // A cut, for comparison.
    crowd.update(0.1).unwrap();
    let cut = across(&mut crowd, member, |crowd| {
        crowd.member_mut(member).unwrap().play(clips[3], ClipPlayback::looping()).unwrap();
    });
    assert!(cut.0 > 0.2 && cut.1 > 2.0 * PULL * BIT_SECS, "a cut jumps: {cut:?}");
}

fn a_crossfade_is_left_in_its_middle(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(8), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.2).unwrap();
    crowd.member_mut(member).unwrap().crossfade(clips[2], 0.3).unwrap();
    crowd.update(0.12).unwrap();
    inertializes(&mut crowd, member, "a crossfade", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[1], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
    crowd.update(0.05).unwrap();
    // And a crossfade begins while that inertializes: it changes speeds, but not the pose.
    let (jump, _) = across(&mut crowd, member, |crowd| {
        crowd.member_mut(member).unwrap().crossfade(clips[3], 0.3).unwrap();
    });
    assert!(jump < ROUNDING, "{jump}");
    crowd.update(0.1).unwrap();
    inertializes(&mut crowd, member, "both at once", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[0], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
}

fn a_blend_space_is_left(builder: &CrowdBuilder) {
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
    inertializes(&mut crowd, member, "a blend space", |crowd| {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[2], ClipPlayback::looping().inertialize_in_secs(SECS))
            .unwrap();
    });
    assert!(
        crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1)).is_err(),
        "it plays no longer"
    );
}

/// Masked and weighted layers of both kinds over another that plays.
fn layers_inertialize(builder: &CrowdBuilder) {
    for mode in [LayerMode::Override, LayerMode::Additive] {
        let (mut crowd, id, clips) = crowd_of(&builder.clone().slots_per_member(8), &motions());
        let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
        let skeleton = crowd.character(id).unwrap().skeleton.clone();
        let mask =
            Mask::of_subtrees(&skeleton, ["joint 1"]).unwrap().with_falloff(&skeleton, 2).unwrap();
        let mask = crowd.add_mask(id, &mask).unwrap();
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
            inertializes(&mut crowd, member, &format!("{mode:?}"), |crowd| {
                let play = upper(ClipPlayback::looping().phase(phase)).inertialize_in_secs(SECS);
                crowd.member_mut(member).unwrap().play(clips[clip], play).unwrap();
            });
            crowd.update(0.05).unwrap();
        }
        // Another weight, an empty layer: neither jumps.
        let (jump, _) = across(&mut crowd, member, |crowd| {
            let play = ClipPlayback::looping().on_layer(1).weight(0.3).inertialize_in_secs(SECS);
            crowd.member_mut(member).unwrap().play(clips[0], play).unwrap();
        });
        assert!(jump < ROUNDING, "{mode:?}: {jump}");
        let (jump, _) = across(&mut crowd, member, |crowd| {
            crowd
                .member_mut(member)
                .unwrap()
                .play(clips[0], ClipPlayback::looping().on_layer(2).inertialize_in_secs(SECS))
                .unwrap();
        });
        assert!(jump < ROUNDING, "{mode:?}: {jump}");
    }
}

fn once_inertialized_it_is_the_new_clip_to_the_bit(builder: &CrowdBuilder) {
    let run = |inertializes: bool| {
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
            let play = if inertializes { play.inertialize_in_secs(SECS) } else { play };
            crowd.member_mut(member).unwrap().play(clip, play).unwrap();
        }
        let halves = [0.125, 0.125, 0.1].map(|secs| {
            crowd.update(secs).unwrap();
            crowd.member_mut(member).unwrap().palette().unwrap()
        });
        // The slots are free again.
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
    assert!(inertialized[1..] == plain[1..], "bit for bit");
}

/// What waits, and what is delayed, inertializes on its tick, whatever the frames.
fn queued_and_delayed_starts_settle_on_their_tick(builder: &CrowdBuilder) {
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
    assert!(run(7) == once && run(28) == once, "bit for bit");
}

/// Starts in one frame: only the last of them is seen, and what was left inertializes into that.
fn what_was_never_seen_leaves_nothing(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.3).unwrap();
    inertializes(&mut crowd, member, "three starts at once", |crowd| {
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

/// Frames through twenty starts of so many seconds each, and some after. Returns by how much the
/// way that a joint turns in a frame differs from that in the frame before, at most, and how far
/// from rest the last joint keeps, in radians.
fn run_through_starts(
    builder: &CrowdBuilder,
    slots: usize,
    (stride, secs): (usize, f32),
) -> (f32, f32) {
    let (mut crowd, clips, member) =
        one_member(&builder.clone().slots_per_member(slots), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.1).unwrap();
    let mut poses = vec![turns(&mut crowd, member)];
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
        poses.push(turns(&mut crowd, member));
    }
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!(
        (playing.len(), playing[0].clip),
        (1, clips[22 * stride % clips.len()]),
        "the last one stays"
    );
    let ways: Vec<_> = poses.windows(2).map(|pair| speeds(&pair[0], &pair[1])).collect();
    let changes = ways.windows(2).map(|pair| BIT_SECS * largest_difference(&pair[0], &pair[1]));
    let from_rest = poses.iter().map(|pose| step_rad(&pose[JOINTS - 1..], &[Quat::IDENTITY]));
    (changes.fold(0.0, f32::max), from_rest.fold(f32::MAX, f32::min))
}

fn twenty_starts_in_a_third_of_a_second_never_jump(builder: &CrowdBuilder) {
    let (cut, _) = run_through_starts(builder, 4, (1, 0.0));
    for slots in [2, 3, 4, 8] {
        for stride in [1, 3] {
            let (change, from_rest) = run_through_starts(builder, slots, (stride, SECS));
            assert!(change < 0.1 && cut > 1.0, "{slots} slots: {change} rad, {cut} by cuts");
            assert!(from_rest > 0.3, "{slots} slots: {from_rest} rad from rest");
        }
    }
}

fn a_start_waits_for_what_inertializes(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.1).unwrap();
    let old = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[1], ClipPlayback::looping().inertialize_in_secs(SECS))
        .unwrap();
    crowd.update(0.1).unwrap();
    let waits = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[2], ClipPlayback::looping().inertialize_in_secs(SECS))
        .unwrap();
    crowd.update(0.14).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips()[0].id, Some(old));
    crowd.update(0.02).unwrap();
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!((playing.len(), playing[0].id), (1, Some(waits)));
    assert_eq!(
        crowd.member_mut(old.member()).and_then(|mut m| m.set_weight(old, 1.0, 0.0)),
        Err(Error::StalePlayback),
        "what inertializes plays no longer"
    );
    // A cut waits for nothing, and leaves nothing.
    crowd.member_mut(member).unwrap().play(clips[3], ClipPlayback::held_at_secs(0.5)).unwrap();
    crowd.update(0.0).unwrap();
    let cut = crowd.member_mut(member).unwrap().palette().unwrap();
    crowd.update(1.0).unwrap();
    assert!(crowd.member_mut(member).unwrap().palette().unwrap() == cut, "bit for bit");
}

on_every_way!(
    pose_and_speed_go_on,
    a_crossfade_is_left_in_its_middle,
    a_blend_space_is_left,
    layers_inertialize,
    once_inertialized_it_is_the_new_clip_to_the_bit,
    queued_and_delayed_starts_settle_on_their_tick,
    what_was_never_seen_leaves_nothing,
    twenty_starts_in_a_third_of_a_second_never_jump,
    a_start_waits_for_what_inertializes,
);

/// All palettes of a crowd whose members inertialize, each from starts of its own.
fn frames(mut crowd: Crowd, mut each: impl FnMut(&mut Crowd, u8)) -> Vec<Vec<populace::Affine>> {
    let id = crowd.add_character(character(&motions())).unwrap();
    let clips: Vec<_> = crowd.clips(id).unwrap().into_iter().map(|(clip, _)| clip).collect();
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
        each(&mut crowd, frame);
        crowd.update(0.03).unwrap();
        all.extend(
            members.iter().map(|member| crowd.member_mut(*member).unwrap().palette().unwrap()),
        );
    }
    all
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn crowds_that_move_or_are_split_settle_alike() {
    let native = || Crowd::builder().device(Device::native());
    let stays = frames(native().build().unwrap(), |_, _| ());
    let moves = frames(native().build().unwrap(), |crowd, frame| {
        if frame % 5 == 4 {
            let device = if frame % 2 == 0 { Device::opencl(0) } else { Device::native() };
            crowd.move_to(device).unwrap();
        }
    });
    assert!(moves == stays, "bit for bit");
    let shared = Crowd::builder()
        .devices([Device::native(), Device::opencl(0)])
        .capacity(12)
        .build()
        .unwrap();
    let split = frames(shared, |crowd, frame| {
        let share = f64::from(frame % 7 + 1) / 9.0;
        crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).unwrap();
    });
    assert!(split == stays, "bit for bit");
}

#[test]
fn times_that_are_none_are_refused_and_all_others_are_only_long_or_short() {
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
    // The last of two counts.
    assert_eq!(
        ClipPlayback::once().inertialize_in_secs(0.3).fade_in_secs(0.2),
        ClipPlayback::once().fade_in_secs(0.2)
    );
}
