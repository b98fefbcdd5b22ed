//! Cache of built programs in files, for later processes.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::hash::Hasher;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use std::{env, io};

use etcetera::BaseStrategy;
use siphasher::sip128::{Hasher128, SipHasher24};

/// Environment variable that names the folder; empty for no cache.
const VARIABLE: &str = "POPULACE_CACHE_DIR";
const EXTENSION: &str = "program";
/// An entry that was not used for this long is deleted when another is written.
const KEPT_FOR: Duration = Duration::from_secs(60 * 24 * 60 * 60);
/// Bytes of the hash at the start of each file.
const HASH_BYTES: usize = 16;

/// A folder of built programs.
#[derive(Clone, Debug)]
pub(crate) struct Cache {
    folder: PathBuf,
}

impl Cache {
    /// The folder named by `POPULACE_CACHE_DIR`, else `populace` in the user's cache folder. `None`
    /// if the variable is empty or the user has no home folder.
    pub(crate) fn of_user() -> Option<Self> {
        let folder = match env::var_os(VARIABLE) {
            Some(named) => PathBuf::from(named),
            None => etcetera::choose_base_strategy().ok()?.cache_dir().join("populace"),
        };
        (!folder.as_os_str().is_empty()).then_some(Self { folder })
    }

    #[cfg(test)]
    pub(crate) fn in_folder(folder: &Path) -> Self {
        Self { folder: folder.into() }
    }

    /// Returns the entry of the program that `words` describe completely.
    pub(crate) fn entry<'a>(&self, words: impl Iterator<Item = &'a str>) -> Entry {
        let mut hash = SipHasher24::new();
        for word in words {
            hash.write(&(word.len() as u64).to_le_bytes());
            hash.write(word.as_bytes());
        }
        let name = format!("{:032x}", hash.finish128().as_u128());
        Entry { path: self.folder.join(name).with_extension(EXTENSION) }
    }
}

/// Returns true for the name of an entry. A user may keep other files in the folder.
fn is_entry(path: &Path) -> bool {
    let is_hash = |name: &str| name.len() == 32 && name.bytes().all(|b| b.is_ascii_hexdigit());
    path.extension() == Some(OsStr::new(EXTENSION))
        && path.file_stem().and_then(OsStr::to_str).is_some_and(is_hash)
}

/// Returns the hash of a binary, which tells whether it is damaged.
fn hash_of(binary: &[u8]) -> [u8; HASH_BYTES] {
    SipHasher24::new().hash(binary).as_bytes()
}

/// The file of one program: a hash, then the binary that the hash belongs to.
#[derive(Debug)]
pub(crate) struct Entry {
    path: PathBuf,
}

impl Entry {
    /// Returns the binary; `None` if there is none, or if it is damaged.
    pub(crate) fn read(&self) -> Option<Vec<u8>> {
        let mut bytes = fs::read(&self.path).ok()?;
        let hash = bytes.get(..HASH_BYTES)?;
        if hash != hash_of(&bytes[HASH_BYTES..]) {
            return None;
        }
        // Records the time of this use. A failure does not matter.
        let _not_set = File::options()
            .append(true)
            .open(&self.path)
            .and_then(|f| f.set_modified(SystemTime::now()));
        Some(bytes.split_off(HASH_BYTES))
    }

    /// Writes or replaces the binary. Does nothing if the folder cannot be written: the next
    /// process builds again.
    pub(crate) fn write(&self, binary: &[u8]) {
        if self.try_write(binary).is_ok() {
            self.delete_unused_beside();
        }
    }

    /// Writes under another name first, so that other processes see the file complete or not at
    /// all.
    fn try_write(&self, binary: &[u8]) -> io::Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(folder)?;
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(&hash_of(binary))?;
        file.write_all(binary)?;
        file.persist(&self.path)?;
        Ok(())
    }

    fn delete_unused_beside(&self) {
        let folder = self.path.parent().into_iter().filter_map(|folder| fs::read_dir(folder).ok());
        for entry in folder.flatten().flatten() {
            let path = entry.path();
            let modified = entry.metadata().and_then(|about| about.modified());
            let unused = modified
                .ok()
                .and_then(|time| time.elapsed().ok())
                .is_some_and(|age| age > KEPT_FOR);
            if unused && is_entry(&path) {
                // Another process may have deleted it already.
                let _gone = fs::remove_file(path);
            }
        }
    }
}

#[cfg(test)]
mod tests;
