//! Parts of a character in a pose, and distances from them.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DVec3};
use populace::character::{Character, Mesh, Part};
use populace::model::Affine;

/// The transforms that take a character's meshes from bind to model space, one per palette entry.
pub(crate) struct Binds(Vec<DAffine3>);

impl Binds {
    /// Returns the transforms of a pose, from `models`, those of its joints.
    pub(crate) fn new(person: &Character, models: &[Affine]) -> Self {
        let models: Vec<DAffine3> = models.iter().map(affine).collect();
        Self::of(person, &models)
    }

    pub(crate) fn at_rest(person: &Character) -> Self {
        Self::of(person, &person.skeleton.rest_models())
    }

    fn of(person: &Character, models: &[DAffine3]) -> Self {
        let entries = person.palette.iter();
        Self(entries.map(|e| models[e.joint.index()] * affine(&e.joint_from_bind)).collect())
    }

    /// Returns the vertices of a mesh, in metres in model space.
    pub(crate) fn skinned(&self, mesh: &Mesh) -> Vec<DVec3> {
        let per = mesh.influences.per_vertex;
        let entries = mesh.influences.entries.chunks_exact(per);
        let weights = mesh.influences.weights.chunks_exact(per);
        let vertices = mesh.positions.iter().zip(entries.zip(weights));
        let place = |(at, (entries, weights)): (&[f32; 3], (&[u16], &[f32]))| {
            let at = DVec3::from(at.map(f64::from));
            let pairs = entries.iter().zip(weights);
            pairs.map(|(e, w)| self.0[usize::from(*e)].transform_point3(at) * f64::from(*w)).sum()
        };
        vertices.map(place).collect()
    }
}

/// Returns the first part whose node's name begins with `name`.
pub(crate) fn part<'a>(person: &'a Character, name: &str) -> Option<&'a Part> {
    person.parts.iter().find(|part| part.node_name.starts_with(name))
}

fn affine(m: &Affine) -> DAffine3 {
    let column = |c: usize| DVec3::from(m.rows.map(|row| f64::from(row[c])));
    DAffine3::from_cols(column(0), column(1), column(2), column(3))
}

/// Places that are this close are the same, in metres.
const SAME_M: f64 = 1e-9;

/// Returns the triangles of a mesh.
pub(crate) fn triangles(mesh: &Mesh) -> Vec<[usize; 3]> {
    mesh.indices.as_chunks().0.iter().map(|triangle| triangle.map(|c| c as usize)).collect()
}

/// Returns the triangles without the bands that give edges of clothes their depth. Bands share no
/// vertex with the cloth, and all of their vertices are on their borders.
pub(crate) fn without_bands(triangles: Vec<[usize; 3]>) -> Vec<[usize; 3]> {
    let on_border: HashSet<usize> = borders(&triangles).into_iter().flatten().collect();
    let cloth = |triangle: &[usize; 3]| triangle.iter().any(|c| !on_border.contains(c));
    let mut inner: HashSet<usize> =
        triangles.iter().filter(|t| cloth(t)).flatten().copied().collect();
    // Corners of cloth can have triangles of border vertices alone.
    loop {
        let before = inner.len();
        let touching = triangles.iter().filter(|t| t.iter().any(|c| inner.contains(c)));
        let touching: Vec<usize> = touching.flatten().copied().collect();
        inner.extend(touching);
        if inner.len() == before {
            break;
        }
    }
    triangles.into_iter().filter(|t| inner.contains(&t[0])).collect()
}

/// Returns the edges that bound only one of some triangles, the lesser vertex first.
pub(crate) fn borders(triangles: &[[usize; 3]]) -> HashSet<[usize; 2]> {
    let mut uses: HashMap<[usize; 2], u32> = HashMap::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *uses.entry([*from.min(to), *from.max(to)]).or_default() += 1;
        }
    }
    uses.into_iter().filter(|(_, uses)| *uses == 1).map(|(edge, _)| edge).collect()
}

/// A patch of a mesh: some of its triangles, with the edges that bound only one of them.
pub(crate) struct Patch {
    triangles: Vec<[usize; 3]>,
    borders: HashSet<[usize; 2]>,
}

impl Patch {
    pub(crate) fn new(triangles: Vec<[usize; 3]>) -> Self {
        Self { borders: borders(&triangles), triangles }
    }

    /// Returns how far a point is outside of the patch, in metres; negative if it is inside. `None`
    /// if the nearest place is on the border. `places` are those of the mesh's vertices. On edges
    /// and corners the sum of the normals around them counts.
    pub(crate) fn outside_m(&self, places: &[DVec3], point: DVec3) -> Option<f64> {
        let (mut least, mut nearest, mut up) = (f64::MAX, DVec3::ZERO, DVec3::ZERO);
        let mut on_border = true;
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| places[corner]);
            let (place, shares) = nearest_on(corners, point);
            let [a, b, c] = corners;
            let away = point.distance(place);
            if away > least + SAME_M {
                continue;
            }
            if away < least - SAME_M {
                (least, nearest, up, on_border) = (away, place, DVec3::ZERO, false);
            }
            up += (b - a).cross(c - a).normalize_or_zero();
            on_border |= self.is_border(triangle, shares);
        }
        (!on_border).then(|| (point - nearest).dot(up.normalize_or_zero()))
    }

    /// Returns whether a place in a triangle, given by shares of its corners, is on a border.
    fn is_border(&self, triangle: &[usize; 3], shares: [f64; 3]) -> bool {
        (0..3).any(|at| {
            let (from, to) = (triangle[(at + 1) % 3], triangle[(at + 2) % 3]);
            shares[at] < 1e-9 && self.borders.contains(&[from.min(to), from.max(to)])
        })
    }
}

/// Returns the place in a triangle that is nearest to a point, and the shares of its corners
/// (C. Ericson, "Real-Time Collision Detection", section 5.1.5, 2005).
fn nearest_on([a, b, c]: [DVec3; 3], point: DVec3) -> (DVec3, [f64; 3]) {
    let (ab, ac) = (b - a, c - a);
    let on_edge = |from: DVec3, along: DVec3| {
        ((point - from).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0)
    };
    let normal = ab.cross(ac);
    let square = normal.length_squared().max(1e-30);
    let v = (point - a).cross(ac).dot(normal) / square;
    let w = ab.cross(point - a).dot(normal) / square;
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return (a + ab * v + ac * w, [1.0 - v - w, v, w]);
    }
    let (s, t, u) = (on_edge(a, ab), on_edge(b, c - b), on_edge(a, ac));
    let edges = [
        (a + ab * s, [1.0 - s, s, 0.0]),
        (b + (c - b) * t, [0.0, 1.0 - t, t]),
        (a + ac * u, [1.0 - u, 0.0, u]),
    ];
    let nearer = |x: &(DVec3, [f64; 3]), y: &(DVec3, [f64; 3])| {
        x.0.distance_squared(point).total_cmp(&y.0.distance_squared(point))
    };
    edges.into_iter().min_by(nearer).unwrap_or((a, [1.0, 0.0, 0.0]))
}

/// Returns the place at which a segment meets a triangle (T. Möller and B. Trumbore, "Fast, minimum
/// storage ray/triangle intersection", Journal of Graphics Tools 2(1), 1997).
pub(crate) fn crossing(from: DVec3, to: DVec3, [a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (ab, ac, along) = (b - a, c - a, to - from);
    let cross = along.cross(ac);
    let det = ab.dot(cross);
    if det.abs() < 1e-18 {
        return None;
    }
    let offset = from - a;
    let u = offset.dot(cross) / det;
    let across = offset.cross(ab);
    let v = along.dot(across) / det;
    let far = ac.dot(across) / det;
    let hits = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&far);
    hits.then(|| from + along * far)
}
