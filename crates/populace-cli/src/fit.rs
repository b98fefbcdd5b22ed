//! What the program says of clips that fit a character badly.

use populace::{BindingMethod, BindingReport};
use serde_json::{Value, json};

use crate::report::{as_typed, talk};

/// Names bind less of what a clip moves only where a part of the motion is missing: files whose
/// clips and skeletons belong together have at least 0.89, others at most 0.17.
const WELL_BOUND: f32 = 0.8;
/// Names alone bind joints that are turned further from each other at rest only where the rigs
/// differ, in radians: then 0.8 and more, else nothing.
const WELL_TURNED_RAD: f32 = 0.3;

/// Warns where names bind a clip badly.
pub(crate) fn warn(clip: &str, character: &str, report: &BindingReport) {
    if report.way == BindingMethod::Roles {
        return;
    }
    let apart = report.rest_turn_rad > WELL_TURNED_RAD;
    if report.share() >= WELL_BOUND && !apart {
        return;
    }
    let turned = if apart {
        format!(", and rest poses are {:.0} degrees apart", report.rest_turn_rad.to_degrees())
    } else {
        String::new()
    };
    talk!(
        "warning: the clip \"{clip}\" fits \"{character}\" badly: by name it moves {} of the {} \
         joints that it is made for{turned}",
        report.bound_joints,
        report.moving_joints
    );
}

/// How well a clip fits, for documents.
pub(crate) fn told(report: &BindingReport) -> Value {
    let way = match report.way {
        BindingMethod::SameRest => "same rest",
        BindingMethod::Roles => "roles",
        BindingMethod::Names => "names",
    };
    json!({
        "way": way,
        "share": as_typed(report.share()),
        "rest_turn_deg": as_typed(report.rest_turn_rad.to_degrees()),
    })
}
