//! Vehicles: they follow each other in lanes, stop for people and lights, park and set off.

use std::f32::consts::FRAC_PI_2;

use glam::Vec2;
use populace::{ClipPlayback, Crowd, MemberId, Placement, PlaybackId};

use crate::Error;
use crate::plan::{BayPlan, LanePlan};
use crate::stage::VehicleModel;

mod bays;
mod following;
mod lane;
#[cfg(test)]
mod tests;

use bays::Bay;
pub(crate) use lane::Lane;

/// Comfortable loss of speed, in metres per second squared.
const LOSS: f32 = 2.4;
/// Distance between two vehicles at rest, in metres.
const JAM_M: f32 = 1.6;
/// Distance ahead of a bay in which a vehicle changes over to it, and past it in which it is back
/// in its lane, in metres.
pub(crate) const SWERVE_M: f32 = 9.0;

/// The activity of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drive {
    /// It drives on.
    Cruises,
    /// It drives to a bay and parks in it.
    Parks { bay: usize },
    /// It stands in a bay since a time in seconds.
    Stands { bay: usize, since: f64 },
    /// It leaves a bay.
    SetsOff { bay: usize },
}

/// A vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Vehicle {
    pub(crate) member: MemberId,
    pub(crate) model: usize,
    pub(crate) lane: usize,
    /// Length along its lane to its middle, in metres.
    pub(crate) along_m: f32,
    pub(crate) speed: f32,
    pub(crate) drive: Drive,
    /// The number of the person who drives it.
    pub(crate) driver: Option<u32>,
    /// The number of the person who is about to get in.
    pub(crate) claimed: Option<u32>,
    /// True while its door is open.
    pub(crate) is_open: bool,
    /// What turns its wheels, and the speed that it was told, in metres per second.
    rolling: Option<(PlaybackId, f32)>,
    /// Its share of the lane's speed.
    pace: f32,
    placement: Placement,
}

/// Something that stops vehicles of a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    pub(crate) lane: usize,
    /// Where the front of a vehicle stops, as a length along the lane in metres.
    pub(crate) along_m: f32,
    /// How far past it the front of a vehicle is that drives on, in metres.
    pub(crate) past_m: f32,
    /// True for somebody who is about to step onto the road: vehicles that cannot brake in comfort
    /// go on.
    pub(crate) is_polite: bool,
}

/// All vehicles of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Traffic {
    pub(crate) models: Vec<VehicleModel>,
    pub(crate) lanes: Vec<Lane>,
    pub(crate) bays: Vec<Bay>,
    pub(crate) vehicles: Vec<Vehicle>,
    /// Vehicles on the road by lane and length along it.
    order: Vec<usize>,
}

impl Traffic {
    /// Brings the vehicles of lanes and bays into a crowd. Vehicles in lanes have no drivers yet.
    pub(crate) fn new(
        crowd: &mut Crowd,
        lanes: &[LanePlan],
        bays: &[BayPlan],
        models: &[VehicleModel],
    ) -> Result<Self, Error> {
        let mut traffic = Self { models: models.to_vec(), ..Self::default() };
        traffic.lanes = lanes.iter().map(Lane::new).collect();
        for plan in bays {
            let lane = lanes.iter().position(|lane| lane.name == plan.lane);
            let lane = lane.ok_or_else(|| {
                Error::unknown("lane", &plan.lane, lanes.iter().map(|lane| &lane.name))
            })?;
            let at = Vec2::from(plan.at);
            if !traffic.lanes[lane].has_room_for_bay(at) {
                let lane = plan.lane.clone();
                return Err(Error::BayAtLaneEnd { lane, at: plan.at, least_m: SWERVE_M });
            }
            let [along_m, aside_m] = traffic.lanes[lane].place(at);
            traffic.bays.push(Bay { lane, along_m, aside_m, vehicle: None });
        }
        if models.is_empty() {
            return Ok(traffic);
        }
        for (bay, _) in bays.iter().enumerate().filter(|(_, plan)| plan.taken) {
            let Bay { lane, along_m, .. } = traffic.bays[bay];
            let drive = Drive::Stands { bay, since: f64::NEG_INFINITY };
            traffic.bays[bay].vehicle = Some(traffic.vehicles.len());
            traffic.add(crowd, lane, along_m, drive)?;
        }
        for (lane, plan) in lanes.iter().enumerate() {
            let apart = traffic.lanes[lane].length_m / plan.vehicles.max(1) as f32;
            for nth in 0..plan.vehicles {
                traffic.add(crowd, lane, apart * (nth as f32 + 0.5), Drive::Cruises)?;
            }
        }
        Ok(traffic)
    }

    fn add(
        &mut self,
        crowd: &mut Crowd,
        lane: usize,
        along_m: f32,
        drive: Drive,
    ) -> Result<(), Error> {
        let nth = self.vehicles.len();
        let model = nth % self.models.len();
        let placement = self.placement(lane, along_m, drive);
        let VehicleModel { character, roll, .. } = self.models[model];
        let member = crowd.spawn(character, placement)?;
        let mut view = crowd.member_mut(member)?;
        let mut rolling = None;
        if let Some(roll) = roll {
            rolling = Some((view.play(roll, ClipPlayback::looping().speed(0.0))?, 0.0));
        }
        let is_parked = matches!(drive, Drive::Stands { .. });
        let speed = if is_parked { 0.0 } else { self.lanes[lane].speed };
        // Golden ratio steps spread the paces evenly.
        let pace = 0.85 + 0.25 * (nth as f32 * 0.618_034).fract();
        let (driver, claimed, is_open) = (None, None, false);
        self.vehicles.push(Vehicle {
            member,
            model,
            lane,
            along_m,
            speed,
            drive,
            driver,
            claimed,
            is_open,
            rolling,
            pace,
            placement,
        });
        Ok(())
    }

    /// The placement of a vehicle.
    pub(crate) fn placement_of(&self, vehicle: usize) -> Placement {
        self.vehicles[vehicle].placement
    }

    /// Moves all vehicles on by `secs`. `stops` are in any order.
    pub(crate) fn advance(
        &mut self,
        crowd: &mut Crowd,
        stops: &[Stop],
        (now, secs): (f64, f32),
    ) -> Result<(), Error> {
        self.sort();
        for place in 0..self.order.len() {
            let index = self.order[place];
            let acceleration = self.acceleration(place, stops);
            let lane = self.vehicles[index].lane;
            let length_m = self.lanes[lane].length_m;
            let vehicle = &mut self.vehicles[index];
            let speed = (vehicle.speed + acceleration * secs).max(0.0);
            vehicle.along_m += 0.5 * (vehicle.speed + speed) * secs;
            vehicle.speed = speed;
            match vehicle.drive {
                Drive::Parks { bay } => {
                    let to = self.bays[bay].along_m;
                    if to - vehicle.along_m < 0.05
                        || vehicle.speed < 0.02 && to - vehicle.along_m < 0.6
                    {
                        vehicle.speed = 0.0;
                        vehicle.drive = Drive::Stands { bay, since: now };
                    }
                }
                Drive::SetsOff { bay } if vehicle.along_m >= self.bays[bay].along_m + SWERVE_M => {
                    vehicle.drive = Drive::Cruises;
                    self.bays[bay].vehicle = None;
                }
                _ => {}
            }
            if vehicle.along_m >= length_m {
                vehicle.along_m -= length_m;
            }
        }
        for index in 0..self.vehicles.len() {
            let Vehicle { lane, along_m, drive, .. } = self.vehicles[index];
            let placement = self.placement(lane, along_m, drive);
            let roll_m = self.models[self.vehicles[index].model].roll_m;
            let vehicle = &mut self.vehicles[index];
            if placement != vehicle.placement {
                vehicle.placement = placement;
                crowd.member_mut(vehicle.member)?.set_placement(placement)?;
            }
            let speed = vehicle.speed;
            if let Some((rolling, told)) = &mut vehicle.rolling
                && (speed - *told).abs() > 0.02 * told.abs() + if speed == 0.0 { 0.0 } else { 0.02 }
            {
                *told = speed;
                crowd.member_mut(vehicle.member)?.set_speed(*rolling, speed / roll_m)?;
            }
        }
        Ok(())
    }

    /// Queues vehicles before a stretch of a lane: all that begin on it, and all that cannot stop
    /// in time.
    pub(crate) fn hold(
        &mut self,
        crowd: &mut Crowd,
        lane: usize,
        [from_m, until_m]: [f32; 2],
    ) -> Result<(), Error> {
        self.sort();
        let mut front_m = from_m;
        for index in self.order.clone().into_iter().rev() {
            let half = 0.5 * self.models[self.vehicles[index].model].length_m;
            let vehicle = &mut self.vehicles[index];
            let needed = vehicle.speed.powi(2) / (2.0 * LOSS);
            let is_near = vehicle.along_m + half > front_m - needed;
            if vehicle.lane != lane
                || vehicle.drive != Drive::Cruises
                || !is_near
                || vehicle.along_m - half >= until_m
            {
                continue;
            }
            (vehicle.along_m, vehicle.speed) = (front_m - half, 0.0);
            front_m = vehicle.along_m - half - JAM_M;
            let placement = self.placement(lane, self.vehicles[index].along_m, Drive::Cruises);
            self.vehicles[index].placement = placement;
            crowd.member_mut(self.vehicles[index].member)?.set_placement(placement)?;
        }
        Ok(())
    }

    /// Sorts the vehicles on the road by lane and length along it.
    fn sort(&mut self) {
        let vehicles = &self.vehicles;
        self.order.clear();
        let moves = |index: &usize| !matches!(vehicles[*index].drive, Drive::Stands { .. });
        self.order.extend((0..vehicles.len()).filter(moves));
        self.order.sort_unstable_by(|a, b| {
            let (a_at, b_at) = (&vehicles[*a], &vehicles[*b]);
            a_at.lane.cmp(&b_at.lane).then(a_at.along_m.total_cmp(&b_at.along_m)).then(a.cmp(b))
        });
    }

    /// Returns true if nobody who steps onto a lane now is met by a vehicle within `secs`, at a
    /// length along the lane.
    pub(crate) fn is_clear(&self, lane: usize, along_m: f32, secs: f32) -> bool {
        self.vehicles.iter().filter(|vehicle| vehicle.lane == lane).all(|vehicle| {
            let gap = along_m - vehicle.along_m - 0.5 * self.models[vehicle.model].length_m;
            let stands = vehicle.speed < 0.4 || matches!(vehicle.drive, Drive::Stands { .. });
            let has_passed = gap < -self.models[vehicle.model].length_m - 1.5;
            has_passed || stands && gap > 0.3 || gap > vehicle.speed * secs + 2.0
        })
    }

    /// Returns the point in the world of a point `[x, y, z]` of a vehicle.
    pub(crate) fn world_point(&self, vehicle: usize, point: [f32; 3]) -> [f32; 3] {
        self.vehicles[vehicle].placement.world_from_model().transform_point(point)
    }

    /// Returns the heading of somebody who faces a vehicle's driver's side.
    pub(crate) fn entry_yaw_rad(&self, vehicle: usize) -> f32 {
        self.vehicles[vehicle].placement.yaw_rad() - FRAC_PI_2
    }
}
