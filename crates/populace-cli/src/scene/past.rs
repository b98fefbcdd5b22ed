//! Where people are, and where they were.

use std::collections::VecDeque;

use glam::Vec3;

use crate::camera::Pose;
use crate::frames::single;

/// Time for which poses are kept, in seconds: as long as cameras look back.
const KEPT_SECS: f64 = 0.6;
/// Metres per second above which a person has not moved, but was put elsewhere: a vehicle at the
/// end of its lane begins again.
const FASTEST_M_PER_SEC: f32 = 100.0;

/// The present and the latest poses of people.
#[derive(Default)]
pub(super) struct Past {
    pub(super) now: Vec<Pose>,
    /// The latest is last. Each has the seconds that have passed since.
    earlier: VecDeque<(f64, Vec<Pose>)>,
}

impl Past {
    /// Goes on by `secs` to other poses. With 0, they take the place of the present ones.
    pub(super) fn pass(&mut self, secs: f64, now: Vec<Pose>) {
        let before = std::mem::replace(&mut self.now, now);
        if secs == 0.0 {
            return;
        }
        self.earlier.push_back((0.0, before));
        self.earlier.iter_mut().for_each(|(since, _)| *since += secs);
        while self.earlier.get(1).is_some_and(|(since, _)| *since >= KEPT_SECS) {
            self.earlier.pop_front();
        }
    }

    /// Forgets all earlier poses. The next ones take the place of the present ones.
    #[cfg(feature = "viewer")]
    pub(super) fn forget(&mut self) {
        self.earlier.clear();
    }

    /// Returns the known way of a person; `None` for a number of nobody.
    pub(super) fn way(&self, id: u64) -> Option<Way> {
        let nth = usize::try_from(id).ok()?;
        let now = *self.now.get(nth)?;
        let all = self.earlier.iter().rev();
        let all = all.map_while(|(since, poses)| Some((*since, *poses.get(nth)?)));
        let known = all.scan((0.0, now), |later, earlier| {
            let way = Vec3::from(later.1.position).distance(Vec3::from(earlier.1.position));
            let moved = way <= FASTEST_M_PER_SEC * single(earlier.0 - later.0);
            *later = earlier;
            moved.then_some(earlier)
        });
        let earlier: Vec<(f64, Pose)> = known.collect();
        Some(Way { ahead: Line::fit(now, &earlier), now, earlier })
    }
}

/// The way of a person since it was last put elsewhere.
pub(super) struct Way {
    now: Pose,
    /// The earlier poses, the latest first, and the seconds that have passed since each.
    earlier: Vec<(f64, Pose)>,
    ahead: Line,
}

impl Way {
    /// Returns where the person was `secs` ago: the earliest pose that is known for times before
    /// it. For times to come, goes on along the line that fits the known poses best, so that
    /// cameras that average the way of a person do not fall behind.
    pub(super) fn before(&self, secs: f64) -> Pose {
        if secs < 0.0 {
            return Pose { position: self.ahead.at(single(-secs)).to_array(), ..self.now };
        }
        let mut later = (0.0, self.now);
        for &(since, earlier) in &self.earlier {
            if secs < since {
                let share = single((secs - later.0) / (since - later.0));
                let [from, to] = [later.1, earlier].map(|pose| Vec3::from(pose.position));
                let nearer = if share < 0.5 { later.1 } else { earlier };
                return Pose { position: from.lerp(to, share).to_array(), ..nearer };
            }
            later = (since, earlier);
        }
        later.1
    }
}

/// The line of least squares through poses, along which a person goes on.
struct Line {
    middle_secs: f32,
    middle: Vec3,
    /// The velocity is `rise / spread`, unless `spread` is 0.
    rise: Vec3,
    spread: f32,
}

impl Line {
    fn fit(now: Pose, earlier: &[(f64, Pose)]) -> Self {
        let known = || std::iter::once((0.0, now)).chain(earlier.iter().copied());
        let points = || known().map(|(since, pose)| (-single(since), Vec3::from(pose.position)));
        let count = points().fold(0.0, |count, _| count + 1.0);
        let middle_secs = points().map(|(at, _)| at).sum::<f32>() / count;
        let middle = points().map(|(_, point)| point).sum::<Vec3>() / count;
        let spread = points().map(|(at, _)| (at - middle_secs).powi(2)).sum();
        let rise = points().map(|(at, point)| (at - middle_secs) * (point - middle)).sum();
        Self { middle_secs, middle, rise, spread }
    }

    /// Returns the point in `secs`.
    fn at(&self, secs: f32) -> Vec3 {
        if self.spread == 0.0 {
            return self.middle;
        }
        self.middle + (secs - self.middle_secs) * self.rise / self.spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earlier_poses_lie_between_those_that_were_seen() {
        let at = |x: f32| vec![Pose { position: [x, 0.0, 0.0], heading_rad: x, eye_m: 1.6 }];
        let mut past = Past { now: at(0.0), ..Past::default() };
        for step in 1..=10_u8 {
            past.pass(0.1, at(f32::from(step)));
        }
        let x = |secs| past.way(0).map(|way| way.before(secs).position[0]);
        for (secs, expected) in [(-1.0, 20.0), (0.0, 10.0), (0.1, 9.0), (0.25, 7.5), (9.0, 4.0)] {
            assert!(x(secs).is_some_and(|x| (x - expected).abs() < 1e-4), "{secs}: {:?}", x(secs));
        }
        assert_eq!(past.way(0).map(|way| way.before(0.27).heading_rad), Some(7.0));
        assert_eq!(past.way(1).map(|way| way.before(0.0)), None);
        past.pass(0.0, at(12.0));
        let x = |secs| past.way(0).map(|way| way.before(secs).position[0]);
        assert_eq!([x(0.0), x(0.1)], [Some(12.0), Some(9.0)]);
    }

    #[test]
    fn who_was_put_elsewhere_has_no_earlier_poses() {
        let at = |x: f32| vec![Pose { position: [x, 0.0, 0.0], heading_rad: 0.0, eye_m: 1.6 }];
        let mut past = Past { now: at(99.0), ..Past::default() };
        past.pass(0.1, at(100.0));
        past.pass(0.1, at(0.0));
        let x = |secs| past.way(0).map(|way| way.before(secs).position[0]);
        assert_eq!([-0.5, 0.0, 0.1, 0.5].map(x), [Some(0.0); 4]);
        past.pass(0.1, at(1.0));
        let x = |secs| past.way(0).map(|way| way.before(secs).position[0]);
        assert_eq!([x(-0.1), x(0.1), x(0.5)], [Some(2.0), Some(0.0), Some(0.0)]);
    }
}
