//! Feet on the ground.

use populace::core::math::vec3;
use populace::{Feet, Foot, Ground, Placement, Play};

use crate::body::{distance, everywhere, joint};

pub(crate) fn feet() -> Feet {
    let foot = |side: &str| Foot {
        hip: joint(&format!("{side}UpperLeg")),
        knee: joint(&format!("{side}LowerLeg")),
        ankle: joint(&format!("{side}Foot")),
    };
    Feet { pelvis: joint("hips"), feet: vec![foot("left"), foot("right")], weight: 1.0 }
}

/// Rest height of the ankle in metres.
const ANKLE: f32 = 0.08;

/// Walks a member over a ground and returns how far a foot moved at most from one frame to the next while planted, how long
/// feet were planted, and how near the ankle came to the ground and how far from where it should be while planted.
fn walk(stage: &mut crate::body::Stage, height: impl Fn(f32, f32) -> f32, normal_y: f32) -> (f32, u32, f32) {
    let speed = 0.9;
    let at = |secs: f32| {
        let (x, z) = (0.3, -1.0 + speed * secs);
        Placement::at([x, height(x, z), z])
    };
    let member = stage.member(at(0.0));
    let clip = stage.clip("walk");
    stage.crowd.play(member, clip, Play::looping()).expect("a clip that plays");
    stage.crowd.plant_with(member, &feet()).expect("feet");
    let plain = stage.member(at(0.0));
    stage.crowd.play(plain, clip, Play::looping()).expect("a clip that plays");
    let (mut moved, mut planted, mut lifted) = (0.0_f32, 0, 0.0_f32);
    let mut last: [Option<[f32; 3]>; 2] = [None, None];
    for frame in 0..180_u16 {
        stage.crowd.place(member, at(f32::from(frame) / 60.0)).expect("a member");
        stage.update(1.0 / 60.0);
        let world = stage.crowd.placement(member).expect("a member").world_from_model();
        for (foot, name) in ["leftFoot", "rightFoot"].into_iter().enumerate() {
            let clip_height = stage.place(plain, name)[1];
            let place = world.transform_point(stage.place(member, name));
            // The leg is 0.85 m, and up to 3% of that a foot counts as planted.
            let is_planted = clip_height - ANKLE < 0.025;
            if is_planted {
                planted += 1;
                moved = moved.max(last[foot].map_or(0.0, |last| distance(last, place)));
                lifted = lifted.max((place[1] - height(place[0], place[2]) - ANKLE / normal_y).abs());
            }
            last[foot] = is_planted.then_some(place);
        }
    }
    (moved, planted, lifted)
}

#[test]
fn planted_feet_stay_put_on_level_ground_and_on_a_slope() {
    everywhere(|stage| {
        let slope = 15.0_f32.to_radians().tan();
        for slopes in [[0.0, 0.0], [0.0, slope], [0.0, -slope], [slope * 0.7, slope * 0.7]] {
            stage.crowd.set_ground(&Ground::plane(0.2, slopes).expect("a plane")).expect("ground");
            let normal = vec3::unit_or([-slopes[0], 1.0, -slopes[1]], [0.0; 3]);
            let (moved, planted, lifted) = walk(stage, |x, z| 0.2 + slopes[0] * x + slopes[1] * z, normal[1]);
            println!(
                "slopes {slopes:?}: {moved} m a frame in {planted} planted frames, {lifted} m off the ground"
            );
            assert!(planted > 50, "feet were planted in {planted} frames alone");
            assert!(moved < 0.002, "a planted foot moved {moved} m");
            assert!(lifted < 0.002, "a planted foot was {lifted} m off the ground");
        }
    });
}

#[test]
fn feet_follow_a_height_field() {
    everywhere(|stage| {
        let height = |x: f32, z: f32| 0.1 * (x * 1.3).sin() + 0.08 * (z * 1.7).cos();
        let samples = (0..200_u16).flat_map(|row| {
            (0..60_u16).map(move |column| (f32::from(column) * 0.05 - 1.0, f32::from(row) * 0.05 - 3.0))
        });
        let heights = samples.map(|(x, z)| height(x, z)).collect();
        let ground = Ground::height_field([-1.0, -3.0], 0.05, 60, heights).expect("a height field");
        stage.crowd.set_ground(&ground).expect("ground");
        let (moved, planted, lifted) = walk(stage, height, 1.0);
        println!("heights: {moved} m a frame in {planted} planted frames, {lifted} m off the ground");
        // The ground is interpolated, and its slope is not in what is asked here.
        assert!(moved < 0.002 && planted > 50 && lifted < 0.006, "{moved} {planted} {lifted}");
    });
}
