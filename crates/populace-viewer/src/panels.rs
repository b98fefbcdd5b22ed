//! The panels around the picture.

mod crowd;
mod help;
mod member;
mod targets;
mod times;
mod timeline;

use egui::{Context, Frame, Margin, Rect, ScrollArea, SidePanel, TopBottomPanel};

use crate::desk::Desk;
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
        SidePanel::right("side").frame(frame).resizable(false).exact_width(PANEL_WIDTH).show(
            context,
            |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    crowd::show(ui, stage, desk);
                    times::show(ui, stage, desk);
                    member::show(ui, stage, desk);
                });
            },
        );
    }
    if desk.help {
        help::show(context, desk);
    }
    context.available_rect()
}
