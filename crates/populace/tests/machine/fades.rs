//! Poses never jump: neither on transitions, however fast parameters change, nor as machines start
//! and stop.

use populace::{ClipPlayback, MachinePlayback, MemberId};
use populace_testkit::Rng;

use crate::arm::{rotations, step_rad};
use crate::fixture::{Scene, everywhere, on_native};

const STEP_SECS: f32 = 1.0 / 240.0;

/// Updates the crowd and returns the largest rotation of a joint in radians.
fn step(scene: &mut Scene, member: MemberId) -> f32 {
    step_of(scene, member, STEP_SECS)
}

fn step_of(scene: &mut Scene, member: MemberId, secs: f32) -> f32 {
    let before = rotations(&mut scene.crowd, member);
    scene.crowd.update(secs).unwrap();
    step_rad(&before, &rotations(&mut scene.crowd, member))
}

#[test]
fn joints_never_jump_however_fast_parameters_change() {
    let mut scene = Scene::new(&on_native());
    let (member, mut random, mut worst) = (scene.machine_instance(0), Rng::new(9), 0.0_f32);
    scene.frame();
    for _ in 0..4000 {
        // The range includes the values that lead out of "sit" with a cut.
        scene.edit(member).set_parameter("speed", random.between(-3.0, 3.0) as f32).unwrap();
        scene.edit(member).set_parameter("jump", random.between(-1.0, 1.0) as f32).unwrap();
        worst = worst.max(step(&mut scene, member));
        if &*scene.crowd.member_mut(member).unwrap().machine_state(0).unwrap() == "sit" {
            scene
                .crowd
                .member_mut(member)
                .unwrap()
                .play_machine(scene.machine, MachinePlayback::new().fade_in_secs(0.2))
                .unwrap();
        }
    }
    // A fade takes at least 24 steps, poses are at most 2 rad apart, and clips move meanwhile.
    assert!(worst < 0.15, "a joint turned {worst} rad in a step");
    assert!(worst > 0.02, "nothing moved: {worst} rad per step");
}

#[test]
fn machine_fades_in_over_a_clip_and_out_under_one() {
    for builder in everywhere() {
        let mut scene = Scene::new(&builder);
        let member = scene.member(0);
        let (walk, run) = (scene.clips[1], scene.clips[2]);
        let mut worst = 0.0_f32;
        scene.edit(member).play(run, ClipPlayback::looping()).unwrap();
        scene.frame();
        scene
            .crowd
            .member_mut(member)
            .unwrap()
            .play_machine(scene.machine, MachinePlayback::new().fade_in_secs(0.3))
            .unwrap();
        scene.edit(member).set_parameter("speed", 1.0).unwrap();
        for _ in 0..100 {
            worst = worst.max(step(&mut scene, member));
        }
        assert_eq!(
            scene.crowd.member(member).unwrap().active_clips(),
            [],
            "active_clips lists clips of a machine"
        );
        let direct = scene.member(0);
        scene.edit(direct).play(walk, ClipPlayback::looping()).unwrap();
        scene.edit(member).play(walk, ClipPlayback::looping().fade_in_secs(0.3)).unwrap();
        for _ in 0..80 {
            worst = worst.max(step(&mut scene, member));
        }
        assert_eq!(scene.bits(member), scene.bits(direct), "the machine has not faded out");
        scene.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
        // On a layer above, the clip below fills the remaining weight.
        let machine = MachinePlayback::new().on_layer(1).fade_in_secs(0.3);
        let id =
            scene.crowd.member_mut(member).unwrap().play_machine(scene.machine, machine).unwrap();
        scene.edit(member).set_layer(1, populace::LayerSettings::default(), None).unwrap();
        for frame in 0..300 {
            if frame == 100 {
                scene.edit(id.member()).set_weight(id, 0.4, 0.2).unwrap();
            }
            if frame == 200 {
                scene.edit(member).stop(1, 0.3).unwrap();
            }
            worst = worst.max(step(&mut scene, member));
        }
        assert_eq!(scene.bits(member), scene.bits(direct), "the machine has not faded out");
        assert!(worst > 0.005 && worst < 0.04, "{worst}, {:?}", scene.crowd.device_info().schedule);
    }
}

/// The weight of a machine on a layer above is split evenly between its two slots.
#[test]
fn machine_weight_equals_that_of_a_clip() {
    let mut scene = Scene::new(&on_native());
    let [machine, direct] = [(); 2].map(|()| scene.member(0));
    let above = ClipPlayback::looping().on_layer(1).weight(0.3);
    for member in [machine, direct] {
        scene
            .crowd
            .member_mut(member)
            .unwrap()
            .play(scene.clips[2], ClipPlayback::looping())
            .unwrap();
        scene.edit(member).set_layer(1, populace::LayerSettings::default(), None).unwrap();
    }
    let run = scene
        .crowd
        .member_mut(machine)
        .unwrap()
        .play_machine(scene.machine, MachinePlayback::new().on_layer(1).weight(0.3))
        .unwrap();
    let play =
        scene.crowd.member_mut(direct).unwrap().play(scene.clips[0], above.phase(0.25)).unwrap();
    for id in [run, play] {
        scene.edit(id.member()).set_speed(id, 1.0).unwrap();
        scene.edit(id.member()).set_weight(id, 0.7, 0.5).unwrap();
    }
    for _ in 0..30 {
        scene.frame();
        assert_eq!(scene.bits(machine), scene.bits(direct));
    }
}

/// Returns the largest rotation of a joint per step, in radians, while clips, blends and machines
/// compete for `slots` slots.
fn worst_step_with_slots(slots: usize, steps_per_sec: u16) -> f32 {
    let mut scene = Scene::new(&on_native().slots_per_member(slots));
    let (member, mut random, mut worst) = (scene.member(0), Rng::new(slots as u64), 0.0_f32);
    scene.crowd.member_mut(member).unwrap().play(scene.clips[0], ClipPlayback::looping()).unwrap();
    scene.frame();
    for step in 0..30 * steps_per_sec {
        if step % (steps_per_sec / 30) == 0 {
            let fade_secs = random.between(0.2, 0.6) as f32;
            let play = ClipPlayback::looping().fade_in_secs(fade_secs);
            let clip = scene.clips[random.below(3)];
            let speed = random.between(-1.0, 0.2) as f32;
            match random.below(10) {
                0 | 1 => drop(scene.crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
                2 => drop(
                    scene.crowd.member_mut(member).unwrap().blend(clip, play.weight(0.6)).unwrap(),
                ),
                3 | 4 => drop(
                    scene
                        .crowd
                        .member_mut(member)
                        .unwrap()
                        .play_machine(scene.machine, MachinePlayback::new().fade_in_secs(fade_secs))
                        .unwrap(),
                ),
                5 => drop(
                    scene
                        .crowd
                        .member_mut(member)
                        .and_then(|mut m| m.set_parameter("speed", speed)),
                ),
                _ => {}
            }
        }
        worst = worst.max(step_of(&mut scene, member, 1.0 / f32::from(steps_per_sec)));
    }
    worst
}

#[test]
fn poses_never_jump_when_slots_are_scarce() {
    for slots in [4, 5, 8] {
        let [coarse, fine] = [240, 960].map(|steps| worst_step_with_slots(slots, steps));
        // A fast joint moves a fourth as far in a fourth of the time; a jump stays as large.
        assert!(fine < 0.35 * coarse, "{fine} of {coarse} with {slots} slots");
    }
}
