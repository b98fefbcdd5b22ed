//! Surfaces whose backs cannot be seen: closed ones of two-sided materials.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use populace_character::{Mesh, pieces, welded};
use populace_model::f64math;

/// Least volume of a solid, as a fraction of the cube over the square root of its area. Two layers
/// of a sheet have less.
const LEAST_VOLUME: f64 = 1e-4;

/// Triangles of a mesh, as indices of their corners.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Sides {
    /// Those of which only the front can be seen.
    pub(super) solid: Vec<u32>,
    /// All others.
    pub(super) sheets: Vec<u32>,
}

/// A connected piece of a surface.
#[derive(Clone, Copy, Default)]
struct Piece {
    area: f64,
    /// Above 0 if fronts face outwards.
    volume: f64,
    /// Length of the edges that only one side has.
    open_edge: f64,
}

impl Piece {
    /// Returns true if a hole as long as all open edges takes at most the fraction `most_open` of
    /// the area. For a flat sheet it would take all of it.
    fn is_solid(&self, most_open: f64) -> bool {
        self.open_edge * self.open_edge <= 4.0 * PI * most_open * self.area
            && self.volume > LEAST_VOLUME * self.area * self.area.sqrt()
    }
}

impl Sides {
    /// Parts the triangles of a mesh, piece by piece. A piece is solid if its holes take at most
    /// the fraction `most_open` of its area: with 0, if it has none.
    pub(super) fn of(mesh: &Mesh, most_open: f64) -> Self {
        let corners = welded(&mesh.positions);
        let triangles = mesh.indices.as_chunks::<3>().0;
        let pieces_of = pieces(&corners, triangles);
        let at = |index: u32| f64math::vec3(mesh.positions[index as usize]);
        let mut pieces: HashMap<usize, Piece> = HashMap::new();
        let mut edges: HashMap<[usize; 2], (i32, f64, usize)> = HashMap::new();
        for triangle in triangles {
            let root = pieces_of[triangle[0] as usize];
            let [a, b, c] = triangle.map(at);
            let piece = pieces.entry(root).or_default();
            piece.area += 0.5 * (b - a).cross(c - a).length();
            // From the piece's own corner, so that a hole far from the origin does not count.
            let origin = f64math::vec3(mesh.positions[root]);
            piece.volume += (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let ends = [triangle[from], triangle[to]];
                let [start, end] = ends.map(|index| corners[index as usize]);
                let (key, sign) = if start < end { ([start, end], 1) } else { ([end, start], -1) };
                let length =
                    ends.map(at).into_iter().reduce(|p, q| q - p).map_or(0.0, DVec3::length);
                edges.entry(key).or_insert((0, length, root)).0 += sign;
            }
        }
        for (sides, length, root) in edges.into_values() {
            let piece = pieces.entry(root).or_default();
            piece.open_edge += f64::from(sides.abs()) * length;
        }
        let mut found = Self::default();
        for triangle in triangles {
            let piece = pieces[&pieces_of[triangle[0] as usize]];
            let side = if piece.is_solid(most_open) { &mut found.solid } else { &mut found.sheets };
            side.extend(triangle);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use populace_character::Influences;

    use super::*;

    /// The faces of a box `height` high over a unit square, without the last `left_out` of
    /// twelve triangles; the lid comes last. Each face has its own corners.
    fn open_box(height: f32, left_out: usize) -> Mesh {
        const FACES: [[u8; 4]; 6] =
            [[0, 2, 3, 1], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [4, 5, 7, 6]];
        let corner = |bits: u8| {
            let of = |axis: u8| f32::from(bits >> axis & 1);
            [of(0), of(1), height * of(2)]
        };
        let positions: Vec<_> = FACES.as_flattened().iter().map(|bits| corner(*bits)).collect();
        let faces = (0u32..24).step_by(4).flat_map(|f| [0, 1, 2, 0, 2, 3].map(|i| f + i));
        Mesh {
            normals: vec![[0.0, 0.0, 1.0]; positions.len()],
            uvs: Vec::new(),
            colors: Vec::new(),
            influences: Influences {
                per_vertex: 4,
                entries: vec![0; 4 * positions.len()],
                weights: [1.0, 0.0, 0.0, 0.0].repeat(positions.len()),
            },
            indices: faces.take(36 - 3 * left_out).collect(),
            positions,
        }
    }

    fn is_solid(mesh: &Mesh, most_open: f64) -> bool {
        let sides = Sides::of(mesh, most_open);
        assert!(sides.solid.is_empty() || sides.sheets.is_empty(), "one piece is one or the other");
        sides.sheets.is_empty()
    }

    #[test]
    fn closed_surfaces_are_solid_unless_they_are_inside_out() {
        let mut mesh = open_box(1.0, 0);
        assert!(is_solid(&mesh, 0.0));
        mesh.indices.reverse();
        assert!(!is_solid(&mesh, 0.0), "its backs face outwards");
        assert!(!is_solid(&open_box(0.0, 0), 0.0), "two layers of a sheet");
    }

    #[test]
    fn holes_count_by_their_part_of_the_surface() {
        assert!(!is_solid(&open_box(1.0, 2), 0.0));
        assert!(!is_solid(&open_box(1.0, 2), 0.1), "the hole takes a fifth of the box");
        assert!(is_solid(&open_box(8.0, 2), 0.1), "a long box without a lid");
        assert!(!is_solid(&open_box(8.0, 11), 0.5), "a single triangle");
    }

    #[test]
    fn pieces_are_judged_one_by_one() {
        let (mut both, sheet) = (open_box(1.0, 0), open_box(1.0, 11));
        let first = u32::try_from(both.positions.len()).expect("few corners");
        both.positions.extend(sheet.positions.iter().map(|[x, y, z]| [x + 5.0, *y, *z]));
        both.indices.extend(sheet.indices.iter().map(|index| first + index));
        let sides = Sides::of(&both, 0.0);
        assert_eq!((sides.solid.len(), sides.sheets.len()), (36, 3));
    }
}
