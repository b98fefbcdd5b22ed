//! Round numbers along a scale.

/// Returns from two to `most` + 1 round numbers between two, equally spaced by 1, 2 or 5 times a power
/// of ten, with the digits after the point that they need.
pub(crate) fn ticks(low: f64, high: f64, most: u32) -> Vec<(f64, String)> {
    let Some((step, decimals)) = step(low, high, most) else {
        return vec![(low, written(low, 0))];
    };
    let first = (low / step - 1e-6).ceil();
    (0..=most + 1)
        .map(|i| (first + f64::from(i)) * step)
        .take_while(|v| *v <= high + 1e-6 * step)
        .map(|v| (v, written(v, decimals)))
        .collect()
}

/// Returns two numbers with as many digits after the point as the round ones between them, and one
/// more where they need it.
pub(crate) fn ends(low: f64, high: f64, most: u32) -> [(f64, String); 2] {
    let decimals = step(low, high, most).map_or(0, |(_, decimals)| decimals);
    [low, high].map(|v| {
        let units = v * (0..decimals).fold(1.0, |unit, _| 10.0 * unit);
        let fits = (units - units.round()).abs() < 1e-6;
        (v, written(v, if fits { decimals } else { decimals + 1 }))
    })
}

/// Returns the step between round numbers from one to another, at most `most` of them, and the
/// digits after the point that they need; `None` if there is none.
fn step(low: f64, high: f64, most: u32) -> Option<(f64, usize)> {
    let rough = (high / f64::from(most) - low / f64::from(most)).abs();
    if !(rough.is_finite() && rough > 0.0) {
        return None;
    }
    let mut exponent = floor_log(rough);
    let unit = 10_f64.powi(exponent);
    let mut step = match rough / unit {
        r if r <= 1.0 + 1e-9 => 1.0,
        r if r <= 2.0 + 1e-9 => 2.0,
        r if r <= 5.0 + 1e-9 => 5.0,
        _ => 10.0,
    };
    if step == 10.0 {
        (step, exponent) = (1.0, exponent + 1);
    }
    Some((step * 10_f64.powi(exponent), usize::try_from(-exponent).unwrap_or(0)))
}

/// Returns the exponent of the greatest power of ten that is not over a positive number.
#[expect(clippy::cast_possible_truncation, reason = "exponents of numbers lie within ±324")]
fn floor_log(v: f64) -> i32 {
    (v.log10() + 1e-9).floor() as i32
}

fn written(v: f64, decimals: usize) -> String {
    let v = if v == 0.0 { 0.0 } else { v };
    let text = if decimals > 4 || v.abs() >= 1e6 {
        format!("{}", Short(v))
    } else {
        format!("{v:.decimals$}")
    };
    text.replace('-', "−")
}

/// A number with two digits after the point at most, and its power of ten.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.2e}", self.0);
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        write!(f, "{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(low: f64, high: f64) -> Vec<String> {
        ticks(low, high, 4).into_iter().map(|(_, word)| word).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(words(0.0, 2.0), ["0.0", "0.5", "1.0", "1.5", "2.0"]);
        assert_eq!(words(0.0, 1.83), ["0.0", "0.5", "1.0", "1.5"]);
        assert_eq!(words(-3.0, 7.0), ["0", "5"]);
        assert_eq!(words(0.0, 100.0), ["0", "50", "100"]);
        assert_eq!(words(-1.0, 1.0), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(words(0.0, 0.0004), ["0.0000", "0.0001", "0.0002", "0.0003", "0.0004"]);
        assert_eq!(words(0.0, 4e9), ["0", "1e9", "2e9", "3e9", "4e9"]);
    }

    #[test]
    fn ends_have_the_digits_of_ticks_or_one_more() {
        for (low, high, wanted) in [
            (0.0, 2.0, ["0.0", "2.0"]),
            (0.0, 1.83, ["0.0", "1.83"]),
            (-3.0, 7.25, ["−3", "7.2"]),
            (0.0, 5.0, ["0", "5"]),
            (0.0, 3e7, ["0", "3e7"]),
            (f64::MIN, f64::MAX, ["−1.8e308", "1.8e308"]),
        ] {
            assert_eq!(ends(low, high, 4).map(|(_, word)| word), wanted);
        }
    }

    #[test]
    fn odd_ends_give_few_ticks() {
        for (low, high) in [(1.0, 1.0), (f64::MIN, f64::MAX), (1e300, 1.1e300), (5e9, 5e9 + 1.0)] {
            assert!(ticks(low, high, 4).len() <= 6, "{low} to {high}");
        }
    }
}
