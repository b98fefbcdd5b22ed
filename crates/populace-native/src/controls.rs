//! What beside clips moves a member on the way down its hierarchy: constraints, overrides, and what
//! others watch; the twin of `kernels/steps.cl`.
//!
//! Constraints turn joints in model space, each about its own place, once the joint's parent has
//! its final transform: what hangs on the joint follows rigidly, so that lengths stay however
//! joints are scaled. A constraint is solved at the first joint of its chain, from the chain's
//! local transforms, and hands turns down to the others.

mod chain;
mod feet;
mod gaze;
mod limb;
mod motion;
mod targets;

use populace_device::layout::{
    Constraint, Control, Float4, LINKS_MOST, Link, NONE, STATES_PER_CONTROL, STEP_ATTACH,
    STEP_CARRY, STEP_CHAIN, STEP_FOOT, STEP_GAZE, STEP_MOTION, STEP_OVERRIDE, STEP_PELVIS,
    STEP_REACH, STEP_STAGE, STEP_TURN, STEP_WATCH, Step, TURNS_MOST, WATCHED_ELEMENTS,
};
use populace_device::{Frame, Tables};
use populace_model::math::{quat, vec3};
use populace_model::{Affine, Trs};

use crate::stages::{self, Stages};

/// What is kept from frame to frame: as the last frame left it, and what that was evaluated from.
#[derive(Default)]
pub(crate) struct Keeping {
    pub(crate) now: Kept,
    before: Kept,
    /// Where state machines are.
    pub(crate) running: Vec<Float4>,
}

/// States of members, and what is watched of joints.
#[derive(Default)]
pub(crate) struct Kept {
    pub(crate) states: Vec<Float4>,
    pub(crate) watched: Vec<Float4>,
}

impl Keeping {
    /// Begins a frame: what the last one left is what this one is evaluated from, and stays where
    /// this one writes nothing.
    pub(crate) fn begin_frame(&mut self) {
        self.before.states.clone_from(&self.now.states);
        self.before.watched.clone_from(&self.now.watched);
    }

    /// Takes over what members left.
    pub(crate) fn take_over(&mut self, left: &mut Left) {
        let Kept { states, watched } = &mut self.now;
        for (kept, left) in [(states, &mut left.states), (watched, &mut left.watched)] {
            for (index, value) in left.drain(..) {
                if let Some(kept) = kept.get_mut(index as usize) {
                    *kept = value;
                }
            }
        }
    }
}

/// What a hierarchy is computed in.
pub(crate) trait Models {
    /// `model_from_joint`, once it was set.
    fn model(&self, joint: usize) -> Affine;

    /// The local transform, until the model transform is set.
    fn local(&self, joint: usize) -> Affine;

    /// Sets `model_from_joint`.
    fn set(&mut self, joint: usize, model: Affine);
}

/// What members leave behind for the next frame and for others.
#[derive(Default)]
pub(crate) struct Left {
    /// Elements of the states, by index.
    pub(crate) states: Vec<(u32, Float4)>,
    /// Elements of what is watched, by index.
    pub(crate) watched: Vec<(u32, Float4)>,
}

/// A member's way down its hierarchy.
pub(crate) struct Steering<'a> {
    tables: &'a Tables,
    control: &'a Control,
    /// The control's index.
    index: u32,
    clock: Clock<'a>,
    tick: u64,
    /// Since the frame before.
    elapsed_secs: f32,
    keeping: &'a Keeping,
    left: &'a mut Left,
    turns: [[f32; 4]; TURNS_MOST as usize],
}

/// The clock of a frame, and the stages of users that run by it.
#[derive(Clone, Copy)]
pub(crate) struct Clock<'a> {
    pub(crate) tick: u64,
    pub(crate) elapsed_secs: f32,
    pub(crate) elapsed_ticks: u32,
    pub(crate) stages: &'a Stages,
}

impl<'a> Clock<'a> {
    pub(crate) fn of(frame: Frame, stages: &'a Stages) -> Self {
        let Frame { tick, elapsed_ticks, .. } = frame;
        Self { tick, elapsed_secs: frame.elapsed_secs(), elapsed_ticks, stages }
    }
}

/// The member's control, if anything but clips moves it.
#[inline(always)]
pub(crate) fn control_of(tables: &Tables, place: u32) -> Option<&Control> {
    let index = tables.members().as_slice()[place as usize].control;
    if index == NONE { None } else { tables.controls().as_slice().get(index as usize) }
}

/// Runs local transforms down a hierarchy.
#[inline(always)]
pub(crate) fn descend(models: &mut impl Models, parents: &[u32]) {
    (0..parents.len()).for_each(|joint| take(models, parents, joint));
}

#[inline(always)]
fn take(models: &mut impl Models, parents: &[u32], joint: usize) {
    let local = models.local(joint);
    let model = if parents[joint] == NONE {
        local
    } else {
        models.model(parents[joint] as usize).mul(&local)
    };
    models.set(joint, model);
}

impl<'a> Steering<'a> {
    pub(crate) fn new(
        tables: &'a Tables,
        place: u32,
        clock: Clock<'a>,
        keeping: &'a Keeping,
        left: &'a mut Left,
    ) -> Option<Self> {
        let control = control_of(tables, place)?;
        let index = tables.members().as_slice()[place as usize].control;
        let turns = [quat::identity(); TURNS_MOST as usize];
        let Clock { tick, elapsed_secs, .. } = clock;
        Some(Self { tables, control, index, clock, tick, elapsed_secs, keeping, left, turns })
    }

    /// Runs local transforms down a hierarchy, and takes the member's steps on the way.
    #[inline(never)]
    pub(crate) fn descend(&mut self, models: &mut impl Models, parents: &[u32]) {
        let first = self.control.step_first as usize;
        let steps =
            &self.tables.steps().as_slice()[first..first + self.control.step_count as usize];
        let mut next = 0;
        for step in steps {
            while next <= step.joint as usize {
                take(models, parents, next);
                next += 1;
            }
            self.take_step(step, models, parents);
        }
        (next..parents.len()).for_each(|joint| take(models, parents, joint));
    }

    #[inline(always)]
    fn take_step(&mut self, step: &Step, models: &mut impl Models, parents: &[u32]) {
        let joint = step.joint as usize;
        let parent = parents[joint];
        match step.kind {
            STEP_TURN => self.turn(models, joint, step.turn),
            STEP_GAZE => self.gaze(models, joint, parent, step),
            STEP_REACH => self.reach(models, joint, step),
            STEP_CHAIN => self.chain(models, joint, step),
            STEP_PELVIS => self.pelvis(models, joint, step),
            STEP_FOOT => self.foot(models, joint, step),
            STEP_OVERRIDE => self.override_model(models, joint, step.index),
            STEP_STAGE => {
                let own = models.model(joint);
                if let Some(model) = stages::model(self.tables, self.clock, step, self.control, own)
                {
                    models.set(joint, model);
                }
            }
            STEP_WATCH => {
                let world = self.world_from_model().mul(&models.model(joint));
                self.keep_watched(step.index, world);
            }
            STEP_CARRY => self.keep_watched(step.index, models.model(joint)),
            STEP_ATTACH => self.attach(models, joint, step),
            STEP_MOTION => self.moves(models, joint, step),
            _ => {}
        }
    }

    #[inline(always)]
    fn turn(&self, models: &mut impl Models, joint: usize, turn: u32) {
        models.set(joint, models.model(joint).turned(self.turns[turn as usize]));
    }

    #[inline(always)]
    fn constraint(&self, step: &Step) -> &'a Constraint {
        &self.tables.constraints().as_slice()[step.index as usize]
    }

    #[inline(always)]
    fn links(&self, constraint: &Constraint) -> &'a [Link] {
        let first = constraint.link_first as usize;
        &self.tables.links().as_slice()[first..first + constraint.link_count as usize]
    }

    /// Where the joints of a chain are, as the clips have them, and the last one's model transform;
    /// `from` is the first one's.
    #[inline(always)]
    fn walk(
        models: &impl Models,
        links: &[Link],
        from: Affine,
    ) -> ([[f32; 3]; LINKS_MOST as usize], Affine) {
        let mut places = [[0.0; 3]; LINKS_MOST as usize];
        let mut model = from;
        places[0] = model.origin();
        for (place, link) in places.iter_mut().zip(links).skip(1) {
            model = model.mul(&models.local(link.joint as usize));
            *place = model.origin();
        }
        (places, model)
    }

    /// A transform that the host gave, and its weight.
    fn given(&self, index: u32) -> (Affine, f32) {
        let given = &self.tables.overrides().as_slice()[index as usize];
        let [x, y, z, weight] = given.translation_and_weight.0;
        let trs =
            Trs { translation: [x, y, z], rotation: given.rotation.0, scale: given.scale.xyz() };
        (Affine::from_trs(&trs), weight)
    }

    #[inline(never)]
    fn override_model(&self, models: &mut impl Models, joint: usize, index: u32) {
        let (to, weight) = self.given(index);
        models.set(
            joint,
            if weight >= 1.0 { to } else { part_of_the_way(&models.model(joint), &to, weight) },
        );
    }

    /// Brings a root to the joint that the member is attached to, where an earlier phase of this
    /// frame left that.
    #[inline(never)]
    fn attach(&self, models: &mut impl Models, joint: usize, step: &Step) {
        let first = (step.index * WATCHED_ELEMENTS) as usize;
        if let Some([a, b, c]) =
            self.keeping.now.watched.get(first..first + WATCHED_ELEMENTS as usize)
        {
            let carrier = Affine { rows: [a.0, b.0, c.0] };
            models.set(joint, carrier.mul(&self.given(step.turn).0).mul(&models.model(joint)));
        }
    }

    fn keep_watched(&mut self, watched: u32, joint: Affine) {
        for (element, row) in (watched * WATCHED_ELEMENTS..).zip(joint.rows) {
            self.left.watched.push((element, Float4(row)));
        }
    }

    fn world_from_model(&self) -> Affine {
        let ([x, y, z, scale], [sin, cos, ..]) = (self.control.place.0, self.control.facing.0);
        let (s, c) = (sin * scale, cos * scale);
        Affine { rows: [[c, 0.0, s, x], [0.0, scale, 0.0, y], [-s, 0.0, c, z]] }
    }

    /// A point of the world in model space.
    #[inline(always)]
    fn to_model(&self, point: [f32; 3]) -> [f32; 3] {
        let ([x, y, z, scale], [sin, cos, ..]) = (self.control.place.0, self.control.facing.0);
        let (d, k) = (vec3::sub(point, [x, y, z]), 1.0 / scale);
        [(cos * d[0] - sin * d[2]) * k, d[1] * k, (sin * d[0] + cos * d[2]) * k]
    }

    /// An element of the state that the frame before left.
    fn state(&self, element: u32) -> Float4 {
        let index = self.index * STATES_PER_CONTROL + element;
        self.keeping.before.states.get(index as usize).copied().unwrap_or_default()
    }

    fn keep_state(&mut self, element: u32, value: Float4) {
        self.left.states.push((self.index * STATES_PER_CONTROL + element, value));
    }
}

/// An affine transform between two: the place in a straight line, the axes by the short turn from
/// the one's to the other's, and their lengths in proportion.
fn part_of_the_way(from: &Affine, to: &Affine, k: f32) -> Affine {
    let (a, b) = (axes(from), axes(to));
    let turn = vec3::part_of(turn_from(&a, &b), k);
    let turned = from.turned(turn);
    let column = |m: &Affine, c: usize| [m.rows[0][c], m.rows[1][c], m.rows[2][c]];
    let mut rows = turned.rows;
    for c in 0..3 {
        let (old, new) = (vec3::length(column(from, c)), vec3::length(column(to, c)));
        let factor = if old > 1e-10 { 1.0 + (new / old - 1.0) * k } else { 1.0 };
        for row in &mut rows {
            row[c] *= factor;
        }
    }
    for (row, (start, end)) in rows.iter_mut().zip(from.origin().into_iter().zip(to.origin())) {
        row[3] = start + (end - start) * k;
    }
    Affine { rows }
}

/// The directions of a transform's axes, at right angles to each other.
fn axes(m: &Affine) -> [[f32; 3]; 3] {
    let column = |c: usize| [m.rows[0][c], m.rows[1][c], m.rows[2][c]];
    let x = vec3::unit_or(column(0), [1.0, 0.0, 0.0]);
    let y = vec3::unit_or(vec3::across(column(1), x), vec3::any_across(x));
    [x, y, vec3::cross(x, y)]
}

/// The turn from one set of axes to another: first the one that brings x to x, then that about x
/// which brings y to y.
fn turn_from(from: &[[f32; 3]; 3], to: &[[f32; 3]; 3]) -> [f32; 4] {
    let first = vec3::between(from[0], to[0], from[1]);
    let second = vec3::between(vec3::turned(first, from[1]), to[1], to[0]);
    quat::mul(second, first)
}
