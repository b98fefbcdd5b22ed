//! Building of kernels ahead of the crowds that need them.

use populace_character::PaletteEntry;
use populace_clip::FIRST_TICK;
use populace_device::layout::Float4;
use populace_device::{Backend, Frame, Schedule, StageBuffer, Tables};
use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

use crate::device::Device;
use crate::devices::Devices;
use crate::error::Error;

/// The number of members of the trial crowd. With fewer, a table with one change is uploaded as a
/// whole and the partial upload is not built.
const MEMBERS: usize = 8;

impl Device {
    /// Builds the kernels of a schedule on this device and runs them once. A later crowd of this
    /// process that is built on it or moves to it uses them again.
    ///
    /// This takes as long as the driver's compiler: seconds, the first time. On a thread of its own
    /// it leaves a crowd running elsewhere:
    ///
    /// ```
    /// # use populace_backends::Device;
    /// # use populace_device::Schedule;
    /// # let next = Device::native(); // in place of an OpenCL device
    /// let preparation = std::thread::spawn(move || next.prepare(Schedule::Fused));
    /// while !preparation.is_finished() {
    ///     // Here the crowd is updated on the device that it has.
    /// }
    /// preparation.join().expect("it does not panic")?;
    /// // Now the crowd moves, without a wait.
    /// # Ok::<(), populace_backends::Error>(())
    /// ```
    ///
    /// User stages are not included: they are built when a crowd that has them moves. Nor is a
    /// context that shares buffers with OpenGL.
    ///
    /// # Errors
    ///
    /// A device that does not exist, cannot be opened or fails.
    pub fn prepare(self, schedule: Schedule) -> Result<(), Error> {
        let mut opened = self.open(schedule, None)?;
        try_out(opened.backend_mut())
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

/// Runs frames of a small crowd, with a removal between them, and reads a member.
fn try_out(backend: &mut dyn Backend) -> Result<(), Error> {
    let mut tables = Tables::with_capacity(4, MEMBERS);
    let joint = JointSource { name: "root".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint])?;
    // Devices skip members without a palette entry.
    let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
    let body = tables.add_body(&skeleton, &[entry])?;
    let members: Vec<u32> =
        (0..MEMBERS).map(|_| tables.add_member(body)).collect::<Result<_, _>>()?;
    for removed in [None, Some(members[0])] {
        if let Some(member) = removed {
            tables.remove_member(member);
        }
        backend.update(&tables)?;
        tables.mark_clean();
        backend.run(&tables, Frame::of_all(FIRST_TICK))?;
    }
    let first = tables.members().as_slice()[members[1] as usize].joint_first as usize;
    let mut joint = [Float4::default(); 1];
    Ok(backend.read(&tables, StageBuffer::Translations, first, &mut joint)?)
}
