//! The three properties of a local transform.

use crate::Trs;

/// The property that a track drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Local translation in metres, 3 values a key.
    Translation,
    /// Local rotation, a unit quaternion `x y z w`, 4 values a key.
    Rotation,
    /// Local scale, 3 values a key.
    Scale,
}

impl Property {
    /// All properties; each one's index is its value as `usize`.
    pub const ALL: [Self; 3] = [Self::Translation, Self::Rotation, Self::Scale];

    /// Values per key: 3, or 4 for a rotation.
    #[must_use]
    pub const fn width(self) -> usize {
        match self {
            Self::Translation | Self::Scale => 3,
            Self::Rotation => 4,
        }
    }

    /// Returns the property of a local transform; the fourth component of vectors is 0.
    #[must_use]
    pub const fn of(self, trs: &Trs) -> [f32; 4] {
        let ([tx, ty, tz], [sx, sy, sz]) = (trs.translation, trs.scale);
        match self {
            Self::Translation => [tx, ty, tz, 0.0],
            Self::Rotation => trs.rotation,
            Self::Scale => [sx, sy, sz, 0.0],
        }
    }
}
