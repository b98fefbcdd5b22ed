//! Blend spaces.

use populace::{
    BlendSpace, BlendSpaceId, BlendSpacePlayback, ClipId, ClipPlayback, Crowd, CrowdBuilder,
    Device, Error, MemberId, Placement,
};
use populace_testkit::Rng;

use crate::fixture::{Motion, one_member, rotations, step_rad};
use crate::on_every_device;

/// Nine clips that swing about a mean angle. The mean grows with the clip's index, and so does the
/// duration: 0.5 s to 1.2 s, except for the first, whose duration is 0.
pub(crate) fn motions() -> Vec<Motion> {
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
            rotations: [1.0, 0.5, 0.3, 0.7]
                .map(|part| ([1.0, 0.3, 0.0], angles.iter().map(|a| a * part).collect())),
        }
    };
    (0..).zip(names).map(motion).collect()
}

/// A space over the speeds 0, 1, 2 and the turn rates -1, 0, 1.
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

/// Returns the largest difference between the phases of a member's clips, in cycles. Clips of
/// duration 0 have no phase.
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
    let character = crowd.member(member).unwrap().character();
    crowd
        .character(character)
        .unwrap()
        .clips()
        .into_iter()
        .map(|(id, clip)| (id, clip.duration_secs()))
        .collect()
}

fn clips_of_a_space_share_one_phase_at_every_position(builder: &CrowdBuilder) {
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

fn space_takes_the_weights_of_its_position(builder: &CrowdBuilder) {
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
        // Setting the same position again changes nothing.
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
    // The rate in cycles per second is the weighted mean of clips 7 (1.1 s) and 8 (1.2 s).
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

/// Whatever the blend-space position, the rotation per frame stays within that of the fastest clip
/// and of the fade.
fn position_changes_never_jump(builder: &CrowdBuilder) {
    const STEP_SECS: f32 = 1.0 / 60.0;
    const OVER_SECS: f32 = 0.2;
    // Rotation per frame at the end of the arm, in model space: the clips' own swing, and a fade
    // across the whole width of the space.
    let (own, wide) =
        (2.5 * 0.1 * std::f32::consts::TAU / 0.5 * STEP_SECS, 2.5 * 0.6 * STEP_SECS / OVER_SECS);
    // In these streams clips come back while their weight is negligible, and a clip from before the
    // blend space holds its weight while others make room.
    let seeds = [30, 45, 52, 115, 169];
    for (seed, slots) in seeds.into_iter().flat_map(|seed| [3, 4, 6, 8].map(|n| (seed, n))) {
        let (mut crowd, clips, member, space) = on_grid(builder, slots);
        crowd.member_mut(member).unwrap().play(clips[8], ClipPlayback::looping()).unwrap();
        crowd.update(0.1).unwrap();
        let mut before = rotations(&mut crowd, member);
        let mut rng = Rng::new(seed);
        for frame in 0..240 {
            let at = [2.0, 2.0].map(|most| rng.unit() * most);
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
            let now = rotations(&mut crowd, member);
            let step = step_rad(&before, &now);
            assert!(
                step < own + wide,
                "seed {seed}, {slots} slots, frame {frame}: {step} rad per frame, {} allowed",
                own + wide
            );
            before = now;
        }
    }
}

fn offset_shifts_a_clip_within_the_cycle(builder: &CrowdBuilder) {
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

/// A clip of duration 0 is weighted like any other, and the phase stops while it plays alone.
fn clip_of_duration_zero_is_allowed(builder: &CrowdBuilder) {
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
        "the phase is not 1/4 of a cycle at the start and 1/4 since then"
    );
}

on_every_device!(
    clips_of_a_space_share_one_phase_at_every_position,
    space_takes_the_weights_of_its_position,
    position_changes_never_jump,
    offset_shifts_a_clip_within_the_cycle,
    clip_of_duration_zero_is_allowed,
);

#[test]
fn bad_blend_spaces_and_positions_are_refused() {
    let native = Crowd::builder().device(Device::native());
    let (mut crowd, clips, member, space) = on_grid(&native, 3);
    let is_bad = |result: Result<(), Error>| matches!(result, Err(Error::BadBlendSpace { .. }));
    assert!(
        is_bad(crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1))),
        "the member plays a blend space"
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
        "the member still plays the space"
    );
    let (mut other, other_clips, stranger, other_space) = on_grid(&native, 2);
    assert!(
        is_bad(other.member_mut(stranger).and_then(|mut m| m.play_blend_space(
            other_space,
            0.0,
            BlendSpacePlayback::new()
        ))),
        "a blend space of three clips played in two slots"
    );
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.play_blend_space(other_space, 0.0, BlendSpacePlayback::new()))
            .is_err()
    );
    assert!(crowd.add_blend_space(grid(&other_clips)).is_err());
    let character = crowd.members().next().unwrap().character();
    let member = crowd.spawn(character, Placement::at([0.0; 3])).unwrap();
    assert!(is_bad(crowd.member_mut(member).and_then(|mut m| m.set_blend_parameter(0.0, 0.1))));
}
