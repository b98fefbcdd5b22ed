//! The folder that a file's URIs are relative to, and what may be read from there.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Symbolic links followed at most for one path.
const MOST_LINKS: usize = 40;

/// Where the files lie that a file names.
pub(crate) struct Folder {
    /// Without one, files count as missing.
    path: Option<PathBuf>,
    allow_outside: bool,
}

/// A file that may be read, opened.
pub(crate) struct Opened {
    file: File,
    /// How many bytes are to be read.
    pub(crate) length: u64,
}

impl Folder {
    pub(crate) fn new(path: Option<&Path>, allow_outside: bool) -> Self {
        // The parent of a bare file name is an empty path, which stands for the current folder.
        let named = path.map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
        Self { path: named.map(Path::to_owned), allow_outside }
    }

    /// Where a file would be that is named by a path, whether it may be read or not.
    pub(crate) fn join(&self, path: &str) -> Option<PathBuf> {
        Some(self.path.as_ref()?.join(path))
    }

    /// Opens a file to read its first `wanted` bytes, which must be there, or all of it.
    ///
    /// Only regular files are opened, since devices and pipes may never end. What is said of a path
    /// that leads outside the folder does not depend on what is there: nothing outside is looked
    /// at.
    pub(crate) fn open(&self, path: &str, wanted: Option<usize>) -> Result<Opened, String> {
        let folder = self.path.as_deref().ok_or_else(|| {
            format!("names the file \"{path}\", but files beside this one are not looked at here")
        })?;
        let failed = |e: io::Error| format!("names \"{path}\", which cannot be read: {e}");
        let found = if self.allow_outside {
            folder.join(path)
        } else {
            resolve(&folder.canonicalize().map_err(failed)?, path).map_err(failed)?.ok_or_else(
                || {
                    format!(
                        "names \"{path}\", which leads outside the file's folder; to read it all \
                         the same use --allow-outside (`LoadOptions::allow_outside`)"
                    )
                },
            )?
        };
        let file = open_regular(&found).map_err(failed)?;
        let has = file.metadata().map_err(failed)?.len();
        match wanted.map(|w| w as u64) {
            Some(wanted) if wanted > has => Err(format!(
                "names \"{path}\", which has {has} bytes where {wanted} are declared; it may be \
                 cut off"
            )),
            wanted => Ok(Opened { file, length: wanted.unwrap_or(has) }),
        }
    }
}

impl Opened {
    /// Reads the bytes; fewer are an error.
    pub(crate) fn read(self) -> Result<Vec<u8>, String> {
        let failed = |e: io::Error| format!("names a file that cannot be read: {e}");
        let mut bytes = Vec::new();
        self.file.take(self.length).read_to_end(&mut bytes).map_err(failed)?;
        if (bytes.len() as u64) < self.length {
            return Err("names a file that ended while it was read".into());
        }
        Ok(bytes)
    }
}

/// Opens a file unless it is a folder, pipe, socket or device. Opening a pipe would already wait.
pub(crate) fn open_regular(path: &Path) -> io::Result<File> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    File::open(path)
}

/// Where a path leads from a folder, all symbolic links in the folder followed; `None` where that
/// is outside. Nothing outside is looked at, so that the answer does not depend on it. `folder` is
/// absolute and without links.
fn resolve(folder: &Path, path: &str) -> io::Result<Option<PathBuf>> {
    let mut at = folder.to_owned();
    let mut ahead = steps(Path::new(path));
    let mut links = 0;
    while let Some(step) = ahead.pop() {
        match Path::new(&step).components().next() {
            Some(Component::ParentDir) => {
                at.pop();
            }
            Some(Component::RootDir | Component::Prefix(_)) => at.push(&step),
            Some(Component::Normal(name)) => {
                at.push(name);
                if at.starts_with(folder) && std::fs::symlink_metadata(&at)?.is_symlink() {
                    links += 1;
                    if links > MOST_LINKS {
                        return Err(io::Error::other("it is behind too many symbolic links"));
                    }
                    ahead.extend(steps(&std::fs::read_link(&at)?));
                    at.pop();
                }
            }
            _ => {}
        }
    }
    Ok(at.starts_with(folder).then_some(at))
}

/// The components of a path, the first one last.
fn steps(path: &Path) -> Vec<OsString> {
    path.components().rev().map(|step| step.as_os_str().to_owned()).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn paths_are_followed_as_far_as_the_folder_goes() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path().canonicalize().unwrap();
        let folder = root.join("folder");
        std::fs::create_dir_all(folder.join("in")).unwrap();
        std::fs::write(folder.join("in/a"), "a").unwrap();
        std::fs::write(root.join("secret"), "s").unwrap();
        symlink("in/a", folder.join("inner")).unwrap();
        symlink(&folder, folder.join("in/self")).unwrap();
        symlink("loop", folder.join("loop")).unwrap();
        let found = |path: &str| resolve(&folder, path).ok().flatten();
        let own = folder.join("in/a");
        let absolute = own.to_str().unwrap();
        for path in ["in/a", "./in/../in/a", "inner", "in/self/inner", "../folder/in/a", absolute] {
            assert_eq!(found(path).as_ref(), Some(&own), "{path}");
        }
        assert!(resolve(&folder, "loop").unwrap_err().to_string().contains("too many"));
        assert!(resolve(&folder, "gone").is_err());
        for (name, target) in
            [("there", "../secret"), ("gone out", "../nothing"), ("far", "/nothing")]
        {
            symlink(target, folder.join(name)).unwrap();
            assert_eq!(resolve(&folder, name).unwrap(), None, "{name}");
        }
        for path in [
            "../secret",
            "../nothing",
            "in/self/../secret",
            "in/../../secret",
            "/",
            "/etc/passwd",
            "/x/y",
        ] {
            assert_eq!(resolve(&folder, path).unwrap(), None, "{path}");
        }
    }
}
