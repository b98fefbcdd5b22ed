//! Where people stand, and how others see them who walk.

use glam::Vec2;
use populace::Crowd;
use populace_locomotion::avoidance::Bystander;

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

/// Returns everybody of a plan who stands, as others see them who walk. `people` has a list for each
/// crowd of the plan.
pub(super) fn bystanders(
    crowd: &Crowd,
    plan: &ScenePlan,
    people: &[Vec<CastPerson>],
) -> Result<Vec<Bystander>, Error> {
    let mut all = Vec::new();
    for (of, people) in plan.crowds.iter().zip(people) {
        let BehaviourPlan::Stand(stand) = &of.does else { continue };
        for (person, at) in people.iter().zip(places(stand, people.len())) {
            if at.abs().max_element() > FARTHEST_M {
                continue;
            }
            let height_m = crowd.character(person.character)?.asset().height_m() * person.scale;
            let radius_m = (RADIUS * height_m).clamp(RADII_M[0], RADII_M[1]);
            all.push(Bystander { position: at.to_array(), radius_m });
        }
    }
    Ok(all)
}

/// Returns where people stand.
pub(super) fn places(plan: &StandPlan, count: usize) -> impl Iterator<Item = Vec2> {
    let ahead = direction(plan.facing_deg);
    let left = Vec2::new(ahead.y, -ahead.x);
    // Fewer than fill a row stand around its middle.
    let row = plan.row.min(count).max(1);
    (0..count).map(move |nth| {
        let aside = ((nth % row) as f32 - 0.5 * (row - 1) as f32) * plan.spacing_m;
        let behind = (nth / row) as f32 * plan.spacing_m;
        Vec2::from(plan.at) + left * aside - ahead * behind
    })
}
