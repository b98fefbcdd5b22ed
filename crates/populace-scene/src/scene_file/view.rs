//! Checks of how a scene is seen.

use super::fault::{Fault, first, first_of, unknown};
use super::limits::{
    COORDINATE, FIELD_OF_VIEW, FILM_SECS, FPS, HEADING, KEY_SECS, PIXELS, SUN_HEIGHT,
};
use crate::plan::{CameraKey, CameraPlan, LightPlan, OutputPlan, ScenePlan};

/// The skies, by name.
const SKIES: [&str; 4] = ["day", "evening", "overcast", "studio"];
/// Names that `--camera` takes for other cameras.
const TAKEN_NAMES: [&str; 7] = ["crowd", "close", "top", "iso", "orbit", "follow", "eye"];
const TAKEN_CHARS: [char; 4] = [':', ',', '/', '.'];

pub(super) fn check(plan: &ScenePlan) -> Option<Fault> {
    check_light(&plan.light)
        .map(|fault| fault.within("light"))
        .or_else(|| check_output(&plan.output).map(|fault| fault.within("output")))
        .or_else(|| first_of("camera", &plan.cameras, check_camera))
}

fn check_light(light: &LightPlan) -> Option<Fault> {
    first([
        unknown("one of the skies", &light.sky, SKIES).map(|rule| Fault::of("sky", rule)),
        light.sun_height_deg.and_then(|height| SUN_HEIGHT.check("sun_height_deg", height)),
        light.sun_facing_deg.and_then(|facing| HEADING.check("sun_facing_deg", facing)),
    ])
}

fn check_output(output: &OutputPlan) -> Option<Fault> {
    first([
        PIXELS.check_all("size", &output.size),
        FPS.check("fps", output.fps),
        FILM_SECS.check("seconds", output.seconds),
        FILM_SECS.check("lead_in_s", output.lead_in_s),
    ])
}

fn check_camera(camera: &CameraPlan) -> Option<Fault> {
    let CameraPlan { name, keys } = camera;
    let is_taken = TAKEN_NAMES.contains(&name.as_str());
    if is_taken || !name.starts_with(char::is_alphabetic) || name.contains(TAKEN_CHARS) {
        let taken = TAKEN_NAMES.join(", ");
        let rule = format!(
            "a name that begins with a letter, has no colon, comma, slash or dot, and is none of \
             {taken}, not \"{name}\": `--camera` takes those for other cameras"
        );
        return Some(Fault::of("name", rule));
    }
    if keys.is_empty() {
        return Some(Fault::of("key", "at least one key"));
    }
    let mut all = keys.iter().enumerate();
    all.find_map(|(nth, key)| check_key(key, &keys[..nth]).map(|fault| fault.nth("key", nth)))
}

fn check_key(key: &CameraKey, before: &[CameraKey]) -> Option<Fault> {
    let is_early = before.last().is_some_and(|before| before.time > key.time);
    // Two keys at one time are a cut.
    let is_third = before.iter().rev().nth(1).is_some_and(|early| early.time >= key.time);
    first([
        KEY_SECS.check("time", key.time),
        is_early.then(|| Fault::of("time", "not before that of the key before")),
        is_third.then(|| Fault::of("time", "after that of the two keys before, which are a cut")),
        COORDINATE.check_all("from", &key.from),
        COORDINATE.check_all("to", &key.to),
        (key.from == key.to).then(|| Fault::of("to", "another point than `from`")),
        FIELD_OF_VIEW.check("fov", key.fov),
    ])
}
