//! Thin surfaces at every level: the brim of a hat, the skirt of a dress, and hair.

use std::f64::consts::TAU;

use populace_cast::{Bottom, Hair, Hat, Look, person};
use populace_character::{Character, Level, Mesh};
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

/// Returns the names of the materials that rays from around and above a head meet first.
fn seen_above(girl: &Character, meshes: &[Mesh]) -> Vec<String> {
    let triangles = triangles(meshes);
    let middle = [0.0, 0.93 * f64::from(girl.height_m()), 0.0];
    let directions = (0..24).flat_map(|around| [0.3, 0.5, 0.7, 0.9].map(|up| (around, up)));
    let name = |(around, up): (i32, f64)| {
        let angle = TAU * (f64::from(around) + 0.4) / 24.0;
        let level = (1.0 - up * up).sqrt();
        let from = [level * angle.sin(), up, level * angle.cos()];
        let seen = seen(&triangles, [0, 1, 2].map(|i| middle[i] + from[i]), from.map(|c| -c));
        let material = seen.and_then(|t| girl.parts[t.part].material);
        material.map_or_else(String::new, |m| girl.materials[m].name.clone())
    };
    directions.map(name).collect()
}

#[test]
fn hair_hides_the_scalp_at_all_levels_but_the_last() {
    for hair in [Hair::Bun, Hair::SidePart, Hair::Long] {
        let girl = person(&Look { hair, hat: None, ..Look::girl() }).unwrap();
        let own: Vec<Mesh> = girl.parts.iter().map(|part| part.mesh.clone()).collect();
        let whole = seen_above(&girl, &own);
        let haired = whole.iter().filter(|name| name.starts_with("Hair")).count();
        assert!(haired > 40, "{hair:?}: {whole:?}");
        // The head is less than four errors high in the last level.
        let levels = levels_of(&girl);
        let height = girl.height_m();
        for Level { error_m, meshes, .. } in levels.iter().filter(|l| l.error_m < 0.04 * height) {
            let level = seen_above(&girl, meshes);
            let bare = whole.iter().zip(&level);
            let bare = bare.filter(|(w, l)| w.starts_with("Hair") && *l == "Skin").count();
            assert!(bare * 12 <= haired, "{hair:?}, {error_m} m off: {bare} of {haired} bare");
        }
    }
}
