//! A jointed figure with a walk, made of capsules.

use glam::{Quat, Vec2, Vec3};
use populace::character::{
    Character, CharacterSource, Error, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace::clip::Clip;
use populace::model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs,
};

/// Names and linear colours of the parts.
const PARTS: [(&str, [f32; 4]); 3] = [
    ("skin", [0.62, 0.36, 0.24, 1.0]),
    ("shirt", [1.0, 1.0, 1.0, 1.0]),
    ("trousers", [0.06, 0.07, 0.11, 1.0]),
];
/// Each joint: its name, its parent, its place relative to the parent, the ends and the radius of
/// its capsule in metres, and its part.
type Bone = (&'static str, Option<usize>, [f32; 3], [[f32; 3]; 2], f32, usize);
#[rustfmt::skip]
const BONES: [Bone; 15] = [
    ("hips", None, [0.0, 0.94, 0.0], [[-0.07, -0.02, 0.0], [0.07, -0.02, 0.0]], 0.125, 2),
    ("spine", Some(0), [0.0, 0.1, 0.0], [[0.0, 0.0, 0.0], [0.0, 0.26, 0.0]], 0.135, 1),
    ("chest", Some(1), [0.0, 0.33, 0.0], [[-0.13, 0.02, 0.0], [0.13, 0.02, 0.0]], 0.08, 1),
    ("head", Some(2), [0.0, 0.13, 0.0], [[0.0, 0.05, 0.01], [0.0, 0.14, 0.02]], 0.1, 0),
    ("l_arm", Some(2), [0.2, 0.02, 0.0], [[0.0, 0.0, 0.0], [0.03, -0.27, 0.0]], 0.052, 1),
    ("l_forearm", Some(4), [0.03, -0.27, 0.0], [[0.0; 3], [0.0, -0.32, 0.0]], 0.042, 0),
    ("r_arm", Some(2), [-0.2, 0.02, 0.0], [[0.0, 0.0, 0.0], [-0.03, -0.27, 0.0]], 0.052, 1),
    ("r_forearm", Some(6), [-0.03, -0.27, 0.0], [[0.0; 3], [0.0, -0.32, 0.0]], 0.042, 0),
    ("l_thigh", Some(0), [0.095, -0.04, 0.0], [[0.0; 3], [0.0, -0.42, 0.0]], 0.078, 2),
    ("l_shin", Some(8), [0.0, -0.42, 0.0], [[0.0; 3], [0.0, -0.41, 0.0]], 0.056, 2),
    ("l_foot", Some(9), [0.0, -0.42, 0.0], [[0.0, -0.01, -0.02], [0.0, -0.01, 0.14]], 0.05, 0),
    ("r_thigh", Some(0), [-0.095, -0.04, 0.0], [[0.0; 3], [0.0, -0.42, 0.0]], 0.078, 2),
    ("r_shin", Some(11), [0.0, -0.42, 0.0], [[0.0; 3], [0.0, -0.41, 0.0]], 0.056, 2),
    ("r_foot", Some(12), [0.0, -0.42, 0.0], [[0.0, -0.01, -0.02], [0.0, -0.01, 0.14]], 0.05, 0),
    ("nose", Some(3), [0.0, 0.08, 0.12], [[0.0, -0.02, 0.0], [0.0, 0.01, -0.01]], 0.018, 0),
];
/// Sides of a capsule, and keys of the walk.
const SIDES: u16 = 16;
const KEYS: u16 = 16;

pub(crate) fn figure() -> Result<Character, Box<dyn std::error::Error>> {
    let joint = |&(name, parent, translation, ..): &Bone| JointSource {
        name: name.into(),
        parent,
        rest: Trs { translation, ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&BONES.iter().map(joint).collect::<Vec<_>>())?;
    let mut origins: Vec<Vec3> = Vec::new();
    for (_, parent, place, ..) in BONES {
        origins.push(Vec3::from(place) + parent.map_or(Vec3::ZERO, |p| origins[p]));
    }
    // Skeletons sort their joints, so each is found by its name.
    let find = |name| skeleton.find(name).ok_or(format!("no joint {name}"));
    let joints: Vec<JointIndex> =
        BONES.iter().map(|bone| find(bone.0)).collect::<Result<_, _>>()?;
    let entry = |(&joint, origin): (&JointIndex, &Vec3)| PaletteEntry {
        joint,
        joint_from_bind: Affine::from_trs(&Trs {
            translation: (-origin).to_array(),
            ..Trs::IDENTITY
        }),
    };
    let palette = joints.iter().zip(&origins).map(entry).collect();
    let clips = vec![Clip::new(walk(), &skeleton)?.into()];
    let parts = (0..PARTS.len()).map(|part| Part {
        node: part,
        node_name: PARTS[part].0.into(),
        primitive: 0,
        material: Some(part),
        mesh: mesh(part, &origins),
    });
    let materials =
        PARTS.map(|(_, base_color)| Material { base_color, ..Material::default() }).to_vec();
    let (name, parts, images, skins) = ("figure".to_owned(), parts.collect(), vec![], vec![]);
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Ok(Character::new(source).map_err(|error: Error| error)?)
}

/// Returns the capsules of one part. Each follows the palette entry of its own joint.
fn mesh(part: usize, origins: &[Vec3]) -> Mesh {
    let (mut positions, mut normals, mut entries, mut indices) = (vec![], vec![], vec![], vec![]);
    for (bone, entry) in BONES.iter().zip(0_u16..).filter(|(bone, _)| bone.5 == part) {
        let [low, high] = bone.3.map(|end| Vec3::from(end) + origins[usize::from(entry)]);
        let up = (high - low).normalize();
        let (right, front) = up.any_orthonormal_pair();
        // Five rings about the lower end, from the pole to the equator, and five about the upper.
        for ring in 0_u16..10 {
            let (end, latitude) =
                if ring < 5 { (low, f32::from(ring) - 4.0) } else { (high, f32::from(ring) - 5.0) };
            let across = Vec2::from_angle(latitude * std::f32::consts::FRAC_PI_8);
            for side in 0..SIDES {
                let around = Vec2::from_angle(f32::from(side) * std::f32::consts::TAU / 16.0);
                let normal = across.x * (around.x * right + around.y * front) + across.y * up;
                let this = u32::try_from(positions.len()).unwrap_or(u32::MAX);
                let next = if side + 1 == SIDES { this + 1 - u32::from(SIDES) } else { this + 1 };
                if ring < 9 {
                    let above = u32::from(SIDES);
                    indices.extend([this, next, next + above, this, next + above, this + above]);
                }
                positions.push((end + normal * bone.4).to_array());
                normals.push(normal.to_array());
                entries.extend([entry, 0, 0, 0]);
            }
        }
    }
    let weights = [1.0, 0.0, 0.0, 0.0].repeat(positions.len());
    let influences = Influences { per_vertex: 4, entries, weights };
    Mesh { positions, normals, uvs: vec![], colors: vec![], influences, indices }
}

/// Returns a walk of one second: angles about the axis from right to left, in radians.
fn walk() -> ClipSource {
    let turned = |joint: &str, angle: &dyn Fn(Vec2) -> f32| {
        let key = |key| {
            let wave = Vec2::from_angle(f32::from(key) * std::f32::consts::TAU / f32::from(KEYS));
            Quat::from_rotation_x(angle(wave)).to_array()
        };
        track(joint, Property::Rotation, (0..=KEYS).flat_map(key).collect())
    };
    let mut tracks = Vec::new();
    for (side, sign) in [("l", 1.0), ("r", -1.0)] {
        let joint = |name: &str| format!("{side}_{name}");
        let thigh = move |wave: Vec2| -0.08 - 0.4 * sign * wave.y;
        let shin = move |wave: Vec2| 0.12 + 0.75 * (sign * wave.x).max(0.0).powi(2);
        tracks.push(turned(&joint("thigh"), &thigh));
        tracks.push(turned(&joint("shin"), &shin));
        tracks.push(turned(&joint("foot"), &|wave| -0.8 * (thigh(wave) + shin(wave))));
        tracks.push(turned(&joint("arm"), &|wave| 0.4 * sign * wave.y));
        tracks.push(turned(&joint("forearm"), &|wave| -0.35 + 0.15 * sign * wave.y));
    }
    let lift = |key| {
        let wave = Vec2::from_angle(f32::from(key) * std::f32::consts::TAU / f32::from(KEYS));
        [0.0, 0.935 - 0.05 * wave.y * wave.y, 0.0]
    };
    tracks.push(track("hips", Property::Translation, (0..=KEYS).flat_map(lift).collect()));
    ClipSource { name: "Walk".into(), tracks }
}

fn track(joint: &str, property: Property, values: Vec<f32>) -> Track {
    let times = (0..=KEYS).map(|key| f32::from(key) / f32::from(KEYS)).collect();
    Track { joint: joint.into(), property, interpolation: Interpolation::Linear, times, values }
}
