//! Slot allocation: more clips than slots, without jumps.

use glam::Quat;
use populace::{ClipId, ClipPlayback, Crowd, CrowdBuilder, MemberId};
use populace_testkit::Rng;

use crate::fixture::{Motion, one_member, rotations, step_rad};
use crate::on_every_device;

/// Length of a frame and time between two starts: 20 starts take 0.3 s.
const STEP_SECS: f32 = 0.015;
const FADE_SECS: f32 = 0.2;

/// Clips with poses far from each other and from the rest pose. Some of them move.
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
        rotations: [1.0, 0.3, 0.2, 0.3].map(|part| {
            let angles = [0.0, 1.0, 0.0, -1.0, 0.0].map(|s| part * (angle + swing * s));
            (axis, angles.to_vec())
        }),
    };
    poses.into_iter().map(motion).collect()
}

/// Records the largest rotation of a joint per frame, and the smallest angle of the root from the
/// rest pose, in radians.
struct Steps {
    before: Vec<Quat>,
    largest: f32,
    least_from_rest: f32,
}

impl Steps {
    fn new(crowd: &mut Crowd, member: MemberId) -> Self {
        Self { before: rotations(crowd, member), largest: 0.0, least_from_rest: f32::MAX }
    }

    fn frame(&mut self, crowd: &mut Crowd, member: MemberId) -> f32 {
        crowd.update(STEP_SECS).unwrap();
        let now = rotations(crowd, member);
        let step = step_rad(&self.before, &now);
        self.largest = self.largest.max(step);
        self.least_from_rest = self.least_from_rest.min(step_rad(&now[..1], &[Quat::IDENTITY]));
        self.before = now;
        step
    }
}

/// Returns the largest rotation per frame in plain crossfades between any two clips.
fn largest_crossfade_step(builder: &CrowdBuilder) -> f32 {
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

/// Returns the largest allowed rotation per frame: that of a plain crossfade and 10 % more, because
/// the sum of several poses is shorter than that of two.
fn allowed_rad(builder: &CrowdBuilder) -> f32 {
    let plain = largest_crossfade_step(builder);
    assert!(plain < 0.4, "{plain} rad per frame are too much to detect jumps");
    1.1 * plain
}

fn twenty_starts_within_300_ms_never_jump(builder: &CrowdBuilder) {
    let allowed_rad = allowed_rad(builder);
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
                    step <= allowed_rad,
                    "{slots} slots, start {start}: {step} rad per frame, {allowed_rad} allowed"
                );
            }
            for frame in 0..20 {
                let step = steps.frame(&mut crowd, member);
                assert!(
                    step <= allowed_rad,
                    "{slots} slots, frame {frame} after: {step} rad, {allowed_rad} allowed"
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
                "a clip other than the last one plays"
            );
        }
    }
}

/// Random starts of all kinds on layers 0 and 1, all with a fade.
fn random_starts_of_all_kinds_never_jump(builder: &CrowdBuilder) {
    // Layers 0 and 1 may both be in a crossfade.
    let allowed_rad = 2.0 * allowed_rad(builder);
    for seed in 0..6_u64 {
        let (mut crowd, clips, member) =
            one_member(&builder.clone().slots_per_member(4), &motions());
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        let mut steps = Steps::new(&mut crowd, member);
        let mut rng = Rng::new(seed);
        for frame in 0..80 {
            let clip = clips[rng.below(6)];
            let play = ClipPlayback::looping().fade_in_secs(FADE_SECS);
            match rng.below(6) {
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
                step <= allowed_rad,
                "seed {seed}, frame {frame}: {step} rad per frame, {allowed_rad} allowed"
            );
        }
        assert!(steps.least_from_rest > 0.6, "{} rad from the rest pose", steps.least_from_rest);
    }
}

/// Returns the weight of a clip of a member; 0 if it does not play.
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

fn start_waits_until_the_weakest_slot_has_faded_out(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(&builder.clone().slots_per_member(2), &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.0).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play(clips[1], ClipPlayback::looping().fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.25).unwrap();
    // Clip 1 has a weight of 1/4 and is evicted within 1/4 of the fade.
    let scheduled = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[2], ClipPlayback::looping().fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.2).unwrap();
    assert!((weight(&crowd, member, clips[1]) - 0.05).abs() < 1e-3);
    assert!(
        (weight(&crowd, member, clips[0]) - 0.95).abs() < 1e-3,
        "clip 0 did not take up the weight of clip 1"
    );
    assert_eq!(weight(&crowd, member, clips[2]), 0.0);
    // A scheduled clip can be changed before it has a slot.
    crowd.member_mut(scheduled.member()).unwrap().set_speed(scheduled, 0.5).unwrap();
    crowd.update(0.55).unwrap();
    assert!((weight(&crowd, member, clips[2]) - 0.5).abs() < 1e-3);
    let playing = crowd.member(member).unwrap().active_clips();
    let started = playing.iter().find(|p| p.id == Some(scheduled)).unwrap();
    assert!((started.time_secs - 0.25).abs() < 1e-3 && (started.speed - 0.5).abs() < 1e-4);
}

fn single_slot_switches_clips_at_once(builder: &CrowdBuilder) {
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

on_every_device!(
    twenty_starts_within_300_ms_never_jump,
    random_starts_of_all_kinds_never_jump,
    start_waits_until_the_weakest_slot_has_faded_out,
    single_slot_switches_clips_at_once,
);
