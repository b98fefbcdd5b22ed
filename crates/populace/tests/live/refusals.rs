//! Poses, playbacks and settings that are refused, and change nothing.

use super::*;

/// Asserts that a live clip whose first pose is `first`, at 5 s, takes another pose and plays.
fn assert_still_plays(scene: &mut Scene, live: ClipId, member: MemberId, first: &[Trs]) {
    scene.crowd.clip_mut(live).expect("a pose").append(5.1, &pose(0.3)).expect("a pose");
    let play = ClipPlayback::live(1e9).fade_in_secs(0.1);
    scene.edit(member).play(live, play).expect("a long delay");
    scene.update(0.2);
    assert_shows(scene, member, &interpolated(first, first, 0.0), 2e-6, "the oldest pose");
}

#[track_caller]
fn assert_refused(result: Result<(), populace::Error>, words: &str) {
    let error = result.expect_err(words).to_string();
    assert!(error.contains(words), "{error}");
}

#[test]
fn bad_poses_are_refused_and_change_nothing() {
    let mut scene = scene(Device::native(), Schedule::Fused);
    let (live, members) = followers(&mut scene, 1.0, &[0.0]);
    let (sway, good) = (scene.clip("sway"), pose(0.0));
    let crowd = &mut scene.crowd;
    let mut bad = |secs: f64, pose: &[Trs], words: &str| {
        let error =
            crowd.clip_mut(live).expect("a clip").append(secs, pose).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    let with = |change: fn(&mut Trs)| {
        let mut pose = good.clone();
        change(&mut pose[3]);
        pose
    };
    bad(f64::NAN, &good, "the time NaN s; it must be finite");
    bad(0.0, &good[1..], "got a pose of 18 joints; its skeleton has 19");
    bad(0.0, &with(|trs| trs.translation[1] = f32::NAN), "for the joint \"");
    bad(0.0, &with(|trs| trs.scale[1] = f32::INFINITY), "numbers must be finite");
    bad(0.0, &with(|trs| trs.rotation = [0.0; 4]), "rotations have a length");
    crowd.clip_mut(live).expect("a pose").append(5.0, &good).expect("a pose");
    let mut bad = |secs: f64, words: &str| {
        let error =
            crowd.clip_mut(live).expect("a clip").append(secs, &good).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    };
    bad(5.0, "a pose at 5 s after one at 5 s");
    bad(4.0, "\"actor\" got a pose at 4 s after one at 5 s; times must increase");
    bad(1e300, "within 1e10 s");
    assert_refused(
        crowd.clip_mut(sway).expect("a clip").append(6.0, &good),
        "\"sway\" is not live",
    );
    assert_refused(
        crowd.clip_mut(live).expect("a clip").append_joints(6.0, &[("hip", good[0])]),
        "did you mean \"hips\"",
    );
    assert_still_plays(&mut scene, live, members[0], &good);
}

#[test]
fn bad_live_playbacks_and_settings_are_refused() {
    let mut scene = scene(Device::native(), Schedule::Fused);
    let (live, members) = followers(&mut scene, 1.0, &[0.0]);
    let (sway, good) = (scene.clip("sway"), pose(0.0));
    let crowd = &mut scene.crowd;
    crowd.clip_mut(live).expect("a pose").append(5.0, &good).expect("a pose");
    for play in [ClipPlayback::looping(), ClipPlayback::once(), ClipPlayback::held_at_secs(0.0)] {
        assert_refused(
            crowd.member_mut(members[0]).and_then(|mut m| m.play(live, play)).map(drop),
            "\"actor\" is live and has neither end nor cycle",
        );
    }
    assert_refused(
        crowd
            .member_mut(members[0])
            .and_then(|mut m| m.play(sway, ClipPlayback::live(0.1)))
            .map(drop),
        "\"sway\" is not live",
    );
    assert_refused(
        crowd
            .member_mut(members[0])
            .and_then(|mut m| m.play(live, ClipPlayback::live(-0.1)))
            .map(drop),
        "the delay of a live clip",
    );
    let space = populace::BlendSpace::line(&[(live, 0.0), (sway, 1.0)]).expect("points");
    assert_refused(crowd.add_blend_space(space).map(drop), "has the live clip \"actor\"");
    for (rows_per_sec, secs) in
        [(0.5, 1.0), (f32::NAN, 1.0), (30.0, 0.0), (30.0, f32::NAN), (1000.0, 1e9)]
    {
        let bad = LiveSettings { rows_per_sec, secs, ..LiveSettings::default() };
        assert_refused(
            crowd.character_mut(scene.body).expect("a body").add_live_clip("bad", &bad).map(drop),
            "the clip \"bad\" ",
        );
    }
    assert_still_plays(&mut scene, live, members[0], &good);
}
