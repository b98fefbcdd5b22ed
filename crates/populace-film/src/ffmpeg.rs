//! MP4 by the program `ffmpeg`.

use std::ffi::OsString;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use crate::Error;
use crate::output::Part;
use crate::settings::FilmSettings;
use crate::writer::FrameWriter;

const NAME: &str = "ffmpeg";
/// Conversion to even sides and to BT.709.
const FILTERS: &str = "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,\
                       setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709";

/// A running `ffmpeg` that takes frames on its standard input and writes the part.
pub(crate) struct FfmpegWriter {
    part: Part,
    child: Child,
    /// Closed by `stop`, which ends the film.
    input: Option<ChildStdin>,
    /// Reads what the program says.
    messages: Option<JoinHandle<String>>,
}

impl FfmpegWriter {
    pub(crate) fn new(part: Part, settings: &FilmSettings) -> Result<Self, Error> {
        // Shows at once if the file cannot be written.
        part.create()?;
        let [width, height] = settings.size;
        let mut command = quiet();
        command.args(["-f", "rawvideo", "-pixel_format", "rgba", "-video_size"]);
        command.arg(format!("{width}x{height}"));
        command.args(["-framerate", &settings.rate.to_string(), "-i", "pipe:0", "-vf", FILTERS]);
        command.args(["-c:v", "libx264", "-preset", "medium", "-pix_fmt", "yuv420p", "-qp"]);
        command.arg(settings.quantizer.to_string());
        let key_every = settings.rate.per_sec().round().clamp(1.0, 300.0);
        command.arg("-g").arg(key_every.to_string());
        for option in ["-colorspace", "-color_primaries", "-color_trc"] {
            command.args([option, "bt709"]);
        }
        command.args(["-movflags", "+frag_keyframe+empty_moov+default_base_moof"]);
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        command.arg(as_file(part.path()));
        let mut child = start(command.stdin(Stdio::piped()))
            .inspect_err(|_| _ = std::fs::remove_file(part.path()))?;
        let (input, stderr) = (child.stdin.take(), child.stderr.take());
        let mut writer = Self { part, child, input, messages: None };
        writer.messages = stderr.map(reading).transpose()?;
        Ok(writer)
    }

    /// Returns what the program said, once it has ended.
    fn messages(&mut self) -> String {
        let text = self.messages.take().and_then(|thread| thread.join().ok());
        text.unwrap_or_default()
    }
}

/// Returns a command that asks nothing and prints errors alone.
fn quiet() -> Command {
    let mut command = Command::new(NAME);
    command.args(["-nostdin", "-hide_banner", "-loglevel", "error", "-y"]);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn start(command: &mut Command) -> Result<Child, Error> {
    command.spawn().map_err(|source| Error::NoFfmpeg { source })
}

/// Starts a thread that reads all messages, so that the program never waits for a reader.
fn reading(mut stderr: impl Read + Send + 'static) -> Result<JoinHandle<String>, Error> {
    let read = move || {
        let mut bytes = Vec::new();
        let _ = stderr.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).trim().to_owned()
    };
    let thread = std::thread::Builder::new().name("ffmpeg messages".into()).spawn(read);
    thread.map_err(|error| failed(error.to_string()))
}

/// Returns a path that is never taken for an option or a protocol.
fn as_file(path: &Path) -> OsString {
    let mut name = OsString::from("file:");
    name.push(path);
    name
}

fn failed(cause: String) -> Error {
    Error::Encoder { encoder: NAME, cause }
}

impl FrameWriter for FfmpegWriter {
    fn write(&mut self, rgba: &[u8]) -> Result<(), Error> {
        let Some(input) = &mut self.input else { return Err(failed("it has ended".into())) };
        match input.write_all(rgba) {
            Ok(()) => Ok(()),
            // The program has ended, and said why.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                self.stop()?;
                Err(failed("it ended before the film".into()))
            }
            Err(error) => Err(failed(error.to_string())),
        }
    }

    fn stop(&mut self) -> Result<(), Error> {
        if self.input.take().is_none() {
            return Ok(());
        }
        let status = self.child.wait().map_err(|error| failed(error.to_string()))?;
        let said = self.messages();
        match (status.success(), said.is_empty()) {
            (true, _) => Ok(()),
            (false, true) => Err(failed(status.to_string())),
            (false, false) => Err(failed(said)),
        }
    }

    fn finish(mut self: Box<Self>) -> Result<PathBuf, Error> {
        self.stop()?;
        let written = rewrite(self.part.path(), self.part.draft());
        self.part.complete(written)
    }
}

impl Drop for FfmpegWriter {
    /// Waits for a program that an error has left running, and for the reader of its messages.
    fn drop(&mut self) {
        let _ = self.stop();
    }
}

/// Writes a fragmented film in its ordinary form.
fn rewrite(part: &Path, draft: &Path) -> Result<(), Error> {
    let mut command = quiet();
    command.arg("-i").arg(as_file(part));
    command.args(["-c", "copy", "-movflags", "+faststart", "-fflags", "+bitexact"]);
    let output = start(command.stdin(Stdio::null()).arg(as_file(draft)))?.wait_with_output();
    let output = output.map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        Ok(())
    } else {
        Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()))
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_dropped_is_waited_for() {
        let mut command = Command::new("sh");
        command.args(["-c", "cat"]).stdin(Stdio::piped()).stdout(Stdio::null());
        let mut child = start(&mut command).expect("a shell");
        let process = PathBuf::from(format!("/proc/{}", child.id()));
        let input = child.stdin.take();
        drop(FfmpegWriter { part: Part::of(Path::new("a.mp4")), child, input, messages: None });
        assert!(!process.exists(), "it still runs, or nobody has waited for it");
    }
}
