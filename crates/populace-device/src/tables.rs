//! The tables that devices evaluate: data shared by all members, and the members themselves.

mod binding;
mod clips;
mod controls;
mod free_runs;
mod hiding;
mod live;
mod machines;
mod members;
mod pages;
mod reduced;
mod removal;
mod rows;
mod runs;
mod sample;
mod set;
mod slots;
mod soles;
mod space;
mod table;

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use crate::Error;
use crate::layout::{
    Body, Entry, Float4, JOINT_BLOCK, LAYER_MASK, LAYERS_PER_MEMBER, MAX_PHASES, Member, NONE,
    PAGE_ENTRIES, PALETTE_BLOCK, POSE_PLANES,
};
use crate::playback::MAX_SLOTS;
use crate::stage_buffer::StageBuffer;
use controls::ControlSpaces;
use machines::InstanceSpace;
use pages::PageLists;
use populace_character::PaletteEntry;
use populace_model::convert::u32_from;
use populace_model::{Mask, Skeleton, Trs};
use runs::{Asset, Runs};
use set::{BlockTableSet, TableSet};
use soles::Soles;
use space::Space;

pub use controls::Ground;
use live::LiveClip;
pub use live::LiveNewest;
pub use machines::{Condition, MachineState, Transition};
pub use table::Table;

/// Joints of a block.
const BLOCK: usize = JOINT_BLOCK as usize;

/// Index of a body (a skeleton with its palette entries) in [`Tables`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyIndex(pub u32);

/// All the data that a device needs to evaluate a crowd. The host's copy is authoritative; devices
/// copy what changed.
#[derive(Clone, Debug)]
pub struct Tables {
    /// Slots of each member, 1 to [`MAX_SLOTS`].
    slots_per_member: usize,
    all: TableSet,
    blocks: BlockTableSet,
    /// Width of the widest level of any body, by depth.
    level_widths: Vec<usize>,
    page_lists: PageLists,
    /// Unused member indices, lowest first. Indices past the end of the table are stale.
    free_members: BinaryHeap<Reverse<u32>>,
    joint_space: Space,
    palette_space: Space,
    control_spaces: ControlSpaces,
    /// Number of members in each phase.
    phase_members: [usize; MAX_PHASES as usize],
    instance_space: InstanceSpace,
    /// The runs of each asset, by kind and index.
    asset_runs: HashMap<(Asset, u32), Runs>,
    /// Soles of bodies that have some, by body.
    soles_of_bodies: HashMap<u32, Soles>,
    /// Live clips, by index.
    live_clips: HashMap<u32, LiveClip>,
    /// Set once a live clip is added, and kept when it is removed.
    had_live_clips: bool,
}

impl Tables {
    /// Creates empty tables. `slots_per_member` is clamped to 1 to [`MAX_SLOTS`].
    #[must_use]
    pub fn new(slots_per_member: usize) -> Self {
        Self::with_capacity(slots_per_member, 0)
    }

    /// Creates empty tables for a crowd of `members` members. Devices allocate memory for exactly
    /// that many at once. The crowd can still grow beyond it, and the host allocates its memory
    /// only as members are added.
    #[must_use]
    pub fn with_capacity(slots_per_member: usize, members: usize) -> Self {
        let slots_per_member = slots_per_member.clamp(1, MAX_SLOTS);
        let mut all = TableSet::new();
        all.members.set_expected(members);
        all.slots.set_expected(members.saturating_mul(slots_per_member));
        all.layers.set_expected(members.saturating_mul(LAYERS_PER_MEMBER as usize));
        all.ground.grow(1, crate::layout::Ground::default());
        all.stage_values.grow(controls::PARAMETER_ELEMENTS, Float4::default());
        Self {
            slots_per_member,
            all,
            blocks: BlockTableSet::new(),
            level_widths: Vec::new(),
            page_lists: PageLists::default(),
            free_members: BinaryHeap::new(),
            joint_space: Space::new(usize::MAX),
            palette_space: Space::new((PAGE_ENTRIES / PALETTE_BLOCK) as usize),
            control_spaces: ControlSpaces::new(),
            phase_members: [0; MAX_PHASES as usize],
            instance_space: InstanceSpace::new(),
            asset_runs: HashMap::new(),
            soles_of_bodies: HashMap::new(),
            live_clips: HashMap::new(),
            had_live_clips: false,
        }
    }

    /// Number of slots per member.
    #[must_use]
    pub fn slots_per_member(&self) -> usize {
        self.slots_per_member
    }

    /// Length of the member table: used and unused entries, up to the last used one.
    #[must_use]
    pub fn member_places(&self) -> usize {
        self.all.members.len()
    }

    /// Elements of the joint buffer up to the last one in use, including padding and unused blocks.
    #[must_use]
    pub fn joint_places(&self) -> usize {
        self.blocks.joint_blocks.len() * BLOCK
    }

    /// Palette entries over all pages, up to the last one in use.
    #[must_use]
    pub fn palette_places(&self) -> usize {
        self.blocks.palette_blocks.len() * PALETTE_BLOCK as usize
    }

    /// Palette entries of each page. All pages but the last have [`PAGE_ENTRIES`].
    pub fn page_lengths(&self) -> impl ExactSizeIterator<Item = usize> + use<> {
        let total = self.palette_places();
        let page = PAGE_ENTRIES as usize;
        (0..total.div_ceil(page)).map(move |p| (total - p * page).min(page))
    }

    /// Indices of the members with palettes in `page`, in no particular order. Members without
    /// palette entries are in no page. The list shrinks as members leave: elements past its end on
    /// a device are meaningless.
    ///
    /// # Panics
    ///
    /// If the page does not exist, see [`page_lengths`](Self::page_lengths).
    #[must_use]
    pub fn page_members(&self, page: usize) -> &Table<u32> {
        &self.page_lists.lists()[page]
    }

    /// Width of the widest level of any body, by depth.
    #[must_use]
    pub fn level_widths(&self) -> &[usize] {
        &self.level_widths
    }

    /// Returns the row of a member as a device has taken it over; see
    /// [`with_taken_over`](Self::with_taken_over).
    ///
    /// # Panics
    ///
    /// If there is no such member.
    #[must_use]
    pub fn member_taken_over(&self, member_index: u32) -> Member {
        self.all.members.value_before(member_index as usize)
    }

    /// Joint count of the largest body, padded to whole blocks.
    #[must_use]
    pub fn padded_most(&self) -> usize {
        self.all.bodies.as_slice().iter().map(|body| body.padded_count as usize).max().unwrap_or(0)
    }

    /// Returns the member that element `first` of `buffer` belongs to, and the index of the element
    /// among those of that member. Returns `None` for palettes, history state and watched joints,
    /// and for elements without a member.
    #[must_use]
    pub fn place_of(&self, buffer: StageBuffer, first: usize) -> Option<(u32, usize)> {
        let member_index = match buffer {
            StageBuffer::Palette
            | StageBuffer::States
            | StageBuffer::Watched
            | StageBuffer::Running => {
                return None;
            }
            StageBuffer::Samples => u32::try_from(first / self.slots_per_member).ok()?,
            _ => *self.joint_blocks().as_slice().get(first / BLOCK)?,
        };
        let member = self
            .all
            .members
            .as_slice()
            .get(member_index as usize)
            .filter(|member| member.body != NONE)?;
        let own_first = match buffer {
            StageBuffer::Samples => member_index as usize * self.slots_per_member,
            _ => member.joint_first as usize,
        };
        Some((member_index, first - own_first))
    }

    /// Adds a body that is always evaluated whole.
    ///
    /// # Errors
    ///
    /// As [`add_reducible_body`](Self::add_reducible_body).
    pub fn add_body(
        &mut self,
        skeleton: &Skeleton,
        palette: &[PaletteEntry],
    ) -> Result<BodyIndex, Error> {
        self.add_reducible_body(skeleton, palette, &[])
    }

    /// Adds a body, and reduced ones with the first `joint_counts` of its joints, in level order.
    /// [`set_reduced`](Self::set_reduced) chooses among them for each member.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits or the palette is larger than a page.
    ///
    /// # Panics
    ///
    /// If a joint count is 0, or larger than that of the skeleton.
    pub fn add_reducible_body(
        &mut self,
        skeleton: &Skeleton,
        palette: &[PaletteEntry],
        joint_counts: &[usize],
    ) -> Result<BodyIndex, Error> {
        if palette.len() > PAGE_ENTRIES as usize {
            let limit = PAGE_ENTRIES as usize;
            return Err(Error::TooLarge {
                what: "one character's palette",
                count: palette.len(),
                limit,
            });
        }
        let mut soles = Soles::default();
        let index = self.add_asset(Asset::Body, |tables, runs| {
            let all = &mut tables.all;
            soles = Soles::add(skeleton, all, runs)?;
            let parents = skeleton.joints().map(|j| skeleton.parent(j).map_or(NONE, |p| p.0));
            let joint_first = runs.add(&mut all.parents, parents)?;
            let levels = skeleton.levels();
            let starts = levels.iter().map(|l| l.start).chain([skeleton.joint_count()]);
            let level_first = runs.add(&mut all.levels, starts.map(u32_from))?;
            let rest: Vec<Trs> = skeleton.joints().map(|j| *skeleton.rest(j)).collect();
            let rest_first = runs.add(&mut all.poses, planes_of(&rest))?;
            let entry_first = runs.add(&mut all.entries, palette.iter().map(device_entry))?;
            let body = Body {
                joint_first,
                joint_count: u32_from(skeleton.joint_count()),
                padded_count: u32_from(padded(skeleton.joint_count())),
                level_first,
                level_count: u32_from(levels.len()),
                rest_first,
                entry_first,
                entry_count: u32_from(palette.len()),
            };
            let reduced = joint_counts
                .iter()
                .map(|count| reduced::add(all, runs, (skeleton, palette), &body, *count))
                .collect::<Result<Vec<_>, _>>()?;
            runs.add(&mut all.bodies, std::iter::once(body).chain(reduced))
        })?;
        self.soles_of_bodies.insert(index, soles);
        self.measure_levels();
        Ok(BodyIndex(index))
    }

    /// Adds a mask and returns its offset in [`masks`](Self::masks), for use in layers.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 31 bits.
    pub fn add_mask(&mut self, mask: &Mask) -> Result<u32, Error> {
        let padded = padded(mask.weights().len());
        let (count, limit) = (self.all.masks.len() + padded, LAYER_MASK as usize);
        if count > limit {
            return Err(Error::TooLarge { what: "the masks", count, limit });
        }
        let padding = std::iter::repeat_n(0.0, padded - mask.weights().len());
        let weights = mask.weights().iter().copied().chain(padding);
        self.add_asset(Asset::Mask, |tables, runs| runs.add(&mut tables.all.masks, weights))
    }

    /// Adds a length factor for each joint of a body, in level order, and returns their offset in
    /// [`joint_scales`](Self::joint_scales).
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits.
    pub fn add_joint_scales(&mut self, factors: &[f32]) -> Result<u32, Error> {
        let padding = std::iter::repeat_n(1.0, padded(factors.len()) - factors.len());
        let factors = factors.iter().copied().chain(padding);
        let add =
            |tables: &mut Self, runs: &mut Runs| runs.add(&mut tables.all.joint_scales, factors);
        self.add_asset(Asset::JointScales, add)
    }

    /// Clears the record of changes. Call it after every device has copied them.
    pub fn mark_clean(&mut self) {
        self.mark_controls_clean();
        self.all.mark_clean();
        self.blocks.mark_clean();
        self.page_lists.mark_clean();
    }

    /// Calls `read` with the tables as of the last [`mark_clean`](Self::mark_clean). Takes time
    /// proportional to the number of changes since then.
    pub fn with_taken_over<R>(&mut self, read: impl FnOnce(&Self) -> R) -> R {
        self.all.revert();
        self.blocks.revert();
        let result = read(self);
        self.all.restore();
        self.blocks.restore();
        result
    }

    /// Returns the numbers that the last owners of a device's history got.
    #[must_use]
    pub const fn epochs(&self) -> Epochs {
        let controls = self.control_spaces.last_epoch();
        Epochs { controls, machines: self.instance_space.last_epoch() }
    }

    /// Gives the next owners of history numbers after these. Tables that go back to an earlier
    /// state need it: devices still hold the history of owners that came later, under their
    /// numbers.
    pub fn continue_epochs(&mut self, after: Epochs) {
        self.control_spaces.continue_after(after.controls);
        self.instance_space.continue_after(after.machines);
    }

    /// Marks every element as changed, for a device that has copied nothing yet.
    pub fn mark_dirty(&mut self) {
        self.mark_controls_dirty();
        self.all.mark_dirty();
        self.blocks.mark_dirty();
        self.page_lists.mark_dirty();
    }
}

/// Numbers that the last owners of a device's history got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Epochs {
    controls: u32,
    machines: u32,
}

/// Returns the planes of a pose, padded to whole blocks of joints.
fn planes_of(pose: &[Trs]) -> Vec<f32> {
    in_blocks(pose.iter().map(numbers_of))
}

/// Returns the number of a joint in each of the planes of a pose.
fn numbers_of(trs: &Trs) -> [f32; POSE_PLANES as usize] {
    let ([qx, qy, qz, qw], [tx, ty, tz], [sx, sy, sz]) = (trs.rotation, trs.translation, trs.scale);
    // Zeros become positive, as in constant ranges.
    [qx, qy, qz, qw, tx, ty, tz, sx, sy, sz].map(|component| component + 0.0)
}

/// Stores the numbers of each joint in planes, block by block. Padding is 0.
fn in_blocks<const PLANES: usize>(
    joints: impl ExactSizeIterator<Item = [f32; PLANES]>,
) -> Vec<f32> {
    let mut planes = vec![0.0; PLANES * padded(joints.len())];
    for (joint, numbers) in joints.enumerate() {
        let block = &mut planes[joint / BLOCK * BLOCK * PLANES..];
        for (plane, number) in block.as_chunks_mut::<BLOCK>().0.iter_mut().zip(numbers) {
            plane[joint % BLOCK] = number;
        }
    }
    planes
}

fn padded(joint_count: usize) -> usize {
    joint_count.next_multiple_of(BLOCK)
}

fn device_entry(entry: &PaletteEntry) -> Entry {
    let [row0, row1, row2] = entry.joint_from_bind.rows.map(Float4);
    Entry { row0, row1, row2, joint: entry.joint.0, ..Entry::default() }
}
