//! Lines of the cache: asked for before they are read, and written past it. Twin of `fetch_lines`
//! and `write_line` in `kernels/company.cl` and `kernels/fused_wide.cl`.
//!
//! Processors other than x86-64 read and write as usual.
#![cfg_attr(target_arch = "x86_64", expect(unsafe_code, reason = "the instructions take pointers"))]

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m128, _MM_HINT_T1, _mm_loadu_ps, _mm_prefetch, _mm_sfence, _mm_stream_ps,
};

/// Floats or words in a line.
const LINE: usize = 16;

/// Asks for memory, so that it is in the second-level cache when it is read. Rows of sixteen members
/// do not fit into the first.
#[inline(always)]
pub(crate) fn fetch_lines(words: &[u32]) {
    #[cfg(target_arch = "x86_64")]
    // Words that do not begin a line reach into one line more.
    for word in words.iter().step_by(LINE).chain(words.last()) {
        // SAFETY: asking for a line changes nothing that a program can see.
        unsafe { _mm_prefetch::<_MM_HINT_T1>(std::ptr::from_ref(word).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = words;
}

/// Writes sixteen numbers. A whole line goes past the caches, which would read it first.
///
/// [`finish_lines`] must follow before any thread uses them, this one included.
#[inline(always)]
pub(crate) fn write_line(line: &[f32; LINE], to: &mut [f32; LINE]) {
    #[cfg(target_arch = "x86_64")]
    if to.as_ptr().addr().is_multiple_of(64) {
        let (from, to) = (line.as_ptr(), to.as_mut_ptr());
        for quarter in (0..LINE).step_by(size_of::<__m128>() / size_of::<f32>()) {
            // SAFETY: both hold sixteen floats, and `to` begins a line. Callers call `finish_lines`
            // before the memory is used again.
            unsafe { _mm_stream_ps(to.add(quarter), _mm_loadu_ps(from.add(quarter))) };
        }
        return;
    }
    *to = *line;
}

/// Makes written lines visible to other threads.
#[inline(always)]
pub(crate) fn finish_lines() {
    // SAFETY: every x86-64 processor has the instruction.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        _mm_sfence();
    }
}
