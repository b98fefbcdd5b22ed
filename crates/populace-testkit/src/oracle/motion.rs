//! Root motion: how far clips move a member from one frame to the next.
//!
//! A clip's body is at `m(t)`, a heading about +Y and a shift. From `a` to `b`, with `n` whole cycles
//! `c` in between, it moves by `inverse(m(a)) c^n m(b)`. The moves of a layer are mixed by the
//! clips' mean weights, those of layers as poses are.
//!
//! An inertialized transition keeps a member's velocity: at its start, the difference between the
//! velocity of the frame before and that of the new clips begins to decay by the quintic of poses,
//! `1 - 10 s^3 + 15 s^4 - 6 s^5`. A member moves by the integral of what is left of it.

use glam::{DAffine3, DMat3, DVec3};
use populace_clip::{Clip, TICKS_PER_SEC};

use super::noise::Noise;
use super::{Timing, Weighting};

/// A slot whose clip moves its member.
#[derive(Clone, Copy, Debug)]
pub struct OracleMover<'a> {
    /// The clip; without root motion it stands.
    pub clip: &'a Clip,
    /// Clip time by the clock.
    pub timing: Timing,
    /// Weight by the clock.
    pub weighting: Weighting,
    /// Index of the layer.
    pub layer: usize,
    /// The body's factor on the clip's shifts.
    pub scale: f64,
}

/// A move as a shift, and the sine and cosine of a heading.
#[derive(Clone, Copy, Debug)]
struct Step {
    shift: DVec3,
    sin_cos: [f64; 2],
}

impl Step {
    const NONE: Self = Self { shift: DVec3::ZERO, sin_cos: [0.0, 1.0] };

    fn of(m: &DAffine3) -> Self {
        Self { shift: m.translation, sin_cos: [m.matrix3.z_axis.x, m.matrix3.z_axis.z] }
    }

    fn affine(&self) -> DAffine3 {
        let [sin, cos] = self.sin_cos;
        let length = sin.hypot(cos);
        let (sin, cos) = (sin / length, cos / length);
        let matrix3 =
            DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
        DAffine3 { matrix3, translation: self.shift }
    }

    fn unit(&self) -> Self {
        Self::of(&self.affine())
    }

    fn mix(&self, to: &Self, part: f64) -> Self {
        let sin_cos = [0, 1].map(|i| self.sin_cos[i] + (to.sin_cos[i] - self.sin_cos[i]) * part);
        Self { shift: self.shift.lerp(to.shift, part), sin_cos }
    }
}

/// A velocity: metres, and the sine of a heading, per tick.
type Velocity = [f64; 4];

fn secs(ticks: u64) -> f64 {
    ticks as f64 / TICKS_PER_SEC as f64
}

/// Returns where a clip's body is, at a time since the clip's start.
fn at(clip: &Clip, since_start: f64) -> DAffine3 {
    let motion = clip.root_motion().expect("only clips with a motion are asked");
    let flat: Vec<[f32; 4]> = motion.device_rows().collect();
    let row = |n: usize| {
        let [x, y, z, _] = flat[2 * n].map(f64::from);
        let [sin, cos, ..] = flat[2 * n + 1].map(f64::from);
        Step { shift: DVec3::new(x, y, z), sin_cos: [sin, cos] }
    };
    let last = flat.len() / 2 - 1;
    let place = since_start / f64::from(clip.duration_secs()) * last as f64;
    let place = place.clamp(0.0, last as f64);
    let before = (0..last).rev().find(|n| *n as f64 <= place).unwrap_or(0);
    row(before).mix(&row(before + 1), place - before as f64).affine()
}

impl OracleMover<'_> {
    fn start_tick(&self) -> u64 {
        match self.timing {
            Timing::Loop { start_tick, .. } | Timing::Once { start_tick, .. } => start_tick,
            Timing::Held { .. } => 0,
        }
    }

    /// Returns how many cycles the clip has played at a tick, from its start on; at most one if it
    /// plays once, and less than 0 backwards.
    fn cycles(&self, tick: u64) -> f64 {
        let duration = f64::from(self.clip.duration_secs());
        match self.timing {
            Timing::Loop { start_tick, phase, speed } => {
                phase + secs(tick - start_tick) * f64::from(speed) / duration
            }
            Timing::Once { start_tick, speed } => {
                let played = (secs(tick - start_tick) * f64::from(speed.abs()) / duration).min(1.0);
                if speed < 0.0 { 1.0 - played } else { played }
            }
            Timing::Held { .. } => 0.0,
        }
    }

    /// Returns the tick after which the clip does not play, if its weight falls to 0 at once.
    fn cut_tick(&self) -> Option<u64> {
        match self.weighting {
            Weighting::Ramp { tick, to, secs, .. } if to <= 0.0 && secs <= 0.0 => Some(tick),
            _ => None,
        }
    }

    /// Returns the move between two ticks.
    fn moved(&self, [from, until]: [u64; 2], noise: &mut Noise) -> Step {
        let stands = self.clip.root_motion().is_none() || self.clip.duration_secs() <= 0.0;
        if stands || matches!(self.timing, Timing::Held { .. }) {
            return Step::NONE;
        }
        let loops = matches!(self.timing, Timing::Loop { .. });
        let duration = f64::from(self.clip.duration_secs());
        let start = f64::from(self.clip.start_secs());
        let mut place = |tick| {
            let cycles = self.cycles(tick);
            let whole = if loops { cycles.floor() } else { 0.0 };
            // Devices add the time to the clip's start.
            let time = noise.near((cycles - whole) * duration, start.abs() + duration);
            (whole, at(self.clip, time.clamp(0.0, duration)))
        };
        let ((whole_from, from), (whole_until, until)) = (place(from), place(until));
        let cycle = at(self.clip, duration);
        let count = whole_until - whole_from;
        let one = if count < 0.0 { cycle.inverse() } else { cycle };
        let mut whole = DAffine3::IDENTITY;
        let mut left = count.abs();
        while left >= 1.0 {
            whole = noise.product(&whole, &one);
            left -= 1.0;
        }
        let to = noise.product(&whole, &until);
        let scale = from.translation.length() + to.translation.length();
        let mut step = Step::of(&(from.inverse() * to));
        step.shift = noise.sized(step.shift, scale) * self.scale;
        step.sin_cos = step.sin_cos.map(|v| noise.near(v, 1.0));
        step
    }

    /// Returns the mean weight between two ticks.
    fn mean_weight(&self, [from, until]: [u64; 2]) -> f64 {
        let Weighting::Ramp { tick, from: at_first, secs: ramp_secs, .. } = self.weighting else {
            return self.weighting.weight(until);
        };
        if self.cut_tick().is_some() {
            return f64::from(at_first);
        }
        let end = tick + populace_clip::ticks_from_secs(f64::from(ramp_secs));
        let mut corners = [from, tick.clamp(from, until), end.clamp(from, until), until];
        corners.sort_unstable();
        let weight = |now: u64| self.weighting.weight(now.max(tick));
        let parts =
            corners.windows(2).map(|w| 0.5 * (weight(w[0]) + weight(w[1])) * (w[1] - w[0]) as f64);
        parts.sum::<f64>() / (until - from) as f64
    }
}

/// Returns how far clips move a member between two ticks. `layer_weights` are the weights of all
/// layers at the member's root, 0 for additive ones.
#[must_use]
fn root_move(
    movers: &[OracleMover<'_>],
    layer_weights: &[f64],
    [before, now]: [u64; 2],
    noise: &mut Noise,
) -> DAffine3 {
    let mut all = Step::NONE;
    let frame = (now - before) as f64;
    for (layer, layer_weight) in layer_weights.iter().enumerate() {
        // Each clip counts for the part of the frame in which it plays; the cosine of the rest is
        // 1, since nothing turns then.
        let (mut shift, mut sin, mut turned) = (DVec3::ZERO, 0.0, 0.0);
        let (mut total, mut first, mut last) = (0.0, now, before);
        for mover in movers.iter().filter(|mover| mover.layer == layer) {
            let end = mover.cut_tick().map_or(now, |cut| cut.min(now));
            let span = [mover.start_tick().max(before), end];
            let weight = noise.number(if span[0] < end { mover.mean_weight(span) } else { 0.0 });
            if weight <= 0.0 {
                continue;
            }
            let step = mover.moved(span, noise);
            shift += step.shift * weight;
            sin += step.sin_cos[0] * weight;
            turned += (step.sin_cos[1] - 1.0) * weight;
            total += weight * (span[1] - span[0]) as f64 / frame;
            (first, last) = (first.min(span[0]), last.max(span[1]));
        }
        let over = |divisor: f64| Step {
            shift: shift / divisor,
            sin_cos: [sin / divisor, 1.0 + turned / divisor],
        };
        if layer == 0 {
            if total > 1e-3 {
                // The mean is over the time in which anything plays.
                all = over(total * frame / (last - first) as f64).unit();
            }
        } else if total > 0.0 && *layer_weight > 0.0 {
            all = all.mix(&over(total).unit(), layer_weight * total.min(1.0)).unit();
        }
    }
    let moved = all.affine();
    DAffine3 { matrix3: noise.matrix(moved.matrix3), translation: noise.vector(all.shift) }
}

/// An inertialized transition of a member.
#[derive(Clone, Copy, Debug)]
pub struct OracleChange {
    /// The clock at the start.
    pub start_tick: u64,
    /// Ticks in which differences decay.
    pub ticks: u64,
    /// Index of the layer.
    pub layer: usize,
}

/// How far a member has moved, and its velocity.
#[derive(Clone, Debug)]
pub struct OracleTravel {
    /// The move since the first frame.
    pub offset: DAffine3,
    /// Velocity in the last frame, once there is one.
    velocity: Option<Velocity>,
    /// Velocity at the start of the newest transition, less that of its clips.
    excess: Velocity,
}

impl Default for OracleTravel {
    fn default() -> Self {
        Self { offset: DAffine3::IDENTITY, velocity: None, excess: [0.0; 4] }
    }
}

impl OracleTravel {
    /// Moves on from one frame to the next. `layer_weights` are the weights of all layers at the
    /// member's root, 0 for additive ones.
    pub fn advance(
        &mut self,
        movers: &[OracleMover<'_>],
        layer_weights: &[f64],
        changes: &[OracleChange],
        [before, now]: [u64; 2],
        noise: &mut Noise,
    ) {
        let at_root = changes.iter().filter(|change| layer_weights[change.layer] > 0.0);
        let last_before = |tick: u64| {
            let begun = at_root.clone().filter(|change| change.start_tick < tick);
            begun.max_by_key(|change| change.start_tick)
        };
        let mut moved = root_move(movers, layer_weights, [before, now], noise);
        // Each transition goes on until the next begins.
        let newest = last_before(now);
        let (going_on, begun) = match newest {
            Some(change) if change.start_tick >= before => (last_before(before), newest),
            _ => (newest, None),
        };
        if let Some(change) = going_on {
            let until = begun.map_or(now, |begun| begun.start_tick);
            let carried = change.carried(&self.excess, [before, until], noise);
            moved = noise.product(&moved, &carried);
        }
        if let (Some(change), Some(velocity)) = (begun, self.velocity) {
            let start = change.start_tick;
            let span = [start, start + (now - before)];
            let own = velocity_of(&root_move(movers, layer_weights, span, noise), span);
            self.excess = [0, 1, 2, 3]
                .map(|i| noise.near(velocity[i] - own[i], velocity[i].abs() + own[i].abs()));
            let carried = change.carried(&self.excess, [start, now], noise);
            moved = noise.product(&moved, &carried);
        }
        if newest.is_none_or(|change| now >= change.start_tick + change.ticks) {
            self.excess = [0.0; 4];
        }
        self.offset = noise.product(&self.offset, &moved);
        self.velocity = Some(velocity_of(&moved, [before, now]));
    }
}

fn velocity_of(moved: &DAffine3, [from, until]: [u64; 2]) -> Velocity {
    let Step { shift, sin_cos } = Step::of(moved);
    [shift.x, shift.y, shift.z, sin_cos[0]].map(|far| far / (until - from) as f64)
}

impl OracleChange {
    /// Returns the move within a span that comes of a difference in velocity at the start.
    fn carried(&self, excess: &Velocity, [from, until]: [u64; 2], noise: &mut Noise) -> DAffine3 {
        // Devices subtract the integral up to `from` from that up to `until`.
        let mut integral = |tick: u64| {
            let inertialized = (tick - self.start_tick) as f64 / self.ticks as f64;
            let s = noise.number(inertialized).min(1.0);
            noise.number(s - 2.5 * s.powi(4) + 3.0 * s.powi(5) - s.powi(6))
        };
        let ticks = (integral(until) - integral(from)) * self.ticks as f64;
        let [x, y, z, sin] = excess.map(|per_tick| noise.number(per_tick * ticks));
        Step { shift: DVec3::new(x, y, z), sin_cos: [sin, 1.0] }.affine()
    }
}
