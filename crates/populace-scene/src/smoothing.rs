//! Rows at even times, and the filter against sway.
//!
//! Recorded heads sway from side to side once a stride, 0.5 to 1 times a second, and speed up and
//! slow down with each step. The body's path is what is left after a low-pass filter: a Butterworth
//! filter of the second order, run forwards and backwards, so that nothing is delayed. Its amplitude
//! is halved at the cut-off frequency.

/// Rows of padding at each end, in periods of the cut-off frequency.
const PADDING_PERIODS: f64 = 1.5;

/// Returns values of a curve through points at even times: a cubic in each interval, which neither
/// overshoots nor turns back where the points do not (F. N. Fritsch and R. E. Carlson, "Monotone
/// piecewise cubic interpolation", SIAM J. Numerical Analysis 17(2), 1980).
pub(crate) fn at_even_times(
    times: &[f64],
    values: &[f64],
    from: f64,
    step_secs: f64,
    count: usize,
) -> Vec<f64> {
    let slopes = monotone_slopes(times, values);
    let mut interval = 0;
    (0..count)
        .map(|nth| {
            let at = from + nth as f64 * step_secs;
            while interval + 2 < times.len() && times[interval + 1] <= at {
                interval += 1;
            }
            let Some(until) = times.get(interval + 1) else { return values[0] };
            let length = until - times[interval];
            let part = ((at - times[interval]) / length).clamp(0.0, 1.0);
            let ends = [values[interval], values[interval + 1]];
            hermite(ends, [slopes[interval] * length, slopes[interval + 1] * length], part)
        })
        .collect()
}

/// Returns the value of a cubic a part of the way between two ends with slopes per interval.
pub(crate) fn hermite([a, b]: [f64; 2], [from, to]: [f64; 2], part: f64) -> f64 {
    let left = 1.0 - part;
    a * left * left * (1.0 + 2.0 * part)
        + b * part * part * (3.0 - 2.0 * part)
        + part * left * (from * left - to * part)
}

/// Returns the slope at each point.
fn monotone_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let secants: Vec<(f64, f64)> = (1..times.len())
        .map(|next| {
            let length = times[next] - times[next - 1];
            (length, (values[next] - values[next - 1]) / length)
        })
        .collect();
    let (Some(first), Some(last)) = (secants.first(), secants.last()) else {
        return vec![0.0; times.len()];
    };
    let inner = secants.windows(2).map(|pair| {
        let [(before, a), (after, b)] = [pair[0], pair[1]];
        if a * b <= 0.0 {
            return 0.0;
        }
        let [left, right] = [2.0 * after + before, after + 2.0 * before];
        (left + right) / (left / a + right / b)
    });
    std::iter::once(first.1).chain(inner).chain([last.1]).collect()
}

/// Smooths values at even times. The line from the first value to the last stays as it is: only the
/// distances from it are filtered, so uniform motion is kept however short it is.
pub(crate) fn low_pass(values: &mut [f64], step_secs: f64, cutoff_hz: f64) {
    let count = values.len();
    // Above half the sampling rate there is nothing to remove.
    if count < 3 || cutoff_hz * step_secs > 0.4 {
        return;
    }
    let filter = Filter::new(step_secs, cutoff_hz);
    let padding = periods(step_secs, cutoff_hz);
    let last = count - 1;
    let (first, slope) = (values[0], (values[last] - values[0]) / last as f64);
    let line = |nth: usize| first + slope * nth as f64;
    let off = |nth: usize| values[nth] - line(nth);
    // Turned about its ends, again and again, the curve goes on with the slope that it has there.
    let turned = |nth: usize| match nth % (2 * last) {
        nth if nth <= last => off(nth),
        nth => -off(2 * last - nth),
    };
    let before = (1..=padding).rev().map(|nth| -turned(nth));
    let mut padded: Vec<f64> = before.chain((0..count + padding).map(turned)).collect();
    for _ in 0..2 {
        filter.run(&mut padded);
        padded.reverse();
    }
    for (nth, (value, smooth)) in values.iter_mut().zip(&padded[padding..]).enumerate() {
        *value = line(nth) + smooth;
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn periods(step_secs: f64, cutoff_hz: f64) -> usize {
    (PADDING_PERIODS / (cutoff_hz * step_secs)).ceil() as usize
}

/// A Butterworth filter of the second order.
struct Filter {
    inputs: [f64; 3],
    outputs: [f64; 2],
}

impl Filter {
    /// Returns the filter with half the amplitude at a frequency after two runs.
    fn new(step_secs: f64, cutoff_hz: f64) -> Self {
        let angle = (std::f64::consts::PI * cutoff_hz * step_secs).tan();
        let scale = 1.0 / (1.0 + std::f64::consts::SQRT_2 * angle + angle * angle);
        let input = angle * angle * scale;
        Self {
            inputs: [input, 2.0 * input, input],
            outputs: [
                2.0 * (angle * angle - 1.0) * scale,
                (1.0 - std::f64::consts::SQRT_2 * angle + angle * angle) * scale,
            ],
        }
    }

    /// Filters values in place, as if the first one had lasted for ever.
    fn run(&self, values: &mut [f64]) {
        let Some(&first) = values.first() else { return };
        let (mut x, mut y) = ([first; 2], [first; 2]);
        for value in values {
            let Self { inputs, outputs } = self;
            let input = *value;
            let output = inputs[0] * input + inputs[1] * x[0] + inputs[2] * x[1]
                - outputs[0] * y[0]
                - outputs[1] * y[1];
            (x, y) = ([input, x[0]], [output, y[0]]);
            *value = output;
        }
    }
}

/// Returns values averaged with the weights of a bell of a width in seconds (its standard
/// deviation).
pub(crate) fn bell(values: &[[f64; 2]], step_secs: f64, width_secs: f64) -> Vec<[f64; 2]> {
    // Three passes of a box are within 3 % of a bell.
    let radius = box_radius(step_secs, width_secs);
    let mut smooth = values.to_vec();
    for _ in 0..3 {
        smooth = boxed(&smooth, radius);
    }
    smooth
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
fn box_radius(step_secs: f64, width_secs: f64) -> usize {
    // Three boxes of n samples have the variance (n * n - 1) / 4.
    let width = width_secs / step_secs;
    (((4.0 * width * width + 1.0).sqrt() - 1.0) / 2.0).round() as usize
}

/// Returns means over the values around each one; fewer at the ends.
fn boxed(values: &[[f64; 2]], radius: usize) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]];
    for (nth, value) in values.iter().enumerate() {
        let sum = sums[nth];
        sums.push([sum[0] + value[0], sum[1] + value[1]]);
    }
    let mean = |nth: usize| {
        let (first, end) = (nth.saturating_sub(radius), (nth + radius + 1).min(values.len()));
        let [from, until] = [sums[first], sums[end]];
        let count = (end - first) as f64;
        [(until[0] - from[0]) / count, (until[1] - from[1]) / count]
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const STEP_SECS: f64 = 0.04;

    fn wave(hz: f64) -> Vec<f64> {
        (0..1000).map(|nth| (TAU * hz * STEP_SECS * f64::from(nth)).sin()).collect()
    }

    /// Returns the largest value away from the ends.
    fn amplitude(values: &[f64]) -> f64 {
        values[200..800].iter().fold(0.0, |most, value| value.abs().max(most))
    }

    #[test]
    fn amplitudes_follow_the_filters_formula() {
        for (hz, expected) in [(0.1, 0.998), (0.5, 0.5), (1.0, 1.0 / 17.0), (2.0, 1.0 / 257.0)] {
            let mut values = wave(hz);
            low_pass(&mut values, STEP_SECS, 0.5);
            let found = amplitude(&values);
            assert!((found - expected).abs() < 0.01, "{hz} Hz: {found}, not {expected}");
        }
    }

    #[test]
    fn straight_lines_stay_and_nothing_is_delayed() {
        for count in [3, 4, 6, 12, 25, 50, 200] {
            let line: Vec<f64> = (0..count).map(|nth| 3.0 - 0.05 * f64::from(nth)).collect();
            let mut smooth = line.clone();
            low_pass(&mut smooth, STEP_SECS, 0.5);
            for (nth, (found, expected)) in smooth.iter().zip(&line).enumerate() {
                assert!((found - expected).abs() < 1e-9, "{nth} of {count}: {found}, {expected}");
            }
        }
        let mut hump: Vec<f64> =
            (-100..=100).map(|nth| (-(f64::from(nth) * 0.03).powi(2)).exp()).collect();
        low_pass(&mut hump, STEP_SECS, 0.5);
        for nth in 0..100 {
            assert!((hump[nth] - hump[200 - nth]).abs() < 1e-3, "{nth}");
        }
        let mut short = [1.0, 2.0];
        low_pass(&mut short, STEP_SECS, 0.5);
        assert_eq!(short, [1.0, 2.0]);
    }

    /// Curves that are much shorter than a period of the cut-off frequency become straight lines.
    #[test]
    fn sway_leaves_short_curves_too() {
        for count in [6, 12] {
            let curve = wave(2.0);
            let mut smooth = curve[..count].to_vec();
            low_pass(&mut smooth, STEP_SECS, 0.5);
            let slope = (curve[count - 1] - curve[0]) / (count - 1) as f64;
            for (nth, found) in smooth.iter().enumerate() {
                let line = curve[0] + slope * nth as f64;
                assert!((found - line).abs() < 0.06, "{nth} of {count}: {found}, not {line}");
            }
        }
    }

    #[test]
    fn curves_pass_through_points_and_do_not_overshoot() {
        let (times, values) = ([0.0, 1.0, 2.0, 3.0, 3.5], [0.0, 0.0, 4.0, 4.0, 5.0]);
        let curve = at_even_times(&times, &values, 0.0, 0.1, 36);
        for (time, value) in times.iter().zip(values) {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            let nth = (time * 10.0_f64).round() as usize;
            assert!((curve[nth] - value).abs() < 1e-9, "{time}: {}", curve[nth]);
        }
        assert!(curve.windows(2).all(|pair| pair[1] >= pair[0] - 1e-12), "{curve:?}");
        assert_eq!(at_even_times(&[2.0], &[7.0], 2.0, 0.1, 2), [7.0, 7.0]);
    }

    #[test]
    fn a_bell_has_the_width_asked_for() {
        let mut peak = vec![[0.0; 2]; 201];
        peak[100] = [1.0, -1.0];
        let smooth = bell(&peak, STEP_SECS, 0.4);
        let variance: f64 = smooth
            .iter()
            .enumerate()
            .map(|(nth, value)| value[0] * ((nth as f64 - 100.0) * STEP_SECS).powi(2))
            .sum();
        assert!((variance.sqrt() - 0.4).abs() < 0.02, "{}", variance.sqrt());
        let sum: f64 = smooth.iter().map(|value| value[1]).sum();
        assert!((sum + 1.0).abs() < 1e-9, "{sum}");
    }
}
