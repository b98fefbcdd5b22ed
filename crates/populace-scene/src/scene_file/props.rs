//! Checks of the things that stand in a scene.

use super::fault::{Fault, first, unknown};
use super::limits::{COORDINATE, HEADING, Limits};
use crate::PROP_KINDS;
use crate::plan::{PropPlan, ScenePlan};
use crate::prop_sizes::{MOST_SEATS, Size, size_of, sizes_of};

pub(super) fn check(plan: &ScenePlan, prop: &PropPlan) -> Option<Fault> {
    let crossings = plan.crossings.len();
    let crossing = prop.crossing.filter(|crossing| *crossing >= crossings);
    first([
        check_kind(prop),
        COORDINATE.check_all("at", &prop.at),
        HEADING.check("facing_deg", prop.facing_deg),
        crossing
            .map(|_| Fault::of("crossing", format!("below {crossings}, the number of crossings"))),
    ])
    .or_else(|| check_sizes(prop).map(|rule| Fault::of("size_m", rule)))
}

/// Finds a prop that is neither of a kind nor of a file, or of both.
fn check_kind(prop: &PropPlan) -> Option<Fault> {
    match (prop.kind.as_str(), &prop.file) {
        ("", None) => {
            Some(Fault::of("kind", "a kind of thing, or there must be a `file` in its place"))
        }
        ("", Some(_)) => None,
        (_, Some(_)) => {
            Some(Fault::of("file", "left out: the prop has a `kind`, and is one or the other"))
        }
        (kind, None) => {
            unknown("one of the kinds", kind, PROP_KINDS).map(|rule| Fault::of("kind", rule))
        }
    }
}

/// Returns the rule that the sizes of a prop break.
fn check_sizes(prop: &PropPlan) -> Option<String> {
    let sizes = sizes_of(&prop.kind);
    if prop.size_m.len() > sizes.len() {
        if sizes.is_empty() {
            return Some("left out: only grounds, roads, shopfronts and stands have it".into());
        }
        let names = sizes.iter().map(|size| size.what).collect::<Vec<_>>().join(", then ");
        return Some(format!("of no more than the {names}"));
    }
    let out_of_range = prop.size_m.iter().zip(sizes).find_map(|(value, size)| {
        let Size { what, least, most, unit, .. } = *size;
        let rule = Limits::new(least, most, unit).broken(*value)?;
        Some(format!("of a {what} {rule}"))
    });
    if out_of_range.is_some() || prop.kind != "stand" {
        return out_of_range;
    }
    let [rows, seats] = [0, 1].map(|nth| size_of(prop, nth));
    if rows.fract() != 0.0 || seats.fract() != 0.0 {
        return Some(format!("of whole numbers, not {rows} rows of {seats} seats"));
    }
    (rows * seats > MOST_SEATS).then(|| {
        format!(
            "of at most {MOST_SEATS} seats in all, not {rows} rows of {seats}; put stands side by \
             side"
        )
    })
}
