//! A frame of the window: input, panels, crowd, picture.

mod commands;
mod touch;

use std::path::{Path, PathBuf};
use std::time::Instant;

use egui::{CentralPanel, Context, Event, Frame as Border, Modifiers, RawInput, Rect, Ui};
use populace::character::Image;
use populace_film::{Pixels, encode_png};
use populace_render::{Camera, PassTimes, Renderer, TexturePatch};

use crate::Error;
use crate::aims::Aims;
use crate::desk::{Command, Desk, Times};
use crate::film::Recording;
use crate::keys::Held;
use crate::layout::Layout;
use crate::marks::{self, Sight};
use crate::pad::Sticks;
use crate::paint::{self, Frame};
use crate::panels;
use crate::show::{Opener, Wish};
use crate::stage::{Seen, Stage, single};
use crate::theme::{self, PANEL};

/// Input since the last frame.
#[derive(Default)]
pub(crate) struct Input {
    pub(crate) events: Vec<Event>,
    pub(crate) modifiers: Modifiers,
    pub(crate) dropped: Vec<PathBuf>,
    /// Positions of the sticks of the gamepad.
    pub(crate) sticks: Sticks,
    /// Seconds that have passed in the window.
    pub(crate) secs: f64,
    /// Milliseconds since the last frame by the clock on the wall.
    pub(crate) wall_ms: f64,
    /// True if exactly one frame of the show passes instead while it plays.
    pub(crate) one_frame: bool,
}

/// Changes of the crowd in a frame of the window.
#[derive(Clone, Copy, Default)]
struct Changes {
    /// True if it was evaluated.
    is_evaluated: bool,
    /// True if time has been played, which makes a frame of a film. A replay plays nothing.
    is_played: bool,
}

/// A window's contents.
pub(crate) struct Viewer<'a> {
    context: Context,
    pub(crate) renderer: Renderer,
    pub(crate) stage: Stage,
    pub(crate) desk: Desk,
    opener: Box<dyn Opener + 'a>,
    wish: Wish,
    held: Held,
    film: Option<Recording>,
    film_path: PathBuf,
    /// Width and height of the window in pixels, and pixels of a point.
    window: [u32; 2],
    scale: f32,
    now_secs: f64,
    /// The place of the picture in points.
    rect: Rect,
    /// Camera of the last picture; `None` if it must be drawn again.
    drawn: Option<Camera>,
    /// Width over height of the pictures that the show was told; `None` for a new show.
    aspect: Option<f32>,
    /// The last picture with what the show drew over it.
    over: Option<Image>,
    cursor: egui::CursorIcon,
}

impl<'a> Viewer<'a> {
    /// Opens the first show.
    pub(crate) fn new(
        mut renderer: Renderer,
        mut opener: Box<dyn Opener + 'a>,
        (layout, film_path): (Layout, PathBuf),
        (window, scale): ([u32; 2], f32),
    ) -> Result<Self, Error> {
        let context = Context::default();
        theme::apply(&context);
        context
            .options_mut(|options| options.max_passes = 1.try_into().unwrap_or(options.max_passes));
        let wish = Wish::default();
        let stage = Stage::open(&mut *opener, &wish, &mut renderer)?;
        let mut desk = Desk::default();
        desk.layout = layout;
        desk.members = u32::try_from(stage.crowd.member_count()).unwrap_or(u32::MAX);
        let devices = populace::devices().into_iter().filter_map(|report| report.device);
        desk.devices = devices.map(|device| device.to_string()).collect();
        desk.say("Press ? for keys and mouse", 0.0);
        let rect = Rect::NOTHING;
        let (held, film, drawn) = (Held::default(), None, None);
        Ok(Self {
            context,
            renderer,
            stage,
            desk,
            opener,
            wish,
            held,
            film,
            film_path,
            window,
            scale,
            now_secs: 0.0,
            rect,
            drawn,
            aspect: None,
            over: None,
            cursor: egui::CursorIcon::Default,
        })
    }

    pub(crate) fn context(&self) -> &Context {
        &self.context
    }

    pub(crate) fn window(&self) -> [u32; 2] {
        self.window
    }

    /// Changes the size of the window in pixels, and the pixels of a point.
    pub(crate) fn resize(&mut self, window: [u32; 2], scale: f32) {
        (self.window, self.scale) = (window, scale);
        #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
        let [width, height] = window.map(|side| side as f32 / scale);
        (self.desk.layout.width, self.desk.layout.height) = (width, height);
    }

    /// Forgets the keys that are held.
    pub(crate) fn leave(&mut self) {
        self.held.clear();
    }

    /// Returns true if the next frame differs from the last one without any input.
    pub(crate) fn is_moving(&self) -> bool {
        self.desk.clock.plays
            || self.stage.target_secs().is_some()
            || self.held.moves()
            || self.context.has_requested_repaint()
    }

    /// Makes a frame. It is shown by [`present`](Self::present).
    pub(crate) fn frame(&mut self, mut input: Input) -> Result<(), Error> {
        let start = Instant::now();
        self.now_secs += input.secs;
        if let Some(path) = input.dropped.pop() {
            let wish = Wish { dropped: Some(path), ..self.wish.clone() };
            self.reopen(Wish { members: None, ..wish });
        }
        let is_typing = self.context.wants_keyboard_input();
        let pressed = self.held.take(&mut input.events, input.modifiers, is_typing);
        pressed.into_iter().for_each(|key| self.press(key));
        let raw = self.raw_input(&mut input);
        let context = self.context.clone();
        let mut result = Ok(Changes::default());
        let mut panels_ms = 0.0;
        let output = context.run(raw, |context| {
            self.rect = panels::lay_out(context, &mut self.stage, &mut self.desk);
            panels_ms = start.elapsed().as_secs_f64() * 1e3;
            CentralPanel::default().frame(Border::NONE).show(context, |ui| {
                self.touch(ui, &input);
                result = self.advance(&input).inspect(|_| self.mark(ui));
            });
        });
        let changes = result?;
        self.cursor = output.platform_output.cursor_icon;
        let draw_start = Instant::now();
        let passes = self.draw(changes)?;
        let place = self.place();
        paint::paint(&mut self.renderer, &context, output, &place)?;
        let draw = draw_start.elapsed().as_secs_f64() * 1e3;
        let animate = if changes.is_evaluated { self.stage.animate_ms() } else { 0.0 };
        let whole = input.wall_ms;
        self.desk.add_times(Times { whole, animate, draw, panels: panels_ms, passes });
        Ok(())
    }

    /// Shows the frame.
    pub(crate) fn present(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        self.renderer.present()?;
        if let Some(times) = self.desk.times.back_mut() {
            times.draw += start.elapsed().as_secs_f64() * 1e3;
        }
        Ok(())
    }

    fn raw_input(&self, input: &mut Input) -> RawInput {
        #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
        let [width, height] = self.window.map(|side| side as f32 / self.scale);
        let mut raw = RawInput {
            screen_rect: Some(Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height))),
            time: Some(self.now_secs),
            modifiers: input.modifiers,
            events: std::mem::take(&mut input.events),
            focused: true,
            ..RawInput::default()
        };
        if let Some(viewport) = raw.viewports.get_mut(&raw.viewport_id) {
            viewport.native_pixels_per_point = Some(self.scale);
        }
        raw
    }

    /// Returns the place of the picture in pixels: left, top, width and height.
    fn pixels(&self) -> ([i32; 2], [u32; 2]) {
        #[expect(clippy::cast_possible_truncation, reason = "floats saturate")]
        let pixel = |points: f32| (points * self.scale).round() as i32;
        let rect = self.rect;
        let [left, top, right, bottom] =
            [rect.min.x, rect.min.y, rect.max.x, rect.max.y].map(pixel);
        let side = |low: i32, high: i32| high.saturating_sub(low).max(1).unsigned_abs();
        ([left, top], [side(left, right), side(top, bottom)])
    }

    fn place(&self) -> Frame {
        let margin = [PANEL.r(), PANEL.g(), PANEL.b()].map(|byte| f32::from(byte) / 255.0);
        let (at, size) = self.pixels();
        Frame { window: self.window, at, size, margin }
    }

    /// Returns the camera of the picture.
    fn camera(&self) -> Result<Camera, Error> {
        Ok(self.desk.rig.camera(&self.stage.shown_camera()?))
    }

    /// Does what the panels wished for, and lets time pass.
    fn advance(&mut self, input: &Input) -> Result<Changes, Error> {
        self.fit()?;
        let mut refresh = false;
        for command in std::mem::take(&mut self.desk.commands) {
            refresh |= command == Command::Refresh;
            self.carry_out(command)?;
        }
        self.aim();
        let frame_secs = 1.0 / self.stage.rate().per_sec();
        let secs = match input.one_frame || self.film.is_some() {
            true if self.desk.clock.plays => frame_secs,
            true => 0.0,
            false => self.desk.clock.passed_secs(input.secs),
        };
        let mut seen = Seen {
            rig: self.desk.rig,
            member: self.stage.you().or(self.desk.picked),
            secs: single(input.secs),
            size: self.pixels().1,
        };
        let mut changes = Changes { is_evaluated: true, is_played: false };
        if self.stage.target_secs().is_some() {
            self.stage.replay(&mut seen)?;
        } else if secs > 0.0 {
            let steering = self.held.steering().with(input.sticks.steering());
            let before_secs = self.stage.secs();
            if !self.stage.play(secs, steering, &mut seen)? {
                self.desk.clock.plays = false;
            }
            changes.is_played = self.stage.secs() > before_secs;
        } else {
            self.stage.follow(&mut seen);
            let camera = seen.rig.camera(&self.stage.shown_camera()?);
            changes.is_evaluated = refresh || self.drawn != Some(camera);
            // A camera that has moved sees other members, in other detail.
            if changes.is_evaluated {
                self.stage.refresh(&mut seen)?;
            }
        }
        self.desk.rig = seen.rig;
        if changes.is_evaluated {
            self.drawn = None;
        }
        Ok(changes)
    }

    /// Sets the targets of members where they are now.
    fn aim(&mut self) {
        let mut error = None;
        for (member, edits) in &self.desk.edits {
            if edits.aims == Aims::default() {
                continue;
            }
            if let Some(placement) = self.stage.placement(*member) {
                let applied = edits.aims.apply(&mut self.stage.crowd, *member, &placement);
                error = error.or(applied.err());
            }
        }
        if let Some(error) = error {
            self.desk.say(error.to_string(), self.now_secs);
        }
    }

    /// Gives the picture the size of its place.
    fn fit(&mut self) -> Result<(), Error> {
        let (_, size) = self.pixels();
        if size != self.renderer.size() {
            self.renderer.resize(size)?;
            self.drawn = None;
            self.end_film();
        }
        #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
        let [width, height] = size.map(|side| side as f32);
        if self.aspect.replace(width / height) == Some(width / height) {
            return Ok(());
        }
        self.stage.set_aspect(width / height).map_err(Error::Show)
    }

    /// Draws lines and words over the picture.
    fn mark(&mut self, ui: &Ui) {
        let Ok(camera) = self.camera() else { return };
        let sight = Sight { camera, rect: self.rect, size: self.pixels().1, scale: self.scale };
        marks::draw(ui, &mut self.stage, &self.desk, &sight);
        if let Some(text) = self.desk.message(self.now_secs) {
            marks::message(ui, self.rect, text);
        }
    }

    /// Draws the picture, if it would differ from the last one, and adds what was played to the
    /// film.
    fn draw(&mut self, changes: Changes) -> Result<PassTimes, Error> {
        let camera = self.camera()?;
        let mut passes = self.desk.times.back().map(|times| times.passes).unwrap_or_default();
        let is_new = self.drawn != Some(camera);
        if is_new {
            let scene = *self.stage.scene();
            self.renderer.draw(&mut self.stage.crowd, &camera, &scene)?;
            self.drawn = Some(camera);
            self.over = self.draw_over(&camera)?;
            if self.desk.layout.times {
                passes = self.renderer.pass_times()?;
            }
        }
        let size = self.renderer.size();
        if let Some(film) = self.film.as_mut().filter(|film| film.takes(size)) {
            if changes.is_played {
                let picture = match &self.over {
                    Some(over) => over.clone(),
                    None => self.renderer.read_image()?,
                };
                film.push(picture)?;
            }
            self.desk.film = Some((film.path().display().to_string(), film.frames()));
        }
        Ok(passes)
    }

    /// Reads the last picture back, without panels and marks.
    pub(crate) fn picture(&mut self) -> Result<Image, Error> {
        match &self.over {
            Some(over) => Ok(over.clone()),
            None => Ok(self.renderer.read_image()?),
        }
    }

    /// Writes a picture as PNG.
    pub(crate) fn write(&mut self, path: &Path, image: &Image) -> Result<(), Error> {
        let png = encode_png([image.width, image.height], Pixels::Rgba(&image.rgba))?;
        self.opener.write(path, &png).map_err(Error::Show)
    }

    /// Reads the picture back and draws over it, if the show does so, for the window to show that
    /// in its place.
    fn draw_over(&mut self, camera: &Camera) -> Result<Option<Image>, Error> {
        if !self.stage.show.has_overlay() {
            self.renderer.remove_texture(paint::OVER);
            return Ok(None);
        }
        let mut picture = self.renderer.read_image()?;
        self.stage.show.overlay(&mut picture, camera).map_err(Error::Show)?;
        self.renderer.set_texture(&TexturePatch {
            texture: paint::OVER,
            at: None,
            size: [picture.width, picture.height],
            rgba: &picture.rgba,
        })?;
        Ok(Some(picture))
    }

    /// Returns the shape of the pointer.
    pub(crate) fn cursor(&self) -> egui::CursorIcon {
        self.cursor
    }
}
