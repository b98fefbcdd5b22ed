//! Averages of pictures, as film in a camera makes them: in linear light.

use populace::character::{Image, linear_from_srgb};

/// Largest number of linear light.
const FULL: f64 = 65535.0;

/// Pictures that are averaged.
pub(crate) struct Exposure {
    /// Linear light of each byte of sRGB.
    light: [u32; 256],
    first: Option<Image>,
    /// Sums of linear light by channel, if there are several pictures.
    sums: Vec<u32>,
    count: u32,
}

impl Exposure {
    pub(crate) fn new() -> Self {
        Self { light: light_of_bytes(), first: None, sums: Vec::new(), count: 0 }
    }

    /// Adds a picture. All have the same size.
    pub(crate) fn add(&mut self, picture: Image) {
        let light = |byte: &u8| self.light[usize::from(*byte)];
        self.count += 1;
        match &self.first {
            None => self.first = Some(picture),
            Some(first) => {
                if self.count == 2 {
                    self.sums.clear();
                    self.sums.extend(first.rgba.iter().map(light));
                }
                let new = picture.rgba.iter().map(light);
                self.sums.iter_mut().zip(new).for_each(|(sum, light)| *sum += light);
            }
        }
    }

    /// Returns the average of the pictures since the last call, if there were any.
    pub(crate) fn develop(&mut self) -> Option<Image> {
        let count = std::mem::take(&mut self.count);
        let mut image = self.first.take()?;
        if count > 1 {
            for (byte, sum) in image.rgba.iter_mut().zip(&self.sums) {
                *byte = self.nearest((sum + count / 2) / count);
            }
        }
        Some(image)
    }

    /// Returns the byte of sRGB whose light is nearest.
    fn nearest(&self, light: u32) -> u8 {
        let above = self.light.partition_point(|of_byte| *of_byte <= light);
        let [low, high] = [above.saturating_sub(1), above.min(255)];
        let [to_low, to_high] = [low, high].map(|at| self.light[at].abs_diff(light));
        u8::try_from(if to_high < to_low { high } else { low }).unwrap_or(u8::MAX)
    }
}

/// Returns the linear light of each byte of sRGB.
fn light_of_bytes() -> [u32; 256] {
    std::array::from_fn(|byte| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "byte is below 256; light is from 0 to 65535"
        )]
        let light = (linear_from_srgb(byte as u8) * FULL).round() as u32;
        light
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rgba: [u8; 4]) -> Image {
        Image { width: 1, height: 1, rgba: rgba.to_vec() }
    }

    /// Half of the light of white is 188 in sRGB.
    #[test]
    fn averages_are_those_of_light() {
        let mut exposure = Exposure::new();
        assert!(exposure.develop().is_none());
        for _ in 0..2 {
            exposure.add(picture([0, 255, 10, 255]));
            exposure.add(picture([255, 255, 10, 255]));
            assert_eq!(exposure.develop(), Some(picture([188, 255, 10, 255])));
        }
    }

    #[test]
    fn equal_pictures_stay_as_they_are() {
        let mut exposure = Exposure::new();
        for byte in 0..=255 {
            (0..16).for_each(|_| exposure.add(picture([byte; 4])));
            assert_eq!(exposure.develop(), Some(picture([byte; 4])));
        }
    }
}
