//! Look-at: a chain shares a turn, and its last joint faces the targets; the twin of `kernels/gaze.cl`.

use populace_core::Affine;
use populace_core::layout::{Constraint, NONE, Step};
use populace_core::math::{angle, quat, vec3};

use super::{Models, Steering};

/// Nearer than this to straight up or down, as the sine of the angle, a target's side counts for less and less: it would
/// turn about wildly there.
const STEEP: f32 = 0.17;

/// Front, left and up of what carries a chain.
struct Frame {
    front: [f32; 3],
    left: [f32; 3],
    up: [f32; 3],
}

/// Yaw towards the left, and pitch upwards, in radians.
#[derive(Clone, Copy)]
struct Angles {
    yaw: f32,
    pitch: f32,
}

impl Frame {
    fn new(constraint: &Constraint, parent: Option<Affine>) -> Self {
        let (front, up) = (constraint.front.xyz(), constraint.up.xyz());
        let [front, up] = parent.map_or([front, up], |model| [front, up].map(|v| model.transform_vector(v)));
        let front = vec3::unit_or(front, [0.0, 0.0, 1.0]);
        let up = vec3::unit_or(vec3::across(up, front), vec3::any_across(front));
        Self { front, left: vec3::cross(up, front), up }
    }

    /// The angles of a unit vector, and its part that is level.
    fn angles(&self, v: [f32; 3]) -> (Angles, f32) {
        let (x, y, z) = (vec3::dot(v, self.left), vec3::dot(v, self.up), vec3::dot(v, self.front));
        let level = vec3::root(x * x + z * z);
        (Angles { yaw: angle::of(x, z), pitch: angle::of(y, level) }, level)
    }

    /// The turn by `by` of what faces the yaw `yaw`: up about its own left, then about what is up here.
    fn turn(&self, yaw: f32, by: Angles) -> [f32; 4] {
        let (sin, cos) = angle::sin_cos(yaw);
        let right = vec3::add_scaled(vec3::scale(self.front, sin), self.left, -cos);
        quat::mul(angle::turn_about(self.up, by.yaw), angle::turn_about(right, by.pitch))
    }
}

/// A yaw within a limit. What is further round is followed no further, and what passes behind lets the gaze come back to
/// the front, so that it never snaps from one side to the other.
fn held(yaw: f32, limit: f32) -> f32 {
    let size = yaw.abs();
    if size <= limit {
        return yaw;
    }
    let behind = 0.5 * (limit + angle::HALF_TURN);
    let size =
        if size <= behind { limit } else { limit * (angle::HALF_TURN - size) / (angle::HALF_TURN - behind) };
    if yaw < 0.0 { -size } else { size }
}

impl Steering<'_> {
    /// The angles to face from a point, and how much they weigh.
    fn wished(&self, constraint: &Constraint, frame: &Frame, from: [f32; 3]) -> (Angles, f32) {
        let [side, up, down, _] = constraint.limits.0;
        let (mut yaw, mut pitch, mut total) = (0.0, 0.0, 0.0);
        for target in self.targets(constraint) {
            let (place, weight) = self.sight(target, from);
            let to = vec3::unit_or(vec3::sub(place, from), [0.0; 3]);
            if weight <= 0.0 || vec3::dot(to, to) <= 0.0 {
                continue;
            }
            let (seen, level) = frame.angles(to);
            let steep = if level < STEEP { level * (1.0 / STEEP) } else { 1.0 };
            let raised = if seen.pitch > up { up } else { seen.pitch };
            yaw += held(seen.yaw, side) * steep * weight;
            pitch += (if raised < -down { -down } else { raised }) * weight;
            total += weight;
        }
        if total <= 0.0 {
            return (Angles { yaw, pitch }, 0.0);
        }
        let k = 1.0 / total;
        (Angles { yaw: yaw * k, pitch: pitch * k }, if total < 1.0 { total } else { 1.0 })
    }

    pub(super) fn gaze(&mut self, models: &mut impl Models, joint: usize, parent: u32, step: &Step) {
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = models.model(joint);
        let frame = Frame::new(constraint, (parent != NONE).then(|| models.model(parent as usize)));
        let (places, last_model) = Self::walk(models, links, 0, own);
        let last = links.len() - 1;
        let facing = vec3::unit_or(last_model.transform_vector(constraint.axis.xyz()), frame.front);
        let (start, _) = frame.angles(facing);
        let (wish, weight) = self.wished(constraint, &frame, places[last]);
        let whole =
            Angles { yaw: (wish.yaw - start.yaw) * weight, pitch: (wish.pitch - start.pitch) * weight };
        let (mut now, mut turned, mut place) = (start, quat::identity(), places[0]);
        for (at, link) in links.iter().enumerate() {
            let by = if at == last {
                // The others have moved it: it looks from where it is now.
                let (wish, weight) = self.wished(constraint, &frame, place);
                let yaw = start.yaw + (wish.yaw - start.yaw) * weight;
                let pitch = start.pitch + (wish.pitch - start.pitch) * weight;
                Angles { yaw: yaw - now.yaw, pitch: pitch - now.pitch }
            } else {
                Angles { yaw: whole.yaw * link.share, pitch: whole.pitch * link.share }
            };
            let turn = if weight > 0.0 { frame.turn(now.yaw, by) } else { quat::identity() };
            now = Angles { yaw: now.yaw + by.yaw, pitch: now.pitch + by.pitch };
            if at == 0 {
                models.set(joint, own.turned(turn));
            } else {
                self.turns[step.turn as usize + at - 1] = turn;
            }
            turned = quat::mul(turn, turned);
            if at < last {
                place = vec3::add(place, vec3::turned(turned, vec3::sub(places[at + 1], places[at])));
            }
        }
    }
}
