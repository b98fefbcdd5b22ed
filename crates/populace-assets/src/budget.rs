//! Limits on the memory of one load and on its work relative to the size of the file.

use std::cell::Cell;
use std::fmt::Display;

use crate::log::{Checked, Log, Reported};

/// Array bytes that every file may use, regardless of its size.
const ARRAY_BYTES: u64 = 64 << 20;
/// Additional array bytes per byte of the file. Real files share arrays between users, but only to
/// this extent.
const ARRAY_BYTES_PER_BYTE: u64 = 64;
/// Joint poses that the clips of every file may hold, regardless of its size.
const POSES: u64 = 1 << 18;
/// Additional joint poses per byte of the file. A clip has a row of all joints for each key time of
/// any track, so the work grows with the product of keys and joints, each of which takes few bytes.
const POSES_PER_BYTE: u64 = 2;

/// Remaining memory and work of one load. Estimates that exceed it are refused before the
/// allocation.
pub(crate) struct Budget<'a> {
    log: &'a Log,
    limit: u64,
    used: Cell<u64>,
    arrays_left: Cell<u64>,
    poses_left: Cell<u64>,
    /// Whether the log already has a problem about disproportionate work. It is reported once.
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

    /// Returns the number of bytes that are still available.
    pub(crate) fn left(&self) -> u64 {
        self.limit - self.used.get()
    }

    /// Raises the limits of arrays and clips for `bytes` bytes of file content.
    pub(crate) fn raise_limits_for(&self, bytes: usize) {
        let grow = |cell: &Cell<u64>, by: u64| cell.set(cell.get().saturating_add(by));
        grow(&self.arrays_left, (bytes as u64).saturating_mul(ARRAY_BYTES_PER_BYTE));
        grow(&self.poses_left, (bytes as u64).saturating_mul(POSES_PER_BYTE));
    }

    /// Checks that `bytes` for `what` fit into the remaining memory, without reserving them.
    pub(crate) fn check(&self, place: &str, what: impl Display, bytes: u64) -> Checked<()> {
        if bytes <= self.left() {
            return Ok(());
        }
        Err(self.log.problem(
            place,
            format!(
                "needs {} for {what} in addition to {} already in use; the memory limit is {}; \
                 raise it with --memory-limit or `LoadOptions::memory_limit_bytes`",
                Mebibytes(bytes),
                Mebibytes(self.used.get()),
                Mebibytes(self.limit),
            ),
        ))
    }

    /// Reserves `bytes` for `what` until the load ends.
    pub(crate) fn take(&self, place: &str, what: impl Display, bytes: u64) -> Checked<()> {
        self.check(place, what, bytes)?;
        self.used.set(self.used.get() + bytes);
        Ok(())
    }

    /// Reserves `bytes` of array data. They also count towards the limit that is proportional to
    /// the file size. Otherwise a small file could use one array many times and take long to load.
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

    /// Returns how many joint poses clips may still hold after `poses`, which a clip needs at least
    /// for `what`. Fails if even `poses` exceed the limit.
    pub(crate) fn poses_left(&self, place: &str, what: impl Display, poses: u64) -> Checked<u64> {
        let left = self.poses_left.get().checked_sub(poses);
        left.ok_or_else(|| self.out_of_proportion(place, what))
    }

    fn out_of_proportion(&self, place: &str, what: impl Display) -> Reported {
        if self.is_out_of_proportion.replace(true) {
            return Reported;
        }
        let rule = "together with earlier data, that is out of proportion to the size of the file";
        self.log.problem(place, format!("needs {what}; {rule}"))
    }

    /// Subtracts the joint poses of a finished clip from the remaining ones.
    pub(crate) fn spend_poses(&self, poses: u64) {
        self.poses_left.set(self.poses_left.get().saturating_sub(poses));
    }
}

/// A number of bytes that displays as MiB, rounded up.
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
    fn memory_limit_can_be_reached_but_not_exceeded() {
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
            "b: needs 2 MiB for that in addition to 2 MiB already in use; the memory limit is 3 \
             MiB; raise it with --memory-limit or `LoadOptions::memory_limit_bytes`"
        );
    }

    #[test]
    fn array_bytes_are_limited_by_file_size() {
        let log = Log::default();
        let budget = Budget::new(u64::MAX, &log);
        budget.raise_limits_for(10);
        budget.charge("a", (64 << 20) + 640).unwrap();
        assert!(budget.charge("b", 1).is_err());
        assert!(log.finish().unwrap_err()[0].what.contains("out of proportion to the size"));
    }
}
