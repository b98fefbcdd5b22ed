//! Seeds of the fuzz targets, which ordinary tests check too.

use std::path::Path;

/// Writes a seed to the folder `POPULACE_WRITE_SEEDS`/`target`, if that variable is set. It is
/// relative to the workspace.
///
/// # Panics
///
/// If the file cannot be written.
pub(crate) fn write(target: &str, name: &str, bytes: &[u8]) {
    let Some(folder) = std::env::var_os("POPULACE_WRITE_SEEDS") else { return };
    // Tests run in the folder of their crate.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = workspace.join(folder).join(target);
    std::fs::create_dir_all(&folder).expect("a folder for the seeds");
    std::fs::write(folder.join(name), bytes).expect("a seed");
}
