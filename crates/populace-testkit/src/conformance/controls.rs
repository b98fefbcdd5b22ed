//! Checks of what moves members besides clips. Each controlled member has a twin with the same
//! clips and no controls. The twin's local transforms, which other checks judge, are what the oracle
//! begins with, so that the only errors are those of the controls.

mod checks;
mod plans;

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_clip::ticks_from_secs;
use populace_device::{Backend, Controls, Frame, LayerMode, Place};
use populace_model::JointIndex;

use crate::compare::{Judge, joint_name, row_major};
use crate::oracle::{
    Bounded, Local, Noise, OracleBody, OracleChange, OracleFrame, OracleMember, OracleMover,
    OraclePlace, OracleRetarget, OracleStage, OracleTravel, bounded, palettes_with,
};
use crate::scenes::Scene;
use crate::tolerance::MODEL_CAP;
use crate::{Inertialization, LayerPlan, MemberPlan, MemberReading, Play, Rng, TestCrowd};

pub(super) use plans::transform as random_transform;

pub use checks::{
    check_attachments, check_chains, check_gaze, check_limbs, check_motion_of_others,
    check_motion_transitions, check_overrides, check_root_motion, check_user_stages,
};

/// The clock at the first frame of most checks.
const START_SECS: f64 = 6.0;
/// Ticks between two frames of these checks.
const ELAPSED: u64 = populace_clip::TICKS_PER_SEC / 30;

/// A member with controls.
struct Controlled {
    member: usize,
    /// The same member without controls.
    twin: usize,
    controls: Controls,
    place: Place,
    /// The controlled member (by its place in the list) and joint that it is attached to.
    parent: Option<(usize, usize)>,
    /// The member's plan in each frame so far.
    played: Vec<MemberPlan>,
}

/// Controlled members and their twins.
struct ControlScene<'a> {
    name: &'static str,
    crowd: TestCrowd<'a>,
    all: Vec<Controlled>,
    stages: Vec<OracleStage>,
    /// The clock at the first frame.
    first_tick: u64,
}

/// Returns a reading's local transforms.
pub(super) fn locals_of(reading: &MemberReading) -> Vec<Local> {
    let three = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    (0..reading.rotations.len())
        .map(|joint| Local {
            translation: three(reading.translations[joint]),
            rotation: DQuat::from_array(reading.rotations[joint].map(f64::from)),
            scale: three(reading.scales[joint]),
        })
        .collect()
}

/// Returns the model transform of a joint that a backend returned.
fn model_of(reading: &MemberReading, joint: usize) -> DAffine3 {
    let m = reading.models[joint].map(f64::from);
    let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Returns the numbers of model transforms and of the palette that follows from them.
pub(super) fn model_numbers(body: &OracleBody, models: &[DAffine3], noise: &mut Noise) -> Vec<f64> {
    let palette = palettes_with(body, models, noise).concat();
    models.iter().flat_map(row_major).chain(palette).collect()
}

/// Returns the same numbers as a backend returned them.
pub(super) fn numbers_found(found: &MemberReading) -> Vec<f32> {
    [found.models.concat(), found.palette.concat()].concat()
}

impl<'a> ControlScene<'a> {
    fn new(name: &'static str, scene: &'a Scene) -> Self {
        Self::with_slots(name, scene, 4)
    }

    fn with_slots(name: &'static str, scene: &'a Scene, slots: usize) -> Self {
        Self {
            name,
            crowd: TestCrowd::new(scene, slots),
            all: Vec::new(),
            stages: Vec::new(),
            first_tick: ticks_from_secs(START_SECS),
        }
    }

    /// Adds a member with controls, and its twin. Returns its place in the list.
    fn add(&mut self, rng: &mut Rng, body: usize, controls: Controls) -> usize {
        let clips = self.crowd.scene.tight_clips();
        let plan = super::plans::member(rng, self.crowd.scene, body, &clips, 3);
        self.add_plan(rng, plan, controls)
    }

    fn add_plan(&mut self, rng: &mut Rng, plan: MemberPlan, controls: Controls) -> usize {
        let twin = self.crowd.add(plan.clone());
        let member = self.crowd.add(plan);
        let place = plans::place(rng);
        let (parent, played) = (None, Vec::new());
        self.all.push(Controlled { member, twin, controls, place, parent, played });
        self.set(self.all.len() - 1);
        self.all.len() - 1
    }

    /// Gives the tables a member's controls.
    fn set(&mut self, at: usize) {
        let Controlled { member, controls, place, .. } = &self.all[at];
        let index = self.crowd.index(*member);
        let skeleton = &self.crowd.scene.bodies[self.crowd.plan(*member).body].skeleton;
        let tables = &mut self.crowd.tables;
        tables.set_controls(index, skeleton, controls).expect("the controls are valid");
        tables.set_place(index, place).expect("the member exists");
    }

    fn run(&mut self, backend: &mut dyn Backend, tick: u64) {
        self.crowd.update(backend);
        let elapsed = u32::try_from(ELAPSED).expect("a short frame");
        let frame = Frame::of_all(tick).after_ticks(elapsed);
        backend.run(&self.crowd.tables, frame).expect("the backend runs a frame");
    }

    /// Runs three frames, and compares all members in each.
    fn judge(&mut self, backend: &mut dyn Backend) {
        self.judge_frames(backend, 3, |_, _| {});
    }

    /// Runs frames, and compares all members in each. `change` gets the ticks before and at each
    /// frame after the first, before that runs.
    fn judge_frames(
        &mut self,
        backend: &mut dyn Backend,
        frames: u64,
        mut change: impl FnMut(&mut Self, [u64; 2]),
    ) {
        let mut judge = Judge::new(self.name);
        let mut watched = HashMap::new();
        for nth in 0..frames {
            let tick = self.first_tick + nth * ELAPSED;
            if nth > 0 {
                change(self, [tick - ELAPSED, tick]);
            }
            for of in &mut self.all {
                of.played.push(self.crowd.plan(of.member).clone());
            }
            self.run(backend, tick);
            let read = |crowd: &TestCrowd<'_>, member| crowd.read(&mut *backend, member);
            let mut read = read;
            let twins: Vec<_> = self.all.iter().map(|of| read(&self.crowd, of.twin)).collect();
            let found: Vec<_> = self.all.iter().map(|of| read(&self.crowd, of.member)).collect();
            for (at, of) in self.all.iter().enumerate() {
                let frame = OracleFrame {
                    tick,
                    place: OraclePlace::new(&of.place),
                    watched: watched.clone(),
                    parent: of.parent.map(|(parent, joint)| model_of(&found[parent], joint)),
                    motion: None,
                };
                self.compare(&mut judge, of, &locals_of(&twins[at]), &frame, &found[at]);
            }
            watched = self.watched(&found);
        }
        judge.done();
    }

    /// Returns how far clips have moved a member since before the first frame.
    fn moved(&self, of: &Controlled, noise: &mut Noise) -> DAffine3 {
        let mut travel = OracleTravel::default();
        let mut end = self.first_tick;
        for plan in &of.played {
            self.advance(&mut travel, plan, [end - ELAPSED, end], noise);
            end += ELAPSED;
        }
        travel.offset
    }

    /// Moves a member on by a frame in which it plays as planned.
    fn advance(
        &self,
        travel: &mut OracleTravel,
        plan: &MemberPlan,
        span: [u64; 2],
        noise: &mut Noise,
    ) {
        let scene = self.crowd.scene;
        let mover = |play: &Play| OracleMover {
            clip: &scene.clips[play.clip].clip,
            timing: play.timing,
            weighting: play.weighting,
            layer: play.layer as usize,
            scale: scene.retargets.get(&(play.clip, plan.body)).map_or(1.0, OracleRetarget::scale),
        };
        let movers: Vec<_> = plan.plays.iter().map(mover).collect();
        let skeleton = &scene.bodies[plan.body].skeleton;
        let root = skeleton.source_from_joint(JointIndex(0));
        let at_root = |layer: &LayerPlan| match layer.mode {
            LayerMode::Additive => 0.0,
            LayerMode::Override => {
                f64::from(layer.weight) * layer.mask.as_ref().map_or(1.0, |m| f64::from(m[root]))
            }
        };
        let layers: Vec<_> = plan.layers.iter().map(at_root).collect();
        let change = |of: &Inertialization| OracleChange {
            start_tick: of.tick,
            ticks: of.ticks,
            layer: of.outgoing.layer as usize,
        };
        let changes: Vec<_> = plan.inertialization.iter().map(change).collect();
        travel.advance(&movers, &layers, &changes, span, noise);
    }

    /// Returns the world transforms of watched joints.
    fn watched(&self, found: &[MemberReading]) -> HashMap<u32, DAffine3> {
        let mut watched = HashMap::new();
        for (of, found) in self.all.iter().zip(found) {
            let skeleton = &self.crowd.scene.bodies[self.crowd.plan(of.member).body].skeleton;
            for (joint, index) in &of.controls.watches {
                let model = model_of(found, skeleton.source_from_joint(*joint));
                let world = OraclePlace::new(&of.place).world_from_model;
                watched.insert(*index, world * model);
            }
        }
        watched
    }

    fn compare(
        &self,
        judge: &mut Judge,
        of: &Controlled,
        clips: &[Local],
        frame: &OracleFrame,
        found: &MemberReading,
    ) {
        let body = &self.crowd.scene.bodies[self.crowd.plan(of.member).body];
        let member = OracleMember {
            body: &body.oracle,
            skeleton: &body.skeleton,
            controls: &of.controls,
            stages: &self.stages,
        };
        let wanted = bounded(|noise| {
            let motion = of.controls.motion.map(|_| self.moved(of, noise));
            let frame = OracleFrame { motion, ..frame.clone() };
            let (locals, models) = member.posed(clips, &frame, noise);
            let rotation = |found: [f32; 4], wanted: DQuat| {
                let found = DQuat::from_array(found.map(f64::from));
                if found.dot(wanted) < 0.0 { -wanted } else { wanted }
            };
            let mut numbers = Vec::new();
            for (joint, local) in locals.iter().enumerate() {
                numbers.extend(local.translation.to_array());
                numbers.extend(rotation(found.rotations[joint], local.rotation).to_array());
                numbers.extend(local.scale.to_array());
            }
            numbers.extend(model_numbers(&body.oracle, &models, noise));
            numbers
        });
        let got: Vec<f32> = (0..found.rotations.len())
            .flat_map(|joint| {
                let local = [&found.translations[joint][..], &found.rotations[joint]].concat();
                [local, found.scales[joint].to_vec()].concat()
            })
            .chain(numbers_found(found))
            .collect();
        assert_eq!(got.len(), wanted.len(), "{}: numbers of a member", self.name);
        for (at, (got, Bounded { value, bound })) in got.into_iter().zip(wanted).enumerate() {
            judge.number(got, value, bound, MODEL_CAP, || self.number_name(of, at));
        }
    }

    /// Names a number in the list of a member's results.
    fn number_name(&self, of: &Controlled, at: usize) -> String {
        let body = &self.crowd.scene.bodies[self.crowd.plan(of.member).body];
        let joints = body.joints.len();
        let (what, joint, element) = match at {
            _ if at < 10 * joints => ("local", at / 10, at % 10),
            _ if at < 22 * joints => ("model", (at - 10 * joints) / 12, (at - 10 * joints) % 12),
            _ => {
                let entry = at - 22 * joints;
                let joint = body.oracle.palette[entry / 12].0;
                return format!(
                    "{} palette entry {} element {}, moved by {:?}",
                    joint_name(&self.crowd, of.member, joint),
                    entry / 12,
                    entry % 12,
                    of.controls
                );
            }
        };
        let name = joint_name(&self.crowd, of.member, joint);
        format!("{name} {what} element {element}, moved by {:?}", of.controls)
    }
}
