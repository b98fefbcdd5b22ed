//! The look of one member: what tells it from others with the same character.

use populace_character::{MAX_OPTIONS, Region};

/// Bits of a channel of a tint, and its value for the factor 1.
const CHANNEL_BITS: u32 = 10;
const ONE: u32 = 128;
const CHANNEL_MAX: u32 = (1 << CHANNEL_BITS) - 1;
/// Bits of a tint, and those of the three that say how much of a member is faded out.
const TINT_BITS: u32 = 3 * CHANNEL_BITS;
const TINT_MASK: u32 = (1 << TINT_BITS) - 1;
const FADED_MAX: u32 = 63;

/// How one member looks: a tint for each region of its character, and the options that it does not
/// show. 32 bytes, which shaders read as they are.
///
/// A tint is three linear factors of 10 bits each, red in the lowest ones: `n` is the factor
/// `(n / 128)^2`, so 128 changes nothing, and 1,023 multiplies by 63.9. The two highest bits of the
/// first three tints are how much of the member is faded out, in 63rds, the lowest bits first.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MemberLook {
    tints: [u32; Region::COUNT],
    /// Bit `n` hides option `n` of the character: see
    /// [`Character::options`](populace_character::Character::options).
    pub hidden: u32,
}

impl MemberLook {
    /// The character's own colours, with all options shown.
    pub const PLAIN: Self = Self {
        tints: [ONE | ONE << CHANNEL_BITS | ONE << (2 * CHANNEL_BITS); Region::COUNT],
        hidden: 0,
    };

    /// Returns the same look with all regions multiplied by a linear colour, as
    /// [`tinted`](Self::tinted) does for one.
    #[must_use]
    pub fn all_tinted(self, color: [f32; 3]) -> Self {
        Region::ALL.into_iter().fold(self, |look, region| look.tinted(region, color))
    }

    /// Returns the same look with a region whose colours are multiplied by a linear colour. Factors
    /// are clamped to 0 to 63.9, and their square roots rounded to steps of 1 / 128; those that are
    /// not numbers count as 1.
    #[must_use]
    pub fn tinted(mut self, region: Region, color: [f32; 3]) -> Self {
        let [r, g, b] = color.map(channel);
        let tint = &mut self.tints[usize::from(region.number())];
        *tint = *tint & !TINT_MASK | r | g << CHANNEL_BITS | b << (2 * CHANNEL_BITS);
        self
    }

    /// The factors of a region's linear colour.
    #[must_use]
    pub fn tint(&self, region: Region) -> [f32; 3] {
        let packed = self.tints[usize::from(region.number())];
        [0, 1, 2].map(|c| {
            let stored = packed >> (c * CHANNEL_BITS) & CHANNEL_MAX;
            #[expect(clippy::cast_precision_loss, reason = "at most 1,023")]
            let root = stored as f32 / ONE as f32;
            root * root
        })
    }

    /// Returns the same look, of which a part from 0 to 1 is drawn: a member that fades in or out
    /// is a pattern of samples. It is rounded to steps of 1 / 63; what is not a number counts as 1.
    #[must_use]
    pub fn with_opacity(mut self, opacity: f32) -> Self {
        let shown = if opacity.is_nan() { 1.0 } else { opacity.clamp(0.0, 1.0) };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "from 0 to 63"
        )]
        let faded = ((1.0 - shown) * FADED_MAX as f32).round() as u32;
        for (nth, tint) in (0_u32..3).zip(&mut self.tints) {
            *tint = *tint & TINT_MASK | (faded >> (2 * nth) & 3) << TINT_BITS;
        }
        self
    }

    /// The part of the member that is drawn, from 0 to 1.
    #[must_use]
    pub fn opacity(&self) -> f32 {
        let bits = (0_u32..3).zip(&self.tints).map(|(nth, tint)| (tint >> TINT_BITS) << (2 * nth));
        #[expect(clippy::cast_precision_loss, reason = "at most 63")]
        let faded = bits.sum::<u32>() as f32;
        1.0 - faded / 63.0
    }

    /// Returns the same look without an option of the character. Numbers past the last option
    /// change nothing.
    #[must_use]
    pub const fn without_option(mut self, option: usize) -> Self {
        if option < MAX_OPTIONS {
            self.hidden |= 1 << option;
        }
        self
    }
}

impl Default for MemberLook {
    fn default() -> Self {
        Self::PLAIN
    }
}

/// Returns the stored value of a factor.
#[expect(clippy::disallowed_methods, reason = "a square root of the host alone")]
fn channel(factor: f32) -> u32 {
    #[expect(clippy::cast_precision_loss, reason = "at most 1,023")]
    let (one, most) = (ONE as f32, CHANNEL_MAX as f32);
    let factor = if factor.is_nan() { 1.0 } else { factor };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of a channel"
    )]
    let stored = (factor.max(0.0).sqrt() * one).round().clamp(0.0, most) as u32;
    stored
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_is_kept_beside_tints() {
        assert!(MemberLook::PLAIN.opacity() == 1.0);
        assert_eq!(MemberLook::PLAIN.with_opacity(1.0), MemberLook::PLAIN);
        assert_eq!(MemberLook::PLAIN.with_opacity(f32::NAN), MemberLook::PLAIN);
        for (given, kept) in [(0.0, 0.0), (0.5, 0.5), (0.9, 0.9), (-3.0, 0.0), (7.0, 1.0)] {
            let look = MemberLook::PLAIN.with_opacity(given);
            assert!((look.opacity() - kept).abs() < 0.01, "{given}: {}", look.opacity());
            let tinted = look.all_tinted([0.25, 1.0, 4.0]);
            assert!(tinted.opacity() == look.opacity());
            assert!(tinted.with_opacity(1.0) == MemberLook::PLAIN.all_tinted([0.25, 1.0, 4.0]));
        }
    }

    #[test]
    fn tints_are_kept_within_half_a_step() {
        let colors = [[0.25, 0.5, 1.75], [0.123, 0.9, 1.33]];
        let look = MemberLook::PLAIN
            .tinted(Region::Hair, colors[0])
            .tinted(Region::Other, colors[1])
            .without_option(31);
        for (region, color) in [(Region::Hair, colors[0]), (Region::Other, colors[1])] {
            let kept = look.tint(region);
            assert!((0..3).all(|c| (kept[c] - color[c]).abs() <= 1.4 / 128.0), "{kept:?}");
        }
        assert_eq!(look.tint(Region::Skin), [1.0; 3]);
        assert_eq!(look.hidden, 1 << 31);
        assert_eq!(size_of::<MemberLook>(), 32);
    }

    #[test]
    fn factors_out_of_range_are_clamped() {
        let look = MemberLook::PLAIN.tinted(Region::Top, [-1.0, f32::NAN, f32::INFINITY]);
        assert_eq!(look.tint(Region::Top), [0.0, 1.0, (1023.0_f32 / 128.0).powi(2)]);
        assert_eq!(MemberLook::PLAIN.without_option(32), MemberLook::PLAIN);
    }
}
