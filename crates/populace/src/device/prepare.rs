//! Devices made ready ahead of the crowds that come to them.

use std::sync::Arc;

use populace_character::{Character, CharacterSource, PaletteEntry};
use populace_device::Schedule;
use populace_model::{Affine, JointSource, Skeleton, Trs};

use super::{Device, Devices};
use crate::{Crowd, Error, Placement};

/// Members of the crowd that a device is tried with: of fewer, a table with one change would be
/// sent as a whole.
const MEMBERS: usize = 8;

impl Device {
    /// Builds what crowds of a schedule need on this device, and runs it once. A later
    /// [`move_to`](Crowd::move_to) or [`build`](crate::CrowdBuilder::build) in this process finds
    /// it done.
    ///
    /// This takes as long as the driver's compiler does: seconds, the first time. A crowd goes on
    /// elsewhere meanwhile where this runs on a thread of its own:
    ///
    /// ```
    /// use populace::{Crowd, Device};
    /// # let next = Device::native(); // in place of an OpenCL device
    /// let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// let schedule = crowd.schedule();
    /// let preparation = std::thread::spawn(move || next.prepare(schedule));
    /// while !preparation.is_finished() {
    ///     crowd.update(1.0 / 60.0)?;
    /// }
    /// preparation.join().expect("it does not panic")?;
    /// crowd.move_to(next)?;
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// Not included are users' stages, which are built when a crowd that has them moves, and what a
    /// driver builds for a context of OpenGL's that it shares buffers with.
    ///
    /// # Errors
    ///
    /// A device that is not there, cannot be opened or fails.
    pub fn prepare(self, schedule: Schedule) -> Result<(), Error> {
        let mut crowd =
            Crowd::builder().device(self).schedule(schedule).capacity(MEMBERS).build()?;
        let character = crowd.add_character(one_joint()?)?;
        let spawn = |_| crowd.spawn(character, Placement::at([0.0; 3]));
        let members = (0..MEMBERS).map(spawn).collect::<Result<Vec<_>, _>>()?;
        crowd.update(0.0)?;
        crowd.despawn(members[0])?;
        crowd.update(0.0)?;
        crowd.local_pose(members[1])?;
        Ok(())
    }
}

impl Devices {
    /// [`Device::prepare`] for each of the devices, one after the other.
    ///
    /// # Errors
    ///
    /// The first that fails.
    pub fn prepare(&self, schedule: Schedule) -> Result<(), Error> {
        self.as_slice().iter().try_for_each(|device| device.prepare(schedule))
    }
}

fn one_joint() -> Result<Arc<Character>, Error> {
    let joint = JointSource { name: "root".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint])?;
    // Devices leave out members without a palette entry.
    let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
    let (palette, name) = (skeleton.joints().map(entry).collect(), "one joint".into());
    let (parts, materials, images, skins, clips) = (vec![], vec![], vec![], vec![], vec![]);
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Ok(Arc::new(Character::new(source)?))
}
