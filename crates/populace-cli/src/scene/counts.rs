//! The things that happened in a scene, as JSON.

use populace_scene::Counts;
use serde_json::{Value, json};

/// Returns the counts by their names.
pub(super) fn as_json(counts: Counts) -> Value {
    json!({
        "looked_in": counts.looked_in,
        "looked_both_ways": counts.looked_both_ways,
        "crossed": counts.crossed,
        "talked": counts.talked,
        "sat": counts.sat,
        "drove_off": counts.drove_off,
        "got_out": counts.got_out,
        "fell": counts.fell,
        "got_up": counts.got_up,
        "phoned": counts.phoned,
        "texted": counts.texted,
        "leaned": counts.leaned,
        "pointed": counts.pointed,
        "carried": counts.carried,
        "clapped": counts.clapped,
        "cheered": counts.cheered,
        "waved": counts.waved,
        "thrust": counts.thrust,
        "hit": counts.hit,
    })
}
