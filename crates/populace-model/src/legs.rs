//! Legs of a skeleton at rest.

use crate::{JointIndex, Skeleton};

/// How far ahead of the hip or behind it the middle of a step is at most, in leg lengths.
const ASIDE: f64 = 0.1;

impl Skeleton {
    /// The length of a leg from hip over knee to ankle, in metres.
    #[must_use]
    pub fn leg_length_m(&self, [hip, knee, ankle]: [JointIndex; 3]) -> f64 {
        let [hip, knee, ankle] = [hip, knee, ankle].map(|joint| self.rest_place(joint));
        hip.distance(knee) + knee.distance(ankle)
    }

    /// Where the middle of a leg's steps is along Z, in metres of model space, for a leg of hip,
    /// knee and ankle: where the ankle is at rest, but at most a tenth of the leg's length from the
    /// hip. A body whose legs rest farther ahead or behind does not stand so.
    #[must_use]
    pub fn middle_of_steps_z(&self, leg: [JointIndex; 3]) -> f64 {
        let most = ASIDE * self.leg_length_m(leg);
        let [hip, _, ankle] = leg.map(|joint| self.rest_place(joint).z);
        if (ankle - hip).abs() <= most { ankle } else { hip + most.copysign(ankle - hip) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{JointSource, Trs};

    /// Returns a leg of 1 m whose ankle rests at a z.
    fn middle(ankle_z: f32) -> f64 {
        let joint = |name: &str, parent, translation| JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation, ..Trs::IDENTITY },
        };
        let sources = [
            joint("hip", None, [0.0, 1.0, 0.25]),
            joint("knee", Some(0), [0.0, -0.5, 0.0]),
            joint("ankle", Some(1), [0.0, -0.3, ankle_z - 0.25]),
        ];
        let skeleton = Skeleton::new(&sources).unwrap();
        let leg = [0, 1, 2].map(|nth| skeleton.joint_from_source(nth));
        let length = 0.5 + f64::from(0.3_f32.hypot(ankle_z - 0.25));
        assert!((skeleton.leg_length_m(leg) - length).abs() < 1e-6);
        skeleton.middle_of_steps_z(leg)
    }

    #[test]
    fn steps_are_about_the_ankle_at_rest_and_not_far_from_beneath_the_hip() {
        assert!((middle(0.2) - 0.2).abs() < 1e-6);
        assert!((middle(0.3) - 0.3).abs() < 1e-6);
        assert!((middle(-0.15) - (0.25 - 0.1)).abs() < 1e-6);
        assert!((middle(0.65) - (0.25 + 0.1)).abs() < 1e-6);
    }
}
