//! An arm of four joints, its clips, and measurements of its poses.

use std::sync::Arc;

use glam::{DQuat, Quat};
use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::{
    ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track,
};
use populace::{Affine, CharacterId, ClipId, Crowd, CrowdBuilder, MemberId, Placement, Trs};

/// Joints of the arm. "joint 0" is the root; each other joint is the child of the one before it.
pub(crate) const JOINTS: usize = 4;

/// A clip that rotates each joint about its own axis.
pub(crate) struct Motion {
    pub(crate) name: &'static str,
    pub(crate) duration_secs: f32,
    /// For each joint: the axis, and the angles in radians at evenly spaced keys.
    pub(crate) rotations: [([f32; 3], Vec<f32>); JOINTS],
}

/// Returns four clips that rotate all joints. `angle` takes the joint counted from 1, the clip
/// counted from 0 and a phase in radians, and returns radians.
pub(crate) fn moving(keys: u8, angle: impl Fn(f32, f32, f32) -> f32) -> Vec<Motion> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.2], [0.3, 0.0, 1.0], [1.0, 1.0, 0.0]];
    let motion = |nth: f32, name| {
        let mut joint = 0.0;
        let rotations = axes.map(|axis| {
            joint += 1.0;
            let phase = |key: u8| f32::from(key) / f32::from(keys) * std::f32::consts::TAU;
            (axis, (0..=keys).map(|key| angle(joint, nth, phase(key))).collect())
        });
        Motion { name, duration_secs: 1.0 + nth * 0.5, rotations }
    };
    [(0.0, "a"), (1.0, "b"), (2.0, "c"), (3.0, "d")].map(|(nth, name)| motion(nth, name)).into()
}

pub(crate) fn skeleton() -> Skeleton {
    let joint = |index: usize| JointSource {
        name: format!("joint {index}"),
        parent: index.checked_sub(1),
        rest: Trs { translation: [0.0, 0.5, 0.0], ..Trs::IDENTITY },
    };
    Skeleton::new(&(0..JOINTS).map(joint).collect::<Vec<_>>()).unwrap()
}

pub(crate) fn clip(motion: &Motion) -> Arc<Clip> {
    let track = |(joint, (axis, angles)): (usize, &([f32; 3], Vec<f32>))| {
        let last = (angles.len() - 1).max(1) as f32;
        let times = (0..angles.len()).map(|key| motion.duration_secs * key as f32 / last);
        let rotation = |angle: &f32| {
            let axis = glam::DVec3::from_array(axis.map(f64::from)).normalize();
            DQuat::from_axis_angle(axis, f64::from(*angle)).as_quat().to_array()
        };
        Track {
            joint: format!("joint {joint}"),
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times: times.collect(),
            values: angles.iter().flat_map(rotation).collect(),
        }
    };
    let tracks = motion.rotations.iter().enumerate().map(track).collect();
    Arc::new(Clip::new(ClipSource { name: motion.name.into(), tracks }, &skeleton()).unwrap())
}

pub(crate) fn character(motions: &[Motion]) -> Character {
    let entry =
        |joint| PaletteEntry { joint: JointIndex(joint), joint_from_bind: Affine::IDENTITY };
    Character::new(CharacterSource {
        name: "arm".into(),
        skeleton: skeleton(),
        palette: (0..JOINTS as u32).map(entry).collect(),
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips: motions.iter().map(clip).collect(),
    })
    .unwrap()
}

/// Builds a crowd with the arm and one member that plays nothing. Also returns the clips in order.
pub(crate) fn one_member(
    builder: &CrowdBuilder,
    motions: &[Motion],
) -> (Crowd, Vec<ClipId>, MemberId) {
    let (mut crowd, id, clips) = crowd_of(builder, motions);
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    (crowd, clips, member)
}

/// Builds a crowd with the arm. Also returns the character and its clips in order.
pub(crate) fn crowd_of(
    builder: &CrowdBuilder,
    motions: &[Motion],
) -> (Crowd, CharacterId, Vec<ClipId>) {
    let mut crowd = builder.clone().build().unwrap();
    let id = crowd.add_character(character(motions)).unwrap();
    let clips = crowd.character(id).unwrap().clips().into_iter().map(|(clip, _)| clip).collect();
    (crowd, id, clips)
}

/// Returns the rotation of each joint in model space.
pub(crate) fn rotations(crowd: &mut Crowd, member: MemberId) -> Vec<Quat> {
    let rotation = |m: Affine| {
        let [a, b, c] = m.rows;
        let columns = [0, 1, 2].map(|i| glam::Vec3::new(a[i], b[i], c[i]));
        Quat::from_mat3(&glam::Mat3::from_cols(columns[0], columns[1], columns[2])).normalize()
    };
    crowd
        .member_mut(member)
        .unwrap()
        .model_from_joints()
        .unwrap()
        .into_iter()
        .map(rotation)
        .collect()
}

/// Returns the largest angle in radians between the rotations of a joint in two poses.
pub(crate) fn step_rad(before: &[Quat], after: &[Quat]) -> f32 {
    // The arc cosine of a dot product is inaccurate for small angles.
    let angle = |(a, b): (&Quat, &Quat)| {
        let turn = a.inverse() * *b;
        2.0 * f64::from(turn.xyz().length()).atan2(f64::from(turn.w.abs()))
    };
    before.iter().zip(after).map(angle).fold(0.0, f64::max) as f32
}
