//! Images of textures.

use crate::{Texture, Wrap};

/// A decoded image, straight alpha. Colours are sRGB; other textures hold numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
    /// `width x height x 4` bytes, rows from the top.
    pub rgba: Vec<u8>,
}

impl Image {
    /// Returns red, green, blue and alpha of the texel at a texture coordinate: the nearest one,
    /// wrapped as the texture wraps.
    #[must_use]
    pub fn texel(&self, texture: &Texture, uv: [f32; 2]) -> [u8; 4] {
        let column = texel_index(uv[0], self.width, texture.wrap_u);
        let row = texel_index(uv[1], self.height, texture.wrap_v);
        self.rgba.as_chunks().0[row * self.width as usize + column]
    }
}

/// Returns the linear light, from 0 to 1, of a byte of sRGB (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb(byte: u8) -> f64 {
    let value = f64::from(byte) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// Returns the index of the texel at a texture coordinate.
fn texel_index(at: f32, size: u32, wrap: Wrap) -> usize {
    let at = f64::from(at);
    let within = match wrap {
        Wrap::Repeat => at.rem_euclid(1.0),
        Wrap::MirroredRepeat => 1.0 - (at.rem_euclid(2.0) - 1.0).abs(),
        Wrap::ClampToEdge => at.clamp(0.0, 1.0),
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and bounded by the next line"
    )]
    let index = (within * f64::from(size)) as usize;
    index.min(size.saturating_sub(1) as usize)
}

#[cfg(test)]
mod tests {
    use populace_model::{JointSource, Skeleton, Trs};

    use super::*;
    use crate::{Character, CharacterSource, TextureFilter};

    #[test]
    fn images_of_other_sizes_than_their_bytes_are_refused() {
        let joint = JointSource { name: "base".into(), parent: None, rest: Trs::IDENTITY };
        let skeleton = Skeleton::new(&[joint]).unwrap();
        for (width, height) in [(u32::MAX, u32::MAX), (1 << 31, 1 << 31), (2, 1), (0, 1)] {
            let source = CharacterSource {
                name: "post".into(),
                skeleton: skeleton.clone(),
                palette: vec![],
                parts: vec![],
                materials: vec![],
                images: vec![Image { width, height, rgba: vec![0; 4] }],
                skins: vec![],
                clips: vec![],
            };
            let refused = Character::new(source).unwrap_err().to_string();
            assert!(refused.contains(&format!("for {width} x {height} pixels")), "{refused}");
        }
    }

    #[test]
    fn texels_are_found_beyond_the_edges() {
        let at = |at, wrap| texel_index(at, 4, wrap);
        assert_eq!([at(1.3, Wrap::Repeat), at(-0.1, Wrap::Repeat)], [1, 3]);
        assert_eq!([at(1.1, Wrap::MirroredRepeat), at(-0.3, Wrap::MirroredRepeat)], [3, 1]);
        assert_eq!([at(7.0, Wrap::ClampToEdge), at(-7.0, Wrap::ClampToEdge)], [3, 0]);
        assert_eq!(at(1.0, Wrap::Repeat), 0);
    }

    #[test]
    fn texel_is_that_of_its_row_and_column() {
        let rgba = (0..24).collect();
        let image = Image { width: 3, height: 2, rgba };
        let wrap = Wrap::Repeat;
        let texture =
            Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter: TextureFilter::Linear };
        assert_eq!(image.texel(&texture, [0.5, 0.75]), [16, 17, 18, 19]);
        assert_eq!(image.texel(&texture, [-0.1, 1.2]), [8, 9, 10, 11]);
    }

    #[test]
    fn light_of_srgb_is_that_of_the_standard() {
        assert_eq!([0, 255].map(linear_from_srgb), [0.0, 1.0]);
        assert!((linear_from_srgb(188) - 0.502_886).abs() < 1e-5);
        assert!((linear_from_srgb(10) - 10.0 / 255.0 / 12.92).abs() < 1e-9);
    }
}
