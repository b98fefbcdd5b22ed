//! Free runs of a table.

use std::ops::Range;

/// Free runs of a table, in ascending order. No two touch, and none reaches the table's end.
#[derive(Clone, Debug, Default)]
pub(super) struct FreeRuns(Vec<Range<usize>>);

impl FreeRuns {
    /// Takes `count` elements of the shortest run that holds them.
    pub(super) fn take(&mut self, count: usize) -> Option<usize> {
        let fitting = (0..self.0.len()).filter(|at| self.0[*at].len() >= count);
        let at = fitting.min_by_key(|at| self.0[*at].len())?;
        let first = self.0[at].start;
        self.0[at].start += count;
        if self.0[at].is_empty() {
            self.0.remove(at);
        }
        Some(first)
    }

    /// Frees a run of a table of `length` elements. Returns the length up to the last element in
    /// use.
    pub(super) fn release(&mut self, run: Range<usize>, length: usize) -> usize {
        if run.is_empty() {
            return length;
        }
        let at = self.0.partition_point(|free| free.end < run.start);
        let touching = self.0[at..].iter().take_while(|free| free.start <= run.end).count();
        let touched = self.0.drain(at..at + touching);
        let run = touched.fold(run, |all, free| all.start.min(free.start)..all.end.max(free.end));
        if run.end == length {
            return run.start;
        }
        self.0.insert(at, run);
        length
    }
}

#[cfg(test)]
mod tests {
    use super::super::Table;
    use super::*;

    #[test]
    fn free_runs_merge_and_the_shortest_that_fits_is_taken() {
        let mut free = FreeRuns::default();
        assert_eq!(free.take(1), None);
        for run in [10..20, 40..45, 60..62] {
            assert_eq!(free.release(run, 100), 100);
        }
        assert_eq!(free.take(4), Some(40), "the shortest that holds four");
        assert_eq!(free.take(2), Some(60));
        assert_eq!(free.release(20..44, 100), 100, "between two free runs");
        assert_eq!((free.0.len(), free.0[0].clone()), (1, 10..45));
        assert_eq!(free.take(35), Some(10));
        assert!(free.0.is_empty());
        free.release(50..80, 100);
        assert_eq!(free.release(80..100, 100), 50, "the end moves below all that is free");
        assert!(free.0.is_empty());
    }

    #[test]
    fn runs_never_overlap_and_the_table_ends_with_the_last() {
        let mut table = Table::<u32>::new("numbers");
        let mut taken = Vec::<Range<usize>>::new();
        let mut rng = fastrand::Rng::with_seed(3);
        for step in 0..20_000_u32 {
            let adds = rng.usize(..10) < if step / 500 % 2 == 0 { 6 } else { 4 };
            if adds || taken.is_empty() {
                let values = vec![step; 1 + rng.usize(..9)];
                let first = table.add(&values).unwrap() as usize;
                taken.push(first..first + values.len());
            } else {
                let run = taken.swap_remove(rng.usize(..taken.len()));
                let own = table.as_slice()[run.start];
                assert!(table.as_slice()[run.clone()].iter().all(|value| *value == own));
                table.release(run);
            }
            assert_eq!(table.len(), taken.iter().map(|run| run.end).max().unwrap_or(0));
            if step % 7 == 0 {
                table.mark_clean();
            }
        }
    }
}
