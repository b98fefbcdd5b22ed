//! The oracle's results for members of a crowd, with error bounds.

use populace_clip::TICKS_PER_SEC;

use crate::oracle::{
    OracleInertialization, OracleLayer, OraclePose, OracleSampledState, OracleSlot, Timing,
    Weighting, evaluate_inertialization,
};
use crate::tolerance::{
    AffineBound, LocalBound, SampleBound, UNIT, WEIGHT_ERROR, model_bounds, palette_bounds,
};
use crate::{Inertialization, LayerPlan, MemberPlan, Play, TestCrowd};

/// The oracle's results for a member, and the bounds that a backend must keep.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    pub(crate) pose: OraclePose,
    pub(crate) locals: Vec<LocalBound>,
    pub(crate) models: Vec<AffineBound>,
    pub(crate) palette: Vec<AffineBound>,
}

impl<'a> TestCrowd<'a> {
    /// Returns the slots of a member at a tick, for the oracle.
    #[must_use]
    pub fn oracle_slots(&self, plan: &MemberPlan, tick: u64) -> Vec<OracleSlot<'a>> {
        let scene = self.scene;
        let slot = |play: &Play| {
            let clip = &scene.clips[play.clip].clip;
            OracleSlot {
                clip: clip.source(),
                time_secs: play.timing.time_secs(tick, clip),
                weight: play.weighting.weight(tick),
                layer: play.layer as usize,
                retarget: scene.retargets.get(&(play.clip, plan.body)),
            }
        };
        plan.plays.iter().map(slot).collect()
    }

    /// Returns the transitions of a member at a tick, for the oracle.
    #[must_use]
    pub fn oracle_inertialization(
        &self,
        plan: &MemberPlan,
        tick: u64,
    ) -> Vec<OracleInertialization<'a>> {
        let inertialization = |of: &Inertialization| OracleInertialization {
            outgoing: self.sampled_state(&of.outgoing, plan.body, of.tick),
            incoming: self.sampled_state(&of.incoming, plan.body, of.tick),
            start_tick: of.tick,
            elapsed_secs: (tick - of.tick) as f64 / TICKS_PER_SEC as f64,
            secs: of.ticks as f64 / TICKS_PER_SEC as f64,
            share: f64::from(of.share),
            share_per_sec: f64::from(of.share_per_sec),
            layer: of.outgoing.layer as usize,
        };
        plan.inertialization.iter().map(inertialization).collect()
    }

    fn sampled_state(&self, play: &Play, body: usize, tick: u64) -> OracleSampledState<'a> {
        let clip = &self.scene.clips[play.clip].clip;
        let [secs, neighbour_secs] = self.sampled_secs(play, tick);
        let distance = neighbour_secs - secs;
        OracleSampledState {
            clip: clip.source(),
            secs,
            neighbour_secs,
            rate: if distance == 0.0 { 0.0 } else { play.timing.speed(tick, clip) / distance },
            retarget: self.scene.retargets.get(&(play.clip, body)),
        }
    }

    /// Returns a member's expected results. `None` if one of its clips jumps so near to the time
    /// that either side is right, or if only a clip's own bound holds.
    pub(crate) fn expected(&self, member: usize, tick: u64) -> Option<Expected> {
        let plan = self.plan(member);
        let clip = |play: &Play| &self.scene.clips[play.clip];
        let jumps = |(play, tick): (&Play, u64)| play.timing.is_near_jump(tick, &clip(play).clip);
        if plan.shown(tick).any(jumps) {
            return None;
        }
        let mut bound = SampleBound::default();
        for (play, _) in plan.shown(tick) {
            let of_clip = match play.timing {
                Timing::Held { secs } if is_exact(&clip(play).exact_times, secs) => {
                    clip(play).at_keys
                }
                _ => clip(play).between_keys?,
            };
            bound = bound.or(of_clip);
        }
        Some(self.expected_within(member, tick, bound))
    }

    /// Widens a bound by the errors that retargeted clips add for a joint: the error of each source
    /// rotation on the way, the rounding of up to four products, 8 units each, and storage.
    /// Positions are off by the rotation error times the lever.
    fn with_retargets(
        &self,
        own: SampleBound,
        plan: &MemberPlan,
        of_one: SampleBound,
        joint: usize,
    ) -> SampleBound {
        let mut widest = own;
        for (play, _) in plan.shown(0) {
            let Some(retarget) = self.scene.retargets.get(&(play.clip, plan.body)) else {
                continue;
            };
            let (joints, reach) = retarget.depends_on(joint);
            let clip = &self.scene.clips[play.clip].clip;
            let mut bound = SampleBound { translation: 0.0, rotation: 4.0 * 8.0 * UNIT, ..of_one };
            let mut moved = 0.0;
            for source in joints {
                let name = &retarget.source_joints()[source].name;
                let one = of_one.with_storage(name, std::iter::once(clip));
                bound.rotation += one.rotation + 8.0 * UNIT;
                moved += one.translation;
            }
            if reach > 0.0 {
                // A quaternion with an error of `e` rotates by at most `2 e`.
                bound.translation_size = bound.translation_size.max(reach);
                bound.translation = 2.0 * bound.rotation * reach + retarget.scale() * moved;
                bound.translation *= 1.0 / self.least_scale(plan.body);
            }
            let converted = self.converted.get(&(play.clip, plan.body));
            let name = &self.scene.bodies[plan.body].joints[joint].name;
            widest = widest.or(bound.with_storage(name, converted.into_iter()));
        }
        widest
    }

    /// Returns the smallest scale of any joint, at most 1. Translations are in units of the parent,
    /// so this bounds how much longer than in metres they may be.
    fn least_scale(&self, body: usize) -> f64 {
        let scales = self.scene.bodies[body].joints.iter().flat_map(|joint| joint.rest.scale);
        scales.map(f64::from).fold(1.0, f64::min)
    }

    /// Returns a member's expected results if each slot's sample is within `bound`.
    pub(crate) fn expected_within(&self, member: usize, tick: u64, bound: SampleBound) -> Expected {
        let plan = self.plan(member);
        let body = &self.scene.bodies[plan.body].oracle;
        let layer = |layer: &LayerPlan| OracleLayer {
            mode: layer.mode,
            weight: f64::from(layer.weight),
            mask: layer.mask.as_ref().map(|mask| mask.iter().map(|w| f64::from(*w)).collect()),
        };
        let layers: Vec<_> = plan.layers.iter().map(layer).collect();
        let slots = self.oracle_slots(plan, tick);
        let inertialization = self.oracle_inertialization(plan, tick);
        let pose = evaluate_inertialization(body, &slots, &inertialization, &layers);
        let bound = widen_for_ramps(bound, plan, &slots);
        let joints = &self.scene.bodies[plan.body].joints;
        let local = |j: usize| {
            let clips = plan.shown(tick).map(|(play, _)| &self.scene.clips[play.clip].clip);
            let bound =
                self.with_retargets(bound.with_storage(&joints[j].name, clips), plan, bound, j);
            LocalBound::after_pose(
                &bound,
                &body.rest(j),
                &pose.gains[j],
                slots.len() + inertialization.len(),
            )
        };
        let locals: Vec<_> = (0..joints.len()).map(local).collect();
        let models = model_bounds(body, &pose.locals, &pose.model_from_joint, &locals);
        let palette = palette_bounds(body, &pose.model_from_joint, &models);
        Expected { pose, locals, models, palette }
    }
}

/// Returns whether rows are exact at a time: at any of `times`, and before and after all keys.
fn is_exact(times: &[f32], secs: f32) -> bool {
    let outside =
        times.first().is_none_or(|t| secs <= *t) || times.last().is_none_or(|t| secs >= *t);
    outside || times.contains(&secs)
}

/// Widens a bound by the errors of weights that ramp. A share of a ramp is a product of two ramps.
fn widen_for_ramps(bound: SampleBound, plan: &MemberPlan, slots: &[OracleSlot<'_>]) -> SampleBound {
    let ramps = |play: &Play| match play.weighting {
        Weighting::Constant(_) => 0.0,
        Weighting::Ramp { .. } => 1.0,
        Weighting::Share { .. } => 2.0,
    };
    let ramps = plan.plays.iter().map(ramps).fold(0.0, f64::max);
    if ramps == 0.0 {
        return bound;
    }
    let total = |layer: usize| -> f64 {
        let of_layer = slots.iter().filter(|s| s.layer == layer);
        of_layer.map(|s| s.weight).sum()
    };
    let least = (0..plan.layers.len()).map(total).filter(|t| *t > 0.0).fold(1.0, f64::min);
    bound.with_weight_error(ramps * WEIGHT_ERROR, slots.len(), least)
}
