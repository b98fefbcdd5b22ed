//! Nearest members on the ground, by a k-d tree.

use std::cmp::Ordering;
use std::ops::Range;

/// Returns the numbers of the `count` nearest other members of each member, nearest first. Of equally
/// near ones the lower number comes first. Members whose position is not finite are near to nobody.
pub(crate) fn nearest(members: &[(usize, [f32; 3])], count: usize) -> Vec<Vec<usize>> {
    let places: Vec<[f64; 2]> =
        members.iter().map(|(_, [x, _, z])| [f64::from(*x), f64::from(*z)]).collect();
    let is_known = |member: &usize| places[*member].iter().all(|along| along.is_finite());
    let mut order: Vec<usize> = (0..places.len()).filter(is_known).collect();
    split(&places, &mut order, 0);
    let mut lowest = order.clone();
    note_lowest(&order, &mut lowest, 0..order.len());
    let tree = Tree { places: &places, order: &order, lowest: &lowest };
    let around = |member: usize| {
        let mut found = Found { wanted: count, nearest: Vec::with_capacity(count + 1) };
        if is_known(&member) {
            tree.search(member, (0..order.len(), 0), 0.0, &mut found);
        }
        found.nearest.into_iter().map(|(_, other)| other).collect()
    };
    (0..places.len()).map(around).collect()
}

/// Sorts members into a tree: the middle one splits a range along an axis, and those before and after
/// it are split along the other one.
fn split(places: &[[f64; 2]], order: &mut [usize], axis: usize) {
    if order.len() < 2 {
        return;
    }
    let along =
        |a: &usize, b: &usize| places[*a][axis].total_cmp(&places[*b][axis]).then_with(|| a.cmp(b));
    let (before, _, after) = order.select_nth_unstable_by(order.len() / 2, along);
    split(places, before, 1 - axis);
    split(places, after, 1 - axis);
}

/// Notes the lowest number of each range at its middle, and returns that of the whole range.
fn note_lowest(order: &[usize], lowest: &mut [usize], range: Range<usize>) -> usize {
    if range.is_empty() {
        return usize::MAX;
    }
    let middle = middle_of(&range);
    let before = note_lowest(order, lowest, range.start..middle);
    let after = note_lowest(order, lowest, middle + 1..range.end);
    lowest[middle] = order[middle].min(before).min(after);
    lowest[middle]
}

fn middle_of(range: &Range<usize>) -> usize {
    range.start + range.len() / 2
}

/// The nearest members that are known, with the squares of their distances, in order.
struct Found {
    wanted: usize,
    nearest: Vec<(f64, usize)>,
}

impl Found {
    /// Returns whether a member at this squared distance would be among the nearest.
    fn wants(&self, squared: f64, member: usize) -> bool {
        let is_before = |worst: &(f64, usize)| order_of(&(squared, member), worst).is_lt();
        self.nearest.len() < self.wanted || self.nearest.last().is_some_and(is_before)
    }

    fn add(&mut self, squared: f64, member: usize) {
        let at = self.nearest.partition_point(|of| order_of(of, &(squared, member)).is_lt());
        self.nearest.insert(at, (squared, member));
        self.nearest.truncate(self.wanted);
    }
}

fn order_of(a: &(f64, usize), b: &(f64, usize)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// Members in the order of [`split`].
struct Tree<'a> {
    places: &'a [[f64; 2]],
    order: &'a [usize],
    /// The lowest number of a range, at its middle. Of many members at one place, only the first
    /// are searched.
    lowest: &'a [usize],
}

impl Tree<'_> {
    /// Searches a range that is split along an axis, and whose members are at least `squared` away.
    fn search(
        &self,
        member: usize,
        (range, axis): (Range<usize>, usize),
        squared: f64,
        found: &mut Found,
    ) {
        let middle = middle_of(&range);
        if range.is_empty() || !found.wants(squared, self.lowest[middle]) {
            return;
        }
        let other = self.order[middle];
        let [dx, dz] = [0, 1].map(|axis| self.places[other][axis] - self.places[member][axis]);
        let between = dx * dx + dz * dz;
        if other != member && found.wants(between, other) {
            found.add(between, other);
        }
        let across = [dx, dz][axis];
        let (before, after) = (range.start..middle, middle + 1..range.end);
        let [near, far] = if across >= 0.0 { [before, after] } else { [after, before] };
        self.search(member, (near, 1 - axis), squared, found);
        self.search(member, (far, 1 - axis), squared.max(across * across), found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_the_members_that_a_search_of_all_finds() {
        let mut random = fastrand::Rng::with_seed(3);
        for (count, width) in [(1, 1.0), (2, 1.0), (15, 3.0), (300, 40.0), (300, 0.0)] {
            let at = |random: &mut fastrand::Rng| random.f32() * width;
            let members: Vec<_> =
                (0..count).map(|_| (0, [at(&mut random), 0.0, 5.0 * at(&mut random)])).collect();
            for (member, found) in nearest(&members, 20).into_iter().enumerate() {
                let squared = |other: usize| {
                    let ([x, _, z], [ox, _, oz]) = (members[member].1, members[other].1);
                    let [dx, dz] = [x - ox, z - oz].map(f64::from);
                    dx * dx + dz * dz
                };
                let mut expected: Vec<usize> =
                    (0..count).filter(|other| *other != member).collect();
                expected.sort_by(|a, b| squared(*a).total_cmp(&squared(*b)).then(a.cmp(b)));
                expected.truncate(20);
                assert_eq!(found, expected, "{count} {width}");
            }
        }
    }

    /// A search that looks at all members of a place would take minutes.
    #[test]
    fn members_at_one_place_are_found_as_fast_as_others() {
        let members = vec![(0, [3.0, 0.0, -2.0]); 50_000];
        let found = nearest(&members, 20);
        assert_eq!(found[5], [0, 1, 2, 3, 4].into_iter().chain(6..21).collect::<Vec<_>>());
        assert_eq!(found[49_999], (0..20).collect::<Vec<_>>());
    }

    #[test]
    fn positions_that_are_not_finite_are_near_to_nobody() {
        let members = [[0.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]].map(|at| (0, at));
        let found = nearest(&members, 20);
        assert_eq!(found, [vec![2], vec![], vec![0]]);
    }
}
