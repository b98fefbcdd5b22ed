//! Conversion of surfaces to drawable parts: one for each region of the body, with identical
//! borders, and one for each option.

use std::collections::BTreeMap;

use glam::DVec3;
use populace_character::{Influences, Material, Mesh, Part};
use populace_model::convert::single;

use super::{Item, Region, Surface, Wardrobe};
use crate::{Colors, rig::Joints};

/// Influences per vertex.
const WIDTH: usize = 4;

/// Returns the parts of a dressed body and their materials. Palette entries are the indices of
/// joints in source order.
pub(crate) fn parts(
    wardrobe: &Wardrobe,
    joints: &Joints,
    colors: &Colors,
) -> (Vec<Part>, Vec<Material>) {
    let (mut parts, mut materials) = (Vec::new(), Vec::new());
    let mut add = |node_name: String, name: String, [r, g, b]: [f32; 3], mesh: Mesh| {
        let at = parts.len();
        let material = Some(at);
        parts.push(Part { node: 0, node_name, primitive: at, material, mesh });
        materials.push(Material { name, base_color: [r, g, b, 1.0], ..Material::default() });
    };
    let normals = wardrobe.body.normals();
    for region in Region::ALL {
        let mesh = mesh(&wardrobe.body, &normals, region, joints);
        if !mesh.indices.is_empty() {
            add("body".into(), name(region).into(), color(region, colors), mesh);
        }
    }
    for Item { group, name: item, region, color, surface } in &wardrobe.items {
        let mesh = mesh(surface, &surface.normals(), *region, joints);
        let material = format!("{} {item}", name(*region));
        add(format!("Option:{group}:{item}"), material, *color, mesh);
    }
    (parts, materials)
}

/// Returns the name of a region's material.
fn name(region: Region) -> &'static str {
    match region {
        Region::Skin => "Skin",
        Region::Eyes => "Eyes",
        Region::Hair => "Hair",
        Region::Top => "Top",
        Region::Trousers => "Trousers",
        Region::Shoes => "Shoes",
        Region::Accessory => "Accessory",
    }
}

/// Returns the linear base colour of a region of the body. Eyes are painted in full.
fn color(region: Region, colors: &Colors) -> [f32; 3] {
    match region {
        Region::Skin => colors.skin,
        Region::Eyes => [1.0; 3],
        Region::Hair => colors.hair,
        Region::Top => colors.shirt,
        Region::Trousers => colors.trousers,
        Region::Shoes => colors.shoes,
        Region::Accessory => colors.accessory,
    }
}

/// Returns the triangles of one region.
fn mesh(surface: &Surface, normals: &[DVec3], region: Region, joints: &Joints) -> Mesh {
    let influences_of = |corner| influences(surface, joints, corner);
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences { per_vertex: WIDTH, entries: Vec::new(), weights: Vec::new() },
        indices: Vec::new(),
    };
    let mut vertices = BTreeMap::new();
    for (corners, _) in surface.triangles.iter().filter(|(_, cover)| cover.region == region) {
        for &corner in corners {
            let index = *vertices.entry(corner).or_insert_with(|| {
                mesh.positions.push(narrow(surface.points[corner]));
                mesh.normals.push(narrow(normals[corner]));
                let [r, g, b] = surface.paints[corner].map(single);
                mesh.colors.push([r, g, b, 1.0]);
                for (entry, weight) in influences_of(corner) {
                    mesh.influences.entries.push(entry);
                    mesh.influences.weights.push(weight);
                }
                mesh.positions.len() - 1
            });
            mesh.indices.push(u32::try_from(index).unwrap_or(u32::MAX));
        }
    }
    mesh
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
    // Without a weight, which only numbers that are not finite give rise to, the sum is 0 and the
    // weights are refused.
    let first = strongest.first().map_or(0, |(joint, _)| *joint);
    let mut four = [(first, if sum > 0.0 { 0.0 } else { f32::NAN }); WIDTH];
    for (slot, (joint, weight)) in four.iter_mut().zip(strongest) {
        *slot = (joint, single(weight / sum));
    }
    four
}

/// Rounds a vector to single precision.
pub(crate) fn narrow(v: DVec3) -> [f32; 3] {
    v.to_array().map(single)
}
