//! Levels of detail of a file's parts (MSFT_lod).

use populace_character::{Character, Error, Influences, Level, Mesh, joints_needed};

use crate::log::Log;
use crate::nodes::Node;

/// The coarser meshes of each part, and the node that it comes from.
#[derive(Default)]
pub(crate) struct Levels {
    parts: Vec<(usize, Vec<Mesh>)>,
}

impl Levels {
    /// Adds those of the next part.
    pub(crate) fn add(&mut self, node: usize, meshes: Vec<Mesh>) {
        self.parts.push((node, meshes));
    }

    /// Gives the levels to the character. They are left out if not all parts have the same ones.
    pub(crate) fn give(
        self,
        character: Character,
        nodes: &[Node],
        log: &Log,
    ) -> Result<Character, Error> {
        let errors_m = |node: usize| nodes[node].levels.iter().map(|(_, error_m)| *error_m);
        let Some(&(first, _)) = self.parts.iter().find(|(_, meshes)| !meshes.is_empty()) else {
            return Ok(character);
        };
        if let Some((other, _)) = self.parts.iter().find(|(n, _)| !errors_m(*n).eq(errors_m(first)))
        {
            let what = format!(
                "has levels of detail, but {} has others or none; they are ignored",
                nodes[*other].place
            );
            log.note(&nodes[first].place, what);
            return Ok(character);
        }
        let level = |error_m| {
            let joint_count = joints_needed(&character.skeleton, error_m);
            Level { error_m, meshes: Vec::new(), joint_count }
        };
        let mut levels: Vec<Level> = errors_m(first).map(level).collect();
        for (_, meshes) in self.parts {
            for (level, mesh) in levels.iter_mut().zip(meshes) {
                level.meshes.push(mesh);
            }
        }
        character.with_levels(levels)
    }
}

/// Returns a mesh without triangles, which stands for a part that is too small to be seen.
pub(crate) fn empty() -> Mesh {
    Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences { per_vertex: 4, entries: Vec::new(), weights: Vec::new() },
        indices: Vec::new(),
    }
}
