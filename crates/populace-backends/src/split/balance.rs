//! The shares of the members that devices take.

/// The fraction of the way towards the measured optimum that shares move per frame. They approach
/// from one side without oscillation, although the speeds are one frame old: below 3 - 2 * sqrt(2)
/// = 0.17 even if times grow with the square of the members.
const PACE: f64 = 1.0 / 6.0;
/// The least share of a measured device, however slow it is.
const LEAST: f64 = 1.0 / 256.0;

/// Shares whose sum is 1.
pub(crate) struct Balance {
    shares: Vec<f64>,
    /// The speeds of each device; empty for fixed shares.
    speeds: Vec<Speeds>,
    /// Whether a frame has been measured. The first touches new memory and is not representative.
    is_warm: bool,
}

/// The last three speeds of a device, in members per millisecond.
#[derive(Clone, Copy, Default)]
struct Speeds {
    last: [f64; 3],
    count: usize,
}

impl Speeds {
    fn add(&mut self, speed: f64) {
        if self.count == 0 {
            self.last = [speed; 3];
        }
        self.last[self.count % 3] = speed;
        self.count += 1;
    }

    /// The median, so that a single delayed frame changes nothing.
    fn middle(mut self) -> f64 {
        self.last.sort_by(f64::total_cmp);
        self.last[1]
    }
}

impl Balance {
    /// Returns fixed shares for `count` devices, or shares that follow measured speed.
    pub(crate) fn new(count: usize, fixed: Option<Vec<f64>>) -> Self {
        let speeds = if fixed.is_some() { Vec::new() } else { vec![Speeds::default(); count] };
        let shares = fixed.unwrap_or_else(|| vec![1.0 / count as f64; count]);
        Self { shares, speeds, is_warm: false }
    }

    pub(crate) fn shares(&self) -> &[f64] {
        &self.shares
    }

    pub(crate) fn is_fixed(&self) -> bool {
        self.speeds.is_empty()
    }

    /// Returns the ends of the devices' ranges of `all` members. With measured shares each device
    /// has a member, as long as there are enough: a device without members shows no speed.
    pub(crate) fn ends(&self, all: usize) -> Vec<usize> {
        let count = self.shares.len();
        let least = usize::from(!self.is_fixed() && all >= count);
        let (mut share, mut first) = (0.0, 0);
        let end_of = |(index, own): (usize, &f64)| {
            share += own;
            let later = count - 1 - index;
            first = nth_of(share, all).clamp(first + least, all - later * least);
            first
        };
        self.shares.iter().enumerate().map(end_of).collect()
    }

    /// Takes the members and milliseconds of each device in a frame. A frame in which any time is
    /// unknown changes nothing.
    pub(crate) fn measured(&mut self, work: impl Iterator<Item = (usize, Option<f64>)> + Clone) {
        let speed = |(members, ms): (usize, Option<f64>)| Some(members as f64 / ms?);
        let is_known =
            |speed: Option<f64>| speed.is_some_and(|speed| speed.is_finite() && speed > 0.0);
        if self.is_fixed() || !work.clone().map(speed).all(is_known) {
            return;
        }
        if !std::mem::replace(&mut self.is_warm, true) {
            return;
        }
        for (speeds, speed) in self.speeds.iter_mut().zip(work.filter_map(speed)) {
            speeds.add(speed);
        }
        let all: f64 = self.speeds.iter().map(|speeds| speeds.middle()).sum();
        for (share, speeds) in self.shares.iter_mut().zip(&self.speeds) {
            *share = (*share + PACE * (speeds.middle() / all - *share)).max(LEAST);
        }
        let total: f64 = self.shares.iter().sum();
        self.shares.iter_mut().for_each(|share| *share /= total);
    }
}

/// Returns the number of members of a share.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "shares lie between 0 and 1, and there are less than 2^32 members"
)]
fn nth_of(share: f64, all: usize) -> usize {
    ((share * all as f64).round() as usize).min(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMBERS: f64 = 10_000.0;

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "shares of ten thousand members"
    )]
    fn work(shares: &[f64], ms: &[f64]) -> impl Iterator<Item = (usize, Option<f64>)> + Clone {
        shares.iter().zip(ms).map(|(share, ms)| ((share * MEMBERS) as usize, Some(*ms)))
    }

    /// Returns the share of the first device after each frame. `times` gives the milliseconds that
    /// each device takes for its share in a frame.
    fn course(frames: usize, times: &mut dyn FnMut(&[f64], usize) -> Vec<f64>) -> Vec<f64> {
        let mut balance = Balance::new(times(&[0.5, 0.5], 0).len(), None);
        (0..frames)
            .map(|frame| {
                let shares = balance.shares().to_vec();
                let ms = times(&shares, frame);
                balance.measured(work(&shares, &ms));
                let total: f64 = balance.shares().iter().sum();
                assert!((total - 1.0).abs() < 1e-12, "{:?}", balance.shares());
                balance.shares()[0]
            })
            .collect()
    }

    /// Asserts that a share approaches a value from one side and stays there.
    #[track_caller]
    fn assert_converges(course: &[f64], wanted: f64) {
        let last = course[course.len() - 1];
        assert!(
            (last - wanted).abs() < 2e-3,
            "the share is {last} instead of {wanted}: {course:?}"
        );
        for (frame, pair) in course.windows(2).enumerate() {
            let (before, after) = (pair[0] - wanted, pair[1] - wanted);
            // The number of members is rounded.
            let far = before.abs() > 1e-3;
            assert!(
                !far || after * before >= 0.0 && after.abs() <= before.abs(),
                "frame {frame}: {course:?}"
            );
        }
    }

    #[test]
    fn times_become_equal_without_oscillation() {
        // Times proportional to the share.
        assert_converges(&course(70, &mut |s, _| vec![s[0] * 30.0, s[1] * 10.0]), 0.25);
        assert_converges(&course(70, &mut |s, _| vec![s[0] * 1.0, s[1] * 49.0]), 0.98);
        // With a constant overhead per device: 1 + 8 x = 3 + 4 (1 - x).
        assert_converges(&course(90, &mut |s, _| vec![1.0 + s[0] * 8.0, 3.0 + s[1] * 4.0]), 0.5);
        assert_converges(&course(200, &mut |s, _| vec![s[0] * 8.0, 4.0 + s[1] * 1.0]), 5.0 / 9.0);
        // Quadratic times, as if caches overflow: 4 x^2 = (1 - x)^2.
        assert_converges(&course(90, &mut |s, _| vec![s[0] * s[0] * 4.0, s[1] * s[1]]), 1.0 / 3.0);
        // Two devices on one core: the one with less work takes twice its time, the other finishes
        // when all work is done.
        let on_one_core = |s: &[f64], _: usize| {
            let work = [s[0] * 10.0, s[1] * 6.0];
            work.iter().map(|w| (2.0 * w).min(work[0] + work[1])).collect()
        };
        assert_converges(&course(90, &mut { on_one_core }), 0.375);
    }

    #[test]
    fn three_devices_share_by_speed() {
        let mut balance = Balance::new(3, None);
        for _ in 0..90 {
            let shares = balance.shares().to_vec();
            let ms = [shares[0] * 100.0, shares[1] * 50.0, shares[2] * 20.0];
            balance.measured(work(&shares, &ms));
        }
        for (share, wanted) in balance.shares().iter().zip([0.125, 0.25, 0.625]) {
            assert!((share - wanted).abs() < 1e-3, "{:?}", balance.shares());
        }
    }

    #[test]
    fn single_slow_frame_does_not_move_shares() {
        let course = course(80, &mut |s, frame| {
            let hiccup = if frame % 5 == 4 { 7.0 } else { 1.0 };
            vec![s[0] * 30.0 * hiccup, s[1] * 10.0]
        });
        assert_converges(&course, 0.25);
    }

    #[test]
    fn noise_moves_shares_by_less_than_its_amplitude() {
        let mut rng = populace_testkit::Rng::new(1);
        let mut noise = || 1.0 + 0.1 * rng.between(-1.0, 1.0);
        let course = course(400, &mut |s, _| vec![s[0] * 20.0 * noise(), s[1] * 20.0 * noise()]);
        let most = course.iter().skip(40).map(|share| (share - 0.5).abs()).fold(0.0, f64::max);
        assert!(most < 0.03, "10 % of noise moves shares by {most}");
    }

    #[test]
    fn unknown_times_keep_shares_and_no_device_gets_zero() {
        let mut balance = Balance::new(2, None);
        for work in [
            [(5, None), (5, Some(1.0))],
            [(0, Some(1.0)), (5, Some(1.0))],
            [(5, Some(0.0)), (5, Some(1.0))],
        ] {
            (0..5).for_each(|_| balance.measured(work.into_iter()));
        }
        assert_eq!(balance.shares(), [0.5, 0.5]);
        (0..100).for_each(|_| balance.measured([(1, Some(1e6)), (1000, Some(1.0))].into_iter()));
        assert!(balance.shares()[0] >= LEAST * 0.99, "{:?}", balance.shares());
        let mut fixed = Balance::new(2, Some(vec![1.0, 0.0]));
        (0..5).for_each(|_| fixed.measured([(1000, Some(9.0)), (1, Some(1.0))].into_iter()));
        assert_eq!(fixed.shares(), [1.0, 0.0]);
    }
}
