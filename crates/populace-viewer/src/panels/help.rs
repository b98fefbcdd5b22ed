//! Keys and mouse.

use egui::{Align2, Context, Grid, RichText, Window};

use crate::desk::Desk;
use crate::theme::ACCENT;

/// Sticks of a gamepad, where the program knows gamepads.
const STICKS: &[(&str, &str)] =
    &[("left stick", "walk and turn as \"you\""), ("right stick", "turn the camera")];
/// Keys and what they do, by group.
const GROUPS: [(&str, &[(&str, &str)]); 4] = [
    (
        "Camera",
        &[
            ("drag left", "turn around a point; in flight, look around"),
            ("drag middle, Shift + drag", "move the picture"),
            ("wheel", "nearer, farther"),
            ("right mouse + W A S D Q E", "fly; Shift is faster"),
            ("1  2  3  4", "as given, orbit, fly, follow"),
            ("F", "look at who is picked"),
        ],
    ),
    (
        "People",
        &[
            ("click", "pick somebody; Esc picks nobody"),
            ("Y", "be this person, or leave"),
            ("arrow keys", "walk and turn as this person; Shift runs"),
            ("R  G", "fall as a ragdoll, get up"),
        ],
    ),
    (
        "Time",
        &[
            ("Space", "play, pause"),
            (",  .", "one frame back, on"),
            ("[  ]", "slower, faster"),
            ("Home", "to the beginning"),
            ("V", "record to MP4, stop"),
        ],
    ),
    (
        "Window",
        &[
            ("Tab", "show or hide the panels"),
            ("T  K  B  L", "times, skeletons, bounds, levels of detail"),
            ("drop a file", "open it"),
            ("?", "this list"),
        ],
    ),
];

pub(super) fn show(context: &Context, desk: &mut Desk) {
    let mut is_open = true;
    Window::new("Keys and mouse")
        .open(&mut is_open)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .resizable(false)
        .collapsible(false)
        .show(context, |ui| {
            Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
                let sticks = Some(("Gamepad", STICKS)).filter(|_| cfg!(feature = "gamepad"));
                for (title, keys) in GROUPS.into_iter().chain(sticks) {
                    ui.label(RichText::new(title).color(ACCENT));
                    ui.end_row();
                    for (key, words) in keys {
                        ui.label(*key);
                        ui.label(*words);
                        ui.end_row();
                    }
                }
            });
        });
    desk.help = is_open;
}
