//! Surfaces of triangles that can be cut along a line, pushed out, smoothed and joined.

use std::collections::{BTreeMap, HashMap};

use glam::{Vec3, Vec4};

use crate::rig_file::Weights;

/// A vertex of a person's surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// Place on the unshaped base mesh, in its units. Regions are told by it, so that they lie on
    /// the same part of every body.
    pub(crate) base: Vec3,
    /// Place on the shaped body in metres.
    pub(crate) body: Vec3,
    /// Where the vertex is, in metres.
    pub(crate) at: Vec3,
    /// Unit normal of the body, and later of the surface.
    pub(crate) normal: Vec3,
    /// Linear colour that multiplies that of the material.
    pub(crate) color: Vec3,
    pub(crate) weights: Weights,
}

impl Vertex {
    /// Returns the vertex between two others; `t` is 0 at `a` and 1 at `b`.
    fn between(a: &Self, b: &Self, t: f32) -> Self {
        Self {
            base: a.base.lerp(b.base, t),
            body: a.body.lerp(b.body, t),
            at: a.at.lerp(b.at, t),
            normal: a.normal.lerp(b.normal, t).normalize_or(a.normal),
            color: a.color.lerp(b.color, t),
            weights: Weights::mix(&[(a.weights, 1.0 - t), (b.weights, t)]),
        }
    }
}

/// Triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Returns an index that fits 32 bits; surfaces are far smaller.
fn index(count: usize) -> u32 {
    populace_model::convert::u32_from(count)
}

impl Surface {
    pub(crate) fn corner(&self, corner: u32) -> &Vertex {
        &self.vertices[corner as usize]
    }

    /// Returns the part where a field is not negative, cut along the line where it is zero.
    pub(crate) fn kept(&self, field: impl Fn(&Vertex) -> f32) -> Self {
        self.split(field).0
    }

    /// Returns the part where a field is not negative, and the other one. Both have the same
    /// vertices along the line where the field is zero.
    pub(crate) fn split(&self, field: impl Fn(&Vertex) -> f32) -> (Self, Self) {
        let values: Vec<f32> = self.vertices.iter().map(field).collect();
        let part = |wanted: bool| {
            let (part, new) = (Self::default(), HashMap::new());
            let mut cut = Cut { from: self, values: &values, wanted, part, new };
            self.triangles.iter().for_each(|triangle| cut.triangle(*triangle));
            cut.part
        };
        (part(true), part(false))
    }

    /// Returns the triangles that meet a condition on their corners.
    pub(crate) fn chosen(&self, keep: impl Fn([&Vertex; 3]) -> bool) -> Self {
        let mut chosen = self.clone();
        chosen.triangles.retain(|t| keep(t.map(|corner| self.corner(corner))));
        chosen.compact()
    }

    /// Removes vertices that no triangle uses.
    fn compact(self) -> Self {
        let mut new = HashMap::new();
        let mut part = Self::default();
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| {
                *new.entry(corner).or_insert_with(|| {
                    part.vertices.push(*self.corner(corner));
                    index(part.vertices.len() - 1)
                })
            });
            part.triangles.push(corners);
        }
        part
    }

    /// Adds another surface.
    pub(crate) fn add(&mut self, other: &Self) {
        let first = index(self.vertices.len());
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|corner| corner + first)));
    }

    /// Returns the surface with each triangle split into four.
    pub(crate) fn subdivided(&self) -> Self {
        let mut fine = Self { vertices: self.vertices.clone(), triangles: Vec::new() };
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let middle = Vertex::between(self.corner(a), self.corner(b), 0.5);
                    fine.vertices.push(middle);
                    index(fine.vertices.len() - 1)
                })
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        fine
    }

    /// Sets the vertices' normals to the mean of those of their triangles by area.
    pub(crate) fn set_normals(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| self.corner(corner).at);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|corner| sums[*corner as usize] += normal);
        }
        for (vertex, sum) in self.vertices.iter_mut().zip(sums) {
            vertex.normal = sum.normalize_or(vertex.normal);
        }
    }

    /// The neighbours of each vertex: all of them, or along the border only for border vertices.
    fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut around = vec![Vec::new(); self.vertices.len()];
        let border = self.border();
        let mut on_border = vec![false; self.vertices.len()];
        for [a, b] in &border {
            around[*a as usize].push(*b);
            around[*b as usize].push(*a);
            on_border[*a as usize] = true;
            on_border[*b as usize] = true;
        }
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if !on_border[from as usize] && !around[from as usize].contains(&to) {
                    around[from as usize].push(to);
                }
                if !on_border[to as usize] && !around[to as usize].contains(&from) {
                    around[to as usize].push(from);
                }
            }
        }
        around
    }

    /// Moves vertices towards the mean of their neighbours. `part` says how far, from 0 to 1.
    pub(crate) fn smooth(&mut self, rounds: usize, part: impl Fn(&Vertex) -> f32) {
        let around = self.neighbours();
        for _ in 0..rounds {
            let before: Vec<Vec3> = self.vertices.iter().map(|v| v.at).collect();
            for (vertex, near) in self.vertices.iter_mut().zip(&around) {
                let mean: Vec3 = near.iter().map(|n| before[*n as usize]).sum();
                let count = near.len().max(1) as f32;
                let share = if near.is_empty() { 0.0 } else { part(vertex) };
                vertex.at = vertex.at.lerp(mean / count, share);
            }
        }
    }

    /// Smooths the weights of some vertices over their neighbours.
    pub(crate) fn smooth_weights(&mut self, rounds: usize, chosen: impl Fn(&Vertex) -> bool) {
        let around = self.neighbours();
        for _ in 0..rounds {
            let before: Vec<Weights> = self.vertices.iter().map(|v| v.weights).collect();
            let all = self.vertices.iter_mut().zip(&around);
            for (vertex, near) in all.filter(|(vertex, _)| chosen(vertex)) {
                let each = 0.6 / near.len().max(1) as f32;
                let mut all = vec![(vertex.weights, 0.4)];
                all.extend(near.iter().map(|n| (before[*n as usize], each)));
                vertex.weights = Weights::mix(&all);
            }
        }
    }

    /// The directed edges that only one triangle has, in order.
    pub(crate) fn border(&self) -> Vec<[u32; 2]> {
        let mut uses: BTreeMap<(u32, u32), (u32, [u32; 2])> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                uses.entry((from.min(to), from.max(to))).or_insert((0, [from, to])).0 += 1;
            }
        }
        uses.into_values().filter(|(count, _)| *count == 1).map(|(_, edge)| edge).collect()
    }

    /// Adds a band from the border to where `end` puts its vertices, so that an edge has depth.
    pub(crate) fn close_border(&mut self, end: impl Fn(&Vertex) -> Vec3) {
        let mut inner: HashMap<u32, [u32; 2]> = HashMap::new();
        for edge in self.border() {
            // The band has vertices of its own on both sides: the edge is sharp.
            let [[a, a_end], [b, b_end]] = edge.map(|corner| {
                *inner.entry(corner).or_insert_with(|| {
                    let vertex = *self.corner(corner);
                    let at = end(&vertex);
                    self.vertices.extend([vertex, Vertex { at, ..vertex }]);
                    [index(self.vertices.len() - 2), index(self.vertices.len() - 1)]
                })
            });
            self.triangles.extend([[b, a, a_end], [b, a_end, b_end]]);
        }
    }

    /// Multiplies the colours of the vertices by a function of them.
    pub(crate) fn tint(&mut self, color: impl Fn(&Vertex) -> Vec3) {
        for vertex in &mut self.vertices {
            vertex.color *= color(vertex);
        }
    }
}

/// The part of a surface that is being cut.
struct Cut<'a> {
    from: &'a Surface,
    values: &'a [f32],
    /// True for the part where values are not negative.
    wanted: bool,
    part: Surface,
    /// New vertices by the one or two old ones that they lie at.
    new: HashMap<(u32, u32), u32>,
}

impl Cut<'_> {
    fn value(&self, corner: u32) -> f32 {
        self.values[corner as usize]
    }

    fn is_inside(&self, corner: u32) -> bool {
        (self.value(corner) >= 0.0) == self.wanted
    }

    fn vertex(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (a.min(b), a.max(b));
        if let Some(&known) = self.new.get(&(a, b)) {
            return known;
        }
        let (from, to) = (self.from.corner(a), self.from.corner(b));
        let vertex = if a == b {
            *from
        } else {
            let (low, high) = (self.value(a), self.value(b));
            Vertex::between(from, to, (low / (low - high)).clamp(0.02, 0.98))
        };
        self.part.vertices.push(vertex);
        let new = index(self.part.vertices.len() - 1);
        self.new.insert((a, b), new);
        new
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        let mut polygon: Vec<u32> = Vec::with_capacity(4);
        for at in 0..3 {
            let (from, to) = (corners[at], corners[(at + 1) % 3]);
            let inside = self.is_inside(from);
            if inside {
                polygon.push(self.vertex(from, from));
            }
            if inside != self.is_inside(to) {
                polygon.push(self.vertex(from, to));
            }
        }
        for at in 2..polygon.len() {
            self.part.triangles.push([polygon[0], polygon[at - 1], polygon[at]]);
        }
    }
}

/// A grid of rows of points. Rows are closed rings if `ring` is true.
pub(crate) fn grid(rows: &[Vec<Vertex>], ring: bool) -> Surface {
    let mut surface = Surface::default();
    let width = rows.first().map_or(0, Vec::len);
    for row in rows {
        surface.vertices.extend_from_slice(row);
    }
    let across = if ring { width } else { width.saturating_sub(1) };
    for row in 1..rows.len() {
        for column in 0..across {
            let next = (column + 1) % width.max(1);
            let at = |row: usize, column: usize| index(row * width + column);
            let [a, b] = [at(row - 1, column), at(row - 1, next)];
            let [c, d] = [at(row, column), at(row, next)];
            surface.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    surface
}

/// Returns a colour from sRGB values of 0 to 255.
pub(crate) fn srgb(color: [u8; 3]) -> Vec3 {
    Vec3::from(color.map(|c| {
        let c = f32::from(c) / 255.0;
        if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    }))
}

/// Returns a colour as a material stores it.
pub(crate) fn rgba(color: Vec3) -> [f32; 4] {
    Vec4::from((color, 1.0)).to_array()
}

/// Rises smoothly from 0 at `low` to 1 at `high`.
pub(crate) fn smoothstep(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
