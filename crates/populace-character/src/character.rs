//! Characters: a skeleton with its meshes, materials and clips.

use std::sync::Arc;

use glam::DAffine3;
use populace_clip::Clip;
use populace_model::{Affine, JointIndex, Skeleton, f64math};

use crate::mesh::{Mesh, rest_place};
use crate::options::{PartOption, find_options};
use crate::{Error, Image, Material};

/// A distinct pair of a joint and a bind matrix that vertices use. Two skins may bind one joint
/// differently, rigid parts use the identity, and joints without vertices have no entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaletteEntry {
    /// The joint that moves the vertices.
    pub joint: JointIndex,
    /// Transforms vertices from bind space to joint space (glTF: inverse bind matrix).
    pub joint_from_bind: Affine,
}

/// A drawable part: a primitive of a mesh, as used by one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Index in the file of the node that uses the mesh.
    pub node: usize,
    /// Name of that node, by which parts can be hidden.
    pub node_name: String,
    /// Index of the primitive within its mesh in the file.
    pub primitive: usize,
    /// Index into [`CharacterSource::materials`]; `None` for plain white.
    pub material: Option<usize>,
    /// The triangles.
    pub mesh: Mesh,
}

/// A skin as used by one mesh node of the file, for palettes in the file's own order.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinInstance {
    /// Index of the skin in the file.
    pub skin: usize,
    /// Index of the mesh node in the file.
    pub node: usize,
    /// The skin's joints in the file's order, each with its bind matrix.
    pub joints: Vec<PaletteEntry>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Minimum corner.
    pub low: [f32; 3],
    /// Maximum corner.
    pub high: [f32; 3],
}

impl Bounds {
    /// Returns the box around points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = [f32; 3]>) -> Option<Self> {
        points.into_iter().fold(None, |bounds, p| {
            let Self { mut low, mut high } = bounds.unwrap_or(Self { low: p, high: p });
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
            Some(Self { low, high })
        })
    }
}

/// The parts of a character, as found by an importer.
#[derive(Clone, Debug)]
pub struct CharacterSource {
    /// A name for display.
    pub name: String,
    /// The joint hierarchy.
    pub skeleton: Skeleton,
    /// Pairs of joint and bind matrix that vertices refer to.
    pub palette: Vec<PaletteEntry>,
    /// Drawable parts.
    pub parts: Vec<Part>,
    /// Materials of the parts.
    pub materials: Vec<Material>,
    /// Images used by textures.
    pub images: Vec<Image>,
    /// Skins, in the file's order.
    pub skins: Vec<SkinInstance>,
    /// Clips that came with the character; their own skeleton is this one.
    pub clips: Vec<Arc<Clip>>,
}

/// A coarser version of a character's meshes, for small pictures of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Distance in metres, at rest, by which its surface may be off that of the character. Smaller
    /// pieces of the character may be missing.
    pub error_m: f32,
    /// One mesh for each part, in the order of [`CharacterSource::parts`] and with the same palette
    /// and materials. Parts that are too small to be seen have no triangles.
    pub meshes: Vec<Mesh>,
    /// Number of joints that are evaluated: the first ones in level order. The others hang from
    /// them as at rest.
    pub joint_count: usize,
}

/// A checked character: every index is valid and every number is finite.
#[derive(Clone, Debug)]
pub struct Character {
    source: CharacterSource,
    levels: Vec<Level>,
    options: Vec<PartOption>,
    /// `model_from_bind` of each palette entry at rest.
    rest_binds: Vec<DAffine3>,
    rest_bounds: Option<Bounds>,
}

impl std::ops::Deref for Character {
    type Target = CharacterSource;

    fn deref(&self) -> &CharacterSource {
        &self.source
    }
}

impl Character {
    /// Checks the parts and computes the bounds at rest.
    ///
    /// # Errors
    ///
    /// [`Error::BadCharacter`] for the first invalid part: an index out of range, arrays of
    /// different lengths, a number that is not finite, an image whose size does not match its
    /// pixels.
    pub fn new(source: CharacterSource) -> Result<Self, Error> {
        let fail = |place: String, what: String| Err(Error::BadCharacter { place, what });
        let joint_count = source.skeleton.joint_count();
        for (index, entry) in source.palette.iter().enumerate() {
            if entry.joint.index() >= joint_count || !entry.joint_from_bind.is_finite() {
                let what = format!("needs a joint below {joint_count} and a finite bind matrix");
                return fail(format!("palette entry {index}"), what);
            }
        }
        for (index, image) in source.images.iter().enumerate() {
            let pixels = u64::from(image.width) * u64::from(image.height);
            if pixels == 0 || pixels.checked_mul(4) != Some(image.rgba.len() as u64) {
                let what = format!(
                    "has {} bytes for {} x {} pixels; each pixel needs 4 bytes",
                    image.rgba.len(),
                    image.width,
                    image.height
                );
                return fail(format!("image {index}"), what);
            }
        }
        for (index, material) in source.materials.iter().enumerate() {
            let place = || format!("material {index}");
            if material.textures().any(|t| t.image >= source.images.len()) {
                return fail(place(), "its texture refers to an image that does not exist".into());
            }
            if !material.is_finite() {
                return fail(place(), "it holds a value that is not a finite number".into());
            }
        }
        for part in &source.parts {
            if let Err(what) = check_part(part, &source) {
                return fail(place_of(part), what);
            }
        }
        let options = find_options(source.parts.iter().map(|part| part.node_name.as_str()));
        let rest_binds = rest_binds(&source);
        let mut character =
            Self { source, levels: Vec::new(), options, rest_binds, rest_bounds: None };
        let parts = 0..character.parts.len();
        character.rest_bounds = Bounds::around(parts.flat_map(|p| character.rest_positions(p)));
        Ok(character)
    }

    /// Sets the coarser levels of detail, finest first. They replace earlier ones.
    ///
    /// # Errors
    ///
    /// [`Error::BadCharacter`] if the levels' errors are not positive and increasing, for a joint
    /// count that is 0 or larger than that of the level before, or for a mesh that
    /// [`new`](Self::new) would refuse as a part.
    pub fn with_levels(mut self, levels: Vec<Level>) -> Result<Self, Error> {
        let (mut finer_m, mut finer_joints) = (0.0, self.skeleton.joint_count());
        for (index, level) in levels.iter().enumerate() {
            let fail = |place: String, what: String| {
                Err(Error::BadCharacter { place: format!("level {}{place}", index + 1), what })
            };
            if !(level.error_m > finer_m && level.error_m.is_finite()) {
                let error_m = level.error_m;
                return fail(
                    String::new(),
                    format!("has an error of {error_m} m; more than {finer_m} m is needed"),
                );
            }
            finer_m = level.error_m;
            let joint_count = level.joint_count;
            if !(1..=finer_joints).contains(&joint_count) {
                let what = format!("has {joint_count} joints; 1 to {finer_joints} are needed");
                return fail(String::new(), what);
            }
            finer_joints = joint_count;
            if level.meshes.len() != self.parts.len() {
                let what = format!("{} meshes for {} parts", level.meshes.len(), self.parts.len());
                return fail(String::new(), what);
            }
            for (part, mesh) in self.parts.iter().zip(&level.meshes) {
                if let Err(what) = check_mesh(mesh, self.palette.len()) {
                    return fail(format!(", {}", place_of(part)), what);
                }
            }
        }
        self.levels = levels;
        Ok(self)
    }

    /// The coarser levels of detail, finest first. Level 0, the character itself, is not among
    /// them.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The parts that members can show or not, by their number.
    #[must_use]
    pub fn options(&self) -> &[PartOption] {
        &self.options
    }

    /// Returns the number of the option that a part belongs to; `None` for a part that is always
    /// shown.
    #[must_use]
    pub fn option_of(&self, part: usize) -> Option<usize> {
        let of_node = PartOption::of_node(&self.parts.get(part)?.node_name)?;
        self.options.iter().position(|option| *option == of_node)
    }

    /// The box around all vertices at rest in model space; `None` without meshes.
    #[must_use]
    pub fn rest_bounds(&self) -> Option<Bounds> {
        self.rest_bounds
    }

    /// Height at rest in metres: that of the meshes, or that of the skeleton without meshes.
    #[must_use]
    pub fn height_m(&self) -> f32 {
        self.rest_bounds.map_or(self.skeleton.size_m(), |b| b.high[1] - b.low[1])
    }

    /// Size at rest in metres: the height, or the longest side of a thing that lies flat, whose
    /// height is less than a thousandth of it.
    #[must_use]
    pub fn size_m(&self) -> f32 {
        let height_m = self.height_m();
        let side = |b: Bounds| (b.high[0] - b.low[0]).max(b.high[2] - b.low[2]);
        let longest_m = self.rest_bounds.map_or(height_m, side);
        if height_m < FLAT * longest_m { longest_m } else { height_m }
    }

    /// `model_from_bind` of each palette entry at rest.
    #[must_use]
    pub fn rest_binds(&self) -> &[DAffine3] {
        &self.rest_binds
    }

    /// Returns the positions in model space of a part's vertices at rest, in metres. Empty if there
    /// is no such part.
    #[must_use]
    pub fn rest_positions(&self, part: usize) -> Vec<[f32; 3]> {
        let Some(Part { mesh, .. }) = self.parts.get(part) else { return Vec::new() };
        let binds = self.rest_binds();
        let place = |vertex| f64math::to_f32(rest_place(mesh, vertex, binds).to_array());
        (0..mesh.positions.len()).map(place).collect()
    }
}

/// Height of a thing that lies flat, at most, as a fraction of its longest side.
const FLAT: f32 = 0.001;

fn rest_binds(source: &CharacterSource) -> Vec<DAffine3> {
    let models = source.skeleton.rest_models();
    let bind =
        |e: &PaletteEntry| models[e.joint.index()] * f64math::affine_from(&e.joint_from_bind);
    source.palette.iter().map(bind).collect()
}

/// Names a part for error messages.
fn place_of(part: &Part) -> String {
    format!("node {} \"{}\", primitive {}", part.node, part.node_name, part.primitive)
}

/// Returns the distance in metres from each joint, in level order, to the farthest vertex that it
/// moves, at rest, times its share of the vertex. This is the input of [`Skeleton::with_reach`].
/// Indices out of range are ignored.
#[must_use]
pub fn vertex_reach_m(skeleton: &Skeleton, palette: &[PaletteEntry], parts: &[Part]) -> Vec<f32> {
    let models = skeleton.rest_models();
    let mut reach: Vec<f64> = vec![0.0; models.len()];
    for mesh in parts.iter().map(|p| &p.mesh) {
        let influences = mesh.positions.iter().enumerate().flat_map(|(vertex, position)| {
            mesh.influences.shares(vertex).map(|(entry, share)| (*position, entry, share))
        });
        for (position, entry, share) in influences.filter(|(.., share)| *share > 0.0) {
            let Some(entry) = palette.get(entry) else {
                continue;
            };
            let Some(model) = models.get(entry.joint.index()) else {
                continue;
            };
            let in_joint = f64math::affine_from(&entry.joint_from_bind)
                .transform_point3(f64math::vec3(position));
            let distance = model.transform_vector3(in_joint).length() * f64::from(share.min(1.0));
            reach[entry.joint.index()] = reach[entry.joint.index()].max(distance);
        }
    }
    reach.into_iter().map(|r| f64math::to_f32([r])[0]).collect()
}

fn check_part(part: &Part, source: &CharacterSource) -> Result<(), String> {
    check_mesh(&part.mesh, source.palette.len())?;
    if part.material.is_some_and(|m| m >= source.materials.len()) {
        return Err("it refers to a material that does not exist".into());
    }
    Ok(())
}

fn check_mesh(mesh: &Mesh, palette_count: usize) -> Result<(), String> {
    let Mesh { positions, normals, uvs, colors, influences, indices } = mesh;
    check_lengths(mesh)?;
    if indices.len() % 3 != 0 || indices.iter().any(|&i| i as usize >= positions.len()) {
        return Err(format!(
            "indices must be whole triangles of vertices below {}",
            positions.len()
        ));
    }
    if let Some(entry) = influences.entries.iter().find(|&&e| usize::from(e) >= palette_count) {
        return Err(format!("a vertex refers to palette entry {entry}; there are {palette_count}"));
    }
    let finite = positions
        .iter()
        .chain(normals)
        .flatten()
        .chain(uvs.iter().flatten())
        .chain(&influences.weights);
    if finite.chain(colors.iter().flatten()).any(|v| !v.is_finite()) {
        return Err("a vertex holds a value that is not a finite number".into());
    }
    Ok(())
}

fn check_lengths(mesh: &Mesh) -> Result<(), String> {
    let Mesh { positions, normals, uvs, colors, influences, .. } = mesh;
    let count = positions.len();
    let per_vertex = influences.per_vertex;
    if per_vertex != 4 && per_vertex != 8 {
        return Err(format!("{per_vertex} influences per vertex; 4 or 8 are supported"));
    }
    let lengths = [
        ("normals", normals.len(), count),
        ("texture coordinates", uvs.len(), if uvs.is_empty() { 0 } else { count }),
        ("colours", colors.len(), if colors.is_empty() { 0 } else { count }),
        ("influences", influences.entries.len(), count * per_vertex),
        ("weights", influences.weights.len(), count * per_vertex),
    ];
    match lengths.iter().find(|(_, has, wants)| has != wants) {
        Some((what, has, wants)) => {
            Err(format!("{has} {what} for {count} vertices; {wants} are needed"))
        }
        None => Ok(()),
    }
}
