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
}
