//! Sharp things drawn over pictures: text, trails, labels, a clock and a legend; and the colour
//! scales that they share with the people they explain.
//!
//! ```
//! use populace_overlay::{Canvas, Corner, Legend, Scale, Trail};
//!
//! # fn main() -> Result<(), populace_overlay::Error> {
//! let mut rgba = vec![255; 4 * 640 * 360];
//! let mut canvas = Canvas::new(&mut rgba, [640, 360])?;
//! let scale = Scale::number(0.0, 2.0);
//! let trail = Trail {
//!     points: vec![[100.0, 100.0], [200.0, 120.0], [300.0, 180.0]],
//!     colors: vec![scale.color(0.4).srgb(), scale.color(1.3).srgb()],
//!     depths_m: Vec::new(),
//!     opacity: 0.8,
//!     width_px: 3.0,
//! };
//! canvas.trails(&[trail], &[]);
//! canvas.clock(12.4, Corner::TopLeft);
//! let (title, unit) = ("Speed".to_owned(), "m/s".to_owned());
//! let legend = Legend { title, unit, scale, words: Vec::new(), has_none: false };
//! canvas.legend(&legend, Corner::BottomRight);
//! # Ok(())
//! # }
//! ```
//!
//! The font is a stroke font of this crate. It has the letters of most European languages that are
//! written in Latin script; other characters are empty boxes. The same calls give the same bytes.

mod canvas;
mod error;
mod font;
mod oklab;
mod panels;
mod scale;
mod strokes;
mod text;
mod ticks;
mod trails;

pub use canvas::Canvas;
pub use error::Error;
pub use font::text_width;
pub use font::truetype::truetype;
pub use oklab::Color;
pub use panels::{Corner, Legend};
pub use scale::{Scale, WORD_COLORS};
pub use text::{Anchor, Label, TextStyle};
pub use trails::Trail;
