//! The base folder of relative URIs, and access control for the files in it.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Maximum number of symbolic links to follow for one path.
const MOST_LINKS: usize = 40;

/// The folder in which the files that a glTF file refers to are looked up.
pub(crate) struct Folder {
    /// If `None`, all files count as missing.
    path: Option<PathBuf>,
    allow_outside: bool,
}

/// An open file that may be read.
pub(crate) struct Opened {
    file: File,
    /// Number of bytes to read.
    pub(crate) length: u64,
}

impl Folder {
    pub(crate) fn new(path: Option<&Path>, allow_outside: bool) -> Self {
        // The parent of a bare file name is an empty path, which means the current folder.
        let named = path.map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
        Self { path: named.map(Path::to_owned), allow_outside }
    }

    /// Joins `path` to the folder without checking whether the file exists or may be read.
    pub(crate) fn join(&self, path: &str) -> Option<PathBuf> {
        Some(self.path.as_ref()?.join(path))
    }

    /// Opens a file to read its first `wanted` bytes, or all of it if `wanted` is `None`. Fails if
    /// the file is shorter.
    ///
    /// Only regular files are opened, since reading a device or pipe may never end. The error for a
    /// path that leads outside the folder is the same whether the file exists or not, because
    /// nothing outside the folder is accessed.
    pub(crate) fn open(&self, path: &str, wanted: Option<usize>) -> Result<Opened, String> {
        let folder = self.path.as_deref().ok_or_else(|| {
            format!(
                "refers to the file \"{path}\", but this input has no folder to find it in; load \
                 the file by its path, or embed the data"
            )
        })?;
        let failed = |e: io::Error| format!("refers to \"{path}\", which cannot be read: {e}");
        let found = if self.allow_outside {
            folder.join(path)
        } else {
            resolve(&folder.canonicalize().map_err(failed)?, path).map_err(failed)?.ok_or_else(
                || {
                    format!(
                        "refers to \"{path}\", which is outside the folder of the file; to read it \
                         anyway, use --allow-outside or `LoadOptions::allow_outside`"
                    )
                },
            )?
        };
        let file = open_regular(&found).map_err(failed)?;
        let has = file.metadata().map_err(failed)?.len();
        match wanted.map(|w| w as u64) {
            Some(wanted) if wanted > has => Err(format!(
                "refers to \"{path}\", which has {has} bytes, but {wanted} are declared; it may be \
                 truncated"
            )),
            wanted => Ok(Opened { file, length: wanted.unwrap_or(has) }),
        }
    }
}

impl Opened {
    /// Reads [`Self::length`] bytes. Fails if the file ends before that.
    pub(crate) fn read(self) -> Result<Vec<u8>, String> {
        let failed = |e: io::Error| format!("refers to a file that cannot be read: {e}");
        let mut bytes = Vec::new();
        self.file.take(self.length).read_to_end(&mut bytes).map_err(failed)?;
        if (bytes.len() as u64) < self.length {
            return Err(
                "refers to a file that became shorter while it was read; load it again".into()
            );
        }
        Ok(bytes)
    }
}

/// Opens a regular file. Folders, pipes, sockets and devices are refused before they are opened,
/// since opening a pipe can already block.
pub(crate) fn open_regular(path: &Path) -> io::Result<File> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    File::open(path)
}

/// Resolves `path` relative to `folder`, following the symbolic links inside the folder. Returns
/// `None` if the result lies outside. Nothing outside the folder is accessed, so the result does
/// not depend on what is there. `folder` must be absolute and free of symbolic links.
fn resolve(folder: &Path, path: &str) -> io::Result<Option<PathBuf>> {
    let mut at = folder.to_owned();
    let mut pending = components_reversed(Path::new(path));
    let mut links = 0;
    while let Some(component) = pending.pop() {
        match Path::new(&component).components().next() {
            Some(Component::ParentDir) => {
                at.pop();
            }
            Some(Component::RootDir | Component::Prefix(_)) => at.push(&component),
            Some(Component::Normal(name)) => {
                at.push(name);
                if at.starts_with(folder) && std::fs::symlink_metadata(&at)?.is_symlink() {
                    links += 1;
                    if links > MOST_LINKS {
                        return Err(io::Error::other("it is behind too many symbolic links"));
                    }
                    pending.extend(components_reversed(&std::fs::read_link(&at)?));
                    at.pop();
                }
            }
            _ => {}
        }
    }
    Ok(at.starts_with(folder).then_some(at))
}

/// Returns the components of a path in reverse order.
fn components_reversed(path: &Path) -> Vec<OsString> {
    path.components().rev().map(|component| component.as_os_str().to_owned()).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn paths_resolve_only_inside_the_folder() {
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
