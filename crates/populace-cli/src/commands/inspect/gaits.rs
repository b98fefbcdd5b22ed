//! The gaits of clips.

use std::sync::Arc;

use populace::character::Character;
use populace::clip::Clip;
use populace::model::Side;
use populace_locomotion::{Contact, Gait};
use serde_json::{Value, json};

/// A body that moves this many degrees off its front does not walk forwards.
const OFF_FRONT_DEGREES: f64 = 10.0;
/// Slower bodies walk in no direction.
const WALKING_M_PER_SEC: f64 = 0.05;

/// Describes the gait of a clip on the character; null for a body without two feet, for a clip in
/// which no foot stands, and for one that does not fit.
pub(super) fn as_json(character: &Arc<Character>, clip: &Arc<Clip>) -> Value {
    let gait = Gait::measure(character, clip).unwrap_or_default();
    gait.as_ref().map_or(Value::Null, describe)
}

fn describe(gait: &Gait) -> Value {
    let side = |foot| if foot == Side::Left { "left" } else { "right" };
    let contact = |contact: &Contact| {
        json!({
            "foot": side(contact.foot),
            "from_secs": contact.from_secs,
            "until_secs": contact.until_secs,
        })
    };
    json!({
        "speed_m_per_sec": gait.speed_m_per_sec(),
        "velocity_m_per_sec": gait.velocity_m_per_sec,
        "stride_m": gait.stride_m(),
        "steps_per_min": gait.cadence_per_min(),
        "contact_share": gait.contact_share(),
        "skate_m_per_sec": gait.skate_m_per_sec,
        "sole_height_m": gait.sole_height_m,
        "contacts": gait.contacts.iter().map(contact).collect::<Vec<_>>(),
    })
}

/// Returns the line of a gait from its description.
pub(super) fn as_text(gait: &Value) -> String {
    let number = |name: &str| gait[name].as_f64();
    let Some(speed) = number("speed_m_per_sec") else { return String::new() };
    let [left, forward] = [0, 1].map(|at| gait["velocity_m_per_sec"][at].as_f64().unwrap_or(0.0));
    let degrees = left.atan2(forward).to_degrees();
    let side = if degrees > 0.0 { "left" } else { "right" };
    let direction = match degrees.abs() {
        _ if speed < WALKING_M_PER_SEC => String::new(),
        off if off < OFF_FRONT_DEGREES => String::new(),
        off if off > 180.0 - OFF_FRONT_DEGREES => " backwards".to_owned(),
        off => format!(" at {off:.0} degrees to the {side}"),
    };
    let stride = number("stride_m").map_or(String::new(), |m| format!(", stride {m:.2} m"));
    let cadence =
        number("steps_per_min").map_or(String::new(), |steps| format!(", {steps:.0} steps/min"));
    format!(
        "    gait: {speed:.2} m/s{direction}{stride}{cadence}, contact {:.0} %, skate {:.3} m/s\n",
        100.0 * number("contact_share").unwrap_or_default(),
        number("skate_m_per_sec").unwrap_or_default(),
    )
}
