//! More clips than slots: what gives way, and that nothing jumps.

use glam::Quat;
use populace::{ClipId, ClipPlayback, Crowd, CrowdBuilder, MemberId};

use crate::on_every_way;
use crate::rig::{Motion, one_member, step_rad, turns};

/// A frame, and between two starts: 20 of them in 0.3 s.
const STEP_SECS: f32 = 0.015;
const FADE_SECS: f32 = 0.2;

/// Poses far from each other and all far from the rest pose; some move.
fn motions() -> Vec<Motion> {
    let poses: [(&str, [f32; 3], f32, f32); 6] = [
        ("a", [1.0, 0.0, 0.0], 0.8, 0.0),
        ("b", [1.0, 0.3, 0.0], 1.3, 0.4),
        ("c", [1.0, -0.5, 0.2], 1.0, -0.3),
        ("d", [1.0, 0.0, 0.6], 1.4, 0.0),
        ("e", [1.0, 0.6, -0.4], 0.9, 0.5),
        ("f", [1.0, -0.2, -0.6], 1.2, 0.2),
    ];
    let motion = |(name, axis, angle, swing): (&'static str, [f32; 3], f32, f32)| Motion {
        name,
        duration_secs: 1.0,
        turns: [1.0, 0.3, 0.2, 0.3].map(|part| {
            let angles = [0.0, 1.0, 0.0, -1.0, 0.0].map(|s| part * (angle + swing * s));
            (axis, angles.to_vec())
        }),
    };
    poses.into_iter().map(motion).collect()
}

/// The largest step from one frame to the next, and the least that the root is turned away from the
/// rest pose.
struct Steps {
    before: Vec<Quat>,
    largest: f32,
    least_from_rest: f32,
}

impl Steps {
    fn new(crowd: &mut Crowd, member: MemberId) -> Self {
        Self { before: turns(crowd, member), largest: 0.0, least_from_rest: f32::MAX }
    }

    fn frame(&mut self, crowd: &mut Crowd, member: MemberId) -> f32 {
        crowd.update(STEP_SECS).unwrap();
        let now = turns(crowd, member);
        let step = step_rad(&self.before, &now);
        self.largest = self.largest.max(step);
        self.least_from_rest = self.least_from_rest.min(step_rad(&now[..1], &[Quat::IDENTITY]));
        self.before = now;
        step
    }
}

/// The largest step of a frame in plain crossfades from any clip to any other.
fn largest_step_of_a_crossfade(builder: &CrowdBuilder) -> f32 {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let mut largest = 0.0_f32;
    for &from in &clips {
        for &to in clips.iter().filter(|to| **to != from) {
            crowd.member_mut(member).unwrap().play(from, ClipPlayback::looping()).unwrap();
            crowd.update(STEP_SECS).unwrap();
            let mut steps = Steps::new(&mut crowd, member);
            crowd
                .member_mut(member)
                .unwrap()
                .play(to, ClipPlayback::looping().fade_in_secs(FADE_SECS))
                .unwrap();
            (0..14).for_each(|_| largest = largest.max(steps.frame(&mut crowd, member)));
        }
    }
    largest
}

/// What no frame may exceed: a plain crossfade's largest step, and a tenth more since several poses
/// are mixed, whose sum is shorter than that of two.
fn allowed(builder: &CrowdBuilder) -> f32 {
    let plain = largest_step_of_a_crossfade(builder);
    assert!(plain < 0.4, "{plain} rad a frame say nothing about jumps");
    1.1 * plain
}

fn twenty_clips_in_a_third_of_a_second_never_jump(builder: &CrowdBuilder) {
    let allowed = allowed(builder);
    for slots in [2, 3, 4, 8] {
        for stride in [1, 2, 5] {
            let (mut crowd, clips, member) =
                one_member(&builder.clone().slots_per_member(slots), &motions());
            crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
            crowd.update(0.1).unwrap();
            let mut steps = Steps::new(&mut crowd, member);
            let mut last = clips[0];
            for start in 1..=20 {
                last = clips[start * stride % clips.len()];
                crowd
                    .member_mut(member)
                    .unwrap()
                    .play(last, ClipPlayback::looping().fade_in_secs(FADE_SECS))
                    .unwrap();
                let step = steps.frame(&mut crowd, member);
                assert!(
                    step <= allowed,
                    "{slots} slots, start {start}: {step} rad in a frame, {allowed} allowed"
                );
            }
            for frame in 0..20 {
                let step = steps.frame(&mut crowd, member);
                assert!(
                    step <= allowed,
                    "{slots} slots, frame {frame} after: {step} rad, {allowed} allowed"
                );
            }
            assert!(
                steps.least_from_rest > 0.7,
                "{} rad from the rest pose",
                steps.least_from_rest
            );
            let playing = crowd.member(member).unwrap().active_clips();
            assert_eq!(
                (playing.len(), playing[0].clip, playing[0].weight),
                (1, last, 1.0),
                "the last one stays"
            );
        }
    }
}

/// Every kind of start, in all layers, at random; none of fades that take no time.
fn starts_of_all_kinds_never_jump(builder: &CrowdBuilder) {
    let allowed = 2.0 * allowed(builder); // Layer 1 and layer 0 may each be in a crossfade.
    for seed in 0..6_u64 {
        let (mut crowd, clips, member) =
            one_member(&builder.clone().slots_per_member(4), &motions());
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        let mut steps = Steps::new(&mut crowd, member);
        let mut state = seed;
        let mut random = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        for frame in 0..80 {
            let clip = clips[random(6) as usize];
            let play = ClipPlayback::looping().fade_in_secs(FADE_SECS);
            match random(6) {
                0 => drop(crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
                1 => drop(
                    crowd.member_mut(member).unwrap().play(clip, play.after_secs(0.02)).unwrap(),
                ),
                2 => drop(crowd.member_mut(member).unwrap().blend(clip, play.weight(0.5)).unwrap()),
                3 => drop(
                    crowd
                        .member_mut(member)
                        .unwrap()
                        .queue(clip, ClipPlayback::once().fade_in_secs(FADE_SECS))
                        .unwrap(),
                ),
                4 => drop(crowd.member_mut(member).unwrap().play(clip, play.on_layer(1)).unwrap()),
                _ => crowd.member_mut(member).unwrap().stop(1, FADE_SECS).unwrap(),
            }
            let step = steps.frame(&mut crowd, member);
            assert!(
                step <= allowed,
                "seed {seed}, frame {frame}: {step} rad in a frame, {allowed} allowed"
            );
        }
        assert!(steps.least_from_rest > 0.6, "{} rad from the rest pose", steps.least_from_rest);
    }
}

/// The weight of a clip among those that play, 0 where it does not.
fn weight(crowd: &Crowd, member: MemberId, clip: ClipId) -> f32 {
    crowd
        .member(member)
        .unwrap()
        .active_clips()
        .iter()
        .filter(|p| p.clip == clip)
        .map(|p| p.weight)
        .sum()
}

fn a_clip_waits_for_the_weakest_to_fade_and_no_longer(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.0).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play(clips[1], ClipPlayback::looping().fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.25).unwrap();
    // 1 weighs a quarter and gives way in a quarter of the fade.
    let waits = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[2], ClipPlayback::looping().fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.2).unwrap();
    assert!((weight(&crowd, member, clips[1]) - 0.05).abs() < 1e-3);
    assert!((weight(&crowd, member, clips[0]) - 0.95).abs() < 1e-3, "what 1 leaves goes to 0");
    assert_eq!(weight(&crowd, member, clips[2]), 0.0);
    crowd.member_mut(waits.member()).unwrap().set_speed(waits, 0.5).unwrap(); // It can be changed before it has a slot.
    crowd.update(0.55).unwrap();
    assert!((weight(&crowd, member, clips[2]) - 0.5).abs() < 1e-3);
    let playing = crowd.member(member).unwrap().active_clips();
    let waited = playing.iter().find(|p| p.id == Some(waits)).unwrap();
    assert!((waited.time_secs - 0.25).abs() < 1e-3 && (waited.speed - 0.5).abs() < 1e-4);
}

fn one_slot_changes_over_at_once(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(1), &motions());
    for clip in clips {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clip, ClipPlayback::looping().fade_in_secs(0.5))
            .unwrap();
        crowd.update(0.1).unwrap();
        assert_eq!(weight(&crowd, member, clip), 1.0);
    }
}

on_every_way!(
    twenty_clips_in_a_third_of_a_second_never_jump,
    starts_of_all_kinds_never_jump,
    a_clip_waits_for_the_weakest_to_fade_and_no_longer,
    one_slot_changes_over_at_once,
);
