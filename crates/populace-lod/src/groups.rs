//! Joints in groups, as attributes of vertices: edges between vertices of different groups bend.

use std::collections::BTreeSet;

use populace_character::{Character, Influences};

/// Most groups. The simplifier takes 32 attributes, of which eight are normals, colours and texture
/// coordinates.
pub(crate) const MAX_GROUPS: usize = 24;

/// Groups of palette entries: joints that have vertices, of which the deepest joined their parents
/// until there were few enough.
pub(crate) struct JointGroups {
    /// Group of each palette entry.
    of_entries: Vec<usize>,
    pub(crate) count: usize,
}

impl JointGroups {
    pub(crate) fn of(character: &Character) -> Self {
        let (parents, palette) = (character.skeleton.parents(), &character.palette);
        let mut used: BTreeSet<usize> = palette.iter().map(|e| e.joint.index()).collect();
        let mut has_joined = vec![false; parents.len()];
        // Joints are in order of their depth.
        while used.len() > MAX_GROUPS
            && let Some(deepest) = used.last().copied()
            && let Some(parent) = parents[deepest]
        {
            used.remove(&deepest);
            used.insert(parent.index());
            has_joined[deepest] = true;
        }
        let mut of_joints = vec![0; parents.len()];
        for (group, joint) in used.iter().enumerate() {
            of_joints[*joint] = group % MAX_GROUPS;
        }
        for (joint, parent) in parents.iter().enumerate() {
            if let Some(parent) = parent.filter(|_| has_joined[joint]) {
                of_joints[joint] = of_joints[parent.index()];
            }
        }
        let of_entries = palette.iter().map(|entry| of_joints[entry.joint.index()]).collect();
        Self { of_entries, count: used.len().min(MAX_GROUPS) }
    }

    /// Adds a vertex's weights to its groups.
    pub(crate) fn add_weights(&self, influences: &Influences, vertex: usize, to: &mut [f32]) {
        let range = vertex * influences.per_vertex..(vertex + 1) * influences.per_vertex;
        for (entry, weight) in
            influences.entries[range.clone()].iter().zip(&influences.weights[range])
        {
            to[self.of_entries[usize::from(*entry)]] += weight;
        }
    }
}
