//! Widths that poses are computed in: one joint, sixteen in memory, or sixteen in registers.

#[cfg(target_arch = "x86_64")]
use crate::lanes::LANES;
use crate::lanes::{Lanes, Members, Simd};
use crate::local::Local;
#[cfg(target_arch = "x86_64")]
use crate::registers::Registers;
use crate::rows::RowWidth;

/// A width that local transforms are sampled in.
pub(crate) trait SampleWidth: RowWidth + Members {
    /// The same lanes in memory, for functions that are compiled apart from their callers: a caller
    /// that rarely needs them must not pay for their registers.
    type Stored: RowWidth;

    /// Stores the lanes.
    fn stored(self) -> Self::Stored;

    /// Loads lanes.
    fn loaded(stored: Self::Stored) -> Self;
}

/// A width of sixteen joints.
pub(crate) trait JointLanes: SampleWidth<Stored = Lanes> {
    /// One register of the same kind, with a member in each lane.
    type Members: Members;
}

impl<R: SampleWidth> Local<R> {
    /// Stores the lanes.
    #[inline(always)]
    pub(crate) fn stored(self) -> Local<R::Stored> {
        let Self { t: [tx, ty, tz], r: [rx, ry, rz, rw], s: [sx, sy, sz] } = self;
        Local {
            t: [tx.stored(), ty.stored(), tz.stored()],
            r: [rx.stored(), ry.stored(), rz.stored(), rw.stored()],
            s: [sx.stored(), sy.stored(), sz.stored()],
        }
    }

    /// Loads lanes.
    #[inline(always)]
    pub(crate) fn loaded(stored: Local<R::Stored>) -> Self {
        let Local { t: [tx, ty, tz], r: [rx, ry, rz, rw], s: [sx, sy, sz] } = stored;
        Self {
            t: [R::loaded(tx), R::loaded(ty), R::loaded(tz)],
            r: [R::loaded(rx), R::loaded(ry), R::loaded(rz), R::loaded(rw)],
            s: [R::loaded(sx), R::loaded(sy), R::loaded(sz)],
        }
    }
}

/// Implements [`SampleWidth`] for a width in memory.
macro_rules! stored {
    ($width:ty) => {
        impl SampleWidth for $width {
            type Stored = Self;

            #[inline(always)]
            fn stored(self) -> Self {
                self
            }

            #[inline(always)]
            fn loaded(stored: Self) -> Self {
                stored
            }
        }
    };
}
stored!(f32);
stored!(Lanes);

impl JointLanes for Lanes {
    type Members = Simd<4>;
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> SampleWidth for R {
    type Stored = Lanes;

    #[inline(always)]
    fn stored(self) -> Lanes {
        let mut lanes = Simd([0.0; LANES]);
        self.store(&mut lanes.0);
        lanes
    }

    #[inline(always)]
    fn loaded(stored: Lanes) -> Self {
        Self::load(&stored.0)
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> JointLanes for R {
    type Members = R::Members;
}
