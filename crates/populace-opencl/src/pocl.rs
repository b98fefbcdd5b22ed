//! Requirements of PoCL: a folder for its kernels, and a linker. Without the folder it lists no
//! device or fails to build. Without the linker it ends the process at the first kernel that it has
//! to link.

use std::path::{Path, PathBuf};
use std::{env, fs};

use opencl3::device::Device;
use opencl3::platform::Platform;

const NAME: &str = "Portable Computing Language";

pub(crate) fn is(platform: &Platform) -> bool {
    platform.name().is_ok_and(|name| name == NAME)
}

/// Returns whether a device belongs to PoCL.
pub(crate) fn offers(device: &Device) -> bool {
    device.platform().is_ok_and(|platform| is(&Platform::new(platform)))
}

/// Returns which requirement this machine does not meet, and the remedy.
pub(crate) fn fault() -> Option<String> {
    let folder = kernel_folder();
    let written = fs::create_dir_all(&folder).and_then(|()| tempfile::tempfile_in(&folder));
    if let Err(error) = written {
        let folder = folder.display();
        return Some(format!(
            "it cannot write its kernel cache {folder} ({error}); let POCL_CACHE_DIR name a \
             folder that can be written"
        ));
    }
    let path = env::var_os("PATH").unwrap_or_default();
    let linked = !cfg!(unix) || env::split_paths(&path).any(|folder| has_linker(&folder));
    (!linked).then(|| {
        "it links kernels with ld, and no folder of PATH holds one; install binutils, or add its \
         folder to PATH"
            .into()
    })
}

/// Returns the folder in which PoCL keeps kernels, by PoCL's own rule.
fn kernel_folder() -> PathBuf {
    let named = |name| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let in_cache = |cache: PathBuf| cache.join("pocl/kcache");
    named("POCL_CACHE_DIR")
        .or_else(|| named("XDG_CACHE_HOME").map(in_cache))
        .or_else(|| named("HOME").map(|home| in_cache(home.join(".cache"))))
        .unwrap_or_else(|| "/tmp/pocl/kcache".into())
}

/// Returns whether a folder holds `ld`, by its plain name or prefixed by the target.
fn has_linker(folder: &Path) -> bool {
    let prefixed = format!("{}-linux-gnu-ld", env::consts::ARCH);
    ["ld", &prefixed].iter().any(|name| folder.join(name).is_file())
}
