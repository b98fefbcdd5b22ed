//! Transposition of squares of lanes: rows of members become rows of joints, and back.
//!
//! The compiler turns shuffles of plain arrays into moves of single numbers, so the processor's own
//! shuffles are named here. Other registers get the plain form.
#![cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "a function compiled for a feature may only be called where the processor has it"
    )
)]

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m256, __m512, _mm256_permute2f128_ps, _mm256_shuffle_ps, _mm256_unpackhi_ps,
    _mm256_unpacklo_ps, _mm512_shuffle_f32x4, _mm512_shuffle_ps, _mm512_unpackhi_ps,
    _mm512_unpacklo_ps,
};

use crate::dispatch::Dispatch;
use crate::lanes::Simd;

/// A vector of lanes that a square is made of.
pub(crate) trait Square<const COUNT: usize>: Sized {
    /// Exchanges rows and columns.
    fn transposed(rows: &[Self; COUNT], registers: Dispatch) -> [Self; COUNT];
}

/// Exchanges rows and columns number by number. It is never inlined, since the compiler takes long
/// over so many moves.
#[inline(never)]
fn plain<const COUNT: usize>(rows: &[Simd<COUNT>; COUNT]) -> [Simd<COUNT>; COUNT] {
    let mut columns = [Simd([0.0; COUNT]); COUNT];
    for (at, column) in columns.iter_mut().enumerate() {
        for (value, row) in column.0.iter_mut().zip(rows) {
            *value = row.0[at];
        }
    }
    columns
}

impl Square<4> for Simd<4> {
    #[inline(always)]
    fn transposed(rows: &[Self; 4], _: Dispatch) -> [Self; 4] {
        plain(rows)
    }
}

impl Square<8> for Simd<8> {
    #[inline(always)]
    fn transposed(rows: &[Self; 8], registers: Dispatch) -> [Self; 8] {
        match registers {
            // SAFETY: `detect` makes these values only where the processor has AVX2. Both types are
            // eight floats.
            #[cfg(target_arch = "x86_64")]
            Dispatch::Avx2 | Dispatch::Avx512 => unsafe {
                std::mem::transmute::<[__m256; 8], [Self; 8]>(transposed_avx2(
                    std::mem::transmute_copy::<[Self; 8], [__m256; 8]>(rows),
                ))
            },
            Dispatch::Baseline => plain(rows),
        }
    }
}

impl Square<16> for Simd<16> {
    #[inline(always)]
    fn transposed(rows: &[Self; 16], registers: Dispatch) -> [Self; 16] {
        match registers {
            // SAFETY: `detect` makes this value only where the processor has AVX-512. Both types
            // are sixteen floats.
            #[cfg(target_arch = "x86_64")]
            Dispatch::Avx512 => unsafe {
                std::mem::transmute::<[__m512; 16], [Self; 16]>(transposed_avx512(
                    std::mem::transmute_copy::<[Self; 16], [__m512; 16]>(rows),
                ))
            },
            _ => plain(rows),
        }
    }
}

/// Exchanges rows and columns within each quarter of 128 bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn quarters_avx2([a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
    let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
    [
        _mm256_shuffle_ps::<0x44>(ab, cd),
        _mm256_shuffle_ps::<0xee>(ab, cd),
        _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
        _mm256_shuffle_ps::<0xee>(ab_high, cd_high),
    ]
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn transposed_avx2([a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
    // In halves: rows 0 to 3 beside rows 4 to 7, of columns 0 to 3 and of columns 4 to 7.
    let low = |a, b| _mm256_permute2f128_ps::<0x20>(a, b);
    let high = |a, b| _mm256_permute2f128_ps::<0x31>(a, b);
    let [i, j, k, l] = quarters_avx2([low(a, e), low(b, f), low(c, g), low(d, h)]);
    let [m, n, o, p] = quarters_avx2([high(a, e), high(b, f), high(c, g), high(d, h)]);
    [i, j, k, l, m, n, o, p]
}

/// Exchanges rows and columns within each quarter of 128 bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn quarters_avx512([a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
    let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
    [
        _mm512_shuffle_ps::<0x44>(ab, cd),
        _mm512_shuffle_ps::<0xee>(ab, cd),
        _mm512_shuffle_ps::<0x44>(ab_high, cd_high),
        _mm512_shuffle_ps::<0xee>(ab_high, cd_high),
    ]
}

/// Exchanges whole quarters: row `i` of the result has quarter `i` of each vector.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn whole_quarters([a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    let (ab, cd) = (_mm512_shuffle_f32x4::<0x44>(a, b), _mm512_shuffle_f32x4::<0x44>(c, d));
    let (ab_high, cd_high) =
        (_mm512_shuffle_f32x4::<0xee>(a, b), _mm512_shuffle_f32x4::<0xee>(c, d));
    [
        _mm512_shuffle_f32x4::<0x88>(ab, cd),
        _mm512_shuffle_f32x4::<0xdd>(ab, cd),
        _mm512_shuffle_f32x4::<0x88>(ab_high, cd_high),
        _mm512_shuffle_f32x4::<0xdd>(ab_high, cd_high),
    ]
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[inline]
fn transposed_avx512(rows: [__m512; 16]) -> [__m512; 16] {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = rows;
    let first = quarters_avx512([a, b, c, d]);
    let second = quarters_avx512([e, f, g, h]);
    let third = quarters_avx512([i, j, k, l]);
    let fourth = quarters_avx512([m, n, o, p]);
    let columns = [0, 1, 2, 3]
        .map(|at: usize| whole_quarters([first[at], second[at], third[at], fourth[at]]));
    let [[a, e, i, m], [b, f, j, n], [c, g, k, o], [d, h, l, p]] = columns;
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const COUNT: usize>(registers: Dispatch)
    where
        Simd<COUNT>: Square<COUNT>,
    {
        let rows: [Simd<COUNT>; COUNT] =
            std::array::from_fn(|row| Simd::from_fn(|lane| (row * COUNT + lane) as f32));
        let columns = Square::transposed(&rows, registers);
        for (at, column) in columns.iter().enumerate() {
            for (lane, value) in column.0.iter().enumerate() {
                assert_eq!(*value, (lane * COUNT + at) as f32, "{COUNT} lanes, {registers:?}");
            }
        }
    }

    #[test]
    fn squares_are_transposed_in_all_registers() {
        for registers in Dispatch::available() {
            check::<4>(registers);
            check::<8>(registers);
            check::<16>(registers);
        }
    }
}
