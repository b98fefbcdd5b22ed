//! Calls that are refused change nothing and say why.

use populace::{ErrorKind, Placement};
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings};
use populace_locomotion::{Error, Goal, Path, WalkerSettings, Walkers};

use crate::fixture::{FRAME_SECS, Town};

/// All that is known of walkers, in words.
fn state(town: &Town) -> String {
    format!("{:?}", town.walkers)
}

#[track_caller]
fn refused<T: std::fmt::Debug>(
    town: &mut Town,
    says: &str,
    call: impl FnOnce(&mut Town) -> Result<T, Error>,
) {
    let before = state(town);
    let error = call(town).unwrap_err();
    assert!(error.to_string().contains(says), "{error}");
    assert_eq!(state(town), before, "{error}: something has changed");
}

#[test]
fn bad_numbers_are_refused() {
    let mut town = Town::new();
    let [one, _] = [0.0, 3.0].map(|x| town.add_at([x, 0.0]));
    town.send(one, 1.0, Goal::Velocity([1.0, 0.0]));
    town.step();
    for bad in [f32::NAN, f32::INFINITY, 20.1, -20.1] {
        let speed = "the speed of a walker is";
        refused(&mut town, speed, |town| town.walkers.set_velocities(&[[0.0; 2], [bad, 0.0]]));
        refused(&mut town, speed, |town| town.walkers.set_goal(one, Goal::Velocity([0.0, bad])));
        refused(&mut town, speed, |town| town.walkers.set_speed(one, bad));
    }
    refused(&mut town, "2 walkers; give one", |town| town.walkers.set_velocities(&[[0.0; 2]]));
    for bad in [f32::NAN, f32::NEG_INFINITY, 1.1e6] {
        refused(&mut town, "coordinate", |town| {
            town.walkers.set_goal(one, Goal::Point([0.0, bad]))
        });
        refused(&mut town, "heading", |town| town.walkers.set_facing(one, Some(bad)));
        refused(&mut town, "coordinate", |_| Path::new(&[[0.0; 2], [bad, 0.0]]));
    }
    refused(&mut town, "it needs at least 2", |_| Path::new(&[[0.0; 2]]));
    for bad in [f32::NAN, -0.1, 1.1] {
        refused(&mut town, "from 0 to 1 second", |town| town.walkers.update(&mut town.crowd, bad));
    }
    for bad in [0.0, f32::NAN, -1.0, f32::INFINITY] {
        let fine = WalkerSettings::default();
        for settings in [
            WalkerSettings { acceleration: bad, ..fine },
            WalkerSettings { deceleration: bad, ..fine },
            WalkerSettings { turn_rate: bad, ..fine },
            WalkerSettings { turn_acceleration: bad, ..fine },
            WalkerSettings { sideways: bad, ..fine },
            WalkerSettings { backwards: bad, ..fine },
        ] {
            let error = Walkers::new(settings).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
        }
    }
}

#[test]
fn bodies_of_extreme_sizes_are_refused() {
    let mut town = Town::new();
    town.avoid();
    let fine = [0.1, 10.0].map(|scale| town.add(Placement::at([0.0; 3]).scaled(scale)));
    for scale in [1e-4, 0.01, 20.0, 1e4] {
        let member = town.crowd.spawn(town.person, Placement::at([0.0; 3]).scaled(scale)).unwrap();
        refused(&mut town, "from 0.1 to 20 metres", |town| {
            town.walkers.add(&mut town.crowd, member)
        });
    }
    let far = town.crowd.spawn(town.person, Placement::at([2e6, 0.0, 0.0])).unwrap();
    refused(&mut town, "coordinate", |town| town.walkers.add(&mut town.crowd, far));
    for member in fine {
        town.send(member, 20.0, Goal::Velocity([20.0, 0.0]));
    }
    town.run(20.0);
    assert!(town.position(fine[1]).x > 100.0);
}

#[test]
fn who_is_no_walker_is_refused() {
    let mut town = Town::new();
    let other = town.crowd.spawn(town.person, Placement::at([0.0; 3])).unwrap();
    let says = "is no walker; make it one with Walkers::add";
    refused(&mut town, says, |town| town.walkers.set_goal(other, Goal::Stand));
    refused(&mut town, says, |town| town.walkers.set_speed(other, 1.0));
    refused(&mut town, says, |town| town.walkers.set_facing(other, None));
    refused(&mut town, says, |town| town.walkers.set_group(other, 1));
    refused(&mut town, says, |town| town.walkers.remove(other));
    let mut stranger = Town::new();
    let (walkers, crowd) = (&mut stranger.walkers, &mut town.crowd);
    assert_eq!(walkers.add(crowd, other).unwrap_err(), Error::NoGaits);
    assert!(walkers.members().is_empty());
}

#[test]
fn a_member_without_slots_for_its_gaits_stays_as_it_is() {
    let mut town = Town::new();
    let mut crowd = populace::Crowd::builder()
        .device(populace::Device::native())
        .slots_per_member(1)
        .build()
        .unwrap();
    let asset = town.crowd.character(town.person).unwrap().asset().clone();
    let person = crowd.add_character(asset).unwrap();
    let clips = ["Idle", "Walk"].map(|name| crowd.clip(person, name).unwrap());
    let gaits =
        populace_locomotion::GaitSpace::new(&mut crowd, person, clips[0], &clips[1..]).unwrap();
    (town.crowd, town.person) = (crowd, person);
    town.walkers.add_gaits(gaits);
    let member = town.crowd.spawn(person, Placement::at([0.0; 3])).unwrap();
    refused(&mut town, "slots", |town| town.walkers.add(&mut town.crowd, member));
    assert!(town.crowd.member_mut(member).unwrap().active_clips().is_empty());
}

#[test]
fn despawned_members_are_named_and_can_be_forgotten() {
    let mut town = Town::new();
    town.avoid();
    let all = [0.0, 2.0, 4.0].map(|x| town.add_at([x, 0.0]));
    town.walkers.set_velocities(&[[0.0, 1.0]; 3]).unwrap();
    town.run(0.5);
    town.crowd.despawn(all[0]).unwrap();
    let number = all[0].number();
    let says = format!("walker {number} was despawned; forget it with Walkers::remove");
    refused(&mut town, &says, |town| town.walkers.update(&mut town.crowd, FRAME_SECS));
    refused(&mut town, &says, |town| town.walkers.update(&mut town.crowd, 0.0));
    // A new member with the number of the old one takes its place.
    let newcomer = town.add_at([8.0, 0.0]);
    assert_eq!(
        (newcomer.number(), town.walkers.members()),
        (number, &[newcomer, all[1], all[2]][..])
    );
    town.run(0.1);
    assert_eq!(town.velocity(newcomer).length(), 0.0, "it does what the old one did");
    town.crowd.despawn(newcomer).unwrap();
    town.walkers.remove(newcomer).unwrap();
    assert_eq!(town.walkers.members(), [all[2], all[1]], "the last takes its place");
    town.run(1.0);
    assert!(all[1..].iter().all(|member| town.velocity(*member).y > 0.99));
    assert_eq!(town.walkers.remove(newcomer).unwrap_err().kind(), ErrorKind::NotFound);
    town.walkers.remove(all[2]).unwrap();
    let before = town.position(all[2]);
    town.run(0.5);
    assert_eq!(town.position(all[2]), before, "who is no walker stays");
}

#[test]
fn a_walker_that_is_added_again_begins_anew() {
    let mut town = Town::new();
    town.walkers.set_avoidance(Some(Avoidance::new(AvoidanceSettings::default()).unwrap()));
    let member = town.add_at([0.0; 2]);
    town.send(member, 1.0, Goal::Velocity([1.0, 0.0]));
    town.run(2.0);
    town.crowd.member_mut(member).unwrap().set_placement(Placement::at([5.0, 0.0, 5.0])).unwrap();
    town.walkers.add(&mut town.crowd, member).unwrap();
    assert_eq!(town.walkers.positions(), [[5.0, 5.0]]);
    assert_eq!(town.walkers.velocities(), [[0.0; 2]]);
    town.run(1.0);
    assert_eq!(town.position(member).to_array(), [5.0, 5.0]);
}

/// A member that the crowd refuses holds up no other walker once it is gone.
#[test]
fn who_was_refused_beside_another_shows_its_steps_later() {
    let mut town = Town::new();
    let [waves, walks] = [0.0, 3.0].map(|x| town.add_at([x, 0.0]));
    town.walkers.set_velocities(&[[0.0, 1.0]; 2]).unwrap();
    let idle = town.crowd.clip(town.person, "Idle").unwrap();
    let playback = populace::ClipPlayback::looping();
    town.crowd.member_mut(waves).unwrap().play(idle, playback).unwrap();
    for _ in 0..20 {
        // Each update renews what all walkers play, and is refused for one.
        let _ = town.walkers.update(&mut town.crowd, 0.1);
        town.crowd.update(0.1).unwrap();
    }
    assert_eq!(town.velocity(walks).length(), 1.0);
    town.walkers.remove(waves).unwrap();
    for _ in 0..5 {
        town.walkers.update(&mut town.crowd, 0.1).unwrap();
        town.crowd.update(0.1).unwrap();
    }
    let playing = town.crowd.member(walks).unwrap().active_clips();
    let still: f32 = playing.iter().filter(|clip| clip.clip == idle).map(|clip| clip.weight).sum();
    assert!(still < 0.5, "{playing:?}");
}

/// Others step as they move while the crowd refuses one of them.
#[test]
fn strides_are_told_beside_who_plays_something_else() {
    let joints = |refused: bool| {
        let mut town = Town::new();
        let [walks, waves] = [0.0, 3.0].map(|x| town.add_at([x, 0.0]));
        town.walkers.set_velocities(&[[0.0, 1.0]; 2]).unwrap();
        if refused {
            let idle = town.crowd.clip(town.person, "Idle").unwrap();
            let playback = populace::ClipPlayback::looping();
            town.crowd.member_mut(waves).unwrap().play(idle, playback).unwrap();
        }
        // Each update renews what all walkers play.
        for _ in 0..5 {
            assert_eq!(town.walkers.update(&mut town.crowd, 0.1).is_err(), refused);
            town.crowd.update(0.1).unwrap();
        }
        town.crowd.member_mut(walks).unwrap().model_from_joints().unwrap()
    };
    assert_eq!(joints(true), joints(false));
}
