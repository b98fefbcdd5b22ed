//! Rays through the meshes of a character at rest.

use glam::DVec3;
use populace_character::Character;

/// A hit of a ray.
#[derive(Clone, Debug)]
pub(crate) struct Hit {
    /// Distance in metres.
    pub(crate) away: f64,
    /// Name of the material.
    pub(crate) material: String,
}

/// Returns the corners of all triangles at rest, with their normals and the names of their materials.
pub(crate) fn triangles(character: &Character) -> Vec<([DVec3; 3], [DVec3; 3], &str)> {
    let mut found = Vec::new();
    for (index, part) in character.parts.iter().enumerate() {
        let name = part.material.map_or("", |m| character.materials[m].name.as_str());
        let places = character.rest_positions(index);
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        for corners in part.mesh.indices.chunks(3) {
            let at = |k: usize| corners[k] as usize;
            let points = [0, 1, 2].map(|k| wide(places[at(k)]));
            // Rest poses of props turn nothing.
            let normals = [0, 1, 2].map(|k| wide(part.mesh.normals[at(k)]));
            found.push((points, normals, name));
        }
    }
    found
}

/// Returns all hits of a ray, nearest first (T. Moeller and B. Trumbore, "Fast, minimum storage
/// ray-triangle intersection", 1997). `along` has length 1.
pub(crate) fn hits(character: &Character, from: DVec3, along: DVec3) -> Vec<Hit> {
    let mut hits = Vec::new();
    for ([a, b, c], _, material) in triangles(character) {
        let (ab, ac) = (b - a, c - a);
        let across = along.cross(ac);
        let det = ab.dot(across);
        if det.abs() < 1e-12 {
            continue;
        }
        let out = from - a;
        let u = out.dot(across) / det;
        let other = out.cross(ab);
        let v = along.dot(other) / det;
        let away = ac.dot(other) / det;
        if u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && away > 0.0 {
            hits.push(Hit { away, material: material.to_owned() });
        }
    }
    hits.sort_by(|a, b| a.away.total_cmp(&b.away));
    hits
}

/// Returns the height of the first surface beneath a point.
pub(crate) fn height(character: &Character, x: f32, z: f32, from: f64) -> Option<f64> {
    let top = DVec3::new(f64::from(x), from, f64::from(z));
    hits(character, top, -DVec3::Y).first().map(|hit| from - hit.away)
}
