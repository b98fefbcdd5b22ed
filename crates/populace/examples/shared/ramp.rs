//! A ramp to stand on.

use populace::character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace::model::{JointSource, Skeleton};
use populace::{Affine, JointIndex, Trs};

/// Creates a ramp as a character of one joint: 8 m wide, 3 m deep, rising towards +X by `rise`
/// metres per metre.
pub(crate) fn ramp(rise: f32) -> Result<Character, populace::character::Error> {
    let joint = JointSource { name: "ramp".into(), parent: None, rest: Trs::IDENTITY };
    let corner = |x: f32, z: f32| [4.0 * x, 4.0 * x * rise, 1.5 * z];
    let positions =
        vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    let length = rise.hypot(1.0);
    let mesh = Mesh {
        normals: vec![[-rise / length, 1.0 / length, 0.0]; 4],
        influences: Influences {
            per_vertex: 4,
            entries: vec![0; 16],
            weights: [1.0, 0.0, 0.0, 0.0].repeat(4),
        },
        indices: vec![0, 1, 2, 0, 2, 3],
        uvs: Vec::new(),
        colors: Vec::new(),
        positions,
    };
    let part = Part { node: 0, node_name: "ramp".into(), primitive: 0, material: Some(0), mesh };
    let color = [0.35, 0.33, 0.28, 1.0];
    Character::new(CharacterSource {
        name: "ramp".into(),
        skeleton: Skeleton::new(&[joint])?,
        palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
        parts: vec![part],
        materials: vec![Material { base_color: color, double_sided: true, ..Material::default() }],
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    })
}
