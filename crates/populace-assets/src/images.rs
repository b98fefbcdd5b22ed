//! Images, decoded when a material asks for them.

use std::io::Cursor as Bytes;
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};
use populace_core::Image;

use crate::data::Data;
use crate::json::Cursor;
use crate::log::{Checked, Log};
use crate::uri::{self, Uri};

/// Pixels along a side.
const MOST_PIXELS: u32 = 16_384;
/// Bytes that decoding one image may take.
const MOST_BYTES: u64 = 512 << 20;
/// Bytes of all images together.
const MOST_BYTES_TOGETHER: usize = 2 << 30;

/// Where an image's bytes are.
enum Source {
    View(usize),
    Data(Vec<u8>),
    Beside(String),
}

struct Entry {
    place: String,
    source: Option<Source>,
    /// `None` until asked for; then the index of the decoded image, if it could be had.
    decoded: Option<Option<usize>>,
}

/// All images of a file.
pub(crate) struct ImageStore<'a> {
    data: &'a Data<'a>,
    log: &'a Log,
    base_folder: Option<&'a Path>,
    entries: Vec<Entry>,
    images: Vec<Image>,
}

impl<'a> ImageStore<'a> {
    pub(crate) fn new(
        root: &Cursor,
        data: &'a Data<'a>,
        log: &'a Log,
        base_folder: Option<&'a Path>,
    ) -> Self {
        let entry = |at: &Cursor| Entry {
            place: at.place().to_owned(),
            source: read_source(at, data).ok().flatten(),
            decoded: None,
        };
        let entries = root.objects("images").iter().map(entry).collect();
        Self { data, log, base_folder, entries, images: Vec::new() }
    }

    pub(crate) fn count(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn into_images(self) -> Vec<Image> {
        self.images
    }

    /// The index of an image among the decoded ones; `None` where it could not be had, which is noted. Only what the
    /// file itself gets wrong is a problem: a texture that was not shipped along stops nobody from moving.
    pub(crate) fn decoded(&mut self, index: usize) -> Checked<Option<usize>> {
        if let Some(known) = self.entries[index].decoded {
            return Ok(known);
        }
        let entry = &self.entries[index];
        let beside;
        let bytes: Result<&[u8], String> = match &entry.source {
            None => return Ok(None),
            Some(Source::View(view)) => Ok(self.data.view_bytes(*view)?),
            Some(Source::Data(bytes)) => Ok(bytes),
            Some(Source::Beside(path)) => {
                beside = uri::read_file(self.base_folder, path, None, MOST_BYTES);
                beside.as_deref().map_err(Clone::clone)
            }
        };
        let used = self.images.iter().map(|i| i.rgba.len()).sum();
        let decoded = match bytes.and_then(|b| decode(b, used)) {
            Ok(image) => {
                self.images.push(image);
                Some(self.images.len() - 1)
            }
            Err(what) => {
                self.log.note(&entry.place, format!("{what}; materials keep their plain colour"));
                None
            }
        };
        self.entries[index].decoded = Some(decoded);
        Ok(decoded)
    }
}

fn read_source(at: &Cursor, data: &Data) -> Checked<Option<Source>> {
    if let Some(view) = at.get("bufferView") {
        return Ok(Some(Source::View(view.index(data.view_count(), "buffer view")?)));
    }
    let Some(uri) = at.get("uri") else {
        at.note("has neither a uri nor a bufferView");
        return Ok(None);
    };
    Ok(match Uri::parse(uri.text()?) {
        Ok(Uri::Data { bytes, .. }) => Some(Source::Data(bytes)),
        Ok(Uri::Relative(path)) => Some(Source::Beside(path)),
        Err(what) => {
            uri.note(format!("{what}; materials keep their plain colour"));
            None
        }
    })
}

/// Decodes PNG, JPEG or WebP, told apart by content.
fn decode(bytes: &[u8], bytes_used: usize) -> Result<Image, String> {
    let format = image::guess_format(bytes).ok();
    let known = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP];
    let format = format.filter(|f| known.contains(f)).ok_or("is neither PNG nor JPEG nor WebP")?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_PIXELS);
    limits.max_image_height = Some(MOST_PIXELS);
    limits.max_alloc = Some(MOST_BYTES);
    let mut reader = ImageReader::with_format(Bytes::new(bytes), format);
    reader.limits(limits);
    let failed = |e: image::ImageError| format!("cannot be decoded: {e}");
    let decoded = reader.decode().map_err(failed)?;
    let (width, height) = (decoded.width(), decoded.height());
    let rgba_bytes = width as usize * height as usize * 4;
    if bytes_used.saturating_add(rgba_bytes) > MOST_BYTES_TOGETHER {
        return Err(format!("would bring the images to more than {MOST_BYTES_TOGETHER} bytes together"));
    }
    Ok(Image { width, height, rgba: decoded.into_rgba8().into_raw() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Bytes::new(Vec::new());
        let pixels = image::RgbaImage::from_fn(width, height, |x, y| {
            let [x, y] = [x, y].map(|v| u8::try_from(v % 256).unwrap());
            image::Rgba([x, y, 7, 255])
        });
        pixels.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn pixels_come_out_as_they_went_in() {
        let image = decode(&png(3, 2), 0).unwrap();
        assert_eq!((image.width, image.height), (3, 2));
        assert_eq!(image.rgba[4 * 5..], [2, 1, 7, 255]);
    }

    #[test]
    fn broken_and_huge_images_are_refused() {
        let good = png(3, 2);
        assert!(decode(&good[..good.len() / 2], 0).unwrap_err().contains("cannot be decoded"));
        assert!(decode(b"GIF89a", 0).unwrap_err().contains("neither PNG"));
        assert!(decode(&good, MOST_BYTES_TOGETHER - 23).unwrap_err().contains("together"));
        assert!(decode(&good, MOST_BYTES_TOGETHER - 24).is_ok());
        let wide = png(MOST_PIXELS + 1, 1);
        assert!(decode(&wide, 0).unwrap_err().contains("cannot be decoded"));
    }
}
