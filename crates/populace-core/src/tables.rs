//! The tables that devices evaluate: templates shared by all members, and the members themselves.

mod set;
mod space;

use std::ops::Range;

use crate::clip::Binding;
use crate::layout::{
    Body, BoundClip, ClipRows, Entry, Float4, JOINT_BLOCK, LAYER_MASK, LAYERS_PER_MEMBER, Layer, Member,
    NONE, PAGE_ENTRIES, PALETTE_BLOCK, POSE_PLANES, SLOT_LOOP, Slot,
};
use crate::{Clip, Error, MAX_SLOTS, Mask, PaletteEntry, Skeleton, Trs};
use set::TableSet;
use space::Space;

/// A growing array whose changes since the last look are known.
#[derive(Clone, Debug)]
pub struct Table<T> {
    name: &'static str,
    data: Vec<T>,
    dirty: Range<usize>,
}

impl<T: bytemuck::Pod> Table<T> {
    fn new(name: &'static str) -> Self {
        Self { name, data: Vec::new(), dirty: 0..0 }
    }

    /// The table's name, for errors.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// All elements.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.data
    }

    /// The range of elements that changed since [`Tables::mark_clean`].
    #[must_use]
    pub fn dirty(&self) -> Range<usize> {
        self.dirty.clone()
    }

    fn set(&mut self, index: usize, value: T) {
        self.data[index] = value;
        self.touch(index..index + 1);
    }

    fn touch(&mut self, range: Range<usize>) {
        self.dirty = if self.dirty.is_empty() {
            range
        } else {
            self.dirty.start.min(range.start)..self.dirty.end.max(range.end)
        };
    }

    fn extend(&mut self, values: impl IntoIterator<Item = T>) -> Result<u32, Error> {
        const LIMIT: usize = NONE as usize;
        let first = self.data.len();
        self.data.extend(values);
        let count = self.data.len();
        if count > LIMIT {
            self.data.truncate(first);
            return Err(Error::TooLarge { what: self.name, count, limit: LIMIT });
        }
        self.touch(first..count);
        Ok(u32_from(first))
    }

    fn resize(&mut self, count: usize, value: T) {
        let first = self.data.len();
        self.data.resize(count, value);
        if count > first {
            self.touch(first..count);
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "tables refuse to grow past 32 bits")]
fn u32_from(index: usize) -> u32 {
    debug_assert!(index <= u32::MAX as usize);
    index as u32
}

/// Index of a body (a skeleton with its palette entries) in [`Tables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyIndex(pub u32);

/// All that a device needs to evaluate a crowd. The host's copy is the truth; devices take over what changed.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Slots of each member, 1 to [`MAX_SLOTS`].
    slots_per_member: usize,
    all: TableSet,
    free_members: Vec<u32>,
    joint_space: Space,
    palette_space: Space,
}

impl Tables {
    /// Empty tables for members of `slots_per_member` slots, held to 1 to [`MAX_SLOTS`].
    #[must_use]
    pub fn new(slots_per_member: usize) -> Self {
        Self {
            slots_per_member: slots_per_member.clamp(1, MAX_SLOTS),
            all: TableSet::new(),
            free_members: Vec::new(),
            joint_space: Space::new(usize::MAX),
            palette_space: Space::new((PAGE_ENTRIES / PALETTE_BLOCK) as usize),
        }
    }

    /// Slots of each member.
    #[must_use]
    pub fn slots_per_member(&self) -> usize {
        self.slots_per_member
    }

    /// Places for members, taken or free.
    #[must_use]
    pub fn member_places(&self) -> usize {
        self.all.members.data.len()
    }

    /// Elements of the joint buffer, padding and free places included.
    #[must_use]
    pub fn joint_places(&self) -> usize {
        self.all.joint_blocks.data.len() * JOINT_BLOCK as usize
    }

    /// Palette entries over all pages, up to the last in use.
    #[must_use]
    pub fn palette_places(&self) -> usize {
        self.all.palette_blocks.data.len() * PALETTE_BLOCK as usize
    }

    /// The palette entries of each page: all but the last are [`PAGE_ENTRIES`] long.
    #[must_use]
    pub fn page_lengths(&self) -> Vec<usize> {
        let total = self.palette_places();
        let page = PAGE_ENTRIES as usize;
        (0..total.div_ceil(page)).map(|p| (total - p * page).min(page)).collect()
    }

    /// The widest level of any body at each depth.
    #[must_use]
    pub fn level_widths(&self) -> Vec<usize> {
        let mut widths = Vec::new();
        for body in self.all.bodies.as_slice() {
            let first = body.level_first as usize;
            let ends = &self.all.levels.data[first..=first + body.level_count as usize];
            for (depth, level) in ends.windows(2).enumerate() {
                widths.resize(widths.len().max(depth + 1), 0);
                widths[depth] = widths[depth].max((level[1] - level[0]) as usize);
            }
        }
        widths
    }

    /// Adds a body.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets, or a palette larger than a page.
    pub fn add_body(&mut self, skeleton: &Skeleton, palette: &[PaletteEntry]) -> Result<BodyIndex, Error> {
        if palette.len() > PAGE_ENTRIES as usize {
            let limit = PAGE_ENTRIES as usize;
            return Err(Error::TooLarge { what: "one character's palette", count: palette.len(), limit });
        }
        let joint_first =
            self.all.parents.extend(skeleton.joints().map(|j| skeleton.parent(j).map_or(NONE, |p| p.0)))?;
        let levels = skeleton.levels();
        let starts = levels.iter().map(|l| l.start).chain([skeleton.joint_count()]);
        let level_first = self.all.levels.extend(starts.map(u32_from))?;
        let rest: Vec<Trs> = skeleton.joints().map(|j| *skeleton.rest(j)).collect();
        let rest_first = self.add_pose(&rest)?;
        let entry_first = self.all.entries.extend(palette.iter().map(device_entry))?;
        let index = self.all.bodies.extend([Body {
            joint_first,
            joint_count: u32_from(skeleton.joint_count()),
            padded_count: u32_from(padded(skeleton.joint_count())),
            level_first,
            level_count: u32_from(levels.len()),
            rest_first,
            entry_first,
            entry_count: u32_from(palette.len()),
        }])?;
        Ok(BodyIndex(index))
    }

    fn add_pose(&mut self, pose: &[Trs]) -> Result<u32, Error> {
        let mut planes = vec![0.0; POSE_PLANES * padded(pose.len())];
        for (plane, values) in planes.chunks_mut(padded(pose.len())).enumerate() {
            for (value, trs) in values.iter_mut().zip(pose) {
                *value = match plane {
                    0..4 => trs.rotation[plane],
                    4..7 => trs.translation[plane - 4],
                    _ => trs.scale[plane - 7],
                };
            }
        }
        self.all.poses.extend(planes)
    }

    /// Adds a clip's rows and returns its index.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets.
    pub fn add_clip(&mut self, clip: &Clip) -> Result<u32, Error> {
        let row_first = self.all.rows.extend(clip.rows().iter().copied())?;
        let block_first = self.all.block_offsets.extend(clip.block_offsets().iter().copied())?;
        let (buckets, buckets_per_sec) = clip.buckets();
        let times = if buckets.is_empty() { &[] } else { clip.row_times() };
        let time_first = self.all.row_times.extend(times.iter().copied())?;
        let bucket_first = self.all.buckets.extend(buckets.iter().copied())?;
        self.all.clips.extend([ClipRows {
            row_first,
            row_stride: u32_from(clip.row_stride()),
            row_count: u32_from(clip.row_count()),
            block_first,
            time_first,
            bucket_first,
            bucket_count: u32_from(buckets.len()),
            buckets_per_sec,
            start_secs: clip.start_secs(),
            duration_secs: clip.duration_secs(),
            rows_per_sec: clip.rows_per_sec(),
            unused: 0,
        }])
    }

    /// Binds a clip to a body and returns the index that slots name.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets; [`Error::BadPlayback`] for a clip or body that is not there, or a
    /// binding to another skeleton.
    pub fn add_bound_clip(&mut self, clip: u32, body: BodyIndex, binding: &Binding) -> Result<u32, Error> {
        let joints = self.all.bodies.data.get(body.0 as usize).map(|b| b.joint_count as usize);
        if clip as usize >= self.all.clips.data.len() || joints != Some(binding.joint_map().len()) {
            return Err(Error::BadPlayback { what: "clip or body to bind", value: clip });
        }
        let map_first = self.all.joint_maps.extend(binding.joint_map().iter().copied())?;
        let base_first = self.add_pose(binding.base_pose())?;
        self.all.bound_clips.extend([BoundClip { clip, map_first, base_first, body: body.0 }])
    }

    /// Adds a mask and returns the offset that layers name.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 31-bit offsets.
    pub fn add_mask(&mut self, mask: &Mask) -> Result<u32, Error> {
        let (count, limit) = (self.all.masks.data.len() + mask.weights().len(), LAYER_MASK as usize);
        if count > limit {
            return Err(Error::TooLarge { what: "the masks", count, limit });
        }
        self.all.masks.extend(mask.weights().iter().copied())
    }

    /// Gives a member of a body a place, without any clip; returns the place.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets.
    ///
    /// # Panics
    ///
    /// If the body does not exist.
    pub fn add_member(&mut self, body: BodyIndex) -> Result<u32, Error> {
        let Body { padded_count, entry_count, .. } = self.all.bodies.data[body.0 as usize];
        let blocks = (padded_count / JOINT_BLOCK) as usize;
        for (what, count, limit) in [
            ("the joint buffer", self.joint_space.end_with(blocks), NONE / JOINT_BLOCK),
            (
                "the palettes",
                self.palette_space.end_with(palette_block_count(entry_count)),
                NONE / PALETTE_BLOCK,
            ),
        ] {
            if count > limit as usize {
                return Err(Error::TooLarge { what, count, limit: limit as usize });
            }
        }
        let place = match self.free_members.pop() {
            Some(place) => place,
            None => self.all.members.extend([Member { body: NONE, ..Member::default() }])?,
        };
        self.all.slots.resize(self.member_places() * self.slots_per_member, EMPTY_SLOT);
        self.all.layers.resize(self.member_places() * LAYERS_PER_MEMBER as usize, PLAIN_LAYER);
        let joint_block = self.joint_space.take(blocks);
        let palette_block = self.palette_space.take(palette_block_count(entry_count));
        fill(&mut self.all.joint_blocks, joint_block, place);
        fill(&mut self.all.palette_blocks, palette_block, place);
        self.reset_playback(place);
        self.all.members.set(
            place as usize,
            Member {
                body: body.0,
                joint_first: u32_from(joint_block.0 * JOINT_BLOCK as usize),
                palette_first: u32_from(palette_block.0 * PALETTE_BLOCK as usize),
                layer_count: 1,
            },
        );
        Ok(place)
    }

    /// Frees a member's place.
    ///
    /// # Panics
    ///
    /// If the place is not taken.
    pub fn remove_member(&mut self, place: u32) {
        let member = self.all.members.data[place as usize];
        let Body { padded_count, entry_count, .. } = self.all.bodies.data[member.body as usize];
        let joints = ((member.joint_first / JOINT_BLOCK) as usize, (padded_count / JOINT_BLOCK) as usize);
        let palette = ((member.palette_first / PALETTE_BLOCK) as usize, palette_block_count(entry_count));
        fill(&mut self.all.joint_blocks, joints, NONE);
        fill(&mut self.all.palette_blocks, palette, NONE);
        self.joint_space.give_back(joints);
        self.palette_space.give_back(palette);
        self.reset_playback(place);
        self.all.members.set(place as usize, Member { body: NONE, ..Member::default() });
        self.free_members.push(place);
    }

    fn reset_playback(&mut self, place: u32) {
        for slot in self.slot_range(place) {
            self.all.slots.set(slot, EMPTY_SLOT);
        }
        for layer in self.layer_range(place) {
            self.all.layers.set(layer, PLAIN_LAYER);
        }
    }

    /// Replaces one of a member's slots.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for a place without a member, a slot that there is not, a layer past the last, or a clip
    /// that is not bound to the member's body.
    pub fn set_slot(&mut self, place: u32, index: usize, slot: Slot) -> Result<(), Error> {
        let member = self.taken(place)?;
        let bad = |what: &'static str, value: u32| Err(Error::BadPlayback { what, value });
        if index >= self.slots_per_member {
            return bad("slot", u32::try_from(index).unwrap_or(NONE));
        }
        if slot.layer() >= LAYERS_PER_MEMBER {
            return bad("layer", slot.layer());
        }
        let bound = self.all.bound_clips.data.get(slot.bound_clip as usize);
        if slot.bound_clip != NONE && bound.is_none_or(|bound| bound.body != member.body) {
            return bad("bound clip", slot.bound_clip);
        }
        self.all.slots.set(place as usize * self.slots_per_member + index, slot);
        self.use_layer(place, slot.layer());
        Ok(())
    }

    /// Replaces one of a member's layers.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] for a place without a member, a layer past the last, or a mask that is not there.
    pub fn set_layer(&mut self, place: u32, index: usize, layer: Layer) -> Result<(), Error> {
        let member = self.taken(place)?;
        let joints = self.all.bodies.data[member.body as usize].joint_count as usize;
        let layer_index = u32::try_from(index).unwrap_or(NONE);
        if layer_index >= LAYERS_PER_MEMBER {
            return Err(Error::BadPlayback { what: "layer", value: layer_index });
        }
        if let Some(first) = layer.mask().filter(|m| *m as usize + joints > self.all.masks.data.len()) {
            return Err(Error::BadPlayback { what: "mask", value: first });
        }
        self.all.layers.set(place as usize * LAYERS_PER_MEMBER as usize + index, layer);
        self.use_layer(place, layer_index);
        Ok(())
    }

    fn taken(&self, place: u32) -> Result<Member, Error> {
        let member = self.all.members.data.get(place as usize).filter(|m| m.body != NONE);
        member.copied().ok_or(Error::BadPlayback { what: "member", value: place })
    }

    fn use_layer(&mut self, place: u32, layer: u32) {
        let mut member = self.all.members.data[place as usize];
        if member.layer_count <= layer {
            member.layer_count = layer + 1;
            self.all.members.set(place as usize, member);
        }
    }

    /// Where a member's slots stand in [`Tables::slots`].
    #[must_use]
    pub fn slot_range(&self, place: u32) -> Range<usize> {
        let first = place as usize * self.slots_per_member;
        first..first + self.slots_per_member
    }

    /// Where a member's layers stand in [`Tables::layers`].
    #[must_use]
    pub fn layer_range(&self, place: u32) -> Range<usize> {
        let first = place as usize * LAYERS_PER_MEMBER as usize;
        first..first + LAYERS_PER_MEMBER as usize
    }

    /// Forgets which elements changed; called once every device took them over.
    pub fn mark_clean(&mut self) {
        self.all.for_each(|_, dirty| *dirty = 0..0);
    }

    /// Marks every element as changed, for a device that knows nothing yet.
    pub fn mark_dirty(&mut self) {
        self.all.for_each(|count, dirty| *dirty = 0..count);
    }
}

const EMPTY_SLOT: Slot = Slot {
    start_tick: 0,
    phase_rate: 0,
    weight_tick: 0,
    start_phase: 0,
    bound_clip: NONE,
    layer_and_mode: SLOT_LOOP,
    start_weight: 0.0,
    weight_rate: 0.0,
    end_weight: 0.0,
};
const PLAIN_LAYER: Layer = Layer { weight: 1.0, mask_and_mode: LAYER_MASK };

fn padded(joint_count: usize) -> usize {
    joint_count.next_multiple_of(JOINT_BLOCK as usize)
}

fn palette_block_count(entry_count: u32) -> usize {
    entry_count.div_ceil(PALETTE_BLOCK) as usize
}

fn device_entry(entry: &PaletteEntry) -> Entry {
    let [row0, row1, row2] = entry.joint_from_bind.rows.map(Float4);
    Entry { row0, row1, row2, joint: entry.joint.0, ..Entry::default() }
}

fn fill(blocks: &mut Table<u32>, (first, count): (usize, usize), place: u32) {
    blocks.resize(blocks.data.len().max(first + count), NONE);
    for block in first..first + count {
        blocks.set(block, place);
    }
}
