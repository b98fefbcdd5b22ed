//! How walkers move: towards their goals, around others, and over slopes.

use glam::Vec2;
use populace::Ground;
use rayon::prelude::*;

use super::goals::Manner;
use super::{FEWEST_PER_THREAD, Walkers};
use crate::Error;
use crate::avoidance::{Agents, LARGEST_M, Stagger};
use crate::walker::{AHEAD_M, Wish, ground_below};

/// How much faster than it prefers a walker may go to evade others.
const HASTE: f32 = 1.3;
/// The highest speed, in metres per second, at which a walker goes on that was led.
const MOST_LED_SPEED: f32 = 100.0;
/// How much a slope takes of the speed, up and down: people climb stairs of a slope of 0.5 at 0.61
/// metres per second and descend them at 0.69, horizontally (U. Weidmann, "Transporttechnik der
/// Fussgaenger", ETH Zurich 1993). Gentler slopes are between those and level ground.
const SLOPES: [f32; 2] = [2.4, 1.9];

impl Walkers {
    /// Finds the velocities that walkers would take if they were alone.
    pub(super) fn prefer(&mut self, secs: f32) {
        let (settings, ground, avoids) = (&self.settings, &self.ground, self.avoidance.is_some());
        let walkers = self.walkers.par_iter_mut().zip(&mut self.velocities).zip(&mut self.orders);
        let wishes = self.preferred.par_iter_mut().zip(&mut self.most_speeds);
        walkers.zip(wishes).with_min_len(FEWEST_PER_THREAD).for_each(
            |(((walker, present), orders), (preferred, most))| {
                if walker.velocity.length_squared() > MOST_LED_SPEED * MOST_LED_SPEED {
                    walker.velocity = walker.velocity.clamp_length_max(MOST_LED_SPEED);
                    *present = walker.velocity.to_array();
                }
                let velocity = orders.velocity(walker.position, settings.deceleration, secs);
                let share = ground
                    .as_ref()
                    .map_or(1.0, |ground| slope_share(ground, walker.position, velocity));
                *preferred = (velocity * share).to_array();
                if avoids {
                    // A walker that is faster already need not brake at once.
                    let most_speed = HASTE * share * velocity.length();
                    *most = most_speed.max(walker.velocity.length()).min(MOST_LED_SPEED);
                }
            },
        );
    }

    /// Steers a share of the walkers around others.
    pub(super) fn steer(&mut self, share: Stagger) -> Result<(), Error> {
        let Some(avoidance) = &mut self.avoidance else {
            self.evades.fill(false);
            return Ok(());
        };
        let agents = Agents {
            positions: &self.positions,
            velocities: &self.velocities,
            preferred: &self.preferred,
            radii_m: &self.radii_m,
            most_speeds: &self.most_speeds,
            groups: &self.groups,
        };
        avoidance.steer(&agents, share, &mut self.steered)?;
        for index in (share.nth..self.members.len()).step_by(share.count) {
            self.evades[index] = self.orders[index].manner == Manner::Heeds
                && self.steered[index] != self.preferred[index];
        }
        Ok(())
    }

    /// Moves all walkers.
    pub(super) fn advance(&mut self, secs: f32) {
        let Self { settings, gaits, avoidance, .. } = self;
        let ground = self.ground.as_ref();
        let places = self.positions.par_iter_mut().zip(&mut self.velocities);
        let orders = self.orders.par_iter().zip(&self.radii_m).zip(&self.phases);
        let wishes = self.preferred.par_iter().zip(&self.steered).zip(&self.evades).zip(orders);
        let shown = self.placements.par_iter_mut().zip(&mut self.strides);
        let walkers = self.walkers.par_iter_mut().zip(shown).zip(places);
        walkers.zip(wishes).with_min_len(FEWEST_PER_THREAD).for_each(
            |(
                ((walker, (placement, stride)), (position, velocity)),
                (steers, ((orders, radius), phase)),
            )| {
                if orders.manner == Manner::Rests {
                    return;
                }
                let ((preferred, steered), evades) = steers;
                // Who need not evade follows its goal in each update, as without avoidance.
                let wanted = Vec2::from(if *evades { *steered } else { *preferred });
                let wish = Wish { velocity: wanted, facing_rad: orders.facing_rad };
                let wanted = walker.advance(wish, settings, secs);
                let at = avoidance.as_ref().map_or(wanted, |avoidance| {
                    let from = walker.position.to_array();
                    avoidance.slide(from, wanted.to_array(), *radius).into()
                });
                let at = at.clamp(Vec2::splat(-LARGEST_M), Vec2::splat(LARGEST_M));
                walker.arrive(at, wanted, ground, secs);
                walker.step(&gaits[orders.gaits as usize], secs, ground.zip(*phase));
                (placement.1, stride.1) = (walker.placement(), walker.stride);
                (*position, *velocity) = (walker.position.to_array(), walker.velocity.to_array());
            },
        );
    }
}

/// Returns the share of a speed that the slope of the ground leaves.
fn slope_share(ground: &Ground, at: Vec2, velocity: Vec2) -> f32 {
    let Some(direction) = velocity.try_normalize() else { return 1.0 };
    let at = at + direction * AHEAD_M;
    let ahead = ground_below(ground, at + direction * 0.5, direction);
    let slope = 2.0 * (ahead - ground_below(ground, at, direction));
    1.0 / (1.0 + if slope > 0.0 { SLOPES[0] * slope } else { -SLOPES[1] * slope })
}
