//! The frames of a film, and the moments that they show.

use std::ops::RangeInclusive;

use populace_film::FrameRate;

/// Degrees of shutter for each picture that is averaged into a frame.
const DEGREES_PER_SAMPLE: f64 = 22.5;

/// How long a frame is exposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shutter {
    /// Share of the time from a frame to the next, from 0 to 1.
    open: f64,
    /// Number of moments that are averaged, at least 1.
    pub(crate) samples: u32,
}

impl Shutter {
    /// Shows a single moment.
    pub(crate) const INSTANT: Self = Self { open: 0.0, samples: 1 };

    /// Returns the shutter that is open for `degrees` from 0 to 360, the time from a frame to the
    /// next. It averages a picture for each 22.5 degrees, and at least two.
    pub(crate) fn degrees(degrees: f64) -> Self {
        if degrees == 0.0 {
            return Self::INSTANT;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to 16, and floats saturate"
        )]
        let samples = (degrees / DEGREES_PER_SAMPLE).ceil() as u32;
        Self { open: degrees / 360.0, samples: samples.max(2) }
    }
}

/// Consecutive frames of a film. Frame k shows the time k / rate, whichever frames are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frames {
    /// Number of the first frame that is drawn; those before it are only evaluated.
    pub(crate) first: u32,
    /// Number of the last frame.
    pub(crate) last: u32,
    pub(crate) rate: FrameRate,
    pub(crate) shutter: Shutter,
    /// Seconds by which the last frame is later than its time.
    pub(crate) late_secs: f64,
}

/// A time at which the action is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    pub(crate) frame: u32,
    /// Seconds since frame 0.
    pub(crate) secs: f64,
    /// Number of the picture among those that are averaged into the frame; `None` if the moment is
    /// only evaluated.
    pub(crate) sample: Option<u32>,
}

impl Frames {
    /// Returns the only frame of a picture at `secs`; at 0 if that is before the first frame.
    pub(crate) fn still(secs: f64, rate: FrameRate) -> Self {
        let secs = secs.max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "floats saturate, and nobody waits for 2^32 frames"
        )]
        let nearest = (secs * rate.per_sec()).round() as u32;
        let is_late = |frame: u32| rate.secs(frame) > secs + 1e-9;
        let frame = if is_late(nearest) { nearest - 1 } else { nearest };
        let late_secs = secs - rate.secs(frame);
        let late_secs = if late_secs > 1e-9 { late_secs } else { 0.0 };
        Self { first: frame, last: frame, rate, shutter: Shutter::INSTANT, late_secs }
    }

    /// Returns the frames of a film with these numbers.
    pub(crate) fn film(range: &RangeInclusive<u32>, rate: FrameRate, shutter: Shutter) -> Self {
        Self { first: *range.start(), last: *range.end(), rate, shutter, late_secs: 0.0 }
    }

    /// Returns the number of frames that are drawn.
    pub(crate) fn count(&self) -> u32 {
        self.last - self.first + 1
    }

    /// Returns the times of the frames that are drawn, in seconds since frame 0.
    pub(crate) fn times(self) -> impl Iterator<Item = f64> {
        (self.first..=self.last).map(move |frame| self.rate.secs(frame) + self.late_secs)
    }

    /// Returns all moments up to frame `last`, in order. They are the same whichever frame is the
    /// first that is drawn.
    pub(crate) fn moments(self, last: u32) -> impl Iterator<Item = Moment> {
        let end = (self.late_secs > 0.0 && last == self.last).then_some(last);
        let whole = move |frame: u32| match end {
            // Its other moments could be later than the one that is shown.
            Some(end) if frame == end => 1,
            _ => self.shutter.samples,
        };
        let at = move |frame: u32, sample: u32| {
            let share = f64::from(sample) / f64::from(self.shutter.samples);
            let late_secs = self.shutter.open * share / self.rate.per_sec();
            (self.rate.secs(frame) + late_secs, sample)
        };
        let shown = move |frame: u32, late_secs: f64, sample: u32, is_shown: bool| {
            let (secs, sample) = at(frame, sample);
            Moment { frame, secs: secs + late_secs, sample: is_shown.then_some(sample) }
        };
        let frames = (0..=last).flat_map(move |frame| {
            (0..whole(frame)).map(move |sample| shown(frame, 0.0, sample, end != Some(frame)))
        });
        let late = end.into_iter().flat_map(move |frame| {
            (0..self.shutter.samples).map(move |sample| shown(frame, self.late_secs, sample, true))
        });
        frames.chain(late)
    }
}

/// Returns the nearest `f32`.
#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(frames: Frames) -> Vec<(u32, f64, Option<u32>)> {
        let rounded = |secs: f64| (secs * 1e6).round() / 1e6;
        frames.moments(frames.last).map(|m| (m.frame, rounded(m.secs), m.sample)).collect()
    }

    fn film(degrees: f64) -> Frames {
        let rate = FrameRate::new(10, 1).expect("a rate");
        let shutter = Shutter::degrees(degrees);
        Frames { first: 1, last: 2, rate, shutter, late_secs: 0.0 }
    }

    #[test]
    fn pictures_before_the_first_frame_show_it() {
        let rate = FrameRate::new(10, 1).expect("a rate");
        let last_of = |secs| Frames::still(secs, rate).last;
        assert_eq!([-5.0, f64::NAN, 0.0, 0.04, 0.06, 0.1].map(last_of), [0, 0, 0, 0, 0, 1]);
    }

    #[test]
    fn moments_of_a_shutter_lie_in_its_interval() {
        let all: Vec<_> = (0..3).map(|k| (k, f64::from(k) / 10.0, Some(0))).collect();
        assert_eq!(times(film(0.0)), all);
        let blurred = times(film(90.0));
        assert_eq!(blurred.len(), 12);
        let wanted =
            [(2, 0.2, Some(0)), (2, 0.20625, Some(1)), (2, 0.2125, Some(2)), (2, 0.21875, Some(3))];
        assert_eq!(blurred[8..], wanted);
        assert_eq!([10.0, 180.0, 360.0].map(|d| Shutter::degrees(d).samples), [2, 8, 16]);
    }

    #[test]
    fn stills_take_the_steps_of_a_film() {
        let rate = FrameRate::new(10, 1).expect("a rate");
        assert_eq!(Frames::still(0.2, rate), Frames { first: 2, ..film(0.0) });
        let between = Frames::still(0.25, rate);
        let shown = times(between);
        assert_eq!(shown[2..], [(2, 0.2, None), (2, 0.25, Some(0))]);
        assert_eq!(Frames::still(0.0, rate).moments(0).count(), 1);
        let blurred = Frames { shutter: Shutter::degrees(45.0), ..between };
        assert_eq!(
            times(blurred)[4..],
            [(2, 0.2, None), (2, 0.25, Some(0)), (2, 0.25625, Some(1))]
        );
    }
}
