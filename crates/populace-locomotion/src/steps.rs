//! Which mix of clips goes at a speed, and with which stride, measured at speeds from standing to
//! beyond the fastest clip.

use crate::footing::Landing;
use crate::soles::Treadmill;
use crate::step::Step;
use crate::strides::{MixSteps, MixStride};
use crate::{Error, Gait, MixedClip};

/// Mixes that are measured between two neighbouring clips.
const MIXES: usize = 8;
/// How the length of a stride grows with speed below the slowest clip: with this power of it, as
/// that of people does (D. W. Grieve, "Gait patterns and the speed of walking", Biomedical
/// Engineering 3 (1968), 119-122; A. D. Kuo, "A simple model of bipedal walking predicts the
/// preferred speed-step length relationship", J. Biomechanical Engineering 123 (2001), 264-269).
const STRIDE_POWER: f32 = 0.42;
/// The slowest stepping, as a fraction of the rate of the slowest clip.
const SLOWEST_RATE: f32 = 0.45;
/// A stride is not shorter than this part of what the speed asks for, to stay within reach.
const SHORTEST: f32 = 0.5;
/// Speeds between two neighbouring clips at which mixes are measured, and from the fastest to this
/// multiple of its speed.
const ROWS: u16 = 16;
const BEYOND: f32 = 3.0;
/// Speeds below this fraction of that of the slowest clip stand still.
pub(crate) const STANDS: f32 = 0.01;
/// A measured stride is not less and not more than these parts of the expected one.
const NEAR: (f32, f32) = (0.4, 2.0);
/// The mix of a member that steps on the spot: this part of the way from standing to the slowest
/// clip.
const ON_THE_SPOT: f32 = 0.45;

/// A moving clip at its own speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) speed: f32,
    /// Metres per cycle.
    pub(crate) stride: f32,
}

/// How a member steps at one speed, in metres per second.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) speed: f32,
    /// Metres per cycle.
    pub(crate) stride: f32,
    pub(crate) mix: f32,
    pub(crate) own: MixStride,
    /// How feet touch down, if that is known.
    pub(crate) landings: Option<[Landing; 2]>,
}

/// The mixes of a character's clips, idle first, each with its gait.
pub(crate) struct Mixes<'a> {
    treadmill: &'a mut Treadmill,
    clips: &'a [(MixedClip, Gait)],
    samples: &'a [Sample],
    /// Own strides of mixes between standing and the first sample, and between neighbouring
    /// samples, at `MIXES + 1` even points, in metres.
    strides: Vec<[f32; MIXES + 1]>,
}

impl<'a> Mixes<'a> {
    /// Measures the own strides of mixes. A mix that shows none, or one that is far from that of
    /// its clips, has a stride in proportion.
    pub(crate) fn new(
        treadmill: &'a mut Treadmill,
        clips: &'a [(MixedClip, Gait)],
        samples: &'a [Sample],
    ) -> Result<Self, Error> {
        let mut mixes = Self { treadmill, clips, samples, strides: Vec::new() };
        let mut below = 0.0;
        for (segment, sample) in samples.iter().enumerate() {
            let mut own = |mix, expected| {
                let steps = mixes.measure(mix)?;
                let own = steps.map(|steps| steps.stride_m(1.0, 0.0));
                Ok::<_, Error>(own.filter(|own| is_near(*own, expected)).unwrap_or(expected))
            };
            let first = segment as f32;
            let above = own(first + 1.0, sample.stride)?;
            let mut strides = [below; MIXES + 1];
            strides[MIXES] = above;
            for (nth, stride) in strides.iter_mut().enumerate().take(MIXES).skip(1) {
                let part = nth as f32 / MIXES as f32;
                *stride = own(first + part, below + (above - below) * part)?;
            }
            mixes.strides.push(strides);
            below = above;
        }
        Ok(mixes)
    }

    /// Measures a mix: a point of the blend space.
    fn measure(&mut self, mix: f32) -> Result<Option<MixSteps>, Error> {
        let weights = (0_u16..).map(|nth| 1.0 - (mix - f32::from(nth)).abs());
        let weighted = self.clips.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        let mixed: Vec<_> = weighted
            .map(|((clip, gait), weight)| (MixedClip { weight, ..clip.clone() }, gait))
            .collect();
        MixSteps::measure(self.treadmill, &mixed)
    }

    /// Returns how a member steps at speeds from standing to beyond the fastest clip.
    pub(crate) fn rows(&mut self) -> Result<Vec<Row>, Error> {
        let slowest = self.samples[0].speed;
        let mut rows = vec![self.row(STANDS * slowest)?];
        let parts = |count: u16| (1..=count).map(move |nth| f32::from(nth) / f32::from(count));
        for part in parts(ROWS) {
            rows.push(self.row(part * slowest)?);
        }
        let beyond = self.samples[self.samples.len() - 1].speed * BEYOND;
        let ends = self.samples.iter().skip(1).map(|sample| sample.speed).chain([beyond]);
        let mut from = slowest;
        for until in ends {
            for part in parts(ROWS) {
                rows.push(self.row(from * (until / from).powf(part))?);
            }
            from = until;
        }
        Ok(rows)
    }

    /// Returns how a member steps at a speed in metres per second. Its stride is shortened, and its
    /// cadence raised, until legs reach the feet that the mix plants.
    fn row(&mut self, speed: f32) -> Result<Row, Error> {
        let (segment, wanted) = self.stride_at(speed);
        let (mix, own_m) = self.mix_of_stride(segment, wanted);
        let Some(steps) = self.measure(mix)? else {
            return Ok(Row::of_ankles(speed, wanted, mix, own_m));
        };
        let stride = steps.within_reach(SHORTEST * wanted, wanted, speed);
        let own = steps.towards(stride, speed / stride);
        if !own.is_plausible(own_m) {
            return Ok(Row::of_ankles(speed, wanted, mix, own_m));
        }
        let landings = steps.landings(own.sole_m);
        Ok(Row { speed, stride, mix, own, landings })
    }

    /// Returns how a member steps that turns on the spot.
    pub(crate) fn on_the_spot(&mut self) -> Result<Step, Error> {
        let slowest = self.samples[0];
        let own_m = own_stride(&self.strides[0], ON_THE_SPOT);
        let cycles_per_sec = slowest.speed / slowest.stride;
        let steps = self.measure(ON_THE_SPOT)?;
        let own = steps.map(|steps| steps.towards(own_m, cycles_per_sec));
        let own = own.filter(|own| own.is_plausible(own_m));
        let own = own.unwrap_or(MixStride { sole_m: own_m, ankle_m: own_m });
        let (stride_m, ankle_m) = (own.sole_m, own.ankle_m);
        Ok(Step { mix: ON_THE_SPOT, cycles_per_sec, stride_m, ankle_m })
    }

    /// Returns the segment that a speed is in, and the stride in metres that suits it.
    fn stride_at(&self, speed: f32) -> (usize, f32) {
        let samples = self.samples;
        let (slowest, fastest) = (samples[0], samples[samples.len() - 1]);
        let next = samples.partition_point(|sample| sample.speed <= speed);
        let stride = match (next.checked_sub(1), samples.get(next)) {
            (None, _) => {
                let stride = slowest.stride * (speed / slowest.speed).powf(STRIDE_POWER);
                stride.min(speed / (SLOWEST_RATE * slowest.speed / slowest.stride))
            }
            (Some(below), Some(above)) => {
                let below = samples[below];
                let power = (above.stride / below.stride).ln() / (above.speed / below.speed).ln();
                below.stride * (speed / below.speed).powf(power)
            }
            (Some(_), None) => fastest.stride * (speed / fastest.speed).powf(0.5),
        };
        (next.min(samples.len() - 1), stride)
    }

    /// Returns the first mix within a segment whose stride is a length in metres, or the last, and
    /// its stride.
    fn mix_of_stride(&self, segment: usize, stride: f32) -> (f32, f32) {
        let strides = &self.strides[segment];
        let reaches = |above: &usize| strides[*above] >= stride;
        let above = (1..MIXES).find(reaches).unwrap_or(MIXES);
        let (low, high) = (strides[above - 1], strides[above]);
        let part = if high > low { ((stride - low) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
        let part = (above as f32 - 1.0 + part) / MIXES as f32;
        (segment as f32 + part, own_stride(strides, part))
    }
}

impl Row {
    /// Returns a row of a mix whose stride ankles step alone.
    const fn of_ankles(speed: f32, stride: f32, mix: f32, own_m: f32) -> Self {
        let own = MixStride { sole_m: own_m, ankle_m: own_m };
        Self { speed, stride, mix, own, landings: None }
    }
}

/// Returns the stride of a mix a part of the way through a segment, 0 to 1, in metres.
fn own_stride(strides: &[f32; MIXES + 1], part: f32) -> f32 {
    let at = part * MIXES as f32;
    let below = (0..MIXES).rev().find(|below| *below as f32 <= at).unwrap_or(0);
    strides[below] + (strides[below + 1] - strides[below]) * (at - below as f32)
}

/// Returns whether a stride that was measured is near what is expected.
fn is_near(measured: f32, expected: f32) -> bool {
    (NEAR.0 * expected..=NEAR.1 * expected).contains(&measured)
}

impl MixStride {
    /// Returns whether it is near a stride in metres that is expected of the mix.
    fn is_plausible(&self, expected: f32) -> bool {
        is_near(self.sole_m, expected) && is_near(self.ankle_m, self.sole_m)
    }
}
