//! Draws crowds with OpenGL: instanced meshes, skinned in the vertex shader straight from the
//! matrix palettes that a device wrote, without a window.
//!
//! Spaces and units are those of [`populace_model`]; pictures are sRGB with rows from the top;
//! colours in [`Scene`] and [`Instance`] are linear.
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
//! A crowd's palettes need no copy: [`Renderer::take_palettes`] lends its device memory of OpenGL's
//! where it can.
//!
//! The main decision: nothing is computed per vertex on the host. A page of palettes is one storage
//! buffer, and all members of one page that share a character are one draw for each of its parts.

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
pub use palettes::HandOver;
pub use picture::{encode_png, write_png};
pub use renderer::Renderer;
pub use scene::{Ambient, CharacterHandle, Ground, Highlights, Instance, Scene, Sky, Sun};
