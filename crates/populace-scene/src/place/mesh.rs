//! Meshes with flat faces.

use populace::character::{Influences, Mesh};

use super::plan::Point;

/// Side in metres of the square that a texture covers.
const TEXTURE_M: f64 = 2.0;

/// A mesh that grows by faces, with a normal and texture coordinates of its own for each vertex.
#[derive(Default)]
pub(super) struct Faces {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
}

/// Returns the point over a point of the plan, in world space.
pub(super) fn over(at: Point, height_m: f64) -> [f64; 3] {
    [at[0], height_m, -at[1]]
}

impl Faces {
    /// Adds a triangle, counter-clockwise seen from its front. One without area is left out.
    pub(super) fn triangle(&mut self, corners: [[f64; 3]; 3]) {
        self.face(&corners, &[0, 1, 2]);
    }

    /// Adds a quadrilateral in a plane, counter-clockwise seen from its front. One without area is
    /// left out.
    pub(super) fn quad(&mut self, corners: [[f64; 3]; 4]) {
        self.face(&corners, &[0, 1, 2, 0, 2, 3]);
    }

    fn face(&mut self, corners: &[[f64; 3]], indices: &[u32]) {
        let Some(normal) = normal(corners) else { return };
        let Ok(first) = u32::try_from(self.positions.len()) else { return };
        let points = corners.iter().map(|p| p.map(single));
        self.positions.extend(points);
        self.normals.extend(corners.iter().map(|_| normal.map(single)));
        self.uvs.extend(corners.iter().map(|p| [p[0], p[2]].map(|v| single(v / TEXTURE_M))));
        self.indices.extend(indices.iter().map(|i| first + i));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Returns the mesh, all moved by the first palette entry.
    pub(super) fn into_mesh(self) -> Mesh {
        let count = self.positions.len();
        Mesh {
            positions: self.positions,
            normals: self.normals,
            uvs: self.uvs,
            colors: Vec::new(),
            influences: Influences {
                per_vertex: 4,
                entries: vec![0; 4 * count],
                weights: [1.0, 0.0, 0.0, 0.0].repeat(count),
            },
            indices: self.indices,
        }
    }
}

/// Returns the unit normal of a face by Newell's method; `None` without area.
fn normal(corners: &[[f64; 3]]) -> Option<[f64; 3]> {
    let origin = corners.first()?;
    let mut sum = [0.0; 3];
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        // Relative to a corner: far from the origin, products would lose the digits that count.
        let [a, b] = [a, b].map(|p| [0, 1, 2].map(|i| p[i] - origin[i]));
        for (i, sum) in sum.iter_mut().enumerate() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            *sum += a[j] * b[k] - a[k] * b[j];
        }
    }
    let length = sum.iter().map(|v| v * v).sum::<f64>().sqrt();
    (length > 1e-9).then(|| sum.map(|v| v / length))
}

#[expect(clippy::cast_possible_truncation, reason = "rounds to single precision")]
fn single(v: f64) -> f32 {
    v as f32
}
