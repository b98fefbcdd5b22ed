//! Files that are not complete yet, and what becomes of them where the program is told to end.
//!
//! SIGINT and SIGTERM end the program at once, wherever it is: loading, waiting for a driver's
//! compiler or drawing. That is safe because nothing is ever written under its final name. A thread
//! of its own waits for signals, removes the file that is being written, tells how many are
//! complete, and exits.

use std::fs::Permissions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

/// What is being written, and what was.
struct State {
    /// The file that has not got its name yet. It is removed where the program ends early.
    path: Option<PathBuf>,
    complete: u32,
    /// How many files there will be, where the command knows.
    wanted: Option<u32>,
}

static STATE: Mutex<State> = Mutex::new(State { path: None, complete: 0, wanted: None });

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lets messages say how many of so many pictures are complete.
pub(crate) fn expect_pictures(count: u32) {
    state().wanted = Some(count);
}

/// A file that has no name yet. Dropped before it is finished, it is gone.
pub(crate) struct Unfinished(Option<NamedTempFile>);

impl Unfinished {
    /// An empty file in the folder of `target`, so that it can take its place at once later on.
    pub(crate) fn beside(target: &Path) -> io::Result<Self> {
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut builder = tempfile::Builder::new();
        builder.prefix(".populace-").suffix(".tmp");
        // As any new file: what the user's mask leaves of these.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        // Nobody may end the program between the file's making and its place in the list.
        let mut state = state();
        let file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        state.path = Some(file.path().to_owned());
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

    /// Gives the file its name, in place of what had it. Some file systems tell that they are full
    /// only when asked to sync.
    pub(crate) fn finish(mut self, target: &Path) -> io::Result<()> {
        self.file()?.as_file().sync_all()?;
        let mut state = state();
        if let Some(file) = self.0.take() {
            let path: TempPath = file.into_temp_path();
            path.persist(target).map_err(|e| e.error)?;
        }
        state.path = None;
        state.complete += 1;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let mut state = state();
            drop(file);
            state.path = None;
        }
    }
}

/// Longer paths are copied to memory of their own on the way to the system.
#[cfg(unix)]
const SHORT_PATH: usize = 300;

/// Removes the file that is being written, where that takes neither waiting nor memory.
#[cfg(unix)]
pub(crate) fn remove_from_a_handler() {
    if let Ok(state) = STATE.try_lock()
        && let Some(path) = state.path.as_ref().filter(|path| path.as_os_str().len() < SHORT_PATH)
    {
        let _ = std::fs::remove_file(path);
    }
}

/// Ends the program by SIGINT or SIGTERM as said above, with exit code 128 and the signal's number.
#[cfg(unix)]
pub(crate) fn end_on_signals() -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::{iterator::Signals, low_level};

    // A file past its limit is then an error of writing, with its own message, as on a full disk.
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default())?;
    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    std::thread::Builder::new().name("signals".into()).stack_size(256 << 10).spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // Held to the end, so that nothing gets its name after it was counted.
            let state = state();
            if let Some(path) = &state.path {
                let _ = std::fs::remove_file(path);
            }
            let told = state
                .wanted
                .map(|wanted| format!("; {} of {wanted} frames are complete", state.complete));
            crate::progress::clear();
            crate::report::talk!("interrupted{}", told.unwrap_or_default());
            low_level::exit(128 + signal);
        }
    })?;
    Ok(())
}
