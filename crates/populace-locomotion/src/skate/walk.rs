//! Two members that walk a part of the course alike, without planting and with it.

use glam::Vec3;
use populace::{CharacterId, Ground, MemberId, Placement, Stride};

use super::body::Sole;
use super::course::{Course, FRAMES_PER_SEC, Order, Part, frames};
use super::samples::Samples;
use crate::{Error, Goal, WalkerSettings, Walkers};

/// Times that a straight part is walked to find the speed of the gait: each begins later, by this
/// part of a frame. A fast gait takes so few frames for a cycle, often nearly the same in each, that
/// one walk shows no more than 40 to 60 times of the cycle. The median of these is off by 2 %.
const WALKS: u16 = 4;

/// One of the two members.
struct Lane {
    walkers: Walkers,
    member: MemberId,
    last: Option<[Sole; 2]>,
    legs: Vec<Vec<Vec3>>,
    samples: Samples,
    /// See [`Samples::passing`], frame by frame.
    passing: Vec<Vec<f32>>,
    from: [f32; 2],
}

/// Two members on one part of the course: the second has its feet planted.
struct Walk {
    lanes: [Lane; 2],
    ground: Ground,
}

impl Course {
    /// Walks a part and measures it for some seconds, without planting and with it.
    pub(super) fn walk(&mut self, part: Part, secs: f32) -> Result<[Samples; 2], Error> {
        let mut both = self.walk_once(part, secs, 0.0)?;
        let Some(requested) = part.requested() else { return Ok(both) };
        for nth in 1..WALKS {
            let others = self.walk_once(part, secs, f32::from(nth) / f32::from(WALKS))?;
            for (samples, other) in both.iter_mut().zip(others) {
                samples.passing.extend(other.passing);
            }
        }
        both.iter_mut().for_each(|samples| samples.hold_to(requested));
        Ok(both)
    }

    /// Walks a part and begins to measure it later by a part of a frame.
    fn walk_once(&mut self, part: Part, secs: f32, later: f32) -> Result<[Samples; 2], Error> {
        let ground = part.ground()?;
        self.crowd.set_ground(&ground)?;
        let mut walk = Walk::new(self, self.id, ground)?;
        for _ in frames(part.warm_secs()) {
            walk.frame(self, part.order(0.0), 1.0)?;
        }
        if later > 0.0 {
            walk.frame(self, part.order(0.0), later)?;
        }
        walk.begin(self)?;
        for frame in frames(secs) {
            walk.frame(self, part.order(frame / FRAMES_PER_SEC), 1.0)?;
            walk.sample(self)?;
        }
        walk.end(self, secs)
    }
}

impl Walk {
    fn new(course: &mut Course, id: CharacterId, ground: Ground) -> Result<Self, Error> {
        let bare = Lane::new(course, id, &ground)?;
        course.crowd.member_mut(bare.member)?.plant_feet(0.0)?;
        let planted = Lane::new(course, id, &ground)?;
        Ok(Self { lanes: [bare, planted], ground })
    }

    /// Moves both members on by some frames.
    fn frame(&mut self, course: &mut Course, order: Order, frames: f32) -> Result<(), Error> {
        let secs = frames / FRAMES_PER_SEC;
        for lane in &mut self.lanes {
            lane.walkers.set_facing(lane.member, order.facing_rad)?;
            lane.walkers.set_goal(lane.member, Goal::Velocity(order.velocity))?;
            lane.walkers.update(&mut course.crowd, secs)?;
        }
        course.crowd.update(secs)?;
        Ok(())
    }

    /// Begins to measure.
    fn begin(&mut self, course: &mut Course) -> Result<(), Error> {
        for lane in &mut self.lanes {
            lane.last = Some(lane.soles(course)?);
            lane.from = lane.walkers.positions()[0];
        }
        Ok(())
    }

    /// Measures a frame.
    fn sample(&mut self, course: &mut Course) -> Result<(), Error> {
        // The gait before planting is that of the member without it, with the stride of the other.
        let strides = [Stride::OF_CLIPS, self.lanes[1].walkers.strides()[0].1];
        let bare = self.lanes[0].soles(course)?;
        if let Some(before) = &self.lanes[0].last {
            let passing = strides.map(|stride| passing(before, &bare, stride.lead()));
            for (lane, passing) in self.lanes.iter_mut().zip(passing) {
                lane.passing.push(passing);
            }
        }
        let planted = self.lanes[1].soles(course)?;
        for (lane, now) in self.lanes.iter_mut().zip([bare, planted]) {
            lane.sample(now, &self.ground);
        }
        Ok(())
    }

    /// Ends the part after some seconds, and takes the members from the crowd.
    fn end(self, course: &mut Course, secs: f32) -> Result<[Samples; 2], Error> {
        for lane in &self.lanes {
            course.crowd.despawn(lane.member)?;
        }
        Ok(self.lanes.map(|mut lane| {
            let [x, z] = lane.walkers.positions()[0];
            let whole = whole_cycles(lane.walkers.cycles_per_sec(), lane.passing.len());
            lane.samples.body_m_per_sec = (x - lane.from[0]).hypot(z - lane.from[1]) / secs;
            lane.samples.passing = lane.passing[..whole].concat();
            lane.samples
        }))
    }
}

impl Lane {
    fn new(course: &mut Course, id: CharacterId, ground: &Ground) -> Result<Self, Error> {
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        walkers.set_ground(ground.clone());
        walkers.add_gaits(course.gaits.clone());
        let member = course.crowd.spawn(id, Placement::at([0.0; 3]))?;
        walkers.add(&mut course.crowd, member)?;
        Ok(Self {
            walkers,
            member,
            last: None,
            legs: Vec::new(),
            samples: Samples::default(),
            passing: Vec::new(),
            from: [0.0; 2],
        })
    }

    /// Returns both feet of this frame, and counts the acceleration of the legs.
    fn soles(&mut self, course: &mut Course) -> Result<[Sole; 2], Error> {
        let models = course.crowd.member_mut(self.member)?.model_from_joints()?;
        let found = course.legs.acceleration(&mut self.legs, &models);
        self.samples.acceleration = self.samples.acceleration.max(found);
        course.body.soles(&course.crowd, self.member, &models)
    }

    fn sample(&mut self, now: [Sole; 2], ground: &Ground) {
        for (before, now) in self.last.iter().flatten().zip(&now) {
            self.samples.feet += 1.0;
            if !now.planted {
                continue;
            }
            self.samples.planted += 1.0;
            let above = |at: &Vec3| at.y - ground.height_at(at.x, at.z);
            let least = now.in_world.iter().map(above).fold(f32::INFINITY, f32::min);
            self.samples.heights_m.push(least.abs());
            self.samples.speeds.extend(before.slid_m(now).map(|slid| slid * FRAMES_PER_SEC));
        }
        self.last = Some(now);
    }
}

/// Returns the number of frames in the most whole cycles that some frames hold; all of them if they
/// hold none. What is left of a cycle would count one part of a step more than the others.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not above `frames`")]
fn whole_cycles(cycles_per_sec: f32, frames: usize) -> usize {
    let cycle = FRAMES_PER_SEC / cycles_per_sec.abs();
    let whole = (frames as f32 / cycle).floor() * cycle;
    if whole >= 1.0 { frames.min(whole.round() as usize) } else { frames }
}

/// Returns the speeds at which the ground passes planted points backwards, between two frames
/// without planting, in metres per second. Ankles step as a stride leads them.
fn passing(before: &[Sole; 2], now: &[Sole; 2], [_, lead]: [f32; 2]) -> Vec<f32> {
    let both = before.iter().zip(now).filter(|(before, now)| before.planted && now.planted);
    let speed = |(before, now): (&Sole, &Sole)| {
        let point = before.lowest();
        let ankle = now.ankle.z - before.ankle.z;
        let arm = now.points[point].z - before.points[point].z - ankle;
        -(ankle * lead + arm) * FRAMES_PER_SEC
    };
    both.map(speed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_taken_over_whole_cycles() {
        // A cycle of 75 frames at 0.8 in a second.
        assert_eq!(whole_cycles(0.8, 300), 300);
        assert_eq!(whole_cycles(0.8, 299), 225);
        assert_eq!((whole_cycles(-0.8, 80), whole_cycles(0.1, 300)), (75, 300));
        assert_eq!(whole_cycles(0.0, 300), 300);
    }
}
