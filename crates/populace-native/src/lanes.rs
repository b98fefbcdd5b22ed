//! Vectors of `f32` lanes: one lane for each joint of a block, or for each leg of a member. Twin of
//! `kernels/lanes.cl`.
//!
//! They are plain arrays in plain loops. The compiler turns these into the widest registers of the
//! processor that the surrounding function is compiled for (see [`dispatch`](crate::dispatch)).

use std::ops::{Add, Div, Mul, Neg, Sub};

use populace_device::layout::JOINT_BLOCK;
use populace_model::math::Real;

/// Joints in a block, computed together.
pub(crate) const LANES: usize = JOINT_BLOCK as usize;

/// Most members side by side. It equals the joints of a block, so that members and joints form a
/// square to transpose.
pub(crate) const ABREAST: usize = LANES;

/// A vector of `COUNT` lanes.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub(crate) struct Simd<const COUNT: usize>(pub(crate) [f32; COUNT]);

/// A line of the cache, so that vectors in memory do not cross two.
#[derive(Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [f32; 16]);

/// One lane for each joint of a block.
pub(crate) type Lanes = Simd<LANES>;

/// A number of lanes computed together, loaded from consecutive floats.
pub(crate) trait Load: Real {
    /// Loads a float for each lane from the start of a slice.
    fn load(from: &[f32]) -> Self;
}

/// A number of lanes computed together, such as one for each member.
pub(crate) trait Members: Load {
    /// Lanes computed together.
    const COUNT: usize;

    /// Stores a float for each lane to the start of a slice.
    fn store(self, to: &mut [f32]);

    /// Returns whether any lane is chosen.
    fn any(which: Self::Choice) -> bool;
}

/// A number of joints computed together, each of which can be told from the others: one, or the
/// sixteen of a block.
pub(crate) trait Width: Members {
    /// Returns one lane.
    fn lane(self, lane: usize) -> f32;

    /// Chooses one lane.
    fn only(lane: usize) -> Self::Choice;
}

impl Load for f32 {
    #[inline]
    fn load(from: &[f32]) -> Self {
        from[0]
    }
}

impl Members for f32 {
    const COUNT: usize = 1;

    #[inline]
    fn store(self, to: &mut [f32]) {
        to[0] = self;
    }

    #[inline]
    fn any(which: bool) -> bool {
        which
    }
}

impl Width for f32 {
    #[inline]
    fn lane(self, _lane: usize) -> f32 {
        self
    }

    #[inline]
    fn only(_lane: usize) -> bool {
        true
    }
}

impl<const COUNT: usize> Load for Simd<COUNT> {
    #[inline]
    fn load(from: &[f32]) -> Self {
        from.first_chunk().map_or(Self([0.0; COUNT]), |numbers| Self(*numbers))
    }
}

impl<const COUNT: usize> Members for Simd<COUNT> {
    const COUNT: usize = COUNT;

    #[inline]
    fn store(self, to: &mut [f32]) {
        to[..COUNT].copy_from_slice(&self.0);
    }

    #[inline]
    fn any(which: [bool; COUNT]) -> bool {
        which.contains(&true)
    }
}

impl Width for Lanes {
    #[inline]
    fn lane(self, lane: usize) -> f32 {
        self.0[lane]
    }

    #[inline]
    fn only(lane: usize) -> [bool; LANES] {
        std::array::from_fn(|other| other == lane)
    }
}

impl<const COUNT: usize> Simd<COUNT> {
    /// Computes each lane from its index.
    #[inline(always)]
    pub(crate) fn from_fn(of_lane: impl Fn(usize) -> f32) -> Self {
        let mut lanes = [0.0; COUNT];
        for (lane, value) in lanes.iter_mut().enumerate() {
            *value = of_lane(lane);
        }
        Self(lanes)
    }
}

/// Returns a buffer of at least `count` vectors.
pub(crate) fn vectors<const COUNT: usize>(
    lines: &mut Vec<Line>,
    count: usize,
) -> &mut [Simd<COUNT>] {
    let needed = count * COUNT / LANES;
    if lines.len() < needed {
        lines.resize(needed, Line::default());
    }
    &mut bytemuck::cast_slice_mut(lines)[..count]
}

/// Loads lanes of vectors, from lane `first` on.
#[inline(always)]
pub(crate) fn load<R: Members, const COUNT: usize, const SIZE: usize>(
    from: &[Simd<COUNT>; SIZE],
    first: usize,
) -> [R; SIZE] {
    let mut all = [R::splat(0.0); SIZE];
    for (value, vector) in all.iter_mut().zip(from) {
        *value = R::load(&vector.0[first..]);
    }
    all
}

/// Stores lanes of vectors, from lane `first` on.
#[inline(always)]
pub(crate) fn store<R: Members, const COUNT: usize, const SIZE: usize>(
    values: &[R; SIZE],
    to: &mut [Simd<COUNT>; SIZE],
    first: usize,
) {
    for (value, vector) in values.iter().zip(to) {
        value.store(&mut vector.0[first..]);
    }
}

/// Sets the components of one lane.
#[inline(always)]
pub(crate) fn put<const COUNT: usize, const SIZE: usize>(
    all: &mut [Simd<COUNT>; SIZE],
    lane: usize,
    one: [f32; SIZE],
) {
    for (component, value) in all.iter_mut().zip(one) {
        component.0[lane] = value;
    }
}

/// Returns the components of one lane.
#[inline(always)]
pub(crate) fn lane_of<const COUNT: usize, const SIZE: usize>(
    all: &[Simd<COUNT>; SIZE],
    lane: usize,
) -> [f32; SIZE] {
    let mut one = [0.0; SIZE];
    for (value, component) in one.iter_mut().zip(all) {
        *value = component.0[lane];
    }
    one
}

macro_rules! operators {
    ($($operator:ident $method:ident $sign:tt),*) => {
        $(impl<const COUNT: usize> $operator for Simd<COUNT> {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                Self::from_fn(|lane| self.0[lane] $sign other.0[lane])
            }
        })*
    };
}
operators!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<const COUNT: usize> Neg for Simd<COUNT> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self::from_fn(|lane| -self.0[lane])
    }
}

impl<const COUNT: usize> Real for Simd<COUNT> {
    type Choice = [bool; COUNT];

    #[inline]
    fn splat(value: f32) -> Self {
        Self([value; COUNT])
    }

    #[inline]
    fn less(self, other: Self) -> Self::Choice {
        let mut choice = [false; COUNT];
        for (lane, chosen) in choice.iter_mut().enumerate() {
            *chosen = self.0[lane] < other.0[lane];
        }
        choice
    }

    #[inline]
    fn at_most(self, other: Self) -> Self::Choice {
        let mut choice = [false; COUNT];
        for (lane, chosen) in choice.iter_mut().enumerate() {
            *chosen = self.0[lane] <= other.0[lane];
        }
        choice
    }

    #[inline]
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self {
        Self::from_fn(|lane| if which[lane] { a.0[lane] } else { b.0[lane] })
    }

    #[inline]
    fn inverse_sqrt_guess(self) -> Self {
        Self::from_fn(|lane| self.0[lane].inverse_sqrt_guess())
    }
}
