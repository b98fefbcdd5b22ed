//! Starts, ends, speeds and weights of clips, and the list of active clips.

use populace::{
    ActiveClip, ClipId, ClipPlayback, Crowd, CrowdBuilder, Device, Error, MemberId, Placement,
};

use crate::fixture::{JOINTS, Motion, crowd_of, one_member, rotations};
use crate::on_every_device;

/// Clips that rotate the root: "wave" by 1 rad in 1 s, "nod" by 2 rad in 0.5 s, "idle" by 0.5 rad
/// and back in 2 s. "still" has a duration of 0.
fn motions() -> Vec<Motion> {
    let motion = |name, duration_secs, angles: &[f32]| {
        let still = ([1.0, 0.0, 0.0], vec![0.0]);
        let mut rotations = [(); JOINTS].map(|()| still.clone());
        rotations[0] = ([1.0, 0.0, 0.0], angles.to_vec());
        Motion { name, duration_secs, rotations }
    };
    vec![
        motion("wave", 1.0, &[0.0, 0.25, 0.5, 0.75, 1.0]),
        motion("nod", 0.5, &[0.0, 0.5, 1.0, 1.5, 2.0]),
        motion("idle", 2.0, &[0.0, 0.5, 0.0]),
        motion("still", 0.0, &[0.3]),
    ]
}

/// Returns the rotation angle of the root in radians.
fn root_angle(crowd: &mut Crowd, member: MemberId) -> f32 {
    rotations(crowd, member)[0].to_axis_angle().1
}

#[track_caller]
fn assert_near(value: f32, wanted: f32) {
    assert!((value - wanted).abs() < 2e-3, "{value} is not {wanted}");
}

#[track_caller]
fn playing(crowd: &Crowd, member: MemberId, clip: ClipId) -> ActiveClip {
    let all = crowd.member(member).unwrap().active_clips();
    *all.iter().find(|p| p.clip == clip).unwrap_or_else(|| panic!("not among {all:?}"))
}

fn queued_clips_start_on_their_tick(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let [wave, nod, idle] = [clips[0], clips[1], clips[2]];
    crowd.member_mut(member).unwrap().play(wave, ClipPlayback::once()).unwrap();
    crowd.member_mut(member).unwrap().queue(nod, ClipPlayback::once()).unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .queue(wave, ClipPlayback::once().speed(-2.0).after_secs(0.25))
        .unwrap();
    crowd
        .member_mut(member)
        .unwrap()
        .queue(idle, ClipPlayback::looping().fade_in_secs(0.5))
        .unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips().len(), 1, "a queued clip took a slot");
    for (step, wanted) in [
        (0.75, 0.75),
        (0.5, 1.0), // 0.25 s into the nod
        (0.25, 2.0),
        (0.2, 2.0),          // the nod holds its end
        (0.3, 1.0 - 0.5),    // backwards at twice the speed since 1.75 s
        (0.25, 0.0),         // at its end, which is its start
        (0.25, 0.5 * 0.125), // half faded into the idle
        (0.25, 0.25),
    ] {
        crowd.update(step).unwrap();
        assert_near(root_angle(&mut crowd, member), wanted);
    }
    let all = crowd.member(member).unwrap().active_clips();
    assert_eq!((all.len(), all[0].clip, all[0].weight, all[0].ends_in_secs), (1, idle, 1.0, None));
}

/// A long frame passes several starts at once, with the same result as short frames.
fn starts_do_not_depend_on_the_frame_length(builder: &CrowdBuilder) {
    let run = |steps: u16| {
        let (mut crowd, clips, member) = one_member(builder, &motions());
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once()).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .queue(clips[1], ClipPlayback::once().fade_in_secs(0.1))
            .unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .queue(clips[2], ClipPlayback::looping().fade_in_secs(0.4).phase(0.3))
            .unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .blend(clips[0], ClipPlayback::looping().weight(0.3).after_secs(1.45))
            .unwrap();
        (0..steps).for_each(|_| crowd.update(1.75 / f32::from(steps)).unwrap());
        (
            crowd.member_mut(member).unwrap().palette().unwrap(),
            crowd.member(member).unwrap().active_clips().len(),
        )
    };
    let once = run(1);
    assert_eq!(once.1, 3);
    assert!(run(7) == once && run(28) == once, "palettes differ");
}

fn queued_clip_follows_a_loop_at_the_end_of_its_cycle(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping().phase(0.4)).unwrap();
    crowd.update(1.0).unwrap(); // 0.4 into the second cycle
    crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once()).unwrap();
    crowd.update(0.59).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.99);
    crowd.update(0.26).unwrap();
    assert_near(root_angle(&mut crowd, member), 1.0);
    // Held clips and clips of duration 0 have no end, so the queued clip starts at once.
    for play in [ClipPlayback::held_at_secs(0.5), ClipPlayback::once()] {
        let clip = if play == ClipPlayback::once() { clips[3] } else { clips[0] };
        crowd.member_mut(member).unwrap().play(clip, play).unwrap();
        crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once()).unwrap();
        crowd.update(0.25).unwrap();
        assert_near(root_angle(&mut crowd, member), 1.0);
    }
}

fn delayed_start_begins_on_its_tick_and_can_be_cancelled(builder: &CrowdBuilder) {
    let (mut crowd, id, clips) = crowd_of(builder, &motions());
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::held_at_secs(0.25)).unwrap();
    let later = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[1], ClipPlayback::looping().after_secs(0.3))
        .unwrap();
    crowd.member_mut(later.member()).unwrap().set_weight(later, 0.75, 0.0).unwrap();
    crowd.update(0.29).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.25);
    crowd.update(0.135).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.5);
    assert_near(playing(&crowd, member, clips[1]).weight, 0.75);
    let later = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[0], ClipPlayback::once().after_secs(0.1))
        .unwrap();
    crowd.member_mut(member).unwrap().stop(0, 0.0).unwrap();
    crowd.update(0.5).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.0);
    assert_eq!(
        crowd.member_mut(later.member()).and_then(|mut m| m.set_weight(later, 1.0, 0.0)),
        Err(Error::StalePlayback)
    );
    let later = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[0], ClipPlayback::once().after_secs(0.1))
        .unwrap();
    crowd.despawn(member).unwrap();
    let newcomer = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    crowd.update(0.5).unwrap();
    assert_eq!(
        crowd.member(newcomer).unwrap().active_clips(),
        [],
        "a start of the despawned member reached the new one"
    );
    assert_eq!(
        crowd.member_mut(later.member()).and_then(|mut m| m.set_weight(later, 1.0, 0.0)),
        Err(Error::StaleMember)
    );
}

fn playback_that_has_ended_stays_ended(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let wave = crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::looping()).unwrap();
    crowd.update(0.1).unwrap();
    let next = ClipPlayback::looping().fade_in_secs(0.2);
    crowd.member_mut(member).unwrap().play(clips[1], next).unwrap();
    crowd.update(0.1).unwrap();
    crowd.member_mut(member).unwrap().set_speed(wave, 0.5).unwrap();
    crowd.update(0.2).unwrap();
    let mut edit = crowd.member_mut(member).unwrap();
    assert_eq!(edit.set_weight(wave, 1.0, 0.0), Err(Error::StalePlayback));
    assert_eq!(edit.set_speed(wave, 1.0), Err(Error::StalePlayback));
    crowd.update(0.1).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips().len(), 1);
}

fn speed_changes_do_not_jump_and_move_the_queue(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    let wave = crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once()).unwrap();
    crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once()).unwrap();
    let mut at = |speed: Option<f32>, secs: f32, wanted: f32| {
        if let Some(speed) = speed {
            let before = root_angle(&mut crowd, member);
            crowd.member_mut(wave.member()).unwrap().set_speed(wave, speed).unwrap();
            crowd.update(0.0).unwrap();
            assert!(
                (root_angle(&mut crowd, member) - before).abs() < 1e-5,
                "setting the speed to {speed} moved the root"
            );
        }
        crowd.update(secs).unwrap();
        assert_near(root_angle(&mut crowd, member), wanted);
    };
    at(None, 0.4, 0.4);
    at(Some(0.5), 0.4, 0.6);
    at(Some(0.0), 5.0, 0.6);
    at(Some(-1.0), 0.5, 0.1);
    at(Some(2.0), 0.44, 0.98);
    at(None, 0.26, 1.0); // The nod started when the wave ended.
    at(None, 0.25, 2.0);
    let idle = crowd.member_mut(member).unwrap().play(clips[2], ClipPlayback::looping()).unwrap();
    crowd.update(0.5).unwrap();
    crowd.member_mut(idle.member()).unwrap().set_speed(idle, -1.0).unwrap();
    crowd.update(0.0).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.25);
    crowd.update(1.0).unwrap(); // backwards past the start to the end
    assert_near(root_angle(&mut crowd, member), 0.25);
    let found = playing(&crowd, member, clips[2]);
    assert_near(found.time_secs, 1.5);
    assert_near(found.speed, -1.0);
}

/// The speed of a clip moves what is queued behind it. It moves neither what is queued on another
/// layer, nor what follows something that has ended.
#[test]
fn speeds_that_are_set_in_each_frame_do_not_hold_up_the_queue() {
    let held = ClipPlayback::held_at_secs(0.5);
    for (layer, play, wanted_secs) in [
        (1, ClipPlayback::looping(), 4.0),
        (1, ClipPlayback::once(), 4.0),
        (1, held, 3.0),
        (0, ClipPlayback::looping(), 4.0),
        (0, ClipPlayback::once(), 4.0),
    ] {
        let (mut crowd, clips, member) =
            one_member(&Crowd::builder().device(Device::native()), &motions());
        let mut view = crowd.member_mut(member).unwrap();
        let base = view.play(clips[0], play).unwrap();
        let above = view.play(clips[2], ClipPlayback::looping().on_layer(1)).unwrap();
        view.queue(clips[1], ClipPlayback::looping().after_secs(3.0)).unwrap();
        let mut at_secs = None;
        for frame in 1..=60_u8 {
            view = crowd.member_mut(member).unwrap();
            let speed = 1.0 + 1e-4 * f32::from(frame % 2);
            view.set_speed([base, above][layer], speed).unwrap();
            crowd.update(0.1).unwrap();
            let all = crowd.member(member).unwrap().active_clips();
            if all.iter().any(|clip| clip.clip == clips[1]) {
                at_secs = Some(0.1 * f32::from(frame));
                break;
            }
        }
        let at_secs = at_secs.unwrap_or(f32::INFINITY);
        let found = format!("layer {layer}, {play:?}: {at_secs} s instead of {wanted_secs}");
        assert!((at_secs - wanted_secs).abs() < 0.15, "{found}");
    }
}

fn weights_fade_and_end_clips(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::held_at_secs(0.0)).unwrap();
    let other = crowd
        .member_mut(member)
        .unwrap()
        .blend(clips[0], ClipPlayback::held_at_secs(1.0).weight(1.0).fade_in_secs(1.0))
        .unwrap();
    crowd.update(0.5).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.330); // 1/3, by quaternion nlerp
    crowd.member_mut(other.member()).unwrap().set_weight(other, 0.25, 0.5).unwrap();
    crowd.update(0.25).unwrap();
    assert_near(playing(&crowd, member, clips[0]).weight, 1.0);
    crowd.member_mut(other.member()).unwrap().set_weight(other, 0.0, 0.2).unwrap();
    crowd.update(0.3).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.0);
    assert_eq!(crowd.member(member).unwrap().active_clips().len(), 1, "the clip has not ended");
    // A handle goes stale once another clip takes the slot.
    for _ in 0..4 {
        crowd.member_mut(member).unwrap().blend(clips[1], ClipPlayback::looping()).unwrap();
    }
    assert_eq!(
        crowd.member_mut(other.member()).and_then(|mut m| m.set_weight(other, 1.0, 0.0)),
        Err(Error::StalePlayback)
    );
    assert_eq!(
        crowd.member_mut(other.member()).and_then(|mut m| m.set_speed(other, 1.0)),
        Err(Error::StalePlayback)
    );
}

on_every_device!(
    queued_clips_start_on_their_tick,
    starts_do_not_depend_on_the_frame_length,
    queued_clip_follows_a_loop_at_the_end_of_its_cycle,
    delayed_start_begins_on_its_tick_and_can_be_cancelled,
    speed_changes_do_not_jump_and_move_the_queue,
    playback_that_has_ended_stays_ended,
    weights_fade_and_end_clips,
    fade_shorter_than_a_tick_ends_within_one_tick,
);

#[test]
fn active_clips_have_times_weights_and_layers() {
    let (mut crowd, clips, member) =
        one_member(&Crowd::builder().device(Device::native()), &motions());
    assert_eq!(crowd.member(member).unwrap().active_clips(), []);
    let upper = crowd
        .member_mut(member)
        .unwrap()
        .play(clips[2], ClipPlayback::looping().on_layer(2).phase(0.25).weight(0.5))
        .unwrap();
    let wave =
        crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once().speed(0.5)).unwrap();
    crowd.update(0.5).unwrap();
    let found = crowd.member(member).unwrap().active_clips();
    let ids: Vec<_> = found.iter().map(|p| (p.id, p.clip, p.layer, p.weight)).collect();
    assert_eq!(ids, [(Some(wave), clips[0], 0, 1.0), (Some(upper), clips[2], 2, 0.5)]);
    assert_near(found[0].time_secs, 0.25);
    assert_near(found[1].time_secs, 1.0);
    assert_eq!(found[1].ends_in_secs, None);
    assert!((found[0].ends_in_secs.unwrap() - 1.5).abs() < 1e-5);
    crowd.update(9.0).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips()[0].ends_in_secs, Some(0.0));
}

fn fade_shorter_than_a_tick_ends_within_one_tick(builder: &CrowdBuilder) {
    let (mut crowd, clips, member) = one_member(builder, &motions());
    crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::held_at_secs(0.5)).unwrap();
    for (secs, from, to) in [(f32::from_bits(1), 0.5, 1.0), (1e-20, 1.0, 0.5), (1e-7, 0.5, 1.0)] {
        crowd
            .member_mut(member)
            .unwrap()
            .play(clips[0], ClipPlayback::held_at_secs(to).fade_in_secs(secs))
            .unwrap();
        crowd.update(0.0).unwrap();
        assert_near(root_angle(&mut crowd, member), from);
        crowd.update(0.001).unwrap();
        assert_near(root_angle(&mut crowd, member), to);
    }
}

#[test]
fn bad_playback_values_are_refused_and_change_nothing() {
    let (mut crowd, clips, member) =
        one_member(&Crowd::builder().device(Device::native()), &motions());
    let wave = crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once()).unwrap();
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert!(
            crowd
                .member_mut(member)
                .and_then(|mut m| m.play(clips[1], ClipPlayback::once().after_secs(bad)))
                .is_err()
        );
        assert!(
            crowd
                .member_mut(member)
                .and_then(|mut m| m.queue(clips[1], ClipPlayback::once().fade_in_secs(bad)))
                .is_err()
        );
        assert!(
            crowd.member_mut(wave.member()).and_then(|mut m| m.set_weight(wave, bad, 0.0)).is_err()
                && crowd
                    .member_mut(wave.member())
                    .and_then(|mut m| m.set_weight(wave, 0.5, bad))
                    .is_err()
        );
        assert!(
            bad < 0.0
                || crowd
                    .member_mut(wave.member())
                    .and_then(|mut m| m.set_speed(wave, bad))
                    .is_err()
        );
    }
    assert!(
        crowd.member_mut(wave.member()).and_then(|mut m| m.set_weight(wave, 1.5, 0.0)).is_err()
    );
    let (mut other, other_clips, stranger) =
        one_member(&Crowd::builder().device(Device::native()), &motions());
    let foreign =
        other.member_mut(stranger).unwrap().play(other_clips[0], ClipPlayback::once()).unwrap();
    assert!(matches!(
        crowd.member_mut(foreign.member()).and_then(|mut m| m.set_speed(foreign, 1.0)),
        Err(Error::UnknownId { what: populace::IdKind::Member, .. })
    ));
    assert!(
        crowd
            .member_mut(member)
            .and_then(|mut m| m.queue(other_clips[0], ClipPlayback::once()))
            .is_err()
    );
    crowd.update(0.5).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.5);
}

#[test]
fn extreme_delays_fades_and_speeds_are_valid() {
    let (mut crowd, clips, member) =
        one_member(&Crowd::builder().device(Device::native()), &motions());
    let wave = crowd.member_mut(member).unwrap().play(clips[0], ClipPlayback::once()).unwrap();
    crowd.update(0.5).unwrap();
    for _ in 0..9 {
        crowd
            .member_mut(member)
            .unwrap()
            .blend(clips[1], ClipPlayback::looping().fade_in_secs(1e9).on_layer(1))
            .unwrap();
    }
    crowd
        .member_mut(member)
        .unwrap()
        .queue(clips[1], ClipPlayback::once().after_secs(1e9))
        .unwrap();
    crowd.member_mut(wave.member()).unwrap().set_speed(wave, 1e-30).unwrap();
    crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once().speed(1e-30)).unwrap();
    crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once().speed(0.0)).unwrap();
    crowd.member_mut(member).unwrap().queue(clips[1], ClipPlayback::once()).unwrap();
    crowd.update(1e3).unwrap();
    assert_near(root_angle(&mut crowd, member), 0.5);
}
