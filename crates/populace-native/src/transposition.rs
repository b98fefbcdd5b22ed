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
    __m256, __m512, _mm256_loadu_ps, _mm256_permute2f128_ps, _mm256_setzero_ps, _mm256_shuffle_ps,
    _mm256_storeu_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps, _mm512_shuffle_f32x4,
    _mm512_shuffle_ps, _mm512_unpackhi_ps, _mm512_unpacklo_ps,
};

use crate::lanes::{LANES, Lanes};
use crate::processor::Dispatch;

/// Lanes of a vector of AVX2.
#[cfg(target_arch = "x86_64")]
const HALF: usize = LANES / 2;

/// Exchanges rows and columns.
#[inline(always)]
pub(crate) fn transpose(rows: &[Lanes; LANES], columns: &mut [Lanes; LANES], registers: Dispatch) {
    match registers {
        // SAFETY: `detect` makes this value only where the processor has AVX-512. Both types are
        // sixteen floats.
        #[cfg(target_arch = "x86_64")]
        Dispatch::Avx512 => unsafe {
            *columns = std::mem::transmute::<[__m512; LANES], [Lanes; LANES]>(transposed_avx512(
                std::mem::transmute_copy::<[Lanes; LANES], [__m512; LANES]>(rows),
            ));
        },
        // SAFETY: `detect` makes this value only where the processor has AVX2.
        #[cfg(target_arch = "x86_64")]
        Dispatch::Avx2 => unsafe { transpose_avx2(rows, columns) },
        Dispatch::Baseline => transpose_plain(rows, columns),
    }
}

/// Exchanges rows and columns number by number. It is never inlined, since the compiler takes long
/// over so many moves.
#[inline(never)]
fn transpose_plain(rows: &[Lanes; LANES], columns: &mut [Lanes; LANES]) {
    for (at, column) in columns.iter_mut().enumerate() {
        for (value, row) in column.0.iter_mut().zip(rows) {
            *value = row.0[at];
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
fn square_avx2([a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
    // In halves: rows 0 to 3 beside rows 4 to 7, of columns 0 to 3 and of columns 4 to 7.
    let low = |a, b| _mm256_permute2f128_ps::<0x20>(a, b);
    let high = |a, b| _mm256_permute2f128_ps::<0x31>(a, b);
    let [i, j, k, l] = quarters_avx2([low(a, e), low(b, f), low(c, g), low(d, h)]);
    let [m, n, o, p] = quarters_avx2([high(a, e), high(b, f), high(c, g), high(d, h)]);
    [i, j, k, l, m, n, o, p]
}

/// Exchanges rows and columns, in four squares of eight.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn transpose_avx2(rows: &[Lanes; LANES], columns: &mut [Lanes; LANES]) {
    for (down, rows) in rows.as_chunks::<HALF>().0.iter().enumerate() {
        for (across, columns) in columns.as_chunks_mut::<HALF>().0.iter_mut().enumerate() {
            let mut square = [_mm256_setzero_ps(); HALF];
            for (values, row) in square.iter_mut().zip(rows) {
                let half = &row.0[across * HALF..][..HALF];
                // SAFETY: the pointer is of eight floats.
                *values = unsafe { _mm256_loadu_ps(half.as_ptr()) };
            }
            for (column, values) in columns.iter_mut().zip(square_avx2(square)) {
                let half = &mut column.0[down * HALF..][..HALF];
                // SAFETY: as above.
                unsafe { _mm256_storeu_ps(half.as_mut_ptr(), values) };
            }
        }
    }
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
    let [a, b, c, d] = quarters_avx512([a, b, c, d]);
    let [e, f, g, h] = quarters_avx512([e, f, g, h]);
    let [i, j, k, l] = quarters_avx512([i, j, k, l]);
    let [m, n, o, p] = quarters_avx512([m, n, o, p]);
    let [a, e, i, m] = whole_quarters([a, e, i, m]);
    let [b, f, j, n] = whole_quarters([b, f, j, n]);
    let [c, g, k, o] = whole_quarters([c, g, k, o]);
    let [d, h, l, p] = whole_quarters([d, h, l, p]);
    [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Simd;

    #[test]
    fn squares_are_transposed_in_all_registers() {
        let rows: [Lanes; LANES] =
            std::array::from_fn(|row| Simd::from_fn(|lane| (row * LANES + lane) as f32));
        for registers in Dispatch::available() {
            let mut columns = [Simd([0.0; LANES]); LANES];
            transpose(&rows, &mut columns, registers);
            for (at, column) in columns.iter().enumerate() {
                for (lane, value) in column.0.iter().enumerate() {
                    assert_eq!(*value, (lane * LANES + at) as f32, "{registers:?}");
                }
            }
        }
    }
}
