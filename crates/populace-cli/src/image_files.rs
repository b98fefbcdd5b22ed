//! The images beside a picture: depth, who is seen, and coverage, as PNG.

use populace_film::{Pixels, encode_png};
use populace_render::Marks;

use crate::cli::ImageKind;
use crate::failure::Failure;

/// Units of depth per metre.
const DEPTH_UNITS: f32 = 100.0;
/// Largest number of a person in an image; one less than fits in three bytes, since 0 is nobody.
const MOST_IDS: u64 = 0xff_fffe;

/// Depth, coverage and people of the pixels of a picture.
pub(crate) struct PixelFacts {
    pub(crate) marks: Marks,
    /// The people of the instances, by their order; `None` for other things.
    pub(crate) people: Vec<Option<u64>>,
}

impl PixelFacts {
    /// Encodes one of the images, of `size` pixels.
    pub(crate) fn png(&self, kind: ImageKind, size: [u32; 2]) -> Result<Vec<u8>, Failure> {
        Ok(match kind {
            ImageKind::Depth => {
                let units: Vec<u16> =
                    self.marks.depths_m.iter().copied().map(depth_units).collect();
                encode_png(size, Pixels::Gray16(&units))?
            }
            ImageKind::Alpha => encode_png(size, Pixels::Gray(&self.marks.coverage))?,
            ImageKind::Id => encode_png(size, Pixels::Rgba(&self.id_colors()?))?,
        })
    }

    fn id_colors(&self) -> Result<Vec<u8>, Failure> {
        let too_large = self.people.iter().flatten().find(|id| **id > MOST_IDS);
        if let Some(id) = too_large {
            return Err(Failure::usage(format!(
                "an image holds the numbers of people up to {MOST_IDS}, and one has {id}; leave \
                 out `id`"
            )));
        }
        let color = |instance: &Option<u32>| {
            let person = instance.and_then(|index| *self.people.get(index as usize)?);
            let [.., red, green, blue] = person.map_or(0, |id| id + 1).to_be_bytes();
            [red, green, blue, 255]
        };
        Ok(self.marks.instances.iter().flat_map(color).collect())
    }
}

/// Returns a depth in centimetres; 0 for nothing, and 65535 for all that is farther.
fn depth_units(depth_m: f32) -> u16 {
    if depth_m.is_infinite() {
        return 0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "floats saturate, as they should here"
    )]
    let units = (depth_m * DEPTH_UNITS).round() as u16;
    units.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_that_the_help_names() {
        let depths = [0.001, 1.234, 655.35, 9e9, f32::INFINITY].map(depth_units);
        assert_eq!(depths, [1, 123, 65535, 65535, 0]);
        let marks = Marks {
            depths_m: vec![1.0; 3],
            instances: vec![None, Some(0), Some(1)],
            coverage: vec![0; 3],
        };
        let facts = PixelFacts { marks, people: vec![Some(0x01_02_03), None] };
        let colors = facts.id_colors().unwrap();
        assert_eq!(colors, [0, 0, 0, 255, 1, 2, 4, 255, 0, 0, 0, 255]);
        let large = PixelFacts { people: vec![Some(MOST_IDS + 1)], ..facts };
        assert!(large.id_colors().is_err());
    }
}
