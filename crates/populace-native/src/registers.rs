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

use crate::lanes::{Load, Members};
use crate::pair::Pair;

/// A register of floats. Only [`Dispatch::run`](crate::dispatch::Dispatch::run) may choose a kind,
/// since it alone knows what the processor has.
pub(crate) trait Register: Copy {
    /// Lanes of a register.
    const COUNT: usize;
    /// Result of a comparison.
    type Mask: Copy;
    /// Members side by side that this register computes together.
    type Members: Members;

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
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn any(which: Self::Mask) -> bool;
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
        $load_packed:ident, $members:ty;
        $widen:expr; $less:expr; $at_most:expr; $choose:expr; $both:expr; $either:expr; $any:expr
    ) => {
        // SAFETY of each block: `Dispatch::run` alone names these registers, for work on processors
        // that have them. Pointers are of slices that are long enough.
        impl Register for $register {
            const COUNT: usize = $count;
            type Mask = $mask;
            type Members = $members;

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
            fn both(a: $mask, b: $mask) -> $mask {
                // SAFETY: as above.
                unsafe { $both(a, b) }
            }

            #[inline(always)]
            fn either(a: $mask, b: $mask) -> $mask {
                // SAFETY: as above.
                unsafe { $either(a, b) }
            }

            #[inline(always)]
            fn any(which: $mask) -> bool {
                // SAFETY: as above.
                unsafe { $any(which) }
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

// One member for each: every work may run in these registers, that of a single member too.
register! {
    __m128, 4, __m128, __m128i, __m128i;
    _mm_set1_ps _mm_loadu_ps _mm_storeu_ps _mm_add_ps _mm_sub_ps _mm_mul_ps
    _mm_div_ps _mm_xor_ps _mm_castsi128_ps _mm_castps_si128 _mm_cvtepi32_ps
    _mm_set1_epi32 _mm_loadu_si128 _mm_and_si128 _mm_srli_epi32 _mm_sub_epi32
    _mm_loadl_epi64, f32;
    |halves| _mm_unpacklo_epi16(halves, _mm_setzero_si128());
    _mm_cmplt_ps;
    _mm_cmple_ps;
    |which, a, b| _mm_or_ps(_mm_and_ps(which, a), _mm_andnot_ps(which, b));
    _mm_and_ps;
    _mm_or_ps;
    |which| _mm_movemask_ps(which) != 0
}

register! {
    __m256, 8, __m256, __m256i, __m128i;
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps
    _mm256_div_ps _mm256_xor_ps _mm256_castsi256_ps _mm256_castps_si256 _mm256_cvtepi32_ps
    _mm256_set1_epi32 _mm256_loadu_si256 _mm256_and_si256 _mm256_srli_epi32 _mm256_sub_epi32
    _mm_loadu_si128, One<Self>;
    |halves| _mm256_cvtepu16_epi32(halves);
    _mm256_cmp_ps::<_CMP_LT_OQ>;
    _mm256_cmp_ps::<_CMP_LE_OQ>;
    |which, a, b| _mm256_blendv_ps(b, a, which);
    _mm256_and_ps;
    _mm256_or_ps;
    |which| _mm256_movemask_ps(which) != 0
}

register! {
    __m512, 16, __mmask16, __m512i, __m256i;
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps
    _mm512_div_ps _mm512_xor_ps _mm512_castsi512_ps _mm512_castps_si512 _mm512_cvtepi32_ps
    _mm512_set1_epi32 _mm512_loadu_si512 _mm512_and_si512 _mm512_srli_epi32 _mm512_sub_epi32
    _mm256_loadu_si256, One<Self>;
    |halves| _mm512_cvtepu16_epi32(halves);
    _mm512_cmp_ps_mask::<_CMP_LT_OQ>;
    _mm512_cmp_ps_mask::<_CMP_LE_OQ>;
    |which, a, b| _mm512_mask_blend_ps(which, b, a);
    _mm512_kand;
    _mm512_kor;
    |which| _mm512_mask2int(which) != 0
}

/// Lanes of one register.
#[derive(Clone, Copy)]
pub(crate) struct One<V>(V);

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {
        $(impl<V: Register> $operator for One<V> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        })*
    };
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl<V: Register> Neg for One<V> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.neg())
    }
}

impl<V: Register> Real for One<V> {
    type Choice = V::Mask;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(V::splat(value))
    }

    #[inline(always)]
    fn less(self, other: Self) -> V::Mask {
        self.0.less(other.0)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> V::Mask {
        self.0.at_most(other.0)
    }

    #[inline(always)]
    fn choose(which: V::Mask, a: Self, b: Self) -> Self {
        Self(V::choose(which, a.0, b.0))
    }

    #[inline(always)]
    fn both(a: V::Mask, b: V::Mask) -> V::Mask {
        V::both(a, b)
    }

    #[inline(always)]
    fn either(a: V::Mask, b: V::Mask) -> V::Mask {
        V::either(a, b)
    }

    #[inline(always)]
    fn inverse_sqrt_guess(self) -> Self {
        Self(self.0.inverse_sqrt_guess())
    }
}

impl<V: Register> Load for One<V> {
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        Self(V::load(from))
    }
}

impl<V: Register> Members for One<V> {
    const COUNT: usize = V::COUNT;

    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.0.store(to);
    }

    #[inline(always)]
    fn any(which: V::Mask) -> bool {
        V::any(which)
    }
}

/// Lanes in registers, which take rows of 16 bits for each lane.
pub(crate) trait Registers: Members {
    /// Members side by side that one register computes together.
    type Members: Members;

    /// Converts the low 16 bits of each lane's word.
    fn low_halves(words: &[u32]) -> Self;
    /// Converts the high 16 bits of each lane's word.
    fn high_halves(words: &[u32]) -> Self;
    /// Converts 16 bits for each lane, two lanes in a word.
    fn packed(words: &[u32]) -> Self;
}

impl<V: Register> Registers for One<V> {
    type Members = V::Members;

    #[inline(always)]
    fn low_halves(words: &[u32]) -> Self {
        Self(V::low_halves(words))
    }

    #[inline(always)]
    fn high_halves(words: &[u32]) -> Self {
        Self(V::high_halves(words))
    }

    #[inline(always)]
    fn packed(words: &[u32]) -> Self {
        Self(V::packed(words))
    }
}

impl<R: Registers> Registers for Pair<R> {
    type Members = R::Members;

    #[inline(always)]
    fn low_halves(words: &[u32]) -> Self {
        Self(R::low_halves(words), R::low_halves(&words[R::COUNT..]))
    }

    #[inline(always)]
    fn high_halves(words: &[u32]) -> Self {
        Self(R::high_halves(words), R::high_halves(&words[R::COUNT..]))
    }

    #[inline(always)]
    fn packed(words: &[u32]) -> Self {
        Self(R::packed(words), R::packed(&words[R::COUNT / 2..]))
    }
}
