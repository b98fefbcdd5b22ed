//! The arithmetic of the stages in single precision.
//!
//! Functions that the kernels need have a twin in the OpenCL C sources with the same order of
//! operations, so that devices agree bit for bit wherever `+ - *` and copies decide, and within the
//! rounding of `/` elsewhere. Names there carry the module's name where OpenCL C has no modules:
//! `quat::mul` is `quat_mul`.

pub mod affine;
pub mod angle;
pub mod quat;
mod real;
pub mod vec3;

pub use affine::{Affine, components};
pub use real::{INVERSE_SQRT_BITS, Real};

/// A local transform: translation, rotation and scale relative to the parent joint.
///
/// Applied to a point in the order scale, rotation, translation (glTF 2.0, section 3.5.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// Translation in metres.
    pub translation: [f32; 3],
    /// Unit quaternion, `x y z w`.
    pub rotation: [f32; 4],
    /// Scale factors along the joint's own axes.
    pub scale: [f32; 3],
}

impl Trs {
    /// The transform that changes nothing.
    pub const IDENTITY: Self =
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0, 1.0, 1.0] };

    /// Whether every component is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.translation.iter().chain(&self.rotation).chain(&self.scale).all(|v| v.is_finite())
    }

    /// Whether translations are at most [`LARGEST`] in size and scales at most [`LARGEST_SCALE`].
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        let within = |values: &[f32; 3], largest: f32| values.iter().all(|v| v.abs() <= largest);
        within(&self.translation, LARGEST) && within(&self.scale, LARGEST_SCALE)
    }
}

/// The largest size of a number that calls take, such as a coordinate in metres: products of
/// several stay within single precision.
pub const LARGEST: f32 = 1e9;

/// The largest scale factor that calls take; a member's own scale is at least 1 part of it.
pub const LARGEST_SCALE: f32 = 1e4;
