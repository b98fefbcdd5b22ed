//! Reads of device results.

use std::sync::Arc;

use populace_device::layout::{Body, Float4};
use populace_device::{BackendError, PaletteSource, StageBuffer};
use populace_model::{Affine, Skeleton, Trs};
use populace_settings::parts::Parts;

use super::base::Base;
use super::state::State;
use super::{Crowd, JointReadback, MemberId, Watch};
use crate::{Error, IdKind, Placement};

impl Crowd {
    /// Calls `reader` with a page of palettes, three elements for each palette entry. Waits for the
    /// last update. Nothing is copied if the device shares memory with the host. Entries of members
    /// that the last update hid hold anything.
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
        Ok(PaletteSource::with_page(self, page, reader)?)
    }

    /// Returns the newest copy of a watched joint that has reached the host: of the last update on
    /// the native device, some frames old on others. `None` until an update has advanced the clock
    /// since the watch began and its result has arrived, and after the watch or the member was
    /// removed.
    ///
    /// # Errors
    ///
    /// A watch of another crowd, or a failing device.
    pub fn readback(&mut self, watch: Watch) -> Result<Option<JointReadback>, Error> {
        let State { base, readbacks, constraints, .. } = &self.state;
        base.check_crowd(IdKind::Watch, watch.member.parts().crowd, watch.serial)?;
        let fetched = self.device.backend_mut().fetched()?;
        Ok(fetched.and_then(|found| readbacks.find(base, constraints, watch, found)))
    }

    /// Updates the cached root-motion offsets from the newest readback, without a wait. After a
    /// wait for the device, they are those of the last update.
    pub(super) fn update_offsets(&mut self) -> Result<(), BackendError> {
        let State { base, motion, constraints, .. } = &mut self.state;
        if !motion.is_empty()
            && let Some((tick, elements)) = self.device.backend_mut().fetched()?
        {
            motion.update_offsets(base, constraints, tick, elements);
        }
        Ok(())
    }

    /// Returns the placement to which root motion has taken a member.
    pub(super) fn moved_placement(&mut self, member: MemberId) -> Result<Placement, Error> {
        let State { base, motion, constraints, .. } = &self.state;
        let placement = base.members.all[member.number() as usize].placement;
        let Some(state) = motion.state_of(base, constraints, member) else { return Ok(placement) };
        let elements = self.device.states(&base.tables, state.first)?;
        self.update_offsets()?;
        Ok(state.moved(placement, elements))
    }

    pub(super) fn machine_state(
        &mut self,
        member: MemberId,
        layer: usize,
    ) -> Result<Arc<str>, Error> {
        let State { base, player, .. } = &self.state;
        let instance = player.machine_on(base, member, layer)?;
        let running = self.device.running(&base.tables, instance)?;
        player.state_name(base, layer, instance, running)
    }

    pub(super) fn palette(&mut self, member: MemberId) -> Result<Vec<Affine>, Error> {
        let (row, body) = self.device_member(member)?;
        let mut elements = vec![Float4::default(); body.entry_count as usize * 3];
        let Self { state: State { base: Base { tables, .. }, .. }, device, .. } = self;
        let first = row.palette_first as usize * 3;
        tables.with_taken_over(|tables| {
            device.backend_mut().read(tables, StageBuffer::Palette, first, &mut elements)
        })?;
        self.update_offsets()?;
        Ok(elements
            .as_chunks::<3>()
            .0
            .iter()
            .map(|rows| Affine { rows: rows.map(|r| r.0) })
            .collect())
    }

    pub(super) fn model_from_joints(&mut self, member: MemberId) -> Result<Vec<Affine>, Error> {
        let buffers = [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2];
        let [a, b, c] = self.read_rows(member, buffers)?;
        let rows = a.iter().zip(&b).zip(&c);
        let mut models: Vec<_> = rows.map(|((a, b), c)| Affine { rows: [a.0, b.0, c.0] }).collect();
        let skeleton = self.skeleton_of(member)?;
        for joint in skeleton.joints().skip(models.len()) {
            // A joint beyond the first has a parent, which comes before it.
            let parent = skeleton.parent(joint).map_or(Affine::IDENTITY, |p| models[p.index()]);
            models.push(parent.mul(&Affine::from_trs(skeleton.rest(joint))));
        }
        Ok(models)
    }

    pub(super) fn local_pose(&mut self, member: MemberId) -> Result<Vec<Trs>, Error> {
        let buffers = [StageBuffer::Translations, StageBuffer::Rotations, StageBuffer::Scales];
        let [t, r, s] = self.read_rows(member, buffers)?;
        let joints = t.iter().zip(&r).zip(&s);
        let mut locals: Vec<_> = joints
            .map(|((t, r), s)| Trs { translation: t.xyz(), rotation: r.0, scale: s.xyz() })
            .collect();
        let skeleton = self.skeleton_of(member)?;
        locals.extend(skeleton.joints().skip(locals.len()).map(|joint| *skeleton.rest(joint)));
        Ok(locals)
    }

    pub(super) fn skeleton_of(&self, member: MemberId) -> Result<&Skeleton, Error> {
        let base = &self.state.base;
        Ok(&base.character_state(base.check(member)?)?.character.skeleton)
    }

    /// Reads the rows of the joints that were evaluated.
    fn read_rows(
        &mut self,
        member: MemberId,
        buffers: [StageBuffer; 3],
    ) -> Result<[Vec<Float4>; 3], Error> {
        let (row, body) = self.device_member(member)?;
        let mut arrays = [(); 3].map(|()| vec![Float4::default(); body.joint_count as usize]);
        let Self { state: State { base: Base { tables, .. }, .. }, device, .. } = self;
        tables.with_taken_over(|tables| {
            let mut all = buffers.into_iter().zip(&mut arrays);
            let first = row.joint_first as usize;
            all.try_for_each(|(buffer, array)| {
                device.backend_mut().read(tables, buffer, first, array)
            })
        })?;
        self.update_offsets()?;
        Ok(arrays)
    }

    /// Returns the device rows of a member, if the last update evaluated it.
    pub(super) fn device_member(
        &self,
        member: MemberId,
    ) -> Result<(populace_device::layout::Member, Body), Error> {
        self.state.base.check(member)?;
        self.device.check_readable()?;
        if !self.state.base.is_evaluated(member.number()) {
            return Err(BackendError::NotEvaluated.into());
        }
        // A constraint set since then may need more joints than were evaluated.
        let tables = &self.state.base.tables;
        let row = tables.member_taken_over(member.number());
        Ok((row, tables.bodies().as_slice()[row.posed as usize]))
    }
}
