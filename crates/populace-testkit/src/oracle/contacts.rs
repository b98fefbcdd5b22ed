//! Contacts of clips: when a foot stands, mixed from the clips of the lowest layer.
//!
//! For one clip the time to the nearest end of a contact says by its sign whether the foot stands.
//! For several it is the mean of these times by weight, so that the ends of contacts move between
//! those of the clips. Clips in which the foot always stands count only if nearly all are such.

use populace_device::layout::{CONTACT_WHOLE, FOOT_NEAR_SECS, FOOT_STEPPING};

use super::noise::Noise;

/// A clip that plays on the lowest layer, and what it does with one foot.
#[derive(Clone, Debug)]
pub struct OracleSteps {
    /// The clip's weight, above 0.
    pub weight: f64,
    /// Time since the clip's start, and the size of the numbers that it is a difference of.
    pub secs: [f64; 2],
    /// The length of the clip.
    pub cycle_secs: f64,
    /// Times of touchdown and lift-off.
    pub contacts: Vec<[f64; 2]>,
}

impl OracleSteps {
    fn always_stands(&self) -> bool {
        let whole = f64::from(CONTACT_WHOLE) * self.cycle_secs;
        self.contacts.iter().any(|[from, until]| until - from >= whole)
    }

    /// Returns the time to the nearest end of a contact: positive within, at most
    /// `FOOT_NEAR_SECS` in size.
    fn secs_within(&self, noise: &mut Noise) -> f64 {
        let [secs, size] = self.secs;
        let secs = noise.near(secs, size + self.cycle_secs);
        let near = f64::from(FOOT_NEAR_SECS);
        let of_contact = |[from, until]: &[f64; 2]| {
            // The cycles before and after this one have the same contacts.
            let in_cycle = |cycle: f64| {
                let secs = secs + cycle * self.cycle_secs;
                (secs - from).min(until - secs)
            };
            [-1.0, 0.0, 1.0].map(in_cycle).into_iter().fold(f64::NEG_INFINITY, f64::max)
        };
        self.contacts.iter().map(of_contact).fold(-near, f64::max).min(near)
    }
}

/// Returns the time from the nearest end of a contact that all clips agree on; positive within a
/// contact. `None` if no clip knows its contacts.
pub(super) fn secs_within(clips: &[OracleSteps], noise: &mut Noise) -> Option<f64> {
    let (mut steps, mut stands, mut within) = (0.0, 0.0, 0.0);
    for clip in clips {
        let weight = noise.number(clip.weight);
        if clip.always_stands() {
            stands += weight;
        } else {
            steps += weight;
            within += weight * clip.secs_within(noise);
        }
    }
    let total = steps + stands;
    let all_stand = steps <= f64::from(FOOT_STEPPING) * total;
    (total > 0.0).then(|| if all_stand { f64::from(FOOT_NEAR_SECS) } else { within / steps })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn within(secs: f64, contacts: &[[f64; 2]]) -> OracleSteps {
        OracleSteps { weight: 0.5, secs: [secs, 0.0], cycle_secs: 1.0, contacts: contacts.to_vec() }
    }

    #[test]
    fn contacts_are_mixed_and_go_on_through_the_end_of_a_cycle() {
        let of = |clips: &[OracleSteps]| secs_within(clips, &mut Noise::none());
        let is = |clips: &[OracleSteps], wanted: f64| {
            let got = of(clips).expect("the clips know");
            assert!((got - wanted).abs() < 1e-7, "{got} instead of {wanted}");
        };
        is(&[within(0.05, &[[0.9, 1.15]])], 0.1);
        is(&[within(0.2, &[[0.9, 1.15]])], -0.05);
        is(&[within(0.2, &[[0.9, 1.15]]), within(0.1, &[[0.0, 0.4]])], 0.025);
        is(&[within(0.2, &[[0.9, 1.15]]), within(0.1, &[[0.0, 1.0]])], -0.05);
        is(&[within(0.1, &[[0.0, 1.0]])], f64::from(FOOT_NEAR_SECS));
        is(&[within(0.1, &[])], -f64::from(FOOT_NEAR_SECS));
        assert_eq!(of(&[]), None);
    }
}
