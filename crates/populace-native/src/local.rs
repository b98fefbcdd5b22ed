//! Algebra of local transforms, of one joint or of sixteen. Twin of `kernels/local.cl`.

use populace_model::math::{Real, quat};

/// Translation, rotation (x, y, z, w) and scale, relative to the parent joint.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Local<R> {
    pub(crate) t: [R; 3],
    pub(crate) r: [R; 4],
    pub(crate) s: [R; 3],
}

impl<R: Real> Local<R> {
    /// All components 0: the start of a weighted sum. It is not a transform.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let zero = R::splat(0.0);
        Self { t: [zero; 3], r: [zero; 4], s: [zero; 3] }
    }
}

/// Computes three components from their indices.
#[inline(always)]
pub(crate) fn each3<R: Real>(of: impl Fn(usize) -> R) -> [R; 3] {
    [of(0), of(1), of(2)]
}

/// Returns the ratio of two scales; 1 if the reference is 0 or no number.
#[inline(always)]
fn scale_ratio<R: Real>(value: R, reference: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let quotient = value / reference;
    let below = R::choose(reference.less(zero), quotient, one);
    R::choose(zero.less(reference), quotient, below)
}

/// Returns the difference that takes `reference` to `value`: the translations' difference,
/// `reference.r⁻¹ * value.r` in the hemisphere of `side`, and the scales' [`scale_ratio`].
#[inline(always)]
pub(crate) fn quotient<R: Real>(value: &Local<R>, reference: &Local<R>, side: [R; 4]) -> Local<R> {
    let r = quat::hemisphere(quat::mul(quat::conjugate(reference.r), value.r), side);
    // No closure: it would not be compiled for the caller's registers.
    let ([x, y, z], of) = (value.s, reference.s);
    let s = [scale_ratio(x, of[0]), scale_ratio(y, of[1]), scale_ratio(z, of[2])];
    Local { t: each3(|i| value.t[i] - reference.t[i]), r, s }
}

/// Subtracts the identity from a difference, so that 0 changes nothing and weighted sums do not
/// depend on the order of their terms.
#[inline(always)]
pub(crate) fn change<R: Real>(quotient: &Local<R>) -> Local<R> {
    let ([x, y, z, w], one) = (quotient.r, R::splat(1.0));
    Local { t: quotient.t, r: [x, y, z, w - one], s: each3(|i| quotient.s[i] - one) }
}

/// Applies a weighted sum of [`change`]s to the pose beneath.
#[inline(always)]
pub(crate) fn add_layer<R: Real>(beneath: &Local<R>, sum: &Local<R>, layer_weight: R) -> Local<R> {
    let delta = quat::add(quat::identity(), quat::scale(sum.r, layer_weight));
    let delta = quat::normalize_or(delta, quat::identity());
    Local {
        t: each3(|i| beneath.t[i] + sum.t[i] * layer_weight),
        r: quat::mul(beneath.r, delta),
        s: each3(|i| beneath.s[i] * (R::splat(1.0) + sum.s[i] * layer_weight)),
    }
}

/// Combines two differences: first one, then the other.
#[inline(always)]
pub(crate) fn after<R: Real>(first: &Local<R>, then: &Local<R>) -> Local<R> {
    Local {
        t: each3(|i| first.t[i] + then.t[i]),
        r: quat::mul(first.r, then.r),
        s: each3(|i| first.s[i] * then.s[i]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference scales, and the ratio of 2 to each. The test of the same name in populace-opencl
    /// has the same numbers.
    const RATIOS: [(f32, f32); 6] =
        [(4.0, 0.5), (-4.0, -0.5), (0.0, 1.0), (-0.0, 1.0), (f32::NAN, 1.0), (f32::INFINITY, 0.0)];

    #[test]
    fn scale_ratio_to_no_number_is_one() {
        for (reference, wanted) in RATIOS {
            let pose = |s| Local { t: [0.0; 3], r: quat::identity(), s: [s; 3] };
            let found = quotient(&pose(2.0), &pose(reference), quat::identity());
            assert_eq!(found.s.map(f32::to_bits), [wanted.to_bits(); 3], "{reference}");
        }
    }
}
