//! The files that a window writes: films, pictures and layouts.

use std::path::Path;

use libtest_mimic::Failed;

use super::time::recording;
use super::{Desk, ensure};

/// Returns the number of frames of a film: the table of their sizes counts them.
fn frames(film: &Path) -> Result<u32, Failed> {
    let bytes = std::fs::read(film)?;
    let table = bytes.windows(4).position(|word| word == b"stsz").ok_or("no table of sizes")?;
    // The version and a size that all frames might have lie between.
    let count = bytes.get(table + 12..table + 16).ok_or("the table is cut off")?;
    Ok(u32::from_be_bytes(count.try_into()?))
}

/// One film goes on to the end of a recording, and one goes to a later time on its way.
pub(super) fn records_each_frame_once(desk: &Desk) -> Result<(), Failed> {
    if !cfg!(feature = "mp4") {
        return Ok(());
    }
    let file = recording(desk)?;
    let script = "at 0 key space\nat 0.2 seek 5.5\nat 0.2 expect time 5.5\nat 0.2 key v\n\
                  at 1.5 expect time 6\nat 1.5 key v\n\
                  at 1.7 seek 2\nat 1.7 expect time 2\nat 1.7 key v\nat 2.3 expect time 2.5\n\
                  at 2.3 seek 4\nat 2.7 expect time 4.3\nat 2.7 key v\n";
    desk.view(&[&file, "--fps", "10"], script)?;
    for (name, wanted) in [("populace-1.mp4", 5), ("populace-2.mp4", 8)] {
        let found = frames(&desk.path(name))?;
        ensure(found == wanted, || format!("{name} has {found} frames in place of {wanted}"))?;
    }
    Ok(())
}
