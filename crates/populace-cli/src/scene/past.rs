//! Where people are, and where they were.

use std::collections::VecDeque;

use glam::Vec3;

use crate::camera::Pose;
use crate::frames::single;

/// Time for which poses are kept, in seconds: as long as cameras look back.
const KEPT_SECS: f64 = 0.6;

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

    /// Returns where a person was `secs` ago; where it is now for times to come, and the earliest
    /// pose that is known for times before it.
    pub(super) fn before(&self, id: u64, secs: f64) -> Option<Pose> {
        let nth = usize::try_from(id).ok()?;
        let mut later = (0.0, *self.now.get(nth)?);
        for (since, poses) in self.earlier.iter().rev() {
            if secs <= later.0 {
                break;
            }
            let Some(earlier) = poses.get(nth) else { break };
            if secs < *since {
                let share = single((secs - later.0) / (since - later.0));
                let [from, to] = [later.1, *earlier].map(|pose| Vec3::from(pose.position));
                let position = from.lerp(to, share).to_array();
                return Some(Pose { position, ..if share < 0.5 { later.1 } else { *earlier } });
            }
            later = (*since, *earlier);
        }
        Some(later.1)
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
        let x = |secs| past.before(0, secs).map(|pose| pose.position[0]);
        for (secs, expected) in [(-1.0, 10.0), (0.0, 10.0), (0.1, 9.0), (0.25, 7.5), (9.0, 4.0)] {
            assert!(x(secs).is_some_and(|x| (x - expected).abs() < 1e-4), "{secs}: {:?}", x(secs));
        }
        assert_eq!(past.before(0, 0.27).map(|pose| pose.heading_rad), Some(7.0));
        assert_eq!(past.before(1, 0.0), None);
        past.pass(0.0, at(12.0));
        let x = |secs| past.before(0, secs).map(|pose| pose.position[0]);
        assert_eq!([x(0.0), x(0.1)], [Some(12.0), Some(9.0)]);
    }
}
