//! Places that one person at a time takes: before windows, at walls, and on seats.

use std::ops::Index;

use glam::Vec2;

use crate::plan::{LeanPlan, SeatPlan, SpotPlan};

/// A place of a plan.
pub(crate) trait PlacePlan {
    /// Returns where it is, seen from above.
    fn at(&self) -> Vec2;

    /// Returns the heading of somebody there in degrees.
    fn facing_deg(&self) -> f32;
}

impl PlacePlan for SpotPlan {
    fn at(&self) -> Vec2 {
        self.at.into()
    }

    fn facing_deg(&self) -> f32 {
        self.facing_deg
    }
}

impl PlacePlan for LeanPlan {
    fn at(&self) -> Vec2 {
        self.at.into()
    }

    fn facing_deg(&self) -> f32 {
        self.facing_deg
    }
}

impl PlacePlan for SeatPlan {
    fn at(&self) -> Vec2 {
        Vec2::new(self.at[0], self.at[2])
    }

    fn facing_deg(&self) -> f32 {
        self.facing_deg
    }
}

/// Places of one kind.
#[derive(Clone)]
pub(crate) struct Places<P> {
    plans: Vec<P>,
    taken: Vec<bool>,
}

impl<P: PlacePlan> Places<P> {
    /// Returns free places.
    pub(crate) fn new(plans: Vec<P>) -> Self {
        Self { taken: vec![false; plans.len()], plans }
    }

    pub(crate) fn len(&self) -> usize {
        self.plans.len()
    }

    pub(crate) fn is_free(&self, place: usize) -> bool {
        !self.taken[place]
    }

    pub(crate) fn take(&mut self, place: usize) {
        self.taken[place] = true;
    }

    pub(crate) fn leave(&mut self, place: usize) {
        self.taken[place] = false;
    }

    /// Returns the heading of somebody at a place in radians.
    pub(crate) fn yaw_rad(&self, place: usize) -> f32 {
        self.plans[place].facing_deg().to_radians()
    }

    /// Returns the free place that is nearest to a point, of those whose own points are `eligible`.
    pub(crate) fn nearest_free(
        &self,
        from: Vec2,
        eligible: impl Fn(Vec2) -> bool,
    ) -> Option<usize> {
        let free = (0..self.len()).filter(|place| self.is_free(*place));
        let eligible = free.filter(|place| eligible(self.plans[*place].at()));
        let distance = |place: &usize| self.plans[*place].at().distance_squared(from);
        eligible.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

impl<P> Index<usize> for Places<P> {
    type Output = P;

    fn index(&self, place: usize) -> &P {
        &self.plans[place]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_place_is_one_that_is_free_and_eligible() {
        let lean = |x: f32| LeanPlan { at: [x, 0.0], facing_deg: 90.0 };
        let mut places = Places::new([4.0, 1.0, 2.0, -3.0].map(lean).to_vec());
        let nearest = |places: &Places<LeanPlan>| places.nearest_free(Vec2::ZERO, |at| at.x > 0.0);
        assert_eq!(nearest(&places), Some(1));
        places.take(1);
        places.take(2);
        assert_eq!((nearest(&places), places.is_free(1)), (Some(0), false));
        places.take(0);
        assert_eq!(nearest(&places), None);
        places.leave(2);
        assert_eq!(nearest(&places), Some(2));
    }
}
