//! Seven people share one state machine, each with its own parameters.
//!
//! They are called one after the other: they turn to the camera, walk or run towards it, and stand.
//! The host moves them and sets the parameters `speed` and `turn`. The machine chooses the clips.
//!
//! `cargo run --example machine [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;

use populace::{
    ClipId, Condition, Crowd, MachinePlayback, MemberId, Placement, StateMachine, StatePlayback,
};
use populace_cast::{Look, person};

const FRAME_SECS: f32 = 1.0 / 60.0;
/// Speed at which people turn.
const TURN_RAD_PER_SEC: f32 = 2.0;

/// A person who walks to the camera.
struct Walker {
    member: MemberId,
    x: f32,
    z: f32,
    yaw_rad: f32,
    speed_m_per_sec: f32,
    /// Number of frames until the call.
    frames_to_call: u16,
}

impl Walker {
    /// Moves the person by one frame, and sets the machine's parameters.
    fn step(&mut self, crowd: &mut Crowd, [walk, run]: [f32; 2]) -> Result<(), populace::Error> {
        let called = self.frames_to_call == 0;
        self.frames_to_call = self.frames_to_call.saturating_sub(1);
        let turn = if called { self.yaw_rad.min(TURN_RAD_PER_SEC * FRAME_SECS) } else { 0.0 };
        let distance = -self.z;
        let target_speed = if !called || turn > 0.0 || distance < 0.05 {
            0.0
        } else if distance > 2.5 {
            run
        } else {
            walk
        };
        self.speed_m_per_sec += (target_speed - self.speed_m_per_sec).clamp(-0.15, 0.06);
        self.yaw_rad -= turn;
        self.z += self.speed_m_per_sec * FRAME_SECS;
        crowd
            .member_mut(self.member)?
            .set_placement(Placement::at([self.x, 0.0, self.z]).facing(self.yaw_rad))?;
        crowd.member_mut(self.member)?.set_parameter("turn", turn / FRAME_SECS)?;
        crowd
            .member_mut(self.member)
            .and_then(|mut m| m.set_parameter("speed", self.speed_m_per_sec))
    }
}

/// Creates a state machine with states for standing, turning, walking and running.
fn gait([idle, walk, run]: [ClipId; 3], [walking, running]: [f32; 2]) -> StateMachine {
    let (goes, between) = (Condition::above("speed", 0.2), 0.5 * (walking + running));
    StateMachine::new()
        .parameter("speed", 0.0)
        .parameter("turn", 0.0)
        .state("idle", idle, StatePlayback::looping())
        .state("turn", walk, StatePlayback::looping().speed(0.7))
        .state("walk", walk, StatePlayback::looping())
        .state("run", run, StatePlayback::looping())
        .transition("idle", "turn", 0.15, &[Condition::above("turn", 0.1)])
        .transition("turn", "walk", 0.25, std::slice::from_ref(&goes))
        .transition(
            "turn",
            "idle",
            0.2,
            &[Condition::below("turn", 0.1), Condition::AfterSecs(0.4)],
        )
        .transition("idle", "walk", 0.25, &[goes])
        .transition("walk", "run", 0.3, &[Condition::above("speed", between)])
        .transition("run", "walk", 0.3, &[Condition::below("speed", between - 0.3)])
        .transition("walk", "idle", 0.3, &[Condition::below("speed", 0.2)])
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut crowd = Crowd::builder().build()?;
    let mut ids = Vec::new();
    for look in &Look::presets() {
        ids.push(crowd.add_character(person(look)?)?);
    }
    // All people play the clips of the first.
    let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(ids[0], name));
    let (idle, walk, run) = (idle?, walk?, run?);
    let mut speeds = [1.4, 3.0];
    for (clip, motion) in crowd.character(ids[0])?.clips() {
        let speed = motion.stats().ground_speed_m_per_sec.unwrap_or(0.0);
        speeds = [
            if clip == walk { speed } else { speeds[0] },
            if clip == run { speed } else { speeds[1] },
        ];
    }
    let gait = crowd.add_machine(&gait([idle, walk, run], speeds))?;

    let mut walkers = Vec::new();
    for (nth, id) in (0..7_u8).zip(ids.iter().cycle()) {
        let (x, z) = (f32::from(nth) * 1.0 - 3.0, -4.0);
        let yaw_rad = std::f32::consts::FRAC_PI_2;
        let member = crowd.spawn(*id, Placement::at([x, 0.0, z]).facing(yaw_rad))?;
        crowd.member_mut(member)?.play_machine(gait, MachinePlayback::new())?;
        let frames_to_call = u16::from(nth) * 32;
        walkers.push(Walker { member, x, z, yaw_rad, speed_m_per_sec: 0.0, frames_to_call });
    }
    for _ in 0..233 {
        for walker in &mut walkers {
            walker.step(&mut crowd, speeds)?;
        }
        crowd.update(FRAME_SECS)?;
    }
    for (nth, walker) in walkers.iter().enumerate() {
        let state = crowd.member_mut(walker.member)?.machine_state(0)?;
        println!(
            "{nth}: {state} at {:.1} m/s, {:.1} m away",
            walker.speed_m_per_sec,
            walker.z.abs()
        );
    }
    let path = shared::output("machine.png");
    shared::draw(&mut crowd, &[[-3.3, -0.1, 0.3], [3.3, 1.9, 0.0]], &path)?;
    println!("all on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
