//! The files in a folder.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// Returns the paths of all files in a folder, in no order. Fails if one of them cannot be listed,
/// since nobody would miss it.
pub(crate) fn paths_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |e: std::io::Error| {
        let folder = folder.display();
        Failure::Input(anyhow::anyhow!("the folder {folder} cannot be read: {e}"))
    };
    let entries = folder.read_dir().map_err(unreadable)?;
    entries.map(|entry| Ok(entry.map_err(unreadable)?.path())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_cannot_be_read_is_named() {
        let refusal = paths_in(Path::new("no_such_folder")).expect_err("a refusal").to_string();
        assert!(refusal.starts_with("the folder no_such_folder cannot be read: "), "{refusal}");
    }
}
