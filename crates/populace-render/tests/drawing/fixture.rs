//! Small procedural characters, and palettes of plain matrices.

use populace_character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace_device::layout::Float4;
use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

/// Returns the transform that scales, rotates about z by `roll_rad`, and translates.
pub(crate) fn transform(translation: [f32; 3], roll_rad: f32, scale: [f32; 3]) -> Affine {
    let rotation = glam::Quat::from_rotation_z(roll_rad).to_array();
    Affine::from_trs(&Trs { translation, rotation, scale })
}

/// Returns a translation.
pub(crate) fn at(x: f32, y: f32, z: f32) -> Affine {
    transform([x, y, z], 0.0, [1.0; 3])
}

/// Returns a palette in the layout of the crowd library: three elements for each entry.
pub(crate) fn palette(entries: &[Affine]) -> Vec<Float4> {
    entries.iter().flat_map(|entry| entry.rows.map(Float4)).collect()
}

/// Returns a box from `low` to `high`, skinned to one palette entry.
pub(crate) fn box_mesh(low: [f32; 3], high: [f32; 3], entry: u16) -> Mesh {
    let mut mesh = quad_mesh(entry);
    (mesh.positions, mesh.normals, mesh.indices) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for (side, sign) in [(low, -1.0), (high, 1.0)] {
            let (u, v) = if sign > 0.0 {
                ((axis + 1) % 3, (axis + 2) % 3)
            } else {
                ((axis + 2) % 3, (axis + 1) % 3)
            };
            let first = u32::try_from(mesh.positions.len()).unwrap();
            for (at_u, at_v) in
                [(low[u], low[v]), (high[u], low[v]), (high[u], high[v]), (low[u], high[v])]
            {
                let mut position = side;
                (position[u], position[v]) = (at_u, at_v);
                mesh.positions.push(position);
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                mesh.normals.push(normal);
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
    }
    mesh.uvs.clear();
    mesh.influences = one_influence(mesh.positions.len(), entry);
    mesh
}

/// Returns a square from -1 to 1 that faces +Z. Its upper left corner is at u = v = 0.
pub(crate) fn quad_mesh(entry: u16) -> Mesh {
    Mesh {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        colors: Vec::new(),
        influences: one_influence(4, entry),
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

pub(crate) fn one_influence(vertices: usize, entry: u16) -> Influences {
    Influences {
        per_vertex: 4,
        entries: [entry, 0, 0, 0].repeat(vertices),
        weights: [1.0, 0.0, 0.0, 0.0].repeat(vertices),
    }
}

/// Returns a part named `name` with the material of index `material`.
pub(crate) fn part(name: &str, material: usize, mesh: Mesh) -> Part {
    Part { node: 0, node_name: name.into(), primitive: 0, material: Some(material), mesh }
}

pub(crate) fn plain(base_color: [f32; 4]) -> Material {
    Material { base_color, ..Material::default() }
}

/// Returns a character with `entry_count` root joints at the origin, one for each palette entry.
pub(crate) fn source(
    parts: Vec<Part>,
    materials: Vec<Material>,
    entry_count: u32,
) -> CharacterSource {
    let joint =
        |index| JointSource { name: format!("joint {index}"), parent: None, rest: Trs::IDENTITY };
    let joints: Vec<_> = (0..entry_count).map(joint).collect();
    let entry =
        |index| PaletteEntry { joint: JointIndex(index), joint_from_bind: Affine::IDENTITY };
    CharacterSource {
        name: "fixture".into(),
        skeleton: Skeleton::new(&joints).unwrap(),
        palette: (0..entry_count).map(entry).collect(),
        parts,
        materials,
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    }
}

/// Returns a person of boxes: palette entry 0 moves the body, entry 1 the head.
pub(crate) fn person(body: [f32; 3], head: [f32; 3]) -> Character {
    let color = |[r, g, b]: [f32; 3]| plain([r, g, b, 1.0]);
    let parts = vec![
        part("leg", 0, box_mesh([-0.22, 0.0, -0.1], [-0.05, 0.8, 0.1], 0)),
        part("leg", 0, box_mesh([0.05, 0.0, -0.1], [0.22, 0.8, 0.1], 0)),
        part("body", 0, box_mesh([-0.25, 0.8, -0.14], [0.25, 1.4, 0.14], 0)),
        part("head", 1, box_mesh([-0.13, 1.45, -0.13], [0.13, 1.75, 0.13], 1)),
    ];
    Character::new(source(parts, vec![color(body), color(head)], 2)).unwrap()
}
