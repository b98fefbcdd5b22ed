//! The look of the panels, and their font.

use std::sync::Arc;

use egui::{
    Color32, Context, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke,
    TextStyle, Visuals,
};

/// Colour of what is picked and of what is drawn over the picture.
pub(crate) const ACCENT: Color32 = Color32::from_rgb(255, 190, 70);
/// Colour of words that explain.
pub(crate) const QUIET: Color32 = Color32::from_rgb(160, 166, 176);
/// Background of panels.
pub(crate) const PANEL: Color32 = Color32::from_rgb(28, 31, 37);
/// Width of the panel at the right in points.
pub(crate) const PANEL_WIDTH: f32 = 250.0;
const NAME: &str = "strokes";

/// Sets font and colours.
pub(crate) fn apply(context: &Context) {
    let mut fonts = FontDefinitions::empty();
    let font = FontData::from_owned(populace_overlay::truetype());
    fonts.font_data.insert(NAME.into(), Arc::new(font));
    for family in [FontFamily::Proportional, FontFamily::Monospace] {
        fonts.families.insert(family, vec![NAME.into()]);
    }
    context.set_fonts(fonts);
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        style.visuals = visuals();
        let size = |size| FontId::new(size, FontFamily::Proportional);
        style.text_styles = [
            (TextStyle::Small, size(11.5)),
            (TextStyle::Body, size(13.5)),
            (TextStyle::Button, size(13.5)),
            (TextStyle::Heading, size(17.0)),
            (TextStyle::Monospace, size(13.5)),
        ]
        .into();
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.spacing.button_padding = egui::vec2(7.0, 2.5);
        style.spacing.slider_width = 130.0;
        style.interaction.selectable_labels = false;
    });
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.extreme_bg_color = Color32::from_rgb(17, 19, 23);
    visuals.override_text_color = Some(Color32::from_rgb(224, 227, 232));
    visuals.selection.bg_fill = Color32::from_rgb(52, 96, 156);
    visuals.slider_trailing_fill = true;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(52, 57, 66));
    for state in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active] {
        state.corner_radius = CornerRadius::same(4);
    }
    widgets.inactive.weak_bg_fill = Color32::from_rgb(50, 55, 64);
    widgets.inactive.bg_fill = Color32::from_rgb(60, 66, 77);
    widgets.hovered.weak_bg_fill = Color32::from_rgb(64, 71, 84);
    widgets.active.weak_bg_fill = Color32::from_rgb(52, 96, 156);
    visuals
}
