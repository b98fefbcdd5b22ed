//! Blend spaces on members.

use populace::{
    BlendSpace, BlendSpaceId, BlendSpacePlayback, ClipId, ClipPlayback, Crowd, CrowdBuilder,
    Device, Error, MemberId, Placement,
};
use populace_testkit::Rng;

use crate::on_every_way;
use crate::rig::{Motion, one_member, step_rad, turns};

/// Nine clips that swing about a middle and stand further off the more the clip's number says:
/// lengths from 0.5 to 1.3 s; the first has no length.
fn motions() -> Vec<Motion> {
    let names = ["0", "1", "2", "3", "4", "5", "6", "7", "8"];
    let motion = |(nth, name): (u8, &'static str)| {
        let nth = f32::from(nth);
        let angles: Vec<f32> = if nth == 0.0 {
            vec![0.5]
        } else {
            (0..=24_u8)
                .map(|key| {
                    0.5 + 0.05 * nth + 0.1 * f32::sin(f32::from(key) / 24.0 * std::f32::consts::TAU)
                })
                .collect()
        };
        let duration_secs = if nth == 0.0 { 0.0 } else { 0.4 + 0.1 * nth };
        Motion {
            name,
            duration_secs,
            turns: [1.0, 0.5, 0.3, 0.7]
                .map(|part| ([1.0, 0.3, 0.0], angles.iter().map(|a| a * part).collect())),
        }
    };
    (0..).zip(names).map(motion).collect()
}

/// Speeds 0, 1, 2 and turns -1, 0, 1.
fn grid(clips: &[ClipId]) -> BlendSpace {
    let at = |nth: u8| [f32::from(nth / 3), f32::from(nth % 3) - 1.0];
    BlendSpace::plane(&(0..).zip(clips).map(|(nth, clip)| (*clip, at(nth))).collect::<Vec<_>>())
        .unwrap()
}

fn on_grid(builder: &CrowdBuilder, slots: usize) -> (Crowd, Vec<ClipId>, MemberId, BlendSpaceId) {
    let (mut crowd, clips, member) =
        one_member(&builder.clone().slots_per_member(slots), &motions());
    let space = crowd.add_blend_space(grid(&clips)).unwrap();
    (crowd, clips, member, space)
}

/// How far the clips' phases are apart at most; those of no length have none.
fn phases_apart(crowd: &Crowd, member: MemberId, lengths: &[(ClipId, f32)]) -> f32 {
    let playing = crowd.member(member).unwrap().active_clips();
    let phases: Vec<f32> = playing
        .iter()
        .filter_map(|p| {
            Some((p, lengths.iter().find(|(clip, secs)| *clip == p.clip && *secs > 0.0)?.1))
        })
        .map(|(p, secs)| p.time_secs / secs)
        .collect();
    let apart = |a: f32, b: f32| (a - b).abs().min(1.0 - (a - b).abs());
    phases.iter().flat_map(|a| phases.iter().map(|b| apart(*a, *b))).fold(0.0, f32::max)
}

fn lengths(crowd: &Crowd, member: MemberId) -> Vec<(ClipId, f32)> {
    let character = crowd.instances().find(|i| i.member == member).unwrap().character;
    crowd
        .clips(character)
        .unwrap()
        .into_iter()
        .map(|(id, clip)| (id, clip.duration_secs()))
        .collect()
}

fn clips_of_a_space_share_a_phase_wherever_it_is_steered(builder: &CrowdBuilder) {
    let (mut crowd, _, member, space) = on_grid(builder, 6);
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, [1.0, 0.0], BlendSpacePlayback::new().phase(0.3))
        .unwrap();
    let lengths = lengths(&crowd, member);
    for step in 0..60_u8 {
        let (speed, turn) = (f32::from(step % 23) / 11.0, f32::from(step % 17) / 8.0 - 1.0);
        if step % 4 == 0 {
            crowd
                .member_mut(member)
                .unwrap()
                .set_blend_parameter([speed, turn], f32::from(step % 3) * 0.1)
                .unwrap();
        }
        crowd.update(1.0 / 60.0).unwrap();
        let apart = phases_apart(&crowd, member, &lengths);
        assert!(apart < 1e-5, "step {step}: {apart} cycles apart");
        assert!(crowd.member(member).unwrap().active_clips().iter().all(|p| p.id.is_none()));
        let total: f32 =
            crowd.member(member).unwrap().active_clips().iter().map(|p| p.weight).sum();
        assert!((total - 1.0).abs() < 1e-4, "step {step}: {total}");
    }
}

fn a_space_stands_where_it_is_steered_to(builder: &CrowdBuilder) {
    let (mut crowd, clips, member, space) = on_grid(builder, 6);
    let wanted = grid(&clips);
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, [0.0, 0.0], BlendSpacePlayback::new())
        .unwrap();
    crowd.update(0.0).unwrap();
    for (nth, at) in [[0.5, 0.25], [2.0, 1.0], [1.0, 0.0], [9.0, 0.5], [-3.0, -7.0], [1.3, 0.9]]
        .into_iter()
        .enumerate()
    {
        crowd.member_mut(member).unwrap().set_blend_parameter(at, 0.2).unwrap();
        // To the same point again changes nothing.
        crowd.update(0.1).unwrap();
        crowd.member_mut(member).unwrap().set_blend_parameter(at, 5.0).unwrap();
        crowd.update(0.3).unwrap();
        let mut found: Vec<_> = crowd
            .member(member)
            .unwrap()
            .active_clips()
            .iter()
            .map(|p| (p.clip, p.weight))
            .collect();
        let order = |clip| clips.iter().position(|c| *c == clip);
        found.sort_by_key(|(clip, _)| order(*clip));
        let mut weights = wanted.weights(at).unwrap();
        weights.sort_by_key(|(clip, _)| order(*clip));
        assert_eq!(found, weights, "point {nth}");
    }
    // The mean of the cycles per second, by weight, on an edge between clips 7 (1.1 s) and 8 (1.2
    // s).
    crowd.member_mut(member).unwrap().set_blend_parameter([2.0, 0.5], 0.0).unwrap();
    crowd.update(0.0).unwrap();
    let before = crowd.member(member).unwrap().active_clips();
    crowd.update(0.1).unwrap();
    let after = crowd.member(member).unwrap().active_clips();
    let cycles = (after[0].time_secs - before[0].time_secs) / 1.1;
    let wanted = 0.1 * (0.5 / 1.1 + 0.5 / 1.2);
    assert!(
        (cycles - wanted).abs() < 1e-4 || (cycles + 1.0 - wanted).abs() < 1e-4,
        "{cycles} is not {wanted}"
    );
}

/// However a space is steered, a frame's step stays near what the fastest clip and the fade make of
/// it.
fn steering_never_jumps(builder: &CrowdBuilder) {
    const STEP_SECS: f32 = 1.0 / 60.0;
    const OVER_SECS: f32 = 0.2;
    // The clips' own swings, in model space at the end of the arm, and the whole width of the space
    // in one fade.
    let (own, wide) =
        (2.5 * 0.1 * std::f32::consts::TAU / 0.5 * STEP_SECS, 2.5 * 0.6 * STEP_SECS / OVER_SECS);
    for slots in [3, 4, 6, 8] {
        let (mut crowd, clips, member, space) = on_grid(builder, slots);
        crowd.member_mut(member).unwrap().play(clips[8], ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        let mut before = turns(&mut crowd, member);
        let mut rng = Rng::new(slots as u64);
        for frame in 0..240 {
            let at = [rng.below(257), rng.below(257)].map(|n| n as f32 / 128.0);
            match frame {
                0 => crowd
                    .member_mut(member)
                    .unwrap()
                    .play_blend_space(space, 1.0, BlendSpacePlayback::new().fade_in_secs(OVER_SECS))
                    .unwrap(),
                150 => drop(
                    crowd
                        .member_mut(member)
                        .unwrap()
                        .play(clips[1], ClipPlayback::looping().fade_in_secs(OVER_SECS))
                        .unwrap(),
                ),
                180 => crowd
                    .member_mut(member)
                    .unwrap()
                    .play_blend_space(space, at, BlendSpacePlayback::new().fade_in_secs(OVER_SECS))
                    .unwrap(),
                _ if frame % 5 == 0 && !(150..180).contains(&frame) => {
                    crowd
                        .member_mut(member)
                        .unwrap()
                        .set_blend_parameter([at[0], at[1] - 1.0], OVER_SECS)
                        .unwrap();
                }
                _ => {}
            }
            crowd.update(STEP_SECS).unwrap();
            let now = turns(&mut crowd, member);
            let step = step_rad(&before, &now);
            assert!(
                step < own + wide,
                "{slots} slots, frame {frame}: {step} rad, {} allowed",
                own + wide
            );
            before = now;
        }
    }
}

fn an_offset_shifts_a_clip_in_the_cycle(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let space = BlendSpace::line(&[(clips[1], 0.0), (clips[2], 1.0)]).unwrap();
    let space = crowd.add_blend_space(space.with_offset(clips[2], 0.75).unwrap()).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, 0.5, BlendSpacePlayback::new().speed(0.0).phase(0.5))
        .unwrap();
    crowd.update(1.0).unwrap();
    let playing = crowd.member(member).unwrap().active_clips();
    assert!((playing[0].time_secs / 0.5 - 0.5).abs() < 1e-4, "{}", playing[0].time_secs);
    assert!((playing[1].time_secs / 0.6 - 0.25).abs() < 1e-4, "{}", playing[1].time_secs);
}

/// A clip of no length weighs like any other, and the phase stands while it plays alone.
fn a_clip_of_no_length_is_allowed(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let space = crowd
        .add_blend_space(BlendSpace::line(&[(clips[0], 0.0), (clips[1], 1.0)]).unwrap())
        .unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, 0.0, BlendSpacePlayback::new().phase(0.25))
        .unwrap();
    crowd.update(3.0).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips()[0].clip, clips[0]);
    crowd.member_mut(member).unwrap().set_blend_parameter(0.5, 0.0).unwrap();
    crowd.update(0.125).unwrap();
    let playing = crowd.member(member).unwrap().active_clips();
    assert_eq!(playing.iter().map(|p| p.weight).collect::<Vec<_>>(), [0.5, 0.5]);
    assert!(
        (playing[1].time_secs - 0.25).abs() < 1e-4,
        "a quarter of the cycle, and a quarter more since"
    );
}

on_every_way!(
    clips_of_a_space_share_a_phase_wherever_it_is_steered,
    a_space_stands_where_it_is_steered_to,
    steering_never_jumps,
    an_offset_shifts_a_clip_in_the_cycle,
    a_clip_of_no_length_is_allowed,
);

#[test]
fn what_a_space_cannot_be_is_refused() {
    let native = Crowd::builder().device(Device::native());
    let (mut crowd, clips, member, space) = on_grid(&native, 3);
    let is_bad = |result: Result<(), Error>| matches!(result, Err(Error::BadBlendSpace { .. }));
    assert!(
        is_bad(crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1))),
        "plays none"
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play_blend_space(space, [f32::NAN, 0.0], BlendSpacePlayback::new()))
            .is_err()
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play_blend_space(space, 0.0, BlendSpacePlayback::new().weight(2.0)))
            .is_err()
    );
    crowd
        .member_mut(member)
        .unwrap()
        .play_blend_space(space, 0.0, BlendSpacePlayback::new())
        .unwrap();
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.set_blend_parameter(f32::INFINITY, 0.1))
            .is_err()
            && crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, -1.0)).is_err()
    );
    crowd.member_mut(member).unwrap().play(clips[1], ClipPlayback::looping()).unwrap();
    assert!(
        is_bad(crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1))),
        "plays it no longer"
    );
    let (mut other, other_clips, stranger, other_space) = on_grid(&native, 2);
    assert!(
        is_bad(other.member_mut(stranger).and_then(|mut m| m.play_blend_space(
            other_space,
            0.0,
            BlendSpacePlayback::new()
        ))),
        "two slots are too few"
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play_blend_space(other_space, 0.0, BlendSpacePlayback::new()))
            .is_err()
    );
    assert!(crowd.add_blend_space(grid(&other_clips)).is_err());
    let character = crowd.instances().next().unwrap().character;
    let member = crowd.spawn(character, Placement::at([0.0; 3])).unwrap();
    assert!(is_bad(crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1))));
}
