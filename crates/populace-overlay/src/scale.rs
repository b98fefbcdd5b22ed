//! Colour scales for numbers and for words.

use crate::Color;

/// Greatest number of words with a colour of their own.
pub const WORD_COLORS: usize = 10;

/// Ramp for numbers through Oklab: from a dark violet through blue, teal and green to a light yellow.
const RAMP: [[f64; 3]; 6] = [
    [0.330, 0.055, -0.130],
    [0.440, 0.000, -0.128],
    [0.560, -0.065, -0.068],
    [0.680, -0.115, 0.010],
    [0.805, -0.120, 0.115],
    [0.930, -0.035, 0.165],
];
/// Steps of the ramp, each equally large in Oklab.
const STEPS: u32 = 64;

/// Lightness and opponents of the colours of words, in the order in which they are given.
const WORDS: [[f64; 3]; WORD_COLORS] = [
    [0.580, -0.045, -0.145],
    [0.740, 0.085, 0.135],
    [0.580, -0.120, 0.085],
    [0.570, 0.185, 0.080],
    [0.500, 0.085, -0.145],
    [0.800, -0.095, -0.060],
    [0.770, 0.135, -0.020],
    [0.890, -0.020, 0.155],
    [0.430, 0.050, 0.060],
    [0.360, -0.005, -0.090],
];
/// Colour of all words beyond.
const OTHERS: [f64; 3] = [0.640, 0.0, 0.0];
/// Colour of what has no value.
const NONE: [f64; 3] = [0.920, 0.0, 0.0];

/// A scale of colours: the same for people, trails and the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    pub(crate) kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    Number { low: f64, high: f64, ramp: Vec<[f64; 3]> },
    Words { count: usize },
}

impl Scale {
    /// Returns a scale for numbers between two, in either order, in steps that look equally large.
    /// If both are equal, or only one is finite, the scale begins there and is as wide as that
    /// number, at least 1. If none is, it is from 0 to 1.
    #[must_use]
    pub fn number(low: f64, high: f64) -> Self {
        let (low, high) = match (low.is_finite(), high.is_finite()) {
            (true, true) if high > low => (low, high),
            (true, true) if low > high => (high, low),
            (true, _) => (low, low + low.abs().max(1.0)),
            (_, true) => (high, high + high.abs().max(1.0)),
            _ => (0.0, 1.0),
        };
        Self { kind: Kind::Number { low, high, ramp: even_ramp() } }
    }

    /// Returns a scale for `count` words. Those beyond [`WORD_COLORS`] share the grey of "others".
    #[must_use]
    pub fn words(count: usize) -> Self {
        Self { kind: Kind::Words { count } }
    }

    /// Number of words with a colour of their own; 0 for a scale of numbers.
    #[must_use]
    pub fn own_colors(&self) -> usize {
        match self.kind {
            Kind::Number { .. } => 0,
            Kind::Words { count } => count.min(WORD_COLORS),
        }
    }

    /// Returns the colour of a number; of a scale of words, that of the word with this index.
    ///
    /// Numbers beyond the ends have the colour of the nearer end. Words beyond those with a colour
    /// of their own are grey. NaN is what has no value, and a light grey.
    #[must_use]
    pub fn color(&self, value: f64) -> Color {
        match &self.kind {
            _ if value.is_nan() => Color::of(NONE),
            Kind::Number { low, high, ramp } => {
                // Halves: the difference of the ends may be beyond the largest number.
                let part = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
                Color::of(at(ramp, part.clamp(0.0, 1.0)))
            }
            Kind::Words { .. } => {
                let known = (0..self.own_colors()).zip(WORDS);
                let mut indices = known.zip(0_u32..);
                let found = indices.find(|(_, index)| f64::from(*index) == value);
                Color::of(found.map_or(OTHERS, |((_, color), _)| color))
            }
        }
    }
}

/// Returns the point of a polyline with equal pieces at 0 to 1.
fn at(points: &[[f64; 3]], part: f64) -> [f64; 3] {
    let mut place = part * f64::from(STEPS);
    for pair in points.windows(2) {
        if place <= 1.0 {
            return [0, 1, 2].map(|i| pair[0][i] + place * (pair[1][i] - pair[0][i]));
        }
        place -= 1.0;
    }
    points.last().copied().unwrap_or(OTHERS)
}

/// Returns the ramp in steps of equal length.
fn even_ramp() -> Vec<[f64; 3]> {
    const FINE: u32 = 40;
    let fine: Vec<_> = (0..RAMP.len() - 1)
        .flat_map(|piece| (0..FINE).map(move |i| spline(piece, f64::from(i) / f64::from(FINE))))
        .chain(RAMP.last().copied())
        .collect();
    let mut lengths = vec![0.0];
    for pair in fine.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + distance(pair[0], pair[1]));
    }
    let all = lengths[lengths.len() - 1];
    let point = |step: u32| {
        let wanted = all * f64::from(step) / f64::from(STEPS);
        let above = lengths.partition_point(|l| *l < wanted).clamp(1, fine.len() - 1);
        let part = (wanted - lengths[above - 1]) / (lengths[above] - lengths[above - 1]);
        [0, 1, 2].map(|i| fine[above - 1][i] + part * (fine[above][i] - fine[above - 1][i]))
    };
    (0..=STEPS).map(point).collect()
}

/// Returns a point of the Catmull-Rom spline through the ramp.
fn spline(piece: usize, t: f64) -> [f64; 3] {
    let last = RAMP.len() - 1;
    let [a, b] = [RAMP[piece], RAMP[piece + 1]];
    let (before, after) = (RAMP[piece.saturating_sub(1)], RAMP[(piece + 2).min(last)]);
    [0, 1, 2].map(|i| {
        let (from, to) = (0.5 * (b[i] - before[i]), 0.5 * (after[i] - a[i]));
        let (c, d) = (b[i] - a[i] - from, a[i] - b[i] + to);
        // Hermite form: the value, its slopes at the ends, and what is left of the way.
        a[i] + t * (from + t * ((2.0 * c - d) + t * (d - c)))
    })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_step_evenly_and_grow_lighter() {
        let ramp = even_ramp();
        let steps: Vec<_> = ramp.windows(2).map(|p| distance(p[0], p[1])).collect();
        let mean = steps.iter().sum::<f64>() / f64::from(STEPS);
        assert!(steps.iter().all(|s| (s / mean - 1.0).abs() < 0.03), "{steps:?}");
        assert!(ramp.windows(2).all(|p| p[1][0] > p[0][0]), "lightness grows: {ramp:?}");
        for end in [0, RAMP.len() - 1] {
            let step = if end == 0 { 0 } else { STEPS as usize };
            assert!(distance(ramp[step], RAMP[end]) < 1e-9);
        }
    }

    #[test]
    fn no_color_is_cut_off() {
        let colors = even_ramp().into_iter().chain(WORDS);
        for lab in colors {
            let linear = Color::of(lab).linear();
            assert!(linear.iter().all(|v| (0.0005..0.9995).contains(v)), "{lab:?}: {linear:?}");
        }
    }

    #[test]
    fn words_differ() {
        let all: Vec<_> = WORDS.into_iter().chain([OTHERS, NONE]).collect();
        for (i, a) in all.iter().enumerate() {
            for (j, b) in all.iter().enumerate().take(i) {
                assert!(distance(*a, *b) > 0.115, "{i} and {j}: {}", distance(*a, *b));
            }
        }
    }

    #[test]
    fn ends_words_and_odd_values() {
        let scale = Scale::number(0.0, 2.0);
        assert_eq!(scale.color(-1.0), scale.color(0.0));
        assert_eq!(scale.color(9.0), scale.color(2.0));
        assert_ne!(scale.color(0.9), scale.color(1.1));
        assert_eq!(scale.color(f64::NAN).srgb(), Color::of(NONE).srgb());
        assert_eq!(Scale::number(2.0, 0.0), scale);
        for (low, high) in [(1.0, 1.0), (f64::NAN, 0.0), (f64::MIN, f64::MAX)] {
            let color = Scale::number(low, high).color(0.5);
            assert!(color.linear().iter().all(|v| v.is_finite()));
        }
        let words = Scale::words(40);
        assert_eq!(words.own_colors(), WORD_COLORS);
        assert_eq!(words.color(10.0), words.color(30.0));
        assert_eq!(Scale::words(10).color(9.0), words.color(9.0));
        assert_ne!(words.color(f64::NAN), words.color(30.0));
    }
}
