//! Nothing jumps: neither from state to state, however parameters change, nor as machines come and
//! go.

use populace::{ClipPlayback, MachinePlayback, MemberId};
use populace_testkit::Rng;

use crate::arm::{step_rad, turns};
use crate::rig::{Stage, everywhere, on_native};

const STEP_SECS: f32 = 1.0 / 240.0;

/// Steps the crowd and tells how far a joint turned at most.
fn step(stage: &mut Stage, member: MemberId) -> f32 {
    step_of(stage, member, STEP_SECS)
}

fn step_of(stage: &mut Stage, member: MemberId, secs: f32) -> f32 {
    let before = turns(&mut stage.crowd, member);
    stage.crowd.update(secs).unwrap();
    step_rad(&before, &turns(&mut stage.crowd, member))
}

#[test]
fn no_joint_jumps_however_fast_parameters_change() {
    let mut stage = Stage::new(&on_native());
    let (member, mut random, mut worst) = (stage.machine_instance(0), Rng::new(9), 0.0_f32);
    stage.frame();
    for _ in 0..4000 {
        // Above what leads out of "sit", which cuts.
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .set_parameter("speed", random.between(-3.0, 3.0) as f32)
            .unwrap();
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .set_parameter("jump", random.between(-1.0, 1.0) as f32)
            .unwrap();
        worst = worst.max(step(&mut stage, member));
        if &*stage.crowd.member_mut(member).unwrap().machine_state(0).unwrap() == "sit" {
            stage
                .crowd
                .member_mut(member)
                .unwrap()
                .play_machine(stage.machine, MachinePlayback::new().fade_in_secs(0.2))
                .unwrap();
        }
    }
    // A fade takes 24 steps at least, between poses that are 2 rad apart at most, and clips move
    // meanwhile.
    assert!(worst < 0.15, "{worst}");
    assert!(worst > 0.02, "nothing moved: {worst}");
}

#[test]
fn machines_fade_in_over_clips_and_out_under_them() {
    for builder in everywhere() {
        let mut stage = Stage::new(&builder);
        let member = stage.member(0);
        let (walk, run) = (stage.clips[1], stage.clips[2]);
        let mut worst = 0.0_f32;
        stage.crowd.member_mut(member).unwrap().play(run, ClipPlayback::looping()).unwrap();
        stage.frame();
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .play_machine(stage.machine, MachinePlayback::new().fade_in_secs(0.3))
            .unwrap();
        stage.crowd.member_mut(member).unwrap().set_parameter("speed", 1.0).unwrap();
        for _ in 0..100 {
            worst = worst.max(step(&mut stage, member));
        }
        assert_eq!(
            stage.crowd.member(member).unwrap().active_clips(),
            [],
            "what a machine plays only the device knows"
        );
        let hand = stage.member(0);
        stage.crowd.member_mut(hand).unwrap().play(walk, ClipPlayback::looping()).unwrap();
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .play(walk, ClipPlayback::looping().fade_in_secs(0.3))
            .unwrap();
        for _ in 0..80 {
            worst = worst.max(step(&mut stage, member));
        }
        assert_eq!(stage.bits(member), stage.bits(hand), "the machine is gone");
        stage.crowd.member_mut(member).and_then(|mut m| m.machine_state(0)).unwrap_err();
        // In a layer above it leaves the rest to what lies beneath.
        let machine = MachinePlayback::new().on_layer(1).fade_in_secs(0.3);
        let id =
            stage.crowd.member_mut(member).unwrap().play_machine(stage.machine, machine).unwrap();
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .set_layer(1, populace::LayerSettings::default(), None)
            .unwrap();
        for frame in 0..300 {
            if frame == 100 {
                stage.crowd.member_mut(id.member()).unwrap().set_weight(id, 0.4, 0.2).unwrap();
            }
            if frame == 200 {
                stage.crowd.member_mut(member).unwrap().stop(1, 0.3).unwrap();
            }
            worst = worst.max(step(&mut stage, member));
        }
        assert_eq!(stage.bits(member), stage.bits(hand), "the machine is gone");
        assert!(worst > 0.005 && worst < 0.04, "{worst}, {:?}", stage.crowd.schedule());
    }
}

/// A weight of a layer above is the machine's whole weight, by halves to the two slots.
#[test]
fn the_weight_of_a_machine_is_that_of_a_clip() {
    let mut stage = Stage::new(&on_native());
    let [machine, hand] = [(); 2].map(|()| stage.member(0));
    let above = ClipPlayback::looping().on_layer(1).weight(0.3);
    for member in [machine, hand] {
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .play(stage.clips[2], ClipPlayback::looping())
            .unwrap();
        stage
            .crowd
            .member_mut(member)
            .unwrap()
            .set_layer(1, populace::LayerSettings::default(), None)
            .unwrap();
    }
    let run = stage
        .crowd
        .member_mut(machine)
        .unwrap()
        .play_machine(stage.machine, MachinePlayback::new().on_layer(1).weight(0.3))
        .unwrap();
    let play =
        stage.crowd.member_mut(hand).unwrap().play(stage.clips[0], above.phase(0.25)).unwrap();
    for id in [run, play] {
        stage.crowd.member_mut(id.member()).unwrap().set_speed(id, 1.0).unwrap();
        stage.crowd.member_mut(id.member()).unwrap().set_weight(id, 0.7, 0.5).unwrap();
    }
    for _ in 0..30 {
        stage.frame();
        assert_eq!(stage.bits(machine), stage.bits(hand));
    }
}

/// Members of few slots whose clips, blends and machines run into each other, at steps of that
/// length: the worst.
fn scarce(slots: usize, steps_per_sec: u16) -> f32 {
    let mut stage = Stage::new(&on_native().slots_per_member(slots));
    let (member, mut random, mut worst) = (stage.member(0), Rng::new(slots as u64), 0.0_f32);
    stage.crowd.member_mut(member).unwrap().play(stage.clips[0], ClipPlayback::looping()).unwrap();
    stage.frame();
    for step in 0..30 * steps_per_sec {
        if step % (steps_per_sec / 30) == 0 {
            let fade_secs = random.between(0.2, 0.6) as f32;
            let play = ClipPlayback::looping().fade_in_secs(fade_secs);
            let clip = stage.clips[random.below(3)];
            let speed = random.between(-1.0, 0.2) as f32;
            match random.below(10) {
                0 | 1 => drop(stage.crowd.member_mut(member).unwrap().play(clip, play).unwrap()),
                2 => drop(
                    stage.crowd.member_mut(member).unwrap().blend(clip, play.weight(0.6)).unwrap(),
                ),
                3 | 4 => drop(
                    stage
                        .crowd
                        .member_mut(member)
                        .unwrap()
                        .play_machine(stage.machine, MachinePlayback::new().fade_in_secs(fade_secs))
                        .unwrap(),
                ),
                5 => drop(
                    stage
                        .crowd
                        .member_mut(member)
                        .and_then(|mut m| m.set_parameter("speed", speed)),
                ),
                _ => {}
            }
        }
        worst = worst.max(step_of(&mut stage, member, 1.0 / f32::from(steps_per_sec)));
    }
    worst
}

#[test]
fn nothing_jumps_where_slots_are_scarce() {
    for slots in [4, 5, 8] {
        let [coarse, fine] = [240, 960].map(|steps| scarce(slots, steps));
        // What moves fast moves a fourth as far in a fourth of the time; what jumps does not.
        assert!(fine < 0.35 * coarse, "{fine} of {coarse} with {slots} slots");
    }
}
