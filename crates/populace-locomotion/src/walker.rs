//! One walker: how it moves towards the velocity that it wants, and how it steps.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec2;
use populace::{Ground, Placement, Stride};

use crate::Error;
use crate::footing::LedStep;
use crate::gait_space::GaitSpace;
use crate::path::check_coordinate;
use crate::step::Step;
use crate::treads::{Footholds, Gait};

/// How far from its heading a walker may move without turning first, in radians.
const LEEWAY_RAD: f32 = 0.45;
/// The part of a remaining turn that is turned in a second, per radian.
const TURN_GAIN: f32 = 4.0;
/// Speeds below which a walker stands, in metres per second, and turns in radians per second.
const STANDS_M_PER_SEC: f32 = 0.02;
const STANDS_RAD_PER_SEC: f32 = 0.05;
/// Half the distance over which the height of the ground is averaged, in metres.
const HALF_STEP_M: f32 = 0.25;
/// Distance ahead of a body that walks at which the ground is averaged, in metres: feet come down
/// there.
pub(crate) const AHEAD_M: f32 = 0.12;
/// Speed from which on the ground is averaged ahead, in metres per second; less far below it.
const WALKS_M_PER_SEC: f32 = 0.3;
/// Time in which a body follows the height of the ground, in seconds.
const HEIGHT_SECS: f32 = 0.08;
/// The part of its speed that leads a walker back when it begins to step backwards, and forwards
/// when it ends to.
const BACKWARDS: f32 = 0.2;
/// Time in which a stride follows the motion, in seconds.
const STRIDE_SECS: f32 = 0.06;
/// A walker that gains speed steps at the rate of the speed that it has after this time, in
/// seconds. At the rate of its own speed, the foot that happens to stand at a start would stand
/// until the leg no longer reaches it.
const SOON_SECS: f32 = 0.5;
/// The change of speed, as a part of it, below which a walker steps as before.
const SAME_SPEED: f32 = 1e-3;
/// Turns smaller than this are not made, in radians.
const LEAST_TURN_RAD: f32 = 1e-3;
const STANDING: Step = Step { mix: 0.0, cycles_per_sec: 0.0, stride_m: 0.0, ankle_m: 0.0 };

/// Limits of walkers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkerSettings {
    /// Gain of speed, in metres per second squared. Pedestrians that set off at a crossing gain
    /// 0.14 g until they walk at 1.36 m/s (E. R. Fugger, B. C. Randles et al., "Analysis of
    /// pedestrian gait and perception-reaction at signal-controlled crosswalk intersections",
    /// Transportation Research Record 1705 (2000), 20-25).
    pub acceleration: f32,
    /// Loss of speed, in metres per second squared. A stop from 1.36 m/s takes 0.8 s and half a
    /// metre. Pedestrians who stop fast at a crossing take two to three steps, more than a second
    /// ("Analysis on termination of pedestrians' gait at urban intersections", IEEE Intelligent
    /// Transportation Systems Conference 2014); the default brakes harder, so that walkers stop in
    /// time for others.
    pub deceleration: f32,
    /// Highest rate of turns, in radians per second: half a turn on the spot takes about two
    /// seconds.
    pub turn_rate: f32,
    /// Gain and loss of the rate of turns, in radians per second squared.
    pub turn_acceleration: f32,
    /// Highest speed sideways as a fraction of that forwards, for walkers that keep a heading. The
    /// defaults of both fractions are a choice, not measured.
    pub sideways: f32,
    /// Highest speed backwards as a fraction of that forwards.
    pub backwards: f32,
}

impl Default for WalkerSettings {
    fn default() -> Self {
        Self {
            acceleration: 1.37,
            deceleration: 1.8,
            turn_rate: 2.0,
            turn_acceleration: 8.0,
            sideways: 0.4,
            backwards: 0.7,
        }
    }
}

/// The motion of a walker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walker {
    pub(crate) position: Vec2,
    pub(crate) velocity: Vec2,
    pub(crate) height_m: f32,
    /// Speed at which it rises, in metres per second.
    climb: f32,
    pub(crate) heading_rad: f32,
    /// The direction of the heading.
    ahead: Vec2,
    pub(crate) turn_rate: f32,
    pub(crate) scale: f32,
    /// Seconds for which it steps on the spot before it stands.
    pub(crate) settles_secs: f32,
    pub(crate) goes_backwards: bool,
    /// How it steps.
    pub(crate) step: Step,
    /// How the crowd was told that it steps.
    pub(crate) told: Option<Step>,
    /// How its gaits step at a speed.
    gait: (f32, Step),
    /// The speed that it will soon have, in metres per second, and the cycles in a second at it.
    soon: f32,
    soon_cycles: (f32, f32),
    pub(crate) stride: Stride,
    /// The step that it is led through, and the phase of its cycle when the frame begins.
    led: Option<(LedStep, f32)>,
    /// The places where its feet stand on ground with treads.
    footholds: Footholds,
    /// The part of the last steps that the position's rounding left out, in metres.
    rest: Vec2,
}

/// The wish of a walker.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    pub(crate) velocity: Vec2,
    /// The heading to keep; that of the motion if `None`.
    pub(crate) facing_rad: Option<f32>,
}

/// The motion that a walker is led through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lead {
    /// Position `[x, z]` in metres.
    pub position: [f32; 2],
    /// Velocity `[x, z]` in metres per second.
    pub velocity: [f32; 2],
    /// The speed that it will have in half a second, in metres per second. It steps at that cadence
    /// when it sets off.
    pub soon_m_per_sec: f32,
    /// The heading about +Y, from +Z towards +X in radians.
    pub yaw_rad: f32,
    /// The height of the ground below it in metres.
    pub height_m: f32,
    /// The step that it takes; if `None`, it steps as suits its speed.
    pub step: Option<LedStep>,
}

impl Lead {
    /// Seconds until [`soon_m_per_sec`](Self::soon_m_per_sec).
    pub const SOON_SECS: f32 = SOON_SECS;

    /// Refuses a number that is not finite or too large.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let Self { position: [x, z], velocity: [vx, vz], .. } = *self;
        let numbers = [x, z, vx, vz, self.soon_m_per_sec, self.yaw_rad, self.height_m];
        numbers.into_iter().try_for_each(check_coordinate)?;
        self.step.map_or(Ok(()), |step| step.check())
    }
}

fn direction_of(heading_rad: f32) -> Vec2 {
    let (sin, cos) = heading_rad.sin_cos();
    Vec2::new(sin, cos)
}

/// Returns the angle from one direction to another about +Y, -pi to pi. The lengths may differ.
fn turn_between(from: Vec2, to: Vec2) -> f32 {
    let (sin, cos) = (to.perp_dot(from), to.dot(from));
    // Nearly all turns are small: the arc tangent's series is exact for them.
    let tangent = sin / cos;
    if cos > 0.0 && tangent.abs() < 0.05 {
        let square = tangent * tangent;
        return tangent * (1.0 - square * (1.0 / 3.0 - square * 0.2));
    }
    sin.atan2(cos)
}

/// Returns the angle between -pi and pi that is the same turn.
fn wrapped(angle: f32) -> f32 {
    if angle.abs() <= PI {
        return angle;
    }
    let turns = (angle / (2.0 * PI)).round();
    angle - turns * 2.0 * PI
}

impl Walker {
    /// Returns a walker that stands at a placement.
    pub(crate) fn standing(placement: &Placement) -> Self {
        let [x, height_m, z] = placement.position();
        Self {
            position: Vec2::new(x, z),
            velocity: Vec2::ZERO,
            height_m,
            climb: 0.0,
            heading_rad: wrapped(placement.yaw_rad()),
            ahead: direction_of(placement.yaw_rad()),
            turn_rate: 0.0,
            scale: placement.scale(),
            settles_secs: 0.0,
            goes_backwards: false,
            step: STANDING,
            told: None,
            gait: (f32::INFINITY, STANDING),
            soon: 0.0,
            soon_cycles: (f32::INFINITY, 0.0),
            stride: Stride::OF_CLIPS,
            led: None,
            footholds: Footholds::default(),
            rest: Vec2::ZERO,
        }
    }

    /// Stands at a point from now on.
    pub(crate) fn stand_at(&mut self, position: Vec2) {
        (self.position, self.velocity) = (position, Vec2::ZERO);
        (self.turn_rate, self.rest) = (0.0, Vec2::ZERO);
        (self.step, self.stride) = (STANDING, Stride::OF_CLIPS);
    }

    pub(crate) fn placement(&self) -> Placement {
        Placement::at([self.position.x, self.height_m, self.position.y])
            .facing(self.heading_rad)
            .scaled(self.scale)
    }

    /// Moves on for `secs`, and returns where it wants to be; walls may hold it back.
    pub(crate) fn advance(&mut self, wish: Wish, limits: &WalkerSettings, secs: f32) -> Vec2 {
        let speed = wish.velocity.length();
        let moves = speed > STANDS_M_PER_SEC;
        let aside = if moves { turn_between(self.ahead, wish.velocity) } else { 0.0 };
        let to_turn = wish.facing_rad.map_or(aside, |facing| wrapped(facing - self.heading_rad));
        let aside = aside - self.turn(to_turn, limits, secs);
        let wanted = if wish.facing_rad.is_some() {
            wish.velocity * side_limit(aside, limits)
        } else if aside.abs() <= LEEWAY_RAD {
            wish.velocity
        } else {
            // It turns until it nearly faces the direction of the wish.
            let aside = wrapped(aside);
            let along = self.heading_rad + aside.clamp(-LEEWAY_RAD, LEEWAY_RAD);
            let over = aside.abs() - LEEWAY_RAD;
            direction_of(along) * speed * direction_of((2.0 * over).clamp(0.0, FRAC_PI_2)).y
        };
        let change = wanted - self.velocity;
        let faster = wanted.length_squared() > self.velocity.length_squared();
        let most = secs * if faster { limits.acceleration } else { limits.deceleration };
        self.velocity += change.clamp_length_max(most);
        let gained = limits.acceleration * SOON_SECS;
        self.soon = wanted.length().min(self.velocity.length() + gained);
        if !moves && self.velocity.length() < STANDS_M_PER_SEC {
            self.velocity = Vec2::ZERO;
        }
        self.position + (self.velocity * secs + self.rest)
    }

    /// Is under way as a lead says, at a phase of its cycle. Returns the phase at which a step that
    /// it is led through has its cycle, which is by half a cycle further for one of the later half.
    pub(crate) fn begin(&mut self, lead: &Lead, gaits: &GaitSpace, phase: f32) -> f32 {
        self.heading_rad = wrapped(lead.yaw_rad);
        self.follow(lead, None, 1.0);
        // A step without end has the stride of the motion at once.
        self.step(gaits, f32::MAX, None);
        self.settles_secs = 0.0;
        self.told = Some(self.step);
        let landings = gaits.landings(self.step.mix);
        lead.step
            .zip(landings)
            .map_or(phase, |(step, landings)| step.phase(&landings[usize::from(phase >= 0.5)]))
    }

    /// Returns the part of a step, 0 to 1, for which a foot has been down when the body is over it.
    pub(crate) fn steps_from_touch_down(&self, gaits: &GaitSpace) -> f32 {
        let landings = gaits.landings(self.step.mix);
        landings.map_or(0.0, |[left, right]| left.until_over + right.until_over)
    }

    /// Moves to where it is led, in a step of `secs` that begins at a phase of its cycle.
    pub(crate) fn follow(&mut self, lead: &Lead, phase: Option<f32>, secs: f32) {
        self.led = lead.step.zip(phase);
        self.position = lead.position.into();
        self.velocity = lead.velocity.into();
        (self.height_m, self.climb) = (lead.height_m, 0.0);
        self.turn_rate = wrapped(lead.yaw_rad - self.heading_rad) / secs;
        self.heading_rad = wrapped(lead.yaw_rad);
        self.ahead = direction_of(self.heading_rad);
        self.soon = lead.soon_m_per_sec;
        self.rest = Vec2::ZERO;
    }

    /// Turns within the limits, and returns the angle.
    fn turn(&mut self, to_turn: f32, limits: &WalkerSettings, secs: f32) -> f32 {
        // A long step ends at the heading.
        let gain = TURN_GAIN.min(1.0 / secs);
        let rate = (gain * to_turn).clamp(-limits.turn_rate, limits.turn_rate);
        let rate = if to_turn.abs() < LEAST_TURN_RAD { 0.0 } else { rate };
        let change = limits.turn_acceleration * secs;
        self.turn_rate += (rate - self.turn_rate).clamp(-change, change);
        let turned = self.turn_rate * secs;
        if turned != 0.0 {
            self.heading_rad = wrapped(self.heading_rad + turned);
            self.ahead = direction_of(self.heading_rad);
        }
        turned
    }

    /// Comes to a position that walls allow, and follows the ground; `None` for level ground.
    pub(crate) fn arrive(&mut self, at: Vec2, wanted: Vec2, ground: Option<&Ground>, secs: f32) {
        if at == wanted {
            self.rest += self.velocity * secs - (at - self.position);
        } else {
            // Walls take speed and give none, even to who is led out of one.
            let most = self.velocity.length();
            self.velocity = ((at - self.position) / secs).clamp_length_max(most);
            self.rest = Vec2::ZERO;
        }
        self.position = at;
        let wanted = ground.map_or(0.0, |ground| {
            let walks = (self.velocity.length() / WALKS_M_PER_SEC).min(1.0);
            ground_below(ground, at + self.ahead * (AHEAD_M * walks), self.ahead)
        });
        // A critically damped spring, with a series for the exponential: the body neither jerks
        // where a step begins nor swings past its height.
        let per_sec = 2.0 / HEIGHT_SECS;
        let x = per_sec * secs;
        let fades = 1.0 / (1.0 + x + 0.48 * x * x + 0.235 * x * x * x);
        let off = self.height_m - wanted;
        let gain = (self.climb + per_sec * off) * secs;
        self.climb = (self.climb - per_sec * gain) * fades;
        self.height_m = wanted + (off + gain) * fades;
    }

    /// Sets how it steps, and counts the time until it stands. On ground with treads, of which it
    /// knows the phase of its cycle when the frame begins, its feet keep to them.
    pub(crate) fn step(&mut self, gaits: &GaitSpace, secs: f32, treads: Option<(&Ground, f32)>) {
        let speed = self.velocity.length() / self.scale;
        let turns = self.turn_rate.abs() > STANDS_RAD_PER_SEC;
        let on_the_spot = gaits.on_the_spot();
        self.settles_secs = if turns || speed * self.scale > STANDS_M_PER_SEC {
            1.0 / on_the_spot.cycles_per_sec
        } else {
            self.settles_secs - secs
        };
        if (speed - self.gait.0).abs() > SAME_SPEED * speed {
            self.gait = (speed, gaits.at_speed(speed));
        }
        let mut step = self.gait.1;
        if self.settles_secs > 0.0 && (speed == 0.0 || turns && step.mix < on_the_spot.mix) {
            step = on_the_spot;
        }
        let soon = self.soon / self.scale;
        if soon > speed && speed > 0.0 && step.mix > 0.0 {
            if (soon - self.soon_cycles.0).abs() > SAME_SPEED * soon {
                self.soon_cycles = (soon, gaits.at_speed(soon).cycles_per_sec);
            }
            step.cycles_per_sec = step.cycles_per_sec.max(self.soon_cycles.1);
        }
        let landings = self.led.and_then(|_| gaits.landings(step.mix)).filter(|_| step.mix > 0.0);
        let led = self.led.zip(landings);
        if let Some(((led, phase), landings)) = led {
            step.cycles_per_sec = led.cycles_per_sec(&landings, phase, secs);
        }
        let Vec2 { x: sin, y: cos } = self.ahead;
        let (x, z) = (self.velocity.x / self.scale, self.velocity.y / self.scale);
        let velocity = [cos * x - sin * z, sin * x + cos * z];
        let lean = if self.goes_backwards { -BACKWARDS } else { BACKWARDS };
        self.goes_backwards = led.is_none() && velocity[1] < -lean * speed;
        if self.goes_backwards {
            step = Step { cycles_per_sec: -step.cycles_per_sec, ..step };
        }
        let wanted = match led {
            Some(((led, phase), landings)) => {
                let told = self.told.unwrap_or(step).cycles_per_sec;
                led.stride(&landings, phase + told * secs, self.scale).unwrap_or(self.stride)
            }
            None => self.stride_over(treads, gaits, (step, velocity), secs),
        };
        self.stride = self.stride.towards(&wanted, secs / (secs + STRIDE_SECS));
        self.step = step;
    }

    /// Returns the stride of a step at a velocity in model space, by which the foot in the air
    /// comes to stand on one tread.
    fn stride_over(
        &mut self,
        treads: Option<(&Ground, f32)>,
        gaits: &GaitSpace,
        (step, velocity): (Step, [f32; 2]),
        secs: f32,
    ) -> Stride {
        let stride = step.stride(velocity, self.turn_rate);
        let landings = gaits.landings(step.mix).filter(|_| step.mix > 0.0);
        let treads = treads.filter(|_| step.cycles_per_sec > 0.0);
        let (Some((ground, phase)), Some(landings)) = (treads, landings) else {
            self.footholds = Footholds::default();
            return stride;
        };
        let gait = Gait {
            ground,
            position: self.position,
            velocity: self.velocity,
            ahead: self.ahead,
            scale: self.scale,
            phase: phase + self.told.unwrap_or(step).cycles_per_sec * secs,
            cycles_per_sec: step.cycles_per_sec,
            lead: stride.lead(),
        };
        let gains = gait.step_onto(&landings, &mut self.footholds);
        if gains == 0.0 {
            return stride;
        }
        let [x, z] = velocity;
        step.stride([x, z + gains * step.cycles_per_sec * step.ankle_m], self.turn_rate)
    }
}

/// Returns the fraction of a speed that is left in a direction relative to the heading.
fn side_limit(aside: f32, limits: &WalkerSettings) -> f32 {
    let (across, along) = aside.sin_cos();
    let most = if along >= 0.0 { 1.0 } else { limits.backwards };
    1.0 / Vec2::new(across / limits.sideways, along / most).length().max(1.0)
}

/// Returns the mean height of the ground over a step's length along a direction.
pub(crate) fn ground_below(ground: &Ground, at: Vec2, direction: Vec2) -> f32 {
    let heights = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|part| {
        let at = at + direction * (part * HALF_STEP_M);
        ground.height_at(at.x, at.y)
    });
    heights.iter().sum::<f32>() / 5.0
}
