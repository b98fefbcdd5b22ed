//! A crowd on a device that fails, and its twin on the native device.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use populace::clip::Clip;
use populace::model::{Interpolation, Property, Track};
use populace::{
    ClipPlayback, Condition, Crowd, Device, Error, Feet, Foot, Gaze, GazeLimits, JointOverride,
    LayerMode, LayerSettings, MachineId, MachinePlayback, MemberId, MotionSettings, Placement,
    Schedule, Space, StateMachine, StatePlayback, Target, Trs, Watch, Weight,
};
use populace_testkit::Rng;

use crate::driver::{self, Call, Fault, Manner};
use crate::fixture::{Scene, character, joint, swing};

/// Frames of a run.
const FRAMES: usize = 10;
/// Members of each kind at the start.
const EACH: usize = 3;
/// What drivers report: no memory, no resources (as after a time-out), a lost device, failed
/// commands, invalid queues, and an error of one vendor for a fault in memory.
const CODES: [i32; 7] = [-4, -5, -6, -2, -14, -36, -9999];
const SCHEDULES: [Schedule; 3] = [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped];

/// What happened in all runs.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) failed_updates: u64,
    pub(crate) failed_reads: u64,
    pub(crate) retries: u64,
    pub(crate) moves_to_native: u64,
    pub(crate) moves_to_opencl: u64,
    /// Runs in which states that only the device knows were lost.
    pub(crate) without_history: u64,
}

/// One of the two crowds.
struct Side {
    scene: Scene,
    machine: MachineId,
    watch: Option<Watch>,
    /// Members that the clock alone determines.
    plain: Vec<MemberId>,
    /// Members with states that a device carries from frame to frame.
    stateful: Vec<MemberId>,
}

/// Two crowds that must be equal.
pub(crate) struct Pair {
    name: String,
    rng: Rng,
    subject: Side,
    twin: Side,
    /// Whether the device's states were lost.
    has_lost_states: bool,
}

fn walk() -> Clip {
    let mut source = swing("stroll", 1.0, &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0)]);
    source.tracks.push(Track {
        joint: "root".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 0.1, 0.0, 1.3],
    });
    let clip = Clip::new(source, &character().skeleton).expect("a good clip");
    clip.with_root_motion(&MotionSettings::default()).expect("a root that moves")
}

fn feet() -> Feet {
    let foot = |side: &str| Foot {
        hip: joint(&format!("{side}UpperLeg")),
        knee: joint(&format!("{side}LowerLeg")),
        ankle: joint(&format!("{side}Foot")),
    };
    Feet { pelvis: joint("hips"), feet: vec![foot("left"), foot("right")], weight: 1.0 }
}

const LIMITS: GazeLimits = GazeLimits { yaw_rad: 1.3, up_rad: 0.7, down_rad: 0.9 };

fn gaze() -> Gaze {
    let chain = [("neck", 0.4), ("head", 0.6)].map(|(name, share)| (joint(name), share)).to_vec();
    Gaze { chain, facing: [0.0, 0.0, 1.0], limits: LIMITS }
}

impl Side {
    fn new(device: Device, schedule: Schedule) -> Result<Self, Error> {
        let builder = Crowd::builder().device(device).schedule(schedule);
        let mut crowd = builder.capacity(16).build()?;
        let body = crowd.add_character(character()).expect("enough capacity");
        crowd.character_mut(body)?.add_clip(&Arc::new(walk()))?;
        let mut scene = Scene { crowd, body };
        let (slow, fast) = (scene.clip("sway"), scene.clip("walk"));
        let machine = StateMachine::new()
            .parameter("speed", 0.0)
            .state("slow", slow, StatePlayback::looping())
            .state("fast", fast, StatePlayback::looping())
            .transition("slow", "fast", 0.1, &[Condition::above("speed", 0.5)])
            .transition("fast", "slow", 0.1, &[Condition::AfterSecs(0.02)]);
        let machine = scene.crowd.add_machine(&machine)?;
        let mut side =
            Self { scene, machine, watch: None, plain: Vec::new(), stateful: Vec::new() };
        for nth in 0..EACH {
            side.add_plain(nth);
            side.add_stateful(nth);
        }
        Ok(side)
    }

    fn at(nth: usize) -> Placement {
        Placement::at([nth as f32 * 0.9, 0.0, 0.3]).facing(nth as f32 * 0.4)
    }

    /// Adds a member with a layer, an override or a parent.
    fn add_plain(&mut self, nth: usize) {
        let member = self.scene.member(Self::at(nth));
        let (sway, walk) = (self.scene.clip("sway"), self.scene.clip("walk"));
        let mut edit = self.scene.edit(member);
        let phase = nth as f32 * 0.21;
        edit.play(sway, ClipPlayback::looping().phase(phase)).expect("a clip");
        edit.set_layer(1, LayerSettings { mode: LayerMode::Additive, weight: 0.6 }, None)
            .expect("a layer");
        edit.play(walk, ClipPlayback::looping().on_layer(1)).expect("a clip");
        if nth % 3 == 1 {
            let transform = Trs { translation: [0.1, 0.2, 0.0], ..Trs::IDENTITY };
            let (joint, space) = (joint("leftHand"), Space::Model);
            edit.override_joints(&[JointOverride { joint, space, transform, weight: 0.5 }])
                .expect("an override");
        }
        if let Some(&parent) = self.plain.first().filter(|_| nth % 3 == 2) {
            self.scene
                .edit(member)
                .attach_to(parent, joint("leftHand"), Trs::IDENTITY)
                .expect("a parent");
        }
        self.plain.push(member);
    }

    /// Adds a member with planted feet and a gaze, with root motion, or with a state machine.
    fn add_stateful(&mut self, nth: usize) {
        let member = self.scene.member(Self::at(nth + 5));
        let [walk, stroll] = ["walk", "stroll"].map(|name| self.scene.clip(name));
        let (machine, other) = (self.machine, self.stateful.first().copied());
        let mut edit = self.scene.edit(member);
        match nth % 3 {
            0 => {
                edit.play(walk, ClipPlayback::looping()).expect("a clip");
                edit.plant_feet_with(&feet()).expect("feet");
                let target = other.map_or(Target::Point([1.0; 3]), |member| Target::Joint {
                    member,
                    joint: joint("leftHand"),
                });
                edit.look_at_with(&gaze(), target, Weight::FULL).expect("a gaze");
            }
            1 => {
                edit.play(stroll, ClipPlayback::looping()).expect("a clip");
                edit.start_root_motion().expect("root motion");
                let watch = edit.watch_joint(joint("leftHand")).expect("a joint");
                self.watch = Some(watch);
            }
            _ => {
                edit.play_machine(machine, MachinePlayback::new()).expect("a machine");
                edit.set_parameter("speed", 1.0).expect("a parameter");
            }
        }
        self.stateful.push(member);
    }

    /// Makes a few calls that change what the device must know.
    fn change(&mut self, rng: &mut Rng, frame: usize) {
        let plain = self.plain[rng.below(self.plain.len())];
        match rng.below(6) {
            0 if self.plain.len() < 8 => self.add_plain(frame),
            1 if self.stateful.len() < 8 => self.add_stateful(frame),
            2 => {
                let walk = self.scene.clip("walk");
                self.scene.edit(plain).crossfade(walk, 0.1).expect("a clip");
            }
            3 => {
                let placement = Self::at(rng.below(9));
                for member in self.stateful.clone() {
                    self.scene.edit(member).set_placement(placement).expect("a member");
                }
            }
            4 => {
                let last = self.plain.pop().filter(|_| self.plain.len() > 2);
                match last {
                    Some(member) => self.scene.crowd.despawn(member).expect("a member"),
                    None => self.add_plain(1),
                }
            }
            _ => {}
        }
    }

    /// Returns the bits of the palettes of members.
    fn palettes(&mut self, members: &[MemberId]) -> Result<Vec<Vec<u32>>, Error> {
        let read = |member: &MemberId| {
            let palette = self.scene.edit(*member).palette()?;
            Ok(palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect())
        };
        members.iter().map(read).collect()
    }
}

impl Pair {
    /// Runs a seed: a scene, a schedule and a fault.
    pub(crate) fn run(seed: u64, tally: &mut Tally) {
        let mut rng = Rng::new(seed);
        let schedule = SCHEDULES[rng.below(SCHEDULES.len())];
        let scene_seed = rng.bits();
        let before = driver::objects();
        let counts = counts(scene_seed, schedule);
        let fault = draw(&mut rng, &counts);
        driver::begin(Some(fault));
        let name = format!("seed {seed}, {schedule}, {fault:?}");
        match Self::new(name.clone(), scene_seed, schedule) {
            Ok(mut pair) => pair.frames(fault.manner, &mut rng, tally),
            Err(error) => {
                assert!(driver::has_failed(), "{name}: {error}");
                assert!(error.to_string().contains(&device_name()), "{name}: {error}");
            }
        }
        assert_eq!(driver::objects(), before, "{name}: objects are left over");
        driver::begin(None);
    }

    fn new(name: String, seed: u64, schedule: Schedule) -> Result<Self, Error> {
        Ok(Self {
            name,
            rng: Rng::new(seed),
            subject: Side::new(Device::opencl(0), schedule)?,
            twin: Side::new(Device::Native { threads: 1 }, Schedule::Staged)?,
            has_lost_states: false,
        })
    }

    fn frames(&mut self, manner: Manner, rng: &mut Rng, tally: &mut Tally) {
        for frame in 0..FRAMES {
            let mut again = self.rng.clone();
            self.subject.change(&mut self.rng, frame);
            self.twin.change(&mut again, frame);
            self.twin.scene.update(0.03);
            self.update(manner, rng, tally);
            self.compare(manner, rng, tally);
        }
        tally.without_history += u64::from(self.has_lost_states);
    }

    /// Updates the subject, and once more after an error.
    fn update(&mut self, manner: Manner, rng: &mut Rng, tally: &mut Tally) {
        let crowd = &mut self.subject.scene.crowd;
        let at_secs = crowd.time_secs();
        let Err(error) = crowd.update(0.03) else { return };
        tally.failed_updates += 1;
        let name = &self.name;
        assert!(driver::has_failed(), "{name}: {error}");
        assert!(error.to_string().contains(&device_name()), "{name}: {error}");
        assert_eq!(crowd.time_secs().to_bits(), at_secs.to_bits(), "{name}: the clock went on");
        self.recover(manner, rng, tally);
        let again = self.subject.scene.crowd.update(0.03);
        again.unwrap_or_else(|error| panic!("{}: {error}", self.name));
    }

    /// Goes on after a fault: on the same device if it is still there, or on another.
    fn recover(&mut self, manner: Manner, rng: &mut Rng, tally: &mut Tally) {
        let to = match rng.below(3) {
            0 if !manner.loses_device() => {
                tally.retries += 1;
                return;
            }
            1 if !manner.loses_device() => {
                tally.moves_to_opencl += 1;
                Device::opencl(0)
            }
            _ => {
                tally.moves_to_native += 1;
                self.has_lost_states |= manner.loses_device();
                Device::Native { threads: 1 }
            }
        };
        let moved = self.subject.scene.crowd.move_to(to);
        moved.unwrap_or_else(|error| panic!("{}: {error}", self.name));
    }

    /// Compares palettes. A read that fails is repeated after the next update of both crowds.
    fn compare(&mut self, manner: Manner, rng: &mut Rng, tally: &mut Tally) {
        for _ in 0..2 {
            if let Some(watch) = self.subject.watch {
                let _newest = self.subject.scene.crowd.readback(watch);
            }
            let mut members = self.subject.plain.clone();
            let mut twins = self.twin.plain.clone();
            if !self.has_lost_states {
                members.extend_from_slice(&self.subject.stateful);
                twins.extend_from_slice(&self.twin.stateful);
            }
            let wanted = self.twin.palettes(&twins).expect("a native device");
            match self.subject.palettes(&members) {
                Ok(found) => {
                    let differ = found.iter().zip(&wanted).position(|(a, b)| a != b);
                    assert_eq!(differ, None, "{}: members differ", self.name);
                    return;
                }
                Err(error) => {
                    tally.failed_reads += 1;
                    assert!(driver::has_failed(), "{}: {error}", self.name);
                    self.recover(manner, rng, tally);
                    self.twin.scene.update(0.03);
                    self.update(manner, rng, tally);
                }
            }
        }
        panic!("{}: palettes cannot be read again", self.name);
    }
}

fn device_name() -> String {
    static NAME: OnceLock<String> = OnceLock::new();
    NAME.get_or_init(|| {
        let found = populace::devices();
        let device = found.into_iter().find(|found| found.device == Some(Device::opencl(0)));
        device.expect("an OpenCL device").name
    })
    .clone()
}

/// Counts the calls of each function in a run without a fault, once for each schedule.
fn counts(seed: u64, schedule: Schedule) -> Vec<usize> {
    static KNOWN: Mutex<Option<HashMap<Schedule, Vec<usize>>>> = Mutex::new(None);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    known
        .entry(schedule)
        .or_insert_with(|| {
            driver::begin(None);
            let mut pair = Pair::new("no fault".into(), seed, schedule).expect("a crowd");
            pair.frames(Manner::Refused, &mut Rng::new(0), &mut Tally::default());
            Call::ALL.iter().map(|call| driver::count(*call)).collect()
        })
        .clone()
}

/// Draws a fault: a function first, so that the many arguments of kernels do not take all.
fn draw(rng: &mut Rng, counts: &[usize]) -> Fault {
    let called: Vec<_> = Call::ALL.iter().zip(counts).filter(|(_, count)| **count > 0).collect();
    let (call, count) = called[rng.below(called.len())];
    Fault {
        call: *call,
        after: rng.below(*count),
        manner: Manner::ALL[rng.below(Manner::ALL.len())],
        code: CODES[rng.below(CODES.len())],
    }
}
