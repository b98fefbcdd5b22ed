//! Drives the window by scripts on a display of its own, and looks at its pictures.
//!
//! The display is Xvfb, which `make setup-tests` installs. Without it the tests show as ignored.

mod display;
mod files;
mod people;
mod time;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

use image::RgbaImage;
use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;
use tempfile::TempDir;

use display::Display;

/// Width and height of the window in pixels.
const SIZE: [u32; 2] = [760, 740];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let can_run = Display::is_installed() && !cfg!(skip_gl);
    let needs = if cfg!(skip_gl) { "POPULACE_SKIP names gl" } else { "Xvfb is missing" };
    let trial = |name: &str, check: fn(&Desk) -> Result<(), Failed>| {
        let name = if can_run { name.to_owned() } else { format!("{name} ({needs})") };
        let run = move || check(&Desk::new()?);
        Trial::test(name, run).with_ignored_flag(!can_run)
    };
    let trials = vec![
        trial("a window opens with picture and panels", people::opens),
        trial("who is under the pointer is picked", people::picks),
        trial("a slider moves an arm, and nothing else", people::slides),
        trial("a picked member falls and gets up", people::falls),
        trial("the keyboard drives a member", people::drives),
        trial("sticks drive a member and the camera", people::drives_by_stick),
        trial("seeking lands on the picture of render --at", time::seeks_crowds),
        trial("seeking in a recording lands on the picture of render --at", time::seeks_recordings),
        trial("the timeline pauses, steps and is dragged", time::steps),
        trial("a dropped file is opened", time::drops),
        trial("another schedule shows the same moment", time::reopens),
        trial("a film is recorded", time::records),
        trial("the demo opens the street", time::opens_the_street),
        trial("a film has each frame once, and the last one", files::records_each_frame_once),
        trial("the layout is remembered", time::remembers),
        trial("files that are no layouts stay as they are", files::refuses_other_files),
        trial("a layout that cannot be written is warned of", files::warns_of_a_lost_layout),
        trial(
            "cameras that see nobody or are in the ground are warned of",
            files::warns_of_cameras,
        ),
        trial("pictures take the place of files as a whole", files::replaces_files_whole),
        trial("pictures and films of other formats are refused", files::refuses_other_formats),
        trial("input is shown by the next picture", time::shows_input_at_once),
        Trial::test("a missing display says what to do", time::misses_a_display),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A display, and a folder for scripts and pictures.
struct Desk {
    display: Display,
    folder: TempDir,
}

impl Desk {
    fn new() -> Result<Self, Failed> {
        Ok(Self { display: Display::start()?, folder: tempfile::tempdir()? })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `populace view` with a script, in the folder.
    fn try_view(&self, args: &[&str], script: &str) -> Result<Output, Failed> {
        std::fs::write(self.path("script.txt"), script)?;
        let [width, height] = SIZE;
        let output = Command::new(env!("CARGO_BIN_EXE_populace"))
            .arg("view")
            .args(args)
            .args(["--size", &format!("{width}x{height}"), "--json", "--script"])
            .arg(self.path("script.txt"))
            .current_dir(self.path(""))
            .env("DISPLAY", self.display.name())
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_CONFIG_HOME", self.path("config"))
            .output()?;
        Ok(output)
    }

    /// Runs `populace view` with a script, and returns its JSON document.
    fn view(&self, args: &[&str], script: &str) -> Result<Value, Failed> {
        let output = self.try_view(args, script)?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        Ok(serde_json::from_slice(&output.stdout)?)
    }

    /// Draws a picture of a size by `populace render`.
    fn render(
        &self,
        args: &[&str],
        [width, height]: [u32; 2],
        out: &str,
    ) -> Result<RgbaImage, Failed> {
        let output = Command::new(env!("CARGO_BIN_EXE_populace"))
            .arg("render")
            .args(args)
            .args(["--size", &format!("{width}x{height}"), "--out"])
            .arg(self.path(out))
            .output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        self.image(out)
    }

    fn image(&self, name: &str) -> Result<RgbaImage, Failed> {
        Ok(read(&self.path(name))?)
    }
}

fn read(path: &Path) -> Result<RgbaImage, image::ImageError> {
    Ok(image::open(path)?.to_rgba8())
}

/// Returns an error with words unless something holds.
fn ensure(holds: bool, words: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(words().into()) }
}

/// Returns the pixels that differ between pictures of the same size.
fn differing(a: &RgbaImage, b: &RgbaImage) -> Vec<[u32; 2]> {
    assert_eq!(a.dimensions(), b.dimensions(), "pictures of the same size");
    let differs = |(x, y, pixel): (u32, u32, &image::Rgba<u8>)| {
        (pixel != b.get_pixel(x, y)).then_some([x, y])
    };
    a.enumerate_pixels().filter_map(differs).collect()
}
