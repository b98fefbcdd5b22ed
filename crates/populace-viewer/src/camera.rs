//! Cameras that people move: around a point, through the air, behind a member.
#![expect(clippy::disallowed_methods, reason = "angles of the host alone; no device computes them")]

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;
use populace_render::Camera;

/// Highest and lowest direction of view, short of straight up and down, in radians.
const STEEPEST_RAD: f32 = FRAC_PI_2 - 0.02;
/// Turn of a drag over a whole height of the picture, in radians.
const TURN_RAD: f32 = 3.0;
/// Distances of a camera from what it goes round, in metres.
const DISTANCES_M: [f32; 2] = [0.3, 5000.0];
/// Factor of the distance for one notch of the wheel.
const NOTCH: f32 = 0.88;
/// Distance of the near plane in metres.
const NEAR_M: f32 = 0.05;
/// Distance behind a member and height above its feet, in heights of it.
const FOLLOW: [f32; 2] = [2.4, 0.75];
/// Time in which a camera comes up with a member that it follows, in seconds.
const FOLLOW_SECS: f32 = 0.25;

/// Ways to move a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The camera of the show.
    #[default]
    Shown,
    /// Goes round a point.
    Orbit,
    /// Flies.
    Fly,
    /// Goes with a member.
    Follow,
}

impl Mode {
    pub(crate) const ALL: [Self; 4] = [Self::Shown, Self::Orbit, Self::Fly, Self::Follow];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Shown => "As given",
            Self::Orbit => "Orbit",
            Self::Fly => "Fly",
            Self::Follow => "Follow",
        }
    }
}

/// A member that a camera follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Followed {
    /// The ground between the feet in metres.
    pub(crate) feet: Vec3,
    pub(crate) yaw_rad: f32,
    pub(crate) height_m: f32,
}

/// A camera and how it moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rig {
    mode: Mode,
    /// The point in the middle of the picture in metres.
    target: Vec3,
    /// Heading of the view about +Y, and its elevation, in radians.
    yaw_rad: f32,
    pitch_rad: f32,
    distance_m: f32,
    /// Heading of the follower behind the member's own, in radians.
    follow_yaw_rad: f32,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            mode: Mode::Shown,
            target: Vec3::Y,
            yaw_rad: 0.0,
            pitch_rad: 0.0,
            distance_m: 5.0,
            follow_yaw_rad: 0.0,
        }
    }
}

impl Rig {
    pub(crate) fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the heading of the view in radians; 0 looks along +Z.
    pub(crate) fn yaw_rad(&self) -> f32 {
        self.yaw_rad
    }

    /// Changes the way to move; the picture stays where it is. `shown` is the camera of the show.
    pub(crate) fn set_mode(&mut self, mode: Mode, shown: &Camera) {
        if self.mode == Mode::Shown && mode != Mode::Shown {
            self.take(shown);
        }
        self.mode = mode;
    }

    /// Takes over a camera. It goes round the point where its view meets the ground, or its
    /// target if that is nearer.
    fn take(&mut self, camera: &Camera) {
        let [eye, target] = [camera.eye, camera.target].map(Vec3::from);
        let Some(forward) = (target - eye).try_normalize() else { return };
        self.yaw_rad = forward.x.atan2(forward.z);
        self.pitch_rad = forward.y.clamp(-1.0, 1.0).asin().clamp(-STEEPEST_RAD, STEEPEST_RAD);
        let to_ground = if forward.y < -1e-3 { (1.0 - eye.y) / forward.y } else { f32::MAX };
        let to_target = eye.distance(target);
        let [least, most] = DISTANCES_M;
        self.distance_m = to_target.min(to_ground.max(least)).clamp(least, most);
        self.target = eye + self.forward() * self.distance_m;
    }

    fn forward(&self) -> Vec3 {
        let level = self.pitch_rad.cos();
        Vec3::new(self.yaw_rad.sin() * level, self.pitch_rad.sin(), self.yaw_rad.cos() * level)
    }

    fn right(&self) -> Vec3 {
        Vec3::new(-self.yaw_rad.cos(), 0.0, self.yaw_rad.sin())
    }

    /// Turns by a drag, in heights of the picture to the right and downwards.
    pub(crate) fn turn(&mut self, [right, down]: [f32; 2], shown: &Camera) {
        if self.mode == Mode::Shown {
            self.set_mode(Mode::Orbit, shown);
        }
        let pitch_rad = (self.pitch_rad - TURN_RAD * down).clamp(-STEEPEST_RAD, STEEPEST_RAD);
        match self.mode {
            // The eye stays where it is.
            Mode::Fly => {
                let eye = self.eye();
                self.yaw_rad = wrapped(self.yaw_rad - TURN_RAD * right);
                self.pitch_rad = pitch_rad;
                self.target = eye + self.forward() * self.distance_m;
            }
            Mode::Follow => {
                self.follow_yaw_rad = wrapped(self.follow_yaw_rad - TURN_RAD * right);
                self.pitch_rad = pitch_rad;
            }
            Mode::Shown | Mode::Orbit => {
                self.yaw_rad = wrapped(self.yaw_rad - TURN_RAD * right);
                self.pitch_rad = pitch_rad;
            }
        }
    }

    /// Moves the picture by a drag, in heights of the picture to the right and downwards, so that
    /// what is in its middle stays under the pointer.
    pub(crate) fn pan(&mut self, [right, down]: [f32; 2], shown: &Camera) {
        if matches!(self.mode, Mode::Shown | Mode::Follow) {
            self.set_mode(Mode::Orbit, shown);
        }
        let height_m = 2.0 * self.distance_m * (0.5 * shown.fov_y_rad).tan();
        let up = self.right().cross(self.forward());
        self.target += (up * down - self.right() * right) * height_m;
    }

    /// Comes nearer by notches of the wheel.
    pub(crate) fn zoom(&mut self, notches: f32, shown: &Camera) {
        if self.mode == Mode::Shown {
            self.set_mode(Mode::Orbit, shown);
        }
        let [least, most] = DISTANCES_M;
        if self.mode == Mode::Fly {
            let way = self.forward() * notches * 0.1 * self.distance_m.clamp(1.0, 50.0);
            self.target += way;
        } else {
            self.distance_m = (self.distance_m * NOTCH.powf(notches)).clamp(least, most);
        }
    }

    /// Flies by metres to the right, upwards and forwards.
    pub(crate) fn fly(&mut self, [right, up, forward]: [f32; 3], shown: &Camera) {
        if self.mode != Mode::Fly {
            self.set_mode(Mode::Fly, shown);
        }
        self.target += self.right() * right + Vec3::Y * up + self.forward() * forward;
    }

    /// Looks at a sphere and goes round it.
    pub(crate) fn frame(&mut self, center: Vec3, radius_m: f32, shown: &Camera) {
        if self.mode == Mode::Shown {
            self.take(shown);
        }
        self.mode = Mode::Orbit;
        self.target = center;
        let [least, most] = DISTANCES_M;
        let distance_m = 1.25 * radius_m / (0.5 * shown.fov_y_rad).sin().max(0.05);
        self.distance_m = distance_m.clamp(least, most);
    }

    /// Goes on for `secs` behind a member.
    pub(crate) fn follow(&mut self, member: &Followed, secs: f32) {
        if self.mode != Mode::Follow {
            return;
        }
        let share = 1.0 - (-secs / FOLLOW_SECS).exp();
        let [behind, height] = FOLLOW;
        let target = member.feet + Vec3::Y * height * member.height_m;
        let wanted_rad = member.yaw_rad + self.follow_yaw_rad;
        self.yaw_rad = wrapped(self.yaw_rad + wrapped(wanted_rad - self.yaw_rad) * share);
        // A member that is far away is cut to.
        let far = self.target.distance(target) > 20.0;
        self.target = if far { target } else { self.target.lerp(target, share) };
        if far || self.distance_m > 12.0 * member.height_m {
            self.distance_m = behind * member.height_m;
            self.pitch_rad = -0.18;
        }
    }

    /// Begins to follow: at a distance that shows a member, from behind.
    pub(crate) fn begin_to_follow(&mut self, member: &Followed, shown: &Camera) {
        self.set_mode(Mode::Follow, shown);
        let [behind, height] = FOLLOW;
        self.target = member.feet + Vec3::Y * height * member.height_m;
        (self.yaw_rad, self.follow_yaw_rad, self.pitch_rad) = (member.yaw_rad, 0.0, -0.18);
        self.distance_m = behind * member.height_m;
    }

    fn eye(&self) -> Vec3 {
        self.target - self.forward() * self.distance_m
    }

    /// Returns the camera. Field of view and haze are those of the camera of the show.
    pub(crate) fn camera(&self, shown: &Camera) -> Camera {
        if self.mode == Mode::Shown {
            return *shown;
        }
        Camera {
            eye: self.eye().to_array(),
            target: (self.eye() + self.forward()).to_array(),
            up: [0.0, 1.0, 0.0],
            fov_y_rad: shown.fov_y_rad,
            near: NEAR_M.min(0.1 * self.distance_m),
            far: shown.far.max(12.0 * self.distance_m),
        }
    }
}

/// Returns an angle from -pi to pi.
fn wrapped(angle_rad: f32) -> f32 {
    (angle_rad + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown() -> Camera {
        Camera { eye: [1.0, 2.0, 8.0], target: [0.0, 1.0, 0.0], ..Camera::default() }
    }

    fn direction(camera: &Camera) -> Vec3 {
        (Vec3::from(camera.target) - Vec3::from(camera.eye)).normalize()
    }

    #[test]
    fn the_picture_stays_when_a_camera_is_taken() {
        for mode in [Mode::Orbit, Mode::Fly] {
            let mut rig = Rig::default();
            rig.set_mode(mode, &shown());
            let taken = rig.camera(&shown());
            assert!(Vec3::from(taken.eye).distance(Vec3::from(shown().eye)) < 1e-3, "{taken:?}");
            assert!(direction(&taken).distance(direction(&shown())) < 1e-4, "{taken:?}");
        }
    }

    #[test]
    fn orbits_keep_their_distance_and_flights_their_place() {
        let mut rig = Rig::default();
        rig.turn([0.3, 0.1], &shown());
        let camera = rig.camera(&shown());
        let distance = |camera: &Camera| Vec3::from(camera.eye).distance(rig.target);
        assert_eq!(rig.mode(), Mode::Orbit);
        assert!((distance(&camera) - rig.distance_m).abs() < 1e-3);
        rig.set_mode(Mode::Fly, &shown());
        let before = rig.camera(&shown());
        rig.turn([0.2, -0.1], &shown());
        let after = rig.camera(&shown());
        assert!(Vec3::from(before.eye).distance(Vec3::from(after.eye)) < 1e-3);
        assert!(direction(&before).distance(direction(&after)) > 0.1);
    }

    /// A drag to the right moves what is in the middle to the right.
    #[test]
    fn what_is_dragged_stays_under_the_pointer() {
        let mut rig = Rig::default();
        rig.set_mode(Mode::Orbit, &shown());
        let middle = rig.target;
        rig.pan([0.1, 0.2], &shown());
        let at = rig.camera(&shown()).project(middle.to_array(), [1000, 1000]).expect("in view");
        assert!((at[0] - 600.0).abs() < 1.0 && (at[1] - 700.0).abs() < 1.0, "{at:?}");
    }

    #[test]
    fn followers_come_up_with_their_member() {
        let mut rig = Rig::default();
        let mut member = Followed { feet: Vec3::ZERO, yaw_rad: 0.0, height_m: 1.8 };
        rig.begin_to_follow(&member, &shown());
        assert!(Vec3::from(rig.camera(&shown()).eye).z < -3.0, "behind");
        for _ in 0..90 {
            member.feet.z += 1.4 / 30.0;
            rig.follow(&member, 1.0 / 30.0);
        }
        let behind_m = member.feet.z - rig.camera(&shown()).eye[2];
        assert!((4.0..5.5).contains(&behind_m), "{behind_m}");
    }
}
