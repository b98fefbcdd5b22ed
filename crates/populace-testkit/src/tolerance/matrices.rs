//! Bounds of matrices, derived from bounds of local transforms.

use glam::{DAffine3, DMat3};

use super::{LocalBound, UNIT};
use crate::oracle::{Local, OracleBody};

/// The largest error of an affine transform: of its linear part as a 2-norm, and of its translation
/// in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AffineBound {
    /// Linear part.
    pub linear: f64,
    /// Metres.
    pub translation: f64,
}

impl AffineBound {
    /// Returns the larger of both: the largest error of any element.
    #[must_use]
    pub fn element(&self) -> f64 {
        self.linear.max(self.translation)
    }

    /// Returns the largest error of the image of a point at a distance from the origin.
    #[must_use]
    pub fn at_reach(&self, reach_m: f64) -> f64 {
        self.linear * reach_m + self.translation
    }

    /// Returns the bound of the product of `a`, known within `bound_a`, and `b`, known within
    /// `bound_b`. Each element rounds in three products and two sums, 5 `u` of the product of the
    /// norms; the translation rounds once more in its last sum.
    fn product(a: &DAffine3, bound_a: Self, b: &Norms, bound_b: Self) -> Self {
        let a_norm = norm(&a.matrix3);
        let rounding = 6.0 * UNIT;
        Self {
            linear: a_norm * bound_b.linear
                + bound_a.linear * (b.linear + bound_b.linear)
                + rounding * 3f64.sqrt() * a_norm * b.linear,
            translation: a_norm * bound_b.translation
                + bound_a.linear * (b.translation + bound_b.translation)
                + bound_a.translation
                + rounding * (a_norm * b.translation + a.translation.length()),
        }
    }
}

/// The norms of the two parts of an affine transform.
struct Norms {
    linear: f64,
    translation: f64,
}

/// Returns the root of the sum of squares.
fn frobenius(m: &DMat3) -> f64 {
    m.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Returns the 2-norm (the largest stretch) of a matrix, or up to 2 % more. The largest eigenvalue
/// of `b = transpose(m) * m` is at most the 16th root of the Frobenius norm of `b^16`, which
/// exceeds it by a factor of at most 3^(1/32).
fn norm(m: &DMat3) -> f64 {
    let mut power = m.transpose() * *m;
    for _ in 0..4 {
        power = power * power;
    }
    frobenius(&power).powf(1.0 / 32.0)
}

/// Returns the bound of each joint's `model_from_joint`, derived from the bounds of the locals.
///
/// A quaternion with an error of `e` rotates by at most `2 e`. If its length is off by `e`, it
/// scales its matrix by at most `2 e` more. Both make `4 e` times the largest factor. The
/// conversion to a matrix rounds at most 6 times per element, 18 `u` over the matrix. Products down
/// the hierarchy follow.
#[must_use]
pub fn model_bounds(
    body: &OracleBody,
    locals: &[Local],
    models: &[DAffine3],
    bounds: &[LocalBound],
) -> Vec<AffineBound> {
    (0..locals.len()).map(|joint| model_bound(body, locals, models, bounds, joint)).collect()
}

fn model_bound(
    body: &OracleBody,
    locals: &[Local],
    models: &[DAffine3],
    bounds: &[LocalBound],
    joint: usize,
) -> AffineBound {
    let (local, bound) = (&locals[joint], &bounds[joint]);
    let largest = local.scale.abs().max_element();
    let norms = Norms { linear: largest, translation: local.translation.length() };
    let own = AffineBound {
        linear: largest * (4.0 * bound.rotation + 18.0 * UNIT) + bound.scale,
        translation: 3f64.sqrt() * bound.translation,
    };
    match body.joints[joint].parent {
        None => own,
        Some(parent) => {
            let beneath = model_bound(body, locals, models, bounds, parent);
            AffineBound::product(&models[parent], beneath, &norms, own)
        }
    }
}

/// Returns the bound of each palette entry, derived from the bounds of the joints' matrices.
/// `joint_from_bind` is exact.
#[must_use]
pub fn palette_bounds(
    body: &OracleBody,
    models: &[DAffine3],
    bounds: &[AffineBound],
) -> Vec<AffineBound> {
    let bound = |(joint, bind): &(usize, [f64; 12])| {
        let row = |r: usize| &bind[4 * r..4 * r + 4];
        let sum = |take: fn(&[f64]) -> f64| (0..3).map(|r| take(row(r))).sum::<f64>().sqrt();
        let norms = Norms {
            linear: sum(|r| r[0] * r[0] + r[1] * r[1] + r[2] * r[2]),
            translation: sum(|r| r[3] * r[3]),
        };
        AffineBound::product(&models[*joint], bounds[*joint], &norms, AffineBound::default())
    };
    body.palette.iter().map(bound).collect()
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec4};

    use super::*;
    use crate::Rng;
    use crate::oracle::{model_from_joints, palettes};
    use crate::scenes::Scene;

    fn wrong(rng: &mut Rng, local: &Local, bound: &LocalBound) -> Local {
        let change =
            DVec4::from((rng.direction(), rng.between(-1.0, 1.0))).normalize() * bound.rotation;
        Local {
            translation: local.translation + rng.vector(-1.0, 1.0) * bound.translation,
            rotation: local.rotation + DQuat::from_vec4(change),
            scale: local.scale + rng.vector(-1.0, 1.0) * bound.scale,
        }
    }

    #[test]
    fn local_errors_stay_within_matrix_bounds() {
        let scene = Scene::new();
        let mut rng = Rng::new(91);
        for body in scene.bodies.iter().map(|b| &b.oracle) {
            let locals: Vec<Local> = (0..body.joints.len()).map(|j| body.rest(j)).collect();
            let bound = LocalBound { translation: 1e-6, rotation: 2e-6, scale: 3e-6 };
            let bounds = vec![bound; locals.len()];
            let off: Vec<Local> = locals.iter().map(|l| wrong(&mut rng, l, &bound)).collect();
            let (right, wrong) = (model_from_joints(body, &locals), model_from_joints(body, &off));
            let model_bounds = model_bounds(body, &locals, &right, &bounds);
            for ((a, b), bound) in right.iter().zip(&wrong).zip(&model_bounds) {
                assert!(frobenius(&(a.matrix3 - b.matrix3)) <= 3f64.sqrt() * bound.linear);
                assert!((a.translation - b.translation).length() <= bound.translation);
            }
            let entries = palettes(body, &right).into_iter().zip(palettes(body, &wrong));
            for ((a, b), bound) in entries.zip(palette_bounds(body, &right, &model_bounds)) {
                let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off <= bound.element(), "{off} {bound:?}");
            }
        }
    }
}
