//! Conversion of a surface to drawable parts, one for each region, with identical borders.

use std::collections::BTreeMap;

use glam::DVec3;
use populace_character::{Influences, Material, Mesh, Part};
use populace_model::convert::single;

use super::{Region, Surface};
use crate::{Colors, rig::Joints};

/// Influences per vertex.
const WIDTH: usize = 4;

/// Returns the parts of a surface and their materials. Palette entries are the indices of joints in
/// source order.
pub(crate) fn parts(
    surface: &Surface,
    joints: &Joints,
    colors: &Colors,
) -> (Vec<Part>, Vec<Material>) {
    let normals = normals(surface);
    let mut parts = Vec::new();
    let mut materials = Vec::new();
    for region in Region::ALL {
        let mut mesh = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            influences: Influences { per_vertex: WIDTH, entries: Vec::new(), weights: Vec::new() },
            indices: Vec::new(),
        };
        let mut vertices = BTreeMap::new();
        for (corners, _) in surface.triangles.iter().filter(|(_, r)| *r == region) {
            for &corner in corners {
                let index = *vertices.entry(corner).or_insert_with(|| {
                    mesh.positions.push(narrow(surface.points[corner]));
                    mesh.normals.push(narrow(normals[corner]));
                    for (entry, weight) in influences(surface, joints, corner) {
                        mesh.influences.entries.push(entry);
                        mesh.influences.weights.push(weight);
                    }
                    mesh.positions.len() - 1
                });
                mesh.indices.push(u32::try_from(index).unwrap_or(u32::MAX));
            }
        }
        if mesh.indices.is_empty() {
            continue;
        }
        let (name, base_color) = look(region, colors);
        let at = parts.len();
        parts.push(Part {
            node: 0,
            node_name: "body".into(),
            primitive: at,
            material: Some(at),
            mesh,
        });
        materials.push(Material { name: name.into(), base_color, ..Material::default() });
    }
    (parts, materials)
}

/// Returns the name and the linear base colour of a region's material.
fn look(region: Region, colors: &Colors) -> (&'static str, [f32; 4]) {
    let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    let [r, g, b] = colors.skin;
    match region {
        Region::Skin => ("skin", opaque(colors.skin)),
        Region::Hair => ("hair", opaque(colors.hair)),
        Region::Brow => ("eyebrows", opaque(colors.hair)),
        Region::Lips => ("lips", opaque([0.80 * r, 0.5 * g, 0.52 * b])),
        Region::EyeWhite => ("eye white", [0.62, 0.60, 0.57, 1.0]),
        Region::Iris => ("iris", [0.03, 0.018, 0.012, 1.0]),
        Region::Shirt => ("shirt", opaque(colors.shirt)),
        Region::Trousers => ("trousers", opaque(colors.trousers)),
        Region::Shoes => ("shoes", opaque(colors.shoes)),
    }
}

/// Returns unit vertex normals: area-weighted sums of the triangles' normals, across regions.
fn normals(surface: &Surface) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; surface.points.len()];
    for (corners, _) in &surface.triangles {
        let [a, b, c] = corners.map(|corner| surface.points[corner]);
        let normal = (b - a).cross(c - a);
        for &corner in corners {
            normals[corner] += normal;
        }
    }
    normals.into_iter().map(|n| n.normalize_or(DVec3::Y)).collect()
}

/// Returns the four joints with the largest weights at a vertex, and weights that sum to 1.
fn influences(surface: &Surface, joints: &Joints, corner: usize) -> [(u16, f32); WIDTH] {
    let mut by_joint: BTreeMap<u16, f64> = BTreeMap::new();
    for &(segment, weight) in &surface.weights[corner] {
        *by_joint.entry(joints.of_segment[segment]).or_default() += weight;
    }
    let mut strongest: Vec<(u16, f64)> = by_joint.into_iter().collect();
    strongest.sort_by(|a, b| b.1.total_cmp(&a.1));
    strongest.truncate(WIDTH);
    let sum: f64 = strongest.iter().map(|(_, w)| w).sum();
    let mut four = [(strongest[0].0, 0.0); WIDTH];
    for (slot, (joint, weight)) in four.iter_mut().zip(strongest) {
        *slot = (joint, single(weight / sum));
    }
    four
}

/// Rounds a vector to single precision.
pub(crate) fn narrow(v: DVec3) -> [f32; 3] {
    v.to_array().map(single)
}
