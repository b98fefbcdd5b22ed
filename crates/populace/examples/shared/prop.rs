//! Props to hold and to wear.

use std::f32::consts::TAU;

use populace::character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace::model::{JointSource, Skeleton};
use populace::{Affine, JointIndex, Trs};

/// Number of corners of a ring.
const RING_CORNERS: u16 = 24;

/// A piece of a prop: its linear colour, and its outline as pairs of radius and height in metres.
pub(crate) type Piece<'a> = ([f32; 3], &'a [[f32; 2]]);

/// Creates a character of one joint from pieces that are surfaces of revolution about +Y.
pub(crate) fn revolved(
    name: &str,
    pieces: &[Piece],
) -> Result<Character, populace::character::Error> {
    let joint = JointSource { name: name.into(), parent: None, rest: Trs::IDENTITY };
    let part = |(piece, (_, outline)): (usize, &Piece)| Part {
        node: 0,
        node_name: name.into(),
        primitive: piece,
        material: Some(piece),
        mesh: mesh(outline),
    };
    let material = |([r, g, b], _): &Piece| Material {
        base_color: [*r, *g, *b, 1.0],
        double_sided: true,
        ..Material::default()
    };
    Character::new(CharacterSource {
        name: name.into(),
        skeleton: Skeleton::new(&[joint])?,
        palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
        parts: pieces.iter().enumerate().map(part).collect(),
        materials: pieces.iter().map(material).collect(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    })
}

/// Creates the mesh of a piece. Each segment of the outline has two rings of its own, so that edges
/// stay sharp.
fn mesh(outline: &[[f32; 2]]) -> Mesh {
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (segment, ends) in (0_u32..).zip(outline.windows(2)) {
        let along = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let length = along[0].hypot(along[1]);
        for [radius, height] in [ends[0], ends[1]] {
            for corner in 0..RING_CORNERS {
                let (sin, cos) = (f32::from(corner) / f32::from(RING_CORNERS) * TAU).sin_cos();
                positions.push([radius * cos, height, radius * sin]);
                normals.push([
                    along[1] / length * cos,
                    -along[0] / length,
                    along[1] / length * sin,
                ]);
            }
        }
        let first = segment * 2 * u32::from(RING_CORNERS);
        for corner in 0..u32::from(RING_CORNERS) {
            let next = (corner + 1) % u32::from(RING_CORNERS);
            let [a, b] = [first + corner, first + next];
            let [c, d] = [a, b].map(|low| low + u32::from(RING_CORNERS));
            indices.extend([a, c, b, b, c, d]);
        }
    }
    let count = positions.len();
    let influences = Influences {
        per_vertex: 4,
        entries: vec![0; 4 * count],
        weights: [1.0, 0.0, 0.0, 0.0].repeat(count),
    };
    Mesh { positions, normals, influences, indices, uvs: Vec::new(), colors: Vec::new() }
}
