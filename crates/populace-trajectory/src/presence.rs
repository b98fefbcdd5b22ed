//! How many are there at the same time.

use std::cmp::Ordering;

/// Returns the times at which the number of those who are there changes, in order, and that number
/// from then on. Each is there from the first of its times to the last, both included: of two, one of
/// which comes at the last time of the other, both are there. Times that are not in order are left
/// out.
#[must_use]
pub fn counts_present(spans: impl IntoIterator<Item = [f64; 2]>) -> Vec<(f64, usize)> {
    // In this order at equal times.
    let (comes, goes) = (0_u8, 1_u8);
    let spans = spans.into_iter().filter(|[from, until]| from <= until);
    let mut changes: Vec<(f64, u8)> =
        spans.flat_map(|[from, until]| [(from, comes), (until, goes)]).collect();
    changes.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    let mut count = 0;
    let mut after = |(secs, change)| {
        count = if change == comes { count + 1 } else { count - 1 };
        (secs, count)
    };
    changes.into_iter().map(&mut after).collect()
}

/// Returns the most that are there at the same time, as [`counts_present`] counts them.
#[must_use]
pub fn most_present(spans: impl IntoIterator<Item = [f64; 2]>) -> usize {
    counts_present(spans).into_iter().map(|(_, count)| count).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_are_there_when_one_comes_as_another_goes() {
        let spans = [[2.0, 3.0], [0.0, 1.0], [1.0, 1.5]];
        let counts = [(0.0, 1), (1.0, 2), (1.0, 1), (1.5, 0), (2.0, 1), (3.0, 0)];
        assert_eq!(counts_present(spans), counts);
        assert_eq!((most_present(spans), most_present([])), (2, 0));
    }

    #[test]
    fn one_is_there_at_a_single_time_and_none_when_times_are_not_in_order() {
        assert_eq!(counts_present([[1.0, 1.0]]), [(1.0, 1), (1.0, 0)]);
        assert_eq!(counts_present([[0.0, -0.0]]), [(0.0, 1), (0.0, 0)]);
        assert_eq!(counts_present([[2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::NAN]]), []);
    }
}
