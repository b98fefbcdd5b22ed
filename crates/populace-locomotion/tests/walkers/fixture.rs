//! A crowd of one built-in character, and its walkers.

use std::f32::consts::PI;
use std::sync::{Arc, OnceLock};

use glam::Vec2;
use populace::character::Character;
use populace::{CharacterId, Crowd, Device, MemberId, Placement};
use populace_cast::Look;
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings};
use populace_locomotion::{GaitSpace, Goal, WalkerSettings, Walkers};

pub(crate) const FRAME_SECS: f32 = 1.0 / 60.0;
/// The radius of the character as a disc, in metres.
pub(crate) const RADIUS_M: f32 = 0.24;

pub(crate) struct Town {
    pub(crate) crowd: Crowd,
    pub(crate) walkers: Walkers,
    pub(crate) person: CharacterId,
}

fn person() -> Arc<Character> {
    static PERSON: OnceLock<Arc<Character>> = OnceLock::new();
    Arc::clone(PERSON.get_or_init(|| Arc::new(populace_cast::person(&Look::man()).unwrap())))
}

impl Town {
    pub(crate) fn new() -> Self {
        Self::on(Device::Native { threads: 1 })
    }

    pub(crate) fn on(device: Device) -> Self {
        let mut crowd = Crowd::builder().device(device).build().unwrap();
        let person = crowd.add_character(person()).unwrap();
        let clips = ["Idle", "Walk", "Run"].map(|name| crowd.clip(person, name).unwrap());
        let mut walkers = Walkers::new(WalkerSettings::default()).unwrap();
        walkers.add_gaits(GaitSpace::new(&mut crowd, person, clips[0], &clips[1..]).unwrap());
        Self { crowd, walkers, person }
    }

    pub(crate) fn avoid(&mut self) {
        self.walkers.set_avoidance(Some(Avoidance::new(AvoidanceSettings::default()).unwrap()));
    }

    pub(crate) fn add(&mut self, placement: Placement) -> MemberId {
        let member = self.crowd.spawn(self.person, placement).unwrap();
        self.walkers.add(&mut self.crowd, member).unwrap();
        member
    }

    pub(crate) fn add_at(&mut self, [x, z]: [f32; 2]) -> MemberId {
        self.add(Placement::at([x, 0.0, z]))
    }

    pub(crate) fn send(&mut self, member: MemberId, speed: f32, goal: Goal) {
        self.walkers.set_speed(member, speed).unwrap();
        self.walkers.set_goal(member, goal).unwrap();
    }

    /// Moves the walkers by a frame; the crowd itself is not updated.
    pub(crate) fn step(&mut self) {
        self.walkers.update(&mut self.crowd, FRAME_SECS).unwrap();
    }

    pub(crate) fn run(&mut self, secs: f32) {
        for _ in 0..(secs / FRAME_SECS).round() as u32 {
            self.step();
        }
    }

    pub(crate) fn place(&self, member: MemberId) -> Placement {
        self.crowd.member(member).unwrap().placement()
    }

    pub(crate) fn position(&self, member: MemberId) -> Vec2 {
        let [x, _, z] = self.place(member).position();
        Vec2::new(x, z)
    }

    pub(crate) fn velocity(&self, member: MemberId) -> Vec2 {
        let index = self.walkers.members().iter().position(|own| *own == member).unwrap();
        self.walkers.velocities()[index].into()
    }

    /// The angle by which the member would have to turn to a heading, without sign.
    pub(crate) fn off_heading(&self, member: MemberId, yaw_rad: f32) -> f32 {
        between(self.place(member).yaw_rad(), yaw_rad)
    }
}

/// The angle between two headings, 0 to pi.
pub(crate) fn between(a: f32, b: f32) -> f32 {
    ((a - b + PI).rem_euclid(2.0 * PI) - PI).abs()
}
