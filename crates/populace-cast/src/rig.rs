//! The two skeletons, and conversion of segment poses to joint tracks.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_character::PaletteEntry;
use populace_model::Error;
use populace_model::convert::single;
use populace_model::{
    Affine, ClipSource, Interpolation, JointSource, Property, Skeleton, Track, Trs,
};

use crate::Rig;
use crate::anatomy::{Body, HEAD, Limb, NECK, PELVIS, SEGMENTS, SPINE, Segment, Side, parent};
use crate::motion::{Motion, Pose};
use crate::surface::narrow;

/// Definition of a rig's joint.
struct Entry {
    name: String,
    /// Segment that gives the joint's position.
    origin: Segment,
    /// Segment that gives the joint's rotation.
    driver: Segment,
    /// Index of the parent joint.
    parent: Option<usize>,
}

/// The joints of a body's rig, in source order.
pub(crate) struct Joints {
    entries: Vec<Entry>,
    /// Index of the joint that moves each segment's vertices.
    pub(crate) of_segment: [u16; SEGMENTS],
    /// Rest positions in model space.
    positions: Vec<DVec3>,
    /// Rest rotations in model space.
    rotations: Vec<DQuat>,
}

impl Joints {
    pub(crate) fn new(body: &Body) -> Self {
        let (entries, of_segment) = match body.look.rig {
            Rig::Lean => lean(),
            Rig::Full => full(),
        };
        let positions: Vec<DVec3> = entries.iter().map(|e| body.joints[e.origin]).collect();
        let rotations = match body.look.rig {
            Rig::Lean => vec![DQuat::IDENTITY; entries.len()],
            Rig::Full => (0..SEGMENTS).map(|segment| along_segment(body, segment)).collect(),
        };
        Self { entries, of_segment, positions, rotations }
    }

    /// Returns the number of joints.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns the position of a joint at rest in model space.
    pub(crate) fn position(&self, joint: usize) -> DVec3 {
        self.positions[joint]
    }

    /// Returns the parent of a joint, which has a lower index.
    pub(crate) fn parent(&self, joint: usize) -> Option<usize> {
        self.entries[joint].parent
    }

    /// Returns the segment that gives a joint's rotation.
    pub(crate) fn driver(&self, joint: usize) -> Segment {
        self.entries[joint].driver
    }

    pub(crate) fn skeleton(&self) -> Result<Skeleton, Error> {
        let sources: Vec<JointSource> = (0..self.entries.len())
            .map(|at| {
                let (position, rotation) = (self.positions[at], self.rotations[at]);
                let (offset, rotation) = match self.entries[at].parent {
                    Some(p) => {
                        let parent_from_model = self.rotations[p].inverse();
                        (
                            parent_from_model * (position - self.positions[p]),
                            parent_from_model * rotation,
                        )
                    }
                    None => (position, rotation),
                };
                JointSource {
                    name: self.entries[at].name.clone(),
                    parent: self.entries[at].parent,
                    rest: Trs {
                        translation: narrow(offset),
                        rotation: quat(rotation),
                        scale: [1.0; 3],
                    },
                }
            })
            .collect();
        Skeleton::new(&sources)
    }

    /// Returns one palette entry for each joint, in source order.
    pub(crate) fn palette(&self, skeleton: &Skeleton) -> Vec<PaletteEntry> {
        (0..self.entries.len())
            .map(|at| {
                let model =
                    DAffine3::from_rotation_translation(self.rotations[at], self.positions[at]);
                let m = model.inverse();
                let columns = [m.x_axis, m.y_axis, m.z_axis, m.translation].map(narrow);
                let rows = [0, 1, 2].map(|row| columns.map(|column| column[row]));
                PaletteEntry {
                    joint: skeleton.joint_from_source(at),
                    joint_from_bind: Affine { rows },
                }
            })
            .collect()
    }

    /// Returns the clip of a motion: rotation tracks of all joints, and the root's translation.
    pub(crate) fn tracks(&self, body: &Body, motion: &Motion) -> ClipSource {
        let last = motion.poses.len() - 1;
        let times: Vec<f32> =
            (0..=last).map(|key| single(motion.duration_secs * key as f64 / last as f64)).collect();
        let mut tracks = Vec::with_capacity(self.entries.len() + 1);
        tracks.push(Track {
            joint: self.entries[0].name.clone(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: times.clone(),
            values: motion
                .poses
                .iter()
                .flat_map(|pose| narrow(body.joints[PELVIS] + pose.pelvis_offset))
                .collect(),
        });
        for (at, entry) in self.entries.iter().enumerate() {
            let mut previous: Option<DQuat> = None;
            let mut values = Vec::with_capacity(4 * times.len());
            for pose in &motion.poses {
                let mut local = self.local(pose, at);
                // Keep neighbouring keys in one hemisphere.
                if previous.is_some_and(|p| p.dot(local) < 0.0) {
                    local = -local;
                }
                previous = Some(local);
                values.extend(quat(local));
            }
            tracks.push(Track {
                joint: entry.name.clone(),
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times: times.clone(),
                values,
            });
        }
        ClipSource { name: motion.name.into(), tracks }
    }

    /// Returns the rotation of joint `at` relative to its parent.
    fn local(&self, pose: &Pose, at: usize) -> DQuat {
        let model = |j: usize| pose.rotations[self.entries[j].driver] * self.rotations[j];
        match self.entries[at].parent {
            Some(p) => (model(p).inverse() * model(at)).normalize(),
            None => model(at),
        }
    }
}

/// Returns `[x, y, z, w]` in single precision.
fn quat(q: DQuat) -> [f32; 4] {
    q.to_array().map(single)
}

const FINGER_NAMES: [&str; 5] = ["Thumb", "Index", "Middle", "Ring", "Little"];

/// Returns the joints of the full rig, one for each segment, and each segment's joint.
fn full() -> (Vec<Entry>, [u16; SEGMENTS]) {
    let mut names = vec![String::new(); SEGMENTS];
    let trunk = [
        (PELVIS, "Pelvis"),
        (SPINE[0], "Spine1"),
        (SPINE[1], "Spine2"),
        (SPINE[2], "Spine3"),
        (SPINE[3], "Spine4"),
        (NECK[0], "Neck1"),
        (NECK[1], "Neck2"),
        (HEAD, "Head"),
    ];
    for (segment, name) in trunk {
        names[segment] = name.into();
    }
    for (side, word) in Side::BOTH.into_iter().zip(["Left", "Right"]) {
        let limbs = [
            (Limb::Clavicle, "Clavicle"),
            (Limb::UpperArm, "UpperArm"),
            (Limb::Forearm, "Forearm"),
            (Limb::Hand, "Hand"),
            (Limb::Thigh, "Thigh"),
            (Limb::Shin, "Shin"),
            (Limb::Foot, "Foot"),
            (Limb::Toes, "Toes"),
        ];
        for (limb, name) in limbs {
            names[limb.of(side)] = format!("{word}{name}");
        }
        for (finger, name) in FINGER_NAMES.into_iter().enumerate() {
            for joint in 0..3 {
                names[Limb::Finger(finger, joint).of(side)] = format!("{word}{name}{}", joint + 1);
            }
        }
    }
    let entries = names
        .into_iter()
        .enumerate()
        .map(|(at, name)| Entry { name, origin: at, driver: at, parent: parent(at) })
        .collect();
    (entries, std::array::from_fn(|at| u16::try_from(at).unwrap_or(0)))
}

/// Returns the joints of the lean rig, and each segment's joint. Spine, neck, the four fingers and
/// the thumb have two, one, one and one joints.
fn lean() -> (Vec<Entry>, [u16; SEGMENTS]) {
    let entry =
        |name: &str, origin, driver, parent| Entry { name: name.into(), origin, driver, parent };
    let mut entries = vec![
        entry("hips", PELVIS, PELVIS, None),
        entry("spine", SPINE[0], SPINE[1], Some(0)),
        entry("chest", SPINE[2], SPINE[3], Some(1)),
        entry("neck", NECK[0], NECK[0], Some(2)),
        entry("head", HEAD, HEAD, Some(3)),
    ];
    let mut of_segment = [0; SEGMENTS];
    let mut assign = |segments: &[Segment], joint: usize| {
        for &segment in segments {
            of_segment[segment] = u16::try_from(joint).unwrap_or(0);
        }
    };
    assign(&SPINE[..2], 1);
    assign(&SPINE[2..], 2);
    assign(&NECK, 3);
    assign(&[HEAD], 4);
    for (side, word) in Side::BOTH.into_iter().zip(["l", "r"]) {
        let first = entries.len();
        let limbs = [
            ("shoulder", Limb::Clavicle, 2),
            ("upper_arm", Limb::UpperArm, first),
            ("forearm", Limb::Forearm, first + 1),
            ("hand", Limb::Hand, first + 2),
            ("fingers", Limb::Finger(2, 0), first + 3),
            ("thumb", Limb::Finger(0, 0), first + 3),
            ("upper_leg", Limb::Thigh, 0),
            ("lower_leg", Limb::Shin, first + 6),
            ("foot", Limb::Foot, first + 7),
            ("toe", Limb::Toes, first + 8),
        ];
        for (name, limb, parent) in limbs {
            let segment = limb.of(side);
            assign(&[segment], entries.len());
            entries.push(entry(&format!("{word}_{name}"), segment, segment, Some(parent)));
        }
        for joint in 0..3 {
            assign(&[Limb::Finger(0, joint).of(side)], first + 5);
            assign(&[1, 2, 3, 4].map(|finger| Limb::Finger(finger, joint).of(side)), first + 4);
        }
    }
    (entries, of_segment)
}

/// Returns the full rig's rest rotation of a segment: Y points to the child joint, and Z as far as
/// possible to the front, or up for the feet.
fn along_segment(body: &Body, segment: Segment) -> DQuat {
    let next = (segment + 1..SEGMENTS).filter(|&s| parent(s) == Some(segment));
    let middle = Side::BOTH.map(|side| Limb::Finger(2, 0).of(side));
    let next: Vec<Segment> = next.collect();
    let child = next.iter().copied().find(|s| middle.contains(s)).or_else(|| next.first().copied());
    let y = match child {
        Some(child) => (body.joints[child] - body.joints[segment]).normalize(),
        None if segment == HEAD => DVec3::Y,
        None if Side::BOTH.iter().any(|s| Limb::Toes.of(*s) == segment) => DVec3::Z,
        None => {
            let parent = parent(segment).unwrap_or(PELVIS);
            (body.joints[segment] - body.joints[parent]).normalize()
        }
    };
    let front = if y.z.abs() > 0.85 { DVec3::Y } else { DVec3::Z };
    let z = (front - y * front.dot(y)).normalize();
    DQuat::from_mat3(&DMat3::from_cols(y.cross(z), y, z)).normalize()
}
