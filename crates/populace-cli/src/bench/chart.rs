//! What was measured, as a picture: nanoseconds per joint over members, both on logarithmic axes,
//! as SVG.

use populace::{Device, Devices};

use super::document::Document;
use super::runs::Run;

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 540.0;
/// What the axes enclose: left, top, right, bottom.
const FRAME: [f64; 4] = [80.0, 70.0, 690.0, 470.0];
/// Colours of the schedules and loads: grey for the floor, then those of Okabe and Ito, "Color
/// Universal Design" (2008), that stay apart for readers who see red and green alike.
const COLOURS: [&str; 7] =
    ["#555555", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// One line of the chart.
struct Series {
    device: Devices,
    /// Schedule and load.
    way: String,
    is_floor: bool,
    /// Members, and nanoseconds per joint; the fewest members first.
    points: Vec<[f64; 2]>,
}

/// An axis from `low` to `high`, which stand at `start` and `end` of the picture.
struct Axis {
    ticks: Vec<f64>,
    start: f64,
    end: f64,
}

/// A picture of whole frames: a line for each device, schedule and load. Floors are dashed, the
/// native device's points hollow.
pub(crate) fn as_svg(document: &Document) -> String {
    let Document { machine, runs } = document;
    let series = series(runs);
    let points = || series.iter().flat_map(|s| &s.points);
    let [left, top, right, bottom] = FRAME;
    let x = Axis::new(points().map(|p| p[0]), &[1.0], [left, right]);
    let y = Axis::new(points().map(|p| p[1]), &[1.0, 2.0, 5.0], [bottom, top]);
    let slots = runs.iter().map(|run| run.slots).max().unwrap_or(0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"14\">\n<rect width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n"
    );
    svg += &label([left, 30.0], "start", 18, "Time per joint of crowds of several sizes");
    svg += &label(
        [left, 52.0],
        "start",
        13,
        &format!("{machine}; clips blended: {slots}, palettes written"),
    );
    svg += &axes(&x, &y);
    let mut ways: Vec<&str> = Vec::new();
    for (index, one) in series.iter().enumerate() {
        let colour = ways.iter().position(|way| *way == one.way).unwrap_or_else(|| {
            ways.push(&one.way);
            ways.len() - 1
        });
        svg += &one.draw(index, COLOURS[colour % COLOURS.len()], &x, &y);
    }
    svg + "</svg>\n"
}

fn series(runs: &[Run]) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for run in runs.iter().filter(|run| run.stage == "all") {
        let load = if run.is_plain() { String::new() } else { format!(", {}", run.load) };
        let (device, way) = (run.device.clone(), format!("{}{load}", run.schedule));
        let at = all.iter().position(|s| s.device == device && s.way == way).unwrap_or_else(|| {
            all.push(Series { device, way, is_floor: run.schedule == "floor", points: Vec::new() });
            all.len() - 1
        });
        all[at].points.push([run.members as f64, run.ns_per_joint()]);
    }
    all.iter_mut().for_each(|s| s.points.sort_by(|a, b| a[0].total_cmp(&b[0])));
    all
}

impl Axis {
    /// Ticks at these multiples of the powers of ten, from the last at or below all values to the
    /// first above them.
    fn new(values: impl Iterator<Item = f64>, multiples: &[f64], [start, end]: [f64; 2]) -> Self {
        let (low, high) =
            values.fold((f64::INFINITY, 0.0), |(low, high), v| (v.min(low), v.max(high)));
        let all = (-3..9).flat_map(|power| multiples.iter().map(move |m| m * 10f64.powi(power)));
        let all: Vec<f64> = all.collect();
        let first = all.iter().rposition(|tick| *tick <= low * 1.000_001).unwrap_or(0);
        let last =
            all.iter().position(|tick| *tick >= high).unwrap_or(all.len() - 1).max(first + 1);
        Self { ticks: all[first..=last].to_vec(), start, end }
    }

    fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.ticks[0], self.ticks[self.ticks.len() - 1]);
        self.start + (value / low).ln() / (high / low).ln() * (self.end - self.start)
    }
}

fn axes(x: &Axis, y: &Axis) -> String {
    let [left, top, right, bottom] = FRAME;
    let line = |[x1, y1, x2, y2]: [f64; 4]| {
        format!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" \
             stroke=\"#cccccc\"/>\n"
        )
    };
    let mut svg = String::new();
    for &tick in &x.ticks {
        let at = x.place(tick);
        svg += &line([at, top, at, bottom]);
        svg += &label([at, bottom + 22.0], "middle", 14, &grouped(tick));
    }
    for &tick in &y.ticks {
        let at = y.place(tick);
        svg += &line([left, at, right, at]);
        svg += &label([left - 8.0, at + 5.0], "end", 14, &grouped(tick));
    }
    svg +=
        &label([f64::midpoint(left, right), bottom + 50.0], "middle", 14, "members (logarithmic)");
    let middle = f64::midpoint(top, bottom);
    let name = label([24.0, middle], "middle", 14, "nanoseconds per joint, median (logarithmic)");
    svg += &name.replacen("<text", &format!("<text transform=\"rotate(-90 24 {middle})\""), 1);
    svg
}

impl Series {
    /// The line, its points, and its place in the legend.
    fn draw(&self, index: usize, colour: &str, x: &Axis, y: &Axis) -> String {
        let places: Vec<[f64; 2]> =
            self.points.iter().map(|p| [x.place(p[0]), y.place(p[1])]).collect();
        let [left, middle] = [FRAME[2] + 20.0, FRAME[1] + 12.0 + 24.0 * index as f64];
        let mut svg = self.line(&places, colour)
            + &self.line(&[[left, middle], [left + 44.0, middle]], colour);
        let fill = if matches!(self.device.as_slice(), [Device::Native { .. }]) {
            "#ffffff"
        } else {
            colour
        };
        for [x, y] in places.into_iter().chain([[left + 22.0, middle]]) {
            svg += &format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\" stroke=\"{colour}\" \
                 stroke-width=\"2\"/>\n"
            );
        }
        svg + &label(
            [left + 54.0, middle + 5.0],
            "start",
            14,
            &format!("{} {}", self.device, self.way),
        )
    }

    fn line(&self, places: &[[f64; 2]], colour: &str) -> String {
        let places: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        let dash = if self.is_floor { " stroke-dasharray=\"7 5\"" } else { "" };
        format!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.5\"{dash}/>\n",
            places.join(" L")
        )
    }
}

fn label([x, y]: [f64; 2], anchor: &str, size: u32, text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!(
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" \
         fill=\"#222222\">{text}</text>\n"
    )
}

/// A number with a comma between thousands.
fn grouped(value: f64) -> String {
    let text = if value < 1.0 { return value.to_string() } else { format!("{value:.0}") };
    let mut grouped = String::new();
    for (index, digit) in text.chars().enumerate() {
        if index > 0 && (text.len() - index) % 3 == 0 {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_enclose_their_values_and_spread_decades_evenly() {
        let axis = Axis::new([1000.0, 100_000.0].into_iter(), &[1.0], [0.0, 200.0]);
        assert_eq!(axis.ticks, [1e3, 1e4, 1e5]);
        assert!((axis.place(1e4) - 100.0).abs() < 1e-9);
        assert_eq!(Axis::new([1000.0].into_iter(), &[1.0], [0.0, 1.0]).ticks, [1e3, 1e4]);
        let axis = Axis::new([0.7, 31.0].into_iter(), &[1.0, 2.0, 5.0], [0.0, 1.0]);
        assert_eq!((axis.ticks[0], axis.ticks[axis.ticks.len() - 1]), (0.5, 50.0));
        for value in [0.7, 31.0] {
            assert!((0.0..=1.0).contains(&axis.place(value)));
        }
    }

    #[test]
    fn thousands_are_set_apart_and_text_is_escaped() {
        assert_eq!([0.5, 20.0, 1e3, 1e6].map(grouped), ["0.5", "20", "1,000", "1,000,000"]);
        assert!(label([0.0; 2], "end", 9, "a<b & c").contains("a&lt;b &amp; c"));
    }
}
