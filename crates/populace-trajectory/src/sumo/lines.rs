//! Bytes with their line numbers.

use std::io::{BufRead, Error, Read, Result};

/// Most bytes of one element or comment. A longer one is no row, and would fill the memory.
const MOST_BYTES: usize = 16 << 20;

/// Counts the lines of what is read.
pub(super) struct Lines<R> {
    from: R,
    line: u64,
    /// Bytes since the last element.
    bytes: usize,
}

impl<R: BufRead> Lines<R> {
    pub(super) fn new(from: R) -> Self {
        Self { from, line: 1, bytes: 0 }
    }

    /// Begins a new element, and returns the number of the line that has been reached.
    pub(super) fn end_event(&mut self) -> u64 {
        self.bytes = 0;
        self.line
    }

    /// Returns true if nothing follows, or nothing that can be read.
    pub(super) fn is_at_end(&mut self) -> bool {
        self.from.fill_buf().is_ok_and(<[u8]>::is_empty) || self.from.fill_buf().is_err()
    }
}

impl<R: BufRead> Read for Lines<R> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let count = self.fill_buf()?.read(into)?;
        self.consume(count);
        Ok(count)
    }
}

impl<R: BufRead> BufRead for Lines<R> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        if self.bytes > MOST_BYTES {
            return Err(Error::other("an element is longer than any that SUMO writes"));
        }
        self.from.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        let bytes = self.from.fill_buf().unwrap_or_default();
        let lines = bytes.iter().take(count).filter(|byte| **byte == b'\n').count();
        self.line += lines as u64;
        self.bytes += count;
        self.from.consume(count);
    }
}
