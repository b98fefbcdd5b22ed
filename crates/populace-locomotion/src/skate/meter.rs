//! Foot skate of the members of a running crowd.

use std::collections::HashMap;

use populace::{CharacterId, Crowd, MemberId};

use super::body::{Body, Sole};
use super::samples::percentile;
use crate::Error;

/// Measures how fast planted soles slide on members of a running crowd, as [`Skate`](crate::Skate)
/// does on its course.
#[derive(Clone, Debug, Default)]
pub struct SkateMeter {
    bodies: Vec<(CharacterId, Option<Body>)>,
    last: HashMap<MemberId, [Sole; 2]>,
    speeds: Vec<f32>,
}

/// Speeds of planted soles in metres per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootSkate {
    /// Their mean.
    pub mean_m_per_sec: f32,
    /// The speed below which 95 % of them are.
    pub p95_m_per_sec: f32,
    /// Their number: planted feet of members from one frame to the next.
    pub samples: usize,
}

impl SkateMeter {
    /// Returns a meter that has seen no frame.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Measures a member after an update of its crowd by `secs`. The first frame of a member only
    /// serves the second. Members without two feet are passed over.
    ///
    /// # Errors
    ///
    /// Errors of the crowd, such as a member that was despawned.
    pub fn sample(&mut self, crowd: &mut Crowd, member: MemberId, secs: f32) -> Result<(), Error> {
        let character = crowd.member(member)?.character();
        let known = self.bodies.iter().position(|(id, _)| *id == character);
        let index = match known {
            Some(index) => index,
            None => {
                self.bodies.push((character, Body::new(crowd, character)?));
                self.bodies.len() - 1
            }
        };
        let Some(body) = &mut self.bodies[index].1 else { return Ok(()) };
        let models = crowd.member_mut(member)?.model_from_joints()?;
        let now = body.soles(crowd, member, &models)?;
        if let Some(last) = self.last.get(&member).filter(|_| secs > 0.0) {
            let slid = last.iter().zip(&now).filter_map(|(before, now)| before.slid_m(now));
            self.speeds.extend(slid.map(|slid| slid / secs));
        }
        self.last.insert(member, now);
        Ok(())
    }

    /// Forgets the last frame of a member, which leaves or jumps.
    pub fn forget(&mut self, member: MemberId) {
        self.last.remove(&member);
    }

    /// Returns the skate of all frames so far; `None` if no foot was planted.
    #[must_use]
    pub fn skate(&self) -> Option<FootSkate> {
        let mut speeds = self.speeds.clone();
        let samples = speeds.len();
        let p95_m_per_sec = percentile(&mut speeds, 95);
        // Single precision would lose the small among millions.
        let sum: f64 = speeds.iter().map(|speed| f64::from(*speed)).sum();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to the nearest f32 is intended"
        )]
        let mean_m_per_sec = (sum / samples as f64) as f32;
        (samples > 0).then_some(FootSkate { mean_m_per_sec, p95_m_per_sec, samples })
    }
}
