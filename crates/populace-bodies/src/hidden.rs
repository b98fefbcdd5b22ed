//! Triangles of the body that nobody sees: those inside the closed mouth.

use std::collections::HashMap;

use glam::Vec3;

use crate::mesh_file::{BaseMesh, fans};

/// Directions in which a triangle is looked at from.
const VIEWS: usize = 24;
/// How far a triangle is seen through narrow gaps, in units of the base mesh.
const START: f32 = 0.01;
/// Rings of triangles around seen ones that count as seen too.
const RINGS: usize = 2;

/// Returns the triangles of the group "body" without those that are hidden in the head.
pub(crate) fn seen_triangles(mesh: &BaseMesh) -> Vec<[u32; 3]> {
    let all = fans(mesh.faces("body"));
    let place = |corner: u32| mesh.positions[corner as usize];
    // Only what lies around the mouth can be hidden; the rest need not be looked at.
    let mouth: Vec<_> = mesh.vertices("helper-tongue");
    let Some((low, high)) = bounds(mouth.iter().map(|v| mesh.positions[*v])) else { return all };
    let margin = Vec3::splat((high - low).max_element());
    let inside = |t: &[u32; 3], margin: Vec3| {
        t.iter().all(|c| {
            let p = place(*c);
            p.cmpge(low - margin).all() && p.cmple(high + margin).all()
        })
    };
    let near: Vec<[Vec3; 3]> =
        all.iter().filter(|t| inside(t, margin)).map(|t| t.map(place)).collect();
    let mut seen: Vec<bool> =
        all.iter().map(|t| !inside(t, margin * 0.5) || is_seen(t.map(place), &near)).collect();
    let mut by_corner: HashMap<u32, Vec<usize>> = HashMap::new();
    for (index, triangle) in all.iter().enumerate() {
        triangle.iter().for_each(|c| by_corner.entry(*c).or_default().push(index));
    }
    for _ in 0..RINGS {
        let before = seen.clone();
        for (index, triangle) in all.iter().enumerate().filter(|(index, _)| !before[*index]) {
            let touching = triangle.iter().flat_map(|c| &by_corner[c]);
            seen[index] = touching.into_iter().any(|other| before[*other]);
        }
    }
    all.into_iter().zip(seen).filter(|(_, seen)| *seen).map(|(t, _)| t).collect()
}

fn bounds(points: impl Iterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.fold(None, |bounds, p| {
        let (low, high) = bounds.unwrap_or((p, p));
        Some((low.min(p), high.max(p)))
    })
}

/// Returns whether the front of a triangle can be seen from some direction.
fn is_seen([a, b, c]: [Vec3; 3], others: &[[Vec3; 3]]) -> bool {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let from = (a + b + c) / 3.0;
    // Points on a sphere along a spiral of golden angles.
    let view = |index: usize| {
        let y = 1.0 - 2.0 * (index as f32 + 0.5) / VIEWS as f32;
        let (sin, cos) = (index as f32 * 2.399_963).sin_cos();
        let radius = (1.0 - y * y).powf(0.5);
        Vec3::new(radius * cos, y, radius * sin)
    };
    let views = (0..VIEWS).map(view).filter(|view| view.dot(normal) > 0.2);
    views.into_iter().any(|view| !others.iter().any(|other| is_hit(from, view, *other)))
}

/// Returns whether a ray meets a triangle (T. Möller and B. Trumbore, "Fast, minimum storage
/// ray/triangle intersection", Journal of Graphics Tools 2(1), 1997).
pub(crate) fn is_hit(from: Vec3, along: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let (ab, ac) = (b - a, c - a);
    let cross = along.cross(ac);
    let det = ab.dot(cross);
    if det.abs() < 1e-12 {
        return false;
    }
    let offset = from - a;
    let u = offset.dot(cross) / det;
    let across = offset.cross(ab);
    let v = along.dot(across) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(across) / det > START
}
