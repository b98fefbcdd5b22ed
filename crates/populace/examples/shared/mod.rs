//! Drawing of a crowd, shared by the examples.

use std::error::Error;

use populace::Crowd;
use populace_film::{Pixels, write_png};
use populace_render::{Camera, Renderer, Scene};

/// Returns the first argument, or a default name in the current folder.
pub(crate) fn output(name: &str) -> String {
    std::env::args().nth(1).unwrap_or_else(|| name.to_owned())
}

/// Draws the crowd in the state of its last update into a PNG file, without a window. The camera
/// shows all `points`.
pub(crate) fn draw(
    crowd: &mut Crowd,
    points: &[[f32; 3]],
    path: &str,
) -> Result<(), Box<dyn Error>> {
    let size = [960, 400];
    let mut renderer = Renderer::headless(size)?;
    let camera = Camera::framing(points.iter().copied(), size[0] as f32 / size[1] as f32);
    renderer.draw(crowd, &camera, &Scene::default())?;
    let image = renderer.read_image()?;
    write_png(path, size, Pixels::Rgba(&image.rgba))?;
    Ok(())
}
