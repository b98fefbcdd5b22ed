//! Pictures as PNG.

use std::io::Cursor;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageFormat, ImageReader};

use crate::Error;
use crate::output::output_error;

/// The pixels of a picture, top row first.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Four bytes each in sRGB. The alpha channel is dropped.
    Rgba(&'a [u8]),
    /// A byte each: a grey, or a share of 255.
    Gray(&'a [u8]),
    /// A number from 0 to 65535 each.
    Gray16(&'a [u16]),
}

/// Writes a picture of `size` pixels (width, height) to `path` as a PNG file.
///
/// # Errors
///
/// [`Error::Output`] with the path if the file cannot be written, and all errors of [`encode_png`].
pub fn write_png(path: impl AsRef<Path>, size: [u32; 2], pixels: Pixels<'_>) -> Result<(), Error> {
    let path = path.as_ref();
    std::fs::write(path, encode_png(size, pixels)?).map_err(|source| output_error(path, source))
}

/// Encodes a picture of `size` pixels (width, height) as the bytes of a PNG file, of 8 or 16 bits.
///
/// # Errors
///
/// [`Error::FrameSize`] if the number of pixels is not that of the size, or 0, and
/// [`Error::Encoder`] if the picture is too large for PNG.
pub fn encode_png(size: [u32; 2], pixels: Pixels<'_>) -> Result<Vec<u8>, Error> {
    let [width, height] = size;
    let (found, pixel_bytes) = match pixels {
        Pixels::Rgba(rgba) => (rgba.len(), 4),
        Pixels::Gray(gray) => (gray.len(), 1),
        Pixels::Gray16(numbers) => (size_of_val(numbers), 2),
    };
    let expected = (u64::from(width) * u64::from(height)).saturating_mul(pixel_bytes);
    if found == 0 || found as u64 != expected {
        return Err(Error::FrameSize { width, height, found, expected });
    }
    let (bytes, color) = match pixels {
        Pixels::Rgba(rgba) => (rgb(rgba), ExtendedColorType::Rgb8),
        Pixels::Gray(gray) => (gray.to_vec(), ExtendedColorType::L8),
        Pixels::Gray16(numbers) => {
            (numbers.iter().flat_map(|n| n.to_ne_bytes()).collect(), ExtendedColorType::L16)
        }
    };
    let mut file = Vec::new();
    // One filter for all rows is faster than a choice for each. This one makes files as small.
    PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Paeth)
        .write_image(&bytes, width, height, color)
        .map_err(|cause| Error::Encoder {
            encoder: "the encoder of PNG",
            cause: cause.to_string(),
        })?;
    Ok(file)
}

/// Decodes a PNG file. Returns the width and height, and the pixels as RGBA in sRGB, 8 bits each,
/// top row first.
///
/// # Errors
///
/// [`Error::BadPng`] if the bytes are no whole PNG file, or if it takes more than 512 MiB.
pub fn decode_png(file: &[u8]) -> Result<([u32; 2], Vec<u8>), Error> {
    let picture = ImageReader::with_format(Cursor::new(file), ImageFormat::Png)
        .decode()
        .map_err(|cause| Error::BadPng { cause: cause.to_string() })?
        .into_rgba8();
    Ok((picture.dimensions().into(), picture.into_raw()))
}

fn rgb(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
}
