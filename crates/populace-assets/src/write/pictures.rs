//! Images and samplers of textures.

use std::io::Cursor;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use populace_character::{Image, Texture, TextureFilter, Wrap};
use serde_json::{Value, json};

/// Returns an image as a PNG file; `None` if its pixels do not match its size.
pub(super) fn png(image: &Image) -> Option<Vec<u8>> {
    let mut png = Cursor::new(Vec::new());
    let encoder = PngEncoder::new(&mut png);
    let color = ExtendedColorType::Rgba8;
    encoder.write_image(&image.rgba, image.width, image.height, color).ok()?;
    Some(png.into_inner())
}

/// Returns the sampler of a texture (glTF 2.0, section 5.26).
pub(super) fn sampler(texture: &Texture) -> Value {
    let wrap = |wrap: Wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    };
    let (near, far) = match texture.filter {
        TextureFilter::Linear => (9729, 9987),
        TextureFilter::Nearest => (9728, 9984),
    };
    json!({
        "magFilter": near,
        "minFilter": far,
        "wrapS": wrap(texture.wrap_u),
        "wrapT": wrap(texture.wrap_v),
    })
}
