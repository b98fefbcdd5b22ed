//! Sorting of instances into draws: one per run of equal model, page and handedness.

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
    /// Number of draw calls.
    pub draw_calls: usize,
}

/// Properties of a model that batching needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ModelInfo {
    /// Number of palette entries.
    pub(crate) entry_count: usize,
    /// The error of each level of detail in metres, finest first; one at least.
    pub(crate) level_errors_m: Vec<f32>,
    /// True if any part is alpha-blended.
    pub(crate) blended: bool,
    /// True for a thing as large as a house: a place, before which others stand.
    pub(crate) is_place: bool,
    /// Centre and radius in metres of the rest pose's bounding sphere, in model space.
    pub(crate) sphere: (Vec3, f32),
}

impl ModelInfo {
    /// Returns `level`, or the coarsest level if there are not as many.
    pub(crate) fn level(&self, level: u32) -> u32 {
        level.min(u32_from(self.level_errors_m.len().saturating_sub(1)))
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
    /// Returns the level of an instance in the shadow map; `None` if its shadow is not in it.
    pub(crate) shadow_level: &'a (dyn Fn(usize) -> Option<u32> + Sync),
    pub(crate) eye: Vec3,
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
            let position = Vec3::from(instance.world_from_model.rows.map(|row| row[3]));
            let distance = position.distance_squared(self.eye).to_bits();
            let key = |level: u32| {
                let group = Group::new(level, page, model)
                    .with(Group::PLACE, info.is_place)
                    .with(Group::MIRRORED, determinant(&instance.world_from_model) < 0.0)
                    .with(Group::FADED, look.opacity() < 1.0);
                DrawKey { group, distance, index: u32_from(index) }
            };
            if look.opacity() > THROWS {
                keys.shadow.extend((self.shadow_level)(index).map(key));
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
        let palette_first = instance.palette_first % PAGE_ENTRIES;
        InstanceData { world_row0, world_row1, world_row2, look0, look1, palette_first, number }
    }
}

/// Returns the determinant of the linear part. It is negative if the transform mirrors.
pub(crate) fn determinant(m: &Affine) -> f32 {
    let [a, b, c] = m.rows.map(|row| Vec3::new(row[0], row[1], row[2]));
    a.dot(b.cross(c))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use populace_character::{Character, CharacterSource};
    use populace_device::MemberLook;
    use populace_model::{JointSource, Skeleton, Trs};

    use super::*;

    /// Kind of a model.
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        /// Has two levels.
        Opaque,
        Blended,
        Place,
    }
    use Kind::{Blended, Opaque, Place};

    fn info(kind: Kind) -> ModelInfo {
        ModelInfo {
            entry_count: 3,
            level_errors_m: if kind == Blended { vec![0.0] } else { vec![0.0, 0.1] },
            blended: kind == Blended,
            is_place: kind == Place,
            sphere: (Vec3::ZERO, 1.0),
        }
    }

    /// A model's index, a first palette entry, and a position on the z axis.
    type Placed = (usize, u32, f32);

    fn nobody() -> Arc<Character> {
        let joint = JointSource { name: "base".into(), parent: None, rest: Trs::IDENTITY };
        let source = CharacterSource {
            name: "nobody".into(),
            skeleton: Skeleton::new(&[joint]).unwrap(),
            palette: Vec::new(),
            parts: Vec::new(),
            materials: Vec::new(),
            images: Vec::new(),
            skins: Vec::new(),
            clips: Vec::new(),
        };
        Arc::new(Character::new(source).unwrap())
    }

    fn batches(placed: &[Placed], kinds: &[Kind]) -> Result<Batches, Error> {
        batches_with(placed, kinds, |_| ())
    }

    fn batches_with(
        placed: &[Placed],
        kinds: &[Kind],
        change: impl Fn(&mut [Instance<'_>]),
    ) -> Result<Batches, Error> {
        let character = nobody();
        let instance = |&(_, palette_first, z): &Placed| {
            let mut world_from_model = Affine::IDENTITY;
            world_from_model.rows[2][3] = z;
            let (moved, look) = ([0.0; 3], MemberLook::PLAIN);
            let (level, visibility) = (0, Visibility::InView);
            Instance {
                character: &character,
                world_from_model,
                moved,
                palette_first,
                look,
                level,
                visibility,
            }
        };
        let mut instances: Vec<_> = placed.iter().map(instance).collect();
        change(&mut instances);
        let models: Vec<usize> = placed.iter().map(|placed| placed.0).collect();
        let infos: Vec<_> = kinds.iter().map(|kind| info(*kind)).collect();
        Batches::new(&Instances {
            all: &instances,
            models: &models,
            infos: &infos.iter().collect::<Vec<_>>(),
            page_lengths: &[100, 100],
            shadow_level: &|index| (index == 0).then_some(1),
            eye: Vec3::new(0.0, 0.0, 10.0),
        })
    }

    #[test]
    fn each_model_and_page_is_one_run() {
        let list = [(0, 0, 0.0), (1, 8, 0.0), (0, PAGE_ENTRIES + 4, 0.0), (0, 16, 5.0)];
        let sorted = batches(&list, &[Opaque, Opaque]).unwrap();
        let run = |page, model, level, first, count| {
            let mirrored = false;
            Run { page, model, level, mirrored, faded: false, first, count }
        };
        assert_eq!(sorted.shadow, [run(0, 0, 1, 0, 1)]);
        assert_eq!(sorted.opaque, [run(0, 0, 0, 1, 2), run(0, 1, 0, 3, 1), run(1, 0, 0, 4, 1)]);
        let firsts: Vec<_> = sorted.instances.iter().map(|i| i.palette_first).collect();
        assert_eq!(firsts, [0, 16, 0, 8, 4], "near instances first; entries relative to the page");
        assert!(sorted.blended.is_empty());
    }

    #[test]
    fn blended_runs_are_sorted_back_to_front() {
        let list = [(0, 0, 0.0), (1, 0, -5.0), (0, 0, -9.0), (2, 0, -7.0)];
        let sorted = batches(&list, &[Blended, Blended, Opaque]).unwrap();
        let order: Vec<_> = sorted
            .blended
            .iter()
            .map(|r| (r.model, sorted.instances[r.first as usize].world_row2[3]))
            .collect();
        assert_eq!(order, [(0, -9.0), (1, -5.0), (0, 0.0)]);
    }

    #[test]
    fn mirrored_instances_get_their_own_run() {
        let mirror = |instances: &mut [Instance<'_>]| {
            instances[0].world_from_model.rows[0][0] = -1.0;
        };
        let sorted = batches_with(&[(0, 0, 0.0); 2], &[Opaque], mirror).unwrap();
        assert_eq!(sorted.opaque.iter().map(|r| r.mirrored).collect::<Vec<_>>(), [false, true]);
    }

    #[test]
    fn palette_past_the_end_of_its_page_is_rejected() {
        assert!(batches(&[(0, 97, 0.0)], &[Opaque]).is_ok());
        let error = batches(&[(0, 0, 0.0), (0, 98, 0.0)], &[Opaque]).unwrap_err();
        assert!(
            matches!(
                error,
                Error::NoPalette { instance: 1, page: 0, first: 98, count: 3, available: 100 }
            ),
            "{error}"
        );
        assert!(batches(&[(0, 2 * PAGE_ENTRIES, 0.0)], &[Opaque]).is_err());
    }

    #[test]
    fn shares_of_threads_join_in_order() {
        let count = 2 * u16::try_from(SHARE).unwrap() + 77;
        // Nearer and nearer, in two models in turn.
        let mut placed: Vec<Placed> = (0..count)
            .map(|i| (usize::from(i % 2), 4 * u32::from(i % 24), f32::from(i) / 1e4))
            .collect();
        let sorted = batches(&placed, &[Opaque, Opaque]).unwrap();
        let numbers: Vec<u32> = sorted.instances.iter().map(|instance| instance.number).collect();
        let last_first = |odd: u16| (0..count).rev().filter(move |i| i % 2 == odd).map(u32::from);
        let expected: Vec<u32> =
            [0].into_iter().chain(last_first(0)).chain(last_first(1)).collect();
        assert_eq!(numbers, expected, "the first throws a shadow");
        let counts: Vec<_> = sorted.opaque.iter().map(|run| (run.model, run.count)).collect();
        let half = u32::from(count / 2);
        assert_eq!(counts, [(0, half + 1), (1, half)]);
        for bad in [2 * SHARE + 5, SHARE + 9] {
            placed[bad].1 = 98;
            let error = batches(&placed, &[Opaque, Opaque]).unwrap_err();
            assert!(
                matches!(error, Error::NoPalette { instance, .. } if instance == bad),
                "{error}"
            );
        }
    }

    #[test]
    fn places_are_drawn_after_those_who_stand_before_them() {
        let list = [(0, 0, 5.0), (1, 4, 0.0)];
        let sorted = batches_with(&list, &[Place, Opaque], |all| all[1].level = 1).unwrap();
        let drawn: Vec<_> = sorted.opaque.iter().map(|run| (run.model, run.level)).collect();
        assert_eq!(drawn, [(1, 1), (0, 0)]);
    }

    #[test]
    fn non_finite_instances_are_skipped() {
        let sorted = batches(&[(0, 0, f32::NAN), (0, 4, 0.0)], &[Opaque]).unwrap();
        assert_eq!(sorted.instances.iter().map(|i| i.palette_first).collect::<Vec<_>>(), [4]);
    }

    #[test]
    fn faded_members_are_runs_of_their_own_and_throw_no_shadow_when_faint() {
        let placed = [(0, 0, 0.0), (0, 3, 1.0), (0, 6, 2.0)];
        let faded = batches_with(&placed, &[Opaque], |all| {
            all[0].look = all[0].look.with_opacity(0.4);
        });
        let faded = faded.unwrap();
        let runs: Vec<_> = faded.opaque.iter().map(|run| (run.faded, run.count)).collect();
        assert_eq!(runs, [(false, 2), (true, 1)]);
        assert_eq!(faded.shadow, []);
        let whole = batches_with(&placed, &[Opaque], |_| ()).unwrap();
        assert_eq!((whole.opaque.len(), whole.shadow.len()), (1, 1));
    }

    #[test]
    fn levels_are_runs_and_hidden_instances_are_not_drawn() {
        let list = [(0, 0, 0.0), (0, 4, 1.0), (0, 8, 2.0), (0, 12, 3.0), (0, 16, 4.0)];
        let sorted = batches_with(&list, &[Opaque], |instances| {
            (instances[0].visibility, instances[1].level) = (Visibility::ShadowOnly, 7);
            (instances[2].visibility, instances[3].level) = (Visibility::Hidden, 1);
        });
        let sorted = sorted.unwrap();
        let runs = |runs: &[Run]| -> Vec<_> {
            let first = |r: &Run| sorted.instances[r.first as usize].palette_first;
            runs.iter().map(|r| (r.level, r.count, first(r))).collect()
        };
        assert_eq!(runs(&sorted.shadow), [(1, 1, 0)]);
        assert_eq!(runs(&sorted.opaque), [(0, 1, 16), (1, 2, 12)], "level 7 counts as the last");
    }
}
