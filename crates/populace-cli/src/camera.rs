//! Cameras: what `--camera` names, and where it is at each time.
//!
//! Cameras know nothing of crowds or files. They see a [`Subject`], which says where its people are.

mod fit;
mod keys;
mod subject;
mod sunken;
mod view;

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;
use populace_render::Camera;

use crate::failure::Failure;
use crate::frames::single;
use fit::{elevated, fit, upright};
pub(crate) use keys::Keys;
pub(crate) use subject::{Pose, Poses, Subject, figure, rectangle};
pub(crate) use view::View;

/// Visibility in distances of the camera from what it shows: haze leaves 83 % of the contrasts.
const VISIBILITY: f32 = 16.0;
/// Seconds in which the camera `orbit` goes round once.
const ORBIT_SECS: f64 = 60.0;
/// Height of the camera `orbit` above the horizon, in radians.
const ORBIT_ELEVATION_RAD: f32 = 0.35;
/// Directions for which the distance of the camera `orbit` is computed.
const ORBIT_DIRECTIONS: u8 = 32;
/// Height of the camera `iso`, from which equal lengths along the three axes look equal.
const ISO_ELEVATION_RAD: f32 = 0.615_479_7;
/// Field of view of the camera `iso`, narrow so that parallels stay nearly parallel.
const ISO_FOV_RAD: f32 = 0.16;
/// The least side of what cameras of a place show, in metres.
const LEAST_M: f32 = 4.0;
const TOP_FOV_RAD: f32 = 0.5;
const ABOVE_FOV_RAD: f32 = 0.6;
const ORBIT_FOV_RAD: f32 = 0.7;
const FOLLOW_FOV_RAD: f32 = 0.8;
const EYE_FOV_RAD: f32 = 1.1;
/// Distance of the near plane of cameras among people, in metres.
const NEAR_M: f32 = 0.05;
/// Distance of the camera `follow` behind the person, in heights of the eyes.
const BEHIND: f32 = 2.2;
/// Distance of the camera `eye` before the axis of the body, so that no face is in the picture, in
/// heights of the eyes.
const BEFORE: f32 = 0.12;
/// Distance in heights of the eyes within which such cameras see nothing: people would see the visors
/// of their own caps.
const EYE_NEAR: f32 = 0.15;
/// Half of the time over which the way of a person is averaged for a camera that goes with it.
const SMOOTH_SECS: f64 = 0.6;
/// Half of the time over which it is averaged for the camera `eye`.
const EYE_SMOOTH_SECS: f64 = 0.2;
/// Times at which the way is averaged, to each side of the time that is shown.
const SMOOTH_STEPS: i32 = 8;

/// A camera of a film.
pub(crate) struct Cameras {
    mode: Mode,
    /// A camera that shows all people from the front.
    framed: Camera,
    least_visibility_m: f32,
    /// The time in seconds from which on a camera with positions of its own rests; `None` for one
    /// that is where people are.
    rests_from_secs: Option<f64>,
}

enum Mode {
    Fixed(Camera),
    /// Goes with a person that was in `from` at first.
    Close {
        camera: Camera,
        id: u64,
        from: Vec3,
    },
    Orbit {
        center: Vec3,
        distance: f32,
    },
    Follow {
        id: u64,
    },
    Eye {
        id: u64,
    },
    Keys(keys::Keys),
}

impl Cameras {
    /// Chooses the camera of a view for pictures whose width is `aspect` times their height.
    /// Refuses a person that is not among those of the subject.
    pub(crate) fn new(view: &View, subject: &dyn Subject, aspect: f32) -> Result<Self, Failure> {
        let mut bounds: Vec<Vec3> = subject.bounds().into_iter().map(Vec3::from).collect();
        let framed = match subject.elevation_rad() {
            Some(elevation_rad) => {
                widen(&mut bounds);
                from_above(&bounds, elevation_rad, aspect)
            }
            None => Camera::framing(bounds.iter().map(|point| point.to_array()), aspect),
        };
        let known = |id: &str| {
            let found = subject.find(id).filter(|id| subject.pose(*id, 0.0).is_some());
            found.ok_or_else(|| {
                Failure::usage(format!(
                    "the camera cannot go with {id}: {}",
                    subject.describe_ids()
                ))
            })
        };
        let mode = match view {
            View::Crowd => Mode::Fixed(framed),
            View::Close => Self::close(subject, framed, aspect),
            View::Top => {
                bounds.extend(subject.place().into_iter().map(Vec3::from));
                Mode::Fixed(fit(&bounds, Vec3::Y, Vec3::NEG_Z, TOP_FOV_RAD, aspect))
            }
            View::Iso => {
                let back = elevated(TAU / 8.0, ISO_ELEVATION_RAD);
                Mode::Fixed(fit(&bounds, back, Vec3::Y, ISO_FOV_RAD, aspect))
            }
            View::Orbit => Self::orbit(&bounds, aspect),
            View::At { eye, target } => {
                let [from, to] = [*eye, *target].map(Vec3::from);
                let (up, far) = (upright(to - from).to_array(), far_m(&framed, from, to));
                Mode::Fixed(Camera { eye: *eye, target: *target, up, near: NEAR_M, far, ..framed })
            }
            View::Follow { id } => Mode::Follow { id: known(id)? },
            View::Eye { id } => Mode::Eye { id: known(id)? },
            View::Keys(keys) => Mode::Keys(keys.clone()),
            View::Named { name } => {
                return Err(Failure::usage(format!(
                    "there is no camera \"{name}\": only scene files name cameras; write crowd, \
                     close, top, iso, orbit, follow:ID, eye:ID, the path of a .toml file, or the \
                     positions of camera and target"
                )));
            }
        };
        let framed_m = Vec3::from(framed.eye).distance(framed.target.into());
        let least_visibility_m = match (view, &mode) {
            (View::Top | View::Iso, _) => f32::INFINITY,
            (_, Mode::Orbit { distance, .. }) => VISIBILITY * distance,
            (View::Crowd, _) => VISIBILITY * framed_m,
            _ => 0.0,
        };
        let rests_from_secs = match view {
            View::At { .. } => Some(0.0),
            View::Keys(keys) => Some(keys.last_secs()),
            _ => None,
        };
        Ok(Self { mode, framed, least_visibility_m, rests_from_secs })
    }

    /// Returns true for a camera with positions of its own, which may be anywhere.
    pub(crate) fn is_placed(&self) -> bool {
        self.rests_from_secs.is_some()
    }

    /// Returns the least distance of visibility in metres; 0 for cameras among people. Cameras far
    /// enough away to show everybody would see only haze.
    pub(crate) fn least_visibility_m(&self) -> f32 {
        self.least_visibility_m
    }

    /// Returns `secs`, or a time just before the first cut after `start` if that is earlier: all
    /// pictures of a frame with motion blur are taken from the shot that it begins in.
    pub(crate) fn within_shot(&self, start: f64, secs: f64) -> f64 {
        let Mode::Keys(keys) = &self.mode else { return secs };
        keys.cut_between(start, secs).map_or(secs, f64::next_down)
    }

    /// Returns the person that the camera goes with.
    pub(crate) fn person(&self) -> Option<u64> {
        match &self.mode {
            Mode::Close { id, .. } | Mode::Follow { id } | Mode::Eye { id } => Some(*id),
            Mode::Fixed(_) | Mode::Orbit { .. } | Mode::Keys(_) => None,
        }
    }

    /// Returns the camera at a time in seconds since frame 0. `poses` are those of
    /// [`person`](Self::person).
    pub(crate) fn at(&self, poses: &Poses<'_>, secs: f64) -> Camera {
        match &self.mode {
            Mode::Fixed(camera) => *camera,
            Mode::Close { camera, from, .. } => {
                let walked = smoothed(poses, secs, SMOOTH_SECS)
                    .map_or(Vec3::ZERO, |pose| Vec3::from(pose.position) - *from);
                let [eye, target] =
                    [camera.eye, camera.target].map(|at| (Vec3::from(at) + walked).to_array());
                Camera { eye, target, ..*camera }
            }
            Mode::Orbit { center, distance } => {
                let turns = single((secs / ORBIT_SECS).fract());
                let eye = *center + *distance * elevated(TAU * turns, ORBIT_ELEVATION_RAD);
                self.looking(eye, *center, ORBIT_FOV_RAD)
            }
            Mode::Follow { .. } => self.follow(poses, secs),
            Mode::Eye { .. } => self.eye(poses, secs),
            Mode::Keys(keys) => {
                let key = keys.at(secs);
                let [from, to] = [key.from, key.to].map(|at| Vec3::from(at.map(single)));
                self.looking(from, to, single(key.fov_deg).to_radians())
            }
        }
    }

    /// Returns a camera among people, with the haze of the framed one or less.
    fn looking(&self, eye: Vec3, target: Vec3, fov_y_rad: f32) -> Camera {
        let up = upright(target - eye).to_array();
        let far = far_m(&self.framed, eye, target);
        Camera { eye: eye.to_array(), target: target.to_array(), up, fov_y_rad, near: NEAR_M, far }
    }

    fn close(subject: &dyn Subject, framed: Camera, aspect: f32) -> Mode {
        let Some(id) = subject.closest() else { return Mode::Fixed(framed) };
        let Some(Pose { position: [x, y, z], .. }) = subject.pose(id, 0.0) else {
            return Mode::Fixed(framed);
        };
        let figure_m = subject.figure_m();
        let camera = match subject.elevation_rad() {
            // From above, so that no wall before the person hides it.
            Some(elevation_rad) => {
                let around = figure([x, y, z], figure_m).map(Vec3::from);
                fit(&around, elevated(0.0, elevation_rad), Vec3::Y, ABOVE_FOV_RAD, aspect)
            }
            None => {
                let [height, half] = figure_m;
                let sides = [[x - half, y, z], [x + half, y, z], [x, y, z + half]];
                Camera::framing(sides.into_iter().chain([[x, y + height, z]]), aspect)
            }
        };
        Mode::Close { camera, id, from: Vec3::new(x, y, z) }
    }

    fn orbit(bounds: &[Vec3], aspect: f32) -> Mode {
        let low = bounds.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = bounds.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let center = 0.5 * (low + high);
        let direction = |number: u8| {
            let share = f32::from(number) / f32::from(ORBIT_DIRECTIONS);
            elevated(TAU * share, ORBIT_ELEVATION_RAD)
        };
        let distance = |back: Vec3| fit::distance(bounds, center, back, ORBIT_FOV_RAD, aspect);
        let distance = (0..ORBIT_DIRECTIONS).map(direction).map(distance).fold(1.0, f32::max);
        Mode::Orbit { center, distance }
    }

    fn follow(&self, poses: &Poses<'_>, secs: f64) -> Camera {
        let Some(pose) = smoothed(poses, secs, SMOOTH_SECS) else { return self.framed };
        let (feet, forward, eye_m) = (Vec3::from(pose.position), pose.forward(), pose.eye_m);
        let eye = feet - BEHIND * eye_m * forward + 1.35 * eye_m * Vec3::Y;
        let target = feet + eye_m * forward + 0.7 * eye_m * Vec3::Y;
        self.looking(eye, target, FOLLOW_FOV_RAD)
    }

    fn eye(&self, poses: &Poses<'_>, secs: f64) -> Camera {
        let Some(pose) = smoothed(poses, secs, EYE_SMOOTH_SECS) else { return self.framed };
        let (feet, forward, eye_m) = (Vec3::from(pose.position), pose.forward(), pose.eye_m);
        let eye = feet + eye_m * (Vec3::Y + BEFORE * forward);
        // People look slightly down as they walk.
        let camera = self.looking(eye, eye + forward - 0.06 * Vec3::Y, EYE_FOV_RAD);
        Camera { near: EYE_NEAR * eye_m, ..camera }
    }
}

/// Returns the distance of the far plane for an eye and its target: haze hides neither the target
/// nor the people that a camera frames.
fn far_m(framed: &Camera, eye: Vec3, target: Vec3) -> f32 {
    framed.far.max(12.0 * eye.distance(target))
}

/// Adds the ground around points that cover less than a square of [`LEAST_M`], so that one person is
/// not alone in the picture.
fn widen(points: &mut Vec<Vec3>) {
    let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
    if (high.x - low.x).max(high.z - low.z) < LEAST_M {
        let middle = (0.5 * (low + high)).with_y(low.y);
        let sides = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z];
        points.extend(sides.map(|side| middle + 0.5 * LEAST_M * side));
    }
}

/// Returns a camera that shows all points from an elevation. The longer side of what they cover goes
/// across the picture.
fn from_above(points: &[Vec3], elevation_rad: f32, aspect: f32) -> Camera {
    let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
    let angle_rad = if high.x - low.x >= high.z - low.z { 0.0 } else { FRAC_PI_2 };
    fit(points, elevated(angle_rad, elevation_rad), Vec3::Y, ABOVE_FOV_RAD, aspect)
}

/// Returns the mean pose of a person around a time, which moves without bobbing and turns without
/// jerks.
fn smoothed(poses: &Poses<'_>, secs: f64, half_secs: f64) -> Option<Pose> {
    let (mut position, mut forward, mut eye_m, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0);
    for step in -SMOOTH_STEPS..=SMOOTH_STEPS {
        let at = secs + half_secs * f64::from(step) / f64::from(SMOOTH_STEPS);
        let pose = pose_at(poses, at)?;
        position += Vec3::from(pose.position);
        forward += pose.forward();
        eye_m += pose.eye_m;
        count += 1.0;
    }
    let heading_rad = forward.x.atan2(forward.z);
    Some(Pose { position: (position / count).to_array(), heading_rad, eye_m: eye_m / count })
}

/// Returns a pose at any time. Before frame 0, people come as they go on after it.
fn pose_at(poses: &Poses<'_>, secs: f64) -> Option<Pose> {
    if secs >= 0.0 {
        return poses(secs);
    }
    let [first, mirrored] = [poses(0.0)?, poses(-secs)?];
    let position = 2.0 * Vec3::from(first.position) - Vec3::from(mirrored.position);
    Some(Pose { position: position.to_array(), ..first })
}

#[cfg(test)]
mod tests;
