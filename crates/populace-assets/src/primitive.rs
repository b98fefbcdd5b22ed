//! Declarations of mesh primitives (glTF 2.0, section 3.7.2).

use crate::accessor::{Component, Shape};
use crate::data::{Data, Format};
use crate::extensions::Extensions;
use crate::json::Cursor;
use crate::log::Checked;

/// The way in which indices form triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topology {
    Triangles,
    Strip,
    Fan,
}

/// A primitive: accessors of its vertex attributes and indices, and its topology.
#[derive(Clone, Debug)]
pub(crate) struct Primitive {
    pub(crate) place: String,
    pub(crate) attributes: Vec<(String, usize)>,
    pub(crate) indices: Option<usize>,
    pub(crate) material: Option<usize>,
    /// `None` for points and lines.
    pub(crate) topology: Option<Topology>,
    pub(crate) has_morph_targets: bool,
}

impl Primitive {
    pub(crate) fn attribute(&self, name: &str) -> Option<usize> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, accessor)| *accessor)
    }

    /// Returns whether the vertices have joints and weights.
    pub(crate) fn is_skinned(&self) -> bool {
        self.attribute("JOINTS_0").is_some() && self.attribute("WEIGHTS_0").is_some()
    }
}

/// The primitives of a mesh.
pub(crate) type Mesh = Vec<Checked<Primitive>>;

pub(crate) fn read_meshes(
    root: &Cursor,
    accessor_count: usize,
    material_count: usize,
) -> Vec<Mesh> {
    let read = |at: &Cursor| {
        at.require("primitives").ok();
        let primitives = at.objects("primitives");
        primitives.iter().map(|p| read_primitive(p, accessor_count, material_count)).collect()
    };
    root.objects("meshes").iter().map(read).collect()
}

fn read_primitive(at: &Cursor, accessor_count: usize, material_count: usize) -> Checked<Primitive> {
    let accessor = |i: &Cursor| i.index(accessor_count, "accessor");
    let indices = at.optional("indices", accessor);
    let material = at.optional("material", |m| m.index(material_count, "material"));
    let topology = at.optional("mode", |mode| match mode.uint()? {
        0..=3 => Ok(None),
        4 => Ok(Some(Topology::Triangles)),
        5 => Ok(Some(Topology::Strip)),
        6 => Ok(Some(Topology::Fan)),
        other => Err(mode.problem(format!("is {other}; it must be from 0 to 6"))),
    });
    let attributes = at.require("attributes").and_then(|object| {
        object.object()?;
        let all: Vec<_> = object
            .keys()
            .filter_map(|name| Some((name.to_owned(), object.get(name)?)))
            .map(|(name, at)| Ok((name, accessor(&at)?)))
            .collect();
        all.into_iter().collect::<Checked<Vec<_>>>()
    });
    Ok(Primitive {
        place: at.place().to_owned(),
        attributes: attributes?,
        indices: indices?,
        material: material?,
        topology: topology?.unwrap_or(Some(Topology::Triangles)),
        has_morph_targets: at.get("targets").is_some(),
    })
}

const fn plain<const N: usize>(shape: Shape, components: [Component; N]) -> [Format; N] {
    let mut formats = [Format::plain(shape, Component::F32); N];
    let mut at = 0;
    while at < N {
        formats[at] = Format::plain(shape, components[at]);
        at += 1;
    }
    formats
}

const fn normalized<const N: usize>(shape: Shape, components: [Component; N]) -> [Format; N] {
    let mut formats = plain(shape, components);
    let mut at = 0;
    while at < N {
        formats[at] = Format::normalized(shape, components[at]);
        at += 1;
    }
    formats
}

/// Returns the allowed formats of a vertex attribute (glTF 2.0, section 3.7.2.1, and
/// KHR_mesh_quantization).
pub(crate) fn formats(attribute: &str, extensions: Extensions) -> Vec<Format> {
    use Component::{F32, I8, I16, U8, U16};
    let set = attribute.trim_end_matches(|c: char| c.is_ascii_digit());
    let (shape, own): (_, Vec<_>) = match set {
        "POSITION" => (Shape::VEC3, vec![]),
        "NORMAL" => (Shape::VEC3, vec![]),
        "TEXCOORD_" => (Shape::VEC2, normalized(Shape::VEC2, [U8, U16]).into()),
        "COLOR_" => {
            let colors = normalized(Shape::VEC3, [U8, U16])
                .into_iter()
                .chain(normalized(Shape::VEC4, [U8, U16]));
            (Shape::VEC4, colors.chain(plain(Shape::VEC3, [F32])).collect())
        }
        "WEIGHTS_" => (Shape::VEC4, normalized(Shape::VEC4, [U8, U16]).into()),
        // JOINTS_n
        _ => return plain(Shape::VEC4, [U8, U16]).into(),
    };
    let quantized: Vec<_> = match set {
        _ if !extensions.mesh_quantization => vec![],
        "POSITION" => {
            let all = [I8, U8, I16, U16];
            plain(shape, all).into_iter().chain(normalized(shape, all)).collect()
        }
        "NORMAL" => normalized(shape, [I8, I16]).into(),
        "TEXCOORD_" => plain(shape, [I8, U8, I16, U16])
            .into_iter()
            .chain(normalized(shape, [I8, I16]))
            .collect(),
        _ => vec![],
    };
    plain(shape, [F32]).into_iter().chain(own).chain(quantized).collect()
}

/// Checks format and length of an attribute; `count` is the number of vertices. Returns its
/// accessor, or `None` if the primitive lacks it.
pub(crate) fn check_attribute(
    primitive: &Primitive,
    name: &str,
    count: usize,
    data: &Data,
    extensions: Extensions,
    problem: impl Fn(String) -> crate::log::Reported,
) -> Checked<Option<usize>> {
    let Some(index) = primitive.attribute(name) else {
        return Ok(None);
    };
    let accessor = data.accessor_with_format(index, name, &formats(name, extensions))?;
    if accessor.count != count {
        return Err(problem(format!(
            "has {} elements of {name}, but {count} of POSITION; all attributes must have the same \
             number",
            accessor.count
        )));
    }
    Ok(Some(index))
}
