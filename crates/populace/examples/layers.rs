//! Four people walk. The second also waves, by a clip in a layer that is masked to one arm. The
//! third also bows, by an additive clip in another layer. The fourth does both with half the
//! weight.
//!
//! `cargo run --example layers [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;

use glam::{Quat, Vec3};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Skeleton, Track};
use populace::{ClipPlayback, Crowd, LayerMode, LayerSettings, Mask, Placement};
use populace_cast::{Look, person};

/// Creates a clip that rotates joints about one axis. Angles are in radians, at keys a third of a
/// second apart.
fn clip(
    skeleton: &Skeleton,
    name: &str,
    axis: Vec3,
    joints: &[(&str, [f32; 4])],
) -> Result<Clip, populace::clip::Error> {
    let track = |&(joint, angles): &(&str, [f32; 4])| Track {
        joint: joint.into(),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0],
        values: angles
            .into_iter()
            .flat_map(|angle| Quat::from_axis_angle(axis, angle).to_array())
            .collect(),
    };
    Clip::new(
        ClipSource { name: name.into(), tracks: joints.iter().map(track).collect() },
        skeleton,
    )
}

fn main() -> Result<(), Box<dyn Error>> {
    let woman = person(&Look::woman())?;
    let skeleton = &woman.skeleton;
    let arm = [("r_upper_arm", [-1.2; 4]), ("r_forearm", [-1.0, -1.7, -1.0, -1.7])];
    let wave = clip(skeleton, "Wave", Vec3::Z, &arm)?;
    // An additive clip adds its difference from its first key.
    let bow = clip(
        skeleton,
        "Bow",
        Vec3::X,
        &[("spine", [0.0, 0.35, 0.35, 0.0]), ("chest", [0.0, 0.35, 0.35, 0.0])],
    )?;
    // The falloff smooths the border of the mask at the shoulder.
    let one_arm = Mask::of_subtrees(skeleton, ["r_shoulder"])?.with_falloff(skeleton, 2)?;

    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(woman)?;
    let (wave, bow) = (
        crowd.character_mut(id)?.add_clip(&wave.into())?,
        crowd.character_mut(id)?.add_clip(&bow.into())?,
    );
    let (walk, one_arm) = (crowd.clip(id, "Walk")?, crowd.character_mut(id)?.add_mask(&one_arm)?);
    let added = LayerMode::Additive;
    for (nth, (waves, bows)) in
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.5)].into_iter().enumerate()
    {
        let member =
            crowd.spawn(id, Placement::at([nth as f32 * 1.1 - 1.65, 0.0, 0.0]).facing(0.4))?;
        crowd.member_mut(member)?.set_layer(
            1,
            LayerSettings { weight: waves, ..LayerSettings::default() },
            Some(one_arm),
        )?;
        crowd.member_mut(member)?.set_layer(
            2,
            LayerSettings { weight: bows, mode: added },
            None,
        )?;
        crowd.member_mut(member)?.play(walk, ClipPlayback::looping())?;
        crowd
            .member_mut(member)?
            .play(wave, ClipPlayback::looping().on_layer(1).fade_in_secs(0.3))?;
        crowd.member_mut(member)?.play(bow, ClipPlayback::once().on_layer(2))?;
        println!("{nth}: walks, waves by {waves}, bows by {bows}");
    }
    crowd.update(0.6)?;
    let path = shared::output("layers.png");
    shared::draw(&mut crowd, &[[-2.4, -0.1, 0.4], [2.4, 2.1, 0.4]], &path)?;
    println!("all four on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
