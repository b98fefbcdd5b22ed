//! Lines of scripts.

use std::fmt;
use std::path::{Path, PathBuf};

use egui::{Key, Modifiers, PointerButton};

use crate::Error;
use crate::pad::Sticks;

/// Forms of a line, for messages.
const ACTIONS: &str = "click, drag, move, wheel, press, slide, key, hold, stick, drop, seek, shot, \
                       picture, expect, pace, measure or quit";

/// A line.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Its number, from 1.
    pub(super) number: usize,
    pub(super) at_secs: f64,
    /// The line without its time.
    pub(super) words: String,
    pub(super) action: Action,
}

/// The action of a line. Points are in pixels from the upper left corner of the window.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Action {
    Click([f32; 2], PointerButton),
    Drag([f32; 2], [f32; 2], PointerButton),
    Move([f32; 2]),
    Wheel([f32; 2], f32),
    /// Clicks the widget of this name.
    Press(String),
    /// Presses the slider of this name at a share of its length.
    Slide(String, f32),
    Hold {
        keys: Vec<Key>,
        modifiers: Modifiers,
        secs: f64,
    },
    /// Holds the sticks of a gamepad.
    Sticks(Sticks, f64),
    Drop(PathBuf),
    /// Goes to a time in seconds, as the timeline does.
    Seek(f64),
    /// Writes the whole window.
    Shot(PathBuf),
    /// Writes the picture alone.
    Picture(PathBuf),
    Expect(Expected),
    Pace {
        is_real_time: bool,
    },
    Measure,
    Quit,
}

impl Action {
    /// Returns true if it makes events.
    pub(super) fn is_input(&self) -> bool {
        !matches!(
            self,
            Self::Shot(_)
                | Self::Picture(_)
                | Self::Expect(_)
                | Self::Seek(_)
                | Self::Pace { .. }
                | Self::Measure
                | Self::Quit
        )
    }
}

/// The state that a line expects.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expected {
    /// This person is picked, or nobody.
    Picked(Option<u64>),
    Anybody,
    /// The show is at this time in seconds.
    Time(f64),
    /// All input until now was shown within this number of frames.
    Frames(u32),
    Members(usize),
    /// The picked member has fallen.
    Down(bool),
    /// The keyboard drives who is picked.
    You(bool),
    /// The driven member is at least this far from where it was taken over, in metres.
    Walked(f32),
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Picked(Some(number)) => write!(f, "{number} to be picked"),
            Self::Picked(None) => write!(f, "nobody to be picked"),
            Self::Anybody => write!(f, "somebody to be picked"),
            Self::Time(secs) => write!(f, "the time {secs} s"),
            Self::Frames(most) => write!(f, "input to be shown within {most} frames"),
            Self::Members(count) => write!(f, "{count} members"),
            Self::Down(true) => write!(f, "who is picked to have fallen"),
            Self::You(true) => write!(f, "who is picked to be driven"),
            Self::You(false) => write!(f, "nobody to be driven"),
            Self::Walked(metres) => write!(f, "who is driven to have walked {metres} m"),
            Self::Down(false) => write!(f, "who is picked to stand"),
        }
    }
}

/// Reads all lines. Empty lines, and what follows a #, have no meaning.
pub(super) fn parse(text: &str, folder: &Path) -> Result<Vec<Line>, Error> {
    let mut lines: Vec<Line> = Vec::new();
    for (index, text) in text.lines().enumerate() {
        let number = index + 1;
        let fault = |fault: String| Error::Script { line: number, fault };
        let words = words(text).map_err(fault)?;
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let Some((first, rest)) = words.split_first() else { continue };
        let (at_secs, rest) = match (*first, rest) {
            ("at", [secs, rest @ ..]) => (seconds(secs).map_err(fault)?, rest),
            _ => return Err(fault("begin with a time, for example: at 0.5 click 300 200".into())),
        };
        if lines.last().is_some_and(|before| before.at_secs > at_secs) {
            return Err(fault("its time is before that of the line above".into()));
        }
        let action = action(rest, folder).map_err(fault)?;
        lines.push(Line { number, at_secs, words: rest.join(" "), action });
    }
    Ok(lines)
}

/// Divides a line into words; one in quotation marks may hold spaces.
fn words(text: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        if first == '#' {
            break;
        }
        let (word, after) = if first == '"' {
            rest[1..].split_once('"').ok_or("a quotation mark has no end")?
        } else {
            rest.split_once(char::is_whitespace).unwrap_or((rest, ""))
        };
        words.push(word.to_owned());
        rest = after.trim_start();
    }
    Ok(words)
}

fn action(words: &[&str], folder: &Path) -> Result<Action, String> {
    let path = |name: &str| folder.join(name);
    Ok(match words {
        ["click", x, y, button @ ..] => Action::Click(point(x, y)?, button_of(button)?),
        ["drag", x, y, to_x, to_y, button @ ..] => {
            Action::Drag(point(x, y)?, point(to_x, to_y)?, button_of(button)?)
        }
        ["move", x, y] => Action::Move(point(x, y)?),
        ["wheel", x, y, notches] => Action::Wheel(point(x, y)?, number(notches)?),
        ["press", name] => Action::Press((*name).to_owned()),
        ["slide", name, share] => {
            let share = number(share)?;
            if !(0.0..=1.0).contains(&share) {
                return Err("a share of a slider is from 0 to 1".into());
            }
            Action::Slide((*name).to_owned(), share)
        }
        ["key", name] => hold(name, 0.0)?,
        ["hold", name, secs] => hold(name, seconds(secs)?)?,
        ["stick", side, x, y, secs] => {
            let (at, rest) = (point(x, y)?, Sticks::default());
            let sticks = match *side {
                "left" => Sticks { left: at, ..rest },
                "right" => Sticks { right: at, ..rest },
                _ => return Err("a stick is left or right".into()),
            };
            if at.iter().any(|axis| axis.abs() > 1.0) {
                return Err("a stick is pushed by -1 to 1".into());
            }
            Action::Sticks(sticks, seconds(secs)?)
        }
        ["drop", name] => Action::Drop(path(name)),
        ["seek", secs] => Action::Seek(seconds(secs)?),
        ["shot", name] => Action::Shot(png(folder, name)?),
        ["picture", name] => Action::Picture(png(folder, name)?),
        ["expect", rest @ ..] => Action::Expect(expected(rest)?),
        ["pace", "real"] => Action::Pace { is_real_time: true },
        ["pace", "frames"] => Action::Pace { is_real_time: false },
        ["measure"] => Action::Measure,
        ["quit"] => Action::Quit,
        [] => return Err(format!("after the time, write {ACTIONS}")),
        [other, ..] => {
            return Err(format!("\"{other}\" is unknown or lacks something; write {ACTIONS}"));
        }
    })
}

/// Returns the path of a picture, whose name says that it is PNG.
fn png(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let path = folder.join(name);
    match path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        true => Ok(path),
        false => Err(format!("{name} does not end in .png; pictures are written as PNG")),
    }
}

fn expected(words: &[&str]) -> Result<Expected, String> {
    let whole = |text: &str| text.parse::<u64>().map_err(|_| format!("{text} is no whole number"));
    let small = |text: &str| text.parse::<u32>().map_err(|_| format!("{text} is no whole number"));
    Ok(match words {
        ["picked", "any"] => Expected::Anybody,
        ["picked", "none"] => Expected::Picked(None),
        ["picked", number] => Expected::Picked(Some(whole(number)?)),
        ["time", secs] => Expected::Time(seconds(secs)?),
        ["frames", most] => Expected::Frames(small(most)?),
        ["members", count] => Expected::Members(small(count)? as usize),
        ["down"] => Expected::Down(true),
        ["up"] => Expected::Down(false),
        ["you"] => Expected::You(true),
        ["others"] => Expected::You(false),
        ["walked", metres] => Expected::Walked(number(metres)?),
        _ => {
            return Err(
                "expect picked any|none|NUMBER, time SECONDS, frames MOST, members COUNT, \
                        down, up, you, others or walked METRES"
                    .into(),
            );
        }
    })
}

fn hold(name: &str, secs: f64) -> Result<Action, String> {
    let (mut modifiers, mut keys) = (Modifiers::NONE, Vec::new());
    for part in name.split('+') {
        match part.to_ascii_lowercase().as_str() {
            "shift" => modifiers.shift = true,
            "ctrl" => (modifiers.ctrl, modifiers.command) = (true, true),
            "alt" => modifiers.alt = true,
            _ => keys.push(key(part)?),
        }
    }
    Ok(Action::Hold { keys, modifiers, secs })
}

fn key(name: &str) -> Result<Key, String> {
    let capital = |name: &str| {
        let mut letters = name.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect::<String>())
    };
    let found = Key::from_name(name).or_else(|| Key::from_name(&capital(name)?));
    found.ok_or_else(|| format!("no key is named {name}; write for example space, up, a, f1 or ?"))
}

fn button_of(words: &[&str]) -> Result<PointerButton, String> {
    match words {
        [] | ["left"] => Ok(PointerButton::Primary),
        ["middle"] => Ok(PointerButton::Middle),
        ["right"] => Ok(PointerButton::Secondary),
        _ => Err("a button is left, middle or right".into()),
    }
}

fn point(x: &str, y: &str) -> Result<[f32; 2], String> {
    Ok([number(x)?, number(y)?])
}

fn number(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| number.abs() < 1e6);
    number.ok_or_else(|| format!("{text} is no number"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let secs = text.parse::<f64>().ok().filter(|secs| (0.0..1e6).contains(secs));
    secs.ok_or_else(|| format!("{text} is no time in seconds"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read() {
        let text = "# moves\n\nat 0 press \"left hand\" # now\nat 0.5 drag 1 2 3 4 middle\n\
                    at 0.5 hold shift+up 0.25\nat 1 shot a.png\nat 1 expect picked none\n\
                    at 1 picture b.PNG\n";
        let lines = parse(text, Path::new("shots")).expect("a script");
        let actions: Vec<_> = lines.iter().map(|line| &line.action).collect();
        assert_eq!(actions[0], &Action::Press("left hand".into()));
        assert_eq!(actions[1], &Action::Drag([1.0, 2.0], [3.0, 4.0], PointerButton::Middle));
        let modifiers = Modifiers { shift: true, ..Modifiers::NONE };
        assert_eq!(actions[2], &Action::Hold { keys: vec![Key::ArrowUp], modifiers, secs: 0.25 });
        assert_eq!(actions[3], &Action::Shot("shots/a.png".into()));
        assert_eq!(actions[4], &Action::Expect(Expected::Picked(None)));
        assert_eq!(actions[5], &Action::Picture("shots/b.PNG".into()));
        assert_eq!((lines[3].number, lines[3].at_secs), (6, 1.0));
    }

    #[test]
    fn faults_name_their_line() {
        for (text, word) in [
            ("click 1 2", "begin with a time"),
            ("at x quit", "x is no time"),
            ("at 1 quit\nat 0 quit", "line 2"),
            ("at 1 jump", "jump"),
            ("at 1 click 1", "click"),
            ("at 1 key nokey", "nokey"),
            ("at 1 slide a 2", "0 to 1"),
            ("at 1 press \"a", "quotation"),
            ("at 1 stick up 0 1 2", "left or right"),
            ("at 1 stick left 0 2 1", "-1 to 1"),
            ("at 1 expect x", "picked"),
            ("at 0 quit\nat 1 shot a.glb", "line 2 of the script: a.glb does not end in .png"),
            ("at 1 picture png", "png does not end in .png"),
            ("at 1", "after the time"),
        ] {
            let message = parse(text, Path::new("")).expect_err(text).to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
