//! Sorting of instances into draws: one per run of equal model, page and handedness.

use glam::Vec3;
use populace_device::layout::PAGE_ENTRIES;
use populace_device::{Instance, Visibility};
use populace_model::Affine;

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ModelInfo {
    /// Number of palette entries.
    pub(crate) entry_count: usize,
    /// Number of levels of detail, at least 1.
    pub(crate) level_count: u32,
    /// True if any part is alpha-blended.
    pub(crate) blended: bool,
    /// True for a thing as large as a house: a place, before which others stand.
    pub(crate) is_place: bool,
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

/// Sort key of one instance.
#[derive(Clone, Copy)]
struct DrawKey {
    is_place: bool,
    page: usize,
    model: usize,
    level: u32,
    mirrored: bool,
    faded: bool,
    /// Squared distance from the eye.
    distance: f32,
    /// Index in the caller's list.
    index: usize,
}

impl Batches {
    /// Checks the instances and sorts them by their distance from `eye`. Hidden instances, and
    /// those with a non-finite transform, are skipped. `models` has the index in `infos` of
    /// each instance's model. `page_len` returns the number of palette entries of a page.
    /// `shadow_level` returns the level of an instance in the shadow map; `None` if its shadow is
    /// not in it.
    pub(crate) fn new(
        instances: &[Instance<'_>],
        models: &[usize],
        infos: &[ModelInfo],
        page_len: &dyn Fn(usize) -> usize,
        shadow_level: &dyn Fn(usize) -> Option<u32>,
        eye: Vec3,
    ) -> Result<Self, Error> {
        let mut keys = Vec::with_capacity(instances.len());
        for (index, (instance, &model)) in instances.iter().zip(models).enumerate() {
            let page = (instance.palette_first / PAGE_ENTRIES) as usize;
            let first = (instance.palette_first % PAGE_ENTRIES) as usize;
            let (count, available) = (infos[model].entry_count, page_len(page));
            if instance.visibility == Visibility::Hidden {
                continue;
            }
            if first + count > available {
                return Err(Error::NoPalette { instance: index, page, first, count, available });
            }
            if instance.world_from_model.is_finite() {
                let position = Vec3::from(instance.world_from_model.rows.map(|row| row[3]));
                keys.push(DrawKey {
                    is_place: infos[model].is_place,
                    page,
                    model,
                    level: instance.level.min(infos[model].level_count - 1),
                    mirrored: determinant(&instance.world_from_model) < 0.0,
                    faded: instance.look.opacity() < 1.0,
                    distance: position.distance_squared(eye),
                    index,
                });
            }
        }
        let mut batches = Self::default();
        let mut shadow_keys: Vec<DrawKey> = keys
            .iter()
            .filter(|key| instances[key.index].look.opacity() > THROWS)
            .filter_map(|key| Some(DrawKey { level: shadow_level(key.index)?, ..*key }))
            .collect();
        sort_for_opaque(&mut shadow_keys);
        batches.shadow = batches.append(instances, &shadow_keys);
        keys.retain(|key| instances[key.index].visibility == Visibility::InView);
        sort_for_opaque(&mut keys);
        batches.opaque = batches.append(instances, &keys);
        keys.retain(|key| infos[key.model].blended);
        keys.sort_unstable_by(|a, b| b.distance.total_cmp(&a.distance).then(a.index.cmp(&b.index)));
        batches.blended = batches.append(instances, &keys);
        Ok(batches)
    }

    /// Appends the instances in the order of `keys` and returns their runs.
    fn append(&mut self, instances: &[Instance<'_>], keys: &[DrawKey]) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for key in keys {
            let DrawKey { page, model, level, mirrored, faded, index, .. } = *key;
            let same = |r: &&mut Run| {
                (r.page, r.model, r.level) == (page, model, level)
                    && (r.mirrored, r.faded) == (mirrored, faded)
            };
            match runs.last_mut().filter(same) {
                Some(run) => run.count += 1,
                None => {
                    // Saturation is out of reach: 2^32 instances would take 256 GiB.
                    let first = u32::try_from(self.instances.len()).unwrap_or(u32::MAX);
                    runs.push(Run { page, model, level, mirrored, faded, first, count: 1 });
                }
            }
            let instance = &instances[index];
            let [look0, look1]: [Index32x4; 2] = bytemuck::cast(instance.look);
            let [world_row0, world_row1, world_row2] = instance.world_from_model.rows;
            self.instances.push(InstanceData {
                world_row0,
                world_row1,
                world_row2,
                look0,
                look1,
                palette_first: instance.palette_first % PAGE_ENTRIES,
                number: u32::try_from(index).unwrap_or(u32::MAX),
            });
        }
        runs
    }
}

/// Sorts into the fewest runs, each front to back. Fine levels come first: they are near, and hide
/// what is behind them. Places come last, since shading them takes longest.
fn sort_for_opaque(keys: &mut [DrawKey]) {
    keys.sort_unstable_by(|a, b| {
        let group = |k: &DrawKey| (k.is_place, k.level, k.page, k.model, k.mirrored, k.faded);
        let order = group(a).cmp(&group(b)).then(a.distance.total_cmp(&b.distance));
        order.then(a.index.cmp(&b.index))
    });
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

    const OPAQUE: ModelInfo =
        ModelInfo { entry_count: 3, level_count: 2, blended: false, is_place: false };
    const BLENDED: ModelInfo = ModelInfo { level_count: 1, blended: true, ..OPAQUE };
    const PLACE: ModelInfo = ModelInfo { is_place: true, ..OPAQUE };

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

    fn batches(placed: &[Placed], infos: &[ModelInfo]) -> Result<Batches, Error> {
        batches_with(placed, infos, |_| ())
    }

    fn batches_with(
        placed: &[Placed],
        infos: &[ModelInfo],
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
        let page_len = |page| if page < 2 { 100 } else { 0 };
        let shadow = |index: usize| (index == 0).then_some(1);
        Batches::new(&instances, &models, infos, &page_len, &shadow, Vec3::new(0.0, 0.0, 10.0))
    }

    #[test]
    fn each_model_and_page_is_one_run() {
        let list = [(0, 0, 0.0), (1, 8, 0.0), (0, PAGE_ENTRIES + 4, 0.0), (0, 16, 5.0)];
        let sorted = batches(&list, &[OPAQUE, OPAQUE]).unwrap();
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
        let sorted = batches(&list, &[BLENDED, BLENDED, OPAQUE]).unwrap();
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
        let sorted = batches_with(&[(0, 0, 0.0); 2], &[OPAQUE], mirror).unwrap();
        assert_eq!(sorted.opaque.iter().map(|r| r.mirrored).collect::<Vec<_>>(), [false, true]);
    }

    #[test]
    fn palette_past_the_end_of_its_page_is_rejected() {
        assert!(batches(&[(0, 97, 0.0)], &[OPAQUE]).is_ok());
        let error = batches(&[(0, 0, 0.0), (0, 98, 0.0)], &[OPAQUE]).unwrap_err();
        assert!(
            matches!(
                error,
                Error::NoPalette { instance: 1, page: 0, first: 98, count: 3, available: 100 }
            ),
            "{error}"
        );
        assert!(batches(&[(0, 2 * PAGE_ENTRIES, 0.0)], &[OPAQUE]).is_err());
    }

    #[test]
    fn places_are_drawn_after_those_who_stand_before_them() {
        let list = [(0, 0, 5.0), (1, 4, 0.0)];
        let sorted = batches_with(&list, &[PLACE, OPAQUE], |all| all[1].level = 1).unwrap();
        let drawn: Vec<_> = sorted.opaque.iter().map(|run| (run.model, run.level)).collect();
        assert_eq!(drawn, [(1, 1), (0, 0)]);
    }

    #[test]
    fn non_finite_instances_are_skipped() {
        let sorted = batches(&[(0, 0, f32::NAN), (0, 4, 0.0)], &[OPAQUE]).unwrap();
        assert_eq!(sorted.instances.iter().map(|i| i.palette_first).collect::<Vec<_>>(), [4]);
    }

    #[test]
    fn faded_members_are_runs_of_their_own_and_throw_no_shadow_when_faint() {
        let placed = [(0, 0, 0.0), (0, 3, 1.0), (0, 6, 2.0)];
        let faded = batches_with(&placed, &[OPAQUE], |all| {
            all[0].look = all[0].look.with_opacity(0.4);
        });
        let faded = faded.unwrap();
        let runs: Vec<_> = faded.opaque.iter().map(|run| (run.faded, run.count)).collect();
        assert_eq!(runs, [(false, 2), (true, 1)]);
        assert_eq!(faded.shadow, []);
        let whole = batches_with(&placed, &[OPAQUE], |_| ()).unwrap();
        assert_eq!((whole.opaque.len(), whole.shadow.len()), (1, 1));
    }

    #[test]
    fn levels_are_runs_and_hidden_instances_are_not_drawn() {
        let list = [(0, 0, 0.0), (0, 4, 1.0), (0, 8, 2.0), (0, 12, 3.0), (0, 16, 4.0)];
        let sorted = batches_with(&list, &[OPAQUE], |instances| {
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
