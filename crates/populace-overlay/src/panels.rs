//! Panels in the corners of a picture: the clock and the legend.

use crate::canvas::{Area, Canvas, text_size};
use crate::font::{CAP_HEIGHT, text_width};
use crate::scale::Kind;
use crate::ticks::{ends, ticks};
use crate::{Anchor, Scale, TextStyle};

/// Colour of plates in sRGB with alpha.
const PLATE: [u8; 4] = [14, 16, 20, 165];
/// Colours of text on plates.
const TEXT: [u8; 4] = [246, 247, 249, 255];
const QUIET_TEXT: [u8; 4] = [201, 205, 212, 255];
/// Lengths in sizes of text: from the picture's edge, within a plate, between lines.
const MARGIN: f64 = 0.9;
const PADDING: f64 = 0.75;
const LINE: f64 = 1.4;
const BAR_WIDTH: f64 = 13.0;
/// Most of the picture's width that a bar covers, unless its title is longer.
const BAR_SHARE: f64 = 0.2;
const BAR_HEIGHT: f64 = 0.8;
const TICK: f64 = 0.28;
/// Space between two numbers under a bar, in sizes of text, and most steps between round ones.
const GAP: f64 = 0.3;
const TICKS: u32 = 4;
const SWATCH: f64 = 0.85;
const INDENT: f64 = SWATCH + 0.55;
/// Width of the soft edge around a plate in sizes of text.
const FADE: f64 = 0.35;
/// Longest word of a legend in sizes of text.
const WORD_MOST: f64 = 16.0;

/// A corner of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corner {
    /// Top left.
    TopLeft,
    /// Top right.
    TopRight,
    /// Bottom left.
    BottomLeft,
    /// Bottom right.
    BottomRight,
}

/// An explanation of colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// The quantity, such as "Speed".
    pub title: String,
    /// The unit, such as "m/s"; empty without one.
    pub unit: String,
    /// The colours.
    pub scale: Scale,
    /// The words of a scale of words, in the order of their indices.
    pub words: Vec<String>,
    /// True for an entry "none", with the colour of what has no value.
    pub has_none: bool,
}

impl Canvas<'_> {
    /// Writes a time in minutes, seconds and tenths, such as "0:12.4 s", on a plate in a corner.
    pub fn clock(&mut self, secs: f64, corner: Corner) {
        let size = self.text_size();
        let text = clock_text(secs);
        let wide = [text_width(&text, size), CAP_HEIGHT * size];
        let [x, y] = self.panel(wide, corner);
        self.panel_text(&text, [x, y + wide[1]], Anchor::Start, TEXT);
    }

    /// Draws a legend on a plate in a corner: a bar of colours with the numbers at its ends and
    /// round ones between, as far as there is room, or a swatch for each word.
    pub fn legend(&mut self, legend: &Legend, corner: Corner) {
        match &legend.scale.kind {
            Kind::Number { low, high, .. } => self.bar(legend, [*low, *high], corner),
            Kind::Words { .. } => self.swatches(legend, corner),
        }
    }

    fn bar(&mut self, legend: &Legend, [low, high]: [f64; 2], corner: Corner) {
        let size = self.text_size();
        let bar = Bar::new(legend, [low, high], self.size());
        let Bar { side, width, title_rows, under, .. } = bar;
        let [left, top] = self.panel(bar.wide, corner);
        self.panel_text(&bar.title, [left + side, top + CAP_HEIGHT * size], Anchor::Start, TEXT);
        let area = Area {
            low: [left + side, (top + title_rows).round()],
            high: [left + side + width, (top + title_rows + BAR_HEIGHT * size).round()],
        };
        self.colors(&legend.scale, area, [low, high]);
        let place = |v: f64| {
            let part = (0.5 * v - 0.5 * low) / (0.5 * high - 0.5 * low);
            (area.low[0] + part * (width - 1.0)).round()
        };
        let mut taken: Vec<[f64; 2]> = Vec::new();
        for (value, word) in bar.ends.into_iter().chain(ticks(low, high, TICKS)) {
            let (x, half) = (place(value), 0.5 * text_width(&word, size));
            let [from, to] = [x - half, x + half];
            if taken.iter().any(|[a, b]| from < b + GAP * size && a - GAP * size < to) {
                continue;
            }
            taken.push([from, to]);
            self.number(&word, x, [area.high[1], area.high[1] + under]);
        }
        if let Some(none) = legend.none() {
            self.entry(&none, [area.low[0], area.high[1] + under + LINE * size]);
        }
    }

    /// Draws a tick from a height down, and a number under it on a base line.
    fn number(&mut self, word: &str, x: f64, [from, base]: [f64; 2]) {
        let size = self.text_size();
        let thick = (size / 12.0).round().max(1.0);
        let tick = Area { low: [x, from], high: [x + thick, from + (TICK * size).round()] };
        self.plate(tick, 0.0, 0.0, QUIET_TEXT);
        self.panel_text(word, [x + 0.5 * thick, base], Anchor::Middle, QUIET_TEXT);
    }

    /// Paints the colours of a scale from left to right.
    fn colors(&mut self, scale: &Scale, area: Area, [low, high]: [f64; 2]) {
        let size = self.size();
        if let Some(window) = crate::strokes::Window::around(area.low, area.high, size) {
            let width = area.high[0] - area.low[0];
            let columns: Vec<_> = (window.first[0]..window.end[0])
                .map(|x| {
                    let part = (f64::from(x) + 0.5 - area.low[0]) / width;
                    scale.color(low * (1.0 - part) + high * part).opaque()
                })
                .collect();
            self.paint(window, |[x, _]| (columns[(x - window.first[0]) as usize], 1.0));
        }
    }

    fn swatches(&mut self, legend: &Legend, corner: Corner) {
        let size = self.text_size();
        let Some(Swatches { title, entries, wide }) = Swatches::new(legend, self.size()) else {
            return;
        };
        let [left, top] = self.panel(wide, corner);
        let mut base = top + CAP_HEIGHT * size;
        if !title.is_empty() {
            self.panel_text(&title, [left, base], Anchor::Start, TEXT);
            base += LINE * size;
        }
        for entry in entries {
            self.entry(&entry, [left, base]);
            base += LINE * size;
        }
    }

    /// Draws a swatch and its word on a base line.
    fn entry(&mut self, (word, color): &Entry, [left, base]: [f64; 2]) {
        let size = self.text_size();
        let middle = base.round() - 0.5 * CAP_HEIGHT * size;
        let half = 0.5 * SWATCH * size;
        let area = Area {
            low: [left, (middle - half).round()],
            high: [left + (2.0 * half).round(), (middle - half).round() + (2.0 * half).round()],
        };
        self.plate(area, 0.22 * size, 0.0, *color);
        self.panel_text(word, [left + INDENT * size, base], Anchor::Start, QUIET_TEXT);
    }

    /// Paints a plate for contents of a size, in pixels, and returns their upper left corner.
    fn panel(&mut self, wide: [f64; 2], corner: Corner) -> [f64; 2] {
        let size = self.text_size();
        let (at, area) = panel(wide, corner, self.size());
        self.plate(area, 0.6 * size, FADE * size, PLATE);
        at
    }

    fn panel_text(&mut self, text: &str, at: [f64; 2], anchor: Anchor, color: [u8; 4]) {
        let style = TextStyle { size_px: self.text_size(), color, halo: false };
        self.text(text, at, anchor, &style);
    }
}

impl Legend {
    /// Returns the rectangle that the legend covers in a corner of a picture of a size, both in
    /// pixels: its upper left and its lower right corner. `None` if it draws nothing.
    #[must_use]
    pub fn bounds(&self, size: [u32; 2], corner: Corner) -> Option<[[f64; 2]; 2]> {
        let wide = match &self.scale.kind {
            Kind::Number { low, high, .. } => Bar::new(self, [*low, *high], size).wide,
            Kind::Words { .. } => Swatches::new(self, size)?.wide,
        };
        let (_, Area { low, high }) = panel(wide, corner, size);
        let fade = FADE * text_size(size);
        Some([low.map(|v| v - fade), high.map(|v| v + fade)])
    }

    fn heading(&self) -> String {
        match (self.title.is_empty(), self.unit.is_empty()) {
            (_, true) => self.title.clone(),
            (true, false) => self.unit.clone(),
            (false, false) => format!("{} ({})", self.title, self.unit),
        }
    }

    /// Returns the entry of what has no value.
    fn none(&self) -> Option<Entry> {
        let color = self.scale.color(f64::NAN).opaque();
        self.has_none.then(|| ("none".to_owned(), color))
    }

    /// Returns the words with a colour of their own, "others" if there are more, and "none".
    fn entries(&self, size_px: f64) -> Vec<Entry> {
        let own = self.scale.own_colors().min(self.words.len());
        let mut entries: Vec<_> = (0_u32..)
            .zip(&self.words[..own])
            .map(|(index, word)| {
                (shortened(word, size_px), self.scale.color(f64::from(index)).opaque())
            })
            .collect();
        if own < self.words.len() {
            entries.push(("others".to_owned(), self.scale.color(f64::INFINITY).opaque()));
        }
        entries.extend(self.none());
        entries
    }
}

/// Returns the upper left corner of contents of a size on a plate in a corner of a picture, and the
/// plate, in pixels.
fn panel(wide: [f64; 2], corner: Corner, picture: [u32; 2]) -> ([f64; 2], Area) {
    let size = text_size(picture);
    let [width, height] = picture.map(f64::from);
    let edge = (MARGIN + PADDING) * size;
    let (right, bottom) = match corner {
        Corner::TopLeft => (false, false),
        Corner::TopRight => (true, false),
        Corner::BottomLeft => (false, true),
        Corner::BottomRight => (true, true),
    };
    let x = if right { width - edge - wide[0] } else { edge }.round();
    let y = if bottom { height - edge - wide[1] } else { edge }.round();
    let around = PADDING * size;
    let area =
        Area { low: [x - around, y - around], high: [x + wide[0] + around, y + wide[1] + around] };
    ([x, y], area)
}

/// A word of a legend and its colour.
type Entry = (String, [u8; 4]);

/// The parts of a legend of numbers, in pixels.
struct Bar {
    title: String,
    /// The numbers at both ends.
    ends: [(f64, String); 2],
    /// Space beside the bar, the bar's width, and what is above and below it.
    side: f64,
    width: f64,
    title_rows: f64,
    under: f64,
    /// Width and height of all.
    wide: [f64; 2],
}

impl Bar {
    fn new(legend: &Legend, [low, high]: [f64; 2], picture: [u32; 2]) -> Self {
        let size = text_size(picture);
        let title = legend.heading();
        let title_rows = if title.is_empty() { 0.0 } else { LINE * size };
        let most = BAR_SHARE * f64::from(picture[0]);
        let ends = ends(low, high, TICKS);
        let halves = [&ends[0], &ends[1]].map(|(_, word)| 0.5 * text_width(word, size));
        // The numbers at the ends stand half beside the bar, and apart from each other.
        let side = halves.into_iter().fold(0.8 * size, f64::max).ceil();
        let none = legend.none();
        let none_width = none.iter().map(|(word, _)| INDENT * size + text_width(word, size));
        let numbers_width = halves[0] + halves[1] + GAP * size;
        let least = none_width.fold(text_width(&title, size).max(numbers_width), f64::max);
        let width = (BAR_WIDTH * size).min(most).max(least).round();
        let under = (TICK + 0.35 + CAP_HEIGHT) * size;
        let none_rows = if none.is_some() { LINE * size } else { 0.0 };
        let wide = [width + 2.0 * side, title_rows + BAR_HEIGHT * size + under + none_rows];
        Self { title, ends, side, width, title_rows, under, wide }
    }
}

/// The parts of a legend of words, in pixels.
struct Swatches {
    title: String,
    entries: Vec<Entry>,
    /// Width and height of all.
    wide: [f64; 2],
}

impl Swatches {
    /// Returns nothing for a legend without a line.
    fn new(legend: &Legend, picture: [u32; 2]) -> Option<Self> {
        let size = text_size(picture);
        let entries = legend.entries(size);
        let title = shortened(&legend.heading(), size);
        let rows = entries.iter().map(|(word, _)| text_width(word, size));
        let width = rows.map(|w| w + INDENT * size).fold(text_width(&title, size), f64::max);
        let titles = if title.is_empty() { 0.0 } else { 1.0 };
        let lines = entries.iter().fold(titles, |sum, _| sum + 1.0);
        let wide = [width, ((lines - 1.0) * LINE + CAP_HEIGHT) * size];
        (lines > 0.0).then_some(Self { title, entries, wide })
    }
}

/// Returns a word, cut if it is too long for a legend.
fn shortened(word: &str, size_px: f64) -> String {
    let most = WORD_MOST * size_px;
    if text_width(word, size_px) <= most {
        return word.to_owned();
    }
    let mut width = text_width("…", size_px);
    let fits = word.chars().take_while(|letter| {
        width += text_width(letter.encode_utf8(&mut [0; 4]), size_px);
        width <= most
    });
    fits.chain(['…']).collect()
}

/// Returns a time as text.
fn clock_text(secs: f64) -> String {
    if !secs.is_finite() {
        return "–".to_owned();
    }
    #[expect(clippy::cast_possible_truncation, reason = "saturates beyond any film's length")]
    let tenths = (10.0 * secs).round() as i64;
    let sign = if tenths < 0 { "−" } else { "" };
    let tenths = tenths.unsigned_abs();
    let (minutes, rest) = (tenths / 600, tenths % 600);
    let clock = format!("{:02}.{} s", rest / 10, rest % 10);
    match minutes / 60 {
        0 => format!("{sign}{minutes}:{clock}"),
        hours => format!("{sign}{hours}:{:02}:{clock}", minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_written_in_minutes() {
        for (secs, text) in [
            (0.0, "0:00.0 s"),
            (12.44, "0:12.4 s"),
            (59.96, "1:00.0 s"),
            (3_723.4, "1:02:03.4 s"),
            (-1.25, "−0:01.3 s"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(clock_text(secs), text);
        }
    }

    #[test]
    fn long_words_are_cut() {
        let word = "w".repeat(200);
        let cut = shortened(&word, 12.0);
        assert!(cut.ends_with('…') && text_width(&cut, 12.0) <= 12.0 * WORD_MOST, "{cut}");
        assert_eq!(shortened("exit", 12.0), "exit");
    }

    #[test]
    fn many_words_end_in_others() {
        let legend = |count: usize| Legend {
            title: String::new(),
            unit: String::new(),
            scale: Scale::words(count),
            words: (0..count).map(|i| i.to_string()).collect(),
            has_none: false,
        };
        assert_eq!(legend(10).entries(12.0).len(), 10);
        let many = legend(11).entries(12.0);
        assert_eq!((many.len(), many[10].0.as_str()), (11, "others"));
        assert!(legend(0).entries(12.0).is_empty());
        let with_none = Legend { has_none: true, ..legend(11) }.entries(12.0);
        assert_eq!((&with_none[..11], with_none[11].0.as_str()), (&many[..], "none"));
        assert_ne!(with_none[11].1, with_none[10].1);
    }
}
