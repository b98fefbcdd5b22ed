//! What the clips of files take as rows.

use std::path::Path;

use populace_assets::Imported;
use serde_json::{Value, json};

/// All clips of a file, or of several.
#[derive(Default)]
pub(crate) struct Taken {
    file: String,
    joints: usize,
    clips: usize,
    rows: usize,
    /// Poses of one joint: rows times joints.
    joint_rows: usize,
    row_bytes: usize,
    key_bytes: usize,
}

impl Taken {
    pub(crate) fn of(file: &Path, imported: &Imported) -> Self {
        let joints = imported.character.skeleton.joint_count();
        let name = file.file_name().unwrap_or_default();
        let mut taken =
            Self { file: name.to_string_lossy().into_owned(), joints, ..Self::default() };
        for clip in &imported.character.clips {
            let stats = clip.stats();
            taken.clips += 1;
            taken.rows += stats.row_count;
            taken.joint_rows += stats.row_count * joints;
            taken.row_bytes += stats.row_bytes;
            taken.key_bytes += stats.key_bytes;
        }
        taken
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

    /// `None` without rows.
    fn bytes_per_joint_and_row(&self) -> Option<f64> {
        (self.joint_rows > 0).then(|| self.row_bytes as f64 / self.joint_rows as f64)
    }
}

pub(crate) fn as_json(all: &[Taken]) -> Value {
    let one = |taken: &Taken| {
        json!({
            "file": taken.file,
            "joints": taken.joints,
            "clips": taken.clips,
            "rows": taken.rows,
            "row_bytes": taken.row_bytes,
            "key_bytes": taken.key_bytes,
            "bytes_per_joint_and_row": taken.bytes_per_joint_and_row(),
        })
    };
    json!({"schema": 1, "files": all.iter().map(one).collect::<Vec<_>>()})
}

/// A table of Markdown; the sum last, where there is more than one file.
pub(crate) fn as_table(all: &[Taken]) -> String {
    let mut text = String::from(
        "| file | joints | clips | rows | row bytes | key bytes | bytes per joint and row |\n",
    );
    text += "|---|--:|--:|--:|--:|--:|--:|\n";
    let sum = (all.len() > 1).then(|| Taken::sum(all));
    for taken in all.iter().chain(&sum) {
        let joints = if taken.joints == 0 { String::new() } else { taken.joints.to_string() };
        let each =
            taken.bytes_per_joint_and_row().map_or(String::new(), |bytes| format!("{bytes:.1}"));
        text += &format!(
            "| {} | {joints} | {} | {} | {} | {} | {each} |\n",
            taken.file, taken.clips, taken.rows, taken.row_bytes, taken.key_bytes
        );
    }
    text
}
