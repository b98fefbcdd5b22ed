//! Warnings about clips that fit a character badly.

use populace::{BindingMethod, BindingReport};
use serde_json::{Value, json};

use crate::report::{as_typed, message};

/// A clip bound by joint names fits if at least this share of its joints is bound. Files whose
/// clips and skeletons belong together have at least 0.89, others at most 0.17.
const LEAST_SHARE: f32 = 0.8;
/// A clip bound by joint names fits if the rest rotations differ by at most this, in radians. The
/// difference is 0 for the same rig, and 0.8 or more for different rigs.
const LARGEST_REST_ANGLE_RAD: f32 = 0.3;

/// Warns about a clip that is bound by joint names and fits badly.
pub(crate) fn warn(clip: &str, character: &str, report: &BindingReport) {
    if report.method == BindingMethod::Roles {
        return;
    }
    let apart = report.rest_angle_rad > LARGEST_REST_ANGLE_RAD;
    if report.share() >= LEAST_SHARE && !apart {
        return;
    }
    let rest = if apart {
        format!(", and the rest poses differ by {:.0} degrees", report.rest_angle_rad.to_degrees())
    } else {
        String::new()
    };
    message!(
        "warning: the clip \"{clip}\" fits \"{character}\" badly: {} of its {} joints are found by \
         name{rest}",
        report.bound_joints,
        report.moving_joints
    );
}

/// Describes how well a clip fits, as JSON.
pub(crate) fn as_json(report: &BindingReport) -> Value {
    let method = match report.method {
        BindingMethod::SameRest => "same rest",
        BindingMethod::Roles => "roles",
        BindingMethod::Names => "names",
    };
    json!({
        "way": method,
        "share": as_typed(report.share()),
        "rest_turn_deg": as_typed(report.rest_angle_rad.to_degrees()),
    })
}
