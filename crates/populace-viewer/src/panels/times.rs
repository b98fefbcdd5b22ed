//! The graph of milliseconds per frame.

use egui::{Area, Color32, Context, Frame, Margin, RichText, Sense, Ui, vec2};

use crate::desk::{Desk, GRAPH_FRAMES, Times};
use crate::stage::Stage;
use crate::theme::{PANEL, QUIET};

const WIDTH: f32 = 244.0;
const HEIGHT: f32 = 58.0;
/// Parts of a frame from the bottom up, with their colours.
const PARTS: [(&str, Color32); 4] = [
    ("animate", Color32::from_rgb(91, 170, 255)),
    ("draw", Color32::from_rgb(255, 170, 70)),
    ("panels", Color32::from_rgb(160, 220, 110)),
    ("rest", Color32::from_rgb(96, 102, 114)),
];

/// Shows the graph in the upper left corner.
pub(super) fn show(context: &Context, stage: &mut Stage, desk: &Desk) {
    let frame = Frame::new()
        .fill(PANEL.gamma_multiply(0.86))
        .inner_margin(Margin::same(8))
        .corner_radius(6.0);
    Area::new("times".into()).fixed_pos([10.0, 10.0]).interactable(false).show(context, |ui| {
        frame.show(ui, |ui| {
            ui.set_width(WIDTH);
            graph(ui, desk);
            numbers(ui, stage, desk);
        });
    });
}

/// Returns the milliseconds of the parts of a frame.
fn parts(times: &Times) -> [f64; PARTS.len()] {
    let known = times.animate + times.draw + times.panels;
    [times.animate, times.draw, times.panels, (times.whole - known).max(0.0)]
}

fn graph(ui: &mut Ui, desk: &Desk) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let mut sorted: Vec<f64> = desk.times.iter().map(|times| times.whole).collect();
    sorted.sort_by(f64::total_cmp);
    // Single slow frames do not flatten all others.
    let usual = sorted.get(sorted.len() * 19 / 20).copied().unwrap_or_default();
    let top_ms = [8.0, 17.0, 34.0, 50.0, 100.0, 200.0, 500.0, 1000.0]
        .into_iter()
        .find(|top| *top >= usual * 1.15)
        .unwrap_or(usual * 1.15);
    #[expect(clippy::cast_precision_loss, reason = "at most 160 frames")]
    let width = rect.width() / GRAPH_FRAMES as f32;
    let mut x = rect.right();
    for times in desk.times.iter().rev() {
        let mut y = rect.bottom();
        for (ms, (_, color)) in parts(times).into_iter().zip(PARTS) {
            #[expect(clippy::cast_possible_truncation, reason = "a part of 58 points")]
            let height = (ms / top_ms) as f32 * HEIGHT;
            let bar = egui::Rect::from_min_max(egui::pos2(x - width, y - height), egui::pos2(x, y));
            painter.rect_filled(bar, 0.0, color);
            y -= height;
        }
        x -= width;
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let at = rect.left_top() + vec2(4.0, 2.0);
    painter.text(at, egui::Align2::LEFT_TOP, format!("{top_ms:.0} ms"), font, QUIET);
}

fn numbers(ui: &mut Ui, stage: &mut Stage, desk: &Desk) {
    let last: Vec<&Times> = desk.times.iter().rev().take(20).collect();
    if last.is_empty() {
        return;
    }
    #[expect(clippy::cast_precision_loss, reason = "at most 20 frames")]
    let count = last.len() as f64;
    let mean = |of: &dyn Fn(&Times) -> f64| last.iter().map(|times| of(times)).sum::<f64>() / count;
    let whole = mean(&|times| times.whole);
    ui.label(format!("{whole:.1} ms, {:.0} frames a second", 1e3 / whole.max(1e-3)));
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (nth, (name, color)) in PARTS.into_iter().enumerate() {
            let ms = mean(&|times| parts(times)[nth]);
            ui.label(RichText::new(format!("{name} {ms:.1}")).color(color).small());
        }
    });
    let quiet = |text: String| RichText::new(text).color(QUIET).small();
    ui.label(quiet(format!(
        "passes: shadow {:.1}, members {:.1}, surroundings {:.1}",
        mean(&|times| times.passes.shadow_ms),
        mean(&|times| times.passes.members_ms),
        mean(&|times| times.passes.surroundings_ms)
    )));
    let stages = stage.crowd.frame_times();
    let mut words: Vec<String> =
        stages.stages_ms.iter().map(|(stage, ms)| format!("{} {ms:.2}", stage.name())).collect();
    if words.is_empty() {
        words.extend(stages.frame_ms.map(|ms| format!("all in one {ms:.2}")));
    }
    if !words.is_empty() {
        ui.label(quiet(format!("stages: {}", words.join(", "))));
    }
}
