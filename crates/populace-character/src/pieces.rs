//! Connected pieces of a surface.

use std::collections::HashMap;

use populace_model::convert::place_bits;

/// Returns for each vertex the first one at the same place.
#[must_use]
pub fn welded(positions: &[[f32; 3]]) -> Vec<usize> {
    let mut first = HashMap::new();
    let all = positions.iter().enumerate();
    all.map(|(vertex, position)| *first.entry(place_bits(*position)).or_insert(vertex)).collect()
}

/// Returns for each vertex the first one of its piece: triangles are of one piece where they share
/// places. `corners` is the result of [`welded`].
#[must_use]
pub fn pieces(corners: &[usize], triangles: &[[u32; 3]]) -> Vec<usize> {
    fn root(parents: &mut [usize], mut vertex: usize) -> usize {
        while parents[vertex] != vertex {
            parents[vertex] = parents[parents[vertex]];
            vertex = parents[vertex];
        }
        vertex
    }
    let mut parents = corners.to_vec();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| root(&mut parents, index as usize));
        let least = a.min(b).min(c);
        for vertex in [a, b, c] {
            parents[vertex] = least;
        }
    }
    (0..parents.len()).map(|vertex| root(&mut parents, vertex)).collect()
}
