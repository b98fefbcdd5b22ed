//! Lanes in the processor's own registers.
//!
//! The compiler divides plain arrays into small vectors and single numbers where branches meet.
//! Registers stay whole, which halves the time of a pose.
//!
//! Operations are `#[inline]`, not `#[inline(always)]`. The compiler simplifies them before it
//! inlines them, so the crate compiles in a seventh less time. Each is a few instructions, which the
//! compiler always inlines.
#![expect(
    unsafe_code,
    reason = "instructions of a feature may only run where the processor has it"
)]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use populace_model::math::{INVERSE_SQRT_BITS, Real};

use crate::lanes::{Load, Members};
use crate::pair::Pair;

/// Lanes in registers, which take rows of 16 bits for each lane.
pub(crate) trait Registers: Members {
    /// Members side by side that one register computes together.
    type Members: Members;

    /// Returns the weighted sum of the low 16 bits of each lane's words, which are signed. The
    /// lower half of `weights` is the weight of `from`, the upper half that of `to`.
    fn mix_low(from: &[u32], to: &[u32], weights: u32) -> Self;
    /// The same for the high 16 bits.
    fn mix_high(from: &[u32], to: &[u32], weights: u32) -> Self;
    /// The same for 16 bits of each lane, two lanes in a word.
    fn mix_packed(from: &[u32], to: &[u32], weights: u32) -> Self;
}

/// Implements an operator by one instruction.
macro_rules! operator {
    ($register:ident, $operator:ident, $method:ident, $instruction:ident) => {
        impl $operator for $register {
            type Output = Self;

            #[inline]
            fn $method(self, other: Self) -> Self {
                // SAFETY: as of `register`.
                unsafe { Self($instruction(self.0, other.0)) }
            }
        }
    };
}

/// Makes a register of floats, by instructions of one name each. Only
/// [`Dispatch::run`](crate::processor::Dispatch::run) may choose one, since it alone knows what the
/// processor has.
macro_rules! register {
    (
        $register:ident, $floats:ty, $count:literal, $mask:ty, $words:ty, $packed:ty;
        $splat:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident
        $xor:ident $as_floats:ident $as_words:ident $convert:ident
        $splat_word:ident $load_words:ident $and:ident $or:ident $shift:ident $shift_left:ident
        $sub_words:ident $multiply_add:ident $load_packed:ident;
        $widen:expr; $less:expr; $at_most:expr; $choose:expr; $both:expr; $either:expr; $any:expr
    ) => {
        #[derive(Clone, Copy)]
        pub(crate) struct $register($floats);

        // SAFETY of each block: `Dispatch::run` alone names these registers, for work on processors
        // that have them. Pointers are of slices that are long enough.
        operator!($register, Add, add, $add);
        operator!($register, Sub, sub, $sub);
        operator!($register, Mul, mul, $mul);
        operator!($register, Div, div, $div);

        impl Neg for $register {
            type Output = Self;

            #[inline]
            fn neg(self) -> Self {
                // SAFETY: as above.
                unsafe { Self($xor(self.0, $splat(-0.0))) }
            }
        }

        impl Real for $register {
            type Choice = $mask;

            #[inline]
            fn splat(value: f32) -> Self {
                // SAFETY: as above.
                unsafe { Self($splat(value)) }
            }

            #[inline]
            fn less(self, other: Self) -> $mask {
                // SAFETY: as above.
                unsafe { $less(self.0, other.0) }
            }

            #[inline]
            fn at_most(self, other: Self) -> $mask {
                // SAFETY: as above.
                unsafe { $at_most(self.0, other.0) }
            }

            #[inline]
            fn choose(which: $mask, a: Self, b: Self) -> Self {
                // SAFETY: as above.
                unsafe { Self($choose(which, a.0, b.0)) }
            }

            #[inline]
            fn both(a: $mask, b: $mask) -> $mask {
                // SAFETY: as above.
                unsafe { $both(a, b) }
            }

            #[inline]
            fn either(a: $mask, b: $mask) -> $mask {
                // SAFETY: as above.
                unsafe { $either(a, b) }
            }

            #[inline]
            fn inverse_sqrt_guess(self) -> Self {
                // SAFETY: as above.
                unsafe {
                    let bits = $shift::<1>($as_words(self.0));
                    let start = $splat_word(INVERSE_SQRT_BITS.cast_signed());
                    Self($as_floats($sub_words(start, bits)))
                }
            }
        }

        impl Load for $register {
            #[inline]
            fn load(from: &[f32]) -> Self {
                // SAFETY: as above.
                unsafe { Self($load(from[..$count].as_ptr())) }
            }
        }

        impl Members for $register {
            const COUNT: usize = $count;

            #[inline]
            fn store(self, to: &mut [f32]) {
                // SAFETY: as above.
                unsafe { $store(to[..$count].as_mut_ptr(), self.0) }
            }

            #[inline]
            fn any(which: $mask) -> bool {
                // SAFETY: as above.
                unsafe { $any(which) }
            }
        }

        impl Registers for $register {
            type Members = Self;

            #[inline]
            fn mix_low(from: &[u32], to: &[u32], weights: u32) -> Self {
                // SAFETY: as above.
                unsafe {
                    let from = $load_words(from[..$count].as_ptr().cast::<$words>());
                    let to = $load_words(to[..$count].as_ptr().cast::<$words>());
                    let from = $and(from, $splat_word(0xffff));
                    Self::mix_pairs($or(from, $shift_left::<16>(to)), weights)
                }
            }

            #[inline]
            fn mix_high(from: &[u32], to: &[u32], weights: u32) -> Self {
                // SAFETY: as above.
                unsafe {
                    let from = $load_words(from[..$count].as_ptr().cast::<$words>());
                    let to = $load_words(to[..$count].as_ptr().cast::<$words>());
                    let to = $and(to, $splat_word(-0x10000));
                    Self::mix_pairs($or($shift::<16>(from), to), weights)
                }
            }

            #[inline]
            fn mix_packed(from: &[u32], to: &[u32], weights: u32) -> Self {
                // SAFETY: as above.
                unsafe {
                    let from = $load_packed(from[..$count / 2].as_ptr().cast::<$packed>());
                    let to = $load_packed(to[..$count / 2].as_ptr().cast::<$packed>());
                    Self::mix_pairs($or($widen(from), $shift_left::<16>($widen(to))), weights)
                }
            }
        }

        impl $register {
            /// Returns the sum of the products of both halves of each word.
            #[inline]
            fn mix_pairs(pairs: $words, weights: u32) -> Self {
                // SAFETY: as above.
                unsafe { Self($convert($multiply_add(pairs, $splat_word(weights.cast_signed())))) }
            }
        }
    };
}

register! {
    Sse, __m128, 4, __m128, __m128i, __m128i;
    _mm_set1_ps _mm_loadu_ps _mm_storeu_ps _mm_add_ps _mm_sub_ps _mm_mul_ps
    _mm_div_ps _mm_xor_ps _mm_castsi128_ps _mm_castps_si128 _mm_cvtepi32_ps
    _mm_set1_epi32 _mm_loadu_si128 _mm_and_si128 _mm_or_si128 _mm_srli_epi32
    _mm_slli_epi32 _mm_sub_epi32 _mm_madd_epi16 _mm_loadl_epi64;
    |halves| _mm_unpacklo_epi16(halves, _mm_setzero_si128());
    _mm_cmplt_ps;
    _mm_cmple_ps;
    |which, a, b| _mm_or_ps(_mm_and_ps(which, a), _mm_andnot_ps(which, b));
    _mm_and_ps;
    _mm_or_ps;
    |which| _mm_movemask_ps(which) != 0
}

register! {
    Avx2, __m256, 8, __m256, __m256i, __m128i;
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps
    _mm256_div_ps _mm256_xor_ps _mm256_castsi256_ps _mm256_castps_si256 _mm256_cvtepi32_ps
    _mm256_set1_epi32 _mm256_loadu_si256 _mm256_and_si256 _mm256_or_si256 _mm256_srli_epi32
    _mm256_slli_epi32 _mm256_sub_epi32 _mm256_madd_epi16 _mm_loadu_si128;
    |halves| _mm256_cvtepu16_epi32(halves);
    _mm256_cmp_ps::<_CMP_LT_OQ>;
    _mm256_cmp_ps::<_CMP_LE_OQ>;
    |which, a, b| _mm256_blendv_ps(b, a, which);
    _mm256_and_ps;
    _mm256_or_ps;
    |which| _mm256_movemask_ps(which) != 0
}

register! {
    Avx512, __m512, 16, __mmask16, __m512i, __m256i;
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps
    _mm512_div_ps _mm512_xor_ps _mm512_castsi512_ps _mm512_castps_si512 _mm512_cvtepi32_ps
    _mm512_set1_epi32 _mm512_loadu_si512 _mm512_and_si512 _mm512_or_si512 _mm512_srli_epi32
    _mm512_slli_epi32 _mm512_sub_epi32 _mm512_madd_epi16 _mm256_loadu_si256;
    |halves| _mm512_cvtepu16_epi32(halves);
    _mm512_cmp_ps_mask::<_CMP_LT_OQ>;
    _mm512_cmp_ps_mask::<_CMP_LE_OQ>;
    |which, a, b| _mm512_mask_blend_ps(which, b, a);
    _mm512_kand;
    _mm512_kor;
    |which| _mm512_mask2int(which) != 0
}

impl<R: Registers> Registers for Pair<R> {
    type Members = R::Members;

    #[inline]
    fn mix_low(from: &[u32], to: &[u32], weights: u32) -> Self {
        let upper = R::mix_low(&from[R::COUNT..], &to[R::COUNT..], weights);
        Self(R::mix_low(from, to, weights), upper)
    }

    #[inline]
    fn mix_high(from: &[u32], to: &[u32], weights: u32) -> Self {
        let upper = R::mix_high(&from[R::COUNT..], &to[R::COUNT..], weights);
        Self(R::mix_high(from, to, weights), upper)
    }

    #[inline]
    fn mix_packed(from: &[u32], to: &[u32], weights: u32) -> Self {
        let upper = R::mix_packed(&from[R::COUNT / 2..], &to[R::COUNT / 2..], weights);
        Self(R::mix_packed(from, to, weights), upper)
    }
}
