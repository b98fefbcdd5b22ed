//! Scripts: what somebody does with mouse and keyboard, line by line.

mod line;
mod report;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::Instant;

use egui::{Event, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2};

use crate::Error;
use crate::desk::Command;
use crate::pad::Sticks;
use crate::viewer::{Input, Viewer};
use line::{Action, Expected, Line};
pub use report::{InputTime, ScriptReport};

/// Frames over which a pointer is dragged.
const DRAG_FRAMES: u8 = 8;
/// Frames for which a line waits for the widget that it names.
const MOST_WAITED: u8 = 10;
/// Half the width of a slider's handle as a share of its height.
const HANDLE: f32 = 0.3;

/// A script that drives a window.
#[derive(Clone, Debug)]
pub struct Script {
    lines: Vec<Line>,
}

impl Script {
    /// Reads a script. Paths in it are relative to `folder`.
    ///
    /// # Errors
    ///
    /// [`Error::Script`] with the first line that cannot be read.
    pub fn parse(text: &str, folder: &Path) -> Result<Self, Error> {
        Ok(Self { lines: line::parse(text, folder)? })
    }
}

/// The events before one frame.
#[derive(Clone, Debug, Default)]
struct Batch {
    events: Vec<Event>,
    modifiers: Modifiers,
    dropped: Vec<PathBuf>,
    sticks: Sticks,
}

/// Input that no picture shows yet.
struct Waiting {
    line: usize,
    words: String,
    /// Number of frames that were shown before it.
    shown: u32,
    came: Instant,
}

/// A script that is being carried out.
pub(crate) struct Run {
    lines: VecDeque<Line>,
    batches: VecDeque<Batch>,
    /// The line whose events are under way, and its words.
    current: Option<(usize, String)>,
    waiting: Option<Waiting>,
    report: ScriptReport,
    /// Frames for which the next line has waited.
    waited: u8,
    /// Number of frames that were shown.
    shown: u32,
    script_secs: f64,
    is_real_time: bool,
    start: Instant,
    quits: bool,
    is_scripted: bool,
}

impl Run {
    /// Begins to carry out a script; without one, only times are taken.
    pub(crate) fn new(script: Option<Script>) -> Self {
        let is_scripted = script.is_some();
        Self {
            lines: script.map(|script| script.lines).unwrap_or_default().into(),
            batches: VecDeque::new(),
            current: None,
            waiting: None,
            waited: 0,
            report: ScriptReport::default(),
            shown: 0,
            script_secs: 0.0,
            is_real_time: false,
            start: Instant::now(),
            quits: false,
            is_scripted,
        }
    }

    /// Returns true if there is a script.
    pub(crate) fn is_scripted(&self) -> bool {
        self.is_scripted
    }

    /// Returns true if the window is to be closed.
    pub(crate) fn quits(&self) -> bool {
        self.quits
    }

    pub(crate) fn into_report(self) -> ScriptReport {
        self.report
    }

    /// Adds what the script does before the next frame.
    pub(crate) fn feed(&mut self, viewer: &Viewer, input: &mut Input) -> Result<(), Error> {
        if !self.is_scripted {
            return Ok(());
        }
        input.one_frame = !self.is_real_time;
        // A gamepad of this machine has no say in a script.
        input.sticks = Sticks::default();
        if input.one_frame {
            input.secs = 1.0 / viewer.stage.rate().per_sec();
        }
        if let Some(line) = self.due().filter(|_| self.batches.is_empty()) {
            match batches(viewer, line) {
                // Panels need a frame or two to unfold.
                Err(_) if self.waited < MOST_WAITED => self.waited += 1,
                Err(error) => return Err(error),
                Ok(None) => {}
                Ok(Some(batches)) => {
                    self.current = Some((line.number, line.words.clone()));
                    self.batches = batches.into();
                    self.lines.pop_front();
                    self.waited = 0;
                }
            }
        }
        if let Some(batch) = self.batches.pop_front() {
            input.events.extend(batch.events);
            input.modifiers = batch.modifiers;
            input.dropped.extend(batch.dropped);
            input.sticks = batch.sticks;
            let last = self.current.take_if(|_| self.batches.is_empty());
            let shown = self.shown;
            let waiting = |(line, words)| Waiting { line, words, shown, came: Instant::now() };
            self.waiting = last.map(waiting);
        }
        Ok(())
    }

    /// Returns the next line if its time has come.
    fn due(&self) -> Option<&Line> {
        self.lines.front().filter(|line| line.at_secs <= self.script_secs + 1e-9)
    }

    /// Carries out the lines that look at the window, before the frame is shown.
    pub(crate) fn look(&mut self, viewer: &mut Viewer) -> Result<(), Error> {
        while self.batches.is_empty() && viewer.stage.target_secs().is_none() {
            let is_output = |line: &&Line| !line.action.is_input();
            let Some(line) = self.due().filter(is_output).cloned() else { break };
            self.lines.pop_front();
            match &line.action {
                Action::Shot(path) => {
                    let size = viewer.window();
                    let shot = viewer.renderer.read_window(size)?;
                    viewer.write(path, &shot)?;
                }
                Action::Picture(path) => {
                    let picture = viewer.picture()?;
                    viewer.write(path, &picture)?;
                }
                Action::Expect(expected) => check(viewer, &self.report, line.number, expected)?,
                Action::Pace { is_real_time } => self.is_real_time = *is_real_time,
                Action::Measure => self.report.begin_to_measure(),
                Action::Quit => self.quits = true,
                Action::Seek(secs) => {
                    viewer.desk.wish(Command::Seek(*secs));
                    break;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Notes that a frame was shown, `secs` after the one before it.
    pub(crate) fn shown(&mut self, viewer: &Viewer, secs: f64) {
        self.shown += 1;
        self.report.add_frame(secs * 1e3);
        if let Some(Waiting { line, words, shown, came }) = self.waiting.take() {
            self.report.inputs.push(InputTime {
                line,
                words,
                at_secs: came.duration_since(self.start).as_secs_f64(),
                ms: came.elapsed().as_secs_f64() * 1e3,
                frames: self.shown - shown,
            });
        }
        if !self.is_scripted {
            return;
        }
        // A replay takes as long as it takes.
        if viewer.stage.target_secs().is_none() {
            self.script_secs +=
                if self.is_real_time { secs } else { 1.0 / viewer.stage.rate().per_sec() };
        }
        if self.lines.is_empty() && self.batches.is_empty() {
            self.quits = true;
        }
    }
}

/// Returns the events of a line frame by frame; `None` for one without events.
fn batches(viewer: &Viewer, line: &Line) -> Result<Option<Vec<Batch>>, Error> {
    let place = |name: &str| {
        let place = viewer.desk.widgets.place(name);
        place.filter(|rect| rect.is_positive()).ok_or_else(|| Error::Expected {
            line: line.number,
            expected: format!("a widget named \"{name}\" in view"),
            found: format!("those named {}", viewer.desk.widgets.names().join(", ")),
        })
    };
    let scale = viewer.context().pixels_per_point();
    let point = |at: [f32; 2]| Pos2::new(at[0], at[1]) / scale;
    Ok(Some(match &line.action {
        Action::Click(at, button) => pressed(&[point(*at)], *button),
        Action::Drag(from, to, button) => {
            let [from, to] = [point(*from), point(*to)];
            let way = |nth: u8| from.lerp(to, f32::from(nth) / f32::from(DRAG_FRAMES));
            pressed(&(0..=DRAG_FRAMES).map(way).collect::<Vec<_>>(), *button)
        }
        Action::Press(name) => pressed(&[place(name)?.center()], PointerButton::Primary),
        Action::Slide(name, share) => {
            let rect = place(name)?;
            // The handle stays within the slider.
            let margin = HANDLE * rect.height();
            let x = rect.left() + margin + share * (rect.width() - 2.0 * margin);
            pressed(&[Pos2::new(x, rect.center().y)], PointerButton::Primary)
        }
        Action::Move(at) => vec![one(Event::PointerMoved(point(*at)))],
        Action::Wheel(at, notches) => {
            let wheel = Event::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: Vec2::new(0.0, *notches),
                modifiers: Modifiers::NONE,
            };
            let events = vec![Event::PointerMoved(point(*at)), wheel];
            vec![Batch { events, ..Batch::default() }]
        }
        Action::Hold { keys, modifiers, secs } => held(keys, *modifiers, frames(viewer, *secs)),
        Action::Sticks(sticks, secs) => {
            let batch = Batch { sticks: *sticks, ..Batch::default() };
            vec![batch; frames(viewer, *secs).max(1)]
        }
        Action::Drop(path) => {
            vec![Batch { dropped: vec![path.clone()], ..Batch::default() }]
        }
        _ => return Ok(None),
    }))
}

/// Returns the number of frames in `secs`, rounded.
fn frames(viewer: &Viewer, secs: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let frames = (secs * viewer.stage.rate().per_sec()).round() as usize;
    frames
}

fn one(event: Event) -> Batch {
    Batch { events: vec![event], ..Batch::default() }
}

/// Returns the frames in which a button is held along points.
fn pressed(points: &[Pos2], button: PointerButton) -> Vec<Batch> {
    let press = |pos: Pos2, pressed: bool| {
        one(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE })
    };
    let [Some(first), Some(last)] = [points.first(), points.last()] else { return Vec::new() };
    let mut batches = vec![one(Event::PointerMoved(*first)), press(*first, true)];
    batches.extend(points[1..].iter().map(|point| one(Event::PointerMoved(*point))));
    batches.push(press(*last, false));
    batches
}

/// Returns the frames in which keys are held.
fn held(keys: &[egui::Key], modifiers: Modifiers, frames: usize) -> Vec<Batch> {
    let event = |key: &egui::Key, pressed: bool| Event::Key {
        key: *key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers,
    };
    let batch = |pressed: bool| Batch {
        events: keys.iter().map(|key| event(key, pressed)).collect(),
        modifiers,
        ..Batch::default()
    };
    let mut batches = vec![batch(true)];
    batches.extend((1..frames).map(|_| Batch { modifiers, ..Batch::default() }));
    batches.push(batch(false));
    batches
}

/// Compares what is there with what was expected.
fn check(
    viewer: &mut Viewer,
    report: &ScriptReport,
    line: usize,
    expected: &Expected,
) -> Result<(), Error> {
    let picked = viewer.desk.picked;
    let number = picked.and_then(|member| viewer.stage.show.person(member));
    let (is_met, found) = match expected {
        Expected::Picked(wanted) => (
            *wanted == number && picked.is_some() == wanted.is_some(),
            number.map_or("nobody picked".to_owned(), |number| format!("{number} picked")),
        ),
        Expected::Anybody => (picked.is_some(), "nobody picked".to_owned()),
        Expected::Time(secs) => {
            let now_secs = viewer.stage.secs();
            ((now_secs - secs).abs() < 0.001, format!("the time {now_secs:.3} s"))
        }
        Expected::Frames(most) => {
            let slowest = report.inputs.iter().map(|input| input.frames).max().unwrap_or(0);
            (slowest <= *most, format!("input that was shown after {slowest} frames"))
        }
        Expected::Members(count) => {
            let members = viewer.stage.crowd.member_count();
            (members == *count, format!("{members} members"))
        }
        Expected::You(drives) => {
            let you = viewer.stage.you();
            let is_driven = you.is_some() && you == picked;
            let found = if you.is_some() { "somebody driven" } else { "nobody driven" };
            (if *drives { is_driven } else { you.is_none() }, found.to_owned())
        }
        Expected::Walked(metres) => {
            let walked_m = viewer.stage.walked_m();
            (walked_m >= *metres, format!("{walked_m:.2} m"))
        }
        Expected::Down(is_down) => {
            let down = picked.is_some_and(|member| viewer.stage.falls.is_down(member));
            (down == *is_down, if down { "somebody down" } else { "nobody down" }.to_owned())
        }
    };
    if is_met {
        return Ok(());
    }
    Err(Error::Expected { line, expected: expected.to_string(), found })
}
