//! Reads and writes measurements as JSON.

use serde_json::{Value, json};

use crate::baked::TableSizes;
use crate::spec::Measurement;

/// All measurements of a benchmark, and the machine they were made on.
pub struct Document {
    /// The processor, its threads and the system.
    pub machine: String,
    /// The measurements, in the order of the table's lines.
    pub runs: Vec<Measurement>,
}

impl Document {
    /// Returns the document as JSON of schema 1.
    #[must_use]
    pub fn as_json(&self) -> Value {
        let runs: Vec<_> = self.runs.iter().map(run_as_json).collect();
        json!({"schema": 1, "machine": self.machine, "runs": runs})
    }

    /// Reads a document written by [`as_json`](Self::as_json).
    ///
    /// # Errors
    ///
    /// If the document has another schema or no runs, or lacks a field, which the text names.
    pub fn from_json(document: &Value) -> Result<Self, String> {
        if document["schema"] != 1 {
            return Err("it is not a document of schema 1".into());
        }
        let whole = Fields { object: document, path: "the document".into() };
        let runs =
            document["runs"].as_array().filter(|runs| !runs.is_empty()).ok_or("it has no runs")?;
        let runs = runs.iter().enumerate().map(|(index, object)| {
            run_from_json(&Fields { object, path: format!("runs[{index}]") })
        });
        Ok(Self { machine: whole.text("machine")?, runs: runs.collect::<Result<_, _>>()? })
    }
}

fn run_as_json(run: &Measurement) -> Value {
    json!({
        "device": run.device.to_string(),
        "schedule": run.schedule,
        "stage": run.stage,
        "load": run.load,
        "members": run.members,
        "joints": run.joints,
        "slots": run.slots,
        "ms_median": run.ms_median,
        "ms_min": run.ms_min,
        "wall_ms_median": run.wall_ms_median,
        "host_ms_median": run.host_ms_median,
        "change_ms_median": run.change_ms_median,
        "ns_per_joint": run.ns_per_joint(),
        "bytes_per_joint": run.bytes_per_joint,
        "memory_bytes": run.memory_bytes,
        "baked": run.tables.map(tables_as_json),
        "bytes_per_member_beyond_palettes": run.bytes_per_member,
        "max_error": run.error_m,
    })
}

fn tables_as_json(tables: TableSizes) -> Value {
    let TableSizes { clips, bytes, row_bytes } = tables;
    json!({"clips": clips, "bytes": bytes, "row_bytes": row_bytes})
}

fn run_from_json(fields: &Fields) -> Result<Measurement, String> {
    let tables = Fields { object: &fields.object["baked"], path: format!("{}.baked", fields.path) };
    let sizes = || {
        let (clips, bytes) = (tables.count("clips")?, tables.count("bytes")?);
        Ok::<_, String>(TableSizes { clips, bytes, row_bytes: tables.count("row_bytes")? })
    };
    Ok(Measurement {
        device: fields.text("device")?.parse().map_err(|e| format!("{}: {e}", fields.path))?,
        schedule: fields.text("schedule")?,
        stage: fields.text("stage")?,
        load: fields.text("load")?,
        members: fields.count("members")?,
        joints: fields.count("joints")?,
        slots: fields.count("slots")?,
        ms_median: fields.number("ms_median")?,
        ms_min: fields.number("ms_min")?,
        wall_ms_median: fields.optional("wall_ms_median"),
        host_ms_median: fields.optional("host_ms_median"),
        change_ms_median: fields.optional("change_ms_median"),
        bytes_per_joint: fields.number("bytes_per_joint")?,
        memory_bytes: fields.count("memory_bytes")?,
        tables: if tables.object.is_null() { None } else { Some(sizes()?) },
        bytes_per_member: fields.optional("bytes_per_member_beyond_palettes"),
        error_m: fields.optional("max_error"),
        allowed_m: None,
    })
}

/// A JSON object, and its path for messages.
struct Fields<'a> {
    object: &'a Value,
    path: String,
}

impl Fields<'_> {
    fn optional(&self, name: &str) -> Option<f64> {
        self.object[name].as_f64()
    }

    fn number(&self, name: &str) -> Result<f64, String> {
        let number = self.optional(name).filter(|number| *number > 0.0);
        number.ok_or_else(|| format!("{} has no {name} above 0", self.path))
    }

    fn count(&self, name: &str) -> Result<usize, String> {
        let count = self.object[name].as_u64().and_then(|count| usize::try_from(count).ok());
        count
            .filter(|count| *count > 0)
            .ok_or_else(|| format!("{} has no {name} above 0", self.path))
    }

    fn text(&self, name: &str) -> Result<String, String> {
        let text = self.object[name].as_str().map(str::to_owned);
        text.ok_or_else(|| format!("{} has no {name}", self.path))
    }
}
