//! Text files of a limited length.

use std::io::Read;
use std::path::Path;

/// The longest text file, in bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Reads a text file. Returns the reason why one cannot be read, such as a pipe or a file that is
/// too long.
pub(crate) fn read(file: &Path) -> Result<String, String> {
    let failed = |e: std::io::Error| e.to_string();
    // Checked first, because opening a pipe would block.
    if !std::fs::metadata(file).map_err(failed)?.is_file() {
        return Err("it is not a regular file".into());
    }
    let mut text = String::new();
    let opened = std::fs::File::open(file).map_err(failed)?;
    opened.take(MOST_BYTES + 1).read_to_string(&mut text).map_err(failed)?;
    if text.len() as u64 > MOST_BYTES {
        return Err(format!("it is longer than {} MiB", MOST_BYTES >> 20));
    }
    Ok(text)
}
