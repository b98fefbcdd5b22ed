//! Windowless rendering of crowds with OpenGL. Meshes are instanced, and skinned in the vertex
//! shader from the matrix palettes that a compute device wrote.
//!
//! Spaces and units are those of [`populace_model`]. Pictures are sRGB, top row first. Colours in
//! [`Scene`] and [`Instance`] are linear.
//!
//! ```no_run
//! use populace_device::layout::Float4;
//! use populace_character::Character;
//! use populace_model::Affine;
//! use populace_render::{Camera, Instance, Renderer, Scene, write_png};
//!
//! # fn picture(character: &Character, palette: &[Float4]) -> Result<(), populace_render::Error> {
//! let mut renderer = Renderer::headless([1280, 720])?;
//! let knight = renderer.add_character(character, &|part| part.node_name == "Helmet")?;
//! renderer.upload_page(0, palette)?;
//! let instance = Instance {
//!     character: knight,
//!     world_from_model: Affine::IDENTITY,
//!     palette_first: 0,
//!     moved: [0.0; 3],
//!     tint: [1.0; 3],
//! };
//! let camera = Camera::framing([[-1.0, 0.0, -1.0], [1.0, 1.8, 1.0]], 1280.0 / 720.0);
//! renderer.draw(&Scene { camera, ..Scene::default() }, &[instance])?;
//! write_png("knight.png", &renderer.read_image()?)
//! # }
//! ```
//!
//! The palettes of a crowd are not copied where the driver allows it:
//! [`Renderer::acquire_palettes`] has the crowd's device write into OpenGL buffers.
//!
//! The host computes nothing per vertex. A page of palettes is one storage buffer. All instances of
//! a character in one page are drawn with one call for each of its parts.

mod batch;
mod camera;
mod error;
mod gl;
mod layout;
mod model;
mod palettes;
mod picture;
mod programs;
mod renderer;
mod scene;
mod sun;

pub use camera::Camera;
pub use error::Error;
pub use palettes::PaletteInterop;
pub use picture::{encode_png, write_png};
pub use renderer::Renderer;
pub use scene::{Ambient, CharacterHandle, Ground, Highlights, Instance, Scene, Sky, Sun};
