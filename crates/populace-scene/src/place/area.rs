//! Areas of polygons: their triangles, and the loops around them.

use std::collections::BTreeMap;

use spade::handles::OUTER_FACE;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::crossings::cut_edges;
use super::plan::{Point, Ring, turn};

/// Triangles of the plan between rings.
pub(super) struct Cells {
    triangulation: ConstrainedDelaunayTriangulation<Point2<f64>>,
}

impl Cells {
    /// Triangulates the plan so that no triangle crosses a ring. Rings may cross and touch.
    pub(super) fn new<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Self {
        let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        for edge in cut_edges(rings) {
            // Insertion fails for numbers that are not finite, which nothing brings here.
            let [from, to] = edge.map(|[x, y]| triangulation.insert(Point2::new(x, y)).ok());
            if let (Some(from), Some(to)) = (from, to)
                && from != to
            {
                triangulation.try_add_constraint(from, to);
            }
        }
        Self { triangulation }
    }

    /// Returns the triangles whose middle is inside, counter-clockwise. `inside` is asked as they
    /// are taken, since it may look at all points of a ring.
    pub(super) fn triangles(
        &self,
        inside: impl Fn(Point) -> bool,
    ) -> impl Iterator<Item = [Point; 3]> {
        let faces = self.triangulation.inner_faces();
        let corners = faces.map(|face| face.positions().map(|p| [p.x, p.y]));
        corners.filter(move |corners| inside(middle(corners)))
    }

    /// Returns the loops around all triangles whose middle is inside, with the inside on the left:
    /// outer ones run counter-clockwise, those around holes clockwise.
    pub(super) fn loops(&self, inside: impl Fn(Point) -> bool) -> Vec<Ring> {
        let mut is_inside = vec![false; self.triangulation.num_all_faces()];
        for face in self.triangulation.inner_faces() {
            is_inside[face.index()] = inside(middle(&face.positions().map(|p| [p.x, p.y])));
        }
        is_inside[OUTER_FACE.index()] = false;
        let mut ways: BTreeMap<usize, Vec<(usize, Point)>> = BTreeMap::new();
        let mut places: BTreeMap<usize, Point> = BTreeMap::new();
        for edge in self.triangulation.directed_edges() {
            if is_inside[edge.face().index()] && !is_inside[edge.rev().face().index()] {
                let to = edge.to().position();
                let from = edge.from();
                places.insert(from.index(), [from.position().x, from.position().y]);
                ways.entry(from.index()).or_default().push((edge.to().index(), [to.x, to.y]));
            }
        }
        let mut loops = Vec::new();
        while let Some((&start, _)) = ways.iter().next() {
            loops.push(trace(start, places[&start], &mut ways));
        }
        loops
    }
}

/// Takes a loop out of the edges that are left, and returns it.
fn trace(start: usize, place: Point, ways: &mut BTreeMap<usize, Vec<(usize, Point)>>) -> Ring {
    let mut ring = vec![place];
    let (mut at, mut came) = (start, None);
    while let Some(outs) = ways.get_mut(&at) {
        let here = ring[ring.len() - 1];
        // Where loops touch, the leftmost way stays with the same area.
        let turn = |to: &Point| came.map_or(0.0, |from| turn(from, here, *to));
        let best = (0..outs.len()).max_by(|a, b| turn(&outs[*a].1).total_cmp(&turn(&outs[*b].1)));
        let Some(best) = best else { break };
        let (to, point) = outs.swap_remove(best);
        if outs.is_empty() {
            ways.remove(&at);
        }
        if to == start {
            break;
        }
        came = Some(here);
        ring.push(point);
        at = to;
    }
    ring
}

fn middle([a, b, c]: &[Point; 3]) -> Point {
    [0, 1].map(|i| (a[i] + b[i] + c[i]) / 3.0)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn no_more_triangles_are_asked_for_than_are_taken() {
        let steps = (0..1000_u32).map(|nth| [f64::from(nth), f64::from(nth % 2)]);
        let ring: Ring = steps.chain([[1000.0, 5.0], [-1.0, 5.0]]).collect();
        let asked = Cell::new(0);
        let inside = |_| {
            asked.set(asked.get() + 1);
            true
        };
        let cells = Cells::new([&ring]);
        assert_eq!((cells.triangles(inside).take(3).count(), asked.get()), (3, 3));
    }
}
