//! Joints in groups, as attributes of vertices: edges between vertices of different groups bend.

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
        let skeleton = &character.skeleton;
        // Each joint's representative: itself, until it joins its parent.
        let mut joints: Vec<usize> = character.palette.iter().map(|e| e.joint.index()).collect();
        loop {
            let mut used = joints.clone();
            used.sort_unstable();
            used.dedup();
            // Joints are in order of their depth.
            let parent = used.iter().rev().find_map(|&joint| {
                let parent = skeleton.parent(skeleton.joints().nth(joint)?)?;
                Some((joint, parent.index()))
            });
            match parent {
                Some((deepest, parent)) if used.len() > MAX_GROUPS => {
                    joints.iter_mut().filter(|j| **j == deepest).for_each(|j| *j = parent);
                }
                _ => {
                    let place = |joint: &usize| used.binary_search(joint).unwrap_or_default();
                    let of_entries = joints.iter().map(place).map(|g| g % MAX_GROUPS).collect();
                    return Self { of_entries, count: used.len().min(MAX_GROUPS) };
                }
            }
        }
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
