//! Samples of planted soles, and what they sum up to.

use super::Skate;

/// Samples of one part of the course.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Speeds of planted points in the world, in metres per second.
    pub(super) speeds: Vec<f32>,
    /// Distances of planted points from the ground, in metres.
    pub(super) heights_m: Vec<f32>,
    /// Feet of all frames, and those that are planted.
    pub(super) feet: f32,
    pub(super) planted: f32,
    /// The speed of the body, in metres per second.
    pub(super) body_m_per_sec: f32,
    /// Speeds at which the ground passes planted points backwards, in metres per second.
    pub(super) passing: Vec<f32>,
    /// See [`Skate::speed_error`].
    pub(super) speed_error: f32,
    /// The largest acceleration in metres per second squared.
    pub(super) acceleration: f32,
}

impl Samples {
    pub(super) fn add(&mut self, other: &Self) {
        self.speeds.extend(&other.speeds);
        self.heights_m.extend(&other.heights_m);
        self.feet += other.feet;
        self.planted += other.planted;
        self.speed_error = self.speed_error.max(other.speed_error);
        self.acceleration = self.acceleration.max(other.acceleration);
    }

    /// Finds the error of its speeds against the requested one, in metres per second.
    pub(super) fn hold_to(&mut self, requested: f32) {
        let error = |speed: f32| (speed / requested - 1.0).abs();
        let gait = percentile(&mut self.passing, 50);
        self.speed_error = error(self.body_m_per_sec).max(error(gait));
    }

    /// Sums up a segment with or without planting, for a body of a height and clips with an
    /// acceleration of their own.
    pub(super) fn sum_up(
        mut self,
        (segment, planting): (&'static str, bool),
        height_m: f32,
        own_acceleration: f32,
    ) -> Skate {
        let count = (self.speeds.len() as f32).max(1.0);
        let share = |of: f32, whole: f32| if whole > 0.0 { of / whole } else { 0.0 };
        Skate {
            segment,
            planting,
            mean_m_per_sec: self.speeds.iter().sum::<f32>() / count,
            p95_m_per_sec: percentile(&mut self.speeds, 95),
            speed_error: self.speed_error,
            sole_error: share(percentile(&mut self.heights_m, 95), height_m),
            acceleration_ratio: share(self.acceleration, own_acceleration),
            contact_share: share(self.planted, self.feet),
        }
    }
}

/// Returns the value below which a percentage of all values is; 0 of none. Sorts them.
pub(super) fn percentile(values: &mut [f32], percent: usize) -> f32 {
    values.sort_by(f32::total_cmp);
    let at = (values.len() * percent / 100).min(values.len().saturating_sub(1));
    values.get(at).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_sorted_values() {
        assert!(percentile(&mut [], 95) == 0.0);
        assert!(percentile(&mut [2.0], 95) == 2.0);
        let mut values: Vec<f32> = (0..100_u8).rev().map(f32::from).collect();
        assert!(percentile(&mut values, 50) == 50.0 && percentile(&mut values, 95) == 95.0);
    }

    #[test]
    fn the_larger_error_of_two_speeds_counts() {
        let mut samples =
            Samples { body_m_per_sec: 2.0, passing: vec![3.0, 1.0, 2.2], ..Samples::default() };
        samples.hold_to(2.0);
        assert!((samples.speed_error - 0.1).abs() < 1e-6);
        samples.body_m_per_sec = 1.5;
        samples.hold_to(2.0);
        assert!((samples.speed_error - 0.25).abs() < 1e-6);
    }

    #[test]
    fn a_part_sums_up_its_samples_and_all_of_it_the_worst() {
        let mut part = Samples {
            speeds: vec![0.0, 0.4],
            heights_m: vec![0.1],
            feet: 4.0,
            planted: 3.0,
            speed_error: 0.1,
            acceleration: 3.0,
            ..Samples::default()
        };
        let other = Samples { speeds: vec![0.2], feet: 2.0, acceleration: 6.0, ..part.clone() };
        part.add(&other);
        let skate = part.sum_up(("all", true), 2.0, 2.0);
        assert!((skate.mean_m_per_sec - 0.2).abs() < 1e-6 && skate.p95_m_per_sec == 0.4);
        assert!((skate.sole_error, skate.acceleration_ratio) == (0.05, 3.0));
        assert!((skate.contact_share, skate.speed_error) == (1.0, 0.1), "{skate:?}");
    }
}
