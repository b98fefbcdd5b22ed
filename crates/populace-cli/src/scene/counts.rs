//! The things that happened in a scene, and who is in it, as JSON.

use populace_scene::Counts;
use populace_scene::plan::{CrowdPlan, ScenePlan};
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
        "together": counts.together,
        "clapped": counts.clapped,
        "cheered": counts.cheered,
        "waved": counts.waved,
        "thrust": counts.thrust,
        "hit": counts.hit,
    })
}

/// Returns each crowd of a plan with the number of its first person and how many there are.
pub(super) fn crowds(plan: &ScenePlan) -> Value {
    let mut first = 0;
    let crowd = |of: &CrowdPlan| {
        let listed = json!({"cast": of.cast, "first": first, "count": of.count});
        first += of.count;
        listed
    };
    plan.crowds.iter().map(crowd).collect()
}
