//! Lines and words over the picture: who is picked, skeletons, bounds and levels of detail.

use std::f32::consts::TAU;

use egui::{Align2, Color32, Painter, Pos2, Rect, Stroke, TextStyle, Ui};
use glam::Vec3;
use populace::MemberId;
use populace::interop::Visibility;
use populace_render::Camera;

use crate::desk::Desk;
use crate::pick::limbs;
use crate::stage::Stage;
use crate::theme::ACCENT;

/// Corners of the ring around the feet of who is picked.
const RING_CORNERS: u8 = 28;
/// Radius of the ring as a share of the height.
const RING: f32 = 0.25;
/// Skeletons that are drawn, at most.
const MOST_SKELETONS: usize = 48;
const SKELETON: Color32 = Color32::from_rgb(120, 235, 255);
const BOUNDS: Color32 = Color32::from_rgb(150, 220, 120);
/// Colours of levels of detail, from full detail on.
const LEVELS: [Color32; 5] = [
    Color32::from_rgb(255, 255, 255),
    Color32::from_rgb(150, 225, 130),
    Color32::from_rgb(255, 215, 90),
    Color32::from_rgb(255, 150, 70),
    Color32::from_rgb(255, 95, 95),
];

/// A picture on the screen.
pub(crate) struct Sight {
    pub(crate) camera: Camera,
    /// Its place in points.
    pub(crate) rect: Rect,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    /// Pixels of a point.
    pub(crate) scale: f32,
}

impl Sight {
    fn point(&self, at: Vec3) -> Option<Pos2> {
        let [x, y] = self.camera.project(at.to_array(), self.size)?;
        let far = 4.0 * (self.size[0].max(self.size[1])) as f32;
        let is_near = x.abs() < far && y.abs() < far;
        is_near.then(|| self.rect.min + egui::vec2(x, y) / self.scale)
    }

    fn line(&self, painter: &Painter, [from, to]: [Vec3; 2], stroke: Stroke) {
        if let (Some(from), Some(to)) = (self.point(from), self.point(to)) {
            painter.line_segment([from, to], stroke);
        }
    }
}

/// Draws what the desk asks for.
pub(crate) fn draw(ui: &Ui, stage: &mut Stage, desk: &Desk, sight: &Sight) {
    let painter = ui.painter_at(sight.rect);
    let visible: Vec<MemberId> = stage
        .crowd
        .members()
        .filter(|member| member.instance().visibility == Visibility::InView)
        .map(|member| member.id())
        .collect();
    if desk.layout.skeletons {
        skeletons(&painter, stage, &visible, sight);
    }
    for member in visible {
        if desk.layout.bounds {
            bounds(&painter, stage, member, sight);
        }
        if desk.layout.levels {
            level(ui, &painter, stage, member, sight);
        }
    }
    if let Some(member) = desk.picked {
        ring(&painter, stage, member, sight);
    }
}

fn ring(painter: &Painter, stage: &mut Stage, member: MemberId, sight: &Sight) {
    let Some(followed) = stage.followed(member) else { return };
    let radius_m = RING * followed.height_m;
    let corner = |nth: u8| {
        let angle = TAU * f32::from(nth) / f32::from(RING_CORNERS);
        let (sine, cosine) = angle.sin_cos();
        followed.feet + radius_m * Vec3::new(sine, 0.0, cosine)
    };
    for nth in 0..RING_CORNERS {
        sight.line(painter, [corner(nth), corner(nth + 1)], Stroke::new(2.5, ACCENT));
    }
}

/// Draws the skeletons of the nearest members. Each is evaluated again, since the fused schedules
/// store no joints.
fn skeletons(painter: &Painter, stage: &mut Stage, members: &[MemberId], sight: &Sight) {
    let eye = Vec3::from(sight.camera.eye);
    let mut near: Vec<(f32, MemberId)> = members
        .iter()
        .filter_map(|member| {
            let (center, _) = stage.crowd.member(*member).ok()?.bounding_sphere();
            Some((eye.distance(Vec3::from(center)), *member))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, member) in near.into_iter().take(MOST_SKELETONS) {
        for limb in limbs(stage, member).unwrap_or_default() {
            sight.line(painter, limb, Stroke::new(1.2, SKELETON));
        }
    }
}

fn bounds(painter: &Painter, stage: &Stage, member: MemberId, sight: &Sight) {
    let Ok(view) = stage.crowd.member(member) else { return };
    let (center, radius_m) = view.bounding_sphere();
    let center = Vec3::from(center);
    let [eye, target] = [sight.camera.eye, sight.camera.target].map(Vec3::from);
    let depth_m = (center - eye).dot((target - eye).normalize_or_zero());
    if let Some(at) = sight.point(center) {
        let slope = (0.5 * sight.camera.fov_y_rad).tan();
        let radius = 0.5 * sight.rect.height() * radius_m / (slope * depth_m);
        painter.circle_stroke(at, radius, Stroke::new(1.0, BOUNDS));
    }
}

fn level(ui: &Ui, painter: &Painter, stage: &Stage, member: MemberId, sight: &Sight) {
    let (Some(height_m), Ok(view)) = (stage.height_m(member), stage.crowd.member(member)) else {
        return;
    };
    let level = view.instance().level as usize;
    // The sphere goes along with root motion, without asking the device.
    let [x, _, z] = view.bounding_sphere().0;
    let over = Vec3::new(x, view.placement().position()[1] + 1.08 * height_m, z);
    if let Some(at) = sight.point(over) {
        let color = LEVELS[level.min(LEVELS.len() - 1)];
        let font = TextStyle::Body.resolve(ui.style());
        let text = level.to_string();
        let shadow = Color32::from_black_alpha(200);
        painter.text(at + egui::vec2(1.0, 1.0), Align2::CENTER_BOTTOM, &text, font.clone(), shadow);
        painter.text(at, Align2::CENTER_BOTTOM, text, font, color);
    }
}

/// Shows a message at the top of the picture.
pub(crate) fn message(ui: &Ui, rect: Rect, text: &str) {
    let painter = ui.painter_at(rect);
    let font = TextStyle::Body.resolve(ui.style());
    let width = (rect.width() - 60.0).max(60.0);
    let galley = painter.layout(text.to_owned(), font, Color32::WHITE, width);
    let at = rect.center_top() + egui::vec2(-0.5 * galley.size().x, 14.0);
    let back = Rect::from_min_size(at, galley.size()).expand2(egui::vec2(12.0, 6.0));
    painter.rect_filled(back, 6.0, Color32::from_black_alpha(190));
    painter.galley(at, galley, Color32::WHITE);
}
