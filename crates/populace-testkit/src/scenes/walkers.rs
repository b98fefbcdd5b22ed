//! Bodies with legs and soles, and clips in which they walk and stand.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use populace_model::convert::single;
use populace_model::{ClipSource, Interpolation, Property, Role, Side, Track};

use super::motion::even_times;
use super::{Scene, SceneBody, SceneClip};

/// The length of a walk's cycle.
const CYCLE_SECS: f64 = 1.1;
/// Parts of the cycle at which the left foot touches down and lifts off; the right one does so half
/// a cycle later.
const CONTACT: [f64; 2] = [0.23, 0.8];

/// Times of touchdown and lift-off of a foot in a clip of [`Scene::of_walkers`], in seconds after
/// its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScenePace {
    /// Contacts of the left foot, then of the right.
    pub(crate) contacts: Option<[[f64; 2]; 2]>,
}

/// Returns the rotation of a joint's parent at rest, in model space.
fn parent_rotation(body: &SceneBody, joint: usize) -> DQuat {
    match body.oracle.joints[joint].parent {
        Some(parent) => parent_rotation(body, parent) * body.oracle.rest(parent).rotation,
        None => DQuat::IDENTITY,
    }
}

/// Returns a track that turns a joint about +X of model space, as if its parents were at rest.
fn lean(body: &SceneBody, joint: usize, times: &[f32], angle: impl Fn(f64) -> f64) -> Track {
    let (above, rest) = (parent_rotation(body, joint), body.oracle.rest(joint).rotation);
    let value = |time: &f32| {
        let turned = DQuat::from_rotation_x(angle(f64::from(*time)));
        (above.inverse() * turned * above * rest).normalize().to_array().map(single)
    };
    Track {
        joint: body.joints[joint].name.clone(),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: times.to_vec(),
        values: times.iter().flat_map(value).collect(),
    }
}

/// Returns a track that lifts the hips, in parts of their height.
fn bob(body: &SceneBody, hips: usize, times: &[f32], lift: impl Fn(f64) -> f64) -> Track {
    let (above, rest) = (parent_rotation(body, hips), body.oracle.rest(hips).translation);
    let value = |time: &f32| {
        let up = DVec3::Y * rest.length() * lift(f64::from(*time));
        (rest + above.inverse() * up).to_array().map(single)
    };
    Track {
        joint: body.joints[hips].name.clone(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: times.to_vec(),
        values: times.iter().flat_map(value).collect(),
    }
}

/// Creates a clip in which legs swing by a factor.
fn walk(body: &SceneBody, name: &str, strength: f64) -> ClipSource {
    let times = even_times(0.0, 34, 30.0);
    let joint = |role| body.joint_of(role).expect("a humanoid body");
    let mut tracks = vec![bob(body, joint(Role::Hips), &times, |secs| {
        -0.04 + 0.02 * strength * (2.0 * TAU * secs / CYCLE_SECS).sin()
    })];
    for (side, late) in [(Side::Left, 0.0), (Side::Right, 0.5)] {
        let phase = move |secs: f64| TAU * (secs / CYCLE_SECS + late);
        let thigh = move |secs: f64| -0.15 - 0.45 * strength * phase(secs).sin();
        let knee = move |secs: f64| 0.2 + 0.9 * strength * phase(secs).cos().max(0.0).powi(2);
        let foot = move |secs: f64| -0.8 * (thigh(secs) + knee(secs));
        tracks.push(lean(body, joint(Role::UpperLeg(side)), &times, thigh));
        tracks.push(lean(body, joint(Role::LowerLeg(side)), &times, knee));
        tracks.push(lean(body, joint(Role::Foot(side)), &times, foot));
    }
    ClipSource { name: name.to_owned(), tracks }
}

impl SceneBody {
    /// Returns the joint of a role, in source order.
    pub(crate) fn joint_of(&self, role: Role) -> Option<usize> {
        self.roles.iter().find(|(own, _)| *own == role).map(|(_, joint)| *joint)
    }
}

impl Scene {
    /// Creates three humanoid bodies with soles, and for each a walk, the same walk, and a stand.
    /// The second result says what is known of the contacts of each clip: those of the first walks
    /// and of the stands.
    pub(crate) fn of_walkers() -> (Self, Vec<ScenePace>) {
        let mut scene = Self::of_humanoids().on_soles();
        scene.bodies.remove(2); // its feet do not hang on its legs
        scene.retargets.clear();
        scene.clips.clear();
        let mut paces = Vec::new();
        for (index, body) in scene.bodies.iter().enumerate() {
            let duration = f64::from(even_times(0.0, 34, 30.0)[33]);
            let left = CONTACT.map(|part| part * CYCLE_SECS);
            let steps = [left, left.map(|secs| secs + 0.5 * CYCLE_SECS)];
            let clips = [
                ("walk", 1.0, Some(steps)),
                ("unknown walk", 0.8, None),
                ("stand", 0.05, Some([[0.0, duration]; 2])),
            ];
            for (name, strength, contacts) in clips {
                scene.clips.push(SceneClip::new(walk(body, name, strength), body, index));
                paces.push(ScenePace { contacts });
            }
        }
        (scene, paces)
    }
}
