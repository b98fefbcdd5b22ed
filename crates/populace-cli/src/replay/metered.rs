//! The people of a recording whose feet are measured.

use populace::{Crowd, MemberId};
use populace_locomotion::{FootSkate, SkateMeter};
use populace_scene::Replay;

use crate::failure::Failure;

/// People whose feet are measured when most are there.
const METERED: usize = 16;

/// Measures the feet of some of the people.
pub(super) struct Metered {
    meter: SkateMeter,
    /// Measures every agent whose index is a multiple of this.
    every: usize,
    /// Measured people who were present in the last frame.
    members: Vec<MemberId>,
}

impl Metered {
    /// Returns the measure of people of whom there are up to `peak` at the same time.
    pub(super) fn new(peak: usize) -> Self {
        let every = peak.div_ceil(METERED);
        Self { meter: SkateMeter::new(), every, members: Vec::new() }
    }

    /// Finds who is there, before an update of the crowd.
    pub(super) fn find(&mut self, crowd: &mut Crowd, replay: &Replay) -> Result<(), Failure> {
        let measured = replay.present().filter(|(agent, _)| agent % self.every == 0);
        let present: Vec<MemberId> = measured.map(|(_, member)| member).collect();
        for member in present.iter().filter(|member| !self.members.contains(member)) {
            let character = crowd.member(*member)?.character();
            // With its last joint watched, a member is posed with all of them, however far or out
            // of view it is: the measure does not depend on the camera.
            if let Some(last) = crowd.character(character)?.asset().skeleton.joints().last() {
                crowd.member_mut(*member)?.watch_joint(last)?;
            }
        }
        self.members = present;
        Ok(())
    }

    /// Measures them, after an update of the crowd by `secs`.
    pub(super) fn sample(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        for member in &self.members {
            self.meter.sample(crowd, *member, secs)?;
        }
        Ok(())
    }

    /// Returns the skate of all frames so far; `None` if no foot was planted.
    pub(super) fn skate(&self) -> Option<FootSkate> {
        self.meter.skate()
    }

    /// Begins again, with a crowd without people.
    #[cfg(feature = "viewer")]
    pub(super) fn rewind(&mut self) {
        *self = Self { meter: SkateMeter::new(), members: Vec::new(), ..*self };
    }
}
