//! The contents of a trajectory file.

use populace_trajectory::{
    Agent, Column, HeadingSource, Origin, Place, Polygon, Recording, Source, Summary, Values,
};
use serde_json::{Value, json};

use crate::report::{as_typed, counted};
use crate::trajectory::{self, format_of, people, rate, reading};

/// Returns the whole description of a recording.
pub(super) fn as_json(recording: &Recording) -> Value {
    let (summary, source) = (recording.summary(), &recording.source);
    let vehicles = trajectory::vehicles(recording);
    let warnings: Vec<_> = recording.warnings.iter().map(ToString::to_string).collect();
    json!({
        "format": source.format.name(),
        "version": source.version,
        "agents": summary.agents,
        "people": summary.agents - vehicles,
        "vehicles": vehicles,
        "peak_agents": summary.peak_agents,
        "rows": recording.row_count(),
        "frames": summary.frames,
        "fps": summary.fps,
        "rows_per_s": summary.rows_per_sec,
        "secs": recording.secs(),
        "duration_s": summary.duration_s,
        "unit": source.unit.value.to_string(),
        "heading": source.heading.value.to_string(),
        "assumed": facts(source, Origin::Assumed),
        "told": facts(source, Origin::Settings),
        "median_speed_m_s": summary.median_speed_m_s,
        "p95_speed_m_s": summary.p95_speed_m_s,
        "max_speed_m_s": summary.max_speed_m_s,
        "extent_m": summary.extent_m.map(|corner| corner.map(as_typed)),
        "elevations_m": summary.elevations_m.map(|range| range.map(as_typed)),
        "origin_m": recording.origin_m,
        "heights_m": heights(&recording.agents).map(|heights| heights.map(as_typed)),
        "gaps": {"agents": summary.gaps.agents, "longest_s": summary.gaps.longest_s},
        "columns": recording.columns.iter().map(column_as_json).collect::<Vec<_>>(),
        "place": place_as_json(&recording.place),
        "warnings": warnings,
    })
}

/// Returns the whole description of a recording as lines.
pub(super) fn as_text(recording: &Recording) -> String {
    let summary = recording.summary();
    let mut lines = vec![
        format_of(&recording.source),
        format!("{}, at most {} at a time", people(recording), summary.peak_agents),
        times(recording, &summary),
        reading(recording),
        format!(
            "speeds of {:.2} m/s in the median, {:.2} m/s at the 95th percentile, {:.2} m/s at \
             most",
            summary.median_speed_m_s, summary.p95_speed_m_s, summary.max_speed_m_s
        ),
        extent(recording, &summary),
        match summary.gaps.agents {
            0 => "no gaps".to_owned(),
            agents => format!(
                "gaps: {} away between rows, for {:.2} s at most",
                counted(agents, "agent"),
                summary.gaps.longest_s
            ),
        },
    ];
    lines.extend(
        heights(&recording.agents)
            .map(|[least, most]| format!("body heights from {least:.2} to {most:.2} m")),
    );
    lines.extend(recording.columns.iter().map(column));
    lines.push(place(&recording.place));
    lines.extend(recording.warnings.iter().map(|warning| format!("warning: {warning}")));
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

/// Returns the names of the facts with an origin. Headings from motion are no assumption.
fn facts(source: &Source, origin: Origin) -> Vec<&'static str> {
    let is_motion = source.heading.value == HeadingSource::Motion;
    let heading = source.heading.origin == origin && !(is_motion && origin == Origin::Assumed);
    let facts = [
        ("unit", source.unit.origin == origin),
        ("fps", source.fps.origin == origin),
        ("heading", heading),
    ];
    facts.into_iter().filter(|(_, holds)| *holds).map(|(name, _)| name).collect()
}

fn times(recording: &Recording, summary: &Summary) -> String {
    let [from, until] = recording.secs();
    format!(
        "{:.1} s, from {} to {} s, in {} and {}",
        summary.duration_s,
        rate(from),
        rate(until),
        counted(summary.frames, "frame"),
        counted(recording.row_count(), "row"),
    )
}

fn extent(recording: &Recording, summary: &Summary) -> String {
    let [[left, bottom], [right, top]] = summary.extent_m;
    let mut text = format!("x from {left:.2} to {right:.2} m, y from {bottom:.2} to {top:.2} m");
    if let Some([low, high]) = summary.elevations_m {
        text += &format!(", elevations from {low:.2} to {high:.2} m");
    }
    match recording.origin_m {
        [0.0, 0.0] => text,
        [x, y] => format!("{text}, relative to {x:.2}, {y:.2} m"),
    }
}

/// Returns the least and the greatest body height in metres, if the file has some.
fn heights(agents: &[Agent]) -> Option<[f32; 2]> {
    let heights = agents.iter().filter_map(|agent| agent.height_m);
    heights.map(|height| [height; 2]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

fn column_as_json(column: &Column) -> Value {
    match &column.values {
        Values::Numbers(_) => json!({"name": column.name, "kind": "numbers"}),
        Values::Words { words, .. } => {
            json!({"name": column.name, "kind": "words", "words": words.len()})
        }
    }
}

fn column(column: &Column) -> String {
    let values = match &column.values {
        Values::Numbers(_) => "numbers".to_owned(),
        Values::Words { words, .. } => counted(words.len(), "word"),
    };
    format!("column \"{}\": {values}", column.name)
}

fn place_as_json(place: &Place) -> Value {
    let walkable = place.walkable_at(0.0);
    json!({
        "areas": walkable.len(),
        "walkable_m2": walkable_m2(walkable),
        "holes": holes(walkable),
        "changes": place.changes.len().saturating_sub(1),
        "obstacles": place.obstacles.len(),
        "sources": place.sources.len(),
        "targets": place.targets.len(),
    })
}

fn place(place: &Place) -> String {
    let walkable = place.walkable_at(0.0);
    if walkable.is_empty() && place.obstacles.is_empty() {
        return "place unknown".to_owned();
    }
    let mut text = format!(
        "place: {} of {:.1} m², {}",
        counted(walkable.len(), "walkable area"),
        walkable_m2(walkable),
        counted(holes(walkable) + place.obstacles.len(), "obstacle"),
    );
    let changes = place.changes.len().saturating_sub(1);
    if changes > 0 {
        text += &format!(", which changes {}", counted(changes, "time"));
    }
    text
}

fn holes(areas: &[Polygon]) -> usize {
    areas.iter().map(|area| area.holes.len()).sum()
}

/// Returns the area of polygons without their holes in square metres.
fn walkable_m2(areas: &[Polygon]) -> f64 {
    // The sum of nothing is -0.
    areas.iter().map(square_metres).sum::<f64>() + 0.0
}

/// Returns the area of a polygon without its holes in square metres.
fn square_metres(area: &Polygon) -> f64 {
    let within = |ring: &Vec<[f64; 2]>| {
        let next = ring.iter().cycle().skip(1);
        let doubled: f64 = ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
        doubled.abs() / 2.0
    };
    within(&area.outline) - area.holes.iter().map(within).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_do_not_count_as_area() {
        let square = |from: f64, to: f64| vec![[from, from], [to, from], [to, to], [from, to]];
        let mut turned = square(1.0, 3.0);
        turned.reverse();
        let area = Polygon { outline: square(0.0, 10.0), holes: vec![turned, square(5.0, 6.0)] };
        assert!((square_metres(&area) - 95.0).abs() < 1e-12);
    }

    #[test]
    fn no_place_has_an_area_of_zero_without_a_sign() {
        assert_eq!(place_as_json(&Place::default())["walkable_m2"].to_string(), "0.0");
    }
}
