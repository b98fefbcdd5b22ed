//! The characters, clips and devices of the sequences.

use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

use glam::DQuat;
use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::{Clip, MotionSettings};
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{Affine, Device, Devices, Schedule, StageJoint, Trs, UserStage};
use populace_cast::{Look, person};

/// Creates a body of `joints` joints in a chain with branches at joint 2 and its root on the
/// ground. Its first `entries` joints have a palette entry. Of its three clips, one rotates all
/// joints, one moves the root and scales joint 1, and one has a duration of 0.
pub(crate) fn chain(name: &str, joints: usize, entries: usize) -> Character {
    let joint = |index: usize| JointSource {
        name: format!("{name} {index}"),
        parent: match index {
            0 => None,
            5 | 9 => Some(2),
            _ => Some(index - 1),
        },
        rest: Trs { translation: [0.0, 0.2, 0.01 * index as f32], ..Trs::IDENTITY },
    };
    let skeleton =
        Skeleton::new(&(0..joints).map(joint).collect::<Vec<_>>()).expect("a valid skeleton");
    let clips =
        [rotating(name, joints, &skeleton), moving(name, &skeleton), instant(name, &skeleton)];
    let palette = skeleton.joints().take(entries);
    let palette =
        palette.map(|joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY }).collect();
    Character::new(CharacterSource {
        name: name.into(),
        skeleton,
        palette,
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips: clips.into_iter().map(Arc::new).collect(),
    })
    .expect("a valid character")
}

fn track(joint: String, property: Property, times: &[f32], values: Vec<f32>) -> Track {
    Track { joint, property, interpolation: Interpolation::Linear, times: times.to_vec(), values }
}

/// Creates a clip that rotates all joints.
pub(crate) fn rotating(name: &str, joints: usize, skeleton: &Skeleton) -> Clip {
    let rotation = |joint: usize| {
        let times = [0.0, 0.3, 0.7, 1.1];
        let values = times.iter().flat_map(|secs| {
            let half = 0.4 * f64::sin(f64::from(*secs) / 1.1 * TAU + joint as f64);
            let rotation = if joint.is_multiple_of(2) {
                DQuat::from_rotation_x(2.0 * half)
            } else {
                DQuat::from_rotation_z(2.0 * half)
            };
            rotation.as_quat().to_array()
        });
        track(format!("{name} {joint}"), Property::Rotation, &times, values.collect())
    };
    let source = ClipSource { name: "turn".into(), tracks: (0..joints).map(rotation).collect() };
    Clip::new(source, skeleton).expect("a valid clip")
}

fn moving(name: &str, skeleton: &Skeleton) -> Clip {
    let times = [0.0, 0.8];
    let root = vec![0.0, 0.2, 0.0, 0.1, 0.3, 1.0];
    let scale = vec![1.0, 1.0, 1.0, 1.2, 0.8, 1.0];
    let tracks = vec![
        track(format!("{name} 0"), Property::Translation, &times, root),
        track(format!("{name} 1"), Property::Scale, &times, scale),
    ];
    let clip =
        Clip::new(ClipSource { name: "move".into(), tracks }, skeleton).expect("a valid clip");
    clip.with_root_motion(&MotionSettings::default()).expect("a root that travels")
}

fn instant(name: &str, skeleton: &Skeleton) -> Clip {
    let values = vec![0.5, 0.0, 0.0, 0.866_025_4];
    let tracks = vec![track(format!("{name} 1"), Property::Rotation, &[0.0], values)];
    Clip::new(ClipSource { name: "instant".into(), tracks }, skeleton).expect("a valid clip")
}

/// Returns all characters: a short chain, a chain of more than a block of joints, a person, and a
/// chain without palette.
pub(crate) fn characters() -> &'static [Arc<Character>] {
    static ALL: OnceLock<[Arc<Character>; 4]> = OnceLock::new();
    ALL.get_or_init(|| {
        let person = person(&Look::man()).expect("a person");
        [chain("arm", 4, 4), chain("snake", 21, 15), person, chain("ghost", 5, 0)].map(Arc::new)
    })
}

fn lift(joint: &mut StageJoint) {
    joint.model.rows[1][3] += joint.parameters[0] + joint.values[1];
}

fn stretch(joint: &mut StageJoint) {
    joint.local.translation[1] += joint.parameters[1] * joint.values[0];
}

/// Creates two user stages: one after Transform, one after Pose.
pub(crate) fn stages() -> [UserStage; 2] {
    let lifts =
        "void lift(StageJoint *joint) { joint->row1.w += joint->parameters[0] + joint->values.y; }";
    let stretches = "void stretch(StageJoint *joint) { joint->translation.y += \
                     joint->parameters[1] * joint->values.x; }";
    [
        UserStage::new("lift").opencl_c(lifts).rust(lift),
        UserStage::new("stretch").opencl_c(stretches).rust(stretch),
    ]
}

/// The devices and the schedule that a sequence runs on.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) name: String,
    /// Devices that `move_to` cycles through, beginning with the first.
    pub(crate) devices: Vec<Devices>,
    pub(crate) schedule: Schedule,
    pub(crate) needs_opencl: bool,
    /// Whether user stages are added. OpenCL compilers take seconds for each set of stages.
    pub(crate) has_stages: bool,
}

fn setup(devices: &[Devices], schedule: Schedule) -> Setup {
    let names: Vec<String> = devices.iter().map(ToString::to_string).collect();
    let needs_opencl = names.iter().any(|name| name.contains("opencl"));
    Setup {
        name: format!("{}/{schedule}", names[0]),
        devices: devices.to_vec(),
        schedule,
        needs_opencl,
        has_stages: !needs_opencl,
    }
}

/// Returns the set-ups of the two crowds of a soak, which have no devices in common.
pub(crate) fn soak_setups() -> [Setup; 2] {
    let native = |threads| Devices::from(Device::Native { threads });
    let opencl = Devices::from(Device::opencl(0));
    let both = Devices::from([Device::Native { threads: 1 }, Device::opencl(0)]);
    let others: &[Devices] = if cfg!(skip_opencl) { &[native(1)] } else { &[opencl, both] };
    [setup(&[native(2)], Schedule::Fused), setup(others, Schedule::Fused)]
}

/// Returns set-ups for every device and schedule, and for two devices that share a crowd.
pub(crate) fn setups() -> Vec<Setup> {
    let one = || Devices::from(Device::Native { threads: 1 });
    let two = || Devices::from(Device::Native { threads: 2 });
    let opencl = || Devices::from(Device::opencl(0));
    let both = || Devices::from([Device::Native { threads: 1 }, Device::opencl(0)]);
    let pair = || Devices::from([Device::Native { threads: 1 }, Device::Native { threads: 2 }]);
    vec![
        setup(&[one(), two()], Schedule::Fused),
        setup(&[one(), two()], Schedule::Staged),
        setup(&[pair(), one()], Schedule::Fused),
        setup(&[opencl()], Schedule::Staged),
        setup(&[opencl()], Schedule::FusedWide),
        setup(&[opencl()], Schedule::FusedGrouped),
        setup(&[both(), opencl(), one()], Schedule::Fused),
    ]
}
