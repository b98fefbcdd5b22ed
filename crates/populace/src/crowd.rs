//! The crowd: members of characters, playing clips on a device.

mod active_device;
mod assets;
mod attach;
mod base;
mod batch;
mod builder;
mod by_member;
mod constraints;
mod devices;
mod events;
mod interop;
mod live;
mod member;
mod members;
mod motion;
mod player;
mod profile;
mod readback;
mod removal;
mod slab;
mod snapshot;
mod stages;
mod state;
mod timeline;
mod view;
mod visible;
mod watches;

use populace_model::convert::u32_from;

use crate::{
    BlendSpaceId, CharacterId, ClipId, Error, MachineId, MaskId, MemberId, Parameter, ParameterId,
    PlaybackId,
};
use active_device::ActiveDevice;
use state::State;

pub use assets::{CharacterMut, CharacterRef, ClipMut};
pub use builder::CrowdBuilder;
pub use events::{Event, EventKind};
pub use member::{MemberMut, MemberRef, MemberView};
pub use profile::{DeviceInfo, FrameTimes};
pub use removal::AssetId;
pub use snapshot::Snapshot;
pub use stages::StageId;
pub use timeline::{History, SeekReport};
pub use view::ViewStatistics;
pub use visible::VisibleMember;
pub use watches::{JointReadback, Watch};

/// Members of characters, playing clips on a device.
pub struct Crowd {
    /// All that the host knows.
    state: State,
    /// The devices that evaluate it.
    device: ActiveDevice,
    /// See [`FrameTimes::view_ms`].
    view_ms: f64,
}

impl Crowd {
    /// Returns the settings from which a crowd is built.
    #[must_use]
    pub fn builder() -> CrowdBuilder {
        CrowdBuilder::default()
    }

    /// Waits until the device has finished all work. Bounding spheres are then where root motion
    /// has taken the members by the last update, and the next update chooses levels of detail by
    /// them.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.device.backend_mut().finish()?;
        Ok(self.update_offsets()?)
    }

    /// Sets the ground for planted feet: level at height 0 unless set.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn set_ground(&mut self, ground: &populace_device::Ground) -> Result<(), Error> {
        Ok(self.state.base.tables.set_ground(ground)?)
    }

    /// The events of the last update, in order of time, of members that
    /// [subscribed](crate::MemberMut::subscribe_events). Clips of state machines report none: only
    /// the device knows their state. If a clip comes to one footstep or marker more than 16 times
    /// in an update, the last 16 are reported.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        self.state.events.as_slice()
    }
}

#[cfg(test)]
mod tests;
