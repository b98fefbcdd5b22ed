//! Meshes and the influences of joints on their vertices.

use glam::{DAffine3, DVec3};
use populace_model::f64math;

/// Palette entries and weights of each vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Influences {
    /// Influences per vertex: 4 or 8.
    pub per_vertex: usize,
    /// `vertices x per_vertex` indices into the
    /// [palette](crate::CharacterSource::palette).
    pub entries: Vec<u16>,
    /// `vertices x per_vertex` weights, as in the source. The weights of a vertex should sum to 1.
    /// If they do not, the skinning equation uses them as they are, and drawing divides by their
    /// sum.
    pub weights: Vec<f32>,
}

impl Influences {
    /// The palette entries of a vertex, each with its share of the vertex as drawn: its weight
    /// divided by the sum of the vertex's weights. Empty past the last vertex.
    pub fn shares(&self, vertex: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let range = vertex * self.per_vertex..(vertex + 1) * self.per_vertex;
        let entries = self.entries.get(range.clone()).unwrap_or_default();
        let weights = self.weights.get(range).unwrap_or_default();
        let sum: f32 = weights.iter().sum();
        let whole = if sum > 0.0 { sum } else { 1.0 };
        entries
            .iter()
            .zip(weights)
            .map(move |(entry, weight)| (usize::from(*entry), weight / whole))
    }
}

/// A triangle mesh in bind space.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the base colour, one per vertex or empty; v increases downwards.
    pub uvs: Vec<[f32; 2]>,
    /// Linear colours that multiply the material's, one per vertex or empty.
    pub colors: Vec<[f32; 4]>,
    /// Palette entries and weights of each vertex.
    pub influences: Influences,
    /// Three vertex indices per triangle, counter-clockwise seen from the front in bind space.
    pub indices: Vec<u32>,
}

/// Returns the position of a vertex at rest in model space, as drawn. `binds` holds `model_from_bind` of each
/// palette entry. Indices out of range are ignored.
pub(crate) fn rest_place(mesh: &Mesh, vertex: usize, binds: &[DAffine3]) -> DVec3 {
    let position = f64math::vec3(mesh.positions[vertex]);
    let moved = |(entry, share): (usize, f32)| {
        Some(binds.get(entry)?.transform_point3(position) * f64::from(share))
    };
    mesh.influences.shares(vertex).filter_map(moved).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_where_they_are_drawn_whatever_the_sum_of_their_weights() {
        let binds = [DAffine3::IDENTITY, DAffine3::from_translation(DVec3::X)];
        let weights = vec![0.25, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let influences =
            Influences { per_vertex: 4, entries: vec![0, 1, 0, 0, 1, 0, 0, 0], weights };
        let mesh = Mesh {
            positions: vec![[1.0, 2.0, 0.0]; 2],
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            influences,
            indices: Vec::new(),
        };
        assert_eq!(rest_place(&mesh, 0, &binds), DVec3::new(1.5, 2.0, 0.0));
        assert_eq!(rest_place(&mesh, 1, &binds), DVec3::ZERO, "no weight");
        assert_eq!(mesh.influences.shares(2).count(), 0, "there is no such vertex");
    }
}
