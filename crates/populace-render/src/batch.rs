//! Sorting of instances into runs of equal model, level, page and handedness.

use std::cmp::Reverse;

use glam::Vec3;
use populace_device::layout::PAGE_ENTRIES;
use populace_device::{Instance, Visibility};
use populace_model::Affine;
use populace_model::convert::u32_from;
use rayon::prelude::*;

use crate::Error;
use crate::layout::{Index32x4, InstanceData};

/// Members of which no larger part is drawn throw no shadow.
const THROWS: f32 = 0.5;

/// Counts of a drawn picture, by pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Members in the picture.
    pub members: PassCounts,
    /// Members in the shadow map, and contact shadows.
    pub shadow: PassCounts,
    /// Sky and ground.
    pub surroundings: PassCounts,
}

/// Counts of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassCounts {
    /// Number of instances; 0 for surroundings.
    pub instances: usize,
    /// Number of their triangles, without hidden parts and contact shadows.
    pub triangles: usize,
    /// Number of draw calls. One call draws all that has the same shader, page of palettes,
    /// material and textures; for software rasterizers such calls are divided.
    pub draw_calls: usize,
}

/// Properties of a model that batching needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ModelInfo {
    /// Number of palette entries.
    pub(crate) entry_count: usize,
    /// The error of each level of detail in metres, finest first; at least one.
    pub(crate) level_errors_m: Vec<f32>,
    /// True if any part is alpha-blended.
    pub(crate) blended: bool,
    /// True for a thing as large as a house: a place, before which others stand.
    pub(crate) is_place: bool,
    /// True for a floor, such as that of a walkable area with its low walls: far wider than high,
    /// so that others throw shadows onto it, and it throws few.
    pub(crate) is_floor: bool,
    /// Centre and radius in metres of the rest pose's bounding sphere, in model space.
    pub(crate) sphere: (Vec3, f32),
}

impl ModelInfo {
    /// Returns `level`, or the coarsest level if there are fewer.
    pub(crate) fn level(&self, level: u32) -> u32 {
        level.min(u32_from(self.level_errors_m.len().saturating_sub(1)))
    }

    /// Returns the error of a level in metres; 0 if there is no such level.
    pub(crate) fn level_error_m(&self, level: u32) -> f32 {
        self.level_errors_m.get(level as usize).copied().unwrap_or(0.0)
    }

    /// Returns the coarsest level with an error of at most `error_m`.
    pub(crate) fn level_within(&self, error_m: f32) -> u32 {
        let finer = self.level_errors_m.iter().filter(|error| **error <= error_m).count();
        u32_from(finer.saturating_sub(1))
    }
}

/// Consecutive instances of one model with palettes in one page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) page: usize,
    /// Index of the model.
    pub(crate) model: usize,
    /// Level of detail of the model.
    pub(crate) level: u32,
    /// True if `world_from_model` mirrors, which reverses the winding of triangles.
    pub(crate) mirrored: bool,
    /// True if the instances are drawn in part.
    pub(crate) faded: bool,
    /// Index of the first instance in [`Batches::instances`].
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// All instances in drawing order, and the runs that draw them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Batches {
    pub(crate) instances: Vec<InstanceData>,
    /// Runs of opaque and masked parts: the fewest possible, each sorted front to back.
    pub(crate) opaque: Vec<Run>,
    /// Runs of blended parts: all instances sorted back to front.
    pub(crate) blended: Vec<Run>,
    /// Runs of what throws shadows.
    pub(crate) shadow: Vec<Run>,
}

/// Properties that the instances of a run share, in one number, so that they compare fast and in
/// drawing order: a bit for places, 31 for the level, 32 for the page, 62 for the model, and one
/// each for mirrored and faded instances. Fine levels come first: they are near, and hide what is
/// behind them. Places come last, since shading them takes longest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Group(u128);

const LEVEL_BIT: u32 = 96;
const PAGE_BIT: u32 = 64;
const MODEL_BIT: u32 = 2;

impl Group {
    const PLACE: Self = Self(1 << 127);
    const MIRRORED: Self = Self(0b10);
    const FADED: Self = Self(0b01);

    fn new(level: u32, page: usize, model: usize) -> Self {
        let [level, page, model] = [u128::from(level), page as u128, model as u128];
        Self(level << LEVEL_BIT | page << PAGE_BIT | model << MODEL_BIT)
    }

    fn with(self, flag: Self, on: bool) -> Self {
        if on { Self(self.0 | flag.0) } else { self }
    }

    fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    fn run(self, first: u32, count: u32) -> Run {
        let bits = |first: u32, last: u32| (self.0 << (127 - last)) >> (127 - last + first);
        #[expect(clippy::cast_possible_truncation, reason = "the bits that `new` was given")]
        Run {
            level: bits(LEVEL_BIT, 126) as u32,
            page: bits(PAGE_BIT, LEVEL_BIT - 1) as usize,
            model: bits(MODEL_BIT, PAGE_BIT - 1) as usize,
            mirrored: self.has(Self::MIRRORED),
            faded: self.has(Self::FADED),
            first,
            count,
        }
    }
}

/// Sort key of an instance: near instances of a group come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct DrawKey {
    group: Group,
    /// Bits of the squared distance from the eye, which sort as the distances do.
    distance: u32,
    /// Index in the caller's list.
    index: u32,
}

/// Instances that a thread takes at a time.
const SHARE: usize = 4096;

/// The instances of a picture, and what sorting them depends on.
pub(crate) struct Instances<'a> {
    pub(crate) all: &'a [Instance<'a>],
    /// For each instance the index in `infos` of its model.
    pub(crate) models: &'a [usize],
    pub(crate) infos: &'a [&'a ModelInfo],
    /// Number of palette entries of each page.
    pub(crate) page_lengths: &'a [usize],
    /// For each instance its shadow caster; `None` if its shadow lies outside of the map.
    pub(crate) casters: &'a [Option<Caster>],
    pub(crate) eye: Vec3,
}

/// Shadow caster: the level of detail of an instance that is drawn into the shadow map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Caster {
    pub(crate) level: u32,
    /// Greatest distance in metres between its surface and that in the picture; 0 if the level is
    /// the same.
    pub(crate) apart_m: f32,
}

/// Keys of the instances of each list.
#[derive(Default)]
struct Keys {
    opaque: Vec<DrawKey>,
    blended: Vec<DrawKey>,
    shadow: Vec<DrawKey>,
}

impl Batches {
    /// Checks the instances and sorts them by their distance from the eye, on all threads. Hidden
    /// instances, and those with a non-finite transform, are skipped.
    pub(crate) fn new(instances: &Instances<'_>) -> Result<Self, Error> {
        let starts = (0..instances.all.len()).into_par_iter().step_by(SHARE);
        let shares: Vec<_> = starts.map(|first| instances.keys(first)).collect();
        let mut keys = Keys::default();
        for share in shares {
            let Keys { opaque, blended, shadow } = share?;
            keys.opaque.extend(opaque);
            keys.blended.extend(blended);
            keys.shadow.extend(shadow);
        }
        keys.shadow.par_sort_unstable();
        keys.opaque.par_sort_unstable();
        keys.blended.par_sort_unstable_by_key(|key| (Reverse(key.distance), key.index));
        let mut batches = Self::default();
        batches.shadow = batches.append(instances, &keys.shadow);
        batches.opaque = batches.append(instances, &keys.opaque);
        batches.blended = batches.append(instances, &keys.blended);
        Ok(batches)
    }

    /// Appends the instances in the order of `keys` and returns their runs.
    fn append(&mut self, instances: &Instances<'_>, keys: &[DrawKey]) -> Vec<Run> {
        let mut first = u32_from(self.instances.len());
        let mut runs = Vec::new();
        for run in keys.chunk_by(|a, b| a.group == b.group) {
            let count = u32_from(run.len());
            runs.push(run[0].group.run(first, count));
            first += count;
        }
        self.instances.par_extend(keys.par_iter().map(|key| instances.data(key.index)));
        runs
    }
}

impl Instances<'_> {
    /// Returns the keys of a share of the instances, from `first` on.
    fn keys(&self, first: usize) -> Result<Keys, Error> {
        let mut keys = Keys::default();
        for index in first..self.all.len().min(first + SHARE) {
            let instance = &self.all[index];
            if instance.visibility == Visibility::Hidden {
                continue;
            }
            let page = self.page(index)?;
            if !instance.world_from_model.is_finite() {
                continue;
            }
            let (model, look) = (self.models[index], &instance.look);
            let info = self.infos[model];
            let placed = Vec3::from(instance.world_from_model.rows.map(|row| row[3]));
            // The palette includes root motion.
            let position = placed + Vec3::from(instance.moved);
            let distance = position.distance_squared(self.eye).to_bits();
            let flags = Group(0)
                .with(Group::PLACE, info.is_place)
                .with(Group::MIRRORED, determinant(&instance.world_from_model) < 0.0)
                .with(Group::FADED, look.opacity() < 1.0);
            let key = |level: u32| {
                let group = Group::new(level, page, model).with(flags, true);
                DrawKey { group, distance, index: u32_from(index) }
            };
            if look.opacity() > THROWS {
                keys.shadow.extend(self.casters[index].map(|caster| key(caster.level)));
            }
            if instance.visibility == Visibility::InView {
                let key = key(info.level(instance.level));
                keys.opaque.push(key);
                keys.blended.extend(info.blended.then_some(key));
            }
        }
        Ok(keys)
    }

    /// Returns the page of an instance's palette.
    fn page(&self, index: usize) -> Result<usize, Error> {
        let palette_first = self.all[index].palette_first;
        let page = (palette_first / PAGE_ENTRIES) as usize;
        let first = (palette_first % PAGE_ENTRIES) as usize;
        let count = self.infos[self.models[index]].entry_count;
        let available = self.page_lengths.get(page).copied().unwrap_or_default();
        if first + count > available {
            return Err(Error::NoPalette { instance: index, page, first, count, available });
        }
        Ok(page)
    }

    /// Returns the attributes of an instance.
    fn data(&self, number: u32) -> InstanceData {
        let instance = &self.all[number as usize];
        let [look0, look1]: [Index32x4; 2] = bytemuck::cast(instance.look);
        let [world_row0, world_row1, world_row2] = instance.world_from_model.rows;
        InstanceData {
            world_row0,
            world_row1,
            world_row2,
            look0,
            look1,
            entry_and_number: [instance.palette_first % PAGE_ENTRIES, number],
            caster_apart_m: self.casters[number as usize].unwrap_or_default().apart_m,
        }
    }
}

/// Returns the determinant of the linear part. It is negative if the transform mirrors.
pub(crate) fn determinant(m: &Affine) -> f32 {
    let [a, b, c] = m.rows.map(|row| Vec3::new(row[0], row[1], row[2]));
    a.dot(b.cross(c))
}

#[cfg(test)]
mod tests;
