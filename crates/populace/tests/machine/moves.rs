//! Machine states survive moves to other devices and changes of the split.

use populace::clip::ticks_from_secs;
use populace::{Crowd, Device, Devices, MemberId, Split};
use populace_testkit::Rng;

use crate::fixture::{FRAME_SECS, Interpreter, Scene, everywhere, on_native};

fn members(scene: &mut Scene) -> Vec<(MemberId, Interpreter)> {
    (0..12).map(|n| (scene.machine_instance(n % 2), Interpreter::new())).collect()
}

fn frames(
    scene: &mut Scene,
    members: &mut [(MemberId, Interpreter)],
    random: &mut Rng,
    count: usize,
) {
    for _ in 0..count {
        for (member, own) in members.iter_mut() {
            if random.chance(0.1) {
                own.speed = [-1.0, 0.0, 1.0, 2.5][random.below(4)];
            }
            own.set_parameters(&mut scene.crowd, *member);
        }
        scene.frame();
        for (_, own) in members.iter_mut() {
            own.step(ticks_from_secs(FRAME_SECS.into()));
        }
    }
}

#[track_caller]
fn assert_states(crowd: &mut Crowd, members: &[(MemberId, Interpreter)]) {
    for (member, own) in members {
        assert_eq!(&*crowd.member_mut(*member).unwrap().machine_state(0).unwrap(), own.state);
    }
}

fn devices() -> Vec<Devices> {
    everywhere().into_iter().map(|builder| builder.build().unwrap().device_info().devices).collect()
}

#[test]
fn machine_states_move_with_the_crowd() {
    let mut stays = Scene::new(&on_native());
    let mut stay = members(&mut stays);
    let mut moves = Scene::new(&on_native());
    let mut moved = members(&mut moves);
    let mut randoms = [Rng::new(3), Rng::new(3)];
    for devices in devices() {
        frames(&mut stays, &mut stay, &mut randoms[0], 31);
        frames(&mut moves, &mut moved, &mut randoms[1], 31);
        // Two moves without a frame in between. Before them a machine starts that no device has
        // run; after them a member is despawned.
        let (late, gone) = (moves.machine_instance(0), moves.machine_instance(1));
        moves.crowd.move_to(Device::native()).unwrap();
        moves.crowd.move_to(devices).unwrap();
        moves.crowd.despawn(gone).unwrap();
        assert_states(&mut moves.crowd, &moved);
        assert_eq!(&*moves.crowd.member_mut(late).unwrap().machine_state(0).unwrap(), "idle");
        frames(&mut stays, &mut stay, &mut randoms[0], 1);
        frames(&mut moves, &mut moved, &mut randoms[1], 1);
        moves.crowd.despawn(late).unwrap();
        assert_states(&mut moves.crowd, &moved);
        for ((stay, _), (moved, _)) in stay.iter().zip(&moved) {
            assert_eq!(moves.bits(*moved), stays.bits(*stay));
        }
    }
}

#[test]
fn members_despawned_between_move_and_frame_do_no_harm() {
    let mut scene = Scene::new(&on_native());
    let members = [(); 5].map(|()| scene.machine_instance(0));
    scene.frame();
    scene.crowd.move_to(Device::Native { threads: 1 }).unwrap();
    members[1..].iter().for_each(|member| scene.crowd.despawn(*member).unwrap());
    scene.frame();
    assert_eq!(&*scene.edit(members[0]).machine_state(0).unwrap(), "idle");
}

#[test]
fn idle_device_gets_the_states_of_members_it_takes_over() {
    let devices = [Device::Native { threads: 1 }, Device::Native { threads: 2 }];
    let share = |a, b| Split::Fixed(vec![a, b]);
    let mut stays = Scene::new(&on_native());
    let mut stay = members(&mut stays);
    let mut split = Scene::new(&Crowd::builder().devices(devices).split(share(1.0, 0.0)));
    let mut shared = members(&mut split);
    let mut randoms = [Rng::new(4), Rng::new(4)];
    for shares in [share(0.0, 1.0), share(1.0, 0.0), share(0.5, 0.5), share(0.0, 1.0)] {
        frames(&mut stays, &mut stay, &mut randoms[0], 40);
        frames(&mut split, &mut shared, &mut randoms[1], 40);
        assert_states(&mut split.crowd, &shared);
        split.crowd.set_split(&shares).unwrap();
        frames(&mut stays, &mut stay, &mut randoms[0], 1);
        frames(&mut split, &mut shared, &mut randoms[1], 1);
        for ((stay, _), (shared, _)) in stay.iter().zip(&shared) {
            assert_eq!(split.bits(*shared), stays.bits(*stay));
        }
    }
}
