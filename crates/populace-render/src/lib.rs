//! Rendering of crowds with OpenGL, without a window or in one. Meshes are instanced, and skinned in the vertex
//! shader from the matrix palettes that a compute device wrote.
//!
//! Spaces and units are those of [`populace_model`]. Pictures are sRGB, top row first. Colours in
//! [`Scene`] and [`Instance`](populace_device::Instance) are linear.
//!
//! ```no_run
//! use populace_device::DrawSource;
//! use populace_film::{Pixels, write_png};
//! use populace_render::{Camera, Renderer, Scene};
//!
//! fn picture(crowd: &mut dyn DrawSource) -> Result<(), Box<dyn std::error::Error>> {
//!     let mut renderer = Renderer::headless([1280, 720])?;
//!     let camera = Camera::framing([[-4.0, 0.0, -9.0], [4.0, 1.8, 0.0]], 1280.0 / 720.0);
//!     renderer.draw(crowd, &camera, &Scene::default())?;
//!     let image = renderer.read_image()?;
//!     Ok(write_png("crowd.png", [image.width, image.height], Pixels::Rgba(&image.rgba))?)
//! }
//! ```
//!
//! [`Renderer::draw`] does all that a picture needs. Callers who choose or tint instances call
//! [`Renderer::acquire_palettes`] and [`Renderer::draw_instances`] instead. The palettes of a crowd
//! are not copied where the driver allows it: the crowd's device writes them into OpenGL buffers.
//!
//! The host computes nothing per vertex. A page of palettes is one buffer texture. One call
//! draws all instances, characters and levels of detail with the same page, shader, material and
//! textures.

mod batch;
mod camera;
mod error;
mod gl;
mod layout;
mod model;
mod models;
mod palettes;
mod programs;
mod renderer;
mod scene;
mod sun;

pub use batch::{Drawn, PassCounts};
pub use camera::Camera;
pub use error::Error;
pub use gl::WindowTarget;
pub use palettes::PaletteInterop;
pub use renderer::Renderer;
pub use renderer::interface::{Sheet, SheetCorner, TexturePatch};
pub use renderer::marks::Marks;
pub use renderer::passes::PassTimes;
pub use scene::{Ambient, Ground, Highlights, Preset, Scene, Sky, Sun};
