//! Comparison of pictures with references stored as PNG files.
//!
//! A reference that is missing or has another size is a failure. `POPULACE_UPDATE=name` (or a
//! comma-separated list of names) rewrites references. On failure, the picture and its difference
//! from the reference are written to a folder.

use std::fmt;
use std::path::{Path, PathBuf};

use ::image::{Rgba, RgbaImage};

/// The largest allowed size of a reference file.
const REFERENCE_BYTES: u64 = 64 * 1024;
/// The environment variable that names the references to rewrite.
const UPDATE: &str = "POPULACE_UPDATE";

/// The allowed difference from a reference, with a constructor for each class of pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// A pixel is bad if a channel differs by more than this.
    pub channel_difference: u8,
    /// The allowed fraction of bad pixels.
    pub bad_share: f64,
}

impl Limits {
    /// For pictures made by the same program on the same machine: every byte must match.
    #[must_use]
    pub const fn exact() -> Self {
        Self { channel_difference: 0, bad_share: 0.0 }
    }

    /// For untextured surfaces drawn by any version of one rasteriser. Shading may round by one
    /// step of a channel, which the gamma curve may double, and a few pixels on edges may flip.
    #[must_use]
    pub const fn surfaces() -> Self {
        Self { channel_difference: 2, bad_share: 0.001 }
    }

    /// For distant textured surfaces, or pictures drawn by another rasteriser. Filter weights may
    /// have as few as 8 bits, and every silhouette may shift by a fraction of a pixel.
    #[must_use]
    pub const fn textures() -> Self {
        Self { channel_difference: 8, bad_share: 0.01 }
    }
}

/// The reason why a picture fails.
#[derive(Debug)]
pub enum Mismatch {
    /// The reference is missing.
    NoReference {
        /// The expected path of the reference.
        reference: PathBuf,
        /// The path of the written picture.
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
        /// The number of pixels that differ by more than the limit.
        bad: usize,
        /// The allowed number.
        allowed: usize,
        /// The largest difference of any channel.
        worst: u8,
        /// The path of the written difference picture.
        difference: PathBuf,
    },
    /// A new reference is too large.
    TooLarge {
        /// Its size in bytes.
        bytes: u64,
    },
    /// Bytes that are not a picture, or a file that could not be read or written.
    File(String),
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoReference { reference, actual } => write!(
                f,
                "the reference {} is missing; check {} and set {UPDATE} to its name to accept it",
                reference.display(),
                actual.display()
            ),
            Self::Size { actual, reference } => {
                let ((w, h), (rw, rh)) = (actual, reference);
                write!(f, "the picture has {w} x {h} pixels, its reference {rw} x {rh}")
            }
            Self::Pixels { bad, allowed, worst, difference } => write!(
                f,
                "{bad} pixels differ, {allowed} may; the largest difference is {worst} of 255; \
                 see {}",
                difference.display()
            ),
            Self::TooLarge { bytes } => {
                write!(f, "a reference of {bytes} bytes exceeds the limit of {REFERENCE_BYTES}")
            }
            Self::File(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Mismatch {}

/// The folders of references and of failures.
#[derive(Clone, Copy, Debug)]
pub struct Folders<'a> {
    /// References, `name.png`.
    pub references: &'a Path,
    /// Written on failure: `name.actual.png` and `name.difference.png`.
    pub failures: &'a Path,
}

/// Asserts that a picture (`width x height x 4` bytes, rows from the top) matches its reference.
///
/// # Panics
///
/// If the comparison fails.
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

/// Compares a picture with its reference.
///
/// # Errors
///
/// [`Mismatch`] states the difference and the files written.
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
            Mismatch::File(format!("{bytes} bytes are not a picture of {width} x {height} pixels"))
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
        return write_reference(actual, &reference_path);
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
    /// Bad pixels are red; the others are gray, brighter the more they differ.
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

/// Writes a reference.
fn write_reference(picture: &RgbaImage, path: &Path) -> Result<(), Mismatch> {
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

    /// A folder per test, removed afterwards.
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
    fn missing_reference_fails_and_writes_the_picture() {
        let scratch = Scratch::new("missing");
        let error = scratch.check(&gray(4, 4), Limits::exact(), "grayish,other").unwrap_err();
        assert!(error.to_string().contains("POPULACE_UPDATE"), "{error}");
        assert!(scratch.has("gray.actual.png"));
    }

    #[test]
    fn update_by_name_writes_the_reference() {
        let scratch = Scratch::new("update");
        scratch.check(&gray(4, 4), Limits::exact(), "other,gray").unwrap();
        scratch.check(&gray(4, 4), Limits::exact(), "").unwrap();
        assert!(!scratch.has("gray.actual.png"));
    }

    #[test]
    fn different_size_fails() {
        let scratch = Scratch::new("size");
        scratch.check(&gray(4, 4), Limits::textures(), "gray").unwrap();
        let error = scratch.check(&gray(4, 5), Limits::textures(), "").unwrap_err();
        assert!(matches!(error, Mismatch::Size { actual: (4, 5), reference: (4, 4) }), "{error}");
    }

    #[test]
    fn both_limits_are_enforced() {
        let scratch = Scratch::new("limits");
        let mut picture = gray(100, 20);
        scratch.check(&picture, Limits::exact(), "gray").unwrap();
        // Every pixel differs slightly, within the channel limit.
        picture.pixels_mut().for_each(|p| p.0[1] += 2);
        scratch.check(&picture, Limits::surfaces(), "").unwrap();
        assert!(scratch.check(&picture, Limits::exact(), "").is_err());
        // Of 2,000 pixels two may be bad.
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
    fn oversized_reference_is_refused() {
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
    #[should_panic(expected = "15 bytes are not a picture of 2 x 2 pixels")]
    fn wrong_byte_count_fails() {
        let folder = std::env::temp_dir();
        let folders = Folders { references: &folder, failures: &folder };
        assert_picture("gray", 2, 2, &[0; 15], Limits::exact(), folders);
    }
}
