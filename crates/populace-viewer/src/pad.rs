//! The sticks of a gamepad: the left one drives "you", and the right one the camera.

#[cfg(feature = "gamepad")]
mod device;

use glam::Vec2;

use crate::you::Steering;

#[cfg(feature = "gamepad")]
pub(crate) use device::Pads;

/// Share of a stick's way around its middle in which it does nothing, and share at which it is
/// fully pushed: sticks rest beside their middle, and few reach their corners.
const DEAD: f32 = 0.18;
const FULL: f32 = 0.95;
/// Turn of the camera in a second with the stick fully pushed, in heights of the picture to the
/// right and downwards, as of a drag.
const TURN: [f32; 2] = [0.7, 0.45];

/// Where the sticks of a gamepad are, as the device gives it: to the right and upwards, each from
/// -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sticks {
    pub(crate) left: [f32; 2],
    pub(crate) right: [f32; 2],
    /// True while the button that lets "you" run is held.
    pub(crate) runs: bool,
}

impl Sticks {
    /// Returns where the driven member goes.
    pub(crate) fn steering(&self) -> Steering {
        let [right, up] = pushed(self.left);
        Steering { forward: up, left: -right, runs: self.runs }
    }

    /// Returns the turn of the camera in `secs`, in heights of the picture to the right and
    /// downwards, as of a drag. The view goes where the stick is pushed.
    pub(crate) fn turn(&self, secs: f32) -> [f32; 2] {
        let [right, up] = pushed(self.right);
        // A drag takes the picture along, so the view goes the other way.
        [-right * TURN[0] * secs, up * TURN[1] * secs]
    }

    /// Returns true while a stick is pushed.
    pub(crate) fn moves(&self) -> bool {
        pushed(self.left) != [0.0; 2] || pushed(self.right) != [0.0; 2]
    }
}

/// Returns how far a stick is pushed, from 0 to 1 in its direction: nothing in the dead zone, and
/// from its edge on without a jump. A broken value is no push.
fn pushed(stick: [f32; 2]) -> [f32; 2] {
    let length = Vec2::from(stick).length();
    if !length.is_finite() || length <= DEAD {
        return [0.0; 2];
    }
    let way = ((length - DEAD) / (FULL - DEAD)).min(1.0);
    stick.map(|axis| axis / length * way)
}

/// No gamepads: the feature `gamepad` is off.
#[cfg(not(feature = "gamepad"))]
pub(crate) struct Pads;

#[cfg(not(feature = "gamepad"))]
impl Pads {
    /// Opens nothing.
    pub(crate) fn open() -> Self {
        Self
    }

    /// Returns no seconds: there is nothing to wait for.
    pub(crate) fn wait_secs(&self) -> Option<f64> {
        None
    }

    /// Returns sticks at rest.
    pub(crate) fn read(&mut self) -> Sticks {
        Sticks::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(stick: [f32; 2]) -> Steering {
        Sticks { left: stick, ..Sticks::default() }.steering()
    }

    #[test]
    fn sticks_near_their_middle_do_nothing() {
        for stick in [[0.0, 0.0], [0.17, 0.0], [-0.12, 0.12], [f32::NAN, 1.0]] {
            assert_eq!(left(stick), Steering::default(), "{stick:?}");
            let sticks = Sticks { right: stick, ..Sticks::default() };
            assert!(!sticks.moves() && sticks.turn(1.0).iter().all(|by| *by == 0.0), "{stick:?}");
        }
        // The zone is round: two axes within it are beyond it together.
        assert!(left([0.15, 0.15]).forward > 0.0);
    }

    #[test]
    fn pushes_begin_at_the_edge_of_the_dead_zone_and_end_at_one() {
        assert!(left([0.0, 0.2]).forward < 0.04, "no jump at the edge");
        let half = left([0.0, 0.5 * (DEAD + FULL)]).forward;
        assert!((half - 0.5).abs() < 1e-6, "{half}");
        assert_eq!(left([0.0, 1.0]), Steering { forward: 1.0, left: 0.0, runs: false });
        let corner = left([1.0, 1.0]);
        let length = corner.forward.hypot(corner.left);
        assert!((length - 1.0).abs() < 1e-6, "a corner is no farther than a side: {length}");
    }

    #[test]
    fn the_left_stick_steers_and_the_right_one_turns_the_view() {
        assert_eq!(left([0.0, -1.0]).forward, -1.0);
        assert_eq!(left([1.0, 0.0]).left, -1.0);
        let runs = Sticks { left: [0.0, 1.0], runs: true, ..Sticks::default() };
        assert!(runs.steering().runs && runs.turn(1.0).iter().all(|by| *by == 0.0));
        let right = Sticks { right: [1.0, 0.0], ..Sticks::default() };
        assert_eq!(right.steering(), Steering::default());
        assert_eq!(right.turn(0.5), [-0.5 * TURN[0], 0.0]);
        assert_eq!(Sticks { right: [0.0, 1.0], ..right }.turn(0.5), [0.0, 0.5 * TURN[1]]);
    }
}
