//! Temporary output files, and their removal if a signal ends the program.
//!
//! SIGINT and SIGTERM end the program at once, even while it loads, draws or waits for a driver's
//! compiler. This is safe because no file is written under its final name. A separate thread waits
//! for the signals, removes the temporary files, reports how many files are complete, and exits.

use std::collections::BTreeSet;
use std::fs::Permissions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use populace_film::{Film, FilmProgress};
use tempfile::{NamedTempFile, TempPath};

/// The files that are being written.
struct State {
    /// Temporary files; removed if the program ends early. Threads write several at once.
    paths: BTreeSet<PathBuf>,
    /// The film that is being written. Its part stays if the program ends early.
    film: Option<UnfinishedFilm>,
    /// Number of complete frames, without those of `film`.
    complete: u32,
    /// The total number of frames, if the command knows it.
    total: Option<u32>,
}

struct UnfinishedFilm {
    part: PathBuf,
    progress: FilmProgress,
}

impl State {
    fn complete_frames(&self) -> u32 {
        self.complete + self.film.as_ref().map_or(0, |film| film.progress.frame_count())
    }
}

static STATE: Mutex<State> =
    Mutex::new(State { paths: BTreeSet::new(), film: None, complete: 0, total: None });

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sets the total number of frames, for the message of an interrupted run.
pub(crate) fn expect_frames(count: u32) {
    state().total = Some(count);
}

/// Sets the film that is being written, for the message of an interrupted run.
pub(crate) fn begin_film(film: &Film) {
    let film = UnfinishedFilm { part: film.part().to_owned(), progress: film.progress() };
    state().film = Some(film);
}

/// Forgets the film, and keeps the number of its frames.
pub(crate) fn end_film() {
    let mut state = state();
    state.complete = state.complete_frames();
    state.film = None;
}

/// Calls `write`, which writes to `path`. A signal before it returns removes that file.
pub(crate) fn draft<T>(path: &Path, write: impl FnOnce() -> T) -> T {
    state().paths.insert(path.to_owned());
    let written = write();
    state().paths.remove(path);
    written
}

/// Says where the beginning of a film is. Removes a part that is empty.
pub(crate) fn describe_part(part: &Path) -> Option<String> {
    match part.metadata() {
        Ok(metadata) if metadata.len() > 0 => {
            Some(format!("{} holds the film as far as it was written", part.display()))
        }
        _ => {
            let _ = std::fs::remove_file(part);
            None
        }
    }
}

/// A temporary file. Dropping it before [`finish`](Self::finish) removes it.
pub(crate) struct Unfinished(Option<NamedTempFile>);

impl Unfinished {
    /// Creates an empty file in the folder of `target`, so that it can be renamed to `target`.
    pub(crate) fn beside(target: &Path) -> io::Result<Self> {
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut builder = tempfile::Builder::new();
        builder.prefix(".populace-").suffix(".tmp");
        // The default mode of new files; the umask applies to it.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        // Locked first, so that no signal ends the program before the new file is registered.
        let mut state = state();
        let folder = folder.unwrap_or(Path::new("."));
        // The name of the temporary file tells users nothing.
        let named = |error: io::Error| {
            let (kind, folder) = (error.kind(), folder.display());
            io::Error::new(kind, format!("no file can be made in the folder {folder}: {kind}"))
        };
        let file = builder.tempfile_in(folder).map_err(named)?;
        state.paths.insert(file.path().to_owned());
        Ok(Self(Some(file)))
    }

    fn file(&mut self) -> io::Result<&mut NamedTempFile> {
        self.0.as_mut().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    pub(crate) fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file()?.write_all(bytes)
    }

    pub(crate) fn set_permissions(&mut self, permissions: Permissions) -> io::Result<()> {
        self.file()?.as_file().set_permissions(permissions)
    }

    /// Renames the file to `target`, replacing an existing file. Syncs first, because some file
    /// systems report a full disk only then.
    pub(crate) fn finish(self, target: &Path) -> io::Result<()> {
        self.rename(target, 0)
    }

    /// Finishes the last file of a frame, and counts the frame at once.
    pub(crate) fn finish_frame(self, target: &Path) -> io::Result<()> {
        self.rename(target, 1)
    }

    fn rename(mut self, target: &Path, frames: u32) -> io::Result<()> {
        self.file()?.as_file().sync_all()?;
        let mut state = state();
        if let Some(file) = self.0.take() {
            let path: TempPath = file.into_temp_path();
            state.paths.remove(&*path);
            path.persist(target).map_err(|e| e.error)?;
        }
        state.complete += frames;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            // Held until the file is gone, so that a signal before that removes it.
            let mut state = state();
            state.paths.remove(file.path());
            drop(file);
        }
    }
}

/// The standard library copies longer paths to the heap for system calls.
#[cfg(unix)]
const STACK_PATH_BYTES: usize = 300;

/// Removes the temporary files, unless that would block or allocate.
#[cfg(unix)]
pub(crate) fn remove_in_signal_handler() {
    let Ok(state) = STATE.try_lock() else { return };
    for path in state.paths.iter().filter(|path| path.as_os_str().len() < STACK_PATH_BYTES) {
        let _ = std::fs::remove_file(path);
    }
}

/// Starts the thread that ends the program on SIGINT and SIGTERM, with exit code 128 plus the
/// signal's number.
#[cfg(unix)]
pub(crate) fn exit_on_signals() -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::{iterator::Signals, low_level};

    // Turns a file beyond the size limit into a write error with a message, as on a full disk.
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default())?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().name("signals".into()).stack_size(256 << 10).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // Held until exit, so that no file is completed after the count.
            let state = state();
            for path in &state.paths {
                let _ = std::fs::remove_file(path);
            }
            let complete = state.complete_frames();
            let progress =
                state.total.map(|total| format!("; {complete} of {total} frames are complete"));
            crate::progress::clear();
            let part = state.film.as_ref().and_then(|film| describe_part(&film.part));
            let part = part.map(|part| format!("; {part}")).unwrap_or_default();
            crate::report::message!("interrupted{}{part}", progress.unwrap_or_default());
            low_level::exit(128 + signal);
        }
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_takes_no_file_is_named_without_the_temporary_file() {
        let Err(error) = Unfinished::beside(Path::new("no_such_folder/a.png")) else {
            panic!("a file in no folder")
        };
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        let words = error.to_string();
        assert!(words.contains("in the folder no_such_folder: "), "{words}");
        assert!(!words.contains(".tmp"), "{words}");
    }

    #[test]
    fn each_of_several_files_is_known_until_it_is_done() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let begin = |name: &str| {
            let mut file = Unfinished::beside(&folder.path().join(name)).expect("a file");
            let path = file.file().expect("a file").path().to_owned();
            (file, path)
        };
        let is_known = |path: &Path| state().paths.contains(path);
        let [dropped, finished, failed] = ["a", "b", "c"].map(begin);
        assert!([&dropped.1, &finished.1, &failed.1].into_iter().all(|path| is_known(path)));
        drop(dropped.0);
        assert!(!is_known(&dropped.1) && !dropped.1.exists());
        finished.0.finish(&folder.path().join("b")).expect("renamed");
        assert!(!is_known(&finished.1) && folder.path().join("b").exists());
        assert!(is_known(&failed.1));
        failed.0.finish(folder.path()).expect_err("a folder in the way");
        assert!(!is_known(&failed.1) && !failed.1.exists());
    }
}
