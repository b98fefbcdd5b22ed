//! Foot skate of characters on the standard course, as JSON and as a table.

use std::sync::Arc;

use populace::character::Character;
use populace_locomotion::{Error, GaitClips, Skate};
use serde_json::{Value, json};

const HEAD: &str = "\
| character | clips | segment | planting | mean, m/s | 95 %, m/s | speed error, % | \
    sole error, % | acceleration | contact, % |
|---|---|---|---|--:|--:|--:|--:|--:|--:|
";

/// The foot skate of one character.
struct Row {
    character: String,
    retargeted: bool,
    skate: Skate,
}

/// The foot skate of several characters.
#[derive(Default)]
pub struct SkateDocument {
    rows: Vec<Row>,
}

impl SkateDocument {
    /// Measures a character ([`Skate::measure`]) with clips of its own or `retargeted` ones, and
    /// adds the results under a name.
    ///
    /// # Errors
    ///
    /// As for [`Skate::measure`]. Nothing is added then.
    pub fn add(
        &mut self,
        name: &str,
        character: &Arc<Character>,
        clips: &GaitClips,
        retargeted: bool,
    ) -> Result<(), Error> {
        let skates = Skate::measure(character, clips)?;
        let row = |skate| Row { character: name.to_owned(), retargeted, skate };
        self.rows.extend(skates.into_iter().map(row));
        Ok(())
    }

    /// Returns the document as JSON of schema 1.
    #[must_use]
    pub fn as_json(&self) -> Value {
        let rows: Vec<_> = self.rows.iter().map(Row::as_json).collect();
        json!({"schema": 1, "skate": rows})
    }

    /// Formats a Markdown table.
    #[must_use]
    pub fn as_table(&self) -> String {
        self.rows.iter().fold(HEAD.to_owned(), |text, row| text + &row.as_line())
    }
}

impl Row {
    const fn clips(&self) -> &'static str {
        if self.retargeted { "retargeted" } else { "own" }
    }

    fn as_json(&self) -> Value {
        let skate = &self.skate;
        json!({
            "character": self.character,
            "clips": self.clips(),
            "segment": skate.segment,
            "planting": skate.planting,
            "mean_m_s": skate.mean_m_per_sec,
            "p95_m_s": skate.p95_m_per_sec,
            "speed_error": skate.speed_error,
            "sole_error": skate.sole_error,
            "acceleration_ratio": skate.acceleration_ratio,
            "contact_share": skate.contact_share,
        })
    }

    fn as_line(&self) -> String {
        let skate = &self.skate;
        format!(
            "| {} | {} | {} | {} | {:.3} | {:.3} | {:.1} | {:.2} | {:.2} | {:.0} |\n",
            self.character.replace('|', "\\|"),
            self.clips(),
            skate.segment,
            if skate.planting { "yes" } else { "no" },
            skate.mean_m_per_sec,
            skate.p95_m_per_sec,
            100.0 * skate.speed_error,
            100.0 * skate.sole_error,
            skate.acceleration_ratio,
            100.0 * skate.contact_share,
        )
    }
}
