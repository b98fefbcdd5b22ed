//! Constraints of other walkers on a velocity: section 4 of the paper, for the most urgent
//! neighbours.

use glam::Vec2;

use super::Body;
use super::geometry::{parting, root};
use super::grid::{Grid, Seen};
use super::linear::HalfPlane;

/// The most neighbours that one walker heeds.
pub(crate) const MOST_NEIGHBOURS: usize = 16;
/// Distance in metres, beyond touching, at which a passing neighbour counts as one to collide with.
const COMFORT_M: f32 = 0.2;
/// Speed in metres per second that turns gaps into seconds, to compare them with times to
/// collision: how fast anybody near may come nearer.
const APPROACH_M_PER_SEC: f32 = 1.3;
/// The fastest that walkers who overlap move apart, in metres per second.
const MOST_PARTING: f32 = 2.0;
/// Seconds in which walkers who overlap move apart.
const PARTING_SECS: f32 = 0.15;
/// The least and the largest share of a walker who overlaps another one.
const PARTING_SHARES: (f32, f32) = (0.2, 0.8);
/// The depth of an overlap, in metres, beyond which neighbours weigh no more.
const DEEPEST_M: f32 = 0.15;

/// The neighbours of one walker.
pub(crate) struct Neighbours<'a> {
    all: [Option<&'a Seen>; MOST_NEIGHBOURS],
    /// How many walkers in sight come towards this one.
    pub(crate) oncoming: f32,
}

impl<'a> Neighbours<'a> {
    /// Chooses the neighbours in sight that a walker would meet soonest: by the time to a
    /// collision, or by the gap between them if that is shorter. They are in order of distance, and
    /// of indices at the same distance.
    ///
    /// The first grid has the walkers, the second the bystanders.
    pub(crate) fn choose(
        grids: [&'a Grid; 2],
        body: &Body,
        (distance, most): (f32, usize),
        hidden: impl Fn(Vec2) -> bool,
    ) -> Self {
        let mut nearest = Ranking { all: [Ranked::LAST; MOST_NEIGHBOURS], most };
        let mut soonest = Ranking { all: [Ranked::LAST; MOST_NEIGHBOURS], most };
        let mut oncoming = 0.0;
        let [walkers, bystanders] = grids;
        let largest = walkers.largest_radius().max(bystanders.largest_radius());
        let widest = body.radius + largest + COMFORT_M;
        let fastest = (body.velocity.length() + walkers.highest_speed()).max(APPROACH_M_PER_SEC);
        // Beyond this distance nobody is more urgent than those who are chosen.
        let mut square_limit = distance * distance;
        let mut see = |nth: usize, place: u32, other: &Seen| {
            let square = other.position.distance_squared(body.position);
            if square > distance * distance || other.index == body.index {
                return;
            }
            if is_oncoming(body, other) && !hidden(other.position) {
                oncoming += 1.0;
            }
            if square <= square_limit {
                let key = urgency(body, other, square);
                let ranked = Ranked { key, index: other.index, place, nth };
                if soonest.takes(&ranked) && !hidden(other.position) {
                    soonest.insert(ranked);
                    let limit = widest + 1.01 * fastest * soonest.all[most - 1].key;
                    square_limit = square_limit.min(limit * limit);
                }
            }
        };
        for (nth, grid) in grids.into_iter().enumerate() {
            grid.around(body.position, distance, |place, other| see(nth, place, other));
        }
        let seen = |ranked: &Ranked| &grids[ranked.nth].walkers()[ranked.place as usize];
        for ranked in soonest.iter() {
            let other = seen(ranked);
            let key = other.position.distance_squared(body.position);
            nearest.insert(Ranked { key, ..*ranked });
        }
        let mut all = [None; MOST_NEIGHBOURS];
        for (other, ranked) in all.iter_mut().zip(nearest.iter()) {
            *other = Some(seen(ranked));
        }
        Self { all, oncoming }
    }

    /// The neighbours, nearest first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &'a Seen> {
        self.all.iter().map_while(|other| *other)
    }
}

/// A neighbour by a key, and by index for equal keys.
#[derive(Clone, Copy)]
struct Ranked {
    key: f32,
    index: u32,
    /// Where it is in its grid, and which grid that is.
    place: u32,
    nth: usize,
}

impl Ranked {
    const LAST: Self = Self { key: f32::INFINITY, index: u32::MAX, place: 0, nth: 0 };

    fn is_before(&self, other: &Self) -> bool {
        self.key < other.key || (self.key == other.key && self.index < other.index)
    }
}

/// The neighbours with the least keys, in order.
struct Ranking {
    all: [Ranked; MOST_NEIGHBOURS],
    most: usize,
}

impl Ranking {
    /// Returns whether a neighbour is among the first.
    fn takes(&self, new: &Ranked) -> bool {
        new.is_before(&self.all[self.most - 1])
    }

    /// Takes a neighbour if it is among the first.
    fn insert(&mut self, new: Ranked) {
        let all = &mut self.all[..self.most];
        let mut at = all.len();
        while at > 0 && new.is_before(&all[at - 1]) {
            if at < all.len() {
                all[at] = all[at - 1];
            }
            at -= 1;
        }
        if at < all.len() {
            all[at] = new;
        }
    }

    fn iter(&self) -> impl Iterator<Item = &Ranked> {
        self.all[..self.most].iter().take_while(|ranked| ranked.index != u32::MAX)
    }
}

/// Returns whether another walker comes towards this one and is not clearly to its left.
fn is_oncoming(body: &Body, other: &Seen) -> bool {
    let apart = other.position - body.position;
    other.ahead.dot(body.ahead) < -0.5
        && apart.dot(body.ahead) > 0.0
        && apart.dot(body.ahead.perp()) > -CLEAR_M
}

/// Returns the seconds until a neighbour at the root of `square` matters.
fn urgency(body: &Body, other: &Seen, square: f32) -> f32 {
    let apart = other.position - body.position;
    let reach = body.radius + other.radius;
    let gap_secs = (root(square) - reach).max(0.0) / APPROACH_M_PER_SEC;
    let closing = body.velocity - other.velocity;
    let rate = closing.dot(apart);
    if rate <= 0.0 {
        return gap_secs;
    }
    let wide = reach + COMFORT_M;
    let speed = closing.length_squared();
    let hits = rate * rate - speed * (square - wide * wide);
    if hits <= 0.0 { gap_secs } else { gap_secs.min(((rate - root(hits)) / speed).max(0.0)) }
}

/// The gap in metres at which a neighbour weighs half of one that is touched, where not all can be
/// avoided.
const NEAR_M: f32 = 0.2;

/// The distance sideways, in metres, at which somebody oncoming is past.
const CLEAR_M: f32 = 1.0;

/// How a walker avoids one other disc.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Manner {
    /// Seconds without a collision.
    pub(crate) horizon_secs: f32,
    /// The part of the change of velocity that this walker makes, 0 to 1.
    pub(crate) share: f32,
    /// Preference for the right, in metres per second of sideways velocity.
    pub(crate) side_bias: f32,
    /// The gap that both like to keep, in metres.
    pub(crate) comfort_m: f32,
}

/// Returns the velocities of a walker that avoid another disc, if the other one makes its part of
/// the change.
pub(crate) fn half_plane(body: &Body, other: &Seen, manner: Manner) -> HalfPlane {
    let apart = other.position - body.position;
    let distance = apart.length();
    let touch = body.radius + other.radius;
    // The comfortable gap gives way: those who are nearer do not move apart, but come no nearer.
    let reach = distance.clamp(touch, touch + manner.comfort_m);
    let closing = body.velocity - other.velocity;
    let (normal, change) = change(apart, closing, reach, manner, (body.index, other.index));
    let overlaps = distance < touch;
    let (least, most) = if overlaps { PARTING_SHARES } else { (0.0, 1.0) };
    let share = manner.share.clamp(least, most);
    HalfPlane {
        normal,
        offset: normal.dot(body.velocity) + share * change,
        weight: 1.0 / (NEAR_M + (distance - touch).max(-DEEPEST_M)),
    }
}

/// Returns the normal of the boundary of the velocity obstacle where it is nearest to a velocity,
/// and the way there: positive from inside.
fn change(
    apart: Vec2,
    closing: Vec2,
    reach: f32,
    manner: Manner,
    (own, other): (u32, u32),
) -> (Vec2, f32) {
    let square = apart.length_squared();
    let distance = root(square);
    let ahead = if distance > 1e-4 { apart / distance } else { parting(own, other) };
    if distance <= reach {
        let parting = ((reach - distance) / PARTING_SECS).min(MOST_PARTING);
        return (-ahead, parting + closing.dot(ahead));
    }
    // Two who meet head on pass each other on the right, as both take the same side.
    let sideways = if closing.dot(apart) > 0.0 { manner.side_bias } else { 0.0 };
    let from_disc = closing - apart / manner.horizon_secs;
    let leaning = from_disc + ahead.perp() * sideways;
    let back = leaning.dot(apart);
    if back < 0.0 && back * back > reach * reach * leaning.length_squared() {
        let normal = leaning.normalize_or(-ahead);
        return (normal, reach / manner.horizon_secs - from_disc.dot(normal));
    }
    let side = if leaning.perp_dot(ahead) <= 0.0 { ahead.perp() } else { -ahead.perp() };
    let normal = (side * root(square - reach * reach) - ahead * reach) / distance;
    (normal, -closing.dot(normal))
}
