//! Formats measurements as a Markdown table.

use crate::document::Document;
use crate::spec::Measurement;

const HEAD: &str = "\
| members | device | schedule | stage | load | ms, median | ms, least | ns per joint | ms, waited \
                    | host's part, ms | MiB | bytes per member | worst error, mm |
|--:|---|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|
";

impl Document {
    /// Formats a Markdown table and notes that compare its lines. Single stages are left out if
    /// there are several crowd sizes.
    #[must_use]
    pub fn as_table(&self) -> String {
        as_table(self)
    }
}

fn as_table(document: &Document) -> String {
    let runs = &document.runs;
    let stages = runs.iter().all(|run| run.members == runs[0].members);
    let shown: Vec<&Measurement> = runs.iter().filter(|run| stages || run.stage == "all").collect();
    let mut text = format!("{}\n\n{HEAD}", document.machine);
    shown.iter().for_each(|run| text += &line(run));
    let mut notes: Vec<_> = shown.iter().filter_map(|run| ratio_to_plain(run, runs)).collect();
    notes.extend(shown.iter().find_map(|run| baked_note(run)));
    if !notes.is_empty() {
        text += &format!("\n{}", notes.concat());
    }
    text
}

fn line(run: &Measurement) -> String {
    let optional = |value: Option<f64>, digits: usize| {
        value.map_or(String::new(), |value| format!("{value:.digits$}"))
    };
    format!(
        "| {} | {} | {} | {} | {} | {:.2} | {:.2} | {:.1} | {} | {} | {} | {} | {} |\n",
        run.members,
        run.device,
        run.schedule,
        run.stage,
        run.load,
        run.ms_median,
        run.ms_min,
        run.ns_per_joint(),
        optional(run.wall_ms_median, 2),
        optional(run.host_ms_median, 3),
        run.memory_bytes >> 20,
        optional(run.bytes_per_member, 0),
        optional(run.error_m.map(|error| error * 1e3), 3),
    )
}

/// Compares a load with the plain load of the same schedule.
fn ratio_to_plain(run: &Measurement, runs: &[Measurement]) -> Option<String> {
    let same_subject = |other: &&Measurement| {
        (other.members, &other.device, &other.schedule, &other.stage)
            == (run.members, &run.device, &run.schedule, &run.stage)
    };
    let whole_and_loaded = run.stage == "all" && !run.is_plain();
    let plain =
        runs.iter().filter(same_subject).find(|other| whole_and_loaded && other.is_plain())?;
    let changes = run
        .change_ms_median
        .map_or(String::new(), |ms| format!("; the calls that change clips took {ms:.3} ms"));
    Some(format!(
        "{}, {} of {} members on {}: {:.2} times the plain one{changes}\n",
        run.load,
        run.schedule,
        run.members,
        run.device,
        run.ms_median / plain.ms_median
    ))
}

fn baked_note(run: &Measurement) -> Option<String> {
    let tables = run.tables?;
    let kib_each = |bytes: usize| bytes as f64 / 1024.0 / tables.clips as f64;
    Some(format!(
        "baked: {:.2} MiB of tables, {:.1} KiB for each of {} pairs of model and clip; the clips' \
         rows take {:.1} KiB each\n",
        tables.bytes as f64 / 1_048_576.0,
        kib_each(tables.bytes),
        tables.clips,
        kib_each(tables.row_bytes)
    ))
}
