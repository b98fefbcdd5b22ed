//! Single-precision arithmetic of the stages.
//!
//! Functions that kernels need have a twin in the OpenCL C sources with the same order of
//! operations. Devices therefore agree bit for bit wherever only `+ - *` and copies are used, and
//! within the rounding of `/` elsewhere. Most twins carry the module's name: `quat::mul` is
//! `quat_mul`, `vec3::add` is `vec3_add`. Exceptions are `vec3::root` (`square_root`),
//! `vec3::between` (`rotation_between`), `vec3::rotated` (`quat_rotated`), `vec3::part_of`
//! (`quat_part`), `vec3::part_as_told` (`quat_part_as_told`) and `angle::sin_cos` (`sin_cos`).

pub mod affine;
pub mod angle;
pub mod quat;
mod real;
#[cfg(test)]
mod tests;
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

    /// Returns whether every component is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.translation.iter().chain(&self.rotation).chain(&self.scale).all(|v| v.is_finite())
    }

    /// Returns whether no translation exceeds [`LARGEST`] and no scale exceeds [`LARGEST_SCALE`] in
    /// magnitude.
    #[must_use]
    pub fn is_bounded(&self) -> bool {
        let within = |values: &[f32; 3], largest: f32| values.iter().all(|v| v.abs() <= largest);
        within(&self.translation, LARGEST) && within(&self.scale, LARGEST_SCALE)
    }
}

/// Maximum magnitude of a number passed to the library, such as a coordinate in metres. Products of
/// several such numbers stay within single precision.
pub const LARGEST: f32 = 1e9;

/// Maximum scale factor passed to the library. A member's own scale must also be at least `1 /
/// LARGEST_SCALE`.
pub const LARGEST_SCALE: f32 = 1e4;
