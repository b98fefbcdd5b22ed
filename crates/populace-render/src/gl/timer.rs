//! Timers of the graphics device.

use std::rc::Rc;
use std::time::Instant;

use glow::HasContext as _;

use super::Gl;
use crate::Error;

/// Timers of the passes of a picture, by their index.
pub(crate) struct Timers<const PASSES: usize> {
    gl: Rc<Gl>,
    queries: [glow::Query; PASSES],
    /// When each pass that was timed since [`clear`](Self::clear) began, by the host's clock.
    began: [Option<Instant>; PASSES],
}

impl<const PASSES: usize> Timers<PASSES> {
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        let mut queries = Vec::with_capacity(PASSES);
        for _ in 0..PASSES {
            // SAFETY: the context is current.
            let query = unsafe { gl.functions.create_query() };
            queries.push(query.map_err(|code| {
                let operation = "create a timer".into();
                Error::GlError { operation, code }
            })?);
        }
        let queries = queries.try_into().map_err(|_| {
            let (operation, code) = ("create a timer".into(), "too few".into());
            Error::GlError { operation, code }
        })?;
        Ok(Self { gl: Rc::clone(gl), queries, began: [None; PASSES] })
    }

    /// Forgets all times.
    pub(crate) fn clear(&mut self) {
        self.began = [None; PASSES];
    }

    /// Begins to time a pass. One pass is timed at a time, and each once.
    pub(crate) fn begin(&mut self, pass: usize) {
        self.began[pass] = Some(Instant::now());
        // SAFETY: the context is current, the query exists, and no other one is active.
        unsafe { self.gl.functions.begin_query(glow::TIME_ELAPSED, self.queries[pass]) }
    }

    pub(crate) fn end(&self) {
        // SAFETY: the context is current, and `begin` made a query active.
        unsafe { self.gl.functions.end_query(glow::TIME_ELAPSED) }
    }

    /// Returns the milliseconds of each pass; 0 for those that were not timed. Waits for the
    /// device.
    ///
    /// Mesa's llvmpipe can return its clock in place of the first time. A time longer than the
    /// host's clock allows counts as none.
    pub(crate) fn ms(&self) -> [f64; PASSES] {
        std::array::from_fn(|pass| {
            let Some(began) = self.began[pass] else { return 0.0 };
            // SAFETY: the context is current, the query exists and has ended.
            let nanosecs = unsafe {
                let functions = &self.gl.functions;
                functions.get_query_parameter_u64(self.queries[pass], glow::QUERY_RESULT)
            };
            #[expect(clippy::cast_precision_loss, reason = "no picture takes 2^53 nanoseconds")]
            let ms = nanosecs as f64 / 1e6;
            if ms > began.elapsed().as_secs_f64() * 1e3 { 0.0 } else { ms }
        })
    }
}

impl<const PASSES: usize> Drop for Timers<PASSES> {
    fn drop(&mut self) {
        if self.gl.make_current().is_err() {
            return;
        }
        for query in self.queries {
            // SAFETY: the context is current, and `self` owns the query.
            unsafe { self.gl.functions.delete_query(query) }
        }
    }
}
