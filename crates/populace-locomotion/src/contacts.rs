//! Contacts: the times in which a foot stands.

use glam::Vec2;
use populace::model::Side;

use crate::soles::{SoleSample, Soles};

/// Heights above the ground at which a sole begins to stand, as fractions of the body's height: for
/// a clip whose standing soles stay at one height, and for one whose soles bob.
const LOW: (f32, f32) = (0.005, 0.015);
/// Differences from the ground's velocity at which a sole begins to stand, as fractions of the
/// ground's speed: for a clip whose standing soles move with the ground, and for one whose soles
/// slide.
const SLOW: (f32, f32) = (0.2, 0.5);
/// By how much a clip's slide is exceeded at which a sole begins to stand.
const MARGIN: f32 = 3.0;
/// Multiples of these limits at which a standing sole ceases to stand.
const LIFTED: f32 = 2.0;
const ESCAPED: f32 = 1.5;
/// A sole that moves faster than the ground is held to this multiple of the limit: where a foot
/// rolls, a sole of a clip made by hand is often thrice as fast. What tells a standing sole from a
/// swinging one is that it moves back.
const FASTER: f32 = 4.0;
/// A sole whose velocity differs from that of the ground by less than this stands in any case, in
/// body heights per second.
const STILL: f32 = 0.06;
/// Weight of the skewness of velocities against their correlation with height, in telling which
/// way feet swing.
const SKEWNESS: f64 = 0.07;
/// A clip goes forwards or backwards, not aside, if at least this part of its direction is along Z.
const ALONG: f32 = 0.4;
/// The share of the samples of a foot that moves back, from the lowest up, at which it is on the
/// ground: soles dip below the ground as well as above it.
const GROUND: f32 = 0.3;
/// A foot whose ground is this fraction of the body's height above that of the other does not come
/// down.
const HELD_UP: f32 = 0.06;
/// Contacts shorter than this, in seconds, are none.
const SHORTEST_SECS: f32 = 0.04;
/// Gaps shorter than this fraction of the cycle, and than this in seconds, do not end a contact: a
/// foot may stop for an instant as it comes off the ground.
const GAP: (f32, f32) = (0.12, 0.12);
/// Times that contacts and the ground's velocity are found from each other.
const ROUNDS: usize = 4;

/// The time in which a foot stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The foot.
    pub foot: Side,
    /// Seconds after the start of the cycle at which the foot touches down.
    pub from_secs: f32,
    /// Seconds after the start of the cycle at which it lifts off. Beyond the cycle's length if the
    /// foot stands through its end.
    pub until_secs: f32,
}

/// Contacts as samples, and the velocity of the ground beneath the body.
pub(crate) struct Standing {
    pub(crate) ground: Vec2,
    /// Whether each foot stands, sample by sample.
    pub(crate) stands: [Vec<bool>; 2],
}

impl Standing {
    /// Finds the samples in which feet stand. Feet are higher where they swing, so the velocity of
    /// the ground is first the median of low soles that do not move as high ones do. Then it is the
    /// median of soles that stand, and soles are held to what the clip itself keeps to.
    pub(crate) fn find(soles: &Soles) -> Self {
        let still = STILL * soles.body_height_m;
        let forward = forward(soles);
        let back = [0, 1].map(|foot: usize| {
            let samples = soles.feet[foot].iter();
            samples.map(|sample| sample.velocity.dot(forward) <= still).collect::<Vec<_>>()
        });
        let heights = ground_heights(soles, &back);
        let mut limits = Limits { low_m: LOW.1 * soles.body_height_m, slow: SLOW.1, still };
        let low = [0, 1].map(|foot: usize| {
            let samples = soles.feet[foot].iter().zip(&back[foot]);
            samples.map(|(s, back)| *back && s.height <= heights[foot] + limits.low_m).collect()
        });
        let ground = median_velocity(soles, &low).unwrap_or_default();
        let mut standing = Self { ground, stands: low };
        for _ in 0..ROUNDS {
            standing.stands = [0, 1]
                .map(|foot| with_hysteresis(soles, foot, heights[foot], standing.ground, &limits));
            let Some(ground) = median_velocity(soles, &standing.stands) else { break };
            standing.ground = ground;
            limits = standing.limits(soles);
        }
        standing
    }

    /// Returns the limits that suit the clip: what most of its standing soles keep to, and a
    /// margin.
    fn limits(&self, soles: &Soles) -> Limits {
        let both = || [0, 1].into_iter().flat_map(|foot| self.samples(soles, foot));
        let at = |sorted: &[f32], fifths: usize| {
            sorted.get(fifths * sorted.len() / 5).copied().unwrap_or_default()
        };
        let bobs = [0, 1].map(|foot| {
            let heights = sorted(self.samples(soles, foot).map(|sample| sample.height));
            at(&heights, 4) - at(&heights, 1)
        });
        let slides = sorted(both().map(|sample| (sample.velocity - self.ground).length()));
        let speed = self.ground.length().max(f32::MIN_POSITIVE);
        let (low, high) = (LOW.0 * soles.body_height_m, LOW.1 * soles.body_height_m);
        Limits {
            low_m: bobs[0].max(bobs[1]).clamp(low, high.max(low)),
            slow: (MARGIN * at(&slides, 4) / speed).clamp(SLOW.0, SLOW.1),
            still: STILL * soles.body_height_m,
        }
    }

    /// Returns the samples in which a foot stands.
    pub(crate) fn samples<'a>(
        &'a self,
        soles: &'a Soles,
        foot: usize,
    ) -> impl Iterator<Item = &'a SoleSample> {
        standing_samples(soles, &self.stands, foot)
    }

    /// Returns the contacts in order of their beginning.
    pub(crate) fn contacts(&self, duration_secs: f32) -> Vec<Contact> {
        let feet = [Side::Left, Side::Right].into_iter().zip(&self.stands);
        let mut all: Vec<_> = feet
            .flat_map(|(foot, stands)| {
                // By the share of the cycle: one that is full gives exactly its length.
                let secs = move |at: usize| at as f32 / stands.len() as f32 * duration_secs;
                runs(stands).into_iter().map(move |(first, count)| Contact {
                    foot,
                    from_secs: secs(first),
                    until_secs: secs(first + count),
                })
            })
            .collect();
        all.sort_by(|a, b| a.from_secs.total_cmp(&b.from_secs));
        all
    }
}

/// Within what a sole begins to stand.
struct Limits {
    /// Height above the ground, in metres.
    low_m: f32,
    /// Difference from the ground's velocity, as a fraction of its speed.
    slow: f32,
    /// The least such difference, in metres per second.
    still: f32,
}

impl Limits {
    /// Returns whether a sole stands on ground at a height, with the ground's velocity, if it
    /// `stood` before.
    fn hold(&self, sample: &SoleSample, height: f32, ground: Vec2, stood: bool) -> bool {
        let (lifted, escaped) = if stood { (LIFTED, ESCAPED) } else { (1.0, 1.0) };
        let most = (self.slow * ground.length()).max(self.still) * escaped;
        let off = sample.velocity - ground;
        let along = off.dot(ground.normalize_or_zero());
        // On ground that keeps still all of the difference is aside.
        let aside = (off - ground.normalize_or_zero() * along).length();
        sample.height <= height + self.low_m * lifted
            && along >= -most
            && along <= most * FASTER
            && aside <= most
    }
}

/// Returns the direction in which feet swing. If the clip's own skeleton tells which way the clip
/// goes, it is that way: on bodies of other proportions a retargeted foot may hover while it stands
/// and touch the ground while it swings. Otherwise it is that in which feet move where they are
/// high. Where height hardly tells, it is that in which they move fastest. Zero if they keep still.
fn forward(soles: &Soles) -> Vec2 {
    let raised = |samples: &[SoleSample]| {
        let mean = samples.iter().map(|s| s.height).sum::<f32>() / samples.len() as f32;
        samples.iter().map(|s| (s.height - mean, s.velocity)).collect::<Vec<_>>()
    };
    let all = soles.feet.iter().flat_map(|samples| raised(samples)).collect::<Vec<_>>();
    let axis = all.iter().map(|(raised, v)| *v * *raised).sum::<Vec2>().normalize_or_zero();
    let goes = soles.own_speed * axis.y;
    if soles.own_speed.abs() > STILL * soles.body_height_m && axis.y.abs() > ALONG {
        return if goes < 0.0 { -axis } else { axis };
    }
    let (mut heights, mut speeds, mut both, mut cubes) = (0.0, 0.0, 0.0, 0.0);
    for (raised, velocity) in &all {
        let (raised, along) = (f64::from(*raised), f64::from(velocity.dot(axis)));
        heights += raised * raised;
        speeds += along * along;
        both += raised * along;
        cubes += along * along * along;
    }
    let correlation = both / (heights * speeds).sqrt();
    let skewness = cubes * (all.len() as f64).sqrt() / (speeds * speeds.sqrt());
    if correlation + SKEWNESS * skewness < 0.0 { -axis } else { axis }
}

/// Returns the heights at which the two feet stand, each its own: a clip may stand on a step.
fn ground_heights(soles: &Soles, back: &[Vec<bool>; 2]) -> [f32; 2] {
    let own = [0, 1].map(|foot| {
        let heights = sorted(standing_samples(soles, back, foot).map(|sample| sample.height));
        let nth = (0..heights.len()).find(|nth| *nth as f32 >= heights.len() as f32 * GROUND);
        nth.map(|nth| heights[nth])
    });
    let lower = own.iter().flatten().copied().fold(f32::INFINITY, f32::min);
    let comes_down = |height: &f32| *height <= lower + HELD_UP * soles.body_height_m;
    own.map(|height| height.filter(comes_down).unwrap_or(lower))
}

fn sorted(values: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut all: Vec<f32> = values.collect();
    all.sort_by(f32::total_cmp);
    all
}

fn standing_samples<'a>(
    soles: &'a Soles,
    stands: &'a [Vec<bool>; 2],
    foot: usize,
) -> impl Iterator<Item = &'a SoleSample> {
    let both = soles.feet[foot].iter().zip(&stands[foot]);
    both.filter(|(_, stands)| **stands).map(|(sample, _)| sample)
}

/// Returns the component-wise median of the velocities of standing soles; `None` if none stands.
fn median_velocity(soles: &Soles, stands: &[Vec<bool>; 2]) -> Option<Vec2> {
    let of = |component: fn(&SoleSample) -> f32| {
        let standing = [0, 1].into_iter().flat_map(|foot| standing_samples(soles, stands, foot));
        let all = sorted(standing.map(component));
        all.get(all.len() / 2).copied()
    };
    Some(Vec2::new(of(|sample| sample.velocity.x)?, of(|sample| sample.velocity.y)?))
}

/// Returns whether a foot stands, sample by sample, on ground at a height.
fn with_hysteresis(
    soles: &Soles,
    foot: usize,
    height: f32,
    ground: Vec2,
    limits: &Limits,
) -> Vec<bool> {
    let samples = &soles.feet[foot];
    let mut stands = false;
    let mut all = vec![false; samples.len()];
    // Twice around, so that the state at the start is that at the end of the cycle.
    for _ in 0..2 {
        for (sample, now) in samples.iter().zip(&mut all) {
            stands = limits.hold(sample, height, ground, stands);
            *now = stands;
        }
    }
    let step_secs = soles.duration_secs / samples.len() as f32;
    let gap_secs = GAP.1.min(GAP.0 * soles.duration_secs);
    for (filled, shortest_secs) in [(true, gap_secs), (false, SHORTEST_SECS)] {
        let gaps: Vec<bool> = all.iter().map(|stands| *stands != filled).collect();
        let short = |(_, count): &(usize, usize)| (*count as f32) * step_secs < shortest_secs;
        for (first, count) in runs(&gaps).into_iter().filter(short) {
            (first..first + count).for_each(|at| all[at % samples.len()] = filled);
        }
    }
    all
}

/// Returns the runs of `true` in a cycle as first element and count. A run through the end of the
/// cycle goes on at its start.
fn runs(cycle: &[bool]) -> Vec<(usize, usize)> {
    let count = cycle.len();
    if cycle.iter().all(|set| *set) {
        return vec![(0, count)];
    }
    let starts = (0..count).filter(|at| cycle[*at] && !cycle[(at + count - 1) % count]);
    let length = |first: usize| (0..count).take_while(|n| cycle[(first + n) % count]).count();
    starts.map(|first| (first, length(first))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_go_on_through_the_end_of_the_cycle() {
        let cycle = [true, true, false, true, false, false, true];
        assert_eq!(runs(&cycle), [(3, 1), (6, 3)]);
        assert_eq!(runs(&[true; 4]), [(0, 4)]);
        assert!(runs(&[false; 4]).is_empty());
    }
}
