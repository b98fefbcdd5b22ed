//! Thin surfaces at every level: the brim of a hat and the skirt of a dress.

use std::f64::consts::TAU;

use populace_cast::{Bottom, Hat, Look, person};
use populace_character::{Level, Mesh};
use populace_lod::levels_of;

use super::geometry::{Point, crossing, dot, normal};

#[test]
fn brims_stay_as_broad_as_the_error_allows() {
    let look = Look { hat: Some(Hat::SunHat), ..Look::girl() };
    let girl = person(&look).unwrap();
    let hat = girl.parts.iter().position(|p| p.node_name.contains("hat")).unwrap();
    let breadth = |mesh: &Mesh| {
        let across = mesh.indices.iter().map(|index| mesh.positions[*index as usize][0]);
        let (low, high) =
            across.fold((0.0_f32, 0.0_f32), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    let own = breadth(&girl.parts[hat].mesh);
    for Level { error_m, meshes, .. } in levels_of(&girl) {
        let left = breadth(&meshes[hat]);
        assert!(left >= own - 4.0 * error_m, "{left} of {own} m with an error of {error_m} m");
    }
}

/// A triangle with its part and the red of its vertex colours.
struct Triangle {
    corners: [Point; 3],
    part: usize,
    red: f32,
}

/// Returns the triangles of a level. The built-in people are bound in model space, so positions are
/// those at rest.
fn triangles(meshes: &[Mesh]) -> Vec<Triangle> {
    let of_part = |(part, mesh): (usize, &Mesh)| {
        let at = |index: u32| mesh.positions[index as usize].map(f64::from);
        let red = |index: u32| mesh.colors[index as usize][0];
        let triangle = |t: &[u32; 3]| Triangle {
            corners: t.map(at),
            part,
            red: t.map(red).iter().sum::<f32>() / 3.0,
        };
        mesh.indices.as_chunks::<3>().0.iter().map(triangle).collect::<Vec<_>>()
    };
    meshes.iter().enumerate().flat_map(of_part).collect()
}

/// Returns the first triangle along a ray that shows its front.
fn seen(triangles: &[Triangle], from: Point, along: Point) -> Option<&Triangle> {
    let hits = triangles.iter().filter(|t| dot(normal(t.corners), along) < 0.0);
    let distances = hits.filter_map(|t| Some((crossing(from, along, t.corners)?, t)));
    distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, triangle)| triangle)
}

#[test]
fn skirts_at_rest_hide_their_inside_and_the_legs_at_every_level() {
    let look = Look::girl();
    assert_eq!(look.bottom, Bottom::Dress);
    let girl = person(&look).unwrap();
    let dress = girl.materials.iter().position(|m| m.name == "Top").unwrap();
    let height = f64::from(girl.height_m());
    for Level { error_m, meshes, .. } in levels_of(&girl) {
        let triangles = triangles(&meshes);
        for (around, up) in (0..24).flat_map(|a| [0.30, 0.34, 0.38].map(|up| (a, up))) {
            let angle = TAU * (f64::from(around) + 0.4) / 24.0;
            let from = [2.0 * angle.sin(), up * height, 2.0 * angle.cos()];
            let along = [-angle.sin(), 0.0, -angle.cos()];
            let place = format!("{error_m} m off, {up} up, {around} of 24 around");
            let first = seen(&triangles, from, along);
            let Triangle { part, red, .. } = first.unwrap_or_else(|| panic!("{place}: nothing"));
            assert_eq!(girl.parts[*part].material, Some(dress), "{place}");
            assert!(*red > 0.6, "{place}: the inner side is seen, of red {red}");
        }
    }
}
