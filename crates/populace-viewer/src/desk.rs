//! State beside the picture: the picked member, choices and wishes.

use std::collections::{HashMap, VecDeque};

use egui::{Rect, Response, Ui};
use populace::MemberId;
use populace_render::PassTimes;

use crate::aims::Aims;
use crate::camera::Rig;
use crate::clock::Clock;
use crate::layout::Layout;

/// Number of frames in the graph of times.
pub(crate) const GRAPH_FRAMES: usize = 160;
/// How long a message is shown, in seconds.
const MESSAGE_SECS: f64 = 5.0;
/// Number of layers above the lowest.
pub(crate) const UPPER_LAYERS: usize = 3;

/// A thing to do once the panels are laid out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    /// Goes to a time in seconds.
    Seek(f64),
    /// Pauses at the next frame, or at the one before.
    Step {
        later: bool,
    },
    /// Evaluates the present time again, since a member was changed.
    Refresh,
    /// Looks at a member and goes round it.
    Frame(MemberId),
    Follow(MemberId),
    /// Lets the keyboard drive a member, or lets go of it.
    Drive(MemberId),
    Fall(MemberId),
    GetUp(MemberId),
    /// Opens the show again.
    Reopen {
        members: Option<u32>,
        device: Option<String>,
        schedule: Option<populace::Schedule>,
    },
    /// Begins or ends a film.
    Record,
}

/// Milliseconds of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Times {
    /// From one picture to the next.
    pub(crate) whole: f64,
    /// Evaluation of the crowd, with what moves it.
    pub(crate) animate: f64,
    /// Drawing and showing the picture.
    pub(crate) draw: f64,
    /// Laying out the panels.
    pub(crate) panels: f64,
    pub(crate) passes: PassTimes,
}

/// The page of the panel at the right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Page {
    #[default]
    Crowd,
    Member,
}

/// A layer as it was set here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LayerEdit {
    pub(crate) weight: f32,
    pub(crate) additive: bool,
    /// Index of its mask among those that can be chosen; 0 for all joints.
    pub(crate) mask: usize,
}

impl Default for LayerEdit {
    fn default() -> Self {
        Self { weight: 1.0, additive: false, mask: 0 }
    }
}

/// Settings of a member that were made here.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edits {
    pub(crate) aims: Aims,
    pub(crate) layers: [LayerEdit; UPPER_LAYERS],
    /// Index of the clip to play next, and its layer.
    pub(crate) clip: usize,
    pub(crate) layer: usize,
}

/// The places of named widgets in the last frame, for scripts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Widgets {
    places: HashMap<String, Rect>,
}

impl Widgets {
    /// Notes the place of a widget.
    pub(crate) fn note(&mut self, name: &str, response: Response) -> Response {
        self.places.insert(name.to_owned(), response.interact_rect);
        response
    }

    pub(crate) fn clear(&mut self) {
        self.places.clear();
    }

    /// Returns the place of a widget in points.
    pub(crate) fn place(&self, name: &str) -> Option<Rect> {
        self.places.get(name).copied()
    }

    /// Returns all names in order.
    pub(crate) fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.places.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }
}

/// The desk.
#[derive(Default)]
pub(crate) struct Desk {
    pub(crate) layout: Layout,
    pub(crate) picked: Option<MemberId>,
    pub(crate) rig: Rig,
    pub(crate) clock: Clock,
    pub(crate) help: bool,
    pub(crate) page: Page,
    pub(crate) edits: HashMap<MemberId, Edits>,
    pub(crate) widgets: Widgets,
    pub(crate) commands: Vec<Command>,
    pub(crate) times: VecDeque<Times>,
    /// Number of members, device and schedule as they are chosen in the panel.
    pub(crate) members: u32,
    /// Devices that can be chosen.
    pub(crate) devices: Vec<String>,
    /// Path and frames of the film that is being made.
    pub(crate) film: Option<(String, u32)>,
    message: Option<(String, f64)>,
}

impl Desk {
    /// Says something for a few seconds.
    pub(crate) fn say(&mut self, text: impl Into<String>, now_secs: f64) {
        self.message = Some((text.into(), now_secs + MESSAGE_SECS));
    }

    /// Returns what is to be said now.
    pub(crate) fn message(&self, now_secs: f64) -> Option<&str> {
        self.message.as_ref().filter(|(_, until)| now_secs < *until).map(|(text, _)| text.as_str())
    }

    pub(crate) fn wish(&mut self, command: Command) {
        self.commands.push(command);
    }

    pub(crate) fn add_times(&mut self, times: Times) {
        if self.times.len() == GRAPH_FRAMES {
            self.times.pop_front();
        }
        self.times.push_back(times);
    }

    /// Forgets the layers that members had at a later time.
    pub(crate) fn forget_layers(&mut self) {
        self.edits.values_mut().for_each(|edits| edits.layers = Default::default());
    }

    /// Forgets members of a crowd that is gone.
    pub(crate) fn forget(&mut self) {
        self.picked = None;
        self.edits.clear();
    }

    /// Adds a button that scripts can name.
    pub(crate) fn button(&mut self, ui: &mut Ui, name: &str) -> bool {
        let response = ui.button(name);
        self.widgets.note(name, response).clicked()
    }

    /// Adds a line with a name, a slider and its value. Scripts know it by `key`.
    pub(crate) fn slider(
        &mut self,
        ui: &mut Ui,
        (key, label): (&str, &str),
        value: &mut f32,
        range: std::ops::RangeInclusive<f32>,
    ) -> bool {
        ui.horizontal(|ui| {
            let size = egui::vec2(58.0, ui.spacing().interact_size.y);
            let label = egui::Label::new(label).truncate();
            ui.allocate_ui_with_layout(
                size,
                egui::Layout::left_to_right(egui::Align::Center),
                |ui| {
                    ui.set_min_width(size.x);
                    ui.add(label)
                },
            );
            ui.spacing_mut().slider_width = (ui.available_width() - 56.0).max(40.0);
            let slider = egui::Slider::new(value, range.clone()).show_value(false);
            let response = ui.add(slider);
            let changed = self.widgets.note(key, response).changed();
            let speed = 0.005 * (range.end() - range.start());
            let number = egui::DragValue::new(value).range(range).speed(speed).fixed_decimals(2);
            ui.add_sized([46.0, 18.0], number).changed() || changed
        })
        .inner
    }
}
