//! Draws measurements as an SVG chart: nanoseconds per joint over members, on logarithmic axes.

use populace::{Device, Devices};

use crate::document::Document;
use crate::spec::Measurement;

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 540.0;
/// The plot area: left, top, right, bottom.
const FRAME: [f64; 4] = [80.0, 70.0, 690.0, 470.0];
/// Colours of the schedules and loads: grey for the floor, then colours of Okabe and Ito, "Color
/// Universal Design" (2008), which colour-blind readers can tell apart.
const COLOURS: [&str; 7] =
    ["#555555", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

/// One line of the chart.
struct Series {
    device: Devices,
    /// Schedule and load.
    label: String,
    is_floor: bool,
    /// Members and nanoseconds per joint, in order of members.
    points: Vec<[f64; 2]>,
}

/// A logarithmic axis; the first tick is at `start` and the last at `end` in the picture.
struct Axis {
    ticks: Vec<f64>,
    start: f64,
    end: f64,
}

impl Document {
    /// Draws a line of whole-frame times for each device, schedule and load, as SVG. Floors are
    /// dashed; points of the native device are hollow.
    #[must_use]
    pub fn as_svg(&self) -> String {
        as_svg(self)
    }
}

fn as_svg(document: &Document) -> String {
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
    let mut labels: Vec<&str> = Vec::new();
    for (index, one) in series.iter().enumerate() {
        let colour = labels.iter().position(|label| *label == one.label).unwrap_or_else(|| {
            labels.push(&one.label);
            labels.len() - 1
        });
        svg += &one.draw(index, COLOURS[colour % COLOURS.len()], &x, &y);
    }
    svg + "</svg>\n"
}

fn series(runs: &[Measurement]) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for run in runs.iter().filter(|run| run.stage == "all") {
        let load = if run.is_plain() { String::new() } else { format!(", {}", run.load) };
        let (device, label) = (run.device.clone(), format!("{}{load}", run.schedule));
        let same = |s: &Series| s.device == device && s.label == label;
        let at = all.iter().position(same).unwrap_or_else(|| {
            let is_floor = run.schedule == "floor";
            all.push(Series { device, label, is_floor, points: Vec::new() });
            all.len() - 1
        });
        all[at].points.push([run.members as f64, run.ns_per_joint()]);
    }
    all.iter_mut().for_each(|s| s.points.sort_by(|a, b| a[0].total_cmp(&b[0])));
    all
}

impl Axis {
    /// Places ticks at the given multiples of powers of ten. The first tick is at or below all
    /// values, the last at or above them.
    fn new(values: impl Iterator<Item = f64>, multiples: &[f64], [start, end]: [f64; 2]) -> Self {
        let (low, high) =
            values.fold((f64::INFINITY, 0.0), |(low, high), v| (v.min(low), v.max(high)));
        let all = (-3..9).flat_map(|power| multiples.iter().map(move |m| m * 10f64.powi(power)));
        let all: Vec<f64> = all.collect();
        let first = all.iter().rposition(|tick| *tick <= low * 1.000_001).unwrap_or(0);
        let first = first.min(all.len() - 2);
        let last =
            all.iter().position(|tick| *tick >= high).unwrap_or(all.len() - 1).max(first + 1);
        Self { ticks: all[first..=last].to_vec(), start, end }
    }

    /// Returns the coordinate of a value in the picture.
    fn coordinate(&self, value: f64) -> f64 {
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
        let at = x.coordinate(tick);
        svg += &line([at, top, at, bottom]);
        svg += &label([at, bottom + 22.0], "middle", 14, &grouped(tick));
    }
    for &tick in &y.ticks {
        let at = y.coordinate(tick);
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
    /// Draws the line, its points, and its entry in the legend.
    fn draw(&self, index: usize, colour: &str, x: &Axis, y: &Axis) -> String {
        let points: Vec<[f64; 2]> =
            self.points.iter().map(|p| [x.coordinate(p[0]), y.coordinate(p[1])]).collect();
        let [left, middle] = [FRAME[2] + 20.0, FRAME[1] + 12.0 + 24.0 * index as f64];
        let mut svg = self.line(&points, colour)
            + &self.line(&[[left, middle], [left + 44.0, middle]], colour);
        let fill = if matches!(self.device.as_slice(), [Device::Native { .. }]) {
            "#ffffff"
        } else {
            colour
        };
        for [x, y] in points.into_iter().chain([[left + 22.0, middle]]) {
            svg += &format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\" stroke=\"{colour}\" \
                 stroke-width=\"2\"/>\n"
            );
        }
        svg + &label(
            [left + 54.0, middle + 5.0],
            "start",
            14,
            &format!("{} {}", self.device, self.label),
        )
    }

    fn line(&self, points: &[[f64; 2]], colour: &str) -> String {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        let dash = if self.is_floor { " stroke-dasharray=\"7 5\"" } else { "" };
        format!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.5\"{dash}/>\n",
            points.join(" L")
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

/// Formats a number with commas between thousands.
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
    fn axis_encloses_its_values_and_is_logarithmic() {
        let axis = Axis::new([1000.0, 100_000.0].into_iter(), &[1.0], [0.0, 200.0]);
        assert_eq!(axis.ticks, [1e3, 1e4, 1e5]);
        assert!((axis.coordinate(1e4) - 100.0).abs() < 1e-9);
        assert_eq!(Axis::new([1000.0].into_iter(), &[1.0], [0.0, 1.0]).ticks, [1e3, 1e4]);
        let axis = Axis::new([0.7, 31.0].into_iter(), &[1.0, 2.0, 5.0], [0.0, 1.0]);
        assert_eq!((axis.ticks[0], axis.ticks[axis.ticks.len() - 1]), (0.5, 50.0));
        let beyond = Axis::new([1e300].into_iter(), &[1.0], [0.0, 1.0]);
        assert_eq!(beyond.ticks, [1e7, 1e8], "values beyond all ticks take the last ones");
        for value in [0.7, 31.0] {
            assert!((0.0..=1.0).contains(&axis.coordinate(value)));
        }
    }

    #[test]
    fn numbers_are_grouped_and_text_is_escaped() {
        assert_eq!([0.5, 20.0, 1e3, 1e6].map(grouped), ["0.5", "20", "1,000", "1,000,000"]);
        assert!(label([0.0; 2], "end", 9, "a<b & c").contains("a&lt;b &amp; c"));
    }
}
