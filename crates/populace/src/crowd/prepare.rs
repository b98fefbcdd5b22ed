//! Building of kernels ahead of the crowds that need them.

use std::sync::Arc;

use populace_character::{Character, CharacterSource, PaletteEntry};
use populace_device::Schedule;
use populace_model::{Affine, JointSource, Skeleton, Trs};

use super::Crowd;
use crate::{Device, Devices, Error, Placement};

/// The number of members of the trial crowd. With fewer, a table with one change is uploaded as a
/// whole and the partial upload is not built.
const MEMBERS: usize = 8;

impl Device {
    /// Builds the kernels of a schedule on this device and runs them once. A later
    /// [`move_to`](Crowd::move_to) or [`build`](crate::CrowdBuilder::build) in this process reuses
    /// them.
    ///
    /// This takes as long as the driver's compiler: seconds, the first time. On a thread of its own
    /// it leaves the crowd running elsewhere:
    ///
    /// ```
    /// use populace::{Crowd, Device};
    /// # let next = Device::native(); // in place of an OpenCL device
    /// let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// let schedule = crowd.device_info().schedule;
    /// let preparation = std::thread::spawn(move || next.prepare(schedule));
    /// while !preparation.is_finished() {
    ///     crowd.update(1.0 / 60.0)?;
    /// }
    /// preparation.join().expect("it does not panic")?;
    /// crowd.move_to(next)?;
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// User stages are not included: they are built when a crowd that has them moves. Nor is a
    /// context that shares buffers with OpenGL.
    ///
    /// # Errors
    ///
    /// A device that does not exist, cannot be opened or fails.
    pub fn prepare(self, schedule: Schedule) -> Result<(), Error> {
        let mut crowd =
            Crowd::builder().device(self).schedule(schedule).capacity(MEMBERS).build()?;
        let character = crowd.add_character(one_joint()?)?;
        let spawn = |_| crowd.spawn(character, Placement::at([0.0; 3]));
        let members = (0..MEMBERS).map(spawn).collect::<Result<Vec<_>, _>>()?;
        crowd.update(0.0)?;
        crowd.despawn(members[0])?;
        crowd.update(0.0)?;
        crowd.member_mut(members[1])?.local_pose()?;
        Ok(())
    }
}

impl Devices {
    /// Calls [`Device::prepare`] for each device, one after the other.
    ///
    /// # Errors
    ///
    /// The error of the first device that fails.
    pub fn prepare(&self, schedule: Schedule) -> Result<(), Error> {
        self.as_slice().iter().try_for_each(|device| device.prepare(schedule))
    }
}

fn one_joint() -> Result<Arc<Character>, Error> {
    let joint = JointSource { name: "root".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint])?;
    // Devices skip members without a palette entry.
    let entry = |joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY };
    let (palette, name) = (skeleton.joints().map(entry).collect(), "one joint".into());
    let (parts, materials, images, skins, clips) = (vec![], vec![], vec![], vec![], vec![]);
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Ok(Arc::new(Character::new(source)?))
}
