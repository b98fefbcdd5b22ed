//! The crowd: its size, device and schedule, and what is drawn over the picture.

use egui::{ComboBox, DragValue, RichText, Ui};
use populace::Schedule;

use crate::camera::Mode;
use crate::desk::{Command, Desk};
use crate::stage::Stage;
use crate::theme::QUIET;

/// Largest crowd that the panel makes; `--members` makes larger ones.
const MOST_MEMBERS: u32 = 100_000;
/// Schedules that can be chosen.
const SCHEDULES: [Schedule; 2] = [Schedule::Fused, Schedule::Staged];

pub(super) fn show(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    egui::Grid::new("crowd").num_columns(2).min_col_width(58.0).show(ui, |ui| {
        ui.label("Members");
        members(ui, stage, desk);
        ui.end_row();
        ui.label("Device");
        devices(ui, stage, desk);
        ui.end_row();
        ui.label("Schedule");
        schedules(ui, stage, desk);
        ui.end_row();
    });
    title(ui, "Camera");
    cameras(ui, stage, desk);
    title(ui, "Drawn over the picture");
    ui.horizontal_wrapped(|ui| drawings(ui, desk));
    title(ui, "In the picture");
    statistics(ui, stage);
}

fn members(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    ui.horizontal(|ui| {
        if stage.show.leads_members() {
            ui.label(format!("{} there now", stage.crowd.member_count()));
            return;
        }
        let field = DragValue::new(&mut desk.members).range(1..=MOST_MEMBERS).speed(1.0);
        let response = ui.add(field);
        desk.widgets.note("Members", response);
        if desk.button(ui, "Set") {
            let members = Some(desk.members);
            desk.wish(Command::Reopen { members, device: None, schedule: None });
        }
    });
}

fn devices(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    let device = stage.crowd.device_info().devices.to_string();
    let mut chosen = None;
    let combo = ComboBox::from_id_salt("device").width(150.0).selected_text(&device);
    let shown = combo.show_ui(ui, |ui| {
        for name in &desk.devices {
            if ui.selectable_label(*name == device, name).clicked() && *name != device {
                chosen = Some(name.clone());
            }
        }
    });
    desk.widgets.note("Device", shown.response);
    if chosen.is_some() {
        desk.wish(Command::Reopen { members: None, device: chosen, schedule: None });
    }
}

fn schedules(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    let schedule = stage.crowd.device_info().schedule;
    let mut chosen = None;
    let combo = ComboBox::from_id_salt("schedule").width(150.0).selected_text(schedule.name());
    let shown = combo.show_ui(ui, |ui| {
        for other in SCHEDULES {
            let response = ui.selectable_label(other == schedule, other.name());
            if desk.widgets.note(other.name(), response).clicked() && other != schedule {
                chosen = Some(other);
            }
        }
    });
    desk.widgets.note("Schedule", shown.response);
    if chosen.is_some() {
        desk.wish(Command::Reopen { members: None, device: None, schedule: chosen });
    }
}

/// Shows what can be drawn over the picture.
fn drawings(ui: &mut Ui, desk: &mut Desk) {
    for (name, words) in [
        ("Skeletons", "Draw the joints of members (K)"),
        ("Bounds", "Draw the spheres by which members are chosen for the picture (B)"),
        ("Levels", "Write levels of detail over members (L)"),
        ("Times", "Draw how long frames take (T)"),
    ] {
        let layout = &mut desk.layout;
        let on = match name {
            "Skeletons" => &mut layout.skeletons,
            "Bounds" => &mut layout.bounds,
            "Times" => &mut layout.times,
            _ => &mut layout.levels,
        };
        let response = ui.toggle_value(on, name).on_hover_text(words);
        desk.widgets.note(name, response);
    }
}

fn title(ui: &mut Ui, text: &str) {
    ui.add_space(8.0);
    ui.label(RichText::new(text).color(QUIET));
}

fn cameras(ui: &mut Ui, stage: &Stage, desk: &mut Desk) {
    ui.horizontal(|ui| {
        for mode in Mode::ALL {
            let chosen = desk.rig.mode() == mode;
            let response = ui.selectable_label(chosen, mode.name());
            if desk.widgets.note(mode.name(), response).clicked() && !chosen {
                match (mode, desk.picked) {
                    (Mode::Follow, Some(member)) => desk.wish(Command::Follow(member)),
                    (Mode::Follow, None) => {
                        let now_secs = ui.input(|input| input.time);
                        desk.say("click somebody to follow", now_secs);
                    }
                    _ => {
                        if let Ok(camera) = stage.shown_camera() {
                            desk.rig.set_mode(mode, &camera);
                        }
                    }
                }
            }
        }
    });
}

fn statistics(ui: &mut Ui, stage: &Stage) {
    let counts = stage.crowd.view_statistics();
    let seen: usize = counts.levels.iter().sum();
    let (shadows, hidden) = (counts.shadow_only, counts.hidden);
    ui.label(format!("{seen} seen, {shadows} by their shadow, {hidden} hidden"));
    let levels = counts.levels.iter().enumerate().filter(|(_, count)| **count > 0);
    let levels: Vec<String> = levels.map(|(level, count)| format!("{level}: {count}")).collect();
    if !levels.is_empty() {
        ui.label(format!("levels of detail {}", levels.join(", ")));
    }
}
