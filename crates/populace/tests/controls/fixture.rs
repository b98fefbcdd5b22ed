//! A humanoid of 1.8 m with rotated joint axes, its clips, and crowds of it.

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::math::{quat, vec3};
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{Affine, Crowd, Device, JointIndex, MemberId, MemberMut, Placement, Schedule, Trs};

/// Joints: name, parent, and rest position in model space, in metres.
const JOINTS: &[(&str, Option<usize>, [f32; 3])] = &[
    ("root", None, [0.0, 0.0, 0.0]),
    ("hips", Some(0), [0.0, 0.98, 0.0]),
    ("spine", Some(1), [0.0, 1.10, -0.01]),
    ("chest", Some(2), [0.0, 1.28, -0.02]),
    ("neck", Some(3), [0.0, 1.50, -0.01]),
    ("head", Some(4), [0.0, 1.60, 0.02]),
    ("leftEye", Some(5), [0.03, 1.68, 0.10]),
    ("rightEye", Some(5), [-0.03, 1.68, 0.10]),
    ("leftShoulder", Some(3), [0.04, 1.44, 0.0]),
    ("leftUpperArm", Some(8), [0.18, 1.45, 0.0]),
    ("leftTwist", Some(9), [0.32, 1.45, -0.004]),
    ("leftLowerArm", Some(10), [0.47, 1.45, -0.01]),
    ("leftHand", Some(11), [0.73, 1.45, 0.0]),
    ("leftUpperLeg", Some(1), [0.10, 0.93, 0.0]),
    ("leftLowerLeg", Some(13), [0.11, 0.51, 0.015]),
    ("leftFoot", Some(14), [0.11, 0.08, -0.02]),
    ("rightUpperLeg", Some(1), [-0.10, 0.93, 0.0]),
    ("rightLowerLeg", Some(16), [-0.11, 0.51, 0.015]),
    ("rightFoot", Some(17), [-0.11, 0.08, -0.02]),
];

/// Returns the rest rotation of a joint in model space. Each joint has different axes, so that no
/// test passes only because axes are upright.
pub(crate) fn axes(joint: usize) -> [f32; 4] {
    let x = joint as f32;
    let v = [(x * 1.7).sin(), (x * 2.3).cos(), (x * 0.9).sin(), 0.4 + (x * 1.1).cos()];
    let length = quat::dot(v, v).sqrt();
    if joint == 0 { quat::identity() } else { v.map(|c| c / length) }
}

/// Returns the rest position of a joint, by its index in [`JOINTS`], in model space.
pub(crate) fn rest_position(joint: usize) -> [f32; 3] {
    JOINTS[joint].2
}

pub(crate) fn skeleton() -> Skeleton {
    let joints: Vec<_> = JOINTS
        .iter()
        .enumerate()
        .map(|(index, &(name, parent, position))| {
            let (parent_from_model, from) = match parent {
                Some(parent) => (quat::conjugate(axes(parent)), JOINTS[parent].2),
                None => (quat::identity(), [0.0; 3]),
            };
            let rest = Trs {
                translation: vec3::rotated(parent_from_model, vec3::sub(position, from)),
                rotation: quat::mul(parent_from_model, axes(index)),
                scale: [1.0; 3],
            };
            JointSource { name: name.into(), parent, rest }
        })
        .collect();
    Skeleton::new(&joints).expect("valid joints")
}

/// Finds a joint by its name.
pub(crate) fn joint(name: &str) -> JointIndex {
    skeleton().find(name).expect("a joint of that name")
}

/// A clip that swings joints back and forth. Each entry of `turns` gives the joint's name, the axis
/// in model space, the amplitude in radians and the phase in cycles.
pub(crate) fn swing(name: &str, secs: f32, turns: &[(&str, [f32; 3], f32, f32)]) -> ClipSource {
    const KEYS: usize = 33;
    let skeleton = skeleton();
    let track = |&(name, axis, amplitude, phase): &(&str, [f32; 3], f32, f32)| {
        let joint = skeleton.find(name).expect("a joint of that name");
        let rest = skeleton.rest(joint).rotation;
        let parent = skeleton
            .parent(joint)
            .map_or(quat::identity(), |p| axes(skeleton.source_from_joint(p)));
        let axis = vec3::rotated(quat::conjugate(parent), axis);
        let times = (0..KEYS).map(|key| key as f32 / (KEYS - 1) as f32 * secs);
        let value = |key: usize| {
            let cycle = key as f32 / (KEYS - 1) as f32 + phase;
            let half = 0.5 * amplitude * (cycle * std::f32::consts::TAU).sin();
            let [x, y, z] = axis.map(|c| c * half.sin());
            quat::mul([x, y, z, half.cos()], rest)
        };
        Track {
            joint: name.into(),
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times: times.collect(),
            values: (0..KEYS).flat_map(value).collect(),
        }
    };
    ClipSource { name: name.into(), tracks: turns.iter().map(track).collect() }
}

/// The humanoid with its clips.
pub(crate) fn character() -> Character {
    let skeleton = skeleton();
    let side = [0.0, 0.0, 1.0];
    let across = [1.0, 0.0, 0.0];
    let up = [0.0, 1.0, 0.0];
    let sources = [
        // Hanging arms and a swaying head and back, as input of the constraints.
        swing(
            "sway",
            2.0,
            &[
                ("leftUpperArm", side, -1.2, 0.25),
                ("leftLowerArm", up, 0.5, 0.2),
                ("spine", up, 0.2, 0.0),
                ("chest", side, 0.1, 0.3),
                ("head", across, 0.3, 0.1),
                ("leftUpperLeg", across, 0.3, 0.0),
                ("leftLowerLeg", across, 0.3, 0.25),
            ],
        ),
        swing(
            "walk",
            1.0,
            &[
                ("leftUpperLeg", across, 0.45, 0.0),
                ("rightUpperLeg", across, 0.45, 0.5),
                ("leftLowerLeg", across, 0.5, 0.2),
                ("rightLowerLeg", across, 0.5, 0.7),
            ],
        ),
        swing("stand", 1.0, &[("head", across, 0.1, 0.0)]),
    ];
    let clips =
        sources.map(|source| Arc::new(Clip::new(source, &skeleton).expect("a good clip"))).to_vec();
    bare("body", skeleton, clips)
}

/// A character without meshes, and a palette entry for each joint.
pub(crate) fn bare(name: &str, skeleton: Skeleton, clips: Vec<Arc<Clip>>) -> Character {
    let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
    let palette = skeleton.joints().map(entry).collect();
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let name = name.into();
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts,
        materials,
        images,
        skins,
        clips,
    })
    .expect("a good character")
}

/// The humanoid with soles: each foot is 0.25 m long and touches the ground along its whole length.
pub(crate) fn with_soles() -> Character {
    let plain = character();
    let mut soles = vec![Vec::new(); plain.skeleton.joint_count()];
    for name in ["leftFoot", "rightFoot"] {
        let [x, _, z] = rest_position(plain.skeleton.source_from_joint(joint(name)));
        soles[joint(name).index()] = [-0.06, 0.12, 0.19].map(|along| [x, 0.0, z + along]).to_vec();
    }
    let source = CharacterSource::clone(&plain);
    let skeleton = source.skeleton.clone().with_soles(&soles);
    Character::new(CharacterSource { skeleton, ..source }).expect("a good character")
}

/// A crowd with the humanoid on one device.
pub(crate) struct Scene {
    pub(crate) crowd: Crowd,
    pub(crate) body: populace::CharacterId,
}

impl Scene {
    pub(crate) fn member(&mut self, placement: Placement) -> MemberId {
        self.crowd.spawn(self.body, placement).expect("enough capacity")
    }

    /// Returns mutable access to a member.
    pub(crate) fn edit(&mut self, member: MemberId) -> MemberMut<'_> {
        self.crowd.member_mut(member).expect("a member")
    }

    /// Returns the model-space transforms of all joints.
    pub(crate) fn models(&mut self, member: MemberId) -> Vec<Affine> {
        self.edit(member).model_from_joints().expect("joints that can be read")
    }

    /// Returns the position of a joint in model space.
    pub(crate) fn position(&mut self, member: MemberId, name: &str) -> [f32; 3] {
        self.models(member)[joint(name).index()].origin()
    }

    pub(crate) fn update(&mut self, secs: f32) {
        self.crowd.update(secs).expect("a frame");
    }

    pub(crate) fn clip(&self, name: &str) -> populace::ClipId {
        self.crowd.clip(self.body, name).expect("a clip of that name")
    }
}

/// Runs a check on every device and schedule.
pub(crate) fn everywhere(check: impl Fn(&mut Scene)) {
    for schedule in [Schedule::Staged, Schedule::Fused] {
        check(&mut scene(Device::native(), schedule));
    }
    #[cfg(all(feature = "opencl", not(skip_opencl)))]
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        check(&mut scene(Device::opencl(0), schedule));
    }
}

pub(crate) fn scene(device: Device, schedule: Schedule) -> Scene {
    let mut crowd =
        Crowd::builder().device(device).schedule(schedule).capacity(640).build().expect("a crowd");
    let body = crowd.add_character(character()).expect("enough capacity");
    Scene { crowd, body }
}

pub(crate) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    vec3::length(vec3::sub(a, b))
}

/// Returns the angle in degrees between the axes of two transforms.
pub(crate) fn turn_deg(a: &Affine, b: &Affine) -> f32 {
    let column =
        |m: &Affine, c: usize| vec3::unit_or([m.rows[0][c], m.rows[1][c], m.rows[2][c]], [0.0; 3]);
    let trace: f32 = (0..3).map(|c| vec3::dot(column(a, c), column(b, c))).sum();
    // The arc cosine is too coarse for small angles, so those come from the length of the
    // difference.
    let apart: f32 = (0..3)
        .map(|c| {
            vec3::dot(vec3::sub(column(a, c), column(b, c)), vec3::sub(column(a, c), column(b, c)))
        })
        .sum();
    if trace > 2.9 {
        (apart / 2.0).sqrt().to_degrees()
    } else {
        ((trace - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
    }
}
