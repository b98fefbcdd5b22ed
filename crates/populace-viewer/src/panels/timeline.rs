//! The timeline: play, pause, step, speed, seek and record.

use egui::{RichText, Slider, Ui};

use crate::clock::SPEEDS;
use crate::desk::{Command, Desk};
use crate::stage::Stage;
use crate::theme::QUIET;

/// Length of the timeline of a show without end: at least this, in seconds, and a fourth more than
/// the time that has passed.
const OPEN_SECS: f64 = 60.0;

pub(super) fn show(ui: &mut Ui, stage: &mut Stage, desk: &mut Desk) {
    ui.horizontal(|ui| {
        let play = if desk.clock.plays { "Pause" } else { "Play" };
        let response = ui.add_sized([58.0, 22.0], egui::Button::new(play));
        if desk.widgets.note("Play", response).clicked() {
            desk.clock.plays = !desk.clock.plays;
        }
        for (name, words, later) in
            [("-1", "One frame back (,)", false), ("+1", "One frame on (.)", true)]
        {
            let response = ui.button(name).on_hover_text(words);
            if desk.widgets.note(name, response).clicked() {
                desk.wish(Command::Step { later });
            }
        }
        speed(ui, desk);
        record(ui, desk);
        let help = ui.button("?").on_hover_text("Keys and mouse");
        if desk.widgets.note("?", help).clicked() {
            desk.help = !desk.help;
        }
        seek(ui, stage, desk);
    });
}

fn speed(ui: &mut Ui, desk: &mut Desk) {
    let text = format!("{}×", desk.clock.speed);
    egui::ComboBox::from_id_salt("speed").width(56.0).selected_text(text).show_ui(ui, |ui| {
        for speed in SPEEDS {
            ui.selectable_value(&mut desk.clock.speed, speed, format!("{speed}×"));
        }
    });
}

fn record(ui: &mut Ui, desk: &mut Desk) {
    let words = match &desk.film {
        Some((_, frames)) => format!("Stop ({frames})"),
        None => "Record".to_owned(),
    };
    let response = ui.button(words).on_hover_text("Record the picture to an MP4 film (V)");
    if desk.widgets.note("Record", response).clicked() {
        desk.wish(Command::Record);
    }
}

fn seek(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    let now_secs = stage.secs().max(0.0);
    let (end_secs, length) = match stage.show.length_secs() {
        Some(secs) => (secs, format!(" / {}", time(secs))),
        None => (OPEN_SECS.max(1.25 * now_secs), String::new()),
    };
    let words = match stage.target_secs() {
        Some(target_secs) => format!("{} to {}", time(now_secs), time(target_secs)),
        None => format!("{}{length}", time(now_secs)),
    };
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_sized([118.0, 20.0], egui::Label::new(RichText::new(words).color(QUIET)));
        ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
        let mut secs = stage.target_secs().unwrap_or(now_secs);
        let slider = Slider::new(&mut secs, 0.0..=end_secs.max(0.01)).show_value(false);
        let response = ui.add(slider);
        if desk.widgets.note("Time", response).changed() {
            desk.wish(Command::Seek(secs));
        }
    });
}

/// Returns a time as minutes, seconds and hundredths.
fn time(secs: f64) -> String {
    let hundredths = (100.0 * secs).round();
    let minutes = (hundredths / 6000.0).floor();
    format!("{minutes:.0}:{:05.2}", (hundredths - 6000.0 * minutes) / 100.0)
}

#[cfg(test)]
mod tests {
    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(super::time(0.0), "0:00.00");
        assert_eq!(super::time(75.5), "1:15.50");
        assert_eq!(super::time(59.996), "1:00.00");
    }
}
