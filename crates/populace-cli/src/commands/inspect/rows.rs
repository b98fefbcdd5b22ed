//! Memory sizes by the clips of files.

use std::path::Path;

use populace_assets::Imported;
use serde_json::{Value, json};

/// Sizes of all clips of a file, or of several files.
#[derive(Default)]
pub(crate) struct ClipSizes {
    file: String,
    joints: usize,
    clips: usize,
    rows: usize,
    /// Rows times joints, summed over the clips.
    joint_rows: usize,
    row_bytes: usize,
    key_bytes: usize,
}

impl ClipSizes {
    pub(crate) fn new(file: &Path, imported: &Imported) -> Self {
        let joints = imported.character.skeleton.joint_count();
        let name = file.file_name().unwrap_or_default();
        let mut sizes =
            Self { file: name.to_string_lossy().into_owned(), joints, ..Self::default() };
        for clip in &imported.character.clips {
            let stats = clip.stats();
            sizes.clips += 1;
            sizes.rows += stats.row_count;
            sizes.joint_rows += stats.row_count * joints;
            sizes.row_bytes += stats.row_bytes;
            sizes.key_bytes += stats.key_bytes;
        }
        sizes
    }

    fn sum(all: &[Self]) -> Self {
        let total = |of: fn(&Self) -> usize| all.iter().map(of).sum();
        Self {
            file: "all".into(),
            joints: 0,
            clips: total(|t| t.clips),
            rows: total(|t| t.rows),
            joint_rows: total(|t| t.joint_rows),
            row_bytes: total(|t| t.row_bytes),
            key_bytes: total(|t| t.key_bytes),
        }
    }

    /// Returns `None` if there are no rows.
    fn bytes_per_joint_and_row(&self) -> Option<f64> {
        (self.joint_rows > 0).then(|| self.row_bytes as f64 / self.joint_rows as f64)
    }
}

pub(crate) fn as_json(all: &[ClipSizes]) -> Value {
    let one = |sizes: &ClipSizes| {
        json!({
            "file": sizes.file,
            "joints": sizes.joints,
            "clips": sizes.clips,
            "rows": sizes.rows,
            "row_bytes": sizes.row_bytes,
            "key_bytes": sizes.key_bytes,
            "bytes_per_joint_and_row": sizes.bytes_per_joint_and_row(),
        })
    };
    json!({"schema": 1, "files": all.iter().map(one).collect::<Vec<_>>()})
}

/// Formats a Markdown table, with a sum if there is more than one file.
pub(crate) fn as_table(all: &[ClipSizes]) -> String {
    let mut text = String::from(
        "| file | joints | clips | rows | row bytes | key bytes | bytes per joint and row |\n",
    );
    text += "|---|--:|--:|--:|--:|--:|--:|\n";
    let sum = (all.len() > 1).then(|| ClipSizes::sum(all));
    for sizes in all.iter().chain(&sum) {
        let joints = if sizes.joints == 0 { String::new() } else { sizes.joints.to_string() };
        let each =
            sizes.bytes_per_joint_and_row().map_or(String::new(), |bytes| format!("{bytes:.1}"));
        text += &format!(
            "| {} | {joints} | {} | {} | {} | {} | {each} |\n",
            sizes.file, sizes.clips, sizes.rows, sizes.row_bytes, sizes.key_bytes
        );
    }
    text
}
