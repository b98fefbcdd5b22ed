//! The functions of one `f32` that the stages use beyond `+ - *`, named in one place.
//!
//! `sqrt` and `/` are correctly rounded here; an OpenCL device may round them within 3 and 2.5 units in the last
//! place (OpenCL C 1.2, section 7.4), which is where the conformance bounds come from.

/// The square root.
#[expect(clippy::disallowed_methods, reason = "this is the one place that names it")]
#[inline]
#[must_use]
pub fn sqrt(x: f32) -> f32 {
    x.sqrt()
}

/// `a` at `t = 0`, moving towards `b` as `t` grows: `a + (b - a) * t`.
#[inline]
#[must_use]
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}
