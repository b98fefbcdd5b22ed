//! Views: members that cannot be seen are not posed, and far ones get coarser levels.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

use std::sync::{Arc, OnceLock};

use populace::character::{Character, CharacterSource, Level, Region};
use populace::interop::{View, Visibility};
use populace::model::{JointSource, Skeleton};
use populace::{
    Affine, BackendError, ClipPlayback, Crowd, Device, Error, JointIndex, JointOverride,
    LiveSettings, MemberId, MemberLook, Placement, Schedule, Space, Target, Trs, ViewStatistics,
    Weight,
};

/// Joints that are left at the second level.
const JOINTS_LEFT: u8 = 20;

/// A man with two coarser levels, of which only errors and joints matter here.
fn man() -> Arc<Character> {
    static MAN: OnceLock<Arc<Character>> = OnceLock::new();
    let make = || {
        let man = populace_cast::cast().unwrap().remove(1);
        let meshes: Vec<_> = man.parts.iter().map(|part| part.mesh.clone()).collect();
        let level = |error_m, joint_count| Level { error_m, meshes: meshes.clone(), joint_count };
        let all = man.skeleton.joint_count();
        let levels = vec![level(0.01, all), level(0.04, JOINTS_LEFT.into())];
        Arc::new(man.with_levels(levels).unwrap())
    };
    Arc::clone(MAN.get_or_init(make))
}

/// A view from the origin along -z, a quarter turn wide and high, of 1000 pixels for a metre at a
/// distance of one metre.
fn view(error_px: f32) -> View {
    let k = std::f32::consts::FRAC_1_SQRT_2;
    View {
        eye: [0.0; 3],
        planes: [
            [k, 0.0, -k, 0.0],
            [-k, 0.0, -k, 0.0],
            [0.0, k, -k, 0.0],
            [0.0, -k, -k, 0.0],
            [0.0, 0.0, -1.0, 0.0],
        ],
        pixels_per_metre: 1000.0,
        to_sun: None,
        error_px,
    }
}

struct Scene {
    crowd: Crowd,
    members: Vec<MemberId>,
}

impl Scene {
    /// Members at positions, each of which walks.
    fn new(device: Device, schedule: Schedule, positions: &[[f32; 3]]) -> Self {
        let mut crowd = Crowd::builder().device(device).schedule(schedule).build().unwrap();
        let id = crowd.add_character(man()).unwrap();
        let walk = crowd.clip(id, "Walk").unwrap();
        let members = positions
            .iter()
            .map(|position| {
                let member = crowd.spawn(id, Placement::at(*position)).unwrap();
                let mut playing = crowd.member_mut(member).unwrap();
                playing.play(walk, ClipPlayback::looping()).unwrap();
                member
            })
            .collect();
        Self { crowd, members }
    }

    fn seen(&self) -> Vec<(Visibility, u32)> {
        self.crowd.instances().map(|instance| (instance.visibility, instance.level)).collect()
    }

    fn palette(&mut self, member: usize) -> Vec<u32> {
        let rows = self.crowd.member_mut(self.members[member]).unwrap().palette().unwrap();
        rows.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect()
    }

    #[track_caller]
    fn assert_not_posed(&mut self, member: usize, state: &str) {
        let found = self.crowd.member_mut(self.members[member]).unwrap().palette();
        assert_eq!(found, Err(Error::Backend(BackendError::NotEvaluated)), "{state}");
    }
}

const AHEAD: [f32; 3] = [0.0, -1.0, -10.0];
const BEHIND: [f32; 3] = [0.0, -1.0, 10.0];

#[test]
fn statistics_count_all_members_or_some() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[AHEAD, BEHIND, BEHIND]);
    scene.crowd.set_view(Some(view(0.0))).unwrap();
    scene.crowd.update(0.0).unwrap();
    let counts = |levels, hidden| ViewStatistics { levels, hidden, shadow_only: 0 };
    assert_eq!(scene.crowd.view_statistics(), counts(vec![1], 2));
    let but_first = |member| member != scene.members[0];
    assert_eq!(scene.crowd.view_statistics_of(but_first), counts(vec![], 2));
}

#[test]
fn hidden_members_are_not_posed_and_go_on_as_if_they_had_been() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        for device in [Device::native(), Device::opencl(0)] {
            if schedule == Schedule::FusedGrouped && device == Device::native() {
                continue;
            }
            let mut scene = Scene::new(device, schedule, &[AHEAD, BEHIND]);
            scene.crowd.update(0.0).unwrap();
            scene.crowd.set_view(Some(view(0.0))).unwrap();
            for _ in 0..3 {
                scene.crowd.update(0.1).unwrap();
            }
            assert_eq!(scene.seen(), [(Visibility::InView, 0), (Visibility::Hidden, 0)]);
            scene.palette(0);
            scene.assert_not_posed(1, &format!("{schedule}: hidden"));
            scene.crowd.set_view(None).unwrap();
            scene.crowd.update(0.1).unwrap();
            assert_eq!(scene.palette(0), scene.palette(1), "{schedule}");
        }
    }
}

#[test]
fn levels_follow_the_distance_and_change_with_hysteresis() {
    // The man reaches about 1.5 m from his hips, so 1 cm covers a pixel at roughly 11.5 m.
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[AHEAD]);
    let member = scene.members[0];
    scene.crowd.set_view(Some(view(1.0))).unwrap();
    let mut level_at = |z: f32| {
        scene.crowd.set_placements(&[(member, Placement::at([0.0, -1.0, -z]))]).unwrap();
        scene.crowd.update(0.0).unwrap();
        scene.crowd.instances().next().unwrap().level
    };
    let coarser = (1..1000).map(|z| z as f32 * 0.1).find(|z| level_at(*z) == 1).unwrap();
    assert!((10.0..16.0).contains(&coarser), "{coarser}");
    assert_eq!(level_at(coarser - 0.2), 1, "a step back does not change it");
    let finer = (1..1000).map(|z| coarser - z as f32 * 0.1).find(|z| level_at(*z) == 0).unwrap();
    assert!(finer < 0.95 * coarser, "{finer} {coarser}");
    assert_eq!((level_at(30.0), level_at(1000.0), level_at(1.0)), (1, 2, 0));
}

#[test]
fn joints_that_a_level_leaves_out_are_read_as_at_rest() {
    let far = [0.0, -1.0, -1000.0];
    for (device, schedule) in [
        (Device::native(), Schedule::Staged),
        (Device::native(), Schedule::Fused),
        (Device::opencl(0), Schedule::Staged),
        (Device::opencl(0), Schedule::FusedWide),
    ] {
        let mut scene = Scene::new(device, schedule, &[AHEAD, far]);
        scene.crowd.set_view(Some(view(1.0))).unwrap();
        scene.crowd.update(0.3).unwrap();
        assert_eq!(scene.seen()[1], (Visibility::InView, 2));
        let joints: Vec<_> = scene
            .members
            .iter()
            .flat_map(|member| man().skeleton.joints().map(|joint| (*member, joint)))
            .collect();
        assert!(joints.len() > 2 * usize::from(JOINTS_LEFT));
        let mut found = vec![Affine::IDENTITY; joints.len()];
        scene.crowd.read_joints(&joints, &mut found).unwrap();
        let wanted = [0, 1].map(|nth: usize| {
            let mut member = scene.crowd.member_mut(scene.members[nth]).unwrap();
            member.model_from_joints().unwrap()
        });
        assert!(found == wanted.concat(), "{schedule}");
    }
}

#[test]
fn hidden_members_keep_their_level() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[AHEAD]);
    let far = AHEAD.map(|metres| 3.0 * metres);
    for (place, error_px, seen) in [
        (far, 1.0, (Visibility::InView, 1)),
        (BEHIND, 1.0, (Visibility::Hidden, 1)),
        (BEHIND, 0.0, (Visibility::Hidden, 1)),
        (AHEAD, 0.0, (Visibility::InView, 0)),
        (BEHIND, 100.0, (Visibility::Hidden, 0)),
        (AHEAD, 100.0, (Visibility::InView, 2)),
    ] {
        scene.crowd.set_view(Some(view(error_px))).unwrap();
        let mut member = scene.crowd.member_mut(scene.members[0]).unwrap();
        member.set_placement(Placement::at(place)).unwrap();
        scene.crowd.update(0.1).unwrap();
        assert_eq!(scene.seen(), [seen], "at {place:?} with {error_px} px");
    }
}

#[test]
fn visible_members_are_listed_in_runs_with_what_a_renderer_needs() {
    let far = [0.0, -1.0, -30.0];
    let mut scene =
        Scene::new(Device::native(), Schedule::Fused, &[far, BEHIND, AHEAD, far, AHEAD]);
    let id = scene.crowd.add_character(man()).unwrap();
    let other = scene.crowd.spawn(id, Placement::at(AHEAD)).unwrap();
    scene.crowd.set_view(Some(view(1.0))).unwrap();
    scene.crowd.update(0.1).unwrap();
    let mut list = Vec::new();
    scene.crowd.visible_members(&mut list);
    scene.crowd.visible_members(&mut list);
    let of = |nth: usize| scene.members[nth];
    let runs: Vec<Vec<MemberId>> = list
        .chunk_by(|a, b| a.run() == b.run())
        .map(|run| run.iter().map(|visible| visible.member).collect())
        .collect();
    assert_eq!(runs, [vec![of(2), of(4)], vec![of(0), of(3)], vec![other]]);
    for visible in list {
        let member = scene.crowd.member(visible.member).unwrap();
        let instance = member.instance();
        assert_eq!((visible.center, visible.radius_m), member.bounding_sphere());
        assert_eq!(visible.world_from_model, instance.world_from_model);
        assert_eq!(visible.palette_first, instance.palette_first);
        assert_eq!((visible.moved, visible.look), (instance.moved, instance.look));
        assert_eq!((visible.level, visible.visibility), (instance.level, instance.visibility));
    }
}

/// Seconds for which nobody in view may keep a pose.
const LONGEST_POSE_SECS: f32 = 0.1;

#[test]
fn nobody_in_view_keeps_a_pose() {
    let distances = [3.0, 10.0, 30.0, 100.0, 300.0, 1000.0];
    let places = distances.map(|z: f32| [0.1 * z, -1.0, -z]);
    for (device, schedule) in [
        (Device::native(), Schedule::Staged),
        (Device::native(), Schedule::Fused),
        (Device::opencl(0), Schedule::Staged),
        (Device::opencl(0), Schedule::FusedWide),
        (Device::opencl(0), Schedule::FusedGrouped),
    ] {
        let mut scene = Scene::new(device, schedule, &places);
        scene.crowd.set_view(Some(view(1.0))).unwrap();
        scene.crowd.update(LONGEST_POSE_SECS).unwrap();
        let levels: Vec<_> = scene.seen().iter().map(|seen| seen.1).collect();
        assert_eq!((levels[0], levels[5]), (0, 2), "near and far members are seen: {levels:?}");
        for frame in 0..8 {
            let before: Vec<_> = (0..places.len()).map(|member| scene.palette(member)).collect();
            scene.crowd.update(LONGEST_POSE_SECS).unwrap();
            for (member, before) in before.iter().enumerate() {
                assert!(
                    scene.palette(member) != *before,
                    "{schedule}, frame {frame}: the member {} m away keeps its pose",
                    distances[member]
                );
            }
        }
    }
}

#[test]
fn far_members_are_posed_with_fewer_joints() {
    const FAR: [f32; 3] = [0.0, -1.0, -100.0];
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        for device in [Device::native(), Device::opencl(0)] {
            if schedule == Schedule::FusedGrouped && device == Device::native() {
                continue;
            }
            let mut scene = Scene::new(device, schedule, &[FAR, FAR, FAR]);
            let [plain, planted, shaped] = *scene.members else { panic!() };
            scene.crowd.member_mut(planted).unwrap().plant_feet(1.0).unwrap();
            let (joint, transform) = (JointIndex(JOINTS_LEFT.into()), Trs::IDENTITY);
            let bent = JointOverride { joint, space: Space::Local, transform, weight: 1.0 };
            scene.crowd.member_mut(shaped).unwrap().override_joints(&[bent]).unwrap();
            scene.crowd.update(0.1).unwrap();
            let whole: Vec<_> = (0..3).map(|m| scene.palette(m)).collect();
            scene.crowd.set_view(Some(view(1.0))).unwrap();
            scene.crowd.update(0.0).unwrap();
            assert!(scene.seen().iter().all(|seen| *seen == (Visibility::InView, 2)));
            let man = man();
            let is_left = |entry: usize| man.palette[entry].joint.index() < JOINTS_LEFT.into();
            for (member, whole) in whole.iter().enumerate() {
                let now = scene.palette(member);
                let equal = |e: &usize| now[12 * e..][..12] == whole[12 * e..][..12];
                let entries = 0..man.palette.len();
                let what = format!("{schedule}, member {member}");
                assert!(entries.clone().filter(|e| is_left(*e)).all(|e| equal(&e)), "{what}");
                let changed = entries.filter(|e| !equal(e)).count();
                assert_eq!(changed > 10, member != 2, "{what}: {changed} entries changed");
            }
            let mut reading = scene.crowd.member_mut(plain).unwrap();
            let (locals, models) =
                (reading.local_pose().unwrap(), reading.model_from_joints().unwrap());
            for joint in man.skeleton.joints().skip(JOINTS_LEFT.into()) {
                assert_eq!(locals[joint.index()], *man.skeleton.rest(joint), "{joint:?}");
            }
            for (entry, matrix) in man.palette.iter().zip(reading.palette().unwrap()) {
                let expected = models[entry.joint.index()].mul(&entry.joint_from_bind);
                let pairs = expected.rows.iter().flatten().zip(matrix.rows.iter().flatten());
                let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 1e-5, "{schedule}, joint {}: {off}", entry.joint.0);
            }
        }
    }
}

/// A constraint that needs more joints than were evaluated holds from the next update on.
#[test]
fn results_are_read_as_they_were_evaluated() {
    for schedule in [Schedule::Staged, Schedule::FusedWide] {
        for device in [Device::native(), Device::opencl(0)] {
            let mut scene = Scene::new(device, schedule, &[[0.0, -1.0, -100.0]]);
            let member = scene.members[0];
            scene.crowd.set_view(Some(view(1.0))).unwrap();
            scene.crowd.update(0.1).unwrap();
            let mut member = scene.crowd.member_mut(member).unwrap();
            let before = member.model_from_joints().unwrap();
            let (joint, transform) = (JointIndex(JOINTS_LEFT.into()), Trs::IDENTITY);
            let bent = JointOverride { joint, space: Space::Local, transform, weight: 1.0 };
            member.override_joints(&[bent]).unwrap();
            assert_eq!(member.model_from_joints().unwrap(), before, "{schedule}");
        }
    }
}

/// The rows of a removed character's reduced bodies point into tables that others fill.
#[test]
fn characters_with_levels_are_removed_whole() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let (wide, deep) = (chain(40, 1), chain(40, 39));
    let first = crowd.add_character(with_level(chain(9, 3), 4)).unwrap();
    crowd.add_character(wide).unwrap();
    crowd.remove(first).unwrap();
    for character in [chain(7, 6), deep, chain(3, 1)] {
        let id = crowd.add_character(character).unwrap();
        crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
        crowd.update(0.1).unwrap();
    }
}

/// Returns `count` joints, of which the first `deep` hang on each other and the others on the last of
/// those.
fn chain(count: usize, deep: usize) -> Character {
    let joint = |nth: usize| JointSource {
        name: format!("{nth}"),
        parent: nth.checked_sub(1).map(|before| before.min(deep)),
        rest: Trs::IDENTITY,
    };
    let skeleton = Skeleton::new(&(0..count).map(joint).collect::<Vec<_>>()).unwrap();
    let (palette, parts, materials, images, skins, clips) =
        (vec![], vec![], vec![], vec![], vec![], vec![]);
    let name = "chain".into();
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Character::new(source).unwrap()
}

fn with_level(character: Character, joint_count: usize) -> Character {
    let level = Level { error_m: 0.1, meshes: Vec::new(), joint_count };
    character.with_levels(vec![level]).unwrap()
}

#[test]
fn members_that_others_need_or_whose_reach_is_unknown_are_posed() {
    let mut scene =
        Scene::new(Device::native(), Schedule::Fused, &[BEHIND, BEHIND, BEHIND, BEHIND, BEHIND]);
    let [watched, moving, shaped, carried, gazing] = *scene.members else { panic!() };
    let crowd = &mut scene.crowd;
    crowd.member_mut(watched).unwrap().watch_joint(JointIndex(3)).unwrap();
    crowd.member_mut(moving).unwrap().start_root_motion().unwrap();
    crowd.member_mut(carried).unwrap().attach_to(shaped, JointIndex(4), Trs::IDENTITY).unwrap();
    crowd
        .member_mut(gazing)
        .unwrap()
        .look_at(Target::Point([0.0, 1.0, 0.0]), Weight::FULL)
        .unwrap();
    crowd.update(0.0).unwrap();
    crowd.set_view(Some(view(0.0))).unwrap();
    for _ in 0..3 {
        crowd.update(0.1).unwrap();
    }
    (0..4).for_each(|member| drop(scene.palette(member)));
    scene.assert_not_posed(4, "gaze alone needs no pose");
    let seen: Vec<_> = scene.seen().iter().map(|seen| seen.0).collect();
    use Visibility::{Hidden, InView};
    assert_eq!(seen, [Hidden, Hidden, Hidden, InView, Hidden]);
}

/// Poses of a live clip may be anywhere, but only those of members that play it.
#[test]
fn live_clips_show_their_own_members_alone() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[BEHIND, BEHIND]);
    let [live, plain] = *scene.members else { panic!() };
    scene.crowd.set_view(Some(view(0.0))).unwrap();
    let body = scene.crowd.member(live).unwrap().character();
    let sphere = |scene: &Scene| scene.crowd.member(plain).unwrap().bounding_sphere();
    let before = sphere(&scene);
    let mut character = scene.crowd.character_mut(body).unwrap();
    let clip = character.add_live_clip("Actor", &LiveSettings::default()).unwrap();
    scene.crowd.member_mut(live).unwrap().play(clip, ClipPlayback::live(0.1)).unwrap();
    scene.crowd.update(0.1).unwrap();
    assert_eq!(sphere(&scene), before);
    assert_eq!(scene.seen(), [(Visibility::InView, 0), (Visibility::Hidden, 0)]);
    let walk = scene.crowd.clip(body, "Walk").unwrap();
    scene.crowd.member_mut(live).unwrap().play(walk, ClipPlayback::looping()).unwrap();
    scene.crowd.update(0.1).unwrap();
    assert_eq!(scene.seen(), [(Visibility::Hidden, 0); 2], "the live clip has ended");
}

#[test]
fn members_in_their_own_build_again_are_hidden_again() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[BEHIND]);
    scene.crowd.set_view(Some(view(0.0))).unwrap();
    let joints = man().skeleton.joint_count();
    for (factor, visibility) in [(1.3, Visibility::InView), (1.0, Visibility::Hidden)] {
        let mut member = scene.crowd.member_mut(scene.members[0]).unwrap();
        member.set_proportions(&vec![factor; joints]).unwrap();
        scene.crowd.update(0.1).unwrap();
        assert_eq!(scene.seen(), [(visibility, 0)], "proportions of {factor}");
    }
}

#[test]
fn a_run_from_a_snapshot_repeats_to_the_bit() {
    for device in [Device::native(), Device::opencl(0)] {
        let mut scene = Scene::new(device, Schedule::Fused, &[AHEAD, BEHIND, [12.0, 0.0, -9.0]]);
        let members = scene.members.clone();
        scene.crowd.member_mut(members[2]).unwrap().plant_feet(1.0).unwrap();
        let run = |scene: &mut Scene, frames: std::ops::Range<i32>| -> Vec<_> {
            frames
                .flat_map(|frame| {
                    let x = (frame % 40 - 20) as f32;
                    let places: Vec<_> = (0..3)
                        .map(|m| (members[m], Placement::at([x * (m as f32 - 1.0), 0.0, -11.0])))
                        .collect();
                    scene.crowd.set_placements(&places).unwrap();
                    scene.crowd.update(1.0 / 30.0).unwrap();
                    let seen = scene.seen();
                    let posed = |m: &usize| seen[*m].0 != Visibility::Hidden;
                    (0..3)
                        .map(|m| (seen[m], posed(&m).then(|| scene.palette(m))))
                        .collect::<Vec<_>>()
                })
                .collect()
        };
        scene.crowd.update(0.0).unwrap();
        scene.crowd.set_view(Some(view(1.0))).unwrap();
        run(&mut scene, 0..25);
        let snapshot = scene.crowd.snapshot().unwrap();
        let first = run(&mut scene, 25..70);
        let kinds = |wanted| first.iter().filter(|((seen, _), _)| *seen == wanted).count();
        assert!(kinds(Visibility::Hidden) > 5 && kinds(Visibility::InView) > 5);
        scene.crowd.restore(&snapshot).unwrap();
        assert!(run(&mut scene, 25..70) == first);
    }
}

#[test]
fn looks_are_kept_by_snapshots_and_end_with_the_member() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[AHEAD]);
    let (crowd, member) = (&mut scene.crowd, scene.members[0]);
    let look = MemberLook::PLAIN.tinted(Region::Hair, [0.5; 3]).without_option(3);
    crowd.member_mut(member).unwrap().set_look(look);
    crowd.update(0.1).unwrap();
    let snapshot = crowd.snapshot().unwrap();
    crowd.member_mut(member).unwrap().set_look(MemberLook::PLAIN);
    assert_eq!(crowd.instances().next().unwrap().look, MemberLook::PLAIN);
    crowd.restore(&snapshot).unwrap();
    assert_eq!(crowd.member(member).unwrap().look(), look);
    assert_eq!(crowd.instances().next().unwrap().look, look);
    let character = crowd.member(member).unwrap().character();
    crowd.despawn(member).unwrap();
    let next = crowd.spawn(character, Placement::at([0.0; 3])).unwrap();
    assert_eq!(crowd.member(next).unwrap().look(), MemberLook::PLAIN);
}

#[test]
fn views_with_numbers_out_of_range_are_refused() {
    let mut scene = Scene::new(Device::native(), Schedule::Fused, &[AHEAD]);
    for bad in [
        View { eye: [f32::NAN, 0.0, 0.0], ..view(1.0) },
        View { pixels_per_metre: f32::INFINITY, ..view(1.0) },
        View { pixels_per_metre: f32::NAN, ..view(1.0) },
        View { pixels_per_metre: -5.0, ..view(1.0) },
        View { pixels_per_metre: 0.0, ..view(1.0) },
        View { to_sun: Some([f32::NAN; 3]), ..view(1.0) },
        view(-1.0),
        view(f32::NAN),
    ] {
        scene.crowd.set_view(Some(bad)).unwrap_err();
        assert!(scene.crowd.view().is_none());
    }
}
