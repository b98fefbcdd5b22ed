//! How planted feet step: contacts of clips, and strides of members.

use populace_device::layout::{self, Float4};
use populace_model::JointIndex;

use crate::check::{Check, bounded};
use crate::error::Error;
use crate::fault::Allowed;

/// A time in which a foot stands while a clip plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The ankle of the foot.
    pub ankle: JointIndex,
    /// Touchdown, in seconds after the clip's start: from 0 up to the clip's duration.
    pub from_secs: f32,
    /// Lift-off: after touchdown, by at most the clip's duration. A contact that goes on through
    /// the end of the cycle ends after the clip's duration. A foot that never lifts has one contact
    /// of the clip's duration.
    pub until_secs: f32,
}

/// Refuses a contact that is not within a clip of this length.
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn check_contact(contact: &Contact, duration_secs: f32) -> Result<(), Error> {
    let outside = |what, value| {
        let allowed = Allowed::Range { least: 0.0, most: duration_secs.into() };
        Err(Error::BadValue { what, value, allowed })
    };
    if !(0.0..=duration_secs).contains(&contact.from_secs) {
        return outside("the beginning of a contact", contact.from_secs);
    }
    let lasts_secs = contact.until_secs - contact.from_secs;
    if !(0.0..=duration_secs).contains(&lasts_secs) {
        return outside("the length of a contact", lasts_secs);
    }
    Ok(())
}

/// Returns a contact as devices store it.
#[must_use]
pub const fn contact_row(contact: &Contact) -> layout::Contact {
    let Contact { ankle, from_secs, until_secs } = *contact;
    layout::Contact { joint: ankle.0, from_secs, until_secs, unused: 0 }
}

/// How the planted feet of a member step, relative to its clips: in another direction, by other
/// lengths, and while the member turns.
///
/// The clips of the member walk along +Z of its model space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    along: [f32; 2],
    turn_rad_per_m: f32,
}

impl Stride {
    /// Steps as the clips do.
    pub const OF_CLIPS: Self = Self::along([0.0, 1.0]);

    /// Where a step of the clips that leads one metre along +Z leads instead: `[x, z]` in metres of
    /// model space. `[0.0, 0.0]` steps on the spot.
    #[must_use]
    pub const fn along(along: [f32; 2]) -> Self {
        Self { along, turn_rad_per_m: 0.0 }
    }

    /// Where a step of the clips that leads one metre along +Z leads instead, as given to
    /// [`along`](Self::along) or on the way from one stride to another.
    #[must_use]
    pub const fn lead(&self) -> [f32; 2] {
        self.along
    }

    /// Turns the feet with a member that turns: the angle about +Y, in radians, by which the member
    /// turns while its clips step one metre.
    #[must_use]
    pub const fn turning_rad_per_m(mut self, rad_per_m: f32) -> Self {
        self.turn_rad_per_m = rad_per_m;
        self
    }

    /// Returns the stride a part of the way, 0 to 1, to another.
    #[must_use]
    pub fn towards(&self, other: &Self, part: f32) -> Self {
        let mix = |from: f32, to: f32| from + (to - from) * part;
        Self {
            along: [0, 1].map(|i: usize| mix(self.along[i], other.along[i])),
            turn_rad_per_m: mix(self.turn_rad_per_m, other.turn_rad_per_m),
        }
    }
}

impl Check for Stride {
    fn check(&self) -> Result<(), Error> {
        bounded("a stride", &[self.along[0], self.along[1], self.turn_rad_per_m])
    }
}

/// Returns a stride as devices store it.
#[must_use]
pub fn stride_row(stride: &Stride) -> Float4 {
    let [x, z] = stride.along;
    Float4([x, z, 0.5 * stride.turn_rad_per_m, 0.0])
}

impl Default for Stride {
    fn default() -> Self {
        Self::OF_CLIPS
    }
}
