//! The window: opened by winit, drawn into by the renderer.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::CursorIcon as Icon;
use populace_render::Renderer;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::Error;
use crate::desk::Command;
use crate::input::Translator;
use crate::layout::Layout;
use crate::pad::{Pads, Sticks};
use crate::script::{Run, Script, ScriptReport};
use crate::show::Opener;
use crate::viewer::{Input, Viewer};

/// Smallest window in points.
const LEAST: [f64; 2] = [480.0, 320.0];

/// How a window is opened.
#[derive(Clone, Debug, Default)]
pub struct WindowSettings {
    /// Size and panels.
    pub layout: Layout,
    /// Width and height in pixels, in place of those of the layout.
    pub size: Option<[u32; 2]>,
    /// Time at which the show begins, in seconds.
    pub at_secs: f64,
    /// What drives the window in place of a person.
    pub script: Option<Script>,
    /// Path of films; a number is added to its name.
    pub film: PathBuf,
}

/// Report and layout of a window that was closed.
#[derive(Clone, Debug, Default)]
pub struct Closed {
    /// Size and panels when it was closed.
    pub layout: Layout,
    /// Times of its frames, and of input if a script drove it.
    pub report: ScriptReport,
}

/// Opens a window with a show, and returns when it was closed.
///
/// # Errors
///
/// [`Error::NoDisplay`] without a display, [`Error::Show`] if the first show cannot be opened,
/// [`Error::Expected`] for a script that finds something else, and failures of the device or of the
/// driver.
pub fn run(opener: Box<dyn Opener + '_>, settings: WindowSettings) -> Result<Closed, Error> {
    let no_display = |cause: String| Error::NoDisplay { cause };
    let event_loop = EventLoop::new().map_err(|error| no_display(cause_of(&error)))?;
    let run = Run::new(settings.script.clone());
    let mut app = App {
        settings,
        opener: Some(opener),
        open: None,
        run,
        translator: Translator::default(),
        input: Input::default(),
        pads: Pads::open(),
        is_left: false,
        last: Instant::now(),
        failure: None,
        layout: Layout::default(),
    };
    let ended = event_loop.run_app(&mut app);
    app.close();
    if let Some(failure) = app.failure {
        return Err(failure);
    }
    ended.map_err(|error| Error::Window { cause: error.to_string() })?;
    Ok(Closed { layout: app.layout, report: app.run.into_report() })
}

/// A window and its contents.
struct Open<'a> {
    viewer: Viewer<'a>,
    window: Arc<Window>,
}

struct App<'a> {
    settings: WindowSettings,
    /// Taken when the window is opened.
    opener: Option<Box<dyn Opener + 'a>>,
    open: Option<Open<'a>>,
    run: Run,
    translator: Translator,
    /// What came since the last frame.
    input: Input,
    pads: Pads,
    /// True while another window has the keyboard, and with it the gamepad.
    is_left: bool,
    last: Instant,
    failure: Option<Error>,
    layout: Layout,
}

/// Returns the message of an error of the system without the line of winit's source in which it was
/// noticed, which such errors begin with: "os error at PATH:LINE: ".
fn cause_of(error: &impl std::fmt::Display) -> String {
    let text = error.to_string();
    let cause = text.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
    cause.map_or_else(|| text.clone(), |(_, cause)| cause.trim_end_matches('.').to_owned())
}

impl App<'_> {
    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Error> {
        let Some(opener) = self.opener.take() else { return Ok(()) };
        let layout = self.settings.layout.clone();
        let mut attributes = Window::default_attributes()
            .with_title("Populace")
            .with_min_inner_size(LogicalSize::new(LEAST[0], LEAST[1]));
        attributes = match self.settings.size {
            Some([width, height]) => attributes.with_inner_size(PhysicalSize::new(width, height)),
            None => attributes.with_inner_size(LogicalSize::new(layout.width, layout.height)),
        };
        let cause = |error: winit::error::OsError| Error::Window { cause: cause_of(&error) };
        let window = Arc::new(event_loop.create_window(attributes).map_err(cause)?);
        let PhysicalSize { width, height } = window.inner_size();
        let size = [width.max(1), height.max(1)];
        let renderer = Renderer::in_window(window.clone(), size)?;
        let scale = scale_of(&window);
        let film = self.settings.film.clone();
        let mut viewer = Viewer::new(renderer, opener, (layout, film), (size, scale))?;
        viewer.resize(size, scale);
        if self.settings.at_secs > 0.0 {
            viewer.desk.wish(Command::Seek(self.settings.at_secs));
        }
        window.set_title(&title(&viewer));
        self.last = Instant::now();
        self.open = Some(Open { viewer, window });
        Ok(())
    }

    /// Makes and shows a frame.
    fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Error> {
        let Some(Open { viewer, window }) = &mut self.open else { return Ok(()) };
        let mut input = std::mem::take(&mut self.input);
        input.modifiers = self.translator.modifiers;
        input.secs = self.last.elapsed().as_secs_f64();
        input.wall_ms = input.secs * 1e3;
        self.last = Instant::now();
        self.run.feed(viewer, &mut input)?;
        let opens = !input.dropped.is_empty();
        viewer.frame(input)?;
        self.run.look(viewer)?;
        window.pre_present_notify();
        viewer.present()?;
        self.run.shown(viewer, self.last.elapsed().as_secs_f64());
        if self.run.quits() {
            event_loop.exit();
        }
        if opens {
            window.set_title(&title(viewer));
        }
        window.set_cursor(cursor(viewer.cursor()));
        Ok(())
    }

    /// Ends the program with an error.
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        self.failure = self.failure.take().or(Some(error));
        event_loop.exit();
    }

    /// Completes the film and takes the layout over.
    fn close(&mut self) {
        if let Some(mut open) = self.open.take() {
            open.viewer.end_film();
            self.layout = open.viewer.desk.layout.clone();
        }
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Err(error) = self.open(event_loop) {
            self.fail(event_loop, error);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(Open { viewer, window }) = &mut self.open else { return };
        let scale = scale_of(window);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.frame(event_loop) {
                    self.fail(event_loop, error);
                }
                return;
            }
            WindowEvent::Resized(PhysicalSize { width, height }) => {
                viewer.resize([width.max(1), height.max(1)], scale);
            }
            WindowEvent::DroppedFile(path) => self.input.dropped.push(path),
            WindowEvent::Focused(false) => {
                self.is_left = true;
                viewer.leave();
            }
            WindowEvent::Focused(true) => self.is_left = false,
            event => self.translator.translate(&event, scale.into(), &mut self.input.events),
        }
        window.request_redraw();
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(Open { viewer, window }) = &self.open else { return };
        let sticks = self.pads.read();
        self.input.sticks = if self.is_left { Sticks::default() } else { sticks };
        if self.run.is_scripted() || viewer.is_moving() || self.input.sticks.moves() {
            event_loop.set_control_flow(ControlFlow::Poll);
            window.request_redraw();
        } else {
            let wait = self.pads.wait_secs().map(Duration::from_secs_f64);
            event_loop.set_control_flow(match wait {
                Some(wait) => ControlFlow::WaitUntil(Instant::now() + wait),
                None => ControlFlow::Wait,
            });
        }
    }
}

/// Returns the number of pixels of a point.
fn scale_of(window: &Window) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "a small number")]
    let scale = window.scale_factor() as f32;
    scale
}

fn title(viewer: &Viewer) -> String {
    format!("{} - Populace", viewer.stage.show.title())
}

fn cursor(icon: Icon) -> winit::window::CursorIcon {
    use winit::window::CursorIcon;
    match icon {
        Icon::PointingHand => CursorIcon::Pointer,
        Icon::Text => CursorIcon::Text,
        Icon::ResizeHorizontal => CursorIcon::EwResize,
        Icon::Grab => CursorIcon::Grab,
        Icon::Grabbing => CursorIcon::Grabbing,
        _ => CursorIcon::Default,
    }
}
