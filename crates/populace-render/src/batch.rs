//! Sorts instances into draws: one for each run of the same character, page and handedness.

use glam::Vec3;
use populace_device::layout::PAGE_ENTRIES;
use populace_model::Affine;

use crate::layout::InstanceData;
use crate::{Error, Instance};

/// What batching must know of a character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CharacterFacts {
    pub(crate) entry_count: usize,
    pub(crate) blended: bool,
}

/// Neighbouring instances of one character whose palettes stand in one page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) page: usize,
    pub(crate) character: usize,
    /// Whether `world_from_model` mirrors, which turns the winding of triangles around.
    pub(crate) mirrored: bool,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// All instances in the order in which they are drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Batches {
    pub(crate) instances: Vec<InstanceData>,
    /// For opaque and masked parts: as few runs as there can be, near instances of each first.
    pub(crate) opaque: Vec<Run>,
    /// For blended parts: strictly from far to near.
    pub(crate) blended: Vec<Run>,
}

struct Place {
    page: usize,
    character: usize,
    mirrored: bool,
    distance: f32,
    index: usize,
}

impl Batches {
    /// Checks the instances and sorts them, as seen from `eye`. Those whose transform or tint is
    /// not finite are left out. `page_len` tells how many palette entries a page holds.
    pub(crate) fn new(
        instances: &[Instance],
        characters: &[CharacterFacts],
        page_len: &dyn Fn(usize) -> usize,
        eye: Vec3,
    ) -> Result<Self, Error> {
        let mut places = Vec::with_capacity(instances.len());
        for (index, instance) in instances.iter().enumerate() {
            let Some(facts) = characters.get(instance.character.0) else {
                return Err(Error::UnknownCharacter { instance: index, count: characters.len() });
            };
            let page = (instance.palette_first / PAGE_ENTRIES) as usize;
            let first = (instance.palette_first % PAGE_ENTRIES) as usize;
            let (count, available) = (facts.entry_count, page_len(page));
            if first + count > available {
                return Err(Error::NoPalette { instance: index, page, first, count, available });
            }
            let finite = instance.world_from_model.is_finite()
                && instance.tint.iter().all(|t| t.is_finite());
            if finite {
                let position = Vec3::from(instance.world_from_model.rows.map(|row| row[3]));
                places.push(Place {
                    page,
                    character: instance.character.0,
                    mirrored: determinant(&instance.world_from_model) < 0.0,
                    distance: position.distance_squared(eye),
                    index,
                });
            }
        }
        let mut batches = Self::default();
        places.sort_unstable_by(|a, b| {
            let group = |p: &Place| (p.page, p.character, p.mirrored);
            let order = group(a).cmp(&group(b)).then(a.distance.total_cmp(&b.distance));
            order.then(a.index.cmp(&b.index))
        });
        batches.opaque = batches.append(instances, &places);
        places.retain(|place| characters[place.character].blended);
        places
            .sort_unstable_by(|a, b| b.distance.total_cmp(&a.distance).then(a.index.cmp(&b.index)));
        batches.blended = batches.append(instances, &places);
        Ok(batches)
    }

    fn append(&mut self, instances: &[Instance], places: &[Place]) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for place in places {
            let Place { page, character, mirrored, index, .. } = *place;
            let last = runs.last_mut();
            match last.filter(|r| (r.page, r.character, r.mirrored) == (page, character, mirrored))
            {
                Some(run) => run.count += 1,
                None => {
                    // A crowd of 2^32 would take 256 GiB of instances.
                    let first = u32::try_from(self.instances.len()).unwrap_or(u32::MAX);
                    runs.push(Run { page, character, mirrored, first, count: 1 });
                }
            }
            let instance = &instances[index];
            let [world_row0, world_row1, world_row2] = instance.world_from_model.rows;
            self.instances.push(InstanceData {
                world_row0,
                world_row1,
                world_row2,
                tint: instance.tint,
                palette_first: instance.palette_first % PAGE_ENTRIES,
            });
        }
        runs
    }
}

/// The determinant of the linear part; negative where it mirrors.
pub(crate) fn determinant(m: &Affine) -> f32 {
    let [a, b, c] = m.rows.map(|row| Vec3::new(row[0], row[1], row[2]));
    a.dot(b.cross(c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CharacterHandle;

    const PLAIN: CharacterFacts = CharacterFacts { entry_count: 3, blended: false };
    const GLASSY: CharacterFacts = CharacterFacts { entry_count: 3, blended: true };

    fn instance(character: usize, palette_first: u32, z: f32) -> Instance {
        let mut world_from_model = Affine::IDENTITY;
        world_from_model.rows[2][3] = z;
        let (moved, tint) = ([0.0; 3], [1.0; 3]);
        Instance {
            character: CharacterHandle(character),
            world_from_model,
            moved,
            palette_first,
            tint,
        }
    }

    fn batches(instances: &[Instance], characters: &[CharacterFacts]) -> Result<Batches, Error> {
        Batches::new(
            instances,
            characters,
            &|page| if page < 2 { 100 } else { 0 },
            Vec3::new(0.0, 0.0, 10.0),
        )
    }

    #[test]
    fn a_run_for_each_character_and_page() {
        let list = [
            instance(0, 0, 0.0),
            instance(1, 8, 0.0),
            instance(0, PAGE_ENTRIES + 4, 0.0),
            instance(0, 16, 5.0),
        ];
        let sorted = batches(&list, &[PLAIN, PLAIN]).unwrap();
        let run =
            |page, character, first, count| Run { page, character, mirrored: false, first, count };
        assert_eq!(sorted.opaque, [run(0, 0, 0, 2), run(0, 1, 2, 1), run(1, 0, 3, 1)]);
        let firsts: Vec<_> = sorted.instances.iter().map(|i| i.palette_first).collect();
        assert_eq!(firsts, [16, 0, 8, 4], "near ones first; places within the page");
        assert!(sorted.blended.is_empty());
    }

    #[test]
    fn blended_runs_go_from_far_to_near() {
        let list =
            [instance(0, 0, 0.0), instance(1, 0, -5.0), instance(0, 0, -9.0), instance(2, 0, -7.0)];
        let sorted = batches(&list, &[GLASSY, GLASSY, PLAIN]).unwrap();
        let order: Vec<_> = sorted
            .blended
            .iter()
            .map(|r| (r.character, sorted.instances[r.first as usize].world_row2[3]))
            .collect();
        assert_eq!(order, [(0, -9.0), (1, -5.0), (0, 0.0)]);
    }

    #[test]
    fn mirrored_instances_are_drawn_apart() {
        let mut mirrored = instance(0, 0, 0.0);
        mirrored.world_from_model.rows[0][0] = -1.0;
        let sorted = batches(&[mirrored, instance(0, 0, 0.0)], &[PLAIN]).unwrap();
        assert_eq!(sorted.opaque.iter().map(|r| r.mirrored).collect::<Vec<_>>(), [false, true]);
    }

    #[test]
    fn a_palette_must_lie_within_what_was_uploaded() {
        assert!(batches(&[instance(0, 97, 0.0)], &[PLAIN]).is_ok());
        let error = batches(&[instance(0, 0, 0.0), instance(0, 98, 0.0)], &[PLAIN]).unwrap_err();
        assert!(
            matches!(
                error,
                Error::NoPalette { instance: 1, page: 0, first: 98, count: 3, available: 100 }
            ),
            "{error}"
        );
        assert!(batches(&[instance(0, 2 * PAGE_ENTRIES, 0.0)], &[PLAIN]).is_err());
    }

    #[test]
    fn strangers_are_refused_and_nonsense_is_left_out() {
        let error = batches(&[instance(1, 0, 0.0)], &[PLAIN]).unwrap_err();
        assert!(matches!(error, Error::UnknownCharacter { instance: 0, count: 1 }), "{error}");
        let sorted = batches(&[instance(0, 0, f32::NAN), instance(0, 4, 0.0)], &[PLAIN]).unwrap();
        assert_eq!(sorted.instances.iter().map(|i| i.palette_first).collect::<Vec<_>>(), [4]);
    }
}
