//! Selection and naming of the nodes that become joints.

use std::collections::{HashMap, HashSet};

use populace_character::{PaletteEntry, Part, SkinInstance, sole_points, vertex_reach_m};
use populace_clip::FARTHEST_SIZES;
use populace_model::{JointIndex, JointSource, Skeleton, Trs};

use crate::bind_pose::bind_pose;
use crate::log::{Checked, Log};
use crate::nodes::Node;

/// A skeleton and the mapping of nodes to joints.
#[derive(Debug)]
pub(crate) struct Rig {
    pub(crate) skeleton: Skeleton,
    /// Joint of each node; `None` if the node is not part of the skeleton.
    pub(crate) joint_from_node: Vec<Option<JointIndex>>,
}

impl Rig {
    /// Builds a skeleton from the nodes `wanted` and `joints`, their ancestors, and the descendants
    /// of `joints`, which are attachment points.
    pub(crate) fn new(
        nodes: &[Node],
        wanted: impl Iterator<Item = usize>,
        joints: &[usize],
        log: &Log,
    ) -> Checked<Self> {
        let chosen = choose(nodes, wanted, joints);
        let list: Vec<_> = (0..nodes.len()).filter(|n| chosen[*n]).collect();
        let mut source_from_node = vec![None; nodes.len()];
        for (source, &node) in list.iter().enumerate() {
            source_from_node[node] = Some(source);
        }
        let names = unique_names(&list, nodes, log);
        let mut sources: Vec<_> = list
            .iter()
            .zip(names)
            .map(|(&node, name)| JointSource {
                name,
                parent: nodes[node].parent.and_then(|p| source_from_node[p]),
                rest: nodes[node].local,
            })
            .collect();
        if sources.is_empty() {
            log.note("file", "has nothing to animate or draw; its skeleton is a single joint");
            sources.push(JointSource { name: "root".into(), parent: None, rest: Trs::IDENTITY });
        }
        let skeleton = Skeleton::new(&sources).map_err(|e| log.problem("nodes", e.to_string()))?;
        let joint_from_node = source_from_node
            .iter()
            .map(|source| source.map(|s| skeleton.joint_from_source(s)))
            .collect();
        Ok(Self { skeleton, joint_from_node })
    }

    /// Adds the reach of vertices, the bind pose and the sole points to the skeleton. Clip
    /// compression needs the first to bound the error of vertices, retargeting the second, and foot
    /// placement the last.
    pub(crate) fn measure_vertices(
        &mut self,
        palette: &[PaletteEntry],
        parts: &[Part],
        skins: &[SkinInstance],
    ) {
        let reach = vertex_reach_m(&self.skeleton, palette, parts);
        let locals = bind_pose(&self.skeleton, skins);
        let skeleton = self.skeleton.clone().with_reach(&reach).with_bind_pose(&locals);
        let soles = sole_points(&skeleton, palette, parts);
        self.skeleton = skeleton.with_soles(&soles);
    }

    /// Adds a note for each part with a vertex that is too far from a joint for the error bound of
    /// clips to hold there.
    pub(crate) fn note_far_vertices(&self, palette: &[PaletteEntry], parts: &[Part], log: &Log) {
        let farthest = FARTHEST_SIZES * self.skeleton.size_m();
        if self.skeleton.reach_m().iter().all(|reach| *reach <= farthest) {
            return;
        }
        for part in parts {
            let reach = vertex_reach_m(&self.skeleton, palette, std::slice::from_ref(part));
            let far = self.skeleton.joints().zip(reach).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((joint, reach)) = far.filter(|(_, reach)| *reach > farthest) else { continue };
            let away = |[x, y, z]: [f32; 3]| x.hypot(y).hypot(z);
            let vertices = part.mesh.positions.iter().enumerate();
            let outermost =
                vertices.max_by(|a, b| away(*a.1).total_cmp(&away(*b.1))).map_or(0, |v| v.0);
            let what = format!(
                "reaches {reach:.1} m from joint \"{}\" with vertex {outermost} of primitive {}; \
                 the error bound of clips holds up to {farthest:.1} m",
                self.skeleton.name(joint),
                part.primitive
            );
            log.note(format!("nodes[{}].mesh", part.node), what);
        }
    }

    /// Returns the node of each joint; `None` for a joint that was added by the importer.
    pub(crate) fn node_from_joint(&self) -> Vec<Option<usize>> {
        let mut nodes = vec![None; self.skeleton.joint_count()];
        for (node, joint) in self.joint_from_node.iter().enumerate() {
            if let Some(joint) = joint {
                nodes[joint.index()] = Some(node);
            }
        }
        nodes
    }

    /// Returns the name of the node's joint, else the node's own name, else a name with its index.
    pub(crate) fn node_name(&self, nodes: &[Node], node: usize) -> String {
        match self.joint_from_node[node] {
            Some(joint) => self.skeleton.name(joint).to_owned(),
            None if nodes[node].name.is_empty() => format!("node{node}"),
            None => nodes[node].name.clone(),
        }
    }
}

/// Returns for each node whether it becomes a joint.
fn choose(nodes: &[Node], wanted: impl Iterator<Item = usize>, joints: &[usize]) -> Vec<bool> {
    let mut chosen = vec![false; nodes.len()];
    let mut below = joints.to_vec();
    while let Some(node) = below.pop() {
        if !std::mem::replace(&mut chosen[node], true) {
            below.extend_from_slice(&nodes[node].children);
        }
    }
    let all = wanted.chain(joints.iter().copied());
    for node in all {
        chosen[node] = true;
        let mut above = nodes[node].parent;
        while let Some(node) = above.filter(|n| !chosen[*n]) {
            chosen[node] = true;
            above = nodes[node].parent;
        }
    }
    chosen
}

/// Returns unique names. The first node of a name keeps it, later ones get the suffix `#2`, `#3`
/// and so on, and nodes without a name are named after their index. Names are changed only where
/// necessary, because clips of other files bind by name.
fn unique_names(list: &[usize], nodes: &[Node], log: &Log) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    let mut names: Vec<Option<String>> = list
        .iter()
        .map(|&node| {
            let name = &nodes[node].name;
            (!name.is_empty() && taken.insert(name.clone())).then(|| name.clone())
        })
        .collect();
    let mut last_suffix: HashMap<&str, usize> = HashMap::new();
    for (slot, &node) in names.iter_mut().zip(list).filter(|(slot, _)| slot.is_none()) {
        let own = &nodes[node].name;
        let base = if own.is_empty() { format!("node{node}") } else { own.clone() };
        let suffix = last_suffix.entry(own).or_insert(1);
        let mut name = base.clone();
        while !taken.insert(name.clone()) {
            *suffix += 1;
            name = format!("{base}#{suffix}");
        }
        if !own.is_empty() {
            log.note(
                &nodes[node].place,
                format!("has the name \"{own}\" of an earlier node; later ones are numbered"),
            );
        }
        *slot = Some(name);
    }
    names.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, parent: Option<usize>, children: &[usize]) -> Node {
        Node {
            place: String::new(),
            name: name.into(),
            parent,
            children: children.into(),
            local: Trs::IDENTITY,
            has_matrix: false,
            mesh: None,
            skin: None,
            in_scene: true,
            levels: Vec::new(),
        }
    }

    #[test]
    fn names_are_unique_and_change_only_if_taken() {
        let log = Log::default();
        let names = ["a", "", "a", "a#2", "node1", "a", ""];
        let nodes: Vec<_> = names.iter().map(|n| node(n, None, &[])).collect();
        let list: Vec<_> = (0..nodes.len()).collect();
        let unique = unique_names(&list, &nodes, &log);
        assert_eq!(unique, ["a", "node1#2", "a#3", "a#2", "node1", "a#4", "node6"]);
    }

    #[test]
    fn skeleton_includes_ancestors_and_descendants_of_joints_only() {
        let nodes = [
            node("armature", None, &[1, 5]),
            node("hips", Some(0), &[2]),
            node("hand", Some(1), &[3]),
            node("grip", Some(2), &[]),
            node("camera", None, &[]),
            node("mesh", Some(0), &[]),
        ];
        let log = Log::default();
        let rig = Rig::new(&nodes, std::iter::empty(), &[1], &log).unwrap();
        let names: Vec<_> =
            rig.skeleton.joints().map(|j| rig.skeleton.name(j).to_owned()).collect();
        assert_eq!(names, ["armature", "hips", "hand", "grip"]);
        assert_eq!(rig.joint_from_node[5], None);
        assert_eq!(rig.node_name(&nodes, 5), "mesh");
    }
}
