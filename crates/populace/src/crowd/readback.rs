//! Reads of device results.

use populace_device::layout::{Body, Float4};
use populace_device::{BackendError, Stage, StageBuffer};
use populace_model::{Affine, Trs};

use super::{Crowd, MemberId};
use crate::Error;

impl Crowd {
    /// Calls `reader` with a page of palettes, three elements for each palette entry. Waits for the
    /// last update. Nothing is copied if the device shares memory with the host.
    ///
    /// # Errors
    ///
    /// [`BackendError::NotEvaluated`] if no update has evaluated the crowd on this device, a page
    /// that is not in use, or a failing device.
    pub fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), Error> {
        self.check_readable()?;
        self.opened.backend_mut().with_page(page, reader)?;
        Ok(self.update_moved()?)
    }

    pub(super) fn palette(&mut self, member: MemberId) -> Result<Vec<Affine>, Error> {
        let (row, body) = self.device_member(member)?;
        let mut elements = vec![Float4::default(); body.entry_count as usize * 3];
        let Self { tables, opened, .. } = self;
        let first = row.palette_first as usize * 3;
        tables.with_taken_over(|tables| {
            opened.backend_mut().read(tables, StageBuffer::Palette, first, &mut elements)
        })?;
        Ok(elements
            .as_chunks::<3>()
            .0
            .iter()
            .map(|rows| Affine { rows: rows.map(|r| r.0) })
            .collect())
    }

    pub(super) fn model_from_joints(&mut self, member: MemberId) -> Result<Vec<Affine>, Error> {
        let buffers = [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2];
        let [a, b, c] = self.read_joints(member, buffers)?;
        Ok(a.iter().zip(&b).zip(&c).map(|((a, b), c)| Affine { rows: [a.0, b.0, c.0] }).collect())
    }

    pub(super) fn local_pose(&mut self, member: MemberId) -> Result<Vec<Trs>, Error> {
        let buffers = [StageBuffer::Translations, StageBuffer::Rotations, StageBuffer::Scales];
        let [t, r, s] = self.read_joints(member, buffers)?;
        let joints = t.iter().zip(&r).zip(&s);
        Ok(joints
            .map(|((t, r), s)| Trs { translation: t.xyz(), rotation: r.0, scale: s.xyz() })
            .collect())
    }

    /// The milliseconds that the last update took on the device, if it has finished and the device
    /// measures time.
    pub fn frame_time_ms(&mut self) -> Option<f64> {
        self.opened.backend_mut().frame_time_ms()
    }

    /// The milliseconds that each stage of the last update took on the device, if the schedule has
    /// stages and the device measures time.
    pub fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        self.opened.backend_mut().stage_times_ms()
    }

    /// Fills every palette with a constant and returns the milliseconds that it took: the lower
    /// bound of an update, for benchmarks. The palettes are wrong until the next update.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn write_floor(&mut self) -> Result<f64, Error> {
        Ok(self.opened.backend_mut().write_floor(&self.tables)?)
    }

    /// The bytes that the device has allocated for this crowd.
    #[must_use]
    pub fn device_memory_bytes(&self) -> usize {
        self.opened.backend().memory_bytes()
    }

    fn read_joints(
        &mut self,
        member: MemberId,
        buffers: [StageBuffer; 3],
    ) -> Result<[Vec<Float4>; 3], Error> {
        let (row, body) = self.device_member(member)?;
        let mut arrays = [(); 3].map(|()| vec![Float4::default(); body.joint_count as usize]);
        let Self { tables, opened, .. } = self;
        tables.with_taken_over(|tables| {
            let mut all = buffers.into_iter().zip(&mut arrays);
            let first = row.joint_first as usize;
            all.try_for_each(|(buffer, array)| {
                opened.backend_mut().read(tables, buffer, first, array)
            })
        })?;
        Ok(arrays)
    }

    /// Returns the device rows of a member, if it was present at the last update.
    fn device_member(
        &self,
        member: MemberId,
    ) -> Result<(populace_device::layout::Member, Body), Error> {
        self.check(member)?;
        self.check_readable()?;
        if self.members[member.index as usize].since == self.frame {
            return Err(BackendError::NotEvaluated.into());
        }
        let row = self.tables.members().as_slice()[member.index as usize];
        Ok((row, self.tables.bodies().as_slice()[row.body as usize]))
    }
}
