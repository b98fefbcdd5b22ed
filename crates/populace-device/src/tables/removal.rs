//! Removal of bodies, clips, bound clips, machine states, masks and length factors. Their elements
//! are free for others afterwards.

use super::runs::{Asset, Runs};
use super::{BodyIndex, Tables};
use crate::Error;
use crate::layout::{Body, BoundClip, ClipRows, MachineState, NONE};

impl Tables {
    /// Adds an asset with all its runs. Nothing is added on an error.
    pub(super) fn add_asset(
        &mut self,
        asset: Asset,
        add: impl FnOnce(&mut Self, &mut Runs) -> Result<u32, Error>,
    ) -> Result<u32, Error> {
        let mut runs = Runs::default();
        match add(self, &mut runs) {
            Ok(index) => {
                self.asset_runs.insert((asset, index), runs);
                Ok(index)
            }
            Err(error) => {
                runs.release(&mut self.all);
                Err(error)
            }
        }
    }

    fn remove_asset(
        &mut self,
        asset: Asset,
        index: u32,
        mark_free: impl FnOnce(&mut Self),
    ) -> Result<(), Error> {
        let unknown = Error::BadPlayback { what: "asset to remove", value: index };
        let runs = self.asset_runs.remove(&(asset, index)).ok_or(unknown)?;
        mark_free(self);
        runs.release(&mut self.all);
        Ok(())
    }

    /// Removes a body. No member, bound clip or machine state may refer to it.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the body does not exist.
    pub fn remove_body(&mut self, body: BodyIndex) -> Result<(), Error> {
        let name = self.all.bodies.name();
        let rows = self.asset_runs.get(&(Asset::Body, body.0)).and_then(|runs| runs.of(name));
        self.remove_asset(Asset::Body, body.0, |tables| {
            // The body, and its reduced bodies after it.
            for row in rows.into_iter().flatten() {
                tables.all.bodies.set(row, Body::default());
            }
        })?;
        self.soles_of_bodies.remove(&body.0);
        self.measure_levels();
        Ok(())
    }

    /// Removes a clip. No bound clip may refer to it.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the clip does not exist.
    pub fn remove_clip(&mut self, clip: u32) -> Result<(), Error> {
        self.remove_asset(Asset::Clip, clip, |tables| {
            tables.all.clips.set(clip as usize, ClipRows::default());
            tables.live_clips.remove(&clip);
        })
    }

    /// Removes a bound clip. No slot or machine state may refer to it.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the bound clip does not exist.
    pub fn remove_bound_clip(&mut self, bound: u32) -> Result<(), Error> {
        self.release_contacts(bound);
        self.remove_asset(Asset::BoundClip, bound, |tables| {
            let free = BoundClip { body: NONE, ..BoundClip::default() };
            let BoundClip { clip, rows, .. } = tables.all.bound_clips.as_slice()[bound as usize];
            if rows != clip {
                tables.all.clips.set(rows as usize, ClipRows::default());
                tables.forget_follower(clip, bound);
            }
            tables.all.bound_clips.set(bound as usize, free);
        })
    }

    /// Removes the machine states that [`add_states`](Self::add_states) returned. No machine
    /// instance may refer to them.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if no states begin at `first`.
    pub fn remove_states(&mut self, first: u32) -> Result<(), Error> {
        self.remove_asset(Asset::States, first, |tables| {
            let free = MachineState { bound_clip: NONE, ..MachineState::default() };
            tables.all.machine_states.set(first as usize, free);
        })
    }

    /// Removes a mask. No layer may refer to it.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if no mask begins at `first`.
    pub fn remove_mask(&mut self, first: u32) -> Result<(), Error> {
        self.remove_asset(Asset::Mask, first, |_| {})
    }

    /// Removes the length factors of a body. No member may use them.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if no factors begin at `first`.
    pub fn remove_joint_scales(&mut self, first: u32) -> Result<(), Error> {
        self.remove_asset(Asset::JointScales, first, |_| {})
    }

    /// Measures the widest level of any body, by depth.
    pub(super) fn measure_levels(&mut self) {
        self.level_widths.clear();
        for body in self.all.bodies.as_slice() {
            let first = body.level_first as usize;
            let last = first + body.level_count as usize;
            let starts = self.all.levels.as_slice().get(first..=last).unwrap_or_default();
            let widths = &mut self.level_widths;
            widths.resize(widths.len().max(body.level_count as usize), 0);
            for (widest, level) in widths.iter_mut().zip(starts.windows(2)) {
                *widest = (*widest).max((level[1] - level[0]) as usize);
            }
        }
    }
}
