//! Plays a woman's walk on a man, on a man with longer limbs, and on a child whose joints have
//! other names and rest poses. All keep their own proportions.
//!
//! `cargo run --example retarget [PICTURE.png] [FILE.glb CLIP]` plays a clip of a file instead.

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;
use std::sync::Arc;

use populace::{ClipPlayback, Crowd, Placement};
use populace_cast::{Look, person};

fn main() -> Result<(), Box<dyn Error>> {
    let (woman, man, child) =
        (person(&Look::woman())?, person(&Look::man())?, person(&Look::child())?);
    let mut arguments = std::env::args().skip(2);
    let source = match (arguments.next(), arguments.next()) {
        (Some(file), Some(clip)) => {
            populace_assets::load(&file)?.character.clips.iter().find(|c| c.name() == clip).cloned()
        }
        _ => woman.clips.iter().find(|clip| clip.name() == "Walk").map(Arc::clone),
    };
    let source = source.ok_or("no clip has that name")?;

    let mut crowd = Crowd::builder().build()?;
    let mut people = Vec::new();
    for (nth, character) in [&woman, &man, &man, &child].into_iter().enumerate() {
        let id = crowd.add_character(character.clone())?;
        let clip = crowd.character_mut(id)?.add_clip(&source)?;
        let member =
            crowd.spawn(id, Placement::at([nth as f32 * 1.1 - 1.65, 0.0, 0.0]).facing(0.6))?;
        crowd.member_mut(member)?.play(clip, ClipPlayback::looping().phase(0.1))?;
        if nth == 2 {
            // Longer legs and arms for this member alone.
            let lengths =
                character.skeleton.joints().map(|joint| match character.skeleton.name(joint) {
                    name if name.contains("Shin") || name.contains("Foot") => 1.15,
                    name if name.contains("Forearm") || name.contains("Hand") => 1.15,
                    // Raised by the longer legs.
                    "Pelvis" => 1.14,
                    _ => 1.0,
                });
            crowd.member_mut(member)?.set_proportions(&lengths.collect::<Vec<f32>>())?;
        }
        people.push((
            member,
            character,
            crowd.character(id)?.roles().map_or("none", |roles| roles.naming()),
        ));
    }
    crowd.update(0.35)?;
    for (member, character, naming) in &people {
        let joints = crowd.member_mut(*member)?.model_from_joints()?;
        let hips = character
            .skeleton
            .joints()
            .find(|j| ["hips", "Pelvis"].contains(&character.skeleton.name(*j)));
        let height = hips.map_or(0.0, |hips| joints[hips.index()].origin()[1]);
        println!("{}: roles found by {naming} names, hips {height:.2} m high", character.name);
    }
    let path = shared::output("retarget.png");
    shared::draw(&mut crowd, &[[-2.4, -0.3, 0.4], [2.4, 2.2, 0.0]], &path)?;
    println!("on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
