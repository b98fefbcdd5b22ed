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
        is_floor: false,
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
    let mut casters = vec![None; instances.len()];
    casters.iter_mut().take(1).for_each(|c| *c = Some(Caster { level: 1, apart_m: 0.1 }));
    Batches::new(&Instances {
        all: &instances,
        models: &models,
        infos: &infos.iter().collect::<Vec<_>>(),
        page_lengths: &[100, 100],
        casters: &casters,
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
    let firsts: Vec<_> = sorted.instances.iter().map(|i| i.entry_and_number[0]).collect();
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

/// The palette includes root motion, which `world_from_model` does not.
#[test]
fn instances_are_sorted_where_root_motion_has_brought_them() {
    let swap = |instances: &mut [Instance<'_>]| {
        (instances[0].moved, instances[1].moved) = ([0.0, 0.0, -8.0], [0.0, 0.0, 8.0]);
    };
    let sorted = batches_with(&[(0, 0, 0.0), (0, 3, -5.0)], &[Blended], swap).unwrap();
    let firsts = |runs: &[Run]| {
        let numbers = runs.iter().flat_map(|run| run.first..run.first + run.count);
        numbers.map(|n| sorted.instances[n as usize].entry_and_number[0]).collect::<Vec<_>>()
    };
    assert_eq!(firsts(&sorted.blended), [0, 3], "back to front");
    assert_eq!(firsts(&sorted.opaque), [3, 0], "front to back");
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
fn group_keeps_its_parts() {
    let (level, page, model) = ((1 << 31) - 1, u32::MAX as usize, (1 << 62) - 1);
    let all = Group::new(level, page, model).with(Group::PLACE, true).with(Group::FADED, true);
    let run = Run { page, model, level, mirrored: false, faded: true, first: 3, count: 4 };
    assert_eq!(all.run(3, 4), run);
    let none = Group::new(0, 0, 0).with(Group::MIRRORED, true);
    let run = Run { page: 0, model: 0, level: 0, mirrored: true, faded: false, ..run };
    assert_eq!(none.run(3, 4), run);
    assert!(Group::new(level, page, model) < Group(0).with(Group::PLACE, true));
    assert!(Group::new(1, 9, 9) < Group::new(2, 0, 0));
}

#[test]
fn shares_of_threads_join_in_order() {
    let count = 2 * u16::try_from(SHARE).unwrap() + 77;
    // Nearer and nearer, in two models in turn.
    let mut placed: Vec<Placed> = (0..count)
        .map(|i| (usize::from(i % 2), 4 * u32::from(i % 24), f32::from(i) / 1e4))
        .collect();
    let sorted = batches(&placed, &[Opaque, Opaque]).unwrap();
    let numbers: Vec<u32> = sorted.instances.iter().map(|instance| instance.number()).collect();
    let last_first = |odd: u16| (0..count).rev().filter(move |i| i % 2 == odd).map(u32::from);
    let expected: Vec<u32> = [0].into_iter().chain(last_first(0)).chain(last_first(1)).collect();
    assert_eq!(numbers, expected, "the first throws a shadow");
    let counts: Vec<_> = sorted.opaque.iter().map(|run| (run.model, run.count)).collect();
    let half = u32::from(count / 2);
    assert_eq!(counts, [(0, half + 1), (1, half)]);
    for bad in [2 * SHARE + 5, SHARE + 9] {
        placed[bad].1 = 98;
        let error = batches(&placed, &[Opaque, Opaque]).unwrap_err();
        assert!(matches!(error, Error::NoPalette { instance, .. } if instance == bad), "{error}");
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
    assert_eq!(sorted.instances.iter().map(|i| i.entry_and_number[0]).collect::<Vec<_>>(), [4]);
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
        let first = |r: &Run| sorted.instances[r.first as usize].entry_and_number[0];
        runs.iter().map(|r| (r.level, r.count, first(r))).collect()
    };
    assert_eq!(runs(&sorted.shadow), [(1, 1, 0)]);
    assert_eq!(runs(&sorted.opaque), [(0, 1, 16), (1, 2, 12)], "level 7 counts as the last");
}
