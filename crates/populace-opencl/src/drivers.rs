//! Drivers that the OpenCL loader is configured to load, and why some fail to load.

use std::path::{Path, PathBuf};
use std::{env, fs, mem};

use dlopen2::Error;
use dlopen2::raw::Library;

/// A driver that is installed on this machine but lists no device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriverFault {
    /// Name of the platform, or of the driver's library.
    pub driver: String,
    /// The fault and its place.
    pub cause: String,
}

/// Folder in which loaders on Unix look for the files that name drivers.
const FOLDER: &str = "/etc/OpenCL/vendors";
/// Environment variables that name another folder, or one file.
const VARIABLES: [&str; 2] = ["OCL_ICD_VENDORS", "OPENCL_VENDOR_PATH"];
/// `RTLD_LAZY`, as loaders use.
const LAZY: i32 = 1;

/// Returns the drivers that fail to load. Only Unix names drivers in files.
pub(crate) fn faults() -> Vec<DriverFault> {
    if !cfg!(unix) {
        return Vec::new();
    }
    files().iter().filter_map(|file| fault(file)).collect()
}

fn files() -> Vec<PathBuf> {
    let named =
        VARIABLES.iter().find_map(|name| env::var_os(name).filter(|value| !value.is_empty()));
    let place = named.map_or_else(|| FOLDER.into(), PathBuf::from);
    if place.is_file() {
        return vec![place];
    }
    let entries = fs::read_dir(place).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "icd")).collect();
    files.sort();
    files
}

fn fault(file: &Path) -> Option<DriverFault> {
    let at_fault = |driver: String, cause: String| Some(DriverFault { driver, cause });
    let name = file.display();
    let text = match fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) => return at_fault(name.to_string(), format!("it cannot be read: {error}")),
    };
    let Some(library) = text.lines().map(str::trim).find(|line| !line.is_empty()) else {
        return at_fault(name.to_string(), "it names no driver".into());
    };
    match Library::open_with_flags(library, Some(LAZY)) {
        Ok(library) => {
            // The library stays loaded: drivers are not made for unloading, and those in use are
            // loaded anyway.
            mem::forget(library);
            None
        }
        Err(Error::OpeningLibraryError(error)) => {
            at_fault(library.into(), format!("{name} names it, but it cannot be loaded: {error}"))
        }
        Err(error) => {
            at_fault(library.into(), format!("{name} names it, but it cannot be loaded: {error}"))
        }
    }
}
