//! Sixteen lanes in the processor's own registers.
//!
//! The compiler divides plain arrays into small vectors and single numbers where branches meet.
//! Registers stay whole, which halves the time of a pose.
#![expect(
    unsafe_code,
    reason = "instructions of a feature may only run where the processor has it"
)]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use populace_model::math::{INVERSE_SQRT_BITS, Real};

use crate::lanes::{LANES, Lanes, Load, Members, Simd};

/// A register of floats. Only [`Dispatch::run`](crate::dispatch::Dispatch::run) may choose a kind,
/// since it alone knows what the processor has.
pub(crate) trait Register: Copy {
    /// Lanes of a register.
    const COUNT: usize;
    /// Result of a comparison.
    type Mask: Copy;

    fn splat(value: f32) -> Self;
    fn load(from: &[f32]) -> Self;
    fn store(self, to: &mut [f32]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn neg(self) -> Self;
    fn less(self, other: Self) -> Self::Mask;
    fn at_most(self, other: Self) -> Self::Mask;
    fn choose(which: Self::Mask, a: Self, b: Self) -> Self;
    fn inverse_sqrt_guess(self) -> Self;
    /// The low 16 bits of each word.
    fn low_halves(words: &[u32]) -> Self;
    /// The high 16 bits of each word.
    fn high_halves(words: &[u32]) -> Self;
    /// 16 bits for each lane, two lanes in a word.
    fn packed(words: &[u32]) -> Self;
}

/// Implements [`Register`] by instructions of one name each.
macro_rules! register {
    (
        $register:ty, $count:literal, $mask:ty, $words:ty, $packed:ty;
        $splat:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident
        $xor:ident $as_floats:ident $as_words:ident $convert:ident
        $splat_word:ident $load_words:ident $and:ident $shift:ident $sub_words:ident
        $load_packed:ident $widen:ident;
        $less:expr; $at_most:expr; $choose:expr
    ) => {
        // SAFETY of each block: `Dispatch::run` alone names these registers, for work on processors
        // that have them. Pointers are of slices that are long enough.
        impl Register for $register {
            const COUNT: usize = $count;
            type Mask = $mask;

            #[inline(always)]
            fn splat(value: f32) -> Self {
                // SAFETY: as above.
                unsafe { $splat(value) }
            }

            #[inline(always)]
            fn load(from: &[f32]) -> Self {
                // SAFETY: as above.
                unsafe { $load(from[..$count].as_ptr()) }
            }

            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                // SAFETY: as above.
                unsafe { $store(to[..$count].as_mut_ptr(), self) }
            }

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { $add(self, other) }
            }

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { $sub(self, other) }
            }

            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { $mul(self, other) }
            }

            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { $div(self, other) }
            }

            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: as above.
                unsafe { $xor(self, $splat(-0.0)) }
            }

            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                // SAFETY: as above.
                unsafe { $less(self, other) }
            }

            #[inline(always)]
            fn at_most(self, other: Self) -> $mask {
                // SAFETY: as above.
                unsafe { $at_most(self, other) }
            }

            #[inline(always)]
            fn choose(which: $mask, a: Self, b: Self) -> Self {
                // SAFETY: as above.
                unsafe { $choose(which, a, b) }
            }

            #[inline(always)]
            fn inverse_sqrt_guess(self) -> Self {
                // SAFETY: as above.
                unsafe {
                    let bits = $shift::<1>($as_words(self));
                    $as_floats($sub_words($splat_word(INVERSE_SQRT_BITS.cast_signed()), bits))
                }
            }

            #[inline(always)]
            fn low_halves(words: &[u32]) -> Self {
                // SAFETY: as above.
                unsafe {
                    let words = $load_words(words[..$count].as_ptr().cast::<$words>());
                    $convert($and(words, $splat_word(0xffff)))
                }
            }

            #[inline(always)]
            fn high_halves(words: &[u32]) -> Self {
                // SAFETY: as above.
                unsafe {
                    let words = $load_words(words[..$count].as_ptr().cast::<$words>());
                    $convert($shift::<16>(words))
                }
            }

            #[inline(always)]
            fn packed(words: &[u32]) -> Self {
                // SAFETY: as above.
                unsafe {
                    let halves = $load_packed(words[..$count / 2].as_ptr().cast::<$packed>());
                    $convert($widen(halves))
                }
            }
        }
    };
}

register! {
    __m256, 8, __m256, __m256i, __m128i;
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps
    _mm256_div_ps _mm256_xor_ps _mm256_castsi256_ps _mm256_castps_si256 _mm256_cvtepi32_ps
    _mm256_set1_epi32 _mm256_loadu_si256 _mm256_and_si256 _mm256_srli_epi32 _mm256_sub_epi32
    _mm_loadu_si128 _mm256_cvtepu16_epi32;
    _mm256_cmp_ps::<_CMP_LT_OQ>;
    _mm256_cmp_ps::<_CMP_LE_OQ>;
    |which, a, b| _mm256_blendv_ps(b, a, which)
}

register! {
    __m512, 16, __mmask16, __m512i, __m256i;
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps
    _mm512_div_ps _mm512_xor_ps _mm512_castsi512_ps _mm512_castps_si512 _mm512_cvtepi32_ps
    _mm512_set1_epi32 _mm512_loadu_si512 _mm512_and_si512 _mm512_srli_epi32 _mm512_sub_epi32
    _mm256_loadu_si256 _mm512_cvtepu16_epi32;
    _mm512_cmp_ps_mask::<_CMP_LT_OQ>;
    _mm512_cmp_ps_mask::<_CMP_LE_OQ>;
    |which, a, b| _mm512_mask_blend_ps(which, b, a)
}

/// Sixteen lanes in `COUNT` registers.
#[derive(Clone, Copy)]
pub(crate) struct Registers<V, const COUNT: usize>([V; COUNT]);

/// Computes each register from those of two operands.
#[inline(always)]
fn each<V: Register, const COUNT: usize>(
    a: Registers<V, COUNT>,
    b: Registers<V, COUNT>,
    of: impl Fn(V, V) -> V,
) -> Registers<V, COUNT> {
    let mut all = a.0;
    for (a, b) in all.iter_mut().zip(b.0) {
        *a = of(*a, b);
    }
    Registers(all)
}

/// Computes each register from its index.
#[inline(always)]
fn indexed<V: Register, const COUNT: usize>(of: impl Fn(usize) -> V) -> Registers<V, COUNT> {
    let mut all = [V::splat(0.0); COUNT];
    for (index, register) in all.iter_mut().enumerate() {
        *register = of(index);
    }
    Registers(all)
}

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {
        $(impl<V: Register, const COUNT: usize> $operator for Registers<V, COUNT> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                each(self, other, #[inline(always)] |a, b| a.$method(b))
            }
        })*
    };
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl<V: Register, const COUNT: usize> Neg for Registers<V, COUNT> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        each(
            self,
            self,
            #[inline(always)]
            |a, _| a.neg(),
        )
    }
}

impl<V: Register, const COUNT: usize> Real for Registers<V, COUNT> {
    type Choice = [V::Mask; COUNT];

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([V::splat(value); COUNT])
    }

    #[inline(always)]
    fn less(self, other: Self) -> Self::Choice {
        let mut all = [self.0[0].less(other.0[0]); COUNT];
        for (mask, (a, b)) in all.iter_mut().zip(self.0.into_iter().zip(other.0)).skip(1) {
            *mask = a.less(b);
        }
        all
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Choice {
        let mut all = [self.0[0].at_most(other.0[0]); COUNT];
        for (mask, (a, b)) in all.iter_mut().zip(self.0.into_iter().zip(other.0)).skip(1) {
            *mask = a.at_most(b);
        }
        all
    }

    #[inline(always)]
    fn choose(which: Self::Choice, a: Self, b: Self) -> Self {
        indexed(
            #[inline(always)]
            |index| V::choose(which[index], a.0[index], b.0[index]),
        )
    }

    #[inline(always)]
    fn inverse_sqrt_guess(self) -> Self {
        each(
            self,
            self,
            #[inline(always)]
            |a, _| a.inverse_sqrt_guess(),
        )
    }
}

impl<V: Register, const COUNT: usize> Load for Registers<V, COUNT> {
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        indexed(
            #[inline(always)]
            |index| V::load(&from[index * V::COUNT..]),
        )
    }
}

impl<V: Register> Members for Registers<V, 1> {
    const COUNT: usize = V::COUNT;

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.0[0].store(to);
    }
}

impl<V: Register, const COUNT: usize> Registers<V, COUNT> {
    #[inline(always)]
    pub(crate) fn to_lanes(self) -> Lanes {
        let mut lanes = Simd([0.0; LANES]);
        for (register, to) in self.0.into_iter().zip(lanes.0.chunks_exact_mut(V::COUNT)) {
            register.store(to);
        }
        lanes
    }

    /// Converts the low 16 bits of each lane's word.
    #[inline(always)]
    pub(crate) fn low_halves(words: &[u32]) -> Self {
        indexed(
            #[inline(always)]
            |index| V::low_halves(&words[index * V::COUNT..]),
        )
    }

    /// Converts the high 16 bits of each lane's word.
    #[inline(always)]
    pub(crate) fn high_halves(words: &[u32]) -> Self {
        indexed(
            #[inline(always)]
            |index| V::high_halves(&words[index * V::COUNT..]),
        )
    }

    /// Converts 16 bits for each lane, two lanes in a word.
    #[inline(always)]
    pub(crate) fn packed(words: &[u32]) -> Self {
        indexed(
            #[inline(always)]
            |index| V::packed(&words[index * V::COUNT / 2..]),
        )
    }
}
