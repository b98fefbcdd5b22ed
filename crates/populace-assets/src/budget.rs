//! The memory that one load may take, and the work that a file of its size may ask for.

use std::cell::Cell;
use std::fmt::Display;

use crate::log::{Checked, Log, Reported};

/// Bytes of arrays that any file may ask for, however small.
const ARRAY_BYTES: u64 = 64 << 20;
/// Bytes of arrays for each byte of a file. Real files share arrays, but not without end.
const ARRAY_BYTES_PER_BYTE: u64 = 64;
/// Poses of one joint that the clips of any file may hold, however small.
const POSES: u64 = 1 << 18;
/// Joint poses for each byte of a file. Clips hold a row of all joints for each key time of any
/// track: a few bytes each of keys and joints multiply to work out of proportion.
const POSES_PER_BYTE: u64 = 2;

/// Remaining memory and work of one load. Estimates past it are refused before any allocation.
pub(crate) struct Budget<'a> {
    log: &'a Log,
    limit: u64,
    used: Cell<u64>,
    arrays_left: Cell<u64>,
    poses_left: Cell<u64>,
    /// Set once the log says that the file asks for work out of proportion to its size.
    is_out_of_proportion: Cell<bool>,
}

impl<'a> Budget<'a> {
    pub(crate) fn new(limit: u64, log: &'a Log) -> Self {
        Self {
            log,
            limit,
            used: Cell::new(0),
            arrays_left: Cell::new(ARRAY_BYTES),
            poses_left: Cell::new(POSES),
            is_out_of_proportion: Cell::new(false),
        }
    }

    /// Bytes that can still be taken.
    pub(crate) fn left(&self) -> u64 {
        self.limit - self.used.get()
    }

    /// Raises the limits of arrays and clips in proportion to `bytes` bytes of a file.
    pub(crate) fn allow_for(&self, bytes: usize) {
        let grow = |cell: &Cell<u64>, by: u64| cell.set(cell.get().saturating_add(by));
        grow(&self.arrays_left, (bytes as u64).saturating_mul(ARRAY_BYTES_PER_BYTE));
        grow(&self.poses_left, (bytes as u64).saturating_mul(POSES_PER_BYTE));
    }

    /// That `bytes` for `what` fit the limit beside what is taken.
    pub(crate) fn check(&self, place: &str, what: impl Display, bytes: u64) -> Checked<()> {
        if bytes <= self.left() {
            return Ok(());
        }
        Err(self.log.problem(
            place,
            format!(
                "needs {} for {what} beside {} taken before; the memory limit is {} \
                 (--memory-limit, `LoadOptions::memory_limit_bytes`)",
                Mebibytes(bytes),
                Mebibytes(self.used.get()),
                Mebibytes(self.limit),
            ),
        ))
    }

    /// Takes `bytes` for `what` until the load ends.
    pub(crate) fn take(&self, place: &str, what: impl Display, bytes: u64) -> Checked<()> {
        self.check(place, what, bytes)?;
        self.used.set(self.used.get() + bytes);
        Ok(())
    }

    /// Takes `bytes` for data of arrays, which must also be in proportion to the file: a small file
    /// that uses one array again and again would take long.
    pub(crate) fn charge(&self, place: &str, bytes: usize) -> Checked<()> {
        let bytes = bytes as u64;
        self.take(place, "its data", bytes)?;
        match self.arrays_left.get().checked_sub(bytes) {
            Some(left) => {
                self.arrays_left.set(left);
                Ok(())
            }
            None => Err(self.out_of_proportion(place, format!("{bytes} bytes of data"))),
        }
    }

    /// Poses of one joint that clips can still hold beside `poses`, which the keys of one need for
    /// `what`.
    pub(crate) fn poses_left(&self, place: &str, what: impl Display, poses: u64) -> Checked<u64> {
        let left = self.poses_left.get().checked_sub(poses);
        left.ok_or_else(|| self.out_of_proportion(place, what))
    }

    fn out_of_proportion(&self, place: &str, what: impl Display) -> Reported {
        if self.is_out_of_proportion.replace(true) {
            return Reported;
        }
        let rule = "that, with what the file asks for before, is out of proportion to its size";
        self.log.problem(place, format!("needs {what}; {rule}"))
    }

    /// Counts poses that a clip holds.
    pub(crate) fn spend_poses(&self, poses: u64) {
        self.poses_left.set(self.poses_left.get().saturating_sub(poses));
    }
}

/// Bytes, shown as MiB and rounded up.
struct Mebibytes(u64);

impl Display for Mebibytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} MiB", self.0.div_ceil(1 << 20))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_can_be_reached_but_not_passed() {
        let log = Log::default();
        let budget = Budget::new(3 << 20, &log);
        budget.take("a", "this", 2 << 20).unwrap();
        assert!(budget.check("b", "that", (1 << 20) + 1).is_err());
        budget.take("c", "that", 1 << 20).unwrap();
        assert_eq!(budget.left(), 0);
        assert!(budget.take("d", "more", u64::MAX).is_err());
        let problems = log.finish().unwrap_err();
        assert_eq!(
            problems[0].to_string(),
            "b: needs 2 MiB for that beside 2 MiB taken before; the memory limit is 3 MiB \
             (--memory-limit, `LoadOptions::memory_limit_bytes`)"
        );
    }

    #[test]
    fn arrays_stay_in_proportion_to_the_file() {
        let log = Log::default();
        let budget = Budget::new(u64::MAX, &log);
        budget.allow_for(10);
        budget.charge("a", (64 << 20) + 640).unwrap();
        assert!(budget.charge("b", 1).is_err());
        assert!(log.finish().unwrap_err()[0].what.contains("out of proportion to its size"));
    }
}
