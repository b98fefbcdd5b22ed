//! Doubts about a plan that breaks no rule: footways with more people than find room.

use crate::plan::{BehaviourPlan, FootwayPlan, ScenePlan};

/// People on a square metre from which on nobody can walk.
const MOST_PER_M2: f32 = 5.0;

impl ScenePlan {
    /// Returns what looks wrong in a plan that is not refused, and how to mend it: each footway
    /// with more than 5 people on a square metre, of whom not all have room. Drivers of vehicles in
    /// lanes are not counted.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let mut people = vec![0.0_f32; self.footways.len()];
        let mut undriven: usize = self.lanes.iter().map(|lane| lane.vehicles).sum();
        for crowd in &self.crowds {
            let BehaviourPlan::Stroll(stroll) = &crowd.does else { continue };
            let drivers = undriven.min(crowd.count);
            undriven -= drivers;
            let own = |nth: &usize| {
                let name = &self.footways[*nth].name;
                stroll.footways.is_empty() || stroll.footways.contains(name)
            };
            let own: Vec<usize> = (0..people.len()).filter(own).collect();
            let all_m: f32 = own.iter().map(|nth| length_m(&self.footways[*nth])).sum();
            for nth in own {
                // They begin evenly along all their footways.
                let share = length_m(&self.footways[nth]) / all_m;
                people[nth] += (crowd.count - drivers) as f32 * share;
            }
        }
        let all = self.footways.iter().zip(people);
        all.filter_map(|(footway, people)| crowded(footway, people)).collect()
    }
}

/// Says that a footway has too many people.
fn crowded(footway: &FootwayPlan, people: f32) -> Option<String> {
    let FootwayPlan { name, width_m, .. } = footway;
    let length_m = length_m(footway);
    let density = people / (length_m * width_m);
    (density > MOST_PER_M2).then(|| {
        format!(
            "the footway \"{name}\", {length_m:.1} m long and {width_m:.1} m wide, has \
             {people:.0} people, {density:.0} on a square metre; above {MOST_PER_M2} they stand \
             within each other: lower `count`, or make the footway longer or wider"
        )
    })
}

/// Returns the length of the middle line of a footway in metres.
fn length_m(footway: &FootwayPlan) -> f32 {
    let points = footway.points.windows(2);
    points.map(|pair| glam::Vec2::from(pair[0]).distance(pair[1].into())).sum()
}
