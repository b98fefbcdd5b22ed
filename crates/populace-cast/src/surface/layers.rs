//! Layers of cloth: a surface whose covers have lifts becomes one of stacked sheets with walls at
//! their borders.

use std::collections::BTreeMap;

use super::{Cover, Surface};

/// A sheet at one point: the cover, and the new index of the point in it.
type Sheet = (Cover, usize);

/// Returns the surface with each cover lifted off along the normals, and walls between covers of
/// different lifts, so that it stays closed.
pub(super) fn lifted(base: &Surface) -> Surface {
    let normals = base.normals();
    let mut covers: Vec<Vec<Cover>> = vec![Vec::new(); base.points.len()];
    for (corners, cover) in &base.triangles {
        for &corner in corners {
            if !covers[corner].contains(cover) {
                covers[corner].push(*cover);
            }
        }
    }
    let mut result = Surface::default();
    let mut sheets: Vec<Vec<Sheet>> = Vec::with_capacity(covers.len());
    for (point, mut own) in covers.into_iter().enumerate() {
        own.sort_by(|a, b| a.lift.total_cmp(&b.lift));
        let add = |cover: Cover| {
            let position = base.points[point] + normals[point] * cover.lift;
            let paint = base.paints[point];
            result.brush = [0, 1, 2].map(|i: usize| paint[i] * cover.paint[i]);
            (cover, result.point(position, base.weights[point].clone()))
        };
        sheets.push(own.into_iter().map(add).collect());
    }
    let of = |point: usize, cover: Cover| {
        sheets[point].iter().find(|(c, _)| *c == cover).map_or(0, |(_, index)| *index)
    };
    for &(corners, cover) in &base.triangles {
        result.triangles.push((corners.map(|corner| of(corner, cover)), cover));
    }
    for (edge, [low, high]) in borders(base) {
        wall(&mut result, edge.map(|point| sheets[point].as_slice()), [low, high]);
    }
    result
}

/// Returns the edges between covers of different lifts, in the direction of the higher cover's
/// triangle, with the lower and the higher cover.
fn borders(base: &Surface) -> Vec<([usize; 2], [Cover; 2])> {
    let mut of_edge = BTreeMap::new();
    for &([a, b, c], cover) in &base.triangles {
        of_edge.extend([((a, b), cover), ((b, c), cover), ((c, a), cover)]);
    }
    let mut borders = Vec::new();
    for (&(a, b), &high) in &of_edge {
        if let Some(&low) = of_edge.get(&(b, a))
            && low.lift < high.lift
        {
            borders.push(([a, b], [low, high]));
        }
    }
    borders
}

/// Adds the wall below an edge of the higher cover. Sheets between both covers divide its ends.
fn wall(result: &mut Surface, ends: [&[Sheet]; 2], [low, high]: [Cover; 2]) {
    let [from, to] = ends.map(|sheets| {
        let within = |cover: &Cover| {
            *cover == low || *cover == high || cover.lift > low.lift && cover.lift < high.lift
        };
        let inside = sheets.iter().filter(|(cover, _)| within(cover));
        inside.map(|&(_, index)| index).collect::<Vec<usize>>()
    });
    // From the top down: a triangle for each step of either end.
    let (mut a, mut b) = (from.len() - 1, to.len() - 1);
    while a > 0 || b > 0 {
        if a >= b {
            result.triangles.push(([from[a - 1], to[b], from[a]], high));
            a -= 1;
        } else {
            result.triangles.push(([from[a], to[b - 1], to[b]], high));
            b -= 1;
        }
    }
}
