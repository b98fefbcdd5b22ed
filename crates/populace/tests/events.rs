//! What is told of members while clips play.

#![expect(
    clippy::disallowed_methods,
    reason = "tests have no need of the same bits on every machine"
)]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a test that cannot go on fails; bodies are shared with others"
)]

#[path = "controls/body.rs"]
mod body;

use body::{Stage, stage};
use populace::{
    BlendSpace, BlendSpacePlayback, ClipPlayback, Crowd, Device, Error, Event, EventKind,
    Placement, Schedule,
};

fn native() -> Stage {
    stage(Device::native(), Schedule::Fused)
}

/// Events of steps of so long, until so late.
fn events(stage: &mut Stage, step_secs: f32, until_secs: f32) -> Vec<Event> {
    let mut all = Vec::new();
    let mut secs = 0.0;
    while secs < until_secs - 1e-4 {
        stage.update(step_secs);
        all.extend(stage.crowd.events().iter().cloned());
        secs += step_secs;
    }
    all
}

fn is_footstep(event: &Event, foot: &str) -> bool {
    matches!(&event.kind, EventKind::Footstep { joint } if &**joint == foot)
}

#[test]
fn feet_that_come_down_are_told_of_once_each_however_long_the_steps_of_the_clock() {
    let found = [1.0 / 60.0, 0.1, 1.0, 5.0].map(|step| {
        let mut stage = native();
        let clip = stage.clip("walk");
        let member = stage.member(Placement::at([0.0; 3]));
        let other = stage.member(Placement::at([0.0; 3]));
        for member in [member, other] {
            stage
                .crowd
                .member_mut(member)
                .expect("a clip that plays")
                .play(clip, ClipPlayback::looping().speed(1.5).phase(0.37))
                .expect("a clip that plays");
        }
        stage.crowd.member_mut(member).expect("a member").subscribe_events();
        let events = events(&mut stage, step, 5.0);
        assert!(events.iter().all(|event| event.member == member && event.clip == clip));
        events
    });
    // Seven and a half cycles of one second; a leg that swings from the hip lifts its foot before
    // and behind.
    for foot in ["leftFoot", "rightFoot"] {
        let count = found[0].iter().filter(|event| is_footstep(event, foot)).count();
        assert!((14..=16).contains(&count), "{foot} came down {count} times");
    }
    for other in &found[1..] {
        assert_eq!(other.len(), found[0].len());
        for (a, b) in found[0].iter().zip(other) {
            assert_eq!(a.kind, b.kind);
            assert!((a.at_secs - b.at_secs).abs() < 1e-4, "{a:?} {b:?}");
        }
    }
    // A foot comes down where the clip says so.
    let mut stage = native();
    let clip = stage.clip("walk");
    let known =
        stage.crowd.clips(stage.body).expect("a character").into_iter().find(|(id, _)| *id == clip);
    let secs = known.expect("it is there").1.footsteps()[0].secs;
    let (before, after) = (f64::from(secs) - 0.01, f64::from(secs) + 0.01);
    let height = |stage: &mut Stage, at: f64| {
        let member = stage.member(Placement::at([0.0; 3]));
        #[expect(clippy::cast_possible_truncation, reason = "the nearest will do")]
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::held_at_secs(at as f32))
            .expect("a clip that plays");
        stage.update(0.0);
        [stage.place(member, "leftFoot")[1], stage.place(member, "rightFoot")[1]]
    };
    let (high, low) = (height(&mut stage, before), height(&mut stage, after));
    assert!((0..2).any(|foot| low[foot] < high[foot] - 1e-4), "{high:?} {low:?}");
}

#[test]
fn moments_and_ends_are_told_of_when_they_are_reached_forwards_and_backwards() {
    for (speed, moment_secs) in [(1.0, 0.5), (-1.0, 1.5), (2.0, 0.25)] {
        let mut stage = native();
        let clip = stage.clip("sway");
        stage.crowd.add_event_marker(clip, "swish", 0.5).expect("a moment of two seconds");
        let member = stage.member(Placement::at([0.0; 3]));
        stage.crowd.member_mut(member).expect("a member").subscribe_events();
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::once().speed(speed))
            .expect("a clip that plays");
        let found: Vec<_> = events(&mut stage, 0.05, 4.0)
            .into_iter()
            .filter(|event| !matches!(event.kind, EventKind::Footstep { .. }))
            .collect();
        let [moment, end] = &found[..] else { panic!("{found:?}") };
        assert_eq!(moment.kind, EventKind::Marker { name: "swish".into() });
        assert_eq!(end.kind, EventKind::ClipEnd);
        assert!((moment.at_secs - moment_secs).abs() < 1e-5, "{moment:?}");
        assert!((end.at_secs - 2.0 / f64::from(speed.abs())).abs() < 1e-5, "{end:?}");
        stage.crowd.member_mut(member).unwrap().unsubscribe_events();
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::once())
            .expect("a clip that plays");
        assert_eq!(events(&mut stage, 0.05, 4.0), []);
    }
}

#[test]
fn what_is_not_within_a_clip_is_refused_and_those_who_leave_are_told_of_no_more() {
    let mut stage = native();
    let clip = stage.clip("sway");
    for secs in [-0.1, 2.1, f32::NAN] {
        let error = stage
            .crowd
            .add_event_marker(clip, "never", secs)
            .expect_err("it is not within two seconds");
        assert!(matches!(error, Error::BadValue { .. }), "{error}");
    }
    let member = stage.member(Placement::at([0.0; 3]));
    stage.crowd.member_mut(member).expect("a member").subscribe_events();
    stage
        .crowd
        .member_mut(member)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::once())
        .expect("a clip that plays");
    stage.crowd.despawn(member).expect("a member");
    assert_eq!(events(&mut stage, 0.5, 4.0), []);
    assert!(stage.crowd.member_mut(member).map(|mut m| m.subscribe_events()).is_err());
}

/// The end of the first of several clips is told of once, and all else alike, whatever the steps
/// are.
fn ends_once(next: impl Fn(&mut Stage, populace::MemberId)) {
    let found = [1.0 / 60.0, 0.5, 3.0].map(|step| {
        let mut stage = native();
        let clip = stage.clip("walk");
        let member = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::once())
            .expect("a clip that plays");
        next(&mut stage, member);
        stage.crowd.member_mut(member).expect("a member").subscribe_events();
        events(&mut stage, step, 3.0)
    });
    let ends =
        |events: &[Event]| events.iter().filter(|event| event.kind == EventKind::ClipEnd).count();
    for events in &found {
        assert_eq!((ends(events), events.len()), (1, found[0].len()));
    }
}

/// A clip that is left by inertialization in the midst of a step of the clock has happened up to
/// then.
#[test]
fn what_is_left_is_told_of_up_to_then() {
    ends_once(|stage, member| {
        let clip = stage.clip("walk");
        stage
            .crowd
            .member_mut(member)
            .expect("a clip to follow")
            .queue(clip, ClipPlayback::looping().inertialize_in_secs(0.3))
            .expect("a clip to follow");
    });
}

/// One that is cut has happened up to then too.
#[test]
fn what_is_cut_is_told_of_up_to_then() {
    ends_once(|stage, member| {
        for name in ["sway", "walk"] {
            let clip = stage.clip(name);
            stage
                .crowd
                .member_mut(member)
                .expect("a clip to follow")
                .queue(clip, ClipPlayback::looping())
                .expect("a clip to follow");
        }
    });
}

/// A blend space that found one slot goes on to its point once there is another, in the midst of a
/// step.
#[test]
fn what_is_steered_within_a_step_is_told_of_before_and_after() {
    let found = [1.0 / 60.0, 0.5, 3.0].map(|step| {
        let builder = Crowd::builder().device(Device::native()).slots_per_member(2);
        let mut crowd = builder.build().expect("a crowd");
        let body = crowd.add_character(body::character()).expect("room");
        let mut stage = Stage { crowd, body };
        let (walk, sway) = (stage.clip("walk"), stage.clip("sway"));
        let space = BlendSpace::line(&[(walk, 0.0), (sway, 1.0)]).expect("a space");
        let space = stage.crowd.add_blend_space(space).expect("a space");
        let member = stage.member(Placement::at([0.0; 3]));
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(sway, ClipPlayback::held_at_secs(0.0))
            .expect("a clip that plays");
        stage
            .crowd
            .member_mut(member)
            .expect("a space")
            .play_blend_space(space, 0.4, BlendSpacePlayback::new().fade_in_secs(0.9))
            .expect("a space");
        stage.crowd.member_mut(member).expect("a member").subscribe_events();
        events(&mut stage, step, 3.0)
    });
    assert!(found[0].len() > 4, "{found:?}");
    assert!(found.iter().all(|events| events.len() == found[0].len()), "{found:?}");
}
