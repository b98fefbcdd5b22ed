//! Bindings of clips to characters: reports, refusals, and partial bindings on request.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{
    Affine, BindingMethod, BlendSpace, BlendSpacePlayback, ClipPlayback, Crowd, Device, JointIndex,
    MachinePlayback, Placement, StateMachine, StatePlayback, Trs,
};

/// A chain of joints, each rotated by an angle against its parent.
fn skeleton(names: &[&str], turn_rad: f32) -> Skeleton {
    let rotation = [(0.5 * turn_rad).sin(), 0.0, 0.0, (0.5 * turn_rad).cos()];
    let joint = |(nth, name): (usize, &&str)| JointSource {
        name: (*name).into(),
        parent: nth.checked_sub(1),
        rest: Trs { translation: [0.0, 0.5, 0.0], rotation, ..Trs::IDENTITY },
    };
    Skeleton::new(&names.iter().enumerate().map(joint).collect::<Vec<_>>()).unwrap()
}

/// A clip that rotates some joints of a skeleton.
fn clip(name: &str, skeleton: &Skeleton, joints: &[&str]) -> Arc<Clip> {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let track = |joint: &&str| Track {
        joint: (*joint).into(),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 1.0, half, 0.0, 0.0, half],
    };
    let tracks = joints.iter().map(track).collect();
    Arc::new(Clip::new(ClipSource { name: name.into(), tracks }, skeleton).unwrap())
}

const BODY: [&str; 4] = ["root", "middle", "top", "tip"];
/// Joint names of which one of seven is also a joint of the character.
const OTHER: [&str; 7] = ["root", "a", "b", "c", "d", "e", "f"];

fn post() -> Character {
    let entry =
        |joint| PaletteEntry { joint: JointIndex(joint), joint_from_bind: Affine::IDENTITY };
    let skeleton = skeleton(&BODY, 0.0);
    Character::new(CharacterSource {
        name: "post".into(),
        palette: (0..4).map(entry).collect(),
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips: vec![clip("Own", &skeleton, &BODY)],
        skeleton,
    })
    .unwrap()
}

#[test]
fn binding_reports_bound_joints_and_rest_differences() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(post()).unwrap();
    let own = crowd.clip(id, "Own").unwrap();
    let mut report_of = |clip: &Arc<Clip>| {
        let clip = crowd.character_mut(id).unwrap().add_clip(clip).unwrap();
        let report = crowd.character(id).unwrap().binding(clip).unwrap();
        (
            report.method,
            report.bound_joints,
            report.moving_joints,
            report.rest_angle_rad,
            report.rest_shift,
        )
    };
    assert_eq!(
        report_of(&clip("Stray", &skeleton(&OTHER, 0.0), &OTHER)),
        (BindingMethod::Names, 1, 7, 0.0, 0.0)
    );
    // A clip that moves only the tip of a skeleton with the same rest pose binds fully.
    let tip = clip("Tip", &skeleton(&BODY, 0.0), &["tip"]);
    assert_eq!(report_of(&tip), (BindingMethod::SameRest, 1, 1, 0.0, 0.0));
    let (method, bound, moving, turned, shift) =
        report_of(&clip("Turned", &skeleton(&BODY, 0.5), &BODY));
    assert_eq!((method, bound, moving, shift), (BindingMethod::Names, 4, 4, 0.0));
    assert!((turned - 0.5).abs() < 1e-3, "{turned}");
    let report = crowd.character(id).unwrap().binding(own).unwrap();
    assert_eq!((report.method, report.share()), (BindingMethod::SameRest, 1.0));
}

#[test]
fn clip_with_one_matching_joint_name_plays_only_on_request() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(post()).unwrap();
    let stray = crowd
        .character_mut(id)
        .unwrap()
        .add_clip(&clip("Stray", &skeleton(&OTHER, 0.0), &OTHER))
        .unwrap();
    let own = crowd.clip(id, "Own").unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    let machine = |play: StatePlayback| StateMachine::new().state("stray", stray, play);
    for requested in [false, true, false] {
        let (play, state, blended) = if requested {
            (
                ClipPlayback::looping().partial(),
                StatePlayback::looping().partial(),
                BlendSpacePlayback::new().partial(),
            )
        } else {
            (ClipPlayback::looping(), StatePlayback::looping(), BlendSpacePlayback::new())
        };
        let space =
            crowd.add_blend_space(BlendSpace::line(&[(own, 0.0), (stray, 1.0)]).unwrap()).unwrap();
        let machine = crowd.add_machine(&machine(state)).unwrap();
        let results = [
            crowd
                .member_mut(member)
                .and_then(|mut m| m.play_machine(machine, MachinePlayback::new()))
                .map(|_| ()),
            crowd.member_mut(member).and_then(|mut m| m.play_blend_space(space, 0.5, blended)),
            crowd.member_mut(member).and_then(|mut m| m.play(stray, play)).map(|_| ()),
        ];
        for result in results {
            match result {
                Ok(()) => assert!(requested, "a partial binding played without a request"),
                Err(error) => {
                    let text = error.to_string();
                    assert!(!requested && text.contains("only 1 of the 7 joints"), "{text}");
                }
            }
        }
    }
    crowd.update(0.5).unwrap();
    assert_eq!(crowd.member(member).unwrap().active_clips()[0].clip, stray);
}
