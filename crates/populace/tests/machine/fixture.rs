//! A state machine of six states, crowds that run it, and an independent interpreter of it.

use std::sync::Arc;

use populace::character::{Character, CharacterSource};
use populace::clip::TICKS_PER_SEC;
use populace::model::{JointSource, Skeleton};
use populace::{
    CharacterId, ClipId, ClipPlayback, Condition, Crowd, CrowdBuilder, Device, Devices, MachineId,
    MachinePlayback, MemberId, MemberMut, Placement, Schedule, Split, StateMachine, StatePlayback,
    Trs,
};

use crate::arm::{Motion, character, skeleton};

/// Length of a frame: a whole number of ticks.
pub(crate) const FRAME_SECS: f32 = 1.0 / 48.0;

pub(crate) fn motions() -> Vec<Motion> {
    let motion = |name, duration_secs, rotations: [&[f32]; 4]| {
        let axes = [[1.0, 0.2, 0.0], [0.0, 1.0, 0.3], [0.5, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let mut axes = axes.into_iter();
        Motion {
            name,
            duration_secs,
            rotations: rotations.map(|angles| (axes.next().unwrap(), angles.to_vec())),
        }
    };
    vec![
        motion("idle", 2.0, [&[0.0, 0.1, 0.0], &[0.05], &[0.1, 0.0, 0.1], &[0.0, 0.05, 0.0]]),
        motion("walk", 1.1, [&[0.3, -0.3, 0.3], &[-0.2, 0.3, -0.2], &[0.2], &[0.0, 0.4, 0.0]]),
        motion("run", 0.7, [&[0.6, -0.5, 0.6], &[0.3, -0.3, 0.3], &[-0.4], &[0.5, -0.2, 0.5]]),
        motion("jump", 0.5, [&[0.0, -0.7, 0.2], &[0.4], &[0.0, 0.5], &[-0.3, 0.3]]),
    ]
}

/// States: name, clip index, playback as a state, and the same playback as a plain clip.
pub(crate) const STATES: [(&str, usize, StatePlayback, ClipPlayback); 6] = {
    use {ClipPlayback as Clip, StatePlayback as State};
    [
        ("idle", 0, State::looping().phase(0.25), Clip::looping().phase(0.25)),
        ("walk", 1, State::looping(), Clip::looping()),
        ("run", 2, State::looping().speed(1.2), Clip::looping().speed(1.2)),
        ("jump", 3, State::once().speed(0.8), Clip::once().speed(0.8)),
        ("sit", 0, State::held_at_secs(0.7), Clip::held_at_secs(0.7)),
        ("back", 1, State::looping().speed(-0.7), Clip::looping().speed(-0.7)),
    ]
};

/// A condition of a transition.
pub(crate) enum Guard {
    Above(&'static str, f32),
    Below(&'static str, f32),
    AfterSecs(f32),
    Ended,
}

/// Transitions in order of priority: from (any state if `None`), to, fade in seconds, and guards.
pub(crate) const TRANSITIONS: [(Option<&str>, &str, f32, &[Guard]); 10] = [
    (None, "jump", 0.1, &[Guard::Above("jump", 0.5)]),
    (Some("idle"), "walk", 0.25, &[Guard::Above("speed", 0.5)]),
    (Some("idle"), "back", 0.3, &[Guard::Below("speed", -0.5)]),
    (Some("walk"), "run", 0.3, &[Guard::Above("speed", 2.0)]),
    (Some("run"), "walk", 0.2, &[Guard::Below("speed", 1.8)]),
    (Some("walk"), "idle", 0.25, &[Guard::Below("speed", 0.4)]),
    (Some("back"), "idle", 0.15, &[Guard::Above("speed", -0.4), Guard::AfterSecs(0.5)]),
    (Some("jump"), "idle", 0.2, &[Guard::Ended, Guard::Below("jump", 0.5)]),
    (Some("idle"), "sit", 0.4, &[Guard::AfterSecs(1.2)]),
    (Some("sit"), "idle", 0.0, &[Guard::Above("speed", 0.2)]),
];

pub(crate) fn machine(clips: &[ClipId]) -> StateMachine {
    let mut machine = StateMachine::new().parameter("speed", 0.0).parameter("jump", 0.0);
    for (name, clip, playback, _) in STATES {
        machine = machine.state(name, clips[clip], playback);
    }
    for (from, to, fade_secs, guards) in TRANSITIONS {
        let condition = |test: &Guard| match test {
            Guard::Above(name, value) => Condition::above(name, *value),
            Guard::Below(name, value) => Condition::below(name, *value),
            Guard::AfterSecs(secs) => Condition::AfterSecs(*secs),
            Guard::Ended => Condition::Ended,
        };
        let conditions: Vec<_> = guards.iter().map(condition).collect();
        machine = match from {
            Some(from) => machine.transition(from, to, fade_secs, &conditions),
            None => machine.transition_from_any(to, fade_secs, &conditions),
        };
    }
    machine
}

/// A naive interpreter of one machine instance.
#[derive(Clone, Debug)]
pub(crate) struct Interpreter {
    pub(crate) state: &'static str,
    pub(crate) speed: f32,
    pub(crate) jump: f32,
    ticks_in_state: u64,
    fade_ticks: u64,
}

fn ticks(secs: f32) -> u64 {
    (f64::from(secs) * TICKS_PER_SEC as f64).round() as u64
}

impl Interpreter {
    pub(crate) fn new() -> Self {
        Self { state: "idle", speed: 0.0, jump: 0.0, ticks_in_state: 0, fade_ticks: 0 }
    }

    /// Advances by a frame. Returns the fade in seconds of the transition that was taken, if any.
    pub(crate) fn step(&mut self, frame_ticks: u64) -> Option<f32> {
        self.ticks_in_state += frame_ticks;
        if self.ticks_in_state < self.fade_ticks {
            return None;
        }
        // The jump clip of 0.5 s runs at a speed of 0.8.
        let ended = self.state == "jump" && self.ticks_in_state >= ticks(0.625);
        let holds = |test: &Guard| match test {
            Guard::Above(name, value) => self.value(name) > *value,
            Guard::Below(name, value) => self.value(name) < *value,
            Guard::AfterSecs(secs) => self.ticks_in_state >= ticks(*secs),
            Guard::Ended => ended,
        };
        let applies =
            |from: Option<&str>, to: &str| from.map_or(to != self.state, |from| from == self.state);
        let mut transitions = TRANSITIONS.iter();
        let (_, to, fade_secs, _) =
            transitions.find(|(f, to, _, t)| applies(*f, to) && t.iter().all(holds))?;
        (self.state, self.ticks_in_state, self.fade_ticks) = (to, 0, ticks(*fade_secs));
        Some(*fade_secs)
    }

    fn value(&self, name: &str) -> f32 {
        if name == "speed" { self.speed } else { self.jump }
    }

    /// Sets the parameters of a member of a crowd to the interpreter's.
    pub(crate) fn set_parameters(&self, crowd: &mut Crowd, member: MemberId) {
        crowd.member_mut(member).unwrap().set_parameter("speed", self.speed).unwrap();
        crowd.member_mut(member).unwrap().set_parameter("jump", self.jump).unwrap();
    }
}

/// A crowd with two characters and the state machine.
pub(crate) struct Scene {
    pub(crate) crowd: Crowd,
    pub(crate) characters: [CharacterId; 2],
    pub(crate) clips: Vec<ClipId>,
    pub(crate) machine: MachineId,
}

impl Scene {
    pub(crate) fn new(builder: &CrowdBuilder) -> Self {
        let mut crowd = builder.clone().build().unwrap();
        let arm = crowd.add_character(character(&motions())).unwrap();
        let clips: Vec<_> =
            crowd.character(arm).unwrap().clips().into_iter().map(|(clip, _)| clip).collect();
        let characters = [arm, crowd.add_character(longer()).unwrap()];
        let machine = crowd.add_machine(&machine(&clips)).unwrap();
        Self { crowd, characters, clips, machine }
    }

    /// Returns mutable access to a member.
    pub(crate) fn edit(&mut self, member: MemberId) -> MemberMut<'_> {
        self.crowd.member_mut(member).unwrap()
    }

    pub(crate) fn member(&mut self, character_index: usize) -> MemberId {
        self.crowd.spawn(self.characters[character_index], Placement::at([0.0; 3])).unwrap()
    }

    pub(crate) fn machine_instance(&mut self, character_index: usize) -> MemberId {
        let member = self.member(character_index);
        self.crowd
            .member_mut(member)
            .unwrap()
            .play_machine(self.machine, MachinePlayback::new())
            .unwrap();
        member
    }

    pub(crate) fn frame(&mut self) {
        self.crowd.update(FRAME_SECS).unwrap();
    }

    /// Returns the bits of a member's palette.
    pub(crate) fn bits(&mut self, member: MemberId) -> Vec<u32> {
        let palette = self.crowd.member_mut(member).unwrap().palette().unwrap();
        palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect()
    }
}

/// The arm with longer bones and one more joint at its end. Clips bind to it by joint names.
fn longer() -> Arc<Character> {
    let arm = skeleton();
    let mut joints: Vec<_> = arm
        .joints()
        .map(|joint| JointSource {
            name: arm.name(joint).into(),
            parent: arm.parent(joint).map(|parent| parent.index()),
            rest: Trs { translation: [0.1, 0.7, 0.0], ..Trs::IDENTITY },
        })
        .collect();
    joints.push(JointSource { name: "tip".into(), parent: Some(3), rest: Trs::IDENTITY });
    let arm = character(&[]);
    Arc::new(
        Character::new(CharacterSource {
            name: "longer arm".into(),
            skeleton: Skeleton::new(&joints).unwrap(),
            palette: arm.palette.clone(),
            parts: vec![],
            materials: vec![],
            images: vec![],
            skins: vec![],
            clips: vec![],
        })
        .unwrap(),
    )
}

/// Returns builders for all devices and schedules, and for some pairs of devices.
pub(crate) fn everywhere() -> Vec<CrowdBuilder> {
    let of = |devices: Devices, schedule| {
        let shares = vec![1.0; devices.as_slice().len()];
        Crowd::builder().devices(devices).split(Split::Fixed(shares)).schedule(schedule)
    };
    let native = |threads| Device::Native { threads };
    let mut all = vec![
        of(native(2).into(), Schedule::Staged),
        of(native(2).into(), Schedule::Fused),
        of([native(1), native(2)].into(), Schedule::Fused),
    ];
    if cfg!(all(feature = "opencl", not(skip_opencl))) {
        for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
            all.push(of(Device::opencl(0).into(), schedule));
        }
        for schedule in [Schedule::Staged, Schedule::Fused] {
            all.push(of([native(1), Device::opencl(0)].into(), schedule));
        }
    }
    all
}

pub(crate) fn on_native() -> CrowdBuilder {
    Crowd::builder().device(Device::native())
}
