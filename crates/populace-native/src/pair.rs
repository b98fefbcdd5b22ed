//! Lanes in two halves, such as those of two registers.
//!
//! Each operation names both halves. Loops over an array of registers take the compiler longer, and
//! it leaves the arrays in memory.

use std::ops::{Add, Div, Mul, Neg, Sub};

use populace_model::math::Real;

use crate::lanes::{Load, Members};

/// The first and the second half of the lanes.
#[derive(Clone, Copy)]
pub(crate) struct Pair<R>(pub(crate) R, pub(crate) R);

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {
        $(impl<R: Real> $operator for Pair<R> {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1.$method(other.1))
            }
        })*
    };
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl<R: Real> Neg for Pair<R> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl<R: Real> Real for Pair<R> {
    type Choice = (R::Choice, R::Choice);

    #[inline]
    fn splat(value: f32) -> Self {
        Self(R::splat(value), R::splat(value))
    }

    #[inline]
    fn less(self, other: Self) -> Self::Choice {
        (self.0.less(other.0), self.1.less(other.1))
    }

    #[inline]
    fn at_most(self, other: Self) -> Self::Choice {
        (self.0.at_most(other.0), self.1.at_most(other.1))
    }

    #[inline]
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self {
        Self(R::choose(which.0, a.0, b.0), R::choose(which.1, a.1, b.1))
    }

    #[inline]
    fn both(a: Self::Choice, b: Self::Choice) -> Self::Choice {
        (R::both(a.0, b.0), R::both(a.1, b.1))
    }

    #[inline]
    fn either(a: Self::Choice, b: Self::Choice) -> Self::Choice {
        (R::either(a.0, b.0), R::either(a.1, b.1))
    }

    #[inline]
    fn others(which: Self::Choice) -> Self::Choice {
        (R::others(which.0), R::others(which.1))
    }

    #[inline]
    fn inverse_sqrt_guess(self) -> Self {
        Self(self.0.inverse_sqrt_guess(), self.1.inverse_sqrt_guess())
    }
}

impl<R: Members> Load for Pair<R> {
    #[inline]
    fn load(from: &[f32]) -> Self {
        Self(R::load(from), R::load(&from[R::COUNT..]))
    }
}

impl<R: Members> Members for Pair<R> {
    const COUNT: usize = 2 * R::COUNT;

    #[inline]
    fn store(self, to: &mut [f32]) {
        self.0.store(to);
        self.1.store(&mut to[R::COUNT..]);
    }

    #[inline]
    fn any(which: Self::Choice) -> bool {
        R::any(which.0) || R::any(which.1)
    }
}
