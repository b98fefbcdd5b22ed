//! A bead that marks a position.

use populace::character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace::model::{JointSource, Skeleton};
use populace::{Affine, JointIndex, Trs};

/// Creates an octahedron as a character of one joint. `size` is the distance in metres from the
/// centre to each corner.
pub(crate) fn bead(
    name: &str,
    size: f32,
    base_color: [f32; 4],
) -> Result<Character, populace::character::Error> {
    let joint = JointSource { name: name.into(), parent: None, rest: Trs::IDENTITY };
    let normals: Vec<[f32; 3]> = vec![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, -1.0],
    ];
    let face = |[x, y, z]: [u32; 3]| if (x + y + z) % 2 == 1 { [x, y, z] } else { [x, z, y] };
    let faces = [0, 3]
        .into_iter()
        .flat_map(|x| [1, 4].map(|y| [x, y]))
        .flat_map(|[x, y]| [[x, y, 2], [x, y, 5]]);
    let mesh = Mesh {
        positions: normals.iter().map(|n| n.map(|c| c * size)).collect(),
        influences: Influences {
            per_vertex: 4,
            entries: vec![0; 24],
            weights: [1.0, 0.0, 0.0, 0.0].repeat(6),
        },
        indices: faces.flat_map(face).collect(),
        uvs: Vec::new(),
        colors: Vec::new(),
        normals,
    };
    let part = Part { node: 0, node_name: name.into(), primitive: 0, material: Some(0), mesh };
    Character::new(CharacterSource {
        name: name.into(),
        skeleton: Skeleton::new(&[joint])?,
        palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
        parts: vec![part],
        materials: vec![Material { base_color, double_sided: true, ..Material::default() }],
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    })
}
