use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs, f64math};

use super::*;
use crate::{CharacterSource, Image, Influences, PaletteEntry, Part, TextureFilter, Wrap};

const SKIN: [u8; 3] = [200, 150, 125];
const HAIR: [u8; 3] = [60, 40, 25];
const BLUE: [u8; 3] = [40, 60, 160];

/// Names, parents and heights in metres of the joints.
const JOINTS: [(&str, Option<u32>, [f32; 3]); 13] = [
    ("hips", None, [0.0, 1.0, 0.0]),
    ("spine", Some(0), [0.0, 0.2, 0.0]),
    ("head", Some(1), [0.0, 0.4, 0.0]),
    ("leftUpperLeg", Some(0), [0.1, 0.0, 0.0]),
    ("leftLowerLeg", Some(3), [0.0, -0.5, 0.0]),
    ("leftFoot", Some(4), [0.0, -0.4, 0.0]),
    ("rightUpperLeg", Some(0), [-0.1, 0.0, 0.0]),
    ("rightLowerLeg", Some(6), [0.0, -0.5, 0.0]),
    ("rightFoot", Some(7), [0.0, -0.4, 0.0]),
    ("leftUpperArm", Some(1), [0.2, 0.3, 0.0]),
    ("leftLowerArm", Some(9), [0.3, 0.0, 0.0]),
    ("rightUpperArm", Some(1), [-0.2, 0.3, 0.0]),
    ("rightLowerArm", Some(11), [-0.3, 0.0, 0.0]),
];

/// Palette entry, place at rest in model space, and column of the texture.
type Point = (u16, [f32; 3], usize);

fn mesh(points: &[Point]) -> Mesh {
    Mesh {
        positions: points.iter().map(|p| p.1).collect(),
        normals: vec![[0.0, 0.0, 1.0]; points.len()],
        #[expect(clippy::cast_precision_loss, reason = "three columns")]
        uvs: points.iter().map(|p| [(p.2 as f32 + 0.5) / 3.0, 0.5]).collect(),
        colors: Vec::new(),
        influences: Influences {
            per_vertex: 4,
            entries: points.iter().flat_map(|p| [p.0, 0, 0, 0]).collect(),
            weights: [1.0, 0.0, 0.0, 0.0].repeat(points.len()),
        },
        indices: Vec::new(),
    }
}

/// Returns a character with one textured part. The texture's columns are skin, hair and blue cloth.
fn character(points: &[Point], material: &str) -> Character {
    let joint = |&(name, parent, translation): &(&str, Option<u32>, [f32; 3])| JointSource {
        name: name.into(),
        parent: parent.map(|p| p as usize),
        rest: Trs { translation, ..Trs::IDENTITY },
    };
    let joints: Vec<_> = JOINTS.iter().map(joint).collect();
    let skeleton = Skeleton::new(&joints).unwrap();
    let models = skeleton.rest_models();
    let entry = |(name, ..): &(&str, Option<u32>, [f32; 3])| {
        let joint: JointIndex = skeleton.find(name).unwrap();
        let [x, y, z] = f64math::to_f32(models[joint.index()].translation.to_array());
        let inverse = Trs { translation: [-x, -y, -z], ..Trs::IDENTITY };
        PaletteEntry { joint, joint_from_bind: Affine::from_trs(&inverse) }
    };
    let texture = Texture {
        image: 0,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: TextureFilter::Linear,
    };
    let rgba = [SKIN, HAIR, BLUE].map(|[r, g, b]| [r, g, b, 255]).concat();
    Character::new(CharacterSource {
        name: "atlas".into(),
        palette: JOINTS.iter().map(entry).collect(),
        skeleton,
        parts: vec![Part {
            node: 0,
            node_name: "all".into(),
            primitive: 0,
            material: Some(0),
            mesh: mesh(points),
        }],
        materials: vec![Material {
            name: material.into(),
            base_color_texture: Some(texture),
            ..Material::default()
        }],
        images: vec![Image { width: 3, height: 1, rgba }],
        skins: Vec::new(),
        clips: Vec::new(),
    })
    .unwrap()
}

/// Eight vertices of the face, from which its tone is known, and some of the rest.
fn body() -> Vec<Point> {
    let mut points: Vec<Point> = vec![(2, [0.0, 1.65, 0.1], 0); 8];
    points.extend([
        (2, [0.0, 1.9, 0.0], 1),
        (2, [0.0, 1.65, -0.1], 1),
        (2, [0.0, 1.65, 0.1], 2),
        (1, [0.0, 1.4, 0.1], 2),
        (0, [0.0, 0.95, 0.1], 2),
        (4, [0.1, 0.3, 0.0], 2),
        (4, [0.1, 0.3, 0.0], 0),
        (5, [0.1, 0.05, 0.1], 2),
    ]);
    points
}

#[test]
fn atlas_keeps_skin_and_divides_the_rest_by_joints() {
    use Region::{Hair, Other, Shoes, Skin, Top, Trousers};
    let character = character(&body(), "atlas");
    let regions = RegionFinder::new(&character).regions(0, &character.parts[0].mesh);
    assert_eq!(regions[..8], [Skin; 8]);
    assert_eq!(regions[8..], [Hair, Hair, Other, Top, Trousers, Trousers, Skin, Shoes]);
}

#[test]
fn brown_hair_is_told_from_skin_by_the_tone_of_the_face() {
    assert!(is_skin(HAIR, None), "its hue is that of skin");
    assert!(!is_skin(HAIR, Some(luminance(SKIN))));
    for skin in [[235, 200, 180], [160, 110, 85], [95, 62, 48], SKIN] {
        assert!(is_skin(skin, Some(luminance(skin))), "{skin:?}");
    }
    for cloth in [BLUE, [128; 3], [30, 120, 50], [220, 20, 20]] {
        assert!(!is_skin(cloth, None), "{cloth:?}");
    }
}

#[test]
fn name_of_a_material_comes_before_its_texture() {
    let character = character(&body(), "Wolf3D_Outfit_Top");
    let regions = RegionFinder::new(&character).regions(0, &character.parts[0].mesh);
    assert!(regions.iter().all(|r| *r == Region::Top));
}
