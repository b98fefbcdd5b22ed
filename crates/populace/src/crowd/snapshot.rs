//! Snapshots: the state of a crowd between two frames.

use super::Crowd;
use super::state::State;
use crate::Error;
use populace_backends::DeviceHistory;

/// The state of a crowd between two frames: members, assets, playback, constraints, the clock, and
/// the history that its device holds. See [`Crowd::snapshot`].
#[derive(Clone)]
pub struct Snapshot {
    state: State,
    history: DeviceHistory,
}

impl Crowd {
    /// Copies all state of the crowd. Waits for the last update.
    ///
    /// Ragdolls and other things outside the crowd are not part of it. The copy takes as much
    /// memory as the crowd has on the host.
    ///
    /// ```
    /// # use populace::{ClipPlayback, Crowd, Device, Placement};
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = populace::doc_fixture::knight(&mut crowd)?;
    /// # let walk = crowd.clip(knight, "Walk")?;
    /// let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// crowd.member_mut(member)?.play(walk, ClipPlayback::looping())?;
    /// crowd.update(0.25)?;
    /// let snapshot = crowd.snapshot()?;
    /// crowd.update(0.5)?;
    /// let first = crowd.member_mut(member)?.palette()?;
    /// crowd.restore(&snapshot)?;
    /// crowd.update(0.5)?;
    /// assert_eq!(crowd.member_mut(member)?.palette()?, first);
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn snapshot(&mut self) -> Result<Snapshot, Error> {
        let history = self.device.history(&self.state.base.tables)?;
        // Devices have then run the last update. A restored crowd starts from its offsets.
        self.update_offsets()?;
        Ok(Snapshot { state: self.state.clone(), history })
    }

    /// Returns to the state of a snapshot of this crowd. The same calls then give the same bits as
    /// they did after the snapshot, on any devices that compute the same bits. If the snapshot was
    /// taken after an update, the crowd is evaluated at its time once more, and results can be read
    /// at once. They are those of the snapshot's time. Joints of planted feet, and of members whose
    /// targets are joints of others, can differ slightly there; what later updates give does not.
    ///
    /// Devices, their split and the OpenGL context stay as they are. Handles that were returned
    /// after the snapshot was taken mean nothing afterwards.
    ///
    /// # Errors
    ///
    /// [`Error::OtherCrowd`] for a snapshot of another crowd, or a device that cannot run a user
    /// stage of the snapshot. Nothing is changed then. With a failing device the crowd has the
    /// state of the snapshot, and [`move_to`](Self::move_to) continues on another.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        if snapshot.state.base.number != self.state.base.number {
            return Err(Error::OtherCrowd);
        }
        let (now, then) = (&self.state.stages, &snapshot.state.stages);
        if now.is_any() || then.is_any() {
            self.device.backend_mut().set_stages(then.as_slice())?;
        }
        let epochs = self.state.base.tables.epochs();
        let last_motion = self.state.motion.last_number();
        self.state.clone_from(&snapshot.state);
        self.state.base.tables.continue_epochs(epochs);
        self.state.motion.continue_after(last_motion);
        self.device.take_history(snapshot.history.clone());
        self.evaluate_again()
    }
}
