//! Foot IK: planted feet stay where they stand, and the pelvis sinks for them. Twin of
//! `kernels/feet.cl`.
//!
//! Reads constraints, links and the legs' transforms. Writes the model transforms of pelvis or hip,
//! the pelvis' state, and rotations for hips, knees and ankles.

use populace_device::layout::{
    Constraint, Control, FOOT_SETTLE_SECS, FOOT_STATE, Float4, MAX_FEET, MAX_PELVIS_SINK,
    PELVIS_RISE_SECS, PELVIS_STATE,
};
use populace_model::math::{Real, quat, vec3};

use super::contacts::{InContact, ankle_link};
use super::foot::{FootGoal, FootInputs, Leg};
use super::foot_state::{FootState, SETTINGS, STANCE, STATE, Settings, Stance};
use super::foothold::Floor;
use super::limb::{BoneLengths, Limb, weighted};
use super::programs::{Company, Programs, Stop};
use crate::dispatch::Work;
use crate::lanes::{Members, Simd, lane_of, load, put, store};
use crate::matrices::{origin, product, transform_vector};
use crate::widths::JointLanes;

const FEET: usize = MAX_FEET as usize;

/// A leg and its goal, of one member or of several in lanes, and the settings of its constraint.
#[derive(Clone, Copy)]
struct Bent<R> {
    limb: Limb<R>,
    lengths: BoneLengths<R>,
    /// Tangent of half the angle about +Y by which the foot turns.
    turn: R,
    /// As [`FootGoal::follows`].
    follows: [R; 4],
    soft: R,
    weight: R,
}

impl<R: Members> Bent<R> {
    /// Returns a leg of no length.
    #[inline(always)]
    fn none() -> Self {
        let zero = R::splat(0.0);
        let limb = Limb { upper: [zero; 3], lower: [zero; 3], bend: [zero; 3], to: [zero; 3] };
        let lengths = limb.bone_lengths();
        Self { limb, lengths, turn: zero, follows: [zero; 4], soft: zero, weight: zero }
    }

    /// Puts a leg, its goal, and the limits of its constraint together.
    #[inline(always)]
    fn bend_leg(leg: &Leg<R>, goal: &FootGoal<R>, [soft, weight]: [R; 2]) -> Self {
        let [x, y, z, turn] = goal.ankle;
        let limb = Limb {
            upper: vec3::sub(leg.knee, leg.hip),
            lower: vec3::sub(origin(&leg.ankle), leg.knee),
            bend: leg.bend,
            to: vec3::sub([x, y, z], leg.hip),
        };
        let lengths = limb.bone_lengths();
        Self { limb, lengths, turn, follows: goal.follows, soft, weight }
    }

    /// Returns the drop of the pelvis, in metres, that the leg needs to reach its goal, times the
    /// leg's weight.
    #[inline(always)]
    fn sinks(&self) -> R {
        let length = self.lengths.upper + self.lengths.lower;
        let one = R::splat(1.0);
        let (reach, most) = (length * (one - self.soft), length * R::splat(MAX_PELVIS_SINK));
        let [x, y, z] = self.limb.to;
        let needed = -y - vec3::root(reach * reach - x * x - z * z);
        R::choose(most.less(needed), most, needed) * self.weight
    }

    /// Returns the rotations of hip, knee and ankle.
    #[inline(always)]
    fn leg_rotations(&self) -> [[R; 4]; 3] {
        let (zero, one, weight) = (R::splat(0.0), R::splat(1.0), self.weight);
        let [hip, knee] = self.limb.limb_rotations(self.lengths, None, self.soft);
        let (hip, knee) = (weighted(hip, weight), weighted(knee, weight));
        // The ankle keeps its rotation from before the constraint, and follows the slope: by the
        // rotation from up to the normal.
        let mut ankle = quat::normalize_or([zero, self.turn * weight, zero, one], quat::identity());
        let [nx, ny, nz, follows] = self.follows;
        let leans = R::either(zero.less(nx.abs()), zero.less(nz.abs()));
        if R::any(leans) {
            let slope = quat::normalize_or([nz, zero, -nx, one + ny], quat::identity());
            let sloped = quat::mul(vec3::part_as_told(slope, follows * weight), ankle);
            ankle = quat::choose::<R>(leans, sloped, ankle);
        }
        [hip, knee, quat::mul(ankle, quat::conjugate(quat::mul(knee, hip)))]
    }
}

/// Inputs of a step of feet, in lanes of members, collected member by member.
struct Collected<const COUNT: usize> {
    /// Numbers of [`Settings`] for each foot.
    settings: [[Simd<COUNT>; SETTINGS]; FEET],
    /// Numbers of [`InContact`] for each foot.
    contacts: [[Simd<COUNT>; 2]; FEET],
    /// Numbers of [`FootState`] for each foot, in the frame before, then in this one.
    states: [[Simd<COUNT>; STATE]; FEET],
    /// Numbers of [`Stance`].
    stances: [Simd<COUNT>; STANCE],
    /// Drop of the pelvis in the frame before, the seconds for which all feet had stood, and 1 if
    /// these are known.
    pelvis: [Simd<COUNT>; PELVIS],
}

/// Numbers of the state of a pelvis.
const PELVIS: usize = 3;

const _: () = assert!(FOOT_STATE == PELVIS_STATE + 1, "states of feet follow that of the pelvis");

/// Returns the numbers of [`Settings`] of a constraint.
#[inline(always)]
fn settings_in(constraint: &Constraint) -> [f32; SETTINGS] {
    let [x, y, z] = constraint.axis.xyz();
    let ([a, b, c, d], [e, f, g, h]) = (constraint.up.0, constraint.limits.0);
    [x, y, z, a, b, c, d, e, f, g, h]
}

/// Returns how far the pelvis is lowered, in metres. It sinks at once, so that feet reach the
/// ground, and takes its time to rise.
#[inline(always)]
fn eased_drop<R: Real>(wanted: R, [before, known]: [R; 2], elapsed_secs: f32) -> R {
    let part = R::splat(elapsed_secs / (elapsed_secs + PELVIS_RISE_SECS));
    let rises = R::both(wanted.less(before), R::splat(0.5).less(known));
    R::choose(rises, before + (wanted - before) * part, wanted)
}

/// Returns the seconds for which all feet will have stood if none lets go, at most
/// [`FOOT_SETTLE_SECS`].
#[inline(always)]
fn stood_after<R: Real>(before: R, elapsed_secs: f32) -> R {
    let (after, most) = (before + R::splat(elapsed_secs), R::splat(FOOT_SETTLE_SECS));
    R::choose(after.less(most), after, most)
}

/// The next step of members side by side, the pelvis above their feet.
pub(super) struct PelvisStep<'a, P>(pub(super) &'a mut P);

impl<C: Company<COUNT>, const COUNT: usize> Work for PelvisStep<'_, Programs<'_, C, COUNT>> {
    const IS_WIDE: bool = COUNT > 1;

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        self.0.pelvis::<C::Members<J>>();
    }
}

/// The next step of members side by side, a leg that something moved after the pelvis.
pub(super) struct FootStep<'a, P>(pub(super) &'a mut P);

impl<C: Company<COUNT>, const COUNT: usize> Work for FootStep<'_, Programs<'_, C, COUNT>> {
    const IS_WIDE: bool = COUNT > 1;

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        self.0.foot::<C::Members<J>>();
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Walks down the chain of a leg from link `start`, whose joint has a model transform. `axis`
    /// is the direction in the hip that the knee bends to.
    #[inline(always)]
    fn walk_leg<R: Members>(
        &self,
        foot: &Constraint,
        start: usize,
        first: usize,
        axis: [R; 3],
    ) -> Leg<R> {
        let (links, none) = (self.links(foot), [R::splat(0.0); 3]);
        let mut model = self.joints.models_of(links[start].joint as usize, first);
        let mut leg = Leg { hip: none, knee: none, bend: none, ankle: model, toes: model };
        let ankle = ankle_link(foot);
        for (at, link) in links.iter().enumerate().skip(start) {
            if at > start {
                model = product(&model, &self.joints.locals_of(link.joint as usize, first));
            }
            if at == foot.upper as usize {
                leg.hip = origin(&model);
                leg.bend = transform_vector(&model, axis);
            }
            if at == foot.middle as usize {
                leg.knee = origin(&model);
            }
            if at == ankle {
                leg.ankle = model;
            }
        }
        leg.toes = model;
        leg
    }

    /// Collects the settings of each member's constraint at `nth` after that of its step. Equal
    /// programs share them.
    #[inline(always)]
    fn put_settings(&mut self, nth: usize) -> [Simd<COUNT>; SETTINGS] {
        let mut settings = [Simd([0.0; COUNT]); SETTINGS];
        let constraints = self.inputs.tables.constraints().as_slice();
        if let (true, Some((step, _))) = (self.share_rows(), self.first_stop()) {
            return settings_in(&constraints[step.index as usize + nth]).map(Simd::splat);
        }
        for lane in 0..self.members.len() {
            let Some(Stop { step, .. }) = self.stop(lane) else { continue };
            put(&mut settings, lane, settings_in(&constraints[step.index as usize + nth]));
        }
        settings
    }

    /// Collects the inputs of all members. `feet` are the constraints of the first member.
    #[inline(always)]
    fn collect<R: Members>(&mut self, feet: &[Constraint]) -> Collected<COUNT> {
        let none = Simd([0.0; COUNT]);
        let mut all = Collected {
            settings: [[none; SETTINGS]; FEET],
            contacts: self.put_contacts::<R>(feet),
            states: [[none; STATE]; FEET],
            stances: [none; STANCE],
            pelvis: [none; PELVIS],
        };
        for (nth, settings) in all.settings[..feet.len()].iter_mut().enumerate() {
            *settings = self.put_settings(nth);
        }
        for lane in 0..self.members.len() {
            let Some(Stop { solver, .. }) = self.stop(lane) else { continue };
            let Control { place, stride, sine, cosine, .. } = solver.control;
            let ([x, y, z, scale], [a, b, c, _]) = (place.0, stride.0);
            put(&mut all.stances, lane, [x, y, z, scale, *sine, *cosine, a, b, c]);
            let Float4([drop, stood_secs, _, bits]) = solver.state(PELVIS_STATE);
            let known = bits.to_bits() == solver.control.epoch;
            let numbers = if known { [drop, stood_secs, 1.0] } else { [drop, 0.0, 0.0] };
            put(&mut all.pelvis, lane, numbers);
            for (nth, states) in (0..).zip(&mut all.states[..feet.len()]) {
                put(states, lane, solver.foot_state(nth));
            }
        }
        all
    }

    /// Finds the goals of the feet of as many members as `R` has lanes, how far their pelvises are
    /// lowered, and the seconds for which all their feet have stood. Solves the legs too, unless
    /// something else moves them after the pelvis: then their goals are handed down.
    #[inline(always)]
    fn plant<R: Members>(
        &mut self,
        feet: &[Constraint],
        all: &mut Collected<COUNT>,
        first: usize,
    ) -> Option<[R; 2]> {
        let ((step, _), tables) = (self.first_stop()?, self.inputs.tables);
        let (operand, elapsed_secs) = (step.operand as usize, self.inputs.frame.elapsed_secs());
        let floor = Floor::floor_of(tables, elapsed_secs);
        let stance = Stance::of_numbers(load(&all.stances, first));
        let [.., soft, weight, _, _]: [R; SETTINGS] = load(&all.settings[0], first);
        let mut legs = [Bent::none(); FEET];
        let [drop_before, stood_secs, known]: [R; PELVIS] = load(&all.pelvis, first);
        let mut stood_secs = stood_after(stood_secs, elapsed_secs);
        let mut needed = R::splat(0.0);
        for (nth, foot) in feet.iter().enumerate() {
            let settings = Settings::of_numbers(load(&all.settings[nth], first));
            let inputs = FootInputs {
                foot,
                soles: tables.soles().as_slice(),
                floor,
                elapsed_secs,
                stance,
                settings,
                leg: self.walk_leg(foot, 0, first, settings.axis),
                contact: InContact::of_numbers(load(&all.contacts[nth], first)),
                state: FootState::of_numbers(load(&all.states[nth], first)),
                stood_secs,
            };
            let (goal, next) = inputs.foot_goal();
            stood_secs = R::choose(next.planted, stood_secs, R::splat(0.0));
            store(&next.numbers(), &mut all.states[nth], first);
            if feet[0].at_once == 0 {
                store(&goal.ankle, &mut self.rotations[operand + 3 * nth], first);
                store(&goal.follows, &mut self.rotations[operand + 3 * nth + 1], first);
            }
            legs[nth] = Bent::bend_leg(&inputs.leg, &goal, [soft, weight]);
            let sinks = legs[nth].sinks();
            needed = R::choose(needed.less(sinks), sinks, needed);
        }
        let drop = eased_drop(needed, [drop_before, known], elapsed_secs);
        if feet[0].at_once != 0 {
            for (nth, leg) in legs[..feet.len()].iter_mut().enumerate() {
                leg.limb.to[1] = leg.limb.to[1] + drop;
                for (at, rotation) in leg.leg_rotations().iter().enumerate() {
                    store(rotation, &mut self.rotations[operand + 3 * nth + at], first);
                }
            }
        }
        Some([drop, stood_secs])
    }

    /// Finds the goals of all feet, and lowers the pelvises until the legs can reach them. Solves
    /// the legs too, unless something else moves them after the pelvis.
    #[inline(always)]
    fn pelvis<R: Members>(&mut self) {
        let Some((step, constraint)) = self.first_stop() else { return };
        let count = constraint.target_count as usize;
        let feet = &self.inputs.tables.constraints().as_slice()[step.index as usize..][..count];
        let mut all = self.collect::<R>(feet);
        let mut pelvises = [Simd([0.0; COUNT]); 2];
        for first in (0..self.members.len()).step_by(R::COUNT) {
            if let Some(pelvis) = self.plant::<R>(feet, &mut all, first) {
                store(&pelvis, &mut pelvises, first);
            }
        }
        let [drops, stood_secs] = &pelvises;
        self.joints.lower(step.joint as usize, drops);
        for lane in 0..self.members.len() {
            let Some(Stop { mut solver, .. }) = self.stop(lane) else { continue };
            let epoch = f32::from_bits(solver.control.epoch);
            let mut next = [Float4([drops.0[lane], stood_secs.0[lane], 0.0, epoch]); 1 + 2 * FEET];
            for (next, states) in next[1..].as_chunks_mut().0.iter_mut().zip(&all.states[..count]) {
                *next = solver.next_state(&FootState::of_numbers(lane_of(states, lane)));
            }
            solver.keep_states(PELVIS_STATE, &next[..1 + 2 * count]);
        }
    }

    /// Solves legs that something else has moved after the pelvis, for the goals that
    /// [`pelvis`](Self::pelvis) found.
    #[inline(always)]
    fn foot<R: Members>(&mut self) {
        let Some((step, foot)) = self.first_stop() else { return };
        let (joint, operand) = (step.joint as usize, step.operand as usize);
        let all = self.put_settings(0);
        for first in (0..self.members.len()).step_by(R::COUNT) {
            let Settings { axis, limits: [soft, weight, ..], .. } =
                Settings::of_numbers(load::<R, COUNT, SETTINGS>(&all, first));
            let leg = self.walk_leg(foot, foot.upper as usize, first, axis);
            let goal = FootGoal {
                ankle: load(&self.rotations[operand], first),
                follows: load(&self.rotations[operand + 1], first),
            };
            let rotations = Bent::bend_leg(&leg, &goal, [soft, weight]).leg_rotations();
            for (at, rotation) in rotations.iter().enumerate() {
                store(rotation, &mut self.rotations[operand + at], first);
            }
        }
        self.joints.rotate::<R>(joint, &self.rotations[operand]);
    }
}
