use std::f32::consts::{PI, TAU};
use std::sync::{Arc, Mutex};

use glam::Quat;
use populace::Device;
use populace::interop::Visibility;
use populace_cast::Look;

use super::*;

/// The time from frame to frame in seconds.
const FRAME_SECS: f64 = 1.0 / 30.0;

fn seen() -> Seen {
    Seen { size: [64, 64], ..Seen::default() }
}

/// A show that notes how it is advanced.
#[derive(Default)]
struct Noted {
    floor_m: f32,
    steps: Arc<Mutex<Vec<f32>>>,
    rewinds: Arc<Mutex<u32>>,
    leads_members: bool,
    /// Turn of the camera from +Z to +X, in radians in a second; and how far it has turned.
    turn_rad_per_sec: f32,
    turn_rad: f32,
    /// The member that it moves, and where to.
    moved: Arc<Mutex<Option<(MemberId, Placement)>>>,
}

impl Show for Noted {
    fn title(&self) -> String {
        "noted".into()
    }

    fn rate(&self) -> FrameRate {
        FrameRate::new(30, 1).expect("a rate")
    }

    fn length_secs(&self) -> Option<f64> {
        None
    }

    fn scene(&self) -> Scene {
        Scene::default()
    }

    fn floor_m(&self) -> f32 {
        self.floor_m
    }

    fn detail_px(&self) -> Option<f32> {
        (self.turn_rad_per_sec != 0.0).then_some(1.0)
    }

    fn set_aspect(&mut self, _aspect: f32) -> Result<(), ShowError> {
        Ok(())
    }

    fn camera(&self, _secs: f64) -> Result<Camera, ShowError> {
        let target = Vec3::Y + Quat::from_rotation_y(self.turn_rad) * Vec3::Z;
        Ok(Camera { eye: [0.0, 1.0, 0.0], target: target.to_array(), ..Camera::default() })
    }

    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, ShowError> {
        self.steps.lock().expect("the steps").push(secs);
        if let Some((member, to)) = *self.moved.lock().expect("a move") {
            crowd.member_mut(member)?.set_placement(to)?;
        }
        self.turn_rad += self.turn_rad_per_sec * secs;
        Ok(secs)
    }

    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), ShowError> {
        Ok(crowd.update(secs)?)
    }

    fn rewind(&mut self) {
        *self.rewinds.lock().expect("the count") += 1;
    }

    fn person(&self, _member: MemberId) -> Option<u64> {
        None
    }

    fn leads_members(&self) -> bool {
        self.leads_members
    }
}

/// Opens a show with two people who stand on its floor.
fn open(show: Noted) -> (Stage, [MemberId; 2]) {
    let mut crowd = Crowd::builder().device(Device::native()).build().expect("a crowd");
    let man = populace_cast::person(&Look::man()).expect("a person");
    let man = crowd.add_character(man).expect("a character");
    let floor_m = show.floor_m;
    let members = [0.0, 3.0]
        .map(|x| crowd.spawn(man, Placement::at([x, floor_m, 0.0])).expect("room for a member"));
    let opened = Opened { crowd, show: Box::new(show) };
    (Stage::new(opened, &mut seen()).expect("a stage"), members)
}

/// Plays for a time in seconds, in steps as long as pictures take on some machine.
fn play(stage: &mut Stage, secs: f64) {
    let end_secs = stage.secs() + secs;
    while stage.secs() < end_secs {
        stage.play(0.0217, Steering::default(), &mut seen()).expect("a step");
    }
}

fn seek(stage: &mut Stage, secs: f64) {
    stage.seek(secs).expect("a time");
    while !stage.replay(&mut seen()).expect("a replay") {}
}

#[test]
fn going_on_from_real_time_keeps_what_people_did() {
    let show = Noted::default();
    let (steps, rewinds) = (show.steps.clone(), show.rewinds.clone());
    let (mut stage, [falling, driven]) = open(show);
    play(&mut stage, 0.2);
    stage.falls.fall(&stage.crowd, falling, [0.0, 1.0]).expect("a fall");
    stage.drive(driven).expect("a driven member");
    play(&mut stage, 0.3);
    let next_secs = stage.neighbour_secs(true);
    assert!(next_secs - stage.secs() < FRAME_SECS - 1e-3, "the time is between two frames");

    steps.lock().expect("the steps").clear();
    seek(&mut stage, next_secs);
    assert_eq!(stage.secs(), next_secs);
    assert_eq!(steps.lock().expect("the steps").len(), 1, "one step leads to the next frame");
    seek(&mut stage, next_secs + 10.5 * FRAME_SECS);
    let taken = std::mem::take(&mut *steps.lock().expect("the steps"));
    assert_eq!(taken.len(), 12, "from frame to frame, and half a frame: {taken:?}");
    let longest = taken.iter().copied().fold(0.0, f32::max);
    assert!(f64::from(longest) < FRAME_SECS + 1e-6, "a step of {longest} s");
    assert!(stage.falls.is_down(falling));
    assert_eq!(stage.you(), Some(driven));
    assert_eq!(*rewinds.lock().expect("the count"), 0);

    let before_secs = stage.neighbour_secs(false);
    seek(&mut stage, before_secs);
    assert_eq!((stage.secs(), stage.you()), (before_secs, None));
    assert!(!stage.falls.is_down(falling), "going back undoes the fall");
    assert_eq!(*rewinds.lock().expect("the count"), 1);
}

/// Returns the height of the highest joint of a member above 0 in metres.
fn top_m(stage: &mut Stage, member: MemberId) -> f32 {
    let mut view = stage.crowd.member_mut(member).expect("a member");
    let joints = view.model_from_joints().expect("its joints");
    let at_m = view.placement().position()[1];
    joints.iter().map(|joint| at_m + joint.transform_point([0.0; 3])[1]).fold(f32::MIN, f32::max)
}

#[test]
fn who_falls_lies_on_the_floor_of_the_show() {
    for floor_m in [-3.0, 2.0] {
        let (mut stage, [member, _]) = open(Noted { floor_m, ..Noted::default() });
        for again in ["first", "rewound"] {
            let (mut lowest_m, mut highest_m) = (f32::MAX, f32::MIN);
            stage.falls.fall(&stage.crowd, member, [0.0, 1.0]).expect("a fall");
            for _ in 0..150 {
                play(&mut stage, 0.02);
                let top_m = top_m(&mut stage, member) - floor_m;
                (lowest_m, highest_m) = (lowest_m.min(top_m), highest_m.max(top_m));
            }
            let heights = format!("{again}, floor at {floor_m} m: {lowest_m} to {highest_m} m");
            assert!(highest_m < 1.9, "nobody is flung up; {heights}");
            assert!((0.1..0.8).contains(&lowest_m), "who lies is on the floor; {heights}");
            stage.rewind().expect("a beginning");
            seek(&mut stage, 0.0);
        }
    }
}

/// Plays for a time in seconds while the driven member is sent forwards.
fn walk(stage: &mut Stage, secs: f64) {
    let end_secs = stage.secs() + secs;
    while stage.secs() < end_secs {
        let forward = Steering { forward: 1.0, ..Steering::default() };
        stage.play(0.0217, forward, &mut seen()).expect("a step");
    }
}

#[test]
fn members_are_hidden_by_the_camera_of_their_frame() {
    let (mut stage, members) = open(Noted { turn_rad_per_sec: 20.0, ..Noted::default() });
    // In the middle of the picture before the step, and of that after it.
    for (member, turn_rad) in members.into_iter().zip([0.0, 0.6]) {
        let at = Quat::from_rotation_y(turn_rad) * Vec3::new(0.0, 0.0, 20.0);
        let mut member = stage.crowd.member_mut(member).expect("a member");
        member.set_placement(Placement::at(at.to_array())).expect("a place");
    }
    stage.play(0.03, Steering::default(), &mut seen()).expect("a step");
    assert_eq!(members.map(|member| is_in_view(&stage, member)), [false, true]);
}

fn is_in_view(stage: &Stage, member: MemberId) -> bool {
    let member = stage.crowd.member(member).expect("a member");
    member.instance().visibility == Visibility::InView
}

/// The camera cuts to a member that is far away.
#[test]
fn members_are_hidden_by_the_camera_that_follows_in_their_frame() {
    let show = Noted { turn_rad_per_sec: 1e-3, ..Noted::default() };
    let moved = show.moved.clone();
    let (mut stage, [followed, passed]) = open(show);
    let at = Placement::at([0.0, 0.0, 1.0]);
    stage.crowd.member_mut(passed).expect("a member").set_placement(at).expect("a place");
    let mut seen = Seen { member: Some(followed), ..seen() };
    let here = stage.followed(followed).expect("a member");
    seen.rig.begin_to_follow(&here, &stage.shown_camera().expect("a camera"));
    for (to, wanted) in [(0.0, true), (500.0, false)] {
        let to = Placement::at([to, 0.0, 0.0]);
        *moved.lock().expect("a move") = Some((followed, to));
        seen.secs = 0.03;
        stage.play(0.03, Steering::default(), &mut seen).expect("a step");
        assert_eq!([followed, passed].map(|member| is_in_view(&stage, member)), [true, wanted]);
    }
}

#[test]
fn a_visitor_is_driven_again() {
    let (mut stage, [member, _]) = open(Noted { leads_members: true, ..Noted::default() });
    let visitor = stage.drive(member).expect("a visitor");
    assert_ne!(visitor, member);
    stage.leave();
    assert_eq!(stage.drive(visitor).expect("the visitor"), visitor);
    assert_eq!(stage.crowd.member_count(), 3);
    stage.rewind().expect("a beginning");
    seek(&mut stage, 0.0);
    assert_eq!(stage.crowd.member_count(), 2);
    stage.drive(member).expect("another visitor");
    assert_eq!(stage.crowd.member_count(), 3);
}

#[test]
fn who_cannot_be_driven_leaves_the_driven_member_alone() {
    let (mut stage, [member, other]) = open(Noted::default());
    stage.crowd.despawn(other).expect("a member");
    stage.drive(member).expect("a driven member");
    assert!(stage.drive(other).is_err());
    assert_eq!(stage.you(), Some(member));
}

#[test]
fn who_is_let_go_while_walking_comes_to_stand() {
    let (mut stage, [member, other]) = open(Noted::default());
    stage.drive(member).expect("a driven member");
    play(&mut stage, 0.5);
    let shown = |stage: &Stage| {
        let clips = stage.crowd.member(member).expect("a member").active_clips();
        clips.iter().filter(|c| c.weight > 0.01).map(|c| c.clip).collect::<Vec<_>>()
    };
    let standing = shown(&stage);
    for next in [None, Some(other)] {
        walk(&mut stage, 1.0);
        assert_ne!(shown(&stage), standing);
        match next {
            None => stage.leave(),
            Some(next) => _ = stage.drive(next).expect("another member"),
        }
        play(&mut stage, 5.0);
        assert_eq!(shown(&stage), standing, "then {next:?}");
        if next.is_none() {
            stage.drive(member).expect("the member again");
        }
    }
}

#[test]
fn who_gets_up_stands_where_the_body_came_to_lie() {
    let (mut stage, [member, _]) = open(Noted::default());
    stage.drive(member).expect("a driven member");
    walk(&mut stage, 1.0);
    stage.falls.fall(&stage.crowd, member, [0.8, 0.6]).expect("a fall");
    play(&mut stage, 2.0);
    let Stage { falls, crowd, .. } = &mut stage;
    falls.get_up(crowd, member).expect("a way up");
    let mut last = stage.placement(member).expect("a placement");
    while stage.falls.is_down(member) {
        last = stage.placement(member).expect("a placement");
        play(&mut stage, 0.02);
    }
    play(&mut stage, 0.1);
    let now = stage.placement(member).expect("a placement");
    let moved_m = Vec3::from(now.position()).distance(Vec3::from(last.position()));
    assert!(moved_m < 0.1, "it jumped by {moved_m} m");
    let turned_rad = (now.yaw_rad() - last.yaw_rad() + PI).rem_euclid(TAU) - PI;
    assert!(turned_rad.abs() < 0.1, "it turned by {turned_rad} rad");
}

#[test]
fn masks_are_made_anew_after_going_back() {
    let (mut stage, [member, _]) = open(Noted::default());
    let character = stage.crowd.member(member).expect("a member").character();
    for role in [Role::Spine, Role::Head] {
        let mask = stage.mask(character, role);
        assert!(mask.is_some());
        assert_eq!(stage.mask(character, role), mask, "once each");
        let mut view = stage.crowd.member_mut(member).expect("a member");
        view.set_layer(1, populace::LayerSettings::default(), mask).expect("a layer");
    }
    play(&mut stage, 0.1);
    assert!(stage.seek(0.0).expect("a time"));
    assert!(!stage.seek(0.0).expect("a time"), "it is there already");
    let mask = stage.mask(character, Role::Head);
    let mut view = stage.crowd.member_mut(member).expect("a member");
    view.set_layer(1, populace::LayerSettings::default(), mask).expect("the mask is known");
}
