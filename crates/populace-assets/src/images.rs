//! Images, decoded on first use by a material.

use std::io::Cursor as Bytes;

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use populace_character::Image;

use crate::budget::Budget;
use crate::data::Data;
use crate::folder::Folder;
use crate::json::Cursor;
use crate::log::{Checked, Log};
use crate::uri::Uri;

/// Maximum width and height in pixels.
const MAX_SIDE: u32 = 16_384;
/// Bytes per pixel of a decoded image.
const RGBA_BYTES: u64 = 4;

/// Location of the encoded bytes of an image.
enum Source<'a> {
    View(usize),
    Uri(Uri<'a>),
}

struct Entry<'a> {
    place: String,
    source: Option<Source<'a>>,
    /// `None` until first use. Then the index of the decoded image, or `Some(None)` if it is not
    /// available.
    decoded: Option<Option<usize>>,
}

/// The images of a file.
pub(crate) struct ImageStore<'a> {
    data: &'a Data<'a>,
    log: &'a Log,
    budget: &'a Budget<'a>,
    folder: &'a Folder,
    entries: Vec<Entry<'a>>,
    images: Vec<Image>,
}

/// An image, or the text of a note that says why it is not available. The outer error stands for a
/// problem that refuses the file.
type ImageResult<T> = Checked<Result<T, String>>;

impl<'a> ImageStore<'a> {
    pub(crate) fn new(
        root: &Cursor<'a>,
        data: &'a Data<'a>,
        log: &'a Log,
        budget: &'a Budget<'a>,
        folder: &'a Folder,
    ) -> Self {
        let entry = |at: &Cursor<'a>| Entry {
            place: at.place().to_owned(),
            source: read_source(at, data).ok().flatten(),
            decoded: None,
        };
        let entries = root.objects("images").iter().map(entry).collect();
        Self { data, log, budget, folder, entries, images: Vec::new() }
    }

    pub(crate) fn count(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn into_images(self) -> Vec<Image> {
        self.images
    }

    /// Returns the index of an image among the decoded ones, decoding it on first use. Returns
    /// `None` and adds a note if the image is not available: a character can be animated without
    /// its textures. Fails only for invalid references and images that exceed the memory limit.
    pub(crate) fn decoded(&mut self, index: usize) -> Checked<Option<usize>> {
        if let Some(known) = self.entries[index].decoded {
            return Ok(known);
        }
        let entry = &self.entries[index];
        let Some(source) = &entry.source else { return Ok(None) };
        let decoded = match self.image(&entry.place, source)? {
            Ok(image) => {
                self.images.push(image);
                Some(self.images.len() - 1)
            }
            Err(what) => {
                self.log.note(
                    &entry.place,
                    format!("{what}; materials use their plain colour instead"),
                );
                None
            }
        };
        self.entries[index].decoded = Some(decoded);
        Ok(decoded)
    }

    fn image(&self, place: &str, source: &Source) -> ImageResult<Image> {
        let bytes = match source {
            Source::View(view) => return self.decode(place, self.data.view_bytes(*view)?),
            Source::Uri(Uri::Data(data)) => {
                self.budget.check(place, "the data of its URI", data.decoded_bytes())?;
                data.decode()
            }
            Source::Uri(Uri::File(path)) => match self.folder.open(path, None) {
                Ok(opened) => {
                    self.budget.check(place, format!("the file \"{path}\""), opened.length)?;
                    opened.read()
                }
                Err(what) => Err(what),
            },
        };
        match bytes {
            Ok(bytes) => self.decode(place, &bytes),
            Err(what) => Ok(Err(what)),
        }
    }

    /// Decodes a PNG, JPEG or WebP image if the size in its header fits the budget. The format is
    /// detected from the content.
    fn decode(&self, place: &str, bytes: &[u8]) -> ImageResult<Image> {
        let format = image::guess_format(bytes).ok();
        let known = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];
        let Some(format) = format.filter(|f| known.contains(f)) else {
            return Ok(Err("is not a PNG, JPEG or WebP image".into()));
        };
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(self.budget.left());
        let mut reader = ImageReader::with_format(Bytes::new(bytes), format);
        reader.limits(limits);
        let failed = |e: image::ImageError| format!("cannot be decoded: {e}");
        let decoder = match reader.into_decoder() {
            Ok(decoder) => decoder,
            Err(error) => return Ok(Err(failed(error))),
        };
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        // The decoder's working memory is freed before its pixels are converted to RGBA, so only
        // the larger of the two counts.
        let converted = if decoder.color_type() == ColorType::Rgba8 { 0 } else { RGBA_BYTES };
        let extra = pixels * converted.max(working_bytes(format)) + bytes.len() as u64;
        let what = format!("an image of {width} x {height} pixels");
        self.budget.check(place, &what, decoder.total_bytes() + extra)?;
        match DynamicImage::from_decoder(decoder) {
            Ok(decoded) => {
                self.budget.take(place, &what, RGBA_BYTES * pixels)?;
                Ok(Ok(Image { width, height, rgba: decoded.into_rgba8().into_raw() }))
            }
            Err(error) => Ok(Err(failed(error))),
        }
    }
}

/// Returns an upper bound of the decoder's working memory in bytes per pixel, without its output:
/// the coefficients of a progressive JPEG, the frame of a WebP.
const fn working_bytes(format: ImageFormat) -> u64 {
    match format {
        ImageFormat::Jpeg => 6,
        ImageFormat::WebP => 4,
        _ => 0,
    }
}

fn read_source<'a>(at: &Cursor<'a>, data: &Data) -> Checked<Option<Source<'a>>> {
    if let Some(view) = at.get("bufferView") {
        return Ok(Some(Source::View(view.index(data.view_count(), "buffer view")?)));
    }
    let Some(uri) = at.get("uri") else {
        at.note("has neither a uri nor a bufferView");
        return Ok(None);
    };
    match Uri::parse(uri.text()?) {
        Ok(uri) => Ok(Some(Source::Uri(uri))),
        Err(what) => {
            uri.note(format!("{what}; materials use their plain colour instead"));
            Ok(None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glb::Container;
    use crate::tree::tests::tree;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Bytes::new(Vec::new());
        let pixels = image::RgbaImage::from_fn(width, height, |x, y| {
            let [x, y] = [x, y].map(|v| u8::try_from(v % 256).unwrap());
            image::Rgba([x, y, 7, 255])
        });
        pixels.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    /// Decodes an image with at most `limit` bytes of memory.
    fn decoded(bytes: &[u8], limit: u64) -> Result<Image, String> {
        let (log, value) = (Log::default(), tree("{}"));
        let (budget, folder, root) =
            (Budget::new(limit, &log), Folder::new(None, false), Cursor::root(&value, &log));
        let container = Container { json: b"", binary: false, bin: None };
        let image = {
            let data = Data::new(&root, &log, &container, &budget, &folder);
            ImageStore::new(&root, &data, &log, &budget, &folder).decode("images[0]", bytes)
        };
        image.unwrap_or_else(|_| Err(log.finish().unwrap_err()[0].to_string()))
    }

    #[test]
    fn png_round_trip_keeps_pixels() {
        let image = decoded(&png(3, 2), 1 << 20).unwrap();
        assert_eq!((image.width, image.height), (3, 2));
        assert_eq!(image.rgba[4 * 5..], [2, 1, 7, 255]);
    }

    #[test]
    fn broken_and_huge_images_are_refused() {
        let good = png(3, 2);
        assert!(
            decoded(&good[..good.len() / 2], 1 << 20).unwrap_err().contains("cannot be decoded")
        );
        assert!(decoded(b"GIF89a", 1 << 20).unwrap_err().contains("is not a PNG"));
        let wide = png(MAX_SIDE + 1, 1);
        assert!(decoded(&wide, 1 << 30).unwrap_err().contains("cannot be decoded"));
    }

    #[test]
    fn memory_is_checked_against_the_header_before_decoding() {
        let mut large = png(3, 2);
        // Width and height in the header and its checksum. The file has no such pixels.
        large[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
        let checksum = crc(&large[12..29]).to_be_bytes();
        large[29..33].copy_from_slice(&checksum);
        let said = decoded(&large, 1 << 30).unwrap_err();
        let words = "images[0]: needs 1025 MiB for an image of 16384 x 16384 pixels in addition";
        assert!(said.starts_with(words), "{said}");
        assert!(decoded(&large, 3 << 30).unwrap_err().contains("cannot be decoded"));
    }

    /// Computes the CRC-32 of a PNG chunk.
    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |s, _| {
                s >> 1 ^ if s & 1 == 1 { 0xEDB8_8320 } else { 0 }
            })
        })
    }
}
