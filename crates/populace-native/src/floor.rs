//! Lower bound of a frame's time: palettes are written with a constant and nothing is computed.
//! Twin of `kernels/floor.cl`.

use std::time::Instant;

use populace_device::layout::Float4;
use rayon::prelude::*;

use crate::pages::Pages;

/// Writes a constant to every palette, on one thread and in chunks of two sizes on all threads.
/// Returns the time of the fastest, in milliseconds.
pub(crate) fn write_floor(pages: &mut Pages) -> f64 {
    let value = Float4([1.0, 2.0, 3.0, 4.0]);
    let mut best = f64::INFINITY;
    let mut time = |write_page: &dyn Fn(&mut [Float4])| {
        let start = Instant::now();
        pages.begin_frame();
        pages.iter_mut().for_each(write_page);
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
    };
    time(&|page| page.fill(value));
    time(&|page| page.par_chunks_mut(12_288).for_each(|chunk| chunk.fill(value)));
    time(&|page| page.par_chunks_mut(393_216).for_each(|chunk| chunk.fill(value)));
    best
}
