//! Constraints of walls on a velocity: the truncated cones of section 5.2 of the paper for line
//! segments, and ways around obstacles ahead.

use glam::Vec2;

use super::Body;
use super::geometry::{nearest_to_origin, root};
use super::linear::HalfPlane;
use super::walls::{NONE, Walls};

/// The most walls that one walker heeds.
pub(crate) const MOST_WALLS: usize = 12;
/// The most corners that the outline of one obstacle is followed along.
const MOST_CORNERS: usize = 16;
/// The fastest that a wall pushes a walker out of itself, in metres per second.
const MOST_PUSH: f32 = 0.6;
/// Seconds in which a wall pushes a walker out of itself.
const PUSH_SECS: f32 = 0.3;
/// The largest detour, as the cosine of its angle: nobody turns back for a pillar.
const LEAST_PROGRESS: f32 = 0.2;
/// Advantage of a detour to the right over one to the left, as a difference of cosines.
const RIGHT_FIRST: f32 = 0.05;

/// The walls near one walker, nearest first.
pub(crate) struct Barriers<'a> {
    walls: &'a Walls,
    near: [(f32, u32); MOST_WALLS],
    count: usize,
}

/// The hands, as factors of the perpendicular. The ground's axes are x and z, of which z is forward
/// and x to the left, so that `Vec2::perp` points to the right.
const RIGHT: f32 = 1.0;
const LEFT: f32 = -1.0;

/// Returns the direction past a disc on one side; `None` from within it.
fn tangent(centre: Vec2, radius: f32, side: f32) -> Option<Vec2> {
    let square = centre.length_squared();
    let rest = square - radius * radius;
    let direction = centre * root(rest) + centre.perp() * (side * radius);
    (rest >= 0.0 && square > 0.0).then(|| direction / square)
}

/// Returns the direction that lies farther to one side.
fn outer(a: Vec2, b: Vec2, side: f32) -> Vec2 {
    if side * a.perp_dot(b) > 0.0 { b } else { a }
}

impl<'a> Barriers<'a> {
    /// Finds the walls within a distance.
    pub(crate) fn near(walls: &'a Walls, position: Vec2, distance: f32) -> Self {
        let mut all = Self { walls, near: [(0.0, NONE); MOST_WALLS], count: 0 };
        let reach = Vec2::splat(distance);
        walls.within(position - reach, position + reach, |nth, wall| {
            let nearest = nearest_to_origin(wall.from - position, wall.to - position);
            let square = nearest.length_squared();
            if square <= distance * distance {
                all.insert((square, nth));
            }
        });
        all
    }

    /// Keeps the nearest walls in order, each once.
    fn insert(&mut self, new: (f32, u32)) {
        let known = &self.near[..self.count];
        let at = known.partition_point(|known| *known < new);
        if at == MOST_WALLS || known.contains(&new) {
            return;
        }
        let end = (self.count + 1).min(MOST_WALLS);
        self.near.copy_within(at..end - 1, at + 1);
        self.near[at] = new;
        self.count = end;
    }

    fn indices(&self) -> impl Iterator<Item = u32> {
        self.near[..self.count].iter().map(|(_, wall)| *wall)
    }

    /// Returns whether a wall stands between two points.
    pub(crate) fn hide(&self, from: Vec2, to: Vec2) -> bool {
        let sides = |from: Vec2, to: Vec2, a: Vec2, b: Vec2| {
            let along = to - from;
            (along.perp_dot(a - from) > 0.0) != (along.perp_dot(b - from) > 0.0)
        };
        self.indices()
            .map(|nth| self.walls.all()[nth as usize])
            .any(|wall| sides(from, to, wall.from, wall.to) && sides(wall.from, wall.to, from, to))
    }

    /// Returns the ends of a wall as seen from a walker, the left one first.
    fn ends(&self, nth: u32, position: Vec2) -> [Vec2; 2] {
        let wall = self.walls.all()[nth as usize];
        let [from, to] = [wall.from - position, wall.to - position];
        if from.perp_dot(to) > 0.0 { [from, to] } else { [to, from] }
    }

    /// Returns the direction past the outline of a wall's obstacle on one side. `None` if the
    /// outline goes on to beyond a quarter turn from the wall, or around the walker.
    fn outline(&self, nth: u32, body: &Body, side: f32) -> Option<Vec2> {
        let all = self.walls.all();
        let [left, right] = self.ends(nth, body.position);
        let own = |end| tangent(end, body.radius, side);
        let mut outermost = outer(own(left)?, own(right)?, side);
        let ahead = nearest_to_origin(left, right);
        let mut end = if side > 0.0 { right } else { left };
        let mut wall = nth;
        for _ in 0..MOST_CORNERS {
            let now = all[wall as usize];
            let forward = now.to - body.position == end;
            wall = if forward { now.after } else { now.before };
            let Some(next) = all.get(wall as usize) else { return Some(outermost) };
            let to = if forward { next.to } else { next.from } - body.position;
            if side * end.perp_dot(to) <= 0.0 {
                return Some(outermost);
            }
            outermost = outer(outermost, own(to)?, side);
            if outermost.dot(ahead) < 0.0 {
                return None;
            }
            end = to;
        }
        None
    }

    /// Returns a preferred velocity that leads around the nearest obstacle straight ahead, if
    /// there is a way around.
    pub(crate) fn around(&self, body: &Body, preferred: Vec2, horizon_secs: f32) -> Vec2 {
        let speed = preferred.length();
        let ahead = preferred.normalize_or_zero();
        let blocks = |nth: &u32| {
            let [left, right] = self.ends(*nth, body.position);
            let nearest = nearest_to_origin(left, right);
            let [first, last] = [(left, LEFT), (right, RIGHT)].map(|(end, side)| {
                let past = tangent(end, body.radius, side);
                past.is_some_and(|past| side * ahead.perp_dot(past) > 0.0)
            });
            let is_near = nearest.length() <= body.radius + speed * horizon_secs;
            is_near && first && last && nearest.dot(ahead) > 0.0
        };
        let Some(nth) = self.indices().find(blocks) else { return preferred };
        let hint = ahead + 0.5 * body.velocity / body.most_speed.max(0.1);
        let way = |side: f32| {
            let direction = self.outline(nth, body, side)?;
            let bonus = if side > 0.0 { RIGHT_FIRST } else { 0.0 };
            let possible = direction.dot(ahead) >= LEAST_PROGRESS;
            possible.then_some((direction, direction.dot(hint) + bonus))
        };
        match [way(RIGHT), way(LEFT)] {
            [Some(right), Some(left)] => (if right.1 >= left.1 { right } else { left }).0 * speed,
            [Some((only, _)), None] | [None, Some((only, _))] => only * speed,
            [None, None] => preferred,
        }
    }

    /// Adds the half-planes of all walls. Velocity zero lies in all of them, unless the walker
    /// is inside a wall.
    pub(crate) fn half_planes(
        &self,
        body: &Body,
        horizon_secs: f32,
        mut add: impl FnMut(HalfPlane),
    ) {
        for nth in self.indices() {
            let plane = self.half_plane(nth, body, horizon_secs);
            if plane.offset > -body.most_speed {
                add(plane);
            }
        }
    }

    fn half_plane(&self, nth: u32, body: &Body, horizon_secs: f32) -> HalfPlane {
        let ends = self.ends(nth, body.position);
        let nearest = nearest_to_origin(ends[0], ends[1]);
        let distance = nearest.length();
        if distance <= body.radius {
            let side = (ends[1] - ends[0]).perp().normalize_or(Vec2::X);
            let normal = if distance > 0.0 { -nearest / distance } else { side };
            let push = (body.radius - distance) / PUSH_SECS;
            return HalfPlane { normal, offset: push.min(MOST_PUSH), weight: 1.0 };
        }
        // The velocities that meet the wall in time are a convex set. A half-plane with a normal
        // that points away from all of the wall begins where it touches that set.
        let mut best = HalfPlane::default();
        let mut least = f32::INFINITY;
        let mut offer = |normal: Vec2, is_outline: bool| {
            let support = normal.dot(ends[0]).max(normal.dot(ends[1])) + body.radius;
            let offset = if is_outline { 0.0 } else { support / horizon_secs };
            let plane = HalfPlane { normal, offset, weight: 1.0 };
            // The least change out of the set, or the largest distance from it.
            if support <= 0.0 && plane.lack(body.velocity) < least {
                least = plane.lack(body.velocity);
                best = plane;
            }
        };
        offer(-nearest / distance, false);
        for (end, side) in ends.into_iter().zip([LEFT, RIGHT]) {
            if let Some(past) = self.outline(nth, body, side) {
                offer(past.perp() * side, true);
            }
            offer((body.velocity - end / horizon_secs).normalize_or_zero(), false);
        }
        let across = (ends[1] - ends[0]).perp().normalize_or_zero();
        offer(if across.dot(ends[0]) < 0.0 { across } else { -across }, false);
        best
    }
}
