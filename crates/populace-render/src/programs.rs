//! Shader variants, assembled from their sources and compiled on first use.

use std::collections::HashMap;
use std::rc::Rc;

use crate::Error;
use crate::gl::{Gl, Program};
use crate::layout::{
    Contact, Corner, Frame, Influences4, Influences8, InstanceData, Surface, UniformBlock as _,
    Vertex, VertexStruct as _, glsl_inputs,
};
use crate::model::{Alpha, Maps};

/// A variant of the shaders that draw members into the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MemberKind {
    pub(crate) influences: u32,
    pub(crate) alpha: Alpha,
    pub(crate) textured: bool,
    /// Light is computed once per vertex, for triangles of a few pixels.
    pub(crate) vertex_lit: bool,
    /// Both sides are, since both can be seen.
    pub(crate) two_sided: bool,
    /// Members are drawn in part.
    pub(crate) faded: bool,
    /// Contact shadows lie on what is as high as the floor.
    pub(crate) contacts: bool,
    pub(crate) maps: Maps,
}

/// A shader variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kind {
    /// Members in the picture.
    Member(MemberKind),
    /// Members in the shadow map.
    Shadow { influences: u32, alpha: Alpha, textured: bool },
    /// Depth and number of members.
    Marks { influences: u32, alpha: Alpha, textured: bool, faded: bool },
    /// The ground plane.
    Ground { contacts: bool },
    /// Contact shadows of members, for the contact map.
    Contact,
    /// The background.
    Sky,
    /// Corners of the grid of samples, outside of the picture.
    Beyond,
    /// The members' samples, over ground and sky.
    Resolve,
    /// The user interface of a window.
    Interface,
}

impl Kind {
    /// Returns the textures beside the base colour that the shader of a member samples.
    pub(crate) fn maps(self) -> Maps {
        match self {
            Self::Member(kind) => kind.maps,
            _ => Maps::default(),
        }
    }
}

const VERSION: &str = "#version 430 core\n";
const SKIN: &str = include_str!("shaders/skin.glsl");
const LOOK: &str = include_str!("shaders/look.glsl");
const FADE: &str = include_str!("shaders/fade.glsl");
const GRID: &str = include_str!("shaders/grid.glsl");
const SUNK: &str = include_str!("shaders/sunk.glsl");
const LIGHT: &str = include_str!("shaders/light.glsl");
const SHADING: &str = include_str!("shaders/shading.glsl");

/// Returns the GLSL texts of the vertex and the fragment shader.
fn sources(kind: Kind) -> [String; 2] {
    match kind {
        Kind::Member(kind) => member_sources(kind),
        Kind::Shadow { influences, alpha, textured } => [
            skinned(influences, &[include_str!("shaders/shadow.vert")]),
            with_blocks(alpha, &[texture_define(textured), include_str!("shaders/shadow.frag")]),
        ],
        Kind::Marks { influences, alpha, textured, faded } => {
            let (texture, [define, faded]) = (texture_define(textured), faded_texts(faded));
            [
                skinned(influences, &[define, SUNK, include_str!("shaders/marks.vert")]),
                with_blocks(alpha, &[texture, define, faded, include_str!("shaders/marks.frag")]),
            ]
        }
        Kind::Ground { contacts } => [
            with_blocks(Alpha::Opaque, &[include_str!("shaders/ground.vert")]),
            with_blocks(
                Alpha::Opaque,
                &[contacts_define(contacts), LIGHT, include_str!("shaders/ground.frag")],
            ),
        ],
        Kind::Contact => [
            contact(&[include_str!("shaders/contact.vert")]),
            with_blocks(Alpha::Opaque, &[include_str!("shaders/contact.frag")]),
        ],
        Kind::Sky => [
            with_blocks(Alpha::Opaque, &[include_str!("shaders/sky.vert")]),
            with_blocks(Alpha::Opaque, &[LIGHT, include_str!("shaders/sky.frag")]),
        ],
        Kind::Beyond => [
            with_blocks(Alpha::Opaque, &[GRID, include_str!("shaders/beyond.vert")]),
            [VERSION, "void main() {}\n"].concat(),
        ],
        Kind::Resolve => [
            [VERSION, include_str!("shaders/resolve.vert")].concat(),
            with_blocks(Alpha::Opaque, &[GRID, include_str!("shaders/resolve.frag")]),
        ],
        Kind::Interface => {
            let inputs = glsl_inputs(&[Corner::ATTRIBUTES]);
            [
                [VERSION, &inputs, include_str!("shaders/interface.vert")].concat(),
                [VERSION, include_str!("shaders/interface.frag")].concat(),
            ]
        }
    }
}

fn member_sources(kind: MemberKind) -> [String; 2] {
    let MemberKind { influences, alpha, textured, vertex_lit, two_sided, faded, contacts, maps } =
        kind;
    let (light, shading) = match (vertex_lit, two_sided) {
        (false, _) => ("", SHADING),
        (true, false) => ("#define VERTEX_LIT\n", ""),
        (true, true) => ("#define VERTEX_LIT\n#define TWO_SIDED\n", ""),
    };
    let texture = texture_define(textured);
    let sampled = if textured || maps.is_sampled() { "#define SAMPLED\n" } else { "" };
    let [define, faded] = faded_texts(faded);
    let defines = [&maps.defines(), texture, sampled, light, define].concat();
    let member = include_str!("shaders/member.frag");
    [
        skinned(influences, &[&defines, LIGHT, SUNK, GRID, include_str!("shaders/member.vert")]),
        with_blocks(
            alpha,
            &[&defines, faded, GRID, contacts_define(contacts), LIGHT, shading, member],
        ),
    ]
}

/// Returns the text that reads contact shadows, if any.
fn contacts_define(contacts: bool) -> &'static str {
    if contacts { concat!("#define CONTACTS\n", include_str!("shaders/contact.glsl")) } else { "" }
}

/// Returns the define of members that fade, and the text of their fragment shaders.
fn faded_texts(faded: bool) -> [&'static str; 2] {
    if faded { ["#define FADED\n", include_str!("shaders/faded.glsl")] } else { ["", ""] }
}

fn texture_define(textured: bool) -> &'static str {
    if textured { "#define TEXTURED\n" } else { "" }
}

/// Returns the text of a vertex shader that skins by 1, 2, 4 or 8 influences, with its inputs and
/// uniform blocks.
fn skinned(influences: u32, bodies: &[&str]) -> String {
    let define = format!("#define INFLUENCES {influences}\n");
    let attributes =
        if influences == 8 { Influences8::ATTRIBUTES } else { Influences4::ATTRIBUTES };
    let inputs = glsl_inputs(&[Vertex::ATTRIBUTES, attributes, InstanceData::ATTRIBUTES]);
    [VERSION, &define, Frame::GLSL, Surface::GLSL, &inputs, SKIN, LOOK, FADE, &bodies.concat()]
        .concat()
}

/// Returns the text of a vertex shader of contact shadows, with its inputs and uniform blocks.
fn contact(bodies: &[&str]) -> String {
    let inputs = glsl_inputs(&[Contact::ATTRIBUTES, InstanceData::ATTRIBUTES]);
    let define = "#define INFLUENCES 1\n";
    [VERSION, define, Frame::GLSL, &inputs, SKIN, FADE, &bodies.concat()].concat()
}

/// Returns the text of a shader with the uniform blocks and the define of its alpha mode.
fn with_blocks(alpha: Alpha, bodies: &[&str]) -> String {
    let define = match alpha {
        Alpha::Opaque => "",
        Alpha::Masked => "#define MASKED\n",
        Alpha::Blended => "#define BLENDED\n",
    };
    [VERSION, define, Frame::GLSL, Surface::GLSL, &bodies.concat()].concat()
}

/// Cache of compiled programs.
pub(crate) struct Programs {
    gl: Rc<Gl>,
    compiled: HashMap<Kind, Program>,
}

impl Programs {
    pub(crate) fn new(gl: &Rc<Gl>) -> Self {
        Self { gl: Rc::clone(gl), compiled: HashMap::new() }
    }

    /// Returns the program of a variant, compiling it on first use.
    pub(crate) fn get(&mut self, kind: Kind) -> Result<&Program, Error> {
        use std::collections::hash_map::Entry;
        match self.compiled.entry(kind) {
            Entry::Occupied(entry) => Ok(entry.into_mut()),
            Entry::Vacant(entry) => {
                let [vertex, fragment] = sources(kind);
                let program = Program::new(&self.gl, &format!("{kind:?}"), &vertex, &fragment)?;
                Ok(entry.insert(program))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
    fn driver_block_layout_matches_rust_structs() {
        let gl = Gl::headless().unwrap();
        let mut programs = Programs::new(&gl);
        let (influences, alpha, maps) = (4, Alpha::Masked, Maps::default());
        let kind = Kind::Member(MemberKind {
            influences,
            alpha,
            textured: true,
            vertex_lit: false,
            two_sided: false,
            faded: false,
            contacts: false,
            maps,
        });
        let program = programs.get(kind).unwrap();
        for fields in [Frame::FIELDS, Surface::FIELDS] {
            let names: Vec<_> = fields.iter().map(|(name, _)| *name).collect();
            let offsets = program.field_offsets(&names);
            for ((name, rust), driver) in fields.iter().zip(offsets) {
                assert_eq!(driver, i32::try_from(*rust).unwrap(), "offset of {name}");
            }
        }
    }
}
