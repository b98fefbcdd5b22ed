//! Windows: the picture, a user interface over it, and showing both.

use std::collections::HashMap;

use populace_character::Image;

use super::Renderer;
use crate::Error;
use crate::gl::{InterfaceTexture, Triangles, WindowPicture};
use crate::layout::Corner;
use crate::programs::Kind;

/// A corner of a triangle of a user interface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SheetCorner {
    /// Pixels from the left and from the top of the window.
    pub position: [f32; 2],
    /// Texture coordinates from 0 to 1.
    pub uv: [f32; 2],
    /// sRGB with premultiplied alpha; the texture is multiplied by it.
    pub color: [u8; 4],
}

/// Triangles of a user interface that share a texture.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Left, top, width and height in pixels of the rectangle outside of which nothing is drawn.
    pub clip: [u32; 4],
    /// Number of the texture; sheets without it are not drawn.
    pub texture: u64,
    /// Corners.
    pub corners: &'a [SheetCorner],
    /// Three corners of each triangle.
    pub indices: &'a [u32],
}

/// New texels of a texture.
#[derive(Clone, Copy, Debug)]
pub struct TexturePatch<'a> {
    /// Number of the texture, chosen by the caller.
    pub texture: u64,
    /// Column and row of the first texel that changes; `None` makes a new texture of this size.
    pub at: Option<[u32; 2]>,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// sRGB with premultiplied alpha, top row first, four bytes each.
    pub rgba: &'a [u8],
}

/// What a window shows besides the picture.
pub(super) struct Interface {
    window: WindowPicture,
    textures: HashMap<u64, InterfaceTexture>,
    /// Kept for their memory.
    corners: Vec<Corner>,
    indices: Vec<u32>,
}

impl Renderer {
    /// Creates a texture of the interface, or replaces a part of one. A part that reaches past its
    /// texture, or whose bytes have another number, is ignored.
    ///
    /// # Errors
    ///
    /// [`Error::NoWindow`], [`Error::TooLarge`], or an error of the driver.
    pub fn set_texture(&mut self, patch: &TexturePatch<'_>) -> Result<(), Error> {
        let gl = std::rc::Rc::clone(&self.gl);
        let interface = self.interface()?;
        if patch.at.is_none() {
            let texture = InterfaceTexture::new(&gl, patch.size)?;
            interface.textures.insert(patch.texture, texture);
        }
        match interface.textures.get(&patch.texture) {
            Some(texture) => texture.write(patch.at.unwrap_or_default(), patch.size, patch.rgba),
            None => Ok(()),
        }
    }

    /// Releases a texture of the interface.
    pub fn remove_texture(&mut self, texture: u64) {
        if let Some(interface) = &mut self.interface {
            interface.textures.remove(&texture);
        }
    }

    /// Brings the last picture into a window of `size` pixels (width, height), and a user interface
    /// over it. The upper left corner of the picture comes to `at`, in pixels from that of the
    /// window; `margin` is the sRGB colour beside it, from 0 to 1.
    ///
    /// # Errors
    ///
    /// [`Error::NoWindow`], or an error of the driver.
    pub fn compose(
        &mut self,
        size: [u32; 2],
        at: [i32; 2],
        margin: [f32; 3],
        sheets: &[Sheet<'_>],
    ) -> Result<(), Error> {
        self.interface()?;
        self.gl.resize_window(size);
        let Some(interface) = &mut self.interface else { return Err(Error::NoWindow) };
        interface.window.begin(size, margin);
        self.picture.copy_to_window(at, size[1]);
        let program = self.programs.get(Kind::Interface)?;
        let Interface { window, textures, corners, indices } = interface;
        corners.clear();
        indices.clear();
        let mut runs = Vec::with_capacity(sheets.len());
        for sheet in sheets {
            let Some(texture) = textures.get(&sheet.texture) else { continue };
            let Ok(first) = u32::try_from(corners.len()) else { break };
            // An index past the corners would read what is behind them.
            if sheet.indices.iter().any(|index| *index as usize >= sheet.corners.len()) {
                continue;
            }
            corners.extend(sheet.corners.iter().map(|corner| to_clip(corner, size)));
            let range = [indices.len(), sheet.indices.len()];
            indices.extend(sheet.indices.iter().map(|index| index + first));
            runs.push(Triangles { texture, indices: range, clip: sheet.clip });
        }
        window.draw(program, (corners, indices), &runs, size[1])
    }

    /// Shows the composed window. Waits for the screen if it is ahead of it.
    ///
    /// # Errors
    ///
    /// [`Error::NoWindow`], or [`Error::ContextLost`].
    pub fn present(&mut self) -> Result<(), Error> {
        self.gl.make_current()?;
        self.gl.swap()
    }

    /// Reads back the composed window of `size` pixels before it is presented, top row first.
    ///
    /// # Errors
    ///
    /// [`Error::NoWindow`], or an error of the driver.
    pub fn read_window(&mut self, size: [u32; 2]) -> Result<Image, Error> {
        self.interface()?.window.read(size)
    }

    /// Returns the interface, and makes it if there is none.
    fn interface(&mut self) -> Result<&mut Interface, Error> {
        self.gl.make_current()?;
        if !self.gl.has_window() {
            return Err(Error::NoWindow);
        }
        match &mut self.interface {
            Some(interface) => Ok(interface),
            empty => {
                let window = WindowPicture::new(&self.gl)?;
                let (corners, indices) = (Vec::new(), Vec::new());
                Ok(empty.insert(Interface { window, textures: HashMap::new(), corners, indices }))
            }
        }
    }
}

/// Returns a corner in clip space.
fn to_clip(corner: &SheetCorner, size: [u32; 2]) -> Corner {
    #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
    let [width, height] = size.map(|side| side.max(1) as f32);
    let [x, y] = corner.position;
    let position = [2.0 * x / width - 1.0, 1.0 - 2.0 * y / height];
    Corner { position, uv: corner.uv, color: corner.color }
}
