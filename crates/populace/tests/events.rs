//! Events of members: footsteps, markers and clip ends.

#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]

#[path = "controls/fixture.rs"]
mod fixture;

use fixture::{Scene, scene};
use populace::{
    BlendSpace, BlendSpacePlayback, ClipPlayback, Crowd, Device, Error, Event, EventKind,
    Placement, Schedule,
};

fn native() -> Scene {
    scene(Device::native(), Schedule::Fused)
}

/// Updates the scene in steps of `step_secs` until `until_secs` and collects all events.
fn events(scene: &mut Scene, step_secs: f32, until_secs: f32) -> Vec<Event> {
    let mut all = Vec::new();
    let mut secs = 0.0;
    while secs < until_secs - 1e-4 {
        scene.update(step_secs);
        all.extend(scene.crowd.events().iter().cloned());
        secs += step_secs;
    }
    all
}

fn is_footstep(event: &Event, foot: &str) -> bool {
    matches!(&event.kind, EventKind::Footstep { joint } if &**joint == foot)
}

#[test]
fn footsteps_are_reported_once_whatever_the_frame_length() {
    let found = [1.0 / 60.0, 0.1, 1.0, 5.0].map(|step| {
        let mut scene = native();
        let clip = scene.clip("walk");
        let member = scene.member(Placement::at([0.0; 3]));
        let other = scene.member(Placement::at([0.0; 3]));
        for member in [member, other] {
            scene
                .edit(member)
                .play(clip, ClipPlayback::looping().speed(1.5).phase(0.37))
                .expect("a clip that plays");
        }
        scene.edit(member).subscribe_events();
        let events = events(&mut scene, step, 5.0);
        assert!(events.iter().all(|event| event.member == member && event.clip == clip));
        events
    });
    // 7.5 cycles of one second. A leg that swings from the hip lifts its foot in front of and
    // behind the body, so there are two footsteps per cycle.
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
    // The foot is lower just after the footstep than just before it.
    let mut scene = native();
    let clip = scene.clip("walk");
    let known = scene
        .crowd
        .character(scene.body)
        .expect("a character")
        .clips()
        .into_iter()
        .find(|(id, _)| *id == clip);
    let secs = known.expect("a clip").1.footsteps()[0].secs;
    let (before, after) = (f64::from(secs) - 0.01, f64::from(secs) + 0.01);
    let height = |scene: &mut Scene, at: f64| {
        let member = scene.member(Placement::at([0.0; 3]));
        #[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is close enough")]
        scene
            .edit(member)
            .play(clip, ClipPlayback::held_at_secs(at as f32))
            .expect("a clip that plays");
        scene.update(0.0);
        [scene.position(member, "leftFoot")[1], scene.position(member, "rightFoot")[1]]
    };
    let (high, low) = (height(&mut scene, before), height(&mut scene, after));
    assert!((0..2).any(|foot| low[foot] < high[foot] - 1e-4), "{high:?} {low:?}");
}

#[test]
fn markers_and_clip_ends_are_reported_in_both_directions() {
    for (speed, marker_secs) in [(1.0, 0.5), (-1.0, 1.5), (2.0, 0.25)] {
        let mut scene = native();
        let clip = scene.clip("sway");
        scene
            .crowd
            .clip_mut(clip)
            .expect("a marker within two seconds")
            .add_event_marker("swish", 0.5)
            .expect("a marker within two seconds");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).subscribe_events();
        scene
            .edit(member)
            .play(clip, ClipPlayback::once().speed(speed))
            .expect("a clip that plays");
        let found: Vec<_> = events(&mut scene, 0.05, 4.0)
            .into_iter()
            .filter(|event| !matches!(event.kind, EventKind::Footstep { .. }))
            .collect();
        let [marker, end] = &found[..] else { panic!("{found:?}") };
        assert_eq!(marker.kind, EventKind::Marker { name: "swish".into() });
        assert_eq!(end.kind, EventKind::ClipEnd);
        assert!((marker.at_secs - marker_secs).abs() < 1e-5, "{marker:?}");
        assert!((end.at_secs - 2.0 / f64::from(speed.abs())).abs() < 1e-5, "{end:?}");
        scene.crowd.member_mut(member).unwrap().unsubscribe_events();
        scene.edit(member).play(clip, ClipPlayback::once()).expect("a clip that plays");
        assert_eq!(events(&mut scene, 0.05, 4.0), []);
    }
}

#[test]
fn bad_markers_are_refused_and_despawned_members_are_silent() {
    let mut scene = native();
    let clip = scene.clip("sway");
    for secs in [-0.1, 2.1, f32::NAN] {
        let error = scene
            .crowd
            .clip_mut(clip)
            .expect("a clip")
            .add_event_marker("never", secs)
            .expect_err("a marker outside the clip");
        assert!(matches!(error, Error::BadValue { .. }), "{error}");
    }
    let member = scene.member(Placement::at([0.0; 3]));
    scene.edit(member).subscribe_events();
    scene.edit(member).play(clip, ClipPlayback::once()).expect("a clip that plays");
    scene.crowd.despawn(member).expect("a member");
    assert_eq!(events(&mut scene, 0.5, 4.0), []);
    assert!(scene.crowd.member_mut(member).map(|mut m| m.subscribe_events()).is_err());
}

/// Asserts that the end of the first of several clips is reported once, and that the number of
/// events is the same for all step lengths. `next` queues the clips that follow.
fn assert_ends_once(next: impl Fn(&mut Scene, populace::MemberId)) {
    let found = [1.0 / 60.0, 0.5, 3.0].map(|step| {
        let mut scene = native();
        let clip = scene.clip("walk");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play(clip, ClipPlayback::once()).expect("a clip that plays");
        next(&mut scene, member);
        scene.edit(member).subscribe_events();
        events(&mut scene, step, 3.0)
    });
    let ends =
        |events: &[Event]| events.iter().filter(|event| event.kind == EventKind::ClipEnd).count();
    for events in &found {
        assert_eq!((ends(events), events.len()), (1, found[0].len()));
    }
}

/// If inertialization replaces a clip in the middle of a step, the clip's events up to that time
/// are reported.
#[test]
fn inertialized_clip_reports_events_until_its_replacement() {
    assert_ends_once(|scene, member| {
        let clip = scene.clip("walk");
        scene
            .edit(member)
            .queue(clip, ClipPlayback::looping().inertialize_in_secs(0.3))
            .expect("a queued clip");
    });
}

/// If a cut replaces a clip in the middle of a step, the clip's events up to that time are
/// reported.
#[test]
fn cut_clip_reports_events_until_its_replacement() {
    assert_ends_once(|scene, member| {
        for name in ["sway", "walk"] {
            let clip = scene.clip(name);
            scene.edit(member).queue(clip, ClipPlayback::looping()).expect("a queued clip");
        }
    });
}

fn is_marker(event: &Event) -> bool {
    matches!(event.kind, EventKind::Marker { .. })
}

/// A clip that fades out in the middle of a step, and whose slot another takes in the same step,
/// reports its events.
#[test]
fn faded_clip_reports_events_although_its_slot_is_taken() {
    let found = [1.0 / 60.0, 0.1, 1.0].map(|step| {
        let mut scene = native();
        let (walk, sway) = (scene.clip("walk"), scene.clip("sway"));
        scene.crowd.clip_mut(sway).unwrap().add_event_marker("swish", 0.1).unwrap();
        let member = scene.member(Placement::at([0.0; 3]));
        let mut view = scene.edit(member);
        view.subscribe_events();
        view.play(sway, ClipPlayback::looping()).unwrap();
        view.play(walk, ClipPlayback::held_at_secs(0.0).fade_in_secs(0.3)).unwrap();
        view.blend(walk, ClipPlayback::held_at_secs(0.5).after_secs(0.5)).unwrap();
        events(&mut scene, step, 1.0)
    });
    for events in found {
        let markers: Vec<_> = events.iter().filter(|event| is_marker(event)).collect();
        let [marker] = &markers[..] else { panic!("{events:?}") };
        assert!((marker.at_secs - 0.1).abs() < 1e-4, "{marker:?}");
    }
}

/// Members report events in the order in which they subscribed, however many unsubscribe.
#[test]
fn events_at_one_time_are_in_the_order_of_subscriptions() {
    let mut scene = native();
    let sway = scene.clip("sway");
    scene.crowd.clip_mut(sway).unwrap().add_event_marker("swish", 0.5).unwrap();
    let members: Vec<_> = (0..5).map(|_| scene.member(Placement::at([0.0; 3]))).collect();
    for member in &members {
        scene.edit(*member).play(sway, ClipPlayback::looping()).unwrap();
    }
    for nth in [3, 1, 4, 1, 0, 2] {
        scene.edit(members[nth]).subscribe_events();
    }
    for nth in [1, 0] {
        scene.edit(members[nth]).unsubscribe_events();
    }
    scene.edit(members[1]).subscribe_events();
    scene.crowd.despawn(members[4]).unwrap();
    let told = events(&mut scene, 1.0, 1.0).into_iter().filter(is_marker);
    let told: Vec<_> = told.map(|event| event.member).collect();
    assert_eq!(told, [3, 2, 1].map(|nth| members[nth]));
}

/// A blend space that got one of two slots takes the second in the middle of a step. Events from
/// before and after that are reported.
#[test]
fn blend_space_reports_events_around_a_late_slot() {
    let found = [1.0 / 60.0, 0.5, 3.0].map(|step| {
        let builder = Crowd::builder().device(Device::native()).slots_per_member(2);
        let mut crowd = builder.build().expect("a crowd");
        let body = crowd.add_character(fixture::character()).expect("enough capacity");
        let mut scene = Scene { crowd, body };
        let (walk, sway) = (scene.clip("walk"), scene.clip("sway"));
        let space = BlendSpace::line(&[(walk, 0.0), (sway, 1.0)]).expect("a space");
        let space = scene.crowd.add_blend_space(space).expect("a space");
        let member = scene.member(Placement::at([0.0; 3]));
        scene.edit(member).play(sway, ClipPlayback::held_at_secs(0.0)).expect("a clip that plays");
        scene
            .edit(member)
            .play_blend_space(space, 0.4, BlendSpacePlayback::new().fade_in_secs(0.9))
            .expect("a space");
        scene.edit(member).subscribe_events();
        events(&mut scene, step, 3.0)
    });
    assert!(found[0].len() > 4, "{found:?}");
    assert!(found.iter().all(|events| events.len() == found[0].len()), "{found:?}");
}
