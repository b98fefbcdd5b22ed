//! Numbers side by side: one for each joint of a block, or for each leg of a member.
//!
//! Plain arrays in plain loops, which the compiler turns into the widest registers of the processor
//! that a function is compiled for (see [`dispatch`](crate::dispatch)).

use std::ops::{Add, Div, Mul, Neg, Sub};

use populace_device::layout::JOINT_BLOCK;
use populace_model::math::Real;

/// Joints side by side.
pub(crate) const LANES: usize = JOINT_BLOCK as usize;

/// Numbers side by side.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Several<const COUNT: usize>(pub(crate) [f32; COUNT]);

/// Sixteen numbers.
pub(crate) type Lanes = Several<LANES>;

impl<const COUNT: usize> Several<COUNT> {
    /// One number for each lane.
    #[inline(always)]
    pub(crate) fn from_fn(of_lane: impl Fn(usize) -> f32) -> Self {
        let mut lanes = [0.0; COUNT];
        for (lane, value) in lanes.iter_mut().enumerate() {
            *value = of_lane(lane);
        }
        Self(lanes)
    }

    /// From the first numbers of a slice.
    #[inline(always)]
    pub(crate) fn load(from: &[f32]) -> Self {
        from.first_chunk().map_or(Self([0.0; COUNT]), |numbers| Self(*numbers))
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $sign:tt),*) => {
        $(impl<const COUNT: usize> $operator for Several<COUNT> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::from_fn(|lane| self.0[lane] $sign other.0[lane])
            }
        })*
    };
}
operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const COUNT: usize> Neg for Several<COUNT> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::from_fn(|lane| -self.0[lane])
    }
}

impl<const COUNT: usize> Real for Several<COUNT> {
    type Choice = [bool; COUNT];

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; COUNT])
    }

    #[inline(always)]
    fn less(self, other: Self) -> Self::Choice {
        let mut choice = [false; COUNT];
        for (lane, chosen) in choice.iter_mut().enumerate() {
            *chosen = self.0[lane] < other.0[lane];
        }
        choice
    }

    #[inline(always)]
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self {
        Self::from_fn(|lane| if which[lane] { a.0[lane] } else { b.0[lane] })
    }

    #[inline(always)]
    fn inverse_sqrt_guess(self) -> Self {
        Self::from_fn(|lane| self.0[lane].inverse_sqrt_guess())
    }
}
