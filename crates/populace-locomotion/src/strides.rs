//! How far mixes of clips step, in the contacts of their clips.

use populace::model::Side;

use crate::feet::Leg;
use crate::footing::Landing;
use crate::soles::{SoleSample, Treadmill};
use crate::{Error, Gait, MixedClip};

/// Times within a contact count up to this, in seconds, when those of several clips are mixed.
const WITHIN_SECS: f32 = 0.12;
/// A foot that this share of a cycle stands does not lift.
const WHOLE: f32 = 0.999;
/// Clips of less than this share of the weight do not make a standing foot step.
const STEPPING: f32 = 0.02;
/// The least and the largest lead of ankles.
const LEADS: (f32, f32) = (0.0, 6.0);
/// A lead this near to 1 is that of the mix itself.
const NEAR_OWN: f32 = 0.1;
/// How far along the ground legs reach, and how far planted feet are held back, in leg lengths: a
/// little less than where devices let a foot go.
const REACH: f32 = 0.63;
const HELD_BACK: f32 = 0.45;
/// Speeds are measured from frame to frame, at this many in a second.
const SHOWN_PER_SEC: f32 = 60.0;
/// Times between two samples at which movements begin.
const FINER: f32 = 4.0;
/// Halvings in the search for a lead, and for a stride within reach.
const HALVINGS: usize = 14;
const REACH_HALVINGS: usize = 7;

/// Contacts of one foot, mixed by the weights of the clips.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planting {
    within: f32,
    steps: f32,
    stands: f32,
}

impl Planting {
    /// Adds a clip at seconds after the start of its cycle.
    pub(crate) fn add(&mut self, gait: &Gait, foot: Side, secs: f32, weight: f32) {
        let own = || gait.contacts.iter().filter(|contact| contact.foot == foot);
        let lasts = |from: f32, until: f32| until - from;
        let cycle = gait.duration_secs;
        if own().any(|c| lasts(c.from_secs, c.until_secs) >= WHOLE * cycle) {
            self.stands += weight;
            return;
        }
        // From the nearest end of a contact: positive within one.
        let within = own().map(|c| {
            let away = (secs - 0.5 * (c.from_secs + c.until_secs)).abs();
            let away = if away > 0.5 * cycle { (cycle - away).abs() } else { away };
            0.5 * lasts(c.from_secs, c.until_secs) - away
        });
        self.within += weight * within.fold(-WITHIN_SECS, f32::max).min(WITHIN_SECS);
        self.steps += weight;
    }

    /// Returns whether the foot is planted, as devices decide it.
    pub(crate) fn is_planted(self) -> bool {
        self.margin() > 0.0
    }

    /// Returns how far within a contact the foot is: above 0 if it is planted.
    fn margin(self) -> f32 {
        if self.steps <= STEPPING * (self.steps + self.stands) { 1.0 } else { self.within }
    }
}

/// How a mix of clips steps, measured on a body.
pub(crate) struct MixSteps {
    feet: [Stance; 2],
}

/// How far a mix steps forwards in a cycle, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MixStride {
    /// By the median velocity of planted soles.
    pub(crate) sole_m: f32,
    /// Metres that the stride gains when the steps of ankles are doubled and the roll of feet is
    /// not.
    pub(crate) ankle_m: f32,
}

impl MixSteps {
    /// Measures clips that are mixed, each with its gait. `None` if no foot is planted.
    pub(crate) fn measure(
        treadmill: &mut Treadmill,
        clips: &[(MixedClip, &Gait)],
    ) -> Result<Option<Self>, Error> {
        let mixed: Vec<_> = clips.iter().map(|(clip, _)| clip.clone()).collect();
        let Some(soles) = treadmill.sample(&mixed)? else { return Ok(None) };
        let legs = soles.legs;
        let ([left, right], [of_left, of_right]) = (soles.feet, soles.middles_z);
        let stance = |side, samples: Vec<SoleSample>, middles_z, leg| {
            let count = samples.len() as f32;
            let within = |at: f32| {
                let mut planting = Planting::default();
                for (mixed, gait) in clips {
                    let phase = (at / count + mixed.offset).rem_euclid(1.0);
                    planting.add(gait, side, phase * gait.duration_secs, mixed.weight);
                }
                planting.margin()
            };
            let at = (0_u16..).map(f32::from).take(samples.len());
            Stance { within: at.map(within).collect(), samples, middles_z, leg }
        };
        let feet = [
            stance(Side::Left, left, of_left, legs[0]),
            stance(Side::Right, right, of_right, legs[1]),
        ];
        let stands = feet.iter().any(|foot| foot.within.iter().any(|within| *within > 0.0));
        Ok(stands.then_some(Self { feet }))
    }

    /// Returns how both feet touch down while the mix goes on by its stride in metres. `None` for a
    /// body without legs, and for a foot that does not lift or does not step.
    pub(crate) fn landings(&self, stride_m: f32) -> Option<[Landing; 2]> {
        let [left, right] = self.feet.each_ref().map(|foot| foot.landing(stride_m));
        Some([left?, right?])
    }

    /// Returns the stride in metres with steps of ankles led, at cycles in a second: by the median
    /// movement of the lowest points of planted soles from one frame to the next.
    pub(crate) fn stride_m(&self, lead: f32, cycles_per_sec: f32) -> f32 {
        self.planted(cycles_per_sec).stride_m(lead)
    }

    /// Returns the movements of planted soles between frames, at cycles in a second.
    fn planted(&self, cycles_per_sec: f32) -> Planted {
        let count = self.feet[0].samples.len() as f32;
        let step = (count * cycles_per_sec / SHOWN_PER_SEC).clamp(1.0, (0.1 * count).max(1.0));
        let moves = self.feet.iter().flat_map(|foot| foot.moves(step)).collect();
        Planted { count, step, moves }
    }

    /// Returns the lead of ankles at which the stride has a length.
    fn lead_of(&self, stride_m: f32, cycles_per_sec: f32) -> f32 {
        let planted = self.planted(cycles_per_sec);
        let (mut low, mut high) = LEADS;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let is_short = planted.stride_m(middle) < stride_m;
            (low, high) = if is_short { (middle, high) } else { (low, middle) };
        }
        0.5 * (low + high)
    }

    /// Returns the longest stride up to `most_m` at a speed, in metres per second, in which legs
    /// reach the feet that are planted; not less than `least_m`.
    pub(crate) fn within_reach(&self, least_m: f32, most_m: f32, speed: f32) -> f32 {
        let reaches = |stride_m: f32| {
            let lead = self.lead_of(stride_m, speed / stride_m);
            self.feet.iter().all(|foot| foot.reaches(lead, stride_m))
        };
        if reaches(most_m) {
            return most_m;
        }
        let (mut low, mut high) = (least_m, most_m);
        for _ in 0..REACH_HALVINGS {
            let middle = 0.5 * (low + high);
            (low, high) = if reaches(middle) { (middle, high) } else { (low, middle) };
        }
        low
    }

    /// Returns the mix's own stride at cycles in a second, and what a lead of ankles adds to it on
    /// the way to a stride in metres.
    pub(crate) fn towards(&self, stride_m: f32, cycles_per_sec: f32) -> MixStride {
        let sole_m = self.stride_m(1.0, cycles_per_sec);
        let lead = self.lead_of(stride_m, cycles_per_sec);
        // Near the mix's own stride by how it grows there.
        let (lead, stride_m) = if (lead - 1.0).abs() >= NEAR_OWN {
            (lead, stride_m)
        } else {
            let lead = if lead < 1.0 { 1.0 - NEAR_OWN } else { 1.0 + NEAR_OWN };
            (lead, self.stride_m(lead, cycles_per_sec))
        };
        MixStride { sole_m, ankle_m: (stride_m - sole_m) / (lead - 1.0) }
    }
}

/// Movements of planted soles from one frame to the next.
struct Planted {
    /// Samples in a cycle, and from one frame to the next.
    count: f32,
    step: f32,
    moves: Vec<Move>,
}

impl Planted {
    /// Returns the median stride in metres with steps of ankles led.
    fn stride_m(&self, lead: f32) -> f32 {
        let mut steps: Vec<f32> = self.moves.iter().map(|of| of.moved_m(lead)).collect();
        if steps.is_empty() {
            return 0.0;
        }
        let middle = steps.len() / 2;
        let (_, moved, _) = steps.select_nth_unstable_by(middle, f32::total_cmp);
        -*moved / self.step * self.count
    }
}

/// A movement of a point of the sole between two times.
struct Move {
    from: Between,
    to: Between,
}

impl Move {
    /// Returns how far the point moves forwards, in metres.
    fn moved_m(&self, lead: f32) -> f32 {
        self.to.place(lead) - self.from.place(lead)
    }
}

/// A place along Z between two samples.
struct Between {
    /// The point of the sole and the ankle at the sample before and at that after, in metres.
    points: [[f32; 2]; 2],
    /// The part of the way from one to the other.
    part: f32,
}

impl Between {
    fn place(&self, lead: f32) -> f32 {
        let [low, high] = self.points.map(|[point, ankle]| point + ankle * (lead - 1.0));
        low + (high - low) * self.part
    }
}

/// Samples of a foot over a cycle, and its contacts.
struct Stance {
    samples: Vec<SoleSample>,
    /// How far within a contact each sample is: above 0 if the foot is planted.
    within: Vec<f32>,
    /// See [`Soles::middles_z`](crate::soles::Soles::middles_z).
    middles_z: Vec<f32>,
    leg: Option<Leg>,
}

impl Stance {
    /// Returns the samples before and after a time in samples, and the part of the way from one to
    /// the other.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 8000")]
    fn around(&self, time: f32) -> ([usize; 2], f32) {
        let (nth, part) = (time as usize, time - time.floor());
        ([nth, nth + 1].map(|nth| nth % self.samples.len()), part)
    }

    /// Returns whether the foot is planted at a time in samples.
    fn is_planted(&self, time: f32) -> bool {
        let (around, part) = self.around(time);
        let [low, high] = around.map(|nth| self.within[nth]);
        low + (high - low) * part > 0.0
    }

    /// Returns where a point of the sole is at a time in samples.
    fn place(&self, point: usize, time: f32) -> Between {
        let (around, part) = self.around(time);
        let points = around.map(|nth| {
            let SoleSample { ankle, points_z, .. } = &self.samples[nth];
            [points_z[point], ankle.y]
        });
        Between { points, part }
    }

    /// Returns the movement of a point of the sole between two times in samples.
    fn between(&self, point: usize, [from, to]: [f32; 2]) -> Move {
        Move { from: self.place(point, from), to: self.place(point, to) }
    }

    /// Returns the movements of planted soles from one time to another, a number of samples later:
    /// at [`FINER`] times for each sample.
    fn moves(&self, step: f32) -> impl Iterator<Item = Move> {
        let times =
            (0_u16..).map(|nth| f32::from(nth) / FINER).map(move |from| [from, from + step]);
        let count = self.samples.len() as f32;
        let times = times.take_while(move |[from, _]| *from < count);
        let planted = times.filter(|times| times.iter().all(|time| self.is_planted(*time)));
        planted.map(|times| {
            let ([before, _], _) = self.around(times[0]);
            self.between(self.samples[before].lowest, times)
        })
    }

    /// Returns how the foot touches down in its longest contact.
    fn landing(&self, stride_m: f32) -> Option<Landing> {
        let (leg, count) = (self.leg?, self.samples.len());
        let planted = |nth: usize| self.within[nth % count] > 0.0;
        let downs = (0..count).filter(|nth| planted(*nth) && !planted(nth + count - 1));
        let stands = |down: usize| (down..down + count).take_while(|nth| planted(*nth)).count();
        let (down, stands) = downs.map(|down| (down, stands(down))).max_by_key(|(_, n)| *n)?;
        let SoleSample { ankle, points_z, lowest, .. } = &self.samples[down];
        let ahead_m = points_z[*lowest] + self.middles_z[*lowest];
        let until_lift = stands as f32 / count as f32;
        let until_over = (ahead_m / stride_m).clamp(0.0, until_lift);
        let over = (down as f32 / count as f32 + until_over).rem_euclid(1.0);
        let stepped_m = ankle.y - leg.middle_z;
        let half_m = self.middles_z.iter().copied().fold(0.0, f32::max);
        let aside_m = ankle.x;
        let landing = Landing { over, until_over, until_lift, ahead_m, stepped_m, aside_m, half_m };
        landing.steps().then_some(landing)
    }

    /// Returns whether the leg reaches a foot that is locked to the ground from the beginning to
    /// the end of its contacts, while the body goes on by a stride in each cycle.
    fn reaches(&self, lead: f32, stride_m: f32) -> bool {
        let Some(leg) = self.leg else { return true };
        let count = self.samples.len();
        let step_m = stride_m / count as f32;
        let mut lag = 0.0_f32;
        // Twice around: a contact may go on through the end of the cycle.
        (0..2 * count).all(|nth| {
            if self.within[nth % count] <= 0.0 {
                lag = 0.0;
                return true;
            }
            let SoleSample { ankle, hip, lowest, .. } = &self.samples[nth % count];
            let own = leg.middle_z + (ankle.y - leg.middle_z) * lead - hip.y;
            let far = (own + lag).abs();
            let overstretched = far > own.abs() && far > REACH * leg.length_m;
            let held_back = lag.abs();
            let now = (nth % count) as f32;
            lag -= step_m + self.between(*lowest, [now, now + 1.0]).moved_m(lead);
            !overstretched && held_back <= HELD_BACK * leg.length_m
        })
    }
}
