//! The panels around the picture.

mod crowd;
mod help;
mod member;
mod targets;
mod timeline;
mod times;

use egui::{Context, Frame, Margin, Rect, ScrollArea, SidePanel, TopBottomPanel, Ui};

use crate::desk::{Desk, Page};
use crate::stage::Stage;
use crate::theme::{PANEL, PANEL_WIDTH};

/// Lays out the panels, and returns the rectangle that they leave to the picture, in points.
pub(crate) fn lay_out(context: &Context, stage: &mut Stage, desk: &mut Desk) -> Rect {
    desk.widgets.clear();
    if desk.layout.panels {
        let frame = Frame::new().fill(PANEL).inner_margin(Margin::symmetric(10, 8));
        TopBottomPanel::bottom("timeline")
            .frame(frame)
            .resizable(false)
            .show(context, |ui| timeline::show(ui, stage, desk));
        SidePanel::right("side")
            .frame(frame)
            .resizable(false)
            .exact_width(PANEL_WIDTH)
            .show(context, |ui| side(ui, stage, desk));
    }
    if desk.layout.times {
        times::show(context, stage, desk);
    }
    if desk.help {
        help::show(context, desk);
    }
    context.available_rect()
}

/// Lays out the panel at the right: the crowd, or who is picked.
fn side(ui: &mut Ui, stage: &mut Stage, desk: &mut Desk) {
    ui.horizontal(|ui| {
        for (page, name) in [(Page::Crowd, "Crowd"), (Page::Member, "Member")] {
            let chosen = desk.page == page;
            let response = ui.add_sized([104.0, 24.0], egui::Button::selectable(chosen, name));
            if desk.widgets.note(name, response).clicked() {
                desk.page = page;
            }
        }
    });
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match desk.page {
        Page::Crowd => crowd::show(ui, stage, desk),
        Page::Member => member::show(ui, stage, desk),
    });
}
