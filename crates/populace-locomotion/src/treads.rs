//! Footholds on treads: a step that would end on an edge is made longer or shorter.

use glam::Vec2;
use populace::Ground;

use crate::footing::Landing;

/// Distance between the points at which the ground under a sole is looked at, in metres.
const FINE_M: f32 = 0.025;
/// Slope of the ground from which it is the riser of a step.
const RISER: f32 = 1.0;
/// The farthest that a foothold is moved, in half lengths of the sole.
const MOST: f32 = 1.0;
/// The least distance from the middle of a sole to a riser, in metres, also for small feet: a foot
/// in the air rises for a riser that is near.
const LEAST_M: f32 = 0.12;
/// The longest step, in half lengths of the sole.
const STEP: f32 = 6.0;
/// The least difference of two treads in height, in metres.
const RISE_M: f32 = 0.05;
/// The least distance from the end that carries a sole to a riser, if the sole is longer than a
/// tread, in metres.
const END_M: f32 = 0.05;
/// The most points under half a sole.
const MOST_POINTS: f32 = 40.0;

/// The places where feet stand.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Footholds {
    /// The foot in the air, which will stand at its place.
    swings: Option<usize>,
    /// The middle of each sole, `[x, z]` in metres.
    middles: [Option<Vec2>; 2],
}

/// A body that walks over the ground, at the end of a frame.
pub(crate) struct Gait<'a> {
    pub(crate) ground: &'a Ground,
    pub(crate) position: Vec2,
    pub(crate) velocity: Vec2,
    /// The direction of the heading.
    pub(crate) ahead: Vec2,
    pub(crate) scale: f32,
    /// The phase of its cycle, and cycles in a second.
    pub(crate) phase: f32,
    pub(crate) cycles_per_sec: f32,
    /// Where its steps lead: see [`Stride::lead`](populace::Stride::lead).
    pub(crate) lead: [f32; 2],
}

impl Gait<'_> {
    /// Chooses where the foot in the air will stand, or keeps to the choice of the frame before.
    /// Returns what the lead of ankles ahead gains for it.
    pub(crate) fn step_onto(&self, landings: &[Landing; 2], footholds: &mut Footholds) -> f32 {
        let in_the_air = landings.iter().enumerate().filter_map(|(foot, landing)| {
            Some((landing.in_the_air(self.phase)? - landing.until_over, foot, landing))
        });
        let Some((until, foot, landing)) = in_the_air.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            footholds.swings = None;
            return 0.0;
        };
        let secs = until / self.cycles_per_sec;
        let [aside, along] = self.lead;
        let aside = landing.aside_m + landing.stepped_m * aside;
        let along = landing.ahead_m + landing.stepped_m * (along - 1.0);
        let side = Vec2::new(self.ahead.y, -self.ahead.x);
        let body = self.position + self.velocity * secs;
        let usual = body + (self.ahead * along + side * aside) * self.scale;
        let half_m = (landing.half_m * self.scale).max(LEAST_M);
        let most = MOST * half_m;
        let near = |other: &Vec2, most: f32| (*other - usual).length_squared() <= most * most;
        let kept = footholds.middles[foot]
            .filter(|kept| footholds.swings == Some(foot) && near(kept, 1.5 * most));
        let middle = kept.unwrap_or_else(|| {
            let other = footholds.middles[1 - foot].filter(|other| near(other, STEP * half_m));
            let sole = |middle| Sole::new(self.ground, middle, self.ahead, half_m);
            let taken = other.map(|other| sole(other).height_m(0.0));
            usual + self.ahead * sole(usual).shift_to_tread(taken)
        });
        *footholds = Footholds { swings: Some(foot), ..*footholds };
        footholds.middles[foot] = Some(middle);
        let shift = (middle - usual).dot(self.ahead) / self.scale;
        // The first half of its way the foot is behind the body, where a longer lead would hold it
        // back.
        let goes = until < 0.5 * landing.swing();
        if goes { shift / landing.stepped_m } else { 0.0 }
    }
}

/// A sole that lies level, and points of the ground along its middle line.
#[derive(Clone, Copy)]
struct Sole<'a> {
    ground: &'a Ground,
    middle: Vec2,
    ahead: Vec2,
    /// Points from its middle to either end, and metres between two of them.
    count: f32,
    spacing_m: f32,
}

impl<'a> Sole<'a> {
    fn new(ground: &'a Ground, middle: Vec2, ahead: Vec2, half_m: f32) -> Self {
        let count = (half_m / FINE_M).ceil().clamp(1.0, MOST_POINTS);
        Self { ground, middle, ahead, count, spacing_m: half_m / count }
    }

    /// Returns the height of the ground a number of points ahead of the middle, in metres.
    fn at(&self, nth: f32) -> f32 {
        let at = self.middle + self.ahead * (nth * self.spacing_m);
        self.ground.height_at(at.x, at.y)
    }

    /// Returns whether a riser leads up from one point to its neighbour.
    fn rises(&self, from: f32, to: f32) -> bool {
        self.at(to) - self.at(from) > RISER * self.spacing_m
    }

    /// Returns the height on which it stands after a shift by a number of points, in metres.
    fn height_m(&self, shift: f32) -> f32 {
        let ahead = (0_u16..).map(f32::from).take_while(|nth| *nth <= self.count);
        let points = ahead.flat_map(|nth| [self.at(shift + nth), self.at(shift - nth)]);
        points.fold(f32::NEG_INFINITY, f32::max)
    }

    /// Returns the least way ahead, in metres, after which the sole stands on one tread; 0 if it
    /// does so already, or if none is near. Its heel or its toes may be over a lower tread. A tread
    /// of another height than the one that the other foot has `taken` is better: each foot has its
    /// own. A sole that is longer than a tread stands on the one that its higher end is on.
    fn shift_to_tread(&self, taken: Option<f32>) -> f32 {
        let by_middle = self.shifts(|shift| self.is_on_tread(shift));
        let both = if by_middle.is_empty() {
            self.shifts(|shift| self.ends_on_tread(shift))
        } else {
            by_middle
        };
        let free = |shift: &&f32| {
            taken.is_none_or(|taken| (self.height_m(**shift) - taken).abs() > RISE_M)
        };
        let least = both.iter().find(free).or(both.first());
        least.map_or(0.0, |shift| shift * self.spacing_m)
    }

    /// Returns the shifts that fit, the least ones first.
    fn shifts(&self, fits: impl Fn(f32) -> bool) -> Vec<f32> {
        let all = (0_u16..).map(f32::from).take_while(|nth| *nth <= MOST * self.count);
        all.flat_map(|nth| [nth, -nth]).filter(|shift| fits(*shift)).collect()
    }

    /// Returns whether no riser leads up from the middle to either end, nor to the middle.
    fn is_on_tread(&self, shift: f32) -> bool {
        let points = || (0_u16..).map(f32::from).take_while(|nth| *nth < self.count);
        let outwards = |side: f32| {
            let mut pairs = points().map(|nth| [shift + side * nth, shift + side * (nth + 1.0)]);
            pairs.any(|[from, to]| self.rises(from, to))
        };
        let on_riser = [shift - 1.0, shift + 1.0].iter().any(|next| self.rises(*next, shift));
        !on_riser && !outwards(1.0) && !outwards(-1.0)
    }

    /// Returns whether the higher end carries the sole, away from risers.
    fn ends_on_tread(&self, shift: f32) -> bool {
        let ends = [shift - self.count, shift + self.count];
        let [back, front] = ends.map(|end| self.at(end));
        let end = if front > back { ends[1] } else { ends[0] };
        let away = (END_M / self.spacing_m).ceil();
        let near = (0_u16..).map(f32::from).take_while(|nth| *nth < away);
        let is_level = |from: f32, to: f32| !self.rises(from, to) && !self.rises(to, from);
        near.flat_map(|nth| [[nth, nth + 1.0], [-nth, -nth - 1.0]])
            .all(|[from, to]| is_level(end + from, end + to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Treads of 30 cm with a rise of 15 cm; risers take 5 cm.
    fn stairs() -> Ground {
        let height = |row: u16| 0.15 * ((0.05 * f32::from(row) - 1.0) / 0.3).ceil().max(0.0);
        let heights = (0..200).flat_map(|row| [height(row); 2]).collect();
        Ground::height_field([-10.0, 0.0], 0.05, 2, heights).unwrap()
    }

    #[test]
    fn soles_come_to_stand_on_one_tread() {
        let ground = stairs();
        for nth in 0..60_u8 {
            let z = 2.0 + 0.01 * f32::from(nth);
            for ahead in [Vec2::Y, -Vec2::Y] {
                let sole = Sole::new(&ground, Vec2::new(0.0, z), ahead, 0.13);
                let shift = sole.shift_to_tread(None);
                assert!(shift.abs() <= 0.11, "{shift} at {z}");
                let middle = z + shift * ahead.y;
                let own = ground.height_at(0.0, middle);
                let ends = [-0.13, 0.13].map(|end| ground.height_at(0.0, middle + end));
                assert!(ends.iter().all(|end| *end <= own + 0.02), "{own} {ends:?} at {z}");
            }
        }
    }

    #[test]
    fn soles_stay_on_slopes_and_where_no_tread_is() {
        let slope = Ground::height_field([0.0; 2], 1.0, 2, vec![0.0, 0.0, 0.5, 0.5]).unwrap();
        let sole = Sole::new(&slope, Vec2::new(0.5, 0.5), Vec2::Y, 0.13);
        assert!(sole.shift_to_tread(None) == 0.0);
        // Risers are everywhere on treads of 5 cm.
        let heights = (0..100_u16).flat_map(|row| [0.1 * f32::from(row); 2]).collect();
        let steep = Ground::height_field([-10.0, 0.0], 0.05, 2, heights).unwrap();
        let sole = Sole::new(&steep, Vec2::new(0.0, 2.0), Vec2::Y, 0.4);
        assert!(sole.shift_to_tread(None) == 0.0);
    }

    #[test]
    fn soles_that_are_longer_than_a_tread_stand_on_that_of_their_higher_end() {
        let ground = stairs();
        for nth in 0..60_u8 {
            let z = 4.0 + 0.01 * f32::from(nth);
            for ahead in [Vec2::Y, -Vec2::Y] {
                let sole = Sole::new(&ground, Vec2::new(0.0, z), ahead, 0.48);
                let shift = sole.shift_to_tread(None);
                assert!(shift.abs() <= 0.31, "{shift} at {z}");
                // The end uphill, and 4 cm on both sides of it.
                let end = z + shift * ahead.y + 0.48;
                let [own, near, far] =
                    [0.0, -0.04, 0.04].map(|off| ground.height_at(0.0, end + off));
                assert!((near - own).abs().max((far - own).abs()) < 0.02, "{own} {near} {far}");
                assert!((sole.height_m(shift / sole.spacing_m) - own).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn each_foot_has_a_tread_of_its_own() {
        let ground = stairs();
        // The tread ends at 2.2, and the next one begins at 2.25.
        let sole = Sole::new(&ground, Vec2::new(0.0, 2.15), Vec2::Y, 0.13);
        let shift = |taken| sole.shift_to_tread(taken);
        let own = ground.height_at(0.0, 2.15 + shift(None));
        let other = ground.height_at(0.0, 2.15 + shift(Some(own)));
        assert!((other - own).abs() > 0.1, "{own} {other}");
    }
}
