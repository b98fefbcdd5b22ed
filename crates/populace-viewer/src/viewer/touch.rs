//! The camera, moved by mouse, keys and gamepad; members, picked by mouse.

use egui::Ui;

use super::{Input, Viewer};
use crate::camera::Mode;
use crate::desk::Page;
use crate::pick::{self, Ray};
use crate::stage::single;

impl Viewer<'_> {
    /// Moves the camera and picks members by the mouse, and turns the camera by a gamepad.
    pub(super) fn touch(&mut self, ui: &mut Ui, input: &Input) {
        let response = ui.allocate_rect(self.rect, egui::Sense::click_and_drag());
        let secs = single(input.secs);
        let Ok(shown) = self.stage.shown_camera() else { return };
        let (shift, wheel) = ui.input(|i| (i.modifiers.shift, i.raw_scroll_delta.y));
        let by = response.drag_delta() / self.rect.height().max(1.0);
        let by = [by.x, by.y];
        let rig = &mut self.desk.rig;
        let [left, middle, right] = [
            egui::PointerButton::Primary,
            egui::PointerButton::Middle,
            egui::PointerButton::Secondary,
        ]
        .map(|button| response.dragged_by(button));
        if right {
            rig.set_mode(Mode::Fly, &shown);
            rig.turn(by, &shown);
        } else if middle || left && shift {
            rig.pan(by, &shown);
        } else if left {
            rig.turn(by, &shown);
        }
        if response.contains_pointer() && wheel != 0.0 {
            rig.zoom(wheel / 40.0, &shown);
        }
        let by = input.sticks.turn(secs);
        if by != [0.0; 2] {
            rig.turn(by, &shown);
        }
        let flight = self.held.flight();
        if flight != [0.0; 3] && (rig.mode() == Mode::Fly || self.stage.you().is_none()) {
            rig.fly(flight.map(|speed| speed * secs), &shown);
        }
        if response.clicked()
            && let Some(at) = response.interact_pointer_pos()
        {
            let at = at - self.rect.min;
            let ray = Ray::new(&rig.camera(&shown), at.into(), self.rect.size().into());
            self.desk.picked = ray.and_then(|ray| pick::pick(&mut self.stage, &ray));
            if self.desk.picked.is_some() {
                self.desk.page = Page::Member;
            }
        }
    }
}
