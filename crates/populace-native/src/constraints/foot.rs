//! Where a foot goes: with its clips and its stride, locked to the ground while it stands. Twin of
//! `kernels/foot.cl`.
//!
//! Reads constraints, soles, the ground, the leg's transforms, and the foot's state as of the frame
//! before. Returns its state for the next.
//!
//! A standing foot is locked in world space: at the lowest point of its sole, over which it rolls,
//! and in its direction. Once lifted, it catches up with the clip.

use populace_device::layout::{
    Constraint, FOOT_EDGE, FOOT_LEG, FOOT_LIFT, FOOT_MAX_TURN, FOOT_NEAR_SECS, FOOT_PIVOT_SLACK,
    FOOT_REACH, FOOT_RELEASE_SECS, FOOT_RELOCK, FOOT_SETTLE, FOOT_SETTLE_SECS, FOOT_SINK,
    FOOT_SINK_UNKNOWN, Float4, MAX_SOLE_POINTS,
};
use populace_model::math::{Real, quat, vec3};

use super::contacts::InContact;
use super::foot_state::{FootState, Settings, Stance};
use super::foothold::{Floor, within};
use crate::lanes::Members;
use crate::matrices::{MATRIX, origin, transform_point, transform_vector};

/// The most points of a sole: those of the ankle and those of the toes.
const POINTS: usize = 2 * MAX_SOLE_POINTS as usize;

/// Goal of a foot.
pub(super) struct FootGoal<R> {
    /// The ankle's position in model space, and the tangent of half the angle about +Y by which the
    /// foot turns.
    pub(super) ankle: [R; 4],
    /// The ground's unit normal in model space, and how much the foot follows the slope: 1 while
    /// planted, 0 when lifted.
    pub(super) follows: [R; 4],
}

/// A leg before the constraint, in model space.
pub(super) struct Leg<R> {
    pub(super) hip: [R; 3],
    pub(super) knee: [R; 3],
    /// Direction that the knee bends to.
    pub(super) bend: [R; 3],
    /// Transforms of the ankle, and of the joint that carries the front of the sole.
    pub(super) ankle: [R; MATRIX],
    pub(super) toes: [R; MATRIX],
}

/// A rotation about +Y, by the tangent of half its angle.
#[derive(Clone, Copy)]
struct Turn<R> {
    half_tan: R,
    sin: R,
    cos: R,
}

impl<R: Real> Turn<R> {
    #[inline(always)]
    fn turn_of(half_tan: R) -> Self {
        let one = R::splat(1.0);
        let inverse = one / (one + half_tan * half_tan);
        Self { half_tan, sin: (half_tan + half_tan) * inverse, cos: R::splat(2.0) * inverse - one }
    }

    /// Returns the turn by the sum of two angles, which is less than half a turn.
    #[inline(always)]
    fn turn_and(self, half_tan: R) -> Self {
        let product = self.half_tan * half_tan;
        Self::turn_of((self.half_tan + half_tan) / (R::splat(1.0) - product))
    }

    #[inline(always)]
    fn turned(self, [x, y, z]: [R; 3]) -> [R; 3] {
        [self.cos * x + self.sin * z, y, self.cos * z - self.sin * x]
    }
}

/// A foot as its clips and the member's stride pose it, in model space.
struct Stepped<R> {
    ankle: [R; 3],
    turn: Turn<R>,
    /// From heel to ball, as the clips have it.
    along: [R; 3],
    /// Points of the sole, as the clips have them, relative to the ankle: first the point on the
    /// ground beneath the ankle, which stands in for a sole without points.
    sole: [[R; 3]; 1 + POINTS],
    /// Number of points of the sole.
    points: u8,
    /// Index of the lowest point of the sole.
    lowest: R,
    /// Position of that point relative to the ankle.
    lowest_point: [R; 3],
    /// Height of that point in model space.
    clearance: R,
}

impl<R: Real> Stepped<R> {
    /// Applies the member's stride: distances that the clip steps along +Z, from the ankle's
    /// position at rest, are scaled and turned, and the foot turns by them about the origin.
    #[inline(always)]
    fn step_foot(
        leg: &Leg<R>,
        foot: &Constraint,
        soles: &[Float4],
        settings: &Settings<R>,
        [along_x, along_z, turn]: [R; 3],
    ) -> Self {
        let zero = R::splat(0.0);
        let (at, rest_z) = (origin(&leg.ankle), settings.limits[2]);
        let [x, y, z] = at;
        let stride = z - rest_z;
        let turn = Turn::turn_of(turn * stride);
        let ankle = turn.turned([x + stride * along_x, y, rest_z + stride * along_z]);
        let of_ankle = &soles[foot.sole_first as usize..][..foot.sole_count as usize];
        let of_toes = &soles[foot.toe_first as usize..][..foot.toe_count as usize];
        let along = match of_ankle {
            [heel, .., ball] => {
                transform_vector(&leg.ankle, splat(vec3::sub(ball.xyz(), heel.xyz())))
            }
            _ => [zero; 3],
        };
        let beneath = y - settings.limits[3];
        let mut sole = [[zero; 3]; 1 + POINTS];
        sole[0] = vec3::sub([x, beneath, z], at);
        let (mut lowest, mut lowest_point, mut clearance) = (zero, sole[0], R::splat(f32::MAX));
        let mut points = 0u8;
        for (joint, of_joint) in [(&leg.ankle, of_ankle), (&leg.toes, of_toes)] {
            for point in of_joint {
                let place = transform_point(joint, splat(point.xyz()));
                let point = vec3::sub(place, at);
                let is_lower = place[1].less(clearance);
                clearance = R::choose(is_lower, place[1], clearance);
                lowest = R::choose(is_lower, R::splat(f32::from(points)), lowest);
                lowest_point = vec3::choose::<R>(is_lower, point, lowest_point);
                points += 1;
                sole[usize::from(points)] = point;
            }
        }
        clearance = if points == 0 { beneath } else { clearance };
        Self { ankle, turn, along, sole, points, lowest, lowest_point, clearance }
    }

    /// Returns the point of the sole with an index, relative to the ankle.
    #[inline(always)]
    fn sole_point(&self, index: R) -> [R; 3] {
        let mut point = self.sole[usize::from(self.points)];
        for nth in (1..self.points).rev() {
            let is_before = index.less(R::splat(f32::from(nth) - 0.5));
            point = vec3::choose::<R>(is_before, self.sole[usize::from(nth)], point);
        }
        point
    }
}

/// Returns the same vector in all lanes.
#[inline(always)]
fn splat<R: Real>([x, y, z]: [f32; 3]) -> [R; 3] {
    [R::splat(x), R::splat(y), R::splat(z)]
}

/// Returns a part of the way from 0 to 1 that begins and ends without speed.
#[inline(always)]
fn eased<R: Real>(part: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let part = R::choose(zero.less(part), R::choose(part.less(one), part, one), zero);
    part * part * (R::splat(3.0) - R::splat(2.0) * part)
}

/// Returns whether a foot stands, and how near it is to that: 1 while it stands, 0 in the air.
#[inline(always)]
fn stands<R: Real>(
    settings: &Settings<R>,
    ankle_height: R,
    contact: InContact<R>,
) -> (R::Choice, R) {
    let [rest, planted_below, lifted_above, _] = settings.up;
    let (one, lift) = (R::splat(1.0), ankle_height - rest);
    let above = (lift - planted_below) / (lifted_above - planted_below);
    let in_contact = R::both(contact.known, R::splat(0.0).at_most(contact.within_secs));
    let is_low = R::both(R::others(contact.known), lift.at_most(planted_below));
    let per_sec = R::splat(1.0 / FOOT_NEAR_SECS);
    let near = R::choose(contact.known, one + contact.within_secs * per_sec, one - above);
    (R::either(in_contact, is_low), eased(near))
}

/// Returns the horizontal offset of a foot from its position in the clip, at most `most` metres,
/// and whether the member was moved elsewhere, which ends the offset. `pivot` is where the clip has
/// the point that stands.
#[inline(always)]
fn offset<R: Real>(state: &FootState<R>, pivot: [R; 3], decay: R, most: R) -> ([R; 3], R::Choice) {
    let (zero, [x, z]) = (R::splat(0.0), state.vector);
    let [x, z] = [
        R::choose(state.planted, x - pivot[0], x * decay),
        R::choose(state.planted, z - pivot[2], z * decay),
    ];
    let vector = [x, zero, z];
    let far = vec3::dot(vector, vector);
    let shorter = vec3::scale(vector, most * far.inverse_sqrt());
    let near = vec3::choose::<R>((most * most).less(far), shorter, vector);
    let elsewhere = (R::splat(4.0) * most * most).less(far);
    (vec3::choose::<R>(elsewhere, [zero; 3], near), elsewhere)
}

/// Returns the tangent of half the angle by which a foot is turned from where the clip has it.
/// `own` is the direction from heel to toes in the clip, in world space.
#[inline(always)]
fn turn_lag<R: Real>(state: &FootState<R>, own: [R; 2], decay: R) -> R {
    let (zero, [x, z]) = (R::splat(0.0), state.direction);
    let (cross, dot) = (own[1] * x - own[0] * z, own[0] * x + own[1] * z);
    let kept = R::choose(zero.less(dot), cross / (R::splat(1.0) + dot), zero);
    let lag = R::choose(state.planted, kept, x * decay);
    within(lag, R::splat(-FOOT_MAX_TURN), R::splat(FOOT_MAX_TURN))
}

/// A foot that is locked to the ground, or let go.
struct Lock<R: Real> {
    /// Offset from where the clip has the foot, in world space, horizontal.
    vector: [R; 3],
    /// The member was moved elsewhere.
    moved_elsewhere: R::Choice,
    planted: R::Choice,
    released: R::Choice,
    /// Index of the point of the sole that stands, and where it is relative to the ankle.
    pivot: R,
    arm: [R; 3],
}

/// A foot of a member, or of several in lanes, and all that it goes by.
pub(super) struct FootInputs<'a, R: Real> {
    /// The constraint of the first member.
    pub(super) foot: &'a Constraint,
    pub(super) soles: &'a [Float4],
    pub(super) floor: Floor<'a>,
    pub(super) elapsed_secs: f32,
    pub(super) stance: Stance<R>,
    pub(super) settings: Settings<R>,
    pub(super) leg: Leg<R>,
    pub(super) contact: InContact<R>,
    pub(super) state: FootState<R>,
    /// Seconds for which all feet have stood, as of the feet before this one.
    pub(super) stood_secs: R,
}

impl<R: Members> FootInputs<'_, R> {
    /// Returns the longest offset of the foot, in metres.
    #[inline(always)]
    fn most(&self) -> R {
        self.settings.up[3] * self.stance.standing.place[3]
    }

    /// Returns the unit direction in world space of a vector of model space, along X and Z.
    #[inline(always)]
    fn level_direction(&self, [x, _, z]: [R; 3]) -> [R; 2] {
        let ([sin, cos], zero) = (self.stance.standing.facing, R::splat(0.0));
        let along = [cos * x + sin * z, zero, cos * z - sin * x];
        let [x, _, z] = vec3::unit_or(along, [zero, zero, R::splat(1.0)]);
        [x, z]
    }

    /// Returns whether an offset takes the ankle too far from the hip: horizontally, or so that the
    /// pelvis would have to sink for it.
    #[inline(always)]
    fn overstretches(&self, stepped: &Stepped<R>, offset: [R; 3]) -> R::Choice {
        let (standing, most) = (&self.stance.standing, self.most());
        let ankle = standing.to_world(stepped.ankle);
        let [x, y, z] = vec3::sub(ankle, standing.to_world(self.leg.hip));
        let own = x * x + z * z;
        let (x, z) = (x + offset[0], z + offset[2]);
        let with_offset = x * x + z * z;
        let furthest = R::splat(FOOT_REACH * FOOT_REACH) * most * most;
        let leg = R::splat(FOOT_LEG * FOOT_LEG) * most * most;
        let (zero, straight) = (R::splat(0.0), vec3::root(leg - own));
        let sink = R::choose(self.contact.known, R::splat(FOOT_SINK), R::splat(FOOT_SINK_UNKNOWN));
        let above = R::choose(straight.less(-y), straight, -y) - sink * most;
        let above = R::choose(zero.less(above), above, zero);
        let is_far = R::either(furthest.less(with_offset), (leg - above * above).less(with_offset));
        R::both(own.less(with_offset), is_far)
    }

    /// Returns whether a foot that stands for long leaves an offset, to stand below the body.
    #[inline(always)]
    fn settles(&self, offset: [R; 3]) -> R::Choice {
        let most = R::splat(FOOT_SETTLE) * self.most();
        let has_stood = R::splat(FOOT_SETTLE_SECS).at_most(self.stood_secs);
        R::both(has_stood, (most * most).less(vec3::dot(offset, offset)))
    }

    /// Locks a foot that stands, unless the lock holds it too far back.
    #[inline(always)]
    fn lock(&self, stepped: &Stepped<R>, stands: R::Choice, turn: Turn<R>, decay: R) -> Lock<R> {
        let (state, most, none) = (&self.state, self.most(), [R::splat(0.0); 3]);
        let kept_arm =
            vec3::choose::<R>(state.planted, turn.turned(stepped.sole_point(state.pivot)), none);
        let pivot = self.stance.standing.to_world(vec3::add(stepped.ankle, kept_arm));
        let (vector, moved_elsewhere) = offset(state, pivot, decay, most);
        let relock = R::splat(FOOT_RELOCK) * most;
        let is_behind = (relock * relock).less(vec3::dot(vector, vector));
        let is_behind = R::both(state.released, is_behind);
        let lets_go = R::either(is_behind, self.overstretches(stepped, vector));
        let lets_go = R::either(lets_go, self.settles(vector));
        let released = R::both(stands, lets_go);
        let slack = R::splat(FOOT_PIVOT_SLACK) * self.settings.up[3];
        let is_low = (stepped.ankle[1] + kept_arm[1]).at_most(stepped.clearance + slack);
        let kept = R::both(state.planted, is_low);
        let lowest_arm = turn.turned(stepped.lowest_point);
        Lock {
            vector,
            moved_elsewhere,
            planted: R::both(stands, R::others(lets_go)),
            released,
            pivot: R::choose(kept, state.pivot, stepped.lowest),
            arm: vec3::choose::<R>(kept, kept_arm, lowest_arm),
        }
    }

    /// Returns the ankle's position in model space above the place of its pivot. A lifted foot is
    /// as far above the ground as the clip has it. `arm` leads from the ankle to the pivot.
    #[inline(always)]
    fn ankle_over(
        &self,
        stepped: &Stepped<R>,
        [x, height, z]: [R; 3],
        arm: [R; 3],
        [nx, ny, nz]: [R; 3],
        near: R,
    ) -> [R; 3] {
        let (zero, one, clearance) = (R::splat(0.0), R::splat(1.0), stepped.clearance);
        let kept = R::choose(zero.less(clearance), clearance * (one - near), zero);
        let above = kept + (stepped.ankle[1] + arm[1] - clearance);
        let standing = &self.stance.standing;
        let y = height + above * standing.place[3];
        let mut tilted = arm;
        if !self.floor.is_level() {
            let tilt = quat::normalize_or([nz, zero, -nx, one + ny], quat::identity());
            let upright = R::both(nx.abs().at_most(zero), nz.abs().at_most(zero));
            let rotated = vec3::rotated(vec3::part_of(tilt, near), arm);
            tilted = vec3::choose::<R>(upright, arm, rotated);
        }
        vec3::sub(standing.to_model([x, y, z]), tilted)
    }

    /// Returns the goal of the foot, and its state for the next frame.
    #[inline(always)]
    pub(super) fn foot_goal(&self) -> (FootGoal<R>, FootState<R>) {
        let Self { foot, floor, stance, settings, ref leg, mut state, .. } = *self;
        let (zero, standing) = (R::splat(0.0), &stance.standing);
        let stepped = Stepped::step_foot(leg, foot, self.soles, &settings, stance.stride);
        let (stands, near) = stands(&settings, stepped.ankle[1], self.contact);
        let decay = R::splat(1.0 / (1.0 + self.elapsed_secs * (1.0 / FOOT_RELEASE_SECS)));
        let own = self.level_direction(stepped.turn.turned(stepped.along));
        let lag = if foot.sole_count > 1 { turn_lag(&state, own, decay) } else { zero };
        let turn = stepped.turn.turn_and(lag);
        let Lock { vector, moved_elsewhere, planted, released, pivot, arm } =
            self.lock(&stepped, stands, turn, decay);
        let place = vec3::add(standing.to_world(vec3::add(stepped.ankle, arm)), vector);
        let most = self.most();
        let mut under = floor.ground_under(place);
        if floor.has_heights() {
            for point in &stepped.sole[1..][..usize::from(stepped.points)] {
                let at = standing.to_world(vec3::add(stepped.ankle, turn.turned(*point)));
                floor.stand_on(&mut under, vec3::add(at, vector), R::splat(FOOT_EDGE) * most);
            }
            under.settle();
        }
        state.known = R::both(state.known, R::others(moved_elsewhere));
        let lift = R::splat(FOOT_LIFT) * vec3::root(vec3::dot(vector, vector));
        let ahead = floor.ground_ahead(&stance, place, under.ground, [most, near]);
        let ahead = ahead + R::choose(R::both(released, self.contact.known), lift, zero);
        let [height, climb] = floor.shown_height(&state, planted, &under, ahead);
        let [x, _, z] = Turn::turn_of(lag).turned([own[0], zero, own[1]]);
        let next = FootState {
            vector: [
                R::choose(planted, place[0], vector[0]),
                R::choose(planted, place[2], vector[2]),
            ],
            direction: [R::choose(planted, x, lag), R::choose(planted, z, zero)],
            height,
            above: R::choose(planted, height - under.ground, zero),
            climb,
            pivot,
            planted,
            released,
            known: zero.less(R::splat(1.0)),
        };
        let [nx, ny, nz] = standing.direction_to_model(under.normal);
        let place = [place[0], height, place[2]];
        let [x, y, z] = self.ankle_over(&stepped, place, arm, [nx, ny, nz], near);
        let goal = FootGoal { ankle: [x, y, z, turn.half_tan], follows: [nx, ny, nz, near] };
        (goal, next)
    }
}
