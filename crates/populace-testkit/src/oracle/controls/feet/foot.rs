//! One foot: it goes with its clips and the member's stride, is locked while it stands, and catches
//! up with its clips in the air.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DQuat, DVec3};
use populace_device::layout::{
    FOOT_LIFT, FOOT_MAX_TURN, FOOT_NEAR_SECS, FOOT_PIVOT_SLACK, FOOT_REACH, FOOT_RELEASE_SECS,
    FOOT_RELOCK, FOOT_SETTLE, FOOT_SETTLE_SECS, FOOT_SINK, FOOT_SINK_UNKNOWN,
};

use super::foothold::{ahead, shown, under};
use super::{
    AIR_ABOVE, FootGoal, FootState, Hold, LegAtRest, MOST_OFFSET, OracleGait, STANDS_BELOW,
};
use crate::oracle::controls::limb::shortest;
use crate::oracle::controls::short_part_of;
use crate::oracle::noise::Noise;

/// A foot as its clips pose it, in model space, and what it goes by.
pub(super) struct FootNow<'a> {
    pub(super) rest: &'a LegAtRest,
    pub(super) hip: DVec3,
    pub(super) ankle: DVec3,
    /// Points of the sole.
    pub(super) points: Vec<DVec3>,
    /// From heel to ball, if the sole has both.
    pub(super) along: Option<DVec3>,
    pub(super) gait: &'a OracleGait,
    pub(super) place: &'a DAffine3,
    /// Seconds for which all feet have stood; 0 once one has let go.
    pub(super) stood_secs: f64,
}

/// A foot after the member's stride.
struct Stepped {
    ankle: DVec3,
    /// Points of the sole relative to the ankle, before the foot turns; if there is none, the point
    /// beneath the ankle.
    arms: Vec<DVec3>,
    /// The tangent of half the angle by which the stride turns the foot.
    turn: f64,
    /// The point that is lowest, and its height.
    lowest: usize,
    clearance: f64,
}

/// A lock, or the lack of one.
struct Lock {
    /// From where the clip has the foot; horizontal, in world space.
    offset: DVec3,
    /// The member was moved elsewhere.
    elsewhere: bool,
    stands: bool,
    released: bool,
    pivot: usize,
}

fn horizontal(v: DVec3) -> DVec3 {
    DVec3::new(v.x, 0.0, v.z)
}

/// Returns a vector turned about +Y, by the tangent of half the angle.
fn turned(v: DVec3, half_tan: f64) -> DVec3 {
    DQuat::from_rotation_y(2.0 * half_tan.atan()) * v
}

/// Returns the sum of two angles, each as the tangent of its half.
fn sum(a: f64, b: f64) -> f64 {
    (a.atan() + b.atan()).tan()
}

fn smooth(part: f64) -> f64 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

impl FootNow<'_> {
    fn to_world(&self, point: DVec3, noise: &mut Noise) -> DVec3 {
        let arm = self.place.transform_vector3(point);
        let at = self.place.translation;
        noise.sized(at + arm, at.length() + arm.length())
    }

    /// Returns the longest offset of the foot in the world.
    fn most(&self) -> f64 {
        MOST_OFFSET * self.rest.length * self.place.matrix3.y_axis.length()
    }

    /// Applies the stride to distances from the ankle's place at rest.
    fn step(&self, noise: &mut Noise) -> Stepped {
        let [along_x, along_z, turn] = self.gait.stride;
        let ahead = noise.near(self.ankle.z - self.rest.ankle.z, self.ankle.z.abs());
        let straight = DVec3::new(
            self.ankle.x + ahead * along_x,
            self.ankle.y,
            self.rest.ankle.z + ahead * along_z,
        );
        let turn = turn * ahead;
        let mut arms: Vec<DVec3> = self.points.iter().map(|point| point - self.ankle).collect();
        if arms.is_empty() {
            arms.push(DVec3::new(0.0, -self.rest.ankle.y, 0.0));
        }
        let height = |at: &usize| self.ankle.y + arms[*at].y;
        let lowest = (0..arms.len()).min_by(|a, b| height(a).total_cmp(&height(b)));
        let lowest = lowest.expect("there is a point");
        let clearance = height(&lowest);
        let ankle = noise.vector(turned(straight, turn));
        Stepped { ankle, arms, turn, lowest, clearance }
    }

    /// Returns whether the foot stands, and how near it is to that: 1 while it stands, 0 in the
    /// air.
    fn stands(&self, within: Option<f64>, noise: &mut Noise) -> (bool, f64) {
        match within {
            Some(within) => (within >= 0.0, smooth(1.0 + within / f64::from(FOOT_NEAR_SECS))),
            None => {
                let lift = self.ankle.y - self.rest.ankle.y;
                let lift = noise.near(lift, self.ankle.y.abs()) / self.rest.length;
                let above = (lift - STANDS_BELOW) / (AIR_ABOVE - STANDS_BELOW);
                (lift <= STANDS_BELOW, smooth(1.0 - above))
            }
        }
    }

    /// Returns the heading from heel to ball as the stride has it, in the world.
    fn heading(&self, turn: f64, noise: &mut Noise) -> Option<f64> {
        let along = self.place.transform_vector3(turned(self.along?, turn));
        let along = noise.vector(along);
        Some(along.x.atan2(along.z))
    }

    /// Returns by how much the foot is turned from where the stride has it: the tangent of half the
    /// angle.
    fn lag_of_turn(before: Option<&FootState>, own: Option<f64>, decay: f64) -> f64 {
        let (Some(own), Some(before)) = (own, before) else { return 0.0 };
        let most = f64::from(FOOT_MAX_TURN);
        let lag = match before.hold {
            Hold::Follows { turn, .. } => turn * decay,
            Hold::Locked { heading: None, .. } => 0.0,
            Hold::Locked { heading: Some(kept), .. } => {
                let angle = (kept - own + PI).rem_euclid(TAU) - PI;
                if angle.abs() < FRAC_PI_2 { (0.5 * angle).tan() } else { 0.0 }
            }
        };
        lag.clamp(-most, most)
    }

    /// Returns the offset from where the clip has the foot, and whether the member was moved
    /// elsewhere, which ends the offset. `pivot` is where the clip has the point that stands.
    fn offset(&self, before: Option<&FootState>, pivot: DVec3, decay: f64) -> (DVec3, bool) {
        let most = self.most();
        let offset = match before.map(|before| before.hold) {
            None => DVec3::ZERO,
            Some(Hold::Locked { anchor, .. }) => horizontal(anchor - pivot),
            Some(Hold::Follows { lag, .. }) => lag * decay,
        };
        if offset.length() > 2.0 * most {
            return (DVec3::ZERO, true);
        }
        (offset.clamp_length_max(most), false)
    }

    /// Returns whether an offset takes the ankle too far from the hip: horizontally, or so that the
    /// hip would have to sink for the offset alone.
    fn overstretches(
        &self,
        stepped: &Stepped,
        offset: DVec3,
        knows_contacts: bool,
        noise: &mut Noise,
    ) -> bool {
        let own = self.to_world(stepped.ankle, noise) - self.to_world(self.hip, noise);
        let (down, with) = (-own.y, horizontal(own + offset).length());
        let own = horizontal(own).length();
        let leg = self.most() / MOST_OFFSET;
        let height = |away: f64| (leg * leg - away * away).max(0.0).sqrt();
        let sink = f64::from(if knows_contacts { FOOT_SINK } else { FOOT_SINK_UNKNOWN });
        let sunk = (down.min(height(own)) - sink * self.most()).max(0.0);
        with > own && (with > f64::from(FOOT_REACH) * self.most() || sunk > height(with))
    }

    /// Returns whether a foot that stands for long leaves an offset, to stand below the body.
    fn settles(&self, offset: DVec3) -> bool {
        self.stood_secs >= f64::from(FOOT_SETTLE_SECS)
            && offset.length() > f64::from(FOOT_SETTLE) * self.most()
    }

    /// Locks a foot that stands, unless the lock would hold it too far back. A foot that was let go
    /// is locked again once it has caught up. The lock passes to another point of the sole when
    /// that is lower.
    fn lock(
        &self,
        before: Option<&FootState>,
        stepped: &Stepped,
        (stands, knows_contacts): (bool, bool),
        (turn, decay): (f64, f64),
        noise: &mut Noise,
    ) -> Lock {
        let (kept, was_released) = match before.map(|before| before.hold) {
            Some(Hold::Locked { pivot, .. }) => (Some(pivot), false),
            Some(Hold::Follows { released, .. }) => (None, released),
            None => (None, false),
        };
        let arm = kept.map_or(DVec3::ZERO, |pivot| turned(stepped.arms[pivot], turn));
        let pivot = self.to_world(stepped.ankle + arm, noise);
        let (offset, elsewhere) = self.offset(before, pivot, decay);
        let behind = was_released && offset.length() > f64::from(FOOT_RELOCK) * self.most();
        let lets_go = behind
            || self.overstretches(stepped, offset, knows_contacts, noise)
            || self.settles(offset);
        let slack = f64::from(FOOT_PIVOT_SLACK) * MOST_OFFSET * self.rest.length;
        let is_low = |pivot: &usize| {
            let height = self.ankle.y + stepped.arms[*pivot].y;
            height <= stepped.clearance + slack
        };
        Lock {
            offset,
            elsewhere,
            stands: stands && !lets_go,
            released: stands && lets_go,
            pivot: kept.filter(is_low).unwrap_or(stepped.lowest),
        }
    }

    /// Returns the goal of the foot, and its state for the next frame.
    pub(super) fn goal(
        &self,
        before: Option<&FootState>,
        within: Option<f64>,
        noise: &mut Noise,
    ) -> (FootGoal, FootState) {
        let (gait, most) = (self.gait, self.most());
        let stepped = self.step(noise);
        let (stands, near) = self.stands(within, noise);
        let decay = 1.0 / (1.0 + gait.elapsed_secs / f64::from(FOOT_RELEASE_SECS));
        let own = self.heading(stepped.turn, noise);
        let lag = Self::lag_of_turn(before, own, decay);
        let turn = sum(stepped.turn, lag);
        let lock = self.lock(before, &stepped, (stands, within.is_some()), (turn, decay), noise);
        let arm = turned(stepped.arms[lock.pivot], turn);
        let place = self.to_world(stepped.ankle + arm, noise) + lock.offset;
        let points: Vec<DVec3> = if self.points.is_empty() { &[][..] } else { &stepped.arms }
            .iter()
            .map(|arm| self.to_world(stepped.ankle + turned(*arm, turn), noise) + lock.offset)
            .collect();
        let under = under(gait, place, &points, most, noise);
        let is_lifted = lock.released && within.is_some();
        let lift = if is_lifted { f64::from(FOOT_LIFT) * lock.offset.length() } else { 0.0 };
        let ahead = lift + ahead(gait, self.place, place, under.height, [most, near], noise);
        let known = before.filter(|_| !lock.elsewhere);
        let secs = gait.elapsed_secs;
        let (height, climb) = shown(known, lock.stands, (&under, ahead), secs, noise);
        let hold = if lock.stands {
            Hold::Locked {
                anchor: place,
                heading: own.map(|own| own + 2.0 * lag.atan()),
                pivot: lock.pivot,
                above: height - under.height,
            }
        } else {
            Hold::Follows { lag: lock.offset, turn: lag, released: lock.released }
        };
        let normal = self.place.inverse().transform_vector3(under.normal).normalize();
        let ankle = self.ankle_over(&stepped, arm, (place, height), (normal, near), noise);
        (FootGoal { ankle, turn, normal, near }, FootState { hold, height, climb })
    }

    /// Returns the ankle's place in model space, if its pivot is above a place on the ground. A
    /// foot in the air is as far above the ground as the clip has it; one that stands leans with
    /// the slope.
    fn ankle_over(
        &self,
        stepped: &Stepped,
        arm: DVec3,
        (place, height): (DVec3, f64),
        (normal, near): (DVec3, f64),
        noise: &mut Noise,
    ) -> DVec3 {
        let kept = stepped.clearance.max(0.0) * (1.0 - near);
        let above = kept + (stepped.ankle.y + arm.y - stepped.clearance);
        let scale = self.place.matrix3.y_axis.length();
        let at = DVec3::new(place.x, height + above * scale, place.z);
        let size = at.length() + self.place.translation.length();
        let pivot = self.place.inverse().transform_point3(noise.sized(at, size));
        let lean = short_part_of(shortest(DVec3::Y, normal, DVec3::X, noise), near);
        pivot - noise.vector(lean * arm)
    }
}
