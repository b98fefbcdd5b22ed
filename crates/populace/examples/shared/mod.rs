//! Drawing of a crowd, shared by the examples.

use std::error::Error;

use populace::Crowd;
use populace::character::Character;
use populace_render::{Camera, Instance, Renderer, Scene, write_png};

/// Returns the first argument, or a default name in the current folder.
pub(crate) fn output(name: &str) -> String {
    std::env::args().nth(1).unwrap_or_else(|| name.to_owned())
}

/// Draws the crowd in the state of its last update into a PNG file, without a window.
///
/// `characters` are the crowd's, in the order in which they were added. The camera shows all
/// `points`.
pub(crate) fn draw(
    crowd: &mut Crowd,
    characters: &[&Character],
    points: &[[f32; 3]],
    path: &str,
) -> Result<(), Box<dyn Error>> {
    let size = [960, 400];
    let mut renderer = Renderer::headless(size)?;
    let mut handles = Vec::new();
    for character in characters {
        handles.push(renderer.add_character(character, &|_| false)?);
    }
    renderer.acquire_palettes(crowd)?;
    let instance = |i: populace::Instance| Instance {
        character: handles[i.character.index()],
        world_from_model: i.world_from_model,
        moved: i.moved,
        palette_first: i.palette_first,
        tint: [1.0; 3],
    };
    let instances: Vec<_> = crowd.instances().map(instance).collect();
    let camera = Camera::framing(points.iter().copied(), size[0] as f32 / size[1] as f32);
    renderer.draw(&Scene { camera, ..Scene::default() }, &instances)?;
    write_png(path, &renderer.read_image()?)?;
    Ok(())
}
