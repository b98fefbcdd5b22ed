//! Targets of the picked member's gaze and hands.

use egui::{RichText, Ui};
use populace::model::Role;
use populace::{Crowd, MemberId};

use crate::aims::{Aim, Aims, HANDS};
use crate::desk::Desk;
use crate::theme::QUIET;

/// Names of the hands, for people and for scripts.
const NAMES: [&str; 2] = ["left hand", "right hand"];

/// Shows what a member looks at. Returns true if it was changed.
pub(super) fn gaze(
    ui: &mut Ui,
    crowd: &Crowd,
    desk: &mut Desk,
    member: MemberId,
    aims: &mut Aims,
) -> bool {
    let height_m = height_m(crowd, member);
    let usual = Aim { point: [0.0, 0.9 * height_m, 2.0 * height_m], weight: 0.0 };
    let mut edited = aims.gaze.unwrap_or(usual);
    let changed = sliders(ui, desk, "gaze", &mut edited, height_m);
    if changed {
        aims.gaze = Some(edited);
    }
    changed
}

/// Shows what the hands of a member reach for. Returns true if it was changed.
pub(super) fn hands(
    ui: &mut Ui,
    crowd: &Crowd,
    desk: &mut Desk,
    member: MemberId,
    aims: &mut Aims,
) -> bool {
    let height_m = height_m(crowd, member);
    let mut changed = false;
    for ((aim, side), name) in aims.hands.iter_mut().zip(HANDS).zip(NAMES) {
        if crowd.member(member).ok().and_then(|m| m.joint(Role::Hand(side))).is_none() {
            ui.label(RichText::new(format!("no {name} is known")).color(QUIET));
            continue;
        }
        ui.label(RichText::new(name).small());
        // A left hand is on the side of +X.
        let sign = if name == NAMES[0] { 1.0 } else { -1.0 };
        let point = [0.14 * sign * height_m, 0.82 * height_m, 0.26 * height_m];
        let mut edited = aim.unwrap_or(Aim { point, weight: 0.0 });
        if sliders(ui, desk, name, &mut edited, height_m) {
            *aim = Some(edited);
            changed = true;
        }
    }
    changed
}

/// Shows weight and place of a target. Moving the place turns the target on.
fn sliders(ui: &mut Ui, desk: &mut Desk, name: &str, aim: &mut Aim, height_m: f32) -> bool {
    let mut changed =
        desk.slider(ui, (&format!("{name} weight"), "weight"), &mut aim.weight, 0.0..=1.0);
    let ranges = [-1.5..=1.5, 0.0..=1.4, -0.6..=2.5];
    for (axis, (word, range)) in ["to left", "height", "ahead"].into_iter().zip(ranges).enumerate()
    {
        let range = range.start() * height_m..=range.end() * height_m;
        if desk.slider(ui, (&format!("{name} {word}"), word), &mut aim.point[axis], range) {
            aim.weight = if aim.weight > 0.0 { aim.weight } else { 1.0 };
            changed = true;
        }
    }
    changed
}

fn height_m(crowd: &Crowd, member: MemberId) -> f32 {
    let character = crowd.member(member).and_then(|m| crowd.character(m.character()));
    character.map_or(1.8, |character| character.asset().height_m().max(0.1))
}
