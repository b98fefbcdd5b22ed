//! Landmarks of the unshaped base mesh, by which regions of the body are told.

use glam::Vec3;

use crate::Error;
use crate::mesh_file::BaseMesh;
use crate::rig_file::{Rig, Weights};
use crate::surface::{Vertex, smoothstep};

/// Height of the top of the head above the eyes on the base mesh for which the measures of the head
/// were taken, in decimetres.
const TOP_OVER_EYES: f32 = 1.21;

/// Joints and landmarks of the base mesh, in its units (decimetres).
pub(crate) struct Marks {
    pub(crate) hips: u16,
    pub(crate) chest: u16,
    pub(crate) neck: u16,
    pub(crate) head: u16,
    /// Left and right.
    pub(crate) thighs: [u16; 2],
    /// True for each joint at or below an upper arm, or below a shin.
    in_arm: Vec<bool>,
    in_head: Vec<bool>,
    /// Shoulder, elbow and wrist of the left arm.
    arm: [Vec3; 3],
    pub(crate) neck_at: Vec3,
    pub(crate) crotch_y: f32,
    pub(crate) hip_y: f32,
    pub(crate) waist_y: f32,
    pub(crate) knee_y: f32,
    pub(crate) ankle_y: f32,
    /// The left eye.
    eye: Vec3,
    head_unit: f32,
}

impl Marks {
    pub(crate) fn new(mesh: &BaseMesh, rig: &Rig) -> Result<Self, Error> {
        let places = rig.places(&mesh.positions);
        let joint = |name: &str| rig.find(name);
        let place = |name: &str| Ok::<_, Error>(places[usize::from(rig.find(name)?)]);
        let both = |name: &str| {
            Ok::<_, Error>([joint(&format!("Left{name}"))?, joint(&format!("Right{name}"))?])
        };
        let eyes = mesh.vertices("helper-l-eye");
        if eyes.is_empty() {
            return Err(Error::bad("3dobjs/base.obj", "has no group \"helper-l-eye\""));
        }
        let eye = eyes.iter().map(|v| mesh.positions[*v]).sum::<Vec3>() / eyes.len() as f32;
        let body: Vec<Vec3> =
            mesh.vertices("body").into_iter().map(|v| mesh.positions[v]).collect();
        let top = body.iter().fold(f32::MIN, |top, v| top.max(v.y));
        let under = |root: u16| {
            let mut below = vec![false; rig.joints.len()];
            for (index, joint) in rig.joints.iter().enumerate() {
                below[index] = index == usize::from(root) || joint.parent.is_some_and(|p| below[p]);
            }
            below
        };
        let [left, right] = both("Arm")?.map(under);
        let in_arm = left.iter().zip(&right).map(|(l, r)| *l || *r).collect();
        let hip_y = place("LeftUpLeg")?.y;
        let middle = body.iter().filter(|v| v.x.abs() < 0.06 && v.y < hip_y);
        Ok(Self {
            hips: joint("Hips")?,
            chest: joint("Spine2")?,
            neck: joint("Neck")?,
            head: joint("Head")?,
            thighs: both("UpLeg")?,
            in_arm,
            in_head: under(joint("Head")?),
            arm: [place("LeftArm")?, place("LeftForeArm")?, place("LeftHand")?],
            neck_at: place("Neck")?,
            crotch_y: middle.fold(hip_y, |low, v| low.min(v.y)),
            hip_y,
            waist_y: place("Spine")?.y,
            knee_y: place("LeftLeg")?.y,
            ankle_y: place("LeftFoot")?.y,
            eye,
            head_unit: (top - eye.y).max(1e-3) / TOP_OVER_EYES,
        })
    }

    fn share(of: &[bool], vertex: &Vertex) -> f32 {
        let pairs = vertex.weights.pairs();
        pairs.filter(|(j, _)| of[usize::from(*j)]).map(|(_, share)| share).sum()
    }

    /// How much of a vertex follows an arm or a hand, from 0 to 1.
    pub(crate) fn arm_share(&self, vertex: &Vertex) -> f32 {
        Self::share(&self.in_arm, vertex)
    }

    /// How much of a vertex follows the head, from 0 to 1.
    pub(crate) fn head_share(&self, vertex: &Vertex) -> f32 {
        Self::share(&self.in_head, vertex)
    }

    /// How much of a vertex lies on the front of the chest, from 0 to 1.
    pub(crate) fn chest_share(&self, vertex: &Vertex) -> f32 {
        let up = (vertex.base.y - self.waist_y) / (self.neck_at.y - self.waist_y).max(1e-3);
        let chest = smoothstep(0.2, 0.35, up) * smoothstep(0.85, 0.65, up);
        let front = smoothstep(0.4, 1.0, vertex.base.z - self.neck_at.z);
        chest * front * (1.0 - self.arm_share(vertex))
    }

    /// Returns weights with only a part of what the thighs have; the hips get the rest.
    pub(crate) fn with_less_thigh(&self, weights: Weights, kept: f32) -> Weights {
        Weights::strongest(weights.pairs().flat_map(|(joint, share)| {
            let kept = if self.thighs.contains(&joint) { kept } else { 1.0 };
            [(joint, share * kept), (self.hips, share * (1.0 - kept))]
        }))
    }

    /// Distance of a vertex along its arm from the shoulder in decimetres; not positive elsewhere.
    pub(crate) fn along_arm(&self, vertex: &Vertex) -> f32 {
        let at = Vec3::new(vertex.base.x.abs(), vertex.base.y, vertex.base.z);
        let [shoulder, elbow, wrist] = self.arm;
        let (upper, lower) = (elbow - shoulder, wrist - elbow);
        let first = (at - shoulder).dot(upper.normalize_or_zero());
        let second = (at - elbow).dot(lower.normalize_or_zero());
        // Around the elbow the planes fan out, so that no cut runs along the arm.
        let along = if first < upper.length() * 0.9 && second < 0.0 {
            first
        } else {
            upper.length() + second.max(first - upper.length()).max(-0.1 * upper.length())
        };
        along * self.arm_share(vertex).min(0.5) * 2.0
    }

    /// Length of the upper arm, and of the whole arm up to the wrist, in decimetres.
    pub(crate) fn arm_lengths(&self) -> [f32; 2] {
        let [shoulder, elbow, wrist] = self.arm;
        let upper = shoulder.distance(elbow);
        [upper, upper + elbow.distance(wrist)]
    }

    /// Place of a vertex relative to the point between the eyes, +Y up and +Z front, in units of
    /// about a decimetre that make heads equally high.
    pub(crate) fn in_head(&self, vertex: &Vertex) -> Vec3 {
        (vertex.base - Vec3::new(0.0, self.eye.y, self.eye.z)) / self.head_unit
    }

    /// Half the distance between the eyes, in those units.
    pub(crate) fn eye_x(&self) -> f32 {
        self.eye.x / self.head_unit
    }
}
