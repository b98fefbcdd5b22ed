//! Scenarios of Vadere: the topography in JSON.

use serde_json::Value;

use crate::{Place, PlaceChange, Polygon};

/// Returns the place of a scenario, or the reason why it has none.
pub(crate) fn place(text: &str) -> Result<Place, String> {
    let json: Value = serde_json::from_str(text)
        .map_err(|error| format!("no JSON ({error}), so no scenario of Vadere"))?;
    let topography = ["/scenario/topography", "/topography"]
        .iter()
        .find_map(|path| json.pointer(path))
        .ok_or("no topography, so no scenario of Vadere")?;
    let bounds = topography.pointer("/attributes/bounds").and_then(rectangle);
    let bounds = bounds.ok_or("no bounds in the topography's attributes")?;
    let width = |name: &str| topography.pointer(name).and_then(Value::as_f64);
    let is_bounded = topography.pointer("/attributes/bounded").and_then(Value::as_bool);
    // A wall of this width runs along the inside of the bounds.
    let wall = width("/attributes/boundingBoxWidth").filter(|_| is_bounded != Some(false));
    let walkable = vec![outline(inset(bounds, wall.unwrap_or(0.0)))];
    Ok(Place {
        changes: vec![PlaceChange { from_secs: 0.0, walkable }],
        obstacles: shapes(topography, "obstacles")?,
        sources: shapes(topography, "sources")?,
        targets: shapes(topography, "targets")?,
    })
}

/// Returns the shapes of a list of the topography.
fn shapes(topography: &Value, list: &str) -> Result<Vec<Polygon>, String> {
    let elements = topography.get(list).and_then(Value::as_array);
    let elements = elements.into_iter().flatten().enumerate();
    let polygons = elements.map(|(index, element)| {
        let polygon = element.get("shape").and_then(shape);
        polygon.ok_or_else(|| format!("{list}[{index}] has no polygon, rectangle or circle"))
    });
    polygons.collect()
}

fn shape(shape: &Value) -> Option<Polygon> {
    match shape.get("type").and_then(Value::as_str)? {
        "RECTANGLE" => rectangle(shape).map(outline),
        "CIRCLE" => circle(shape),
        _ => {
            let points = shape.get("points")?.as_array()?;
            let outline = points.iter().map(point).collect::<Option<Vec<_>>>()?;
            (outline.len() > 2).then_some(Polygon { outline, holes: Vec::new() })
        }
    }
}

fn point(point: &Value) -> Option<[f64; 2]> {
    let part = |name: &str| point.get(name).and_then(Value::as_f64).filter(|v| v.is_finite());
    Some([part("x")?, part("y")?])
}

/// Returns the corners with the least and the greatest coordinates.
fn rectangle(shape: &Value) -> Option<[[f64; 2]; 2]> {
    let [x, y] = point(shape)?;
    let length = |name: &str| shape.get(name).and_then(Value::as_f64).filter(|v| *v > 0.0);
    Some([[x, y], [x + length("width")?, y + length("height")?]])
}

/// Returns a rectangle without a margin; itself if nothing would be left.
fn inset([least, most]: [[f64; 2]; 2], by: f64) -> [[f64; 2]; 2] {
    let inner = [least.map(|v| v + by), most.map(|v| v - by)];
    let is_left = by > 0.0 && (0..2).all(|axis| inner[0][axis] < inner[1][axis]);
    if is_left { inner } else { [least, most] }
}

fn outline([[left, bottom], [right, top]]: [[f64; 2]; 2]) -> Polygon {
    let outline = vec![[left, bottom], [right, bottom], [right, top], [left, top]];
    Polygon { outline, holes: Vec::new() }
}

/// Returns a polygon of 32 corners for a circle.
fn circle(shape: &Value) -> Option<Polygon> {
    let [x, y] = point(shape.get("center")?)?;
    let radius = shape.get("radius").and_then(Value::as_f64).filter(|v| *v > 0.0)?;
    let corner = |i: u32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 32.0).sin_cos();
        [x + radius * cos, y + radius * sin]
    };
    Some(Polygon { outline: (0..32).map(corner).collect(), holes: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::place;

    #[test]
    fn walkable_is_within_the_walls_of_the_bounds() {
        let place = place(
            r#"{"scenario": {"topography": {
                "attributes": {"bounds": {"x": 1, "y": 2, "width": 8, "height": 10},
                    "boundingBoxWidth": 0.5, "bounded": true},
                "obstacles": [{"shape": {"type": "POLYGON",
                    "points": [{"x": 0, "y": 0}, {"x": 1, "y": 0}, {"x": 1, "y": 1}]}}],
                "targets": [{"shape": {"type": "CIRCLE", "radius": 2,
                    "center": {"x": 3, "y": 3}}}],
                "sources": [{"shape": {"type": "RECTANGLE",
                    "x": 2, "y": 3, "width": 1, "height": 4}}]}}}"#,
        )
        .unwrap();
        let corners = [[1.5, 2.5], [8.5, 2.5], [8.5, 11.5], [1.5, 11.5]];
        assert_eq!(place.changes[0].walkable[0].outline, corners);
        assert_eq!(place.obstacles[0].outline, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert_eq!(place.sources[0].outline, [[2.0, 3.0], [3.0, 3.0], [3.0, 7.0], [2.0, 7.0]]);
        assert_eq!(place.targets[0].outline.len(), 32);
        assert_eq!(place.targets[0].outline[0], [5.0, 3.0]);
    }

    #[test]
    fn reasons_name_the_part() {
        assert!(place("{").unwrap_err().contains("no JSON"));
        assert!(place("{}").unwrap_err().contains("no topography"));
        let bounds = r#""attributes": {"bounds": {"x": 0, "y": 0, "width": 1, "height": 1}}"#;
        let text = format!(r#"{{"topography": {{{bounds}, "obstacles": [{{}}]}}}}"#);
        assert!(place(&text).unwrap_err().starts_with("obstacles[0]"));
        let text = format!(r#"{{"topography": {{{bounds}}}}}"#);
        assert_eq!(place(&text).unwrap().changes[0].walkable[0].outline[2], [1.0, 1.0]);
    }
}
