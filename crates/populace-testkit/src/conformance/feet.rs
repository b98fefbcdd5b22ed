//! Checks of planted feet.

use std::f64::consts::TAU;

use populace_clip::{TICKS_PER_SEC, ticks_from_secs};
use populace_device::layout::{Contact, Float4};
use populace_device::{
    Backend, Constraint, Controls, Feet, Foot, Frame, Ground, JointOverride, Place, Space,
};
use populace_model::convert::single;
use populace_model::{JointIndex, Role, Side, Trs};

use super::controls::{locals_of, model_numbers, numbers_found};

use crate::compare::{Judge, joint_name};
use crate::oracle::{
    Bounded, Local, Noise, OracleFrame, OracleGait, OracleGround, OracleMember, OraclePlace,
    OracleStance, OracleSteps, Timing, Weighting, bounded,
};
use crate::scenes::{Scene, ScenePace};
use crate::tolerance::MODEL_CAP;
use crate::{MemberPlan, Play, Rng, TestCrowd};

/// The clock before the first frame.
const START_SECS: f64 = 6.0;
const FRAMES: u64 = 36;
const WALKERS: usize = 12;
/// Clips of each body: a walk, a walk whose contacts are not known, and a stand.
const CLIPS: usize = 3;

/// A member that walks, its twin without planted feet, and what was seen of both.
struct Walker {
    member: usize,
    twin: usize,
    controls: Controls,
    stride: [f32; 3],
    place: Place,
    /// Metres per second ahead, and radians per second.
    pace: [f64; 2],
    heading: f64,
    seen: Vec<Seen>,
}

/// A member in one frame.
struct Seen {
    tick: u64,
    elapsed_ticks: u32,
    place: Place,
    /// Local transforms of the twin.
    clips: Vec<Local>,
    /// Model transforms and palette of the member.
    found: Vec<f32>,
}

/// Walkers on one ground.
struct FeetScene<'a> {
    crowd: TestCrowd<'a>,
    paces: &'a [ScenePace],
    ground: OracleGround,
    walkers: Vec<Walker>,
}

/// Returns the plane, or the stairs on a wavy ground, of a number, for devices and for the oracle.
fn ground(nth: usize) -> (Ground, OracleGround) {
    let plane = |height: f32, slopes: [f32; 2]| {
        let ground = Ground::plane(height, slopes).expect("the plane is valid");
        let (height, slopes) = (f64::from(height), slopes.map(f64::from));
        (ground, OracleGround::Plane { height, slopes })
    };
    match nth {
        0 => plane(0.1, [0.0; 2]),
        1 => plane(-0.05, [0.14, -0.1]),
        _ => {
            let (corner, spacing_m, count_x) = ([-6.0f32, -6.0], 0.125f32, 97);
            let height = |nth: usize| {
                let at = |index: usize| f64::from(spacing_m) * index as f64 - 6.0;
                let (x, z) = (at(nth % count_x), at(nth / count_x));
                let stairs = if x > 0.0 { 0.16 * (z / 0.5).floor() } else { 0.0 };
                single(stairs + 0.03 * (1.7 * x).sin() * (1.3 * z).cos())
            };
            let heights: Vec<f32> = (0..count_x * count_x).map(height).collect();
            let ground = Ground::height_field(corner, spacing_m, count_x, heights.clone())
                .expect("the heights are valid");
            let of_oracle = OracleGround::Heights {
                corner: corner.map(f64::from),
                spacing_m: f64::from(spacing_m),
                count_x,
                heights: heights.into_iter().map(f64::from).collect(),
            };
            (ground, of_oracle)
        }
    }
}

/// The walker that stands while it is carried on, so that its feet step below it.
const CARRIED: usize = 11;

/// Returns what a walker plays: a walk alone, or one that fades into a stand, or a stand.
fn plays(rng: &mut Rng, body: usize, nth: usize) -> Vec<Play> {
    if nth == CARRIED {
        return vec![Play::held(CLIPS * body + 2, 0.1)];
    }
    let start_tick = ticks_from_secs(rng.between(0.0, 5.0));
    let timing =
        Timing::Loop { start_tick, phase: rng.between(0.0, 1.0), speed: [1.0, 1.3, 0.7][nth % 3] };
    let clip = CLIPS * body + usize::from(nth % 5 == 3);
    let mut plays = vec![Play { timing, ..Play::held(clip, 0.0) }];
    if nth % 4 == 1 {
        let tick = ticks_from_secs(START_SECS + 0.2);
        let ramp = |from, to| Weighting::Ramp { tick, from, to, secs: 0.6 };
        plays[0].weighting = ramp(1.0, 0.0);
        plays.push(Play { weighting: ramp(0.0, 1.0), ..Play::held(CLIPS * body + 2, 0.1) });
    }
    plays
}

impl<'a> FeetScene<'a> {
    fn new(scene: &'a Scene, paces: &'a [ScenePace]) -> Self {
        let crowd = TestCrowd::new(scene, 2);
        Self { crowd, paces, ground: ground(0).1, walkers: Vec::new() }
    }

    /// Replaces the ground and all walkers.
    fn begin(&mut self, nth_ground: usize, rng: &mut Rng) {
        for walker in std::mem::take(&mut self.walkers) {
            self.crowd.remove(walker.twin);
            self.crowd.remove(walker.member);
        }
        let (of_device, ground) = ground(nth_ground);
        self.crowd.tables.set_ground(&of_device).expect("the ground fits in the tables");
        self.ground = ground;
        (0..WALKERS).for_each(|nth| self.add(rng, nth));
    }

    fn joint(&self, body: usize, role: Role) -> JointIndex {
        let body = &self.crowd.scene.bodies[body];
        body.skeleton.joint_from_source(body.joint_of(role).expect("a humanoid body"))
    }

    fn legs(&self, body: usize) -> Vec<Foot> {
        let joint = |role| self.joint(body, role);
        let foot = |side| Foot {
            hip: joint(Role::UpperLeg(side)),
            knee: joint(Role::LowerLeg(side)),
            ankle: joint(Role::Foot(side)),
        };
        [Side::Left, Side::Right].map(foot).to_vec()
    }

    fn add(&mut self, rng: &mut Rng, nth: usize) {
        let body = nth % self.crowd.scene.bodies.len();
        let plan = MemberPlan::plain(body, plays(rng, body, nth));
        let (legs, pelvis) = (self.legs(body), self.joint(body, Role::Hips));
        for play in &plan.plays {
            let bound = self.crowd.slot(play, body).bound_clip;
            let known = self.paces[play.clip].contacts.into_iter().flatten();
            let contact = |(foot, [from, until]): (&Foot, [f64; 2])| Contact {
                joint: foot.ankle.0,
                from_secs: single(from),
                until_secs: single(until),
                unused: 0,
            };
            let contacts: Vec<_> = legs.iter().zip(known).map(contact).collect();
            self.crowd.tables.set_contacts(bound, &contacts).expect("the clip is bound");
        }
        let twin = self.crowd.add(plan.clone());
        let member = self.crowd.add(plan);
        let weight = if nth % 6 == 2 { 0.6 } else { 1.0 };
        // What moves a hip after the pelvis makes devices solve the legs later. Its rotation is not
        // half a turn away from the leg's, where the way to it would be any.
        let moved = JointOverride {
            joint: legs[0].hip,
            space: Space::Model,
            transform: Trs {
                rotation: [0.0, 0.0, 0.0, 1.0],
                ..super::controls::random_transform(rng)
            },
            weight: 0.02,
        };
        let controls = Controls {
            constraints: vec![Constraint::Feet(Feet { pelvis, feet: legs, weight })],
            overrides: if nth % 6 == 4 { vec![moved] } else { Vec::new() },
            ..Controls::default()
        };
        let size = self.crowd.scene.bodies[body].skeleton.size_m();
        let pace = [1.0, 1.0, 0.0, 2.2, -0.6, 1.2, 0.9][nth % 7];
        let speed = 0.7 * f64::from(size) * if nth == CARRIED { 0.15 } else { pace };
        let heading = rng.between(0.0, TAU);
        let place = Place {
            position: rng.vector(-1.5, 1.5).to_array().map(single),
            sin_cos: [0.0, 1.0],
            scale: single(rng.between(0.8, 1.3)),
        };
        let turn = single(rng.between(-0.3, 0.3));
        let strides = [[0.0, 1.0, 0.0], [0.3, 0.8, turn], [-0.2, 1.2, 0.0]];
        self.walkers.push(Walker {
            member,
            twin,
            controls,
            stride: strides[nth / 2 % 3],
            place,
            pace: [speed, [0.0, 0.9, -1.6][nth % 3]],
            heading,
            seen: Vec::new(),
        });
        self.move_walker(nth, 0.0);
        self.walkers[nth].place.position[1] = 0.0;
    }

    /// Moves a walker on for a time.
    fn move_walker(&mut self, nth: usize, secs: f64) {
        let walker = &mut self.walkers[nth];
        walker.heading += walker.pace[1] * secs;
        let (sin, cos) = walker.heading.sin_cos();
        let way = walker.pace[0] * secs;
        walker.place.position[0] += single(way * sin);
        walker.place.position[2] += single(way * cos);
        walker.place.sin_cos = [sin, cos].map(single);
    }

    fn frame(&mut self, backend: &mut dyn Backend, frame: u64, tick: u64, elapsed_ticks: u32) {
        for nth in 0..self.walkers.len() {
            self.move_walker(nth, f64::from(elapsed_ticks) / TICKS_PER_SEC as f64);
            let walker = &mut self.walkers[nth];
            if nth == 5 && frame == FRAMES / 2 {
                // Elsewhere, so that locks end.
                walker.place.position[0] -= 3.0;
            }
            let index = self.crowd.index(walker.member);
            let skeleton = &self.crowd.scene.bodies[self.crowd.plan(walker.member).body].skeleton;
            let tables = &mut self.crowd.tables;
            if frame == 0 {
                let set = tables.set_controls(index, skeleton, &walker.controls);
                set.expect("the controls are valid");
                let [x, z, turn] = walker.stride;
                tables.set_stride(index, Float4([x, z, turn, 0.0])).expect("the member exists");
            }
            tables.set_place(index, &walker.place).expect("the member exists");
        }
        self.crowd.update(backend);
        let now = Frame::of_all(tick).after_ticks(elapsed_ticks);
        backend.run(&self.crowd.tables, now).expect("the backend runs a frame");
        for walker in &mut self.walkers {
            let clips = locals_of(&self.crowd.read(backend, walker.twin));
            let found = numbers_found(&self.crowd.read(backend, walker.member));
            let place = walker.place;
            walker.seen.push(Seen { tick, elapsed_ticks, place, clips, found });
        }
    }

    /// Returns what a member plays that knows the contacts of a foot.
    fn steps(&self, member: usize, foot: usize, tick: u64) -> Vec<OracleSteps> {
        let of = |play: &Play| {
            let clip = &self.crowd.scene.clips[play.clip].clip;
            let weight = play.weighting.weight(tick.max(ticks_from_secs(START_SECS + 0.2)));
            let contacts = self.paces[play.clip].contacts.filter(|_| weight > 0.0)?;
            let start = f64::from(clip.start_secs());
            Some(OracleSteps {
                weight,
                secs: [play.timing.time_secs(tick, clip) - start, start.abs()],
                cycle_secs: f64::from(clip.duration_secs()),
                contacts: vec![contacts[foot]],
            })
        };
        self.crowd.plan(member).plays.iter().filter_map(of).collect()
    }

    /// Returns the oracle's numbers of a walker in all frames.
    fn wanted(&self, walker: &Walker, noise: &mut Noise) -> Vec<f64> {
        let body = &self.crowd.scene.bodies[self.crowd.plan(walker.member).body];
        let member = OracleMember {
            body: &body.oracle,
            skeleton: &body.skeleton,
            controls: &walker.controls,
            stages: &[],
        };
        let mut stance = OracleStance::default();
        let mut numbers = Vec::new();
        for seen in &walker.seen {
            let gait = OracleGait {
                ground: self.ground.clone(),
                elapsed_secs: f64::from(seen.elapsed_ticks) / TICKS_PER_SEC as f64,
                stride: walker.stride.map(f64::from),
                steps: [0, 1].map(|foot| self.steps(walker.member, foot, seen.tick)).to_vec(),
            };
            let place = OraclePlace::new(&seen.place);
            let frame = OracleFrame { tick: seen.tick, place, ..OracleFrame::default() };
            let gait = (&gait, &mut stance);
            let (_, models) = member.posed_on_feet(&seen.clips, &frame, gait, noise);
            numbers.extend(model_numbers(&body.oracle, &models, noise));
        }
        numbers
    }

    fn judge(&self, judge: &mut Judge) {
        for (nth, walker) in self.walkers.iter().enumerate() {
            let wanted = bounded(|noise| self.wanted(walker, noise));
            let got = walker.seen.iter().flat_map(|seen| &seen.found);
            let of_frame = walker.seen[0].found.len();
            assert_eq!(wanted.len(), of_frame * walker.seen.len(), "numbers of a walker");
            for (at, (got, Bounded { value, bound })) in got.zip(wanted).enumerate() {
                judge.number(*got, value, bound, MODEL_CAP, || {
                    let (frame, at) = (at / of_frame, at % of_frame);
                    let name = joint_name(&self.crowd, walker.member, at / 12);
                    format!("walker {nth} in frame {frame}: {name} or entry, element {}", at % 12)
                });
            }
        }
    }
}

/// Checks planted feet on level ground, a slope, and stairs on uneven ground: feet that lock, roll
/// over their soles and lift off by the contacts of clips and by the height of the ankle, mixes of
/// a walk and a stand, feet that step below a body that stands, strides of other lengths and directions, members that move as fast as their
/// clips, faster, backwards or not at all, that turn, and that are moved elsewhere.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_feet(backend: &mut dyn Backend) {
    let (scene, paces) = Scene::of_walkers();
    let mut judge = Judge::new("planted feet");
    let mut rng = Rng::new(79);
    let mut feet = FeetScene::new(&scene, &paces);
    for ground in 0..3 {
        feet.begin(ground, &mut rng);
        let mut tick = ticks_from_secs(START_SECS);
        for frame in 0..FRAMES {
            let per_sec = if frame % 3 == 2 { 60 } else { 30 };
            let elapsed = u32::try_from(TICKS_PER_SEC / per_sec).expect("a short frame");
            tick += u64::from(elapsed);
            feet.frame(backend, frame, tick, elapsed);
        }
        feet.judge(&mut judge);
    }
    judge.done();
}
