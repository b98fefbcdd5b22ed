//! The two skeletons, and how poses of the body's segments become tracks of their joints.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_character::PaletteEntry;
use populace_model::Error;
use populace_model::{
    Affine, ClipSource, Interpolation, JointSource, Property, Skeleton, Track, Trs,
};

use crate::Rig;
use crate::anatomy::{Body, HEAD, Limb, NECK, PELVIS, SEGMENTS, SPINE, Segment, Side, parent};
use crate::motion::{Motion, Pose};
use crate::surface::{narrow, narrow_one};

/// A joint of a rig: its name, the segment at whose place it stands, the segment whose turns it
/// makes, its parent.
struct Entry {
    name: String,
    place: Segment,
    driver: Segment,
    parent: Option<usize>,
}

/// The joints of a body's rig, in source order.
pub(crate) struct Joints {
    entries: Vec<Entry>,
    /// Which joint moves what each segment moves.
    pub(crate) of_segment: [u16; SEGMENTS],
    /// Model space.
    places: Vec<DVec3>,
    /// Model space.
    turns: Vec<DQuat>,
}

impl Joints {
    pub(crate) fn new(body: &Body) -> Self {
        let (entries, of_segment) = match body.look.rig {
            Rig::Lean => lean(),
            Rig::Full => full(),
        };
        let places: Vec<DVec3> = entries.iter().map(|e| body.joints[e.place]).collect();
        let turns = match body.look.rig {
            Rig::Lean => vec![DQuat::IDENTITY; entries.len()],
            Rig::Full => (0..SEGMENTS).map(|segment| along_segment(body, segment)).collect(),
        };
        Self { entries, of_segment, places, turns }
    }

    pub(crate) fn skeleton(&self) -> Result<Skeleton, Error> {
        let sources: Vec<JointSource> = (0..self.entries.len())
            .map(|at| {
                let (offset, turn) = match self.entries[at].parent {
                    Some(p) => {
                        let back = self.turns[p].inverse();
                        (back * (self.places[at] - self.places[p]), back * self.turns[at])
                    }
                    None => (self.places[at], self.turns[at]),
                };
                JointSource {
                    name: self.entries[at].name.clone(),
                    parent: self.entries[at].parent,
                    rest: Trs {
                        translation: narrow(offset),
                        rotation: quat(turn),
                        scale: [1.0; 3],
                    },
                }
            })
            .collect();
        Skeleton::new(&sources)
    }

    /// One entry for each joint, in source order.
    pub(crate) fn palette(&self, skeleton: &Skeleton) -> Vec<PaletteEntry> {
        (0..self.entries.len())
            .map(|at| {
                let model = DAffine3::from_rotation_translation(self.turns[at], self.places[at]);
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

    /// Rotations of all joints and the root's translation.
    pub(crate) fn tracks(&self, body: &Body, motion: &Motion) -> ClipSource {
        let last = motion.poses.len() - 1;
        let times: Vec<f32> = (0..=last)
            .map(|key| narrow_one(motion.duration_secs * key as f64 / last as f64))
            .collect();
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
            let mut before: Option<DQuat> = None;
            let mut values = Vec::with_capacity(4 * times.len());
            for pose in &motion.poses {
                let mut local = self.local(pose, at);
                if before.is_some_and(|b| b.dot(local) < 0.0) {
                    local = -local;
                }
                before = Some(local);
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

    fn local(&self, pose: &Pose, at: usize) -> DQuat {
        let model = |j: usize| pose.turns[self.entries[j].driver] * self.turns[j];
        match self.entries[at].parent {
            Some(p) => (model(p).inverse() * model(at)).normalize(),
            None => model(at),
        }
    }
}

/// `x y z w`, rounded to single precision.
fn quat(q: DQuat) -> [f32; 4] {
    q.to_array().map(narrow_one)
}

const FINGER_NAMES: [&str; 5] = ["Thumb", "Index", "Middle", "Ring", "Little"];

/// Every segment is a joint.
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
        .map(|(at, name)| Entry { name, place: at, driver: at, parent: parent(at) })
        .collect();
    (entries, std::array::from_fn(|at| u16::try_from(at).unwrap_or(0)))
}

/// Two joints for the spine, one for the neck, one for four fingers, one for the thumb.
fn lean() -> (Vec<Entry>, [u16; SEGMENTS]) {
    let entry =
        |name: &str, place, driver, parent| Entry { name: name.into(), place, driver, parent };
    let mut entries = vec![
        entry("hips", PELVIS, PELVIS, None),
        entry("spine", SPINE[0], SPINE[1], Some(0)),
        entry("chest", SPINE[2], SPINE[3], Some(1)),
        entry("neck", NECK[0], NECK[0], Some(2)),
        entry("head", HEAD, HEAD, Some(3)),
    ];
    let mut of_segment = [0; SEGMENTS];
    let mut carry = |segments: &[Segment], joint: usize| {
        for &segment in segments {
            of_segment[segment] = u16::try_from(joint).unwrap_or(0);
        }
    };
    carry(&SPINE[..2], 1);
    carry(&SPINE[2..], 2);
    carry(&NECK, 3);
    carry(&[HEAD], 4);
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
            carry(&[segment], entries.len());
            entries.push(entry(&format!("{word}_{name}"), segment, segment, Some(parent)));
        }
        for joint in 0..3 {
            carry(&[Limb::Finger(0, joint).of(side)], first + 5);
            carry(&[1, 2, 3, 4].map(|finger| Limb::Finger(finger, joint).of(side)), first + 4);
        }
    }
    (entries, of_segment)
}

/// The rest rotation of the full rig: Y to the next joint, Z as far to the front (of feet: up) as
/// can be.
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
            let before = parent(segment).unwrap_or(PELVIS);
            (body.joints[segment] - body.joints[before]).normalize()
        }
    };
    let front = if y.z.abs() > 0.85 { DVec3::Y } else { DVec3::Z };
    let z = (front - y * front.dot(y)).normalize();
    DQuat::from_mat3(&DMat3::from_cols(y.cross(z), y, z)).normalize()
}
