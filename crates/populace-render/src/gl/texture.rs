//! Textures of materials.

use std::rc::Rc;

use glow::HasContext as _;
use populace_character::{Image, TextureFilter, Wrap};

use super::Gl;
use crate::Error;

/// Upper bound of the anisotropy. Higher values make no visible difference on characters.
const ANISOTROPY: f32 = 8.0;

/// A texture with all mip levels and its sampling parameters.
pub(crate) struct Texture {
    gl: Rc<Gl>,
    raw: glow::Texture,
}

/// Sampling parameters of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sampling {
    /// Wrap mode along u and v.
    pub(crate) wrap: [Wrap; 2],
    pub(crate) filter: TextureFilter,
    pub(crate) coding: Coding,
}

/// Meaning of a texture's bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Coding {
    /// Colours, which are decoded when sampled.
    #[default]
    Srgb,
    /// Numbers from 0 to 1.
    Linear,
}

impl Texture {
    /// Uploads `image`. Its first row, the top one, is at v = 0.
    pub(crate) fn new(gl: &Rc<Gl>, image: &Image, sampling: Sampling) -> Result<Self, Error> {
        let limit = gl.limits().texture_size;
        let largest = image.width.max(image.height);
        let sizes = (i32::try_from(image.width), i32::try_from(image.height));
        let (Ok(width), Ok(height), true) = (sizes.0, sizes.1, largest <= limit) else {
            let (size, limit) = (u64::from(largest), u64::from(limit));
            return Err(Error::TooLarge { what: "the side of a texture", size, limit });
        };
        let format = match sampling.coding {
            Coding::Srgb => glow::SRGB8_ALPHA8,
            Coding::Linear => glow::RGBA8,
        };
        let levels = i32::try_from(u32::BITS - largest.leading_zeros()).unwrap_or(1);
        // SAFETY: the context is current.
        let raw = unsafe { gl.functions.create_texture() }
            .map_err(|code| Error::GlError { operation: "create a texture".into(), code })?;
        let texture = Self { gl: Rc::clone(gl), raw };
        texture.bind(0);
        // SAFETY: the context is current and the texture bound. The driver reads width x height x 4
        // bytes. `rgba` has that length, which `populace_character::Character::new` checks. Rows of
        // 4-byte pixels have no padding.
        unsafe {
            let pixels = glow::PixelUnpackData::Slice(Some(&image.rgba));
            let functions = &gl.functions;
            functions.tex_storage_2d(glow::TEXTURE_2D, levels, format, width, height);
            functions.tex_sub_image_2d(
                glow::TEXTURE_2D,
                0,
                0,
                0,
                width,
                height,
                glow::RGBA,
                glow::UNSIGNED_BYTE,
                pixels,
            );
            functions.generate_mipmap(glow::TEXTURE_2D);
        }
        texture.set_sampling(sampling);
        gl.check("upload a texture")?;
        Ok(texture)
    }

    fn set_sampling(&self, sampling: Sampling) {
        let wrap = |wrap| match wrap {
            Wrap::Repeat => glow::REPEAT,
            Wrap::MirroredRepeat => glow::MIRRORED_REPEAT,
            Wrap::ClampToEdge => glow::CLAMP_TO_EDGE,
        };
        let (near, far) = match sampling.filter {
            TextureFilter::Linear => (glow::LINEAR, glow::LINEAR_MIPMAP_LINEAR),
            TextureFilter::Nearest => (glow::NEAREST, glow::NEAREST_MIPMAP_LINEAR),
        };
        let [u, v] = sampling.wrap.map(wrap);
        let parameters = [
            (glow::TEXTURE_WRAP_S, u),
            (glow::TEXTURE_WRAP_T, v),
            (glow::TEXTURE_MAG_FILTER, near),
            (glow::TEXTURE_MIN_FILTER, far),
        ];
        for (name, value) in parameters {
            // SAFETY: the context is current and the texture bound; enumerants are below 2^31.
            unsafe {
                self.gl.functions.tex_parameter_i32(glow::TEXTURE_2D, name, value.cast_signed())
            }
        }
        let anisotropy = self.gl.limits().anisotropy.min(ANISOTROPY);
        if anisotropy > 1.0 && sampling.filter == TextureFilter::Linear {
            // SAFETY: as above; a limit above 1 implies that the extension is present.
            unsafe {
                self.gl.functions.tex_parameter_f32(
                    glow::TEXTURE_2D,
                    glow::TEXTURE_MAX_ANISOTROPY_EXT,
                    anisotropy,
                );
            }
        }
    }

    /// Binds the texture to a texture unit.
    pub(crate) fn bind(&self, unit: u32) {
        // SAFETY: the context is current; OpenGL 4.3 has at least 48 units, and this crate uses
        // lower numbers only.
        unsafe {
            self.gl.functions.active_texture(glow::TEXTURE0 + unit);
            self.gl.functions.bind_texture(glow::TEXTURE_2D, Some(self.raw));
        }
    }
}

impl Drop for Texture {
    fn drop(&mut self) {
        if self.gl.make_current().is_ok() {
            // SAFETY: the context is current, and `self` owns the texture.
            unsafe { self.gl.functions.delete_texture(self.raw) }
        }
    }
}
