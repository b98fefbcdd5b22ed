//! Solids of flat faces, and the normals of their corners.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};

/// Length in metres below which points are one.
const WELD_M: f64 = 1e-5;
/// Twice the area in square metres below which a face is left out.
const LEAST_AREA: f64 = 1e-9;

/// Points in metres, and faces as convex polygons of them, counter-clockwise seen from outside. A
/// solid may be open.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solid {
    pub(crate) points: Vec<DVec3>,
    pub(crate) faces: Vec<Vec<usize>>,
}

/// A face with a unit normal, and the point and normal of each corner.
pub(super) struct Face {
    pub(super) normal: DVec3,
    pub(super) corners: Vec<(usize, DVec3)>,
}

impl Solid {
    /// Adds a point and returns its index.
    pub(crate) fn point(&mut self, point: DVec3) -> usize {
        self.points.push(point);
        self.points.len() - 1
    }

    /// Adds a face of new points.
    pub(crate) fn face(&mut self, points: &[DVec3]) {
        let first = self.points.len();
        self.points.extend(points);
        self.faces.push((first..self.points.len()).collect());
    }

    /// Adds another solid.
    pub(crate) fn join(&mut self, other: &Self) {
        let first = self.points.len();
        self.points.extend(&other.points);
        let moved = |face: &Vec<usize>| face.iter().map(|p| p + first).collect();
        self.faces.extend(other.faces.iter().map(moved));
    }

    /// Returns the solid with its inside out.
    pub(crate) fn turned(mut self) -> Self {
        for face in &mut self.faces {
            face.reverse();
        }
        self
    }

    /// Returns the solid with all faces turned away from a point.
    pub(crate) fn outwards_from(mut self, middle: DVec3) -> Self {
        for index in 0..self.faces.len() {
            let face = &self.faces[index];
            let away: DVec3 = face.iter().map(|p| self.points[*p] - middle).sum();
            if self.area(face).dot(away) < 0.0 {
                self.faces[index].reverse();
            }
        }
        self
    }

    /// Returns the solid after a transform. One that mirrors keeps the outside.
    pub(crate) fn moved(&self, to: &DAffine3) -> Self {
        let points = self.points.iter().map(|p| to.transform_point3(*p)).collect();
        let moved = Self { points, faces: self.faces.clone() };
        if to.matrix3.determinant() < 0.0 { moved.turned() } else { moved }
    }

    /// Returns the faces with area. A corner's normal is the mean of the faces around it that meet
    /// its own face at an angle of at most `crease_deg`, weighted by their areas.
    pub(super) fn corners(&self, crease_deg: f64) -> Vec<Face> {
        let least_cosine = crease_deg.to_radians().cos();
        let welded = self.welded();
        let areas: Vec<DVec3> = self.faces.iter().map(|face| self.area(face)).collect();
        let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            if areas[index].length() > LEAST_AREA {
                for point in face {
                    around.entry(welded[*point]).or_default().push(index);
                }
            }
        }
        let mut faces = Vec::with_capacity(self.faces.len());
        for (index, face) in self.faces.iter().enumerate() {
            if areas[index].length() <= LEAST_AREA {
                continue;
            }
            let normal = areas[index].normalize();
            let corner = |&point: &usize| {
                let near = around.get(&welded[point]).into_iter().flatten();
                let smooth = near.filter(|f| areas[**f].normalize().dot(normal) >= least_cosine);
                let sum: DVec3 = smooth.map(|f| areas[*f]).sum();
                (welded[point], sum.normalize_or(normal))
            };
            faces.push(Face { normal, corners: face.iter().map(corner).collect() });
        }
        faces
    }

    /// Returns for each point the first one at its place.
    fn welded(&self) -> Vec<usize> {
        let mut first: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        let place = |p: &DVec3| whole(*p / WELD_M);
        let each = self.points.iter().enumerate();
        each.map(|(index, point)| *first.entry(place(point)).or_insert(index)).collect()
    }

    /// Returns twice a face's area along its normal, by Newell's method.
    fn area(&self, face: &[usize]) -> DVec3 {
        let points = face.iter().map(|p| self.points[*p]);
        let Some(origin) = points.clone().next() else { return DVec3::ZERO };
        let next = points.clone().cycle().skip(1);
        points.zip(next).map(|(a, b)| (a - origin).cross(b - origin)).sum()
    }
}

/// Returns the axis of a normal's largest component: 0, 1 or 2.
pub(super) fn main_axis(normal: DVec3) -> usize {
    let size = normal.abs();
    // Slopes of roofs count as level up to some 50 degrees.
    if 1.2 * size.y >= size.x.max(size.z) {
        1
    } else if size.x > size.z {
        0
    } else {
        2
    }
}

/// Returns texture coordinates in metres on the plane across an axis; v runs downwards.
pub(super) fn planar(point: DVec3, axis: usize) -> [f64; 2] {
    match axis {
        0 => [point.z, -point.y],
        1 => [point.x, point.z],
        _ => [point.x, -point.y],
    }
}

/// Returns a unit vector as whole numbers, by which equal ones are found.
pub(super) fn rounded(normal: DVec3) -> [i64; 3] {
    whole(normal * 1e4)
}

#[expect(clippy::cast_possible_truncation, reason = "props are far smaller than 2^63 steps")]
fn whole(v: DVec3) -> [i64; 3] {
    v.to_array().map(|c| c.round() as i64)
}
