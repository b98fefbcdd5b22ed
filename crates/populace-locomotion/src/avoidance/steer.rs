//! The new velocity of one walker.

use glam::Vec2;

use super::barriers::{Barriers, MOST_WALLS};
use super::grid::Seen;
use super::linear::{Goal, HalfPlane, MOST_PLANES, relax, solve};
use super::persons::{MOST_NEIGHBOURS, Manner, Neighbours, half_plane};
use super::{Agents, Avoidance, Body};

/// The most groups of strangers that one walker walks around.
const MOST_GROUPS: usize = 4;
/// Seconds ahead in which a walker looks for a way around obstacles.
const DETOUR_SECS: f32 = 1.5;
/// The sum of two speeds, in metres per second, from which on the full horizon holds.
const BRISK: f32 = 1.6;

/// The share of the highest speed that a walker uses who cannot avoid everybody.
const PRESSED: f32 = 0.8;

/// How much more of a change of velocity a walker makes for one ahead of it than for one behind it.
const VIEW: f32 = 0.35;
/// How much the shares of two walkers differ by their indices, from the half. Equal ones would
/// block each other in a door.
const UNEQUAL: f32 = 0.15;
/// The number of oncoming walkers for which a walker keeps to the right as much as it can.
const MANY: f32 = 3.0;

/// The half-planes of one walker, walls first.
struct Planes {
    all: [HalfPlane; MOST_PLANES],
    count: usize,
}

impl Planes {
    fn add(&mut self, plane: HalfPlane) {
        self.all[self.count] = plane;
        self.count += 1;
    }
}

const _: () = assert!(MOST_WALLS + MOST_NEIGHBOURS + MOST_GROUPS <= MOST_PLANES);

impl Avoidance {
    /// Returns the new velocity of the walker at a place of the grid.
    pub(crate) fn velocity(&self, agents: &Agents<'_>, place: u32) -> Vec2 {
        let walker = &self.grid.walkers()[place as usize];
        let nth = walker.index as usize;
        let body = Body {
            position: walker.position,
            velocity: walker.velocity,
            ahead: walker.ahead,
            radius: walker.radius,
            most_speed: agents.most_speeds[nth],
            index: walker.index,
            group: walker.group,
        };
        let settings = &self.settings;
        let preferred = Vec2::from(agents.preferred[nth]).clamp_length_max(body.most_speed);
        let speed = body.velocity.length().max(preferred.length());
        let farthest_wall = body.radius + speed * DETOUR_SECS.max(settings.wall_horizon_secs);
        let barriers = Barriers::near(&self.walls, body.position, farthest_wall);
        let grids = [&self.grid, &self.bystanders.grid];
        let [largest, standing] = grids.map(|grid| grid.largest_radius());
        let distance = body.radius + largest.max(standing);
        let distance = distance + (speed + BRISK) * settings.horizon_secs;
        let hidden = |other: Vec2| barriers.hide(body.position, other);
        let sight = (distance.min(settings.sight_m), settings.neighbours);
        let neighbours = Neighbours::choose(grids, &body, sight, hidden);
        let wished = self.groups.preferred(&body, preferred, neighbours.iter(), &settings.groups);
        let sidestep = settings.keep_right * (neighbours.oncoming / MANY).min(1.0);
        let wished = wished + body.ahead.perp() * sidestep;
        let wished = barriers.around(&body, wished, DETOUR_SECS);

        let mut planes = Planes { all: [HalfPlane::default(); MOST_PLANES], count: 0 };
        barriers.half_planes(&body, settings.wall_horizon_secs, |plane| planes.add(plane));
        let firm = planes.count;
        for other in neighbours.iter() {
            planes.add(half_plane(&body, other, self.manner(&body, other)));
        }
        let persons = planes.count;
        if settings.groups.is_walked_around {
            self.add_groups(&body, &neighbours, &mut planes);
        }
        let goal = Goal::Near(wished);
        let most = body.most_speed;
        solve(&planes.all[..planes.count], most, goal)
            .or_else(|_| solve(&planes.all[..persons], most, goal))
            .unwrap_or_else(|failure| relax(&planes.all[..persons], firm, most * PRESSED, failure))
    }

    /// Returns how a walker avoids a neighbour. Both find the same horizon, and shares that sum
    /// to 1 but for rounding. A bystander leaves the whole change to the walker.
    fn manner(&self, body: &Body, other: &Seen) -> Manner {
        let settings = &self.settings;
        if body.group != 0 && body.group == other.group {
            let horizon_secs = settings.groups.horizon_secs;
            return Manner { horizon_secs, share: 0.5, side_bias: 0.0, comfort_m: 0.0 };
        }
        let speeds = body.velocity.length() + other.velocity.length();
        let (slow, full) = (settings.slow_horizon_secs, settings.horizon_secs);
        let horizon_secs = slow + (full - slow) * (speeds / BRISK).min(1.0);
        let apart = (other.position - body.position).normalize_or_zero();
        let in_view = 0.5 * (body.ahead.dot(apart) + other.ahead.dot(apart));
        let is_even = (body.index ^ other.index) & 1 == 0;
        let politeness = if is_even == (body.index < other.index) { UNEQUAL } else { -UNEQUAL };
        let share = (0.5 + VIEW * in_view + politeness).clamp(0.0, 1.0);
        let share = if other.is_bystander() { 1.0 } else { share };
        let side_bias = settings.keep_right * opposition(body, other);
        Manner { horizon_secs, share, side_bias, comfort_m: settings.comfort_m }
    }

    /// Adds the groups of strangers as discs.
    fn add_groups(&self, body: &Body, neighbours: &Neighbours<'_>, planes: &mut Planes) {
        let mut known = [0; MOST_GROUPS];
        let mut count = 0;
        let strangers =
            neighbours.iter().filter(|other| other.group != 0 && other.group != body.group);
        for other in strangers {
            if count == MOST_GROUPS || known[..count].contains(&other.group) {
                continue;
            }
            known[count] = other.group;
            count += 1;
            if let Some(disc) = self.groups.disc(body, other) {
                let share = if body.group == 0 { 1.0 } else { 0.5 };
                let horizon_secs = self.settings.horizon_secs;
                let side_bias = self.settings.keep_right * opposition(body, other);
                let manner = Manner { horizon_secs, share, side_bias, comfort_m: 0.0 };
                planes.add(half_plane(body, &disc, manner));
            }
        }
    }
}

/// Returns how much two walkers are opposed, 0 to 1: 0 for those who go the same way.
fn opposition(body: &Body, other: &Seen) -> f32 {
    (0.5 - 1.5 * body.ahead.dot(other.ahead)).clamp(0.0, 1.0)
}
