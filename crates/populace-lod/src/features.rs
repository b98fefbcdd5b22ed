//! Features: small separate pieces of a surface, such as eyes, brows and buttons.

use std::collections::HashMap;

use glam::Vec3;
use populace_character::{pieces, welded};

/// Greatest extent of a feature, as a fraction of the character's size.
const LARGEST: f32 = 0.04;
/// Pieces face the mean direction of their triangles if it is at least this long. It is 0 for a closed
/// surface and 1 for a flat one.
const LEAST_FACING: f32 = 0.05;

/// A piece of a surface: the triangles that share places.
struct Piece {
    least: Vec3,
    most: Vec3,
    /// Sum of the normals of the triangles, each twice as long as its triangle is large.
    normal: Vec3,
    /// Sum of the lengths of these normals.
    area: f32,
}

impl Piece {
    fn of(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let (least, most) = (a.min(b).min(c), a.max(b).max(c));
        Self { least, most, normal, area: normal.length() }
    }

    fn add(&mut self, other: &Self) {
        self.least = self.least.min(other.least);
        self.most = self.most.max(other.most);
        self.normal += other.normal;
        self.area += other.area;
    }
}

/// Returns for each vertex of a feature the direction in which the feature faces, 0 if it is closed, and
/// `None` for other vertices. `size_m` is that of the character.
pub(crate) fn features(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    size_m: f32,
) -> Vec<Option<Vec3>> {
    let pieces_of = pieces(&welded(positions), triangles);
    let mut pieces: HashMap<usize, Piece> = HashMap::new();
    for triangle in triangles {
        let piece = Piece::of(triangle.map(|vertex| Vec3::from(positions[vertex as usize])));
        pieces
            .entry(pieces_of[triangle[0] as usize])
            .and_modify(|all| all.add(&piece))
            .or_insert(piece);
    }
    let facing = |vertex: usize| {
        let piece = pieces.get(&pieces_of[vertex])?;
        let is_open = piece.normal.length() >= LEAST_FACING * piece.area;
        let normal = if is_open { piece.normal.normalize_or_zero() } else { Vec3::ZERO };
        ((piece.most - piece.least).length() <= LARGEST * size_m).then_some(normal)
    };
    (0..positions.len()).map(facing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pieces_are_features_and_face_where_they_are_open() {
        // A plate of 2 cm that faces +Z, of triangles with vertices of their own, and a larger one.
        let plate =
            |m: f32| [[0.0, 0.0, m], [m, 0.0, m], [m, m, m], [0.0, 0.0, m], [m, m, m], [0.0, m, m]];
        let tetrahedron = [[5.0, 0.0, 0.0], [5.01, 0.0, 0.0], [5.0, 0.01, 0.0], [5.0, 0.0, 0.01]];
        let positions: Vec<[f32; 3]> =
            plate(0.02).into_iter().chain(plate(0.1)).chain(tetrahedron).collect();
        let mut triangles = vec![[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]];
        triangles.extend([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|t| t.map(|i| 12 + i)));
        let found = features(&positions, &triangles, 1.8);
        assert_eq!(found[..6], [Some(Vec3::Z); 6]);
        assert_eq!(found[6..12], [None; 6]);
        assert_eq!(found[12..], [Some(Vec3::ZERO); 4]);
    }
}
