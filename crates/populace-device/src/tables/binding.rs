//! Clips bound to bodies: the ranges and the column of each joint, and retarget corrections.

use populace_model::convert::u32_from;
use populace_retarget::{Binding, Correction, FootCorrection};

use super::runs::{Asset, Runs};
use super::{BodyIndex, Tables, padded};
use crate::Error;
use crate::layout::{
    BLOCK_CORRECTED, BLOCK_STRAIGHT, Body, BoundBlock, BoundClip, CORRECTION_PLANES, Contact,
    JOINT_BLOCK, MAP_COLUMN, MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION, NONE, RANGE_PLANES,
    REST_SCALE, REST_TRANSLATION, RowBlock, Source,
};

/// For each block of 16 joints of a body: whether a joint of it has a rotation or an arm in a
/// correction or in any later one.
struct CorrectedBlocks {
    corrections: Vec<bool>,
    arms: Vec<bool>,
}

impl CorrectedBlocks {
    fn none(body: &Body) -> Self {
        let blocks = vec![false; (body.padded_count / JOINT_BLOCK) as usize];
        Self { corrections: blocks.clone(), arms: blocks }
    }

    fn of(corrections: &[Correction], body: &Body) -> Self {
        let mut some = Self::none(body);
        for (joint, correction) in corrections.iter().enumerate() {
            let block = joint / JOINT_BLOCK as usize;
            some.corrections[block] |= *correction != Correction::NONE;
            some.arms[block] |= correction.has_arm();
        }
        some
    }

    fn or(&self, other: &Self) -> Self {
        let either = |a: &[bool], b: &[bool]| a.iter().zip(b).map(|(a, b)| a | b).collect();
        Self {
            corrections: either(&self.corrections, &other.corrections),
            arms: either(&self.arms, &other.arms),
        }
    }
}

impl Tables {
    /// Binds a clip to a body and returns the index of the bound clip, for use in slots.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits; [`Error::BadPlayback`] if the clip or body
    /// does not exist or the binding is for another skeleton.
    pub fn add_bound_clip(
        &mut self,
        clip: u32,
        body: BodyIndex,
        binding: &Binding,
    ) -> Result<u32, Error> {
        let joints =
            self.all.bodies.as_slice().get(body.0 as usize).map(|b| b.joint_count as usize);
        if clip as usize >= self.all.clips.len() || joints != Some(binding.joint_map().len()) {
            return Err(Error::BadPlayback { what: "clip or body to bind", value: clip });
        }
        self.add_asset(Asset::BoundClip, |tables, runs| tables.bind(clip, body, binding, runs))
    }

    /// Sets the contacts of a bound clip, in place of those that it had.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the bound clip does not exist; [`Error::TooLarge`] if offsets
    /// exceed 32 bits.
    pub fn set_contacts(&mut self, bound: u32, contacts: &[Contact]) -> Result<(), Error> {
        let row = self.all.bound_clips.as_slice().get(bound as usize).copied();
        let unknown = Error::BadPlayback { what: "bound clip", value: bound };
        let row = row.filter(|row| row.body != NONE).ok_or(unknown)?;
        let mut runs = Runs::default();
        let contact_first = runs.add(&mut self.all.contacts, contacts.iter().copied())?;
        self.release_contacts(bound);
        self.asset_runs.insert((Asset::Contacts, bound), runs);
        let row = BoundClip { contact_first, contact_count: u32_from(contacts.len()), ..row };
        self.all.bound_clips.set(bound as usize, row);
        Ok(())
    }

    /// Frees the contacts of a bound clip.
    pub(super) fn release_contacts(&mut self, bound: u32) {
        if let Some(runs) = self.asset_runs.remove(&(Asset::Contacts, bound)) {
            runs.release(&mut self.all);
        }
    }

    fn bind(
        &mut self,
        clip: u32,
        body: BodyIndex,
        binding: &Binding,
        runs: &mut Runs,
    ) -> Result<u32, Error> {
        let body_row = self.all.bodies.as_slice()[body.0 as usize];
        let row_block_first = self.all.clips.as_slice()[clip as usize].block_first;
        let of_clip =
            BoundClip { clip, row_block_first, body: NONE, next: NONE, ..BoundClip::default() };
        // Corrections are added last to first, so that each can name the next.
        let (mut next, mut later) = (NONE, CorrectedBlocks::none(&body_row));
        if let Some(foot_correction) = binding.foot_correction() {
            let bound = self.add_foot_correction(foot_correction, of_clip, runs)?;
            let corrections = &foot_correction.corrections;
            (next, later) =
                self.add_correction(corrections, bound, (next, later), &body_row, runs)?;
        }
        for corrections in binding.corrections().iter().rev() {
            (next, later) =
                self.add_correction(corrections, of_clip, (next, later), &body_row, runs)?;
        }
        let range_first = runs.add(&mut self.all.poses, range_planes(binding))?;
        let first_joints = (0..body_row.padded_count as usize).step_by(JOINT_BLOCK as usize);
        let flags = first_joints.zip(later.corrections.iter().zip(&later.arms)).map(
            |(first, (corrected, arms))| {
                let moved = u32::from(*arms) * REST_TRANSLATION;
                (self.rest_flags(&body_row, range_first, first) & !moved)
                    | (u32::from(*corrected) * BLOCK_CORRECTED)
            },
        );
        let flags = flags.collect();
        let motion_scale = binding.motion_scale();
        let bound = BoundClip { range_first, body: body.0, next, motion_scale, ..of_clip };
        self.add_bound(bound, binding.joint_map(), flags, runs)
    }

    /// Adds a bound clip or a correction of one, with its joint map and blocks. `flags` holds the
    /// flags of each block.
    fn add_bound(
        &mut self,
        bound: BoundClip,
        map: &[u32],
        flags: Vec<u32>,
        runs: &mut Runs,
    ) -> Result<u32, Error> {
        let map_first = runs.add(&mut self.all.joint_maps, map.iter().copied())?;
        let mut blocks = Vec::with_capacity(flags.len());
        for (block, flags) in flags.into_iter().enumerate() {
            let first = (block * JOINT_BLOCK as usize).min(map.len());
            let last = map.len().min(first + JOINT_BLOCK as usize);
            blocks.push(self.bind_block(bound.row_block_first, &map[first..last], flags, runs)?);
        }
        let block_first = runs.add(&mut self.all.bound_blocks, blocks)?;
        runs.add(&mut self.all.bound_clips, [BoundClip { map_first, block_first, ..bound }])
    }

    /// Adds a correction of the clip `of` in front of `next`. Returns its index and the blocks that
    /// it or a later correction affects.
    fn add_correction(
        &mut self,
        corrections: &[Correction],
        of: BoundClip,
        (next, later): (u32, CorrectedBlocks),
        body: &Body,
        runs: &mut Runs,
    ) -> Result<(u32, CorrectedBlocks), Error> {
        let map: Vec<u32> = corrections.iter().map(|correction| correction.map).collect();
        let range_first = runs.add(&mut self.all.poses, correction_planes(corrections))?;
        let own = CorrectedBlocks::of(corrections, body);
        let flags = own.arms.iter().zip(&later.corrections).map(|(arms, corrected)| {
            let still = if *arms { 0 } else { REST_TRANSLATION };
            still | (u32::from(*corrected) * BLOCK_CORRECTED)
        });
        let index =
            self.add_bound(BoundClip { range_first, next, ..of }, &map, flags.collect(), runs)?;
        Ok((index, later.or(&own)))
    }

    /// Adds the rows of a foot correction. A constant correction has no rows of its own.
    fn add_foot_correction(
        &mut self,
        foot_correction: &FootCorrection,
        of: BoundClip,
        runs: &mut Runs,
    ) -> Result<BoundClip, Error> {
        let FootCorrection { rows, blocks, stride, .. } = foot_correction;
        if rows.is_empty() {
            return Ok(of);
        }
        let row_first = self.add_words(rows.iter().copied(), runs)?;
        let row_block_first = runs.add(&mut self.all.row_blocks, blocks.iter().copied())?;
        Ok(BoundClip { row_block_first, row_first, row_stride: u32_from(*stride), ..of })
    }

    /// Builds the location of the columns that 16 joints follow. `blocks` is the offset of the
    /// clip's first block.
    fn bind_block(
        &mut self,
        blocks: u32,
        maps: &[u32],
        flags: u32,
        runs: &mut Runs,
    ) -> Result<BoundBlock, Error> {
        const BLOCK: usize = JOINT_BLOCK as usize;
        let moves = MAP_ROTATION | MAP_TRANSLATION | MAP_SCALE;
        let mut sources: Vec<(u32, [u32; BLOCK])> = Vec::new();
        for (lane, map) in maps.iter().enumerate().filter(|(_, map)| **map & moves != 0) {
            let column = map & MAP_COLUMN;
            let (block, from) = (column / JOINT_BLOCK, column % JOINT_BLOCK);
            let at = sources.iter().position(|(known, _)| *known == block).unwrap_or_else(|| {
                sources.push((block, [NONE; BLOCK]));
                sources.len() - 1
            });
            sources[at].1[lane] = from;
        }
        let own_lane = |(lane, from): (u32, &u32)| *from == NONE || *from == lane;
        let straight = sources.len() == 1 && (0..).zip(&sources[0].1).all(own_lane);
        let mut rows_of = Vec::with_capacity(sources.len());
        for (block, lanes) in &sources {
            let lanes_first = runs.add(&mut self.all.source_lanes, lanes.iter().copied())?;
            rows_of.push(Source { block: blocks + block, lanes_first });
        }
        let source_first = runs.add(&mut self.all.sources, rows_of)?;
        let mut rows = RowBlock::STILL;
        for (block, _) in &sources {
            let source = self.all.row_blocks.as_slice()[(blocks + block) as usize];
            rows = if straight { source } else { rows.or_moving(&source) };
        }
        let straight = if straight { BLOCK_STRAIGHT } else { 0 };
        Ok(BoundBlock {
            rotation_first: rows.rotation_first,
            rotation_lanes: rows.rotation_lanes,
            translation_first: rows.translation_first,
            translation_lanes: rows.translation_lanes,
            scale_first: rows.scale_first,
            scale_lanes: rows.scale_lanes,
            flags: straight | flags,
            source_first,
            source_count: u32_from(sources.len()),
        })
    }

    /// Returns flags that tell whether the translations and scales of 16 joints from `first` on
    /// equal those of the body's rest.
    fn rest_flags(&self, body: &Body, range_first: u32, first: usize) -> u32 {
        let (padded, joints) = (body.padded_count as usize, first..first + JOINT_BLOCK as usize);
        let poses = self.all.poses.as_slice();
        let plane = |table: u32, plane: usize| {
            let start = table as usize + plane * padded;
            &poses[start + joints.start..start + joints.end]
        };
        let same = |range_plane: usize, rest_plane: usize| {
            let offsets = (0..3).all(|c| {
                plane(range_first, range_plane + c) == plane(body.rest_first, rest_plane + c)
            });
            offsets && plane(range_first, range_plane + 3).iter().all(|&step| step == 0.0)
        };
        (u32::from(same(5, 4)) * REST_TRANSLATION) | (u32::from(same(9, 7)) * REST_SCALE)
    }
}

fn correction_planes(corrections: &[Correction]) -> Vec<f32> {
    let padded = padded(corrections.len());
    let mut planes = vec![0.0; CORRECTION_PLANES * padded];
    for joint in 0..padded {
        let Correction { rotation, step_w, arm, after, .. } =
            corrections.get(joint).copied().unwrap_or(Correction::NONE);
        let ([qx, qy, qz, qw], [tx, ty, tz, _], [ax, ay, az, aw]) =
            (rotation.offset, arm.offset, after);
        let values = [qx, qy, qz, qw, rotation.step, step_w, tx, ty, tz, arm.step, ax, ay, az, aw];
        for (plane, value) in values.into_iter().enumerate() {
            planes[plane * padded + joint] = value;
        }
    }
    planes
}

fn range_planes(binding: &Binding) -> Vec<f32> {
    let padded = padded(binding.ranges().len());
    let mut planes = vec![0.0; RANGE_PLANES * padded];
    for (joint, [translation, rotation, scale]) in binding.ranges().iter().enumerate() {
        let ([qx, qy, qz, qw], [tx, ty, tz, _], [sx, sy, sz, _]) =
            (rotation.offset, translation.offset, scale.offset);
        let (q, t, s) = (rotation.step, translation.step, scale.step);
        for (plane, value) in
            [qx, qy, qz, qw, q, tx, ty, tz, t, sx, sy, sz, s].into_iter().enumerate()
        {
            planes[plane * padded + joint] = value;
        }
    }
    planes
}
