//! Prints the gaits of the clips of files, or of the people made by code:
//! `cargo run --example gaits -- [FILE...]`. The clips of files without meshes play on all bodies.

#![expect(clippy::print_stdout, reason = "an example prints what it finds")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use populace::character::Character;
use populace_locomotion::Gait;

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let characters: Vec<Character> = if files.is_empty() {
        populace_cast::cast()?
    } else {
        let load = |file: &String| {
            Ok::<_, Box<dyn Error>>(populace_assets::load(Path::new(file))?.character)
        };
        files.iter().map(load).collect::<Result<_, _>>()?
    };
    let (bodies, motions): (Vec<_>, Vec<_>) =
        characters.into_iter().partition(|character| !character.parts.is_empty());
    for body in bodies.into_iter().map(Arc::new) {
        println!("{}, {:.2} m", body.name, body.height_m());
        println!("  m/s   steps/min  stride m  stands  slides m/s  clip");
        for clip in body.clips.iter().chain(motions.iter().flat_map(|motions| &motions.clips)) {
            let Some(gait) = Gait::measure(&body, clip)? else { continue };
            println!(
                "  {:4.2}  {:9.0}  {:8.2}  {:4.0} %  {:10.3}  {}",
                gait.speed_m_per_sec(),
                gait.cadence_per_min().unwrap_or(0.0),
                gait.stride_m().unwrap_or(0.0),
                100.0 * gait.contact_share(),
                gait.skate_m_per_sec,
                clip.name()
            );
        }
    }
    Ok(())
}
