//! Linear programs over velocities: the nearest one that all half-planes allow, or else the one
//! that lacks least. After sections 5.3 and 5.4 of van den Berg, Guy, Lin and Manocha, "Reciprocal
//! n-body collision avoidance", 2011.

use glam::Vec2;

use super::geometry::root;

/// The most half-planes of one program.
pub(crate) const MOST_PLANES: usize = 40;
/// Differences of velocities below this, in metres per second, are rounding.
const ROUNDING: f32 = 1e-5;

/// The velocities with `normal · velocity >= offset`. The normal has length 1.
///
/// Where not all can be met, the one that lacks most times its weight lacks least.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HalfPlane {
    pub(crate) normal: Vec2,
    pub(crate) offset: f32,
    pub(crate) weight: f32,
}

impl HalfPlane {
    /// Returns how far a velocity is outside, in metres per second; negative inside.
    pub(crate) fn lack(&self, velocity: Vec2) -> f32 {
        self.offset - self.normal.dot(velocity)
    }
}

/// The measure of the best velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Goal {
    /// The one nearest to this velocity.
    Near(Vec2),
    /// The one that goes farthest in this direction of length 1.
    Along(Vec2),
}

/// A program without a solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Infeasible {
    /// Index of the first half-plane that those before it exclude.
    pub(crate) at: usize,
    /// The best velocity that those before it allow.
    pub(crate) velocity: Vec2,
}

/// Returns the best velocity, at most `most` fast, in all half-planes.
pub(crate) fn solve(planes: &[HalfPlane], most: f32, goal: Goal) -> Result<Vec2, Infeasible> {
    let mut velocity = match goal {
        Goal::Near(wished) => wished.clamp_length_max(most),
        Goal::Along(direction) => direction * most,
    };
    for (at, plane) in planes.iter().enumerate() {
        if plane.lack(velocity) > ROUNDING {
            velocity = best_on_edge(&planes[..at], plane, most, goal)
                .ok_or(Infeasible { at, velocity })?;
        }
    }
    Ok(velocity)
}

/// Returns the best velocity on the edge of a half-plane that lies in all others; `None` if there
/// is none.
fn best_on_edge(others: &[HalfPlane], edge: &HalfPlane, most: f32, goal: Goal) -> Option<Vec2> {
    let reach = most * most - edge.offset * edge.offset;
    if reach < 0.0 {
        return None;
    }
    let along = edge.normal.perp();
    let start = edge.normal * edge.offset;
    let (mut from, mut until) = (-root(reach), root(reach));
    for other in others {
        let rate = other.normal.dot(along);
        let lack = other.lack(start);
        if rate.abs() < ROUNDING {
            if lack > ROUNDING {
                return None;
            }
        } else if rate > 0.0 {
            from = from.max(lack / rate);
        } else {
            until = until.min(lack / rate);
        }
    }
    if from > until + ROUNDING {
        return None;
    }
    let best = match goal {
        Goal::Near(wished) => along.dot(wished).max(from).min(until),
        Goal::Along(direction) if along.dot(direction) > 0.0 => until,
        Goal::Along(_) => from,
    };
    Some(start + along * best)
}

/// Returns the velocity for which the half-plane that lacks most lacks least. The first `firm` ones
/// are kept. It is called with the failure of [`solve`]; half-planes before that one are met there.
pub(crate) fn relax(planes: &[HalfPlane], firm: usize, most: f32, failure: Infeasible) -> Vec2 {
    let firm = firm.min(failure.at);
    let mut velocity = failure.velocity;
    let mut worst = 0.0;
    let mut equal = [HalfPlane::default(); MOST_PLANES];
    equal[..firm].copy_from_slice(&planes[..firm]);
    for (at, plane) in planes.iter().enumerate().skip(failure.at) {
        if plane.lack(velocity) * plane.weight <= worst + ROUNDING {
            continue;
        }
        let mut count = firm;
        // Velocities at which an earlier half-plane lacks no more than this one.
        for earlier in &planes[firm..at] {
            let across = earlier.normal * earlier.weight - plane.normal * plane.weight;
            let length = across.length();
            // One that looks the same way lacks less everywhere: it is met, and this one is not.
            if length > ROUNDING {
                let offset = earlier.offset * earlier.weight - plane.offset * plane.weight;
                equal[count] =
                    HalfPlane { normal: across / length, offset: offset / length, weight: 1.0 };
                count += 1;
            }
        }
        // There is always a solution, but for rounding; then the last velocity is as good.
        if let Ok(better) = solve(&equal[..count], most, Goal::Along(plane.normal)) {
            velocity = better;
        }
        worst = (plane.lack(velocity) * plane.weight).max(worst);
    }
    velocity
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(normal: Vec2, offset: f32) -> HalfPlane {
        HalfPlane { normal: normal.normalize(), offset, weight: 1.0 }
    }

    /// Compares with a search over a fine lattice of velocities.
    fn lattice(best: impl Fn(Vec2) -> f32) -> f32 {
        let all = (-200..=200).flat_map(|x| (-200..=200).map(move |y| (x as f32, y as f32)));
        let fast = all.map(|(x, y)| Vec2::new(x, y) * 0.01).filter(|v| v.length() <= 2.0);
        fast.map(best).fold(f32::INFINITY, f32::min)
    }

    fn random_planes(random: &mut fastrand::Rng, count: usize) -> Vec<HalfPlane> {
        let mut number = || random.f32() * 2.0 - 1.0;
        (0..count).map(|_| plane(Vec2::new(number(), number()), number() * 0.8)).collect()
    }

    #[test]
    fn solutions_are_as_near_as_those_of_a_search() {
        let mut random = fastrand::Rng::with_seed(1);
        let (mut solved, mut refused) = (0, 0);
        for _ in 0..300 {
            let planes = random_planes(&mut random, 5);
            let wished = Vec2::new(random.f32() * 3.0 - 1.5, random.f32() - 0.5);
            let meets = |v: Vec2, slack: f32| planes.iter().all(|plane| plane.lack(v) <= slack);
            let searched =
                lattice(|v| if meets(v, 0.0) { v.distance(wished) } else { f32::INFINITY });
            if let Ok(found) = solve(&planes, 2.0, Goal::Near(wished)) {
                assert!(meets(found, 1e-4), "{planes:?} {found}");
                assert!(found.distance(wished) <= searched + 1e-4);
                solved += 1;
            } else {
                assert_eq!(searched, f32::INFINITY, "{planes:?}");
                refused += 1;
            }
        }
        assert!(solved > 50 && refused > 50, "{solved} {refused}");
    }

    #[test]
    fn relaxed_solutions_lack_no_more_than_those_of_a_search() {
        let mut random = fastrand::Rng::with_seed(2);
        let mut relaxed = 0;
        for _ in 0..300 {
            let mut planes = random_planes(&mut random, 6);
            planes[0].offset = -planes[0].offset.abs();
            planes.iter_mut().for_each(|plane| plane.weight = 0.5 + random.f32());
            let Err(failure) = solve(&planes, 2.0, Goal::Near(Vec2::X)) else { continue };
            let found = relax(&planes, 1, 2.0, failure);
            let lack = |v: Vec2| {
                let lacks = planes[1..].iter().map(|plane| plane.weight * plane.lack(v));
                lacks.fold(f32::NEG_INFINITY, f32::max)
            };
            let searched =
                lattice(|v| if planes[0].lack(v) <= 0.0 { lack(v) } else { f32::INFINITY });
            assert!(planes[0].lack(found) <= 1e-4, "the firm one is kept");
            assert!(lack(found) <= searched + 1e-3, "{} {searched}", lack(found));
            relaxed += 1;
        }
        assert!(relaxed > 50, "{relaxed}");
    }
}
