//! Characters that are written and read again.

use populace_assets::{WriteOptions, load_from_slice, to_glb};
use populace_character::{
    AlphaMode, Character, CharacterSource, Image, Influences, Level, Material, Mesh, PaletteEntry,
    Part, Texture, TextureFilter, Wrap,
};
use populace_model::{Affine, JointSource, Skeleton, Trs};

use crate::{assert_note, assert_problem, loaded};

const OPTIONS: WriteOptions = WriteOptions { generator: "a test", copyright: "nobody" };

/// Three triangles around an edge, which follow two palette entries.
fn mesh(triangles: usize, x: f32) -> Mesh {
    let positions = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.5], [x, 1.0, -0.25]].to_vec();
    Mesh {
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: vec![[0.25, 0.75]; 4],
        colors: vec![[0.5, 0.25, 1.0, 1.0]; 4],
        influences: Influences {
            per_vertex: 4,
            entries: [0, 1, 0, 0].repeat(4),
            weights: [0.75, 0.25, 0.0, 0.0].repeat(4),
        },
        indices: [[0, 1, 2], [0, 2, 3], [1, 2, 3]][..triangles].concat(),
        positions,
    }
}

fn source() -> CharacterSource {
    let joint = |name: &str, parent, y| JointSource {
        name: name.into(),
        parent,
        rest: Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&[joint("hips", None, 1.0), joint("head", Some(0), 0.5)])
        .expect("a skeleton");
    let entry = |joint: usize, y: f32| PaletteEntry {
        joint: skeleton.joint_from_source(joint),
        joint_from_bind: Affine::from_trs(&Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY }),
    };
    let part = |node: usize, name: &str, x| Part {
        node,
        node_name: name.into(),
        primitive: 0,
        material: Some(node - 2),
        mesh: mesh(3, x),
    };
    let texture = Texture {
        image: 0,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::MirroredRepeat,
        filter: TextureFilter::Nearest,
    };
    let coat = Material {
        name: "Coat".into(),
        base_color: [0.5, 0.25, 0.125, 1.0],
        base_color_texture: Some(texture),
        alpha: AlphaMode::Mask { cutoff: 0.25 },
        double_sided: true,
        metallic: 0.25,
        roughness: 0.75,
        metallic_roughness_texture: Some(texture),
        normal_texture: Some(texture),
        normal_scale: 0.5,
        occlusion_texture: Some(texture),
        occlusion_strength: 0.25,
        emissive: [0.5, 4.0, 1.0],
        emissive_texture: Some(texture),
    };
    CharacterSource {
        name: "character".into(),
        palette: vec![entry(0, -1.0), entry(1, -1.5)],
        parts: vec![part(2, "body", 0.0), part(5, "hat", 2.0)],
        materials: vec![coat, Material::default(), Material::default(), Material::default()],
        images: vec![Image { width: 1, height: 2, rgba: vec![1, 2, 3, 255, 4, 5, 6, 128] }],
        skins: Vec::new(),
        clips: Vec::new(),
        skeleton,
    }
}

fn empty() -> Mesh {
    Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences { per_vertex: 4, entries: Vec::new(), weights: Vec::new() },
        indices: Vec::new(),
    }
}

/// The hat is too small for the second level.
fn levels() -> Vec<Level> {
    vec![
        Level { error_m: 0.01, meshes: vec![mesh(2, 0.0), mesh(1, 2.0)], joint_count: 2 },
        Level { error_m: 0.04, meshes: vec![mesh(1, 0.0), empty()], joint_count: 2 },
    ]
}

fn character() -> Character {
    let character = Character::new(source()).expect("valid parts");
    character.with_levels(levels()).expect("valid levels")
}

/// Replaces bytes of the same length in the JSON of a file.
fn changed(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = file.windows(from.len()).position(|w| w == from.as_bytes()).expect("it is there");
    [&file[..at], to.as_bytes(), &file[at + from.len()..]].concat()
}

#[test]
fn character_is_read_as_it_was_written() {
    let (written, file) = (character(), to_glb(&character(), &OPTIONS).unwrap());
    let read = loaded(&file);
    assert_eq!(read.notes, [], "a written file follows the rules");
    assert_eq!(read.generator.as_deref(), Some("a test"));
    assert!(String::from_utf8_lossy(&file).contains(r#""copyright":"nobody""#));
    let read = read.character;
    assert_eq!(read.parts.len(), written.parts.len());
    for (read, written) in read.parts.iter().zip(&written.parts) {
        assert_eq!(read, written);
    }
    assert_eq!(read.palette, written.palette);
    assert_eq!(read.materials, written.materials);
    assert_eq!(read.images, written.images);
    assert_eq!(read.levels(), written.levels());
    let names = |c: &Character| -> Vec<_> {
        c.skeleton.joints().map(|j| (c.skeleton.name(j).to_owned(), *c.skeleton.rest(j))).collect()
    };
    assert_eq!(names(&read), names(&written));
}

#[test]
fn wide_palettes_and_second_influences_survive() {
    let mut source = source();
    let joints: Vec<_> = (0..300)
        .map(|joint| JointSource { name: format!("j{joint}"), parent: None, rest: Trs::IDENTITY })
        .collect();
    source.skeleton = Skeleton::new(&joints).unwrap();
    source.palette = source
        .skeleton
        .joints()
        .map(|joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY })
        .collect();
    let influences = &mut source.parts[0].mesh.influences;
    influences.per_vertex = 8;
    influences.entries = (0..32).map(|at| 268 + at).collect();
    influences.weights = vec![0.125; 32];
    source.parts.truncate(1);
    source.parts[0].node = 300;
    let written = Character::new(source).unwrap();
    let read = loaded(&to_glb(&written, &WriteOptions::default()).unwrap()).character;
    let joints = |c: &Character| -> Vec<_> {
        let entries = &c.parts[0].mesh.influences.entries;
        let name = |e: &u16| c.skeleton.name(c.palette[usize::from(*e)].joint).to_owned();
        entries.iter().map(name).collect()
    };
    assert_eq!(joints(&read), joints(&written));
    assert_eq!(read.parts[0].mesh.influences.per_vertex, 8);
}

#[test]
fn two_bindings_of_one_joint_in_a_part_are_refused() {
    let mut source = source();
    source.palette[1].joint = source.palette[0].joint;
    let error = to_glb(&Character::new(source).unwrap(), &OPTIONS).unwrap_err().to_string();
    assert!(error.contains("\"body\" binds the joint \"hips\" in two ways"), "{error}");
}

#[test]
fn parts_without_triangles_are_refused() {
    for mesh in [empty(), Mesh { indices: Vec::new(), ..mesh(1, 0.0) }] {
        let mut source = source();
        source.parts[1].mesh = mesh;
        let written = to_glb(&Character::new(source).unwrap(), &OPTIONS);
        let error = written.map(|file| file.len()).unwrap_err().to_string();
        assert!(error.contains("\"hat\" has no triangles"), "{error}");
    }
}

#[test]
fn levels_of_other_files_are_checked() {
    let file = to_glb(&character(), &OPTIONS).unwrap();
    let unknown = changed(&file, r#""error_m":[0"#, r#""error_x":[0"#);
    assert_note(&unknown, "nodes[2]: has levels of detail without an error in metres");
    assert!(loaded(&unknown).character.levels().is_empty());
    let missing = changed(&file, r#""ids":[3,4]"#, r#""ids":[3,9]"#);
    assert_problem(&missing, "nodes[2].extensions.MSFT_lod.ids[1]: refers to node 9");
    let falling = load_from_slice(&changed(&file, "[0.00999", "[0.05999"), None);
    assert!(falling.is_ok(), "the parts differ, so their levels are ignored");
}
