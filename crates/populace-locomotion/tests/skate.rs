//! Foot skate on the standard course: of one of the people made by code, and of characters in the
//! folder `POPULACE_TEST_DATA` (environment variable).

#![expect(clippy::unwrap_used, reason = "tests panic on errors")]

use std::path::PathBuf;
use std::sync::Arc;

use populace::character::{Character, CharacterSource};
use populace::model::RoleMap;
use populace::{ClipId, Crowd, Device};
use populace_cast::cast;
use populace_locomotion::{Error, GaitClips, GaitSpace, Skate};

/// The most of each measure with planting.
struct Targets {
    mean_m_per_sec: f32,
    p95_m_per_sec: f32,
}

fn find<'a>(all: &'a [Skate], segment: &str, planting: bool) -> &'a Skate {
    all.iter().find(|one| one.segment == segment && one.planting == planting).unwrap()
}

#[track_caller]
fn holds(all: &[Skate], targets: &Targets) {
    let (planted, bare) = (find(all, "all", true), find(all, "all", false));
    assert!(planted.mean_m_per_sec <= targets.mean_m_per_sec, "{planted:?}");
    assert!(planted.p95_m_per_sec <= targets.p95_m_per_sec, "{planted:?}");
    assert!(planted.speed_error <= 0.02, "{planted:?}");
    assert!(planted.sole_error <= 0.01, "{planted:?}");
    assert!(planted.contact_share >= 0.95 * bare.contact_share, "{planted:?} {bare:?}");
    for segment in ["start", "stop", "turn"] {
        let part = find(all, segment, true);
        assert!(part.acceleration_ratio <= 1.5, "{part:?}");
    }
    // Feet slide if nothing plants them: else the course measures nothing.
    assert!(bare.mean_m_per_sec > 5.0 * planted.mean_m_per_sec, "{bare:?}");
    assert!(find(all, "turn", false).mean_m_per_sec > 0.1);
}

#[test]
fn a_built_in_person_hardly_skates() {
    let person = Arc::new(cast().unwrap().remove(0));
    let clips = GaitClips::of(&person).unwrap();
    let all = Skate::measure(&person, &clips).unwrap();
    assert_eq!(all.len(), 24);
    holds(&all, &Targets { mean_m_per_sec: 0.01, p95_m_per_sec: 0.04 });
    // Feet come down on treads, and rise to them without a jerk.
    let [planted, bare] = [true, false].map(|planting| find(&all, "stairs", planting));
    assert!(planted.sole_error < 0.005 && planted.acceleration_ratio < 1.0, "{planted:?}");
    assert!(bare.sole_error > 0.02, "{bare:?}");
}

#[test]
fn without_a_stride_a_gait_beyond_its_clips_misses_the_speed() {
    let person = Arc::new(cast().unwrap().remove(0));
    let all = Skate::measure(&person, &GaitClips::of(&person).unwrap()).unwrap();
    // 4 m/s is faster than the run: only planting lengthens its steps.
    let [planted, bare] = [true, false].map(|planting| find(&all, "straight 4", planting));
    assert!(bare.speed_error > 0.1 && planted.speed_error < 0.02, "{bare:?} {planted:?}");
}

#[test]
fn clips_are_chosen_by_their_gait() {
    for person in cast().unwrap().into_iter().map(Arc::new) {
        let name = |clip: &populace::clip::Clip| clip.name().to_owned();
        let chosen = GaitClips::of(&person).unwrap();
        let moving: Vec<_> = chosen.moving.iter().map(|clip| name(clip)).collect();
        assert_eq!(
            (name(&chosen.idle), moving),
            ("Idle".into(), vec!["Walk".into(), "Run".into()])
        );
        // Without the clip that stands, there is nothing to walk with.
        let moving = GaitClips::among(&person, &chosen.moving);
        assert!(moving.is_none());
    }
}

#[test]
fn a_gait_space_is_that_of_the_clips_that_are_chosen() {
    let person = Arc::new(cast().unwrap().remove(0));
    let mut crowd = Crowd::builder().device(Device::native()).capacity(1).build().unwrap();
    let id = crowd.add_character(Arc::clone(&person)).unwrap();
    let clips = crowd.character(id).unwrap().clips();
    let of =
        |name: &str| -> ClipId { clips.iter().find(|(_, clip)| clip.name() == name).unwrap().0 };
    let (idle, moving) = (of("Idle"), [of("Walk"), of("Run")]);
    let chosen = GaitSpace::of(&mut crowd, id).unwrap();
    let told = GaitSpace::new(&mut crowd, id, idle, &moving).unwrap();
    assert_eq!(chosen.speeds_m_per_sec(), told.speeds_m_per_sec());
    assert_eq!(chosen.at_speed(1.0), told.at_speed(1.0));
    assert_eq!(crowd.character(id).unwrap().clips().len(), clips.len(), "no clip was added");

    let source = CharacterSource { clips: Vec::new(), ..(**person).clone() };
    let bare = crowd.add_character(Arc::new(Character::new(source).unwrap())).unwrap();
    let error = GaitSpace::of(&mut crowd, bare).unwrap_err();
    assert!(matches!(error, Error::NoGaitClips { .. }), "{error}");
}

/// Loads a character of the test data, with feet that its legs move.
fn load(file: &str) -> Option<Arc<Character>> {
    let root = PathBuf::from(std::env::var_os("POPULACE_TEST_DATA")?);
    let character = populace_assets::load(root.join("characters").join(file)).unwrap().character;
    let roles = RoleMap::detect(&character.skeleton).unwrap();
    Some(Arc::new(character.with_feet_on_legs(&roles).unwrap()))
}

#[test]
fn clips_made_by_hand_hardly_skate() {
    let Some(knight) = load("kaykit_knight.glb") else { return };
    let clips = GaitClips::of(&knight).unwrap();
    assert_eq!(clips.moving.len(), 2);
    let all = Skate::measure(&knight, &clips).unwrap();
    holds(&all, &Targets { mean_m_per_sec: 0.02, p95_m_per_sec: 0.08 });
    // No foot is left behind and let go.
    let start = find(&all, "start", true);
    assert!(start.mean_m_per_sec < 0.01 && start.p95_m_per_sec < 0.04, "{start:?}");
}

#[test]
fn retargeted_clips_hardly_skate() {
    let Some(human) = load("m2m_human_base.glb") else { return };
    let person = cast().unwrap().remove(0);
    let clips = GaitClips::among(&human, &person.clips).unwrap();
    let all = Skate::measure(&human, &clips).unwrap();
    holds(&all, &Targets { mean_m_per_sec: 0.02, p95_m_per_sec: 0.08 });
}

#[test]
fn bodies_that_rest_in_the_middle_of_a_run_stand_by_their_bind_pose() {
    let Some(girl) = load("girl.glb") else { return };
    let person = cast().unwrap().remove(0);
    let clips = GaitClips::among(&girl, &person.clips).unwrap();
    let all = Skate::measure(&girl, &clips).unwrap();
    holds(&all, &Targets { mean_m_per_sec: 0.02, p95_m_per_sec: 0.08 });
}

#[test]
fn a_walk_and_a_fast_jog_hardly_skate_between_their_speeds() {
    // Feet of the mix stand as long as those of the walk, at thrice its speed.
    let Some(human) = load("m2m_human_base.glb") else { return };
    let clips = GaitClips::of(&human).unwrap();
    let all = Skate::measure(&human, &clips).unwrap();
    for segment in ["start", "straight 2", "straight 3", "straight 4"] {
        let part = find(&all, segment, true);
        assert!(part.mean_m_per_sec < 0.02 && part.p95_m_per_sec < 0.08, "{part:?}");
    }
    holds(&all, &Targets { mean_m_per_sec: 0.02, p95_m_per_sec: 0.08 });
}

#[test]
fn retargeted_clips_go_forwards_on_short_legs() {
    // Feet of this body hover while they stand and scrape while they swing.
    let Some(knight) = load("kaykit_knight.glb") else { return };
    let person = cast().unwrap().remove(0);
    let clips = GaitClips::among(&knight, &person.clips).unwrap();
    let names: Vec<_> = clips.moving.iter().map(|clip| clip.name()).collect();
    assert_eq!(names, ["Walk", "Run"]);
}

#[test]
fn legs_that_rest_behind_their_hips_step_beneath_them_without_a_pop() {
    let Some(girl) = load("girl.glb") else { return };
    let clips = GaitClips::of(&girl).unwrap();
    let all = Skate::measure(&girl, &clips).unwrap();
    for segment in ["start", "stop", "turn"] {
        let part = find(&all, segment, true);
        assert!(part.acceleration_ratio < 1.5, "{part:?}");
    }
}

#[test]
fn feet_that_are_longer_than_a_tread_stand_on_stairs() {
    let Some(robot) = load("quaternius_robot.glb") else { return };
    let person = cast().unwrap().remove(0);
    let clips = GaitClips::among(&robot, &person.clips).unwrap();
    let all = Skate::measure(&robot, &clips).unwrap();
    let part = find(&all, "stairs", true);
    assert!(part.sole_error < 0.01 && part.p95_m_per_sec < 0.01, "{part:?}");
}
