//! Look-at: a chain shares a turn, and its last joint faces the targets; the twin of
//! `kernels/gaze.cl`.
//!
//! A turn of the gaze is a yaw about what is up and a pitch about the left of what faces, so that
//! no head tilts. Both come straight from the directions before and after. Angles are needed for
//! what lies beyond the limits or between targets.

use populace_device::layout::{Constraint, NONE, Step};
use populace_model::Affine;
use populace_model::math::{Real, angle, quat, vec3};

use super::{Models, Steering};

/// Nearer than this to straight up or down, as the sine of the angle, a target's side counts for
/// less and less: it would turn about wildly there.
const STEEP: f32 = 0.17;
/// With less than this level of a direction of length 1 there is no side to turn from.
const UPRIGHT: f32 = 1e-3;

/// Front, left and up of what carries a chain.
struct Frame {
    front: [f32; 3],
    left: [f32; 3],
    up: [f32; 3],
}

/// A direction of length 1 in a frame.
#[derive(Clone, Copy, Default)]
struct Sight {
    left: f32,
    up: f32,
    front: f32,
    /// The length of what is level of it.
    level: f32,
}

impl Frame {
    #[inline(always)]
    fn new(constraint: &Constraint, parent: Option<Affine>) -> Self {
        let (front, up) = (constraint.front.xyz(), constraint.up.xyz());
        let [ahead, up] =
            parent.map_or([front, up], |model| [front, up].map(|v| model.transform_vector(v)));
        let front = vec3::unit_or(ahead, [0.0, 0.0, 1.0]);
        let left = vec3::unit_or(vec3::cross(up, ahead), vec3::any_across(front));
        Self { front, left, up: vec3::cross(front, left) }
    }

    /// A direction in the frame; `None` where it has no length.
    #[inline(always)]
    fn see(&self, v: [f32; 3]) -> Option<Sight> {
        let (x, y, z) = (vec3::dot(v, self.left), vec3::dot(v, self.up), vec3::dot(v, self.front));
        let level = x * x + z * z;
        let squared = level + y * y;
        let k = if squared > 1e-20 { squared.inverse_sqrt() } else { return None };
        Some(Sight { left: x * k, up: y * k, front: z * k, level: vec3::root(level) * k })
    }

    /// Where the end of a chain faces.
    #[inline(always)]
    fn start(&self, facing: [f32; 3]) -> Sight {
        let start = self.see(facing).unwrap_or_default();
        if start.level < UPRIGHT {
            return Sight { left: 0.0, up: start.up, front: UPRIGHT, level: UPRIGHT };
        }
        start
    }

    /// The turn of what faces `start`: by a yaw, of which there are sine and cosine of the half,
    /// both times the same; and to a pitch, of which there are cosine and sine.
    #[inline(always)]
    fn turn(&self, start: Sight, [side, ahead]: [f32; 2], [level, height]: [f32; 2]) -> [f32; 4] {
        let rise = start.level * height - start.up * level;
        let on = 1.0 + (start.level * level + start.up * height);
        let (right, back, whole) = (-start.front * rise, start.left * rise, start.level * on);
        let (x, y, z) = (ahead * right + side * back, side * whole, ahead * back - side * right);
        let axis = vec3::add_scaled(
            vec3::add_scaled(vec3::scale(self.left, x), self.up, y),
            self.front,
            z,
        );
        quat::normalize_or([axis[0], axis[1], axis[2], ahead * whole], quat::identity())
    }
}

/// A yaw within a limit. What is further round is followed no further, and what passes behind lets
/// the gaze come back to the front, so that it never snaps from one side to the other.
fn held(yaw: f32, limit: f32) -> f32 {
    let size = yaw.abs();
    if size <= limit {
        return yaw;
    }
    let behind = 0.5 * (limit + angle::HALF_TURN);
    let size = if size <= behind {
        limit
    } else {
        limit * (angle::HALF_TURN - size) / (angle::HALF_TURN - behind)
    };
    if yaw < 0.0 { -size } else { size }
}

impl Steering<'_> {
    /// The turn towards the mean of all targets, as far as limits let it.
    #[inline(never)]
    fn aim_by_angles(
        &self,
        constraint: &Constraint,
        frame: &Frame,
        start: Sight,
        from: [f32; 3],
    ) -> [f32; 4] {
        let [side, up, down, _] = constraint.limits.0;
        let (mut yaw, mut pitch, mut total) = (0.0, 0.0, 0.0);
        for target in self.targets(constraint) {
            let (place, weight) = self.sight(target, from);
            let Some(seen) = frame.see(vec3::sub(place, from)).filter(|_| weight > 0.0) else {
                continue;
            };
            let steep = if seen.level < STEEP { seen.level * (1.0 / STEEP) } else { 1.0 };
            let upwards = angle::of(seen.up, seen.level);
            let raised = if upwards > up { up } else { upwards };
            yaw += held(angle::of(seen.left, seen.front), side) * steep * weight;
            pitch += (if raised < -down { -down } else { raised }) * weight;
            total += weight;
        }
        let k = 1.0 / total;
        let (side, ahead) = angle::sin_cos(0.5 * (yaw * k - angle::of(start.left, start.front)));
        let (height, level) = angle::sin_cos(pitch * k);
        frame.turn(start, [side, ahead], [level, height])
    }

    /// The turn from facing `start` to facing what is aimed at from a point, and how much that
    /// weighs.
    #[inline(never)]
    fn aim(
        &self,
        constraint: &Constraint,
        frame: &Frame,
        start: Sight,
        from: [f32; 3],
    ) -> ([f32; 4], f32) {
        let (mut to, mut total, mut count) = (Sight::default(), 0.0, 0);
        for target in self.targets(constraint) {
            let (place, weight) = self.sight(target, from);
            let Some(seen) = frame.see(vec3::sub(place, from)).filter(|_| weight > 0.0) else {
                continue;
            };
            to = seen;
            total += weight;
            count += 1;
        }
        let weight = if total < 1.0 { total } else { 1.0 };
        if count == 0 {
            return (quat::identity(), weight);
        }
        // The tangents of the limits. With both in front, the short way is the one that passes the
        // front.
        let [side, up, down] = [constraint.axis, constraint.front, constraint.up].map(|v| v.0[3]);
        let within = to.level >= STEEP
            && to.left.abs() <= side * to.front
            && to.up <= up * to.level
            && -to.up <= down * to.level;
        if count > 1 || !within || start.front <= 0.0 {
            return (self.aim_by_angles(constraint, frame, start, from), weight);
        }
        let side = start.front * to.left - start.left * to.front;
        let ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
        (frame.turn(start, [side, ahead], [to.level, to.up]), weight)
    }

    #[inline(never)]
    pub(super) fn gaze(
        &mut self,
        models: &mut impl Models,
        joint: usize,
        parent: u32,
        step: &Step,
    ) {
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = models.model(joint);
        let frame = Frame::new(constraint, (parent != NONE).then(|| models.model(parent as usize)));
        let (places, end) = Self::walk(models, links, own);
        let start = frame.start(end.transform_vector(constraint.axis.xyz()));
        let last = links.len() - 1;
        let (whole, weight) = self.aim(constraint, &frame, start, places[last]);
        let (mut so_far, mut place, mut shared) = (quat::identity(), places[0], 0.0);
        for (at, link) in links.iter().enumerate().take(last) {
            let share = link.share * weight;
            let mut turn = quat::identity();
            if share > 0.0 {
                shared += share;
                let now = vec3::part_as_told(whole, shared);
                turn = quat::mul(now, quat::conjugate(so_far));
                so_far = now;
            }
            if at > 0 {
                self.turns[step.turn as usize + at - 1] = turn;
            } else {
                models.set(joint, own.turned(turn));
            }
            place = vec3::add(place, vec3::turned(so_far, vec3::sub(places[at + 1], places[at])));
        }
        // The others have moved the last: it looks from where it is now, and turns by what is left.
        let (there, weight) = self.aim(constraint, &frame, start, place);
        let there = if weight < 1.0 { vec3::part_as_told(there, weight) } else { there };
        let left = quat::mul(there, quat::conjugate(so_far));
        if last == 0 {
            models.set(joint, own.turned(left));
        } else {
            self.turns[step.turn as usize + last - 1] = left;
        }
    }
}
