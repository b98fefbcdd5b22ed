//! Comparison of pictures with references that are kept as PNG files.
//!
//! A missing reference, or one of another size, is a failure. `POPULACE_UPDATE=name` (or several
//! names with commas between) writes the reference anew. On failure the picture and its difference
//! from the reference are written beside each other to a folder.

use std::fmt;
use std::path::{Path, PathBuf};

use ::image::{Rgba, RgbaImage};

/// The most bytes that a reference may have.
const REFERENCE_BYTES: u64 = 64 * 1024;
/// The environment variable that names the references to write anew.
const UPDATE: &str = "POPULACE_UPDATE";

/// How far a picture may stray from its reference: a class of pictures, each made by a function of
/// its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// A pixel is bad where a channel differs by more than this.
    pub channel_difference: u8,
    /// The most bad pixels, as a share of all.
    pub bad_share: f64,
}

impl Limits {
    /// Pictures made by the same program on the same machine: every byte.
    #[must_use]
    pub const fn exact() -> Self {
        Self { channel_difference: 0, bad_share: 0.0 }
    }

    /// Flat surfaces under plain light, by any version of one rasteriser: shading rounds to one
    /// step of a channel up or down, and its gamma curve may double that; a few pixels on edges go
    /// to the other side.
    #[must_use]
    pub const fn surfaces() -> Self {
        Self { channel_difference: 2, bad_share: 0.001 }
    }

    /// Textured and far away, or by another rasteriser: filtering weights have as few as 8 bits,
    /// and every silhouette may move by a fraction of a pixel.
    #[must_use]
    pub const fn textures() -> Self {
        Self { channel_difference: 8, bad_share: 0.01 }
    }
}

/// Why a picture does not pass.
#[derive(Debug)]
pub enum Mismatch {
    /// There is no reference.
    NoReference {
        /// Where it should be.
        reference: PathBuf,
        /// Where the picture was written.
        actual: PathBuf,
    },
    /// The reference has another size.
    Size {
        /// Width and height of the picture.
        actual: (u32, u32),
        /// Width and height of the reference.
        reference: (u32, u32),
    },
    /// Too many bad pixels.
    Pixels {
        /// How many differ by more than the limit.
        bad: usize,
        /// How many may.
        allowed: usize,
        /// The largest difference of a channel.
        worst: u8,
        /// Where the difference was written.
        difference: PathBuf,
    },
    /// A reference too large to keep.
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// Bytes that are no picture, or a file that could not be read or written.
    File(String),
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoReference { reference, actual } => write!(
                f,
                "there is no reference {}; look at {} and set {UPDATE} to its name to keep it",
                reference.display(),
                actual.display()
            ),
            Self::Size { actual, reference } => {
                let ((w, h), (rw, rh)) = (actual, reference);
                write!(f, "the picture is {w} x {h} pixels, its reference {rw} x {rh}")
            }
            Self::Pixels { bad, allowed, worst, difference } => write!(
                f,
                "{bad} pixels are off, where {allowed} may be, the worst by {worst} of 255; see {}",
                difference.display()
            ),
            Self::TooLarge { bytes } => {
                write!(
                    f,
                    "a reference of {bytes} bytes is too large to keep; the limit is \
                     {REFERENCE_BYTES}"
                )
            }
            Self::File(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Mismatch {}

/// Where references are kept and failures go.
#[derive(Clone, Copy, Debug)]
pub struct Folders<'a> {
    /// References, `name.png`.
    pub references: &'a Path,
    /// On failure `name.actual.png` and `name.difference.png`.
    pub failures: &'a Path,
}

/// Compares a picture (`width x height x 4` bytes, rows from the top) with the reference of its
/// name.
///
/// # Panics
///
/// If it does not pass.
#[track_caller]
pub fn assert_picture(
    name: &str,
    width: u32,
    height: u32,
    rgba: &[u8],
    limits: Limits,
    folders: Folders<'_>,
) {
    if let Err(mismatch) = compare_picture(name, width, height, rgba, limits, folders) {
        panic!("{name}: {mismatch}");
    }
}

/// Compares a picture with the reference of its name.
///
/// # Errors
///
/// [`Mismatch`] says what differs and where to look.
pub fn compare_picture(
    name: &str,
    width: u32,
    height: u32,
    rgba: &[u8],
    limits: Limits,
    folders: Folders<'_>,
) -> Result<(), Mismatch> {
    let update = std::env::var(UPDATE).unwrap_or_default();
    let bytes = rgba.len();
    let picture = RgbaImage::from_raw(width, height, rgba.to_vec())
        .filter(|picture| picture.len() == bytes)
        .ok_or_else(|| {
            Mismatch::File(format!("{bytes} bytes are no {width} x {height} picture"))
        })?;
    compare(name, &picture, limits, folders, &update)
}

fn compare(
    name: &str,
    actual: &RgbaImage,
    limits: Limits,
    folders: Folders<'_>,
    update: &str,
) -> Result<(), Mismatch> {
    let reference_path = folders.references.join(format!("{name}.png"));
    if update.split(',').any(|wanted| wanted == name) {
        return keep(actual, &reference_path);
    }
    let actual_path = folders.failures.join(format!("{name}.actual.png"));
    if !reference_path.exists() {
        save(actual, &actual_path)?;
        return Err(Mismatch::NoReference { reference: reference_path, actual: actual_path });
    }
    let reference = ::image::open(&reference_path)
        .map_err(|error| Mismatch::File(format!("{}: {error}", reference_path.display())))?
        .to_rgba8();
    if reference.dimensions() != actual.dimensions() {
        save(actual, &actual_path)?;
        return Err(Mismatch::Size {
            actual: actual.dimensions(),
            reference: reference.dimensions(),
        });
    }
    let difference = Difference::of(actual, &reference, limits);
    if difference.bad <= difference.allowed {
        return Ok(());
    }
    let difference_path = folders.failures.join(format!("{name}.difference.png"));
    save(actual, &actual_path)?;
    save(&difference.picture, &difference_path)?;
    Err(Mismatch::Pixels {
        bad: difference.bad,
        allowed: difference.allowed,
        worst: difference.worst,
        difference: difference_path,
    })
}

struct Difference {
    bad: usize,
    allowed: usize,
    worst: u8,
    /// Bad pixels red, the rest brighter the more they differ.
    picture: RgbaImage,
}

impl Difference {
    fn of(actual: &RgbaImage, reference: &RgbaImage, limits: Limits) -> Self {
        let mut picture = RgbaImage::new(actual.width(), actual.height());
        let (mut bad, mut worst) = (0, 0);
        for ((a, b), shown) in actual.pixels().zip(reference.pixels()).zip(picture.pixels_mut()) {
            let channels = a.0.iter().zip(b.0).map(|(a, b)| a.abs_diff(b));
            let off = channels.max().unwrap_or(0);
            worst = worst.max(off);
            let is_bad = off > limits.channel_difference;
            bad += usize::from(is_bad);
            let gray = off.saturating_mul(16);
            *shown = if is_bad { Rgba([255, 0, 0, 255]) } else { Rgba([gray, gray, gray, 255]) };
        }
        let pixels = f64::from(actual.width()) * f64::from(actual.height());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of pixels, rounded down"
        )]
        let allowed = (pixels * limits.bad_share) as usize;
        Self { bad, allowed, worst, picture }
    }
}

fn save(picture: &RgbaImage, path: &Path) -> Result<(), Mismatch> {
    let fail = |error: &dyn fmt::Display| Mismatch::File(format!("{}: {error}", path.display()));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| fail(&error))?;
    }
    picture.save(path).map_err(|error| fail(&error))
}

/// Writes a reference anew.
fn keep(picture: &RgbaImage, path: &Path) -> Result<(), Mismatch> {
    save(picture, path)?;
    let bytes = std::fs::metadata(path)
        .map_err(|error| Mismatch::File(format!("{}: {error}", path.display())))?
        .len();
    if bytes > REFERENCE_BYTES {
        return Err(Mismatch::TooLarge { bytes });
    }
    println!("wrote {}", path.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own for each test, gone afterwards.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(test: &str) -> Self {
            let name = format!("populace-testkit-{}-{test}", std::process::id());
            Self(std::env::temp_dir().join(name))
        }

        fn check(&self, picture: &RgbaImage, limits: Limits, update: &str) -> Result<(), Mismatch> {
            let (references, failures) = (self.0.join("references"), self.0.join("failures"));
            let folders = Folders { references: &references, failures: &failures };
            compare("gray", picture, limits, folders, update)
        }

        fn has(&self, file: &str) -> bool {
            self.0.join("failures").join(file).exists()
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn gray(width: u32, height: u32) -> RgbaImage {
        RgbaImage::from_pixel(width, height, Rgba([128, 128, 128, 255]))
    }

    #[test]
    fn a_missing_reference_fails_and_shows_the_picture() {
        let scratch = Scratch::new("missing");
        let error = scratch.check(&gray(4, 4), Limits::exact(), "grayish,other").unwrap_err();
        assert!(error.to_string().contains("POPULACE_UPDATE"), "{error}");
        assert!(scratch.has("gray.actual.png"));
    }

    #[test]
    fn an_update_by_name_writes_the_reference_which_then_passes() {
        let scratch = Scratch::new("update");
        scratch.check(&gray(4, 4), Limits::exact(), "other,gray").unwrap();
        scratch.check(&gray(4, 4), Limits::exact(), "").unwrap();
        assert!(!scratch.has("gray.actual.png"));
    }

    #[test]
    fn another_size_fails() {
        let scratch = Scratch::new("size");
        scratch.check(&gray(4, 4), Limits::textures(), "gray").unwrap();
        let error = scratch.check(&gray(4, 5), Limits::textures(), "").unwrap_err();
        assert!(matches!(error, Mismatch::Size { actual: (4, 5), reference: (4, 4) }), "{error}");
    }

    #[test]
    fn both_limits_count() {
        let scratch = Scratch::new("limits");
        let mut picture = gray(100, 20);
        scratch.check(&picture, Limits::exact(), "gray").unwrap();
        // Every pixel a little: within the channel's limit.
        picture.pixels_mut().for_each(|p| p.0[1] += 2);
        scratch.check(&picture, Limits::surfaces(), "").unwrap();
        assert!(scratch.check(&picture, Limits::exact(), "").is_err());
        // 2,000 pixels allow for two bad ones.
        picture.put_pixel(0, 0, Rgba([0, 0, 0, 255]));
        picture.put_pixel(1, 0, Rgba([0, 0, 0, 255]));
        scratch.check(&picture, Limits::surfaces(), "").unwrap();
        picture.put_pixel(2, 0, Rgba([128, 128, 128, 0]));
        let error = scratch.check(&picture, Limits::surfaces(), "").unwrap_err();
        let expected = matches!(error, Mismatch::Pixels { bad: 3, allowed: 2, worst: 255, .. });
        assert!(expected, "{error}");
        assert!(scratch.has("gray.actual.png") && scratch.has("gray.difference.png"));
    }

    #[test]
    fn a_reference_too_large_to_keep_is_refused() {
        let scratch = Scratch::new("large");
        let mut rng = crate::Rng::new(5);
        let mut noise = gray(200, 200);
        noise
            .pixels_mut()
            .for_each(|p| p.0 = u32::try_from(rng.bits() >> 32).unwrap().to_le_bytes());
        let error = scratch.check(&noise, Limits::exact(), "gray").unwrap_err();
        assert!(matches!(error, Mismatch::TooLarge { .. }), "{error}");
    }

    #[test]
    #[should_panic(expected = "15 bytes are no 2 x 2 picture")]
    fn bytes_that_are_no_picture_fail() {
        let folder = std::env::temp_dir();
        let folders = Folders { references: &folder, failures: &folder };
        assert_picture("gray", 2, 2, &[0; 15], Limits::exact(), folders);
    }
}
