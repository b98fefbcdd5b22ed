//! Triangulation and normals.

use glam::DVec3;

use crate::json::to_f32;
use crate::primitive::Topology;

/// Converts a triangle list, strip or fan to a triangle list (glTF 2.0, section 3.7.2.1). Leftover
/// vertices at the end are dropped.
pub(crate) fn triangulate(indices: Vec<u32>, topology: Topology) -> Vec<u32> {
    match topology {
        Topology::Triangles => {
            let mut indices = indices;
            indices.truncate(indices.len() / 3 * 3);
            indices
        }
        // Every other triangle of a strip has its winding reversed, so that all face the same way.
        Topology::Strip => indices
            .windows(3)
            .enumerate()
            .flat_map(|(at, w)| if at % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        Topology::Fan => {
            let rim = indices.get(1..).unwrap_or_default();
            rim.windows(2).flat_map(|w| [w[0], w[1], indices[0]]).collect()
        }
    }
}

/// Flat normals for a primitive without normals (glTF 2.0, section 3.7.2.1).
pub(crate) struct FlatNormals {
    /// One normal per vertex: first the vertices of the file, then the copies.
    pub(crate) normals: Vec<[f32; 3]>,
    /// For each copy, the index of the vertex in the file that it duplicates.
    pub(crate) copies: Vec<u32>,
}

/// Computes one normal per triangle. Vertices of the file keep their index and take the normal of
/// the first triangle that uses them. If another triangle has a different normal, a copy of the
/// vertex is appended and `indices` is changed to refer to it.
pub(crate) fn flat_normals(positions: &[[f32; 3]], indices: &mut [u32]) -> FlatNormals {
    let mut normals: Vec<Option<[f32; 3]>> = vec![None; positions.len()];
    let mut copies = Vec::new();
    let mut copied_normals = Vec::new();
    for triangle in indices.chunks_exact_mut(3) {
        let normal = triangle_normal([0, 1, 2].map(|corner| positions[triangle[corner] as usize]));
        for corner in triangle {
            let own = normals[*corner as usize].get_or_insert(normal);
            if *own == normal {
                continue;
            }
            copies.push(*corner);
            copied_normals.push(normal);
            let copy = positions.len() + copies.len() - 1;
            *corner = u32::try_from(copy).unwrap_or(*corner);
        }
    }
    let own = normals.into_iter().map(|n| n.unwrap_or(UP));
    FlatNormals { normals: own.chain(copied_normals).collect(), copies }
}

/// Replacement for a normal of length zero.
const UP: [f32; 3] = [0.0, 1.0, 0.0];

fn triangle_normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|p| DVec3::from_array(p.map(f64::from)));
    unit((b - a).cross(c - a))
}

fn unit(vector: DVec3) -> [f32; 3] {
    vector.try_normalize().map_or(UP, |n| n.to_array().map(to_f32))
}

/// Scales normals to unit length.
pub(crate) fn normalize(normals: &mut [[f32; 3]]) {
    for normal in normals {
        *normal = unit(DVec3::from_array(normal.map(f64::from)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(triangulate(vec![0, 1, 2, 3, 4], Topology::Strip), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert_eq!(triangulate(vec![0, 1, 2, 3], Topology::Fan), [1, 2, 0, 2, 3, 0]);
        assert_eq!(triangulate(vec![0, 1, 2, 3], Topology::Triangles), [0, 1, 2]);
        for topology in [Topology::Triangles, Topology::Strip, Topology::Fan] {
            assert!(triangulate(vec![], topology).is_empty());
            assert!(triangulate(vec![0, 1], topology).is_empty());
        }
    }

    #[test]
    fn flat_normals_append_copies_at_a_folded_edge() {
        // A square folded along its diagonal 0-1: z up for the first triangle, x up for the second.
        let positions = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let mut indices = [0, 1, 2, 0, 1, 3];
        let flat = flat_normals(&positions, &mut indices);
        assert_eq!(indices, [0, 1, 2, 4, 5, 3]);
        assert_eq!(flat.copies, [0, 1]);
        assert_eq!(flat.normals[0], [0.0, 0.0, 1.0]);
        assert_eq!(flat.normals[3], [1.0, 0.0, 0.0]);
        assert_eq!(flat.normals[4], flat.normals[3]);
        // Two triangles in one plane share their vertices.
        let mut flat_square = [0, 1, 2, 2, 1, 3];
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert!(flat_normals(&positions, &mut flat_square).copies.is_empty());
    }
}
