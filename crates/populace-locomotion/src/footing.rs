//! How the feet of a mix of clips touch down, and how a walker steps that is led from foothold to
//! foothold.

use populace::Stride;

use crate::Error;
use crate::error::within;
use crate::path::check_coordinate;

/// Seconds in which the cycle is brought to the phase of a step that leads it.
const CATCHES_UP_SECS: f32 = 0.1;
/// How slow and how fast the cycle goes meanwhile, as multiples of the rate of the step.
const RATES: (f32, f32) = (0.4, 1.8);
/// The least that an ankle has stepped when its foot touches down, in metres.
const LEAST_STEP_M: f32 = 0.02;

/// How a foot of a mix touches down, at the scale of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Landing {
    /// The phase at which the body is over the middle of its sole, 0 to 1.
    pub(crate) over: f32,
    /// The part of a cycle from touch-down until then, and that until the foot lifts.
    pub(crate) until_over: f32,
    pub(crate) until_lift: f32,
    /// How far ahead of the body the middle of the sole is at touch-down, once it lies flat, in
    /// metres.
    pub(crate) ahead_m: f32,
    /// The way of the ankle until then, in metres. Strides scale it.
    pub(crate) stepped_m: f32,
    /// How far to the left of the body the ankle is then, and half the length of the sole, in
    /// metres.
    pub(crate) aside_m: f32,
    pub(crate) half_m: f32,
}

impl Landing {
    /// Returns the landing a part of the way, 0 to 1, to that of another mix.
    pub(crate) fn towards(&self, other: &Self, part: f32) -> Self {
        let mix = |from: f32, to: f32| from + (to - from) * part;
        let turn = half_turn(other.over - self.over);
        Self {
            over: (self.over + turn * part).rem_euclid(1.0),
            until_over: mix(self.until_over, other.until_over),
            until_lift: mix(self.until_lift, other.until_lift),
            ahead_m: mix(self.ahead_m, other.ahead_m),
            stepped_m: mix(self.stepped_m, other.stepped_m),
            aside_m: mix(self.aside_m, other.aside_m),
            half_m: mix(self.half_m, other.half_m),
        }
    }

    /// Returns whether the ankle steps far enough for strides to lead it.
    pub(crate) fn steps(&self) -> bool {
        self.stepped_m > LEAST_STEP_M
    }

    /// Returns the part of a cycle until the body is over the foot, at a phase; `None` while the
    /// foot stands.
    pub(crate) fn in_the_air(&self, phase: f32) -> Option<f32> {
        let until = (self.over - phase).rem_euclid(1.0);
        let lifted = self.until_over + self.swing();
        (self.until_over..lifted).contains(&until).then_some(until)
    }

    /// The part of a cycle for which the foot is in the air.
    pub(crate) fn swing(&self) -> f32 {
        1.0 - self.until_lift
    }
}

/// A step from one foothold to the next that a walker is led through. Its feet stand on the
/// footholds in turn, beside the way of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LedStep {
    /// The part of the way from over the last foothold to over the next, 0 to 1.
    pub part: f32,
    /// Seconds from one to the other, 0.1 to 10.
    pub secs: f32,
    /// The next foothold and the one after it, in metres to the left and ahead of where the body
    /// will be when the foot touches down, in its directions then. A foot without one steps as far
    /// as that before it.
    pub footholds: [Option<[f32; 2]>; 2],
}

impl LedStep {
    /// Refuses a number that is not finite or out of its range.
    pub(crate) fn check(&self) -> Result<(), Error> {
        within("the part of a step", self.part, 0.0..=1.0, "from 0 to 1")?;
        within("the time of a step", self.secs, 0.1..=10.0, "from 0.1 to 10 seconds")?;
        let mut numbers = self.footholds.iter().flatten().flatten();
        numbers.try_for_each(|number| check_coordinate(*number))
    }

    /// Returns the phase at which a cycle is now, if the next foothold is of one of the feet.
    pub(crate) fn phase(&self, landing: &Landing) -> f32 {
        (landing.over - 0.5 * (1.0 - self.part)).rem_euclid(1.0)
    }

    /// Returns the cycles in a second that bring the cycle from a phase at the beginning of a frame
    /// of `secs` to that of the step. Either foot may take it.
    pub(crate) fn cycles_per_sec(&self, landings: &[Landing; 2], phase: f32, secs: f32) -> f32 {
        let usual = 0.5 / self.secs;
        let late = landings.map(|landing| half_turn(self.phase(&landing) - usual * secs - phase));
        let late = if late[0].abs() <= late[1].abs() { late[0] } else { late[1] };
        (usual + late / CATCHES_UP_SECS).clamp(RATES.0 * usual, RATES.1 * usual)
    }

    /// Returns the stride that takes the foot in the air to its foothold, for a body of a scale at
    /// a phase; `None` if both feet stand or the foothold is not known.
    pub(crate) fn stride(&self, landings: &[Landing; 2], phase: f32, scale: f32) -> Option<Stride> {
        let in_the_air = landings.iter().filter_map(|of| Some((of.in_the_air(phase)?, of)));
        let (until, landing) = in_the_air.min_by(|a, b| a.0.total_cmp(&b.0))?;
        // Half a cycle is a step: the foot is on its way to the next foothold or to that after it.
        let nth = usize::from(2.0 * until > 1.5 - self.part);
        let [left, ahead] = self.footholds[nth]?.map(|metres| metres / scale);
        let stepped = landing.stepped_m;
        Some(Stride::along([left / stepped, 1.0 + (ahead - landing.ahead_m) / stepped]))
    }
}

/// Returns the same turn in cycles, from minus a half to a half.
fn half_turn(cycles: f32) -> f32 {
    (cycles + 0.5).rem_euclid(1.0) - 0.5
}
