//! The Mixamo rig: joints, where they lie on the mesh, and weights of vertices.

use std::collections::HashMap;

use glam::Vec3;
use serde_json::Value;

use crate::Error;
use crate::mesh_file::BaseMesh;

const RIG: &str = "rigs/standard/rig.mixamo.json";
const WEIGHTS: &str = "rigs/standard/weights.mixamo.json";

/// A joint of the rig.
pub(crate) struct RigJoint {
    pub(crate) name: String,
    /// Index of the parent, which comes before its children.
    pub(crate) parent: Option<usize>,
    /// Vertices of the base mesh whose mean is the joint's place.
    pub(crate) anchors: Vec<usize>,
}

/// Up to four joints and their weights, strongest first. Weights sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights {
    pub(crate) joints: [u16; 4],
    pub(crate) shares: [f32; 4],
}

impl Weights {
    /// The whole weight on one joint.
    pub(crate) fn one(joint: u16) -> Self {
        Self { joints: [joint; 4], shares: [1.0, 0.0, 0.0, 0.0] }
    }

    /// Returns the four strongest of the given shares, or the first joint without any.
    pub(crate) fn strongest(pairs: impl IntoIterator<Item = (u16, f32)>) -> Self {
        let mut sums: Vec<(u16, f32)> = Vec::new();
        for (joint, share) in pairs {
            match sums.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, sum)) => *sum += share,
                None => sums.push((joint, share)),
            }
        }
        sums.retain(|(_, share)| *share > 0.0);
        sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        sums.truncate(4);
        let total: f32 = sums.iter().map(|(_, share)| share).sum();
        let Some(&(first, _)) = sums.first() else { return Self::one(0) };
        let mut weights = Self { joints: [first; 4], shares: [0.0; 4] };
        for (slot, (joint, share)) in sums.into_iter().enumerate() {
            weights.joints[slot] = joint;
            weights.shares[slot] = share / total;
        }
        weights
    }

    pub(crate) fn pairs(&self) -> impl Iterator<Item = (u16, f32)> + use<> {
        self.joints.into_iter().zip(self.shares)
    }

    /// Mixes several weights.
    pub(crate) fn mix(all: &[(Self, f32)]) -> Self {
        Self::strongest(all.iter().flat_map(|(w, part)| w.pairs().map(move |(j, s)| (j, s * part))))
    }
}

/// The rig: joints with parents first, and the weights of each vertex of the base mesh.
pub(crate) struct Rig {
    pub(crate) joints: Vec<RigJoint>,
    pub(crate) weights: Vec<Weights>,
}

impl Rig {
    pub(crate) fn parse(rig: &str, weights: &str, mesh: &BaseMesh) -> Result<Self, Error> {
        let joints = read_joints(rig, mesh)?;
        let weights = read_weights(weights, &joints, mesh.positions.len())?;
        Ok(Self { joints, weights })
    }

    /// The joint whose name ends in `:name`, as `mixamorig:Head`.
    pub(crate) fn find(&self, name: &str) -> Result<u16, Error> {
        let found = self.joints.iter().position(|j| j.name.rsplit(':').next() == Some(name));
        found
            .and_then(|joint| u16::try_from(joint).ok())
            .ok_or_else(|| Error::bad(RIG, format!("has no joint \"{name}\"")))
    }

    /// The place of each joint for these positions of the base mesh's vertices.
    pub(crate) fn places(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let mean = |joint: &RigJoint| {
            let sum: Vec3 = joint.anchors.iter().map(|anchor| positions[*anchor]).sum();
            sum / joint.anchors.len() as f32
        };
        self.joints.iter().map(mean).collect()
    }
}

fn json(file: &str, text: &str) -> Result<Value, Error> {
    serde_json::from_str(text).map_err(|e| Error::bad(file, format!("is not JSON: {e}")))
}

fn read_joints(text: &str, mesh: &BaseMesh) -> Result<Vec<RigJoint>, Error> {
    let value = json(RIG, text)?;
    let bones = value.get("bones").unwrap_or(&value);
    let bones = bones.as_object().ok_or_else(|| Error::bad(RIG, "has no \"bones\""))?;
    let mut order: Vec<&String> = Vec::new();
    let parent = |name: &str| bones[name]["parent"].as_str().filter(|p| !p.is_empty());
    while order.len() < bones.len() {
        let before = order.len();
        for name in bones.keys() {
            let ready = parent(name).is_none_or(|p| order.iter().any(|known| *known == p));
            if ready && !order.contains(&name) {
                order.push(name);
            }
        }
        if order.len() == before {
            return Err(Error::bad(RIG, "has a bone whose parents do not lead to a root"));
        }
    }
    let joint = |name: &&String| {
        Ok(RigJoint {
            name: (*name).clone(),
            parent: parent(name).and_then(|p| order.iter().position(|known| *known == p)),
            anchors: read_anchors(name, &bones[*name]["head"], mesh)?,
        })
    };
    order.iter().map(joint).collect()
}

/// Reads the vertices that a joint lies between: named ones, or those of a joint cube.
fn read_anchors(name: &str, head: &Value, mesh: &BaseMesh) -> Result<Vec<usize>, Error> {
    let listed = head["vertex_indices"].as_array().into_iter().flatten();
    let listed = listed.filter_map(|v| usize::try_from(v.as_u64()?).ok());
    let mut anchors: Vec<usize> = listed.collect();
    anchors.extend(head["vertex_index"].as_u64().and_then(|v| usize::try_from(v).ok()));
    if anchors.is_empty() {
        anchors = mesh.vertices(head["cube_name"].as_str().unwrap_or_default());
    }
    if anchors.is_empty() || anchors.iter().any(|v| *v >= mesh.positions.len()) {
        return Err(Error::bad(RIG, format!("the head of \"{name}\" names no vertex of the mesh")));
    }
    Ok(anchors)
}

fn read_weights(text: &str, joints: &[RigJoint], count: usize) -> Result<Vec<Weights>, Error> {
    let value = json(WEIGHTS, text)?;
    let all =
        value["weights"].as_object().ok_or_else(|| Error::bad(WEIGHTS, "has no \"weights\""))?;
    let index: HashMap<&str, u16> = joints.iter().map(|j| j.name.as_str()).zip(0u16..).collect();
    let mut shares: Vec<Vec<(u16, f32)>> = vec![Vec::new(); count];
    for (name, list) in all {
        let Some(&joint) = index.get(name.as_str()) else { continue };
        for pair in list.as_array().into_iter().flatten() {
            let vertex = pair[0].as_u64().and_then(|v| usize::try_from(v).ok());
            let share = pair[1].as_f64();
            if let (Some(slot), Some(share)) = (vertex.and_then(|v| shares.get_mut(v)), share) {
                slot.push((joint, populace_model::convert::single(share)));
            }
        }
    }
    Ok(shares.into_iter().map(Weights::strongest).collect())
}
