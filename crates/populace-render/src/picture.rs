//! PNG encoding of pictures.

use std::path::Path;

use image::ImageEncoder as _;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use populace_character::Image;

use crate::Error;

/// Writes a picture to `path` as an RGB PNG file. The alpha channel is dropped.
///
/// # Errors
///
/// [`Error::Output`] with the path if the file cannot be written, and all errors of
/// [`encode_png`].
pub fn write_png(path: impl AsRef<Path>, picture: &Image) -> Result<(), Error> {
    let path = path.as_ref();
    let output = |source| Error::Output { path: path.to_owned(), source };
    std::fs::write(path, encode_png(picture)?).map_err(output)
}

/// Encodes a picture as the bytes of an RGB PNG file. The alpha channel is dropped.
///
/// # Errors
///
/// [`Error::EmptyPicture`] if there are no pixels, or if their number does not match the picture's
/// size; [`Error::Encoding`] if the picture is too large for PNG.
pub fn encode_png(picture: &Image) -> Result<Vec<u8>, Error> {
    let Image { width, height, ref rgba } = *picture;
    if rgba.is_empty() || rgba.len() as u64 != 4 * u64::from(width) * u64::from(height) {
        return Err(Error::EmptyPicture { width, height });
    }
    let rgb: Vec<u8> =
        rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    // One filter for all rows is faster than a choice for each. This one makes files as small.
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Paeth)
        .write_image(&rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|cause| Error::Encoding { cause: cause.to_string() })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray() -> Image {
        Image { width: 1, height: 1, rgba: vec![128, 128, 128, 255] }
    }

    #[test]
    fn write_error_names_the_path() {
        let error = write_png("no-such-folder/picture.png", &gray()).unwrap_err();
        assert!(error.to_string().contains("no-such-folder/picture.png"), "{error}");
    }

    #[test]
    fn picture_with_missing_pixels_is_rejected() {
        let error = write_png("never-written.png", &Image { width: 2, ..gray() }).unwrap_err();
        assert!(matches!(error, Error::EmptyPicture { width: 2, height: 1 }), "{error}");
    }
}
