//! Conversion of mesh primitives to parts.

use populace_character::{Mesh, PaletteEntry, Part};
use populace_model::JointIndex;

use crate::data::Data;
use crate::extensions::Extensions;
use crate::geometry;
use crate::influences::{self, Palette, Sets};
use crate::log::{Checked, Log, Reported};
use crate::materials::{TextureUse, UvTransform};
use crate::primitive::{Primitive, Topology, check_attribute};

/// The joints that move the vertices of a part.
#[derive(Clone, Copy)]
pub(crate) enum Mover<'a> {
    /// One joint.
    Rigid { joint: JointIndex },
    /// The joints of a skin, in its order.
    Skin(&'a [PaletteEntry]),
}

/// The node and primitive that a part comes from.
pub(crate) struct PartSource {
    pub(crate) node: usize,
    pub(crate) node_name: String,
    pub(crate) primitive: usize,
}

/// Builds parts; holds the inputs that all parts share.
pub(crate) struct PartBuilder<'a> {
    pub(crate) data: &'a Data<'a>,
    pub(crate) log: &'a Log,
    pub(crate) extensions: Extensions,
    /// Texture use of each material.
    pub(crate) textures: &'a [Option<TextureUse>],
}

impl PartBuilder<'_> {
    /// Builds a part. Also returns the number of vertices that the file has, which may be followed
    /// by copies. Returns `None` if the primitive has no triangles.
    pub(crate) fn part(
        &self,
        source: PartSource,
        primitive: &Primitive,
        mover: Mover,
        palette: &mut Palette,
    ) -> Checked<Option<(Part, usize)>> {
        let Some((topology, positions)) = self.triangles(primitive) else {
            return Ok(None);
        };
        let formats = crate::primitive::formats("POSITION", self.extensions);
        let accessor = self.data.accessor_with_format(positions, "POSITION", &formats)?;
        if accessor.count == 0 {
            return Err(
                self.problem(primitive, "has no vertices; POSITION must not be empty".into())
            );
        }
        if !accessor.has_bounds {
            let what =
                "has no min and max, which glTF requires of POSITION; they are not used here";
            self.log.note(&accessor.place, what);
        }
        let count = accessor.count;
        // All attributes are read before the first `?`, so that all problems are reported.
        let indices = self.indices(primitive, topology, count);
        let normals = self.attribute::<3>(primitive, "NORMAL", count);
        let uvs = self.uvs(primitive, count);
        let colors = self.colors(primitive, count);
        let influences = self.influences(primitive, count, mover, palette);
        let positions = self.data.vectors::<3>(positions);
        let mut mesh = Mesh {
            positions: positions?,
            normals: Vec::new(),
            uvs: uvs?,
            colors: colors?,
            influences: influences?,
            indices: indices?,
        };
        match normals? {
            Some(normals) => {
                mesh.normals = normals;
                geometry::normalize(&mut mesh.normals);
            }
            None => self.add_flat_normals(primitive, &mut mesh)?,
        }
        let PartSource { node, node_name, primitive: index } = source;
        let part = Part { node, node_name, primitive: index, material: primitive.material, mesh };
        Ok(Some((part, count)))
    }

    /// Returns the topology and the accessor of positions. Returns `None` and adds a note if the
    /// primitive has no triangles.
    fn triangles(&self, primitive: &Primitive) -> Option<(Topology, usize)> {
        let found = (primitive.topology, primitive.attribute("POSITION"));
        match found {
            (Some(topology), Some(positions)) => return Some((topology, positions)),
            (None, _) => {
                self.log.note(&primitive.place, "consists of points or lines and is ignored")
            }
            (_, None) => self.log.note(&primitive.place, "has no POSITION and is ignored"),
        }
        None
    }

    fn problem(&self, primitive: &Primitive, what: String) -> Reported {
        self.log.problem(&primitive.place, what)
    }

    fn indices(
        &self,
        primitive: &Primitive,
        topology: Topology,
        count: usize,
    ) -> Checked<Vec<u32>> {
        use crate::accessor::{Component, Shape};
        use crate::data::Format;
        let Some(index) = primitive.indices else {
            let all = u32::try_from(count).map_err(|_| {
                self.problem(primitive, "has more vertices than 32-bit indices can address".into())
            })?;
            self.data.budget.charge(&primitive.place, count.saturating_mul(12))?;
            return Ok(geometry::triangulate((0..all).collect(), topology));
        };
        let components = [Component::U8, Component::U16, Component::U32];
        let formats = components.map(|c| Format::plain(Shape::SCALAR, c));
        let accessor = self.data.accessor_with_format(index, "indices", &formats)?;
        if self.data.has_stride(accessor) {
            self.log.note(
                &accessor.place,
                "is in a buffer view with a byteStride, which only vertex data may have; it is \
                 used anyway",
            );
        }
        let indices = self.data.uints(index)?;
        let wrong = indices.iter().filter(|i| **i as usize >= count).count();
        if wrong > 0 {
            let first = indices.iter().position(|i| *i as usize >= count).unwrap_or(0);
            return Err(self.log.problem(
                &accessor.place,
                format!(
                    "holds index {} in element {first}, but {} has only {count} vertices \
                     ({wrong} of {} indices are out of range)",
                    indices[first],
                    primitive.place,
                    indices.len()
                ),
            ));
        }
        let whole = match topology {
            Topology::Triangles => indices.len() % 3 == 0,
            Topology::Strip | Topology::Fan => indices.len() >= 3,
        };
        if !whole {
            self.log.note(
                &primitive.place,
                "has indices at the end that do not form a triangle; they are ignored",
            );
        }
        if topology != Topology::Triangles {
            self.data.budget.charge(&primitive.place, indices.len().saturating_mul(12))?;
        }
        Ok(geometry::triangulate(indices, topology))
    }

    /// Returns the accessor of an attribute after checking it, or `None` if the primitive lacks it.
    fn checked(&self, primitive: &Primitive, name: &str, count: usize) -> Checked<Option<usize>> {
        let problem = |what| self.problem(primitive, what);
        check_attribute(primitive, name, count, self.data, self.extensions, problem)
    }

    fn attribute<const N: usize>(
        &self,
        primitive: &Primitive,
        name: &str,
        count: usize,
    ) -> Checked<Option<Vec<[f32; N]>>> {
        let index = self.checked(primitive, name, count)?;
        index.map(|index| self.data.vectors::<N>(index)).transpose()
    }

    /// Returns the texture coordinates of the base colour after KHR_texture_transform.
    fn uvs(&self, primitive: &Primitive, count: usize) -> Checked<Vec<[f32; 2]>> {
        let texture = primitive.material.and_then(|m| self.textures.get(m)?.as_ref());
        let set = texture.map_or(0, |t| t.set);
        let name = format!("TEXCOORD_{set}");
        let uvs = self.attribute::<2>(primitive, &name, count)?;
        if uvs.is_none() && texture.is_some() {
            self.log.note(&primitive.place, format!("has no {name}, which its texture needs"));
        }
        let mut uvs = uvs.unwrap_or_default();
        if let Some(transform) = texture.and_then(|t| t.transform) {
            uvs.iter_mut().for_each(|uv| *uv = UvTransform::apply(&transform, *uv));
            if uvs.iter().flatten().any(|v| !v.is_finite()) {
                return Err(self.problem(
                    primitive,
                    "has texture coordinates that overflow after KHR_texture_transform".into(),
                ));
            }
        }
        Ok(uvs)
    }

    fn colors(&self, primitive: &Primitive, count: usize) -> Checked<Vec<[f32; 4]>> {
        let Some(index) = self.checked(primitive, "COLOR_0", count)? else {
            return Ok(Vec::new());
        };
        if self.data.accessor(index)?.shape.components() == 4 {
            return self.data.vectors::<4>(index);
        }
        let opaque = self.data.vectors::<3>(index)?;
        Ok(opaque.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    }

    fn influences(
        &self,
        primitive: &Primitive,
        count: usize,
        mover: Mover,
        palette: &mut Palette,
    ) -> Checked<populace_character::Influences> {
        let (place, log) = (&primitive.place, self.log);
        self.data.budget.charge(place, count.saturating_mul(24))?;
        match mover {
            Mover::Rigid { joint } => influences::rigid(joint, count, palette, place, log),
            Mover::Skin(skin) => {
                let sets = self.influence_sets(primitive, count)?;
                influences::skinned(&sets, skin, palette, place, log)
            }
        }
    }

    fn influence_sets(&self, primitive: &Primitive, count: usize) -> Checked<Sets> {
        let mut sets = Sets { joints: Vec::new(), weights: Vec::new() };
        for set in 0..2 {
            let names = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            let joints = self.checked(primitive, &names[0], count);
            let weights = self.checked(primitive, &names[1], count);
            match (joints?, weights?) {
                (Some(joints), Some(weights)) => {
                    sets.joints.push(self.data.uints(joints)?);
                    sets.weights.push(self.data.floats(weights)?);
                }
                (None, None) => {}
                _ => {
                    let what = format!("must have both {} and {}, or neither", names[0], names[1]);
                    return Err(self.problem(primitive, what));
                }
            }
        }
        if primitive.attribute("JOINTS_2").is_some() {
            self.log.note(
                &primitive.place,
                "has more than 8 influences per vertex; the first 8 are used",
            );
        }
        Ok(sets)
    }

    fn add_flat_normals(&self, primitive: &Primitive, mesh: &mut Mesh) -> Checked<()> {
        self.log.note(&primitive.place, "has no NORMAL; flat normals are computed");
        self.data.budget.charge(&primitive.place, mesh.indices.len().saturating_mul(64))?;
        let flat = geometry::flat_normals(&mesh.positions, &mut mesh.indices);
        mesh.normals = flat.normals;
        let width = mesh.influences.per_vertex;
        for copy in flat.copies.into_iter().map(|c| c as usize) {
            mesh.positions.push(mesh.positions[copy]);
            if !mesh.uvs.is_empty() {
                mesh.uvs.push(mesh.uvs[copy]);
            }
            if !mesh.colors.is_empty() {
                mesh.colors.push(mesh.colors[copy]);
            }
            mesh.influences.entries.extend_from_within(copy * width..(copy + 1) * width);
            mesh.influences.weights.extend_from_within(copy * width..(copy + 1) * width);
        }
        Ok(())
    }
}
