//! A field of wheat in gusts of wind. The wind is a user stage that runs after Transform for every
//! joint of every stalk: in OpenCL C on OpenCL devices, and in Rust on the native device. Both draw
//! the same picture.
//!
//! `cargo run --release --example wind [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;

use populace::character::{
    Character, CharacterSource, Influences, Material, Mesh, PaletteEntry, Part,
};
use populace::model::{JointSource, Skeleton};
use populace::{Affine, After, Crowd, Device, Placement, StageJoint, StageUse, Trs, UserStage};

/// Number of joints of a stalk.
const JOINTS: u16 = 6;
/// Distance between joints.
const JOINT_M: f32 = 0.17;

/// Gusts move over the field as waves. Parameters: strength, length in metres and period in
/// seconds.
const WIND: &str = "
void wind(StageJoint *joint)
{
    const float *p = joint->parameters;
    float x = joint->place.x / p[1] + joint->place.z * 0.07f - stage_phase(joint, p[2]) + \
                    joint->values.x;
    x -= floor(x);
    const float lean = p[0] * (0.25f + 6.0f * (x - x * x * x) * (x - x * x * x));
    const float4 axis = stage_to_model(joint, (float4)(0.0f, 0.0f, -1.0f, 0.0f));
    stage_rotate(joint, (float4)(axis.xyz * lean, 1.0f - 0.5f * lean * lean));
}
";

fn wind(joint: &mut StageJoint) {
    let (p, [place_x, _, place_z]) = (joint.parameters, joint.place.position);
    let x = place_x / p[1] + place_z * 0.07 - joint.phase(p[2]) + joint.values[0];
    let x = x - x.floor();
    let lean = p[0] * (0.25 + 6.0 * (x - x * x * x) * (x - x * x * x));
    let [x, y, z] = joint.to_model([0.0, 0.0, -1.0]).map(|c| c * lean);
    joint.rotate([x, y, z, 1.0 - 0.5 * lean * lean]);
}

/// Creates a stalk: a chain of joints, and rings of three vertices skinned to the joint at their
/// height.
fn stalk() -> Result<Character, populace::character::Error> {
    let joint = |at: u16| JointSource {
        name: format!("node{at}"),
        parent: at.checked_sub(1).map(usize::from),
        rest: Trs { translation: [0.0, if at == 0 { 0.0 } else { JOINT_M }, 0.0], ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&(0..JOINTS).map(joint).collect::<Vec<_>>())?;
    let down = |at: f32| {
        Affine::from_trs(&Trs { translation: [0.0, -at * JOINT_M, 0.0], ..Trs::IDENTITY })
    };
    let entry = |joint| PaletteEntry { joint, joint_from_bind: down(joint.0 as f32) };
    let palette: Vec<_> = skeleton.joints().map(entry).collect();
    let (mut positions, mut normals, mut colors) = (vec![], vec![], vec![]);
    let (mut entries, mut weights, mut indices) = (vec![], vec![], vec![]);
    for (ring, width) in (0_u16..).zip([0.012, 0.011, 0.01, 0.009, 0.034, 0.03, 0.002]) {
        for [x, z] in [[0.0, 1.0], [0.87, -0.5], [-0.87, -0.5]] {
            positions.push([x * width, f32::from(ring).min(5.9) * JOINT_M, z * width]);
            normals.push([x, 0.0, z]);
            let shade = 0.35 + f32::from(ring) * 0.11;
            colors.push([0.72 * shade, 0.38 * shade, 0.07 * shade, 1.0]);
            entries.extend([ring.min(JOINTS - 1), 0, 0, 0]);
            weights.extend([1.0, 0.0, 0.0, 0.0]);
        }
    }
    for (ring, a, b) in
        (0..6).flat_map(|ring| [(3 * ring, 0, 1), (3 * ring, 1, 2), (3 * ring, 2, 0)])
    {
        indices.extend([ring + a, ring + b, ring + 3 + a, ring + b, ring + 3 + b, ring + 3 + a]);
    }
    let influences = Influences { per_vertex: 4, entries, weights };
    let mesh = Mesh { positions, normals, uvs: vec![], colors, influences, indices };
    let (name, materials) = ("stalk".to_owned(), vec![Material::default()]);
    let parts =
        vec![Part { node: 0, node_name: name.clone(), primitive: 0, material: Some(0), mesh }];
    let (images, skins, clips) = (vec![], vec![], vec![]);
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts,
        materials,
        images,
        skins,
        clips,
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let stalk = stalk()?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(10_000).build()?;
    let id = crowd.add_character(stalk)?;
    let wind =
        crowd.add_stage(After::Transform, UserStage::new("wind").opencl_c(WIND).rust(wind))?;
    crowd.set_stage_parameters(wind, &[0.13, 3.5, 4.0])?;
    for nth in 0..10_000_u16 {
        let [a, b, c] = [0.754_877_7, 0.569_840_3, 0.347_296].map(|k| (f32::from(nth) * k).fract());
        let place =
            Placement::at([12.0 * a - 6.0, 0.0, -9.0 * b]).scaled(0.85 + 0.3 * c).facing(6.0 * c);
        let member = crowd.spawn(id, place)?;
        crowd
            .member_mut(member)?
            .set_stage(wind, StageUse::on_all().with_values([0.12 * c, 0.0, 0.0, 0.0]))?;
    }
    let (path, points) = (shared::output("wind.png"), [[-3.2, 0.0, 0.0], [3.2, 1.3, -3.0]]);
    let mut pictures = Vec::new();
    for (device, secs) in [(Device::native(), 1.5), (Device::best(), 0.0)] {
        crowd.move_to(device)?;
        crowd.update(secs)?;
        shared::draw(&mut crowd, &points, &path)?;
        println!("10000 stalks in the wind on {}, drawn to {path}", crowd.device_info().name);
        pictures.push(std::fs::read(&path)?);
    }
    println!("both pictures are the same: {}", pictures[0] == pictures[1]);
    Ok(())
}
