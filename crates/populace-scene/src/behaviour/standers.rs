//! Where people stand, and how walkers see them.

use glam::Vec2;
use populace::Crowd;
use populace_locomotion::avoidance::Bystander;
use populace_random::Rng;

use super::falls::direction;
use crate::Error;
use crate::plan::{BehaviourPlan, ScenePlan, StandPlan};
use crate::replay::Person as CastPerson;

/// The radius of somebody who stands, in metres per metre of height, as that of walkers.
const RADIUS: f32 = 0.14;
/// The least and the largest radius in metres.
const RADII_M: [f32; 2] = [0.05, 3.0];
/// The farthest coordinate in metres to which walkers come.
const FARTHEST_M: f32 = 1e6;
/// The part of the distance between neighbours by which each stands off its place, at most.
const OFF: f32 = 0.25;
/// The angle in degrees by which each turns off the heading, at most.
const TURNED_DEG: f32 = 15.0;
/// Number that is mixed into the seed, so that places have random numbers of their own.
const PLACES: u64 = 0x5ee9_71e5;

/// Somebody who stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stander {
    pub(super) at: Vec2,
    pub(super) yaw_rad: f32,
    radius_m: f32,
}

impl Stander {
    /// Returns it as walkers see it; `None` where nobody comes.
    fn bystander(&self) -> Option<Bystander> {
        let bystander = Bystander { position: self.at.to_array(), radius_m: self.radius_m };
        (self.at.abs().max_element() <= FARTHEST_M).then_some(bystander)
    }
}

/// Returns the people who stand, in a list for each crowd of the plan. `people` has such lists too.
pub(super) fn of_plan(
    crowd: &Crowd,
    plan: &ScenePlan,
    people: &[Vec<CastPerson>],
) -> Result<Vec<Vec<Stander>>, Error> {
    let mut first = 0;
    let mut all = Vec::new();
    for (of, people) in plan.crowds.iter().zip(people) {
        let BehaviourPlan::Stand(stand) = &of.does else {
            all.push(Vec::new());
            first += people.len() as u64;
            continue;
        };
        let mut radii_m = Vec::with_capacity(people.len());
        for person in people {
            let height_m = crowd.character(person.character)?.asset().height_m() * person.scale;
            radii_m.push((RADIUS * height_m).clamp(RADII_M[0], RADII_M[1]));
        }
        all.push(standers(stand, &radii_m, (plan.seed, first)));
        first += people.len() as u64;
    }
    Ok(all)
}

/// Returns all people who stand, as walkers see them.
pub(super) fn bystanders(standers: &[Vec<Stander>]) -> Vec<Bystander> {
    standers.iter().flatten().filter_map(Stander::bystander).collect()
}

/// Returns where people with some radii stand. `first` is the number of the first person: it
/// chooses the stream of random numbers within `seed`.
fn standers(plan: &StandPlan, radii_m: &[f32], (seed, first): (u64, u64)) -> Vec<Stander> {
    let ahead = direction(plan.facing_deg);
    let left = Vec2::new(ahead.y, -ahead.x);
    // Fewer than fill a row stand around its middle.
    let row = plan.row.min(radii_m.len()).max(1);
    let is_even = plan.even || radii_m.len() == 1;
    // Shoulder to shoulder at the nearest.
    let widest_m = 2.0 * radii_m.iter().copied().fold(0.0, f32::max);
    let off_m = (OFF * plan.spacing_m).min(0.5 * (plan.spacing_m - widest_m)).max(0.0);
    let stander = |(nth, radius_m): (usize, &f32)| {
        let aside = ((nth % row) as f32 - 0.5 * (row - 1) as f32) * plan.spacing_m;
        let behind = (nth / row) as f32 * plan.spacing_m;
        let mut random = Rng::stream(seed ^ PLACES, first + nth as u64);
        let around = Vec2::from_angle(random.between_f32(0.0, std::f32::consts::TAU));
        let (off, turned_deg) = (around * off_m * random.unit(), TURNED_DEG * random.signed());
        let (off, turned_deg) = if is_even { (Vec2::ZERO, 0.0) } else { (off, turned_deg) };
        Stander {
            at: Vec2::from(plan.at) + left * aside - ahead * behind + off,
            yaw_rad: (plan.facing_deg + turned_deg).to_radians(),
            radius_m: *radius_m,
        }
    };
    radii_m.iter().enumerate().map(stander).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADII_M: [f32; 60] = [0.25; 60];

    fn stand(spacing_m: f32) -> StandPlan {
        StandPlan { at: [3.0, -2.0], facing_deg: 40.0, row: 12, spacing_m, ..StandPlan::default() }
    }

    #[test]
    fn people_stand_off_their_rows_and_not_in_each_other() {
        for (spacing_m, off_m) in [(2.0, 0.5), (1.0, 0.25), (0.6, 0.05), (0.4, 0.0)] {
            let plan = stand(spacing_m);
            let even = standers(&StandPlan { even: true, ..plan.clone() }, &RADII_M, (1, 7));
            let loose = standers(&plan, &RADII_M, (1, 7));
            assert_eq!(loose, standers(&plan, &RADII_M, (1, 7)), "equal seeds, equal places");
            let pairs = || even.iter().zip(&loose);
            let farthest = pairs().map(|(a, b)| a.at.distance(b.at)).fold(0.0, f32::max);
            assert!(farthest <= off_m + 1e-5 && farthest >= 0.8 * off_m, "{farthest} of {off_m} m");
            let turned = pairs().map(|(a, b)| (b.yaw_rad - a.yaw_rad).to_degrees());
            let (least, most) = turned.fold((0.0, 0.0), |(a, b), of| (of.min(a), of.max(b)));
            assert!((-15.01..-10.0).contains(&least) && (10.0..15.01).contains(&most));
            for (nth, one) in loose.iter().enumerate() {
                let others = loose[..nth].iter().map(|other| other.at.distance(one.at));
                let nearest = others.fold(f32::MAX, f32::min);
                assert!(nearest >= spacing_m.min(0.5) - 1e-4, "{nearest} m at {spacing_m} m");
            }
        }
        let other = standers(&stand(1.0), &RADII_M, (2, 7));
        assert_ne!(other, standers(&stand(1.0), &RADII_M, (1, 7)), "seeds differ");
    }

    #[test]
    fn one_alone_stands_where_it_is_told() {
        let [alone] = standers(&stand(1.0), &RADII_M[..1], (1, 7))[..] else { panic!("one") };
        assert_eq!((alone.at, alone.yaw_rad), (Vec2::new(3.0, -2.0), 40.0_f32.to_radians()));
    }
}
