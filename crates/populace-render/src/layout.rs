//! The structs that Rust and GLSL share, each declared once.
//!
//! [`glsl_block!`] emits a `#[repr(C)]` [`bytemuck::Pod`] type and the text of a `std140` uniform
//! block; [`vertex_struct!`] emits such a type and the table of its vertex attributes, from which
//! the `in` declarations of vertex shaders are written. Only types that both languages lay out
//! alike have a name here: there is no three-component vector for blocks, which takes 16 bytes
//! there.

use populace_device::layout::Float4;

/// A column-major 4x4 matrix in a uniform block.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Mat4(pub(crate) [Float4; 4]);

impl From<glam::Mat4> for Mat4 {
    fn from(m: glam::Mat4) -> Self {
        Self(m.to_cols_array_2d().map(Float4))
    }
}

/// Vertex attributes need no padding, so a three-component vector is fine there.
pub(crate) type Float2 = [f32; 2];
pub(crate) type Float3 = [f32; 3];
pub(crate) type Vector4 = [f32; 4];
/// Four 16-bit indices.
pub(crate) type Index4 = [u16; 4];

/// A uniform block that Rust fills.
pub(crate) trait UniformBlock: bytemuck::Pod {
    /// Which binding point it has; no other block has the same.
    const BINDING: u32;
    /// The declaration in GLSL.
    const GLSL: &'static str;
    /// Each field's name and offset in bytes.
    #[cfg(test)]
    const FIELDS: &'static [(&'static str, usize)];
}

/// How an attribute's components are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    F32,
    U16,
    U32,
}

/// One attribute of a vertex or an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Attribute {
    pub(crate) name: &'static str,
    pub(crate) glsl_type: &'static str,
    pub(crate) component: Component,
    pub(crate) component_count: u8,
    pub(crate) offset_bytes: usize,
}

/// A struct that a vertex shader reads, once per vertex or once per instance.
pub(crate) trait VertexStruct: bytemuck::Pod {
    const ATTRIBUTES: &'static [Attribute];
}

macro_rules! block_type {
    (f32) => {
        "float"
    };
    (u32) => {
        "uint"
    };
    (Float4) => {
        "vec4"
    };
    (Mat4) => {
        "mat4"
    };
}

macro_rules! glsl_block {
    ($(#[$doc:meta])* $name:ident, binding $binding:literal { $( $(#[$fd:meta])* $field:ident : $ty:ident ),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C, align(16))]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name { $( $(#[$fd])* pub(crate) $field: $ty ),* }
        impl UniformBlock for $name {
            const BINDING: u32 = $binding;
            const GLSL: &'static str = concat!(
                "layout(std140, binding = ", stringify!($binding), ") uniform ", stringify!($name), " {\n",
                $( "    ", block_type!($ty), " ", stringify!($field), ";\n", )* "};\n");
            #[cfg(test)]
            const FIELDS: &'static [(&'static str, usize)] =
                &[$( (stringify!($field), std::mem::offset_of!($name, $field)) ),*];
        }
    };
}

macro_rules! attribute_type {
    (u32) => {
        ("uint", Component::U32, 1)
    };
    (Float2) => {
        ("vec2", Component::F32, 2)
    };
    (Float3) => {
        ("vec3", Component::F32, 3)
    };
    (Vector4) => {
        ("vec4", Component::F32, 4)
    };
    (Index4) => {
        ("uvec4", Component::U16, 4)
    };
}

macro_rules! vertex_struct {
    ($(#[$doc:meta])* $name:ident { $( $(#[$fd:meta])* $field:ident : $ty:ident ),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name { $( $(#[$fd])* pub(crate) $field: $ty ),* }
        impl VertexStruct for $name {
            const ATTRIBUTES: &'static [Attribute] = &[$( {
                let (glsl_type, component, component_count) = attribute_type!($ty);
                Attribute {
                    name: stringify!($field), glsl_type, component, component_count,
                    offset_bytes: std::mem::offset_of!($name, $field),
                }
            } ),*];
        }
    };
}

glsl_block! {
    /// What is the same for everything drawn in a pass.
    Frame, binding 0 {
        clip_from_world: Mat4,
        /// To directions as seen from the eye; only its sight lines are used.
        world_from_clip: Mat4,
        shadow_from_world: Mat4,
        /// xyz in world space; w the far plane's distance.
        eye: Float4,
        /// xyz unit vector; w the world-space size of a shadow texel, 0 where there are no shadows.
        to_sun: Float4,
        /// rgb; w where tone mapping begins to bend, 1 for nowhere.
        sun_color: Float4,
        sky_light: Float4,
        ground_light: Float4,
        zenith_color: Float4,
        horizon_color: Float4,
        ground_color: Float4,
        line_color: Float4,
    }
}

glsl_block! {
    /// A part's surface.
    Surface, binding 1 {
        base_color: Float4,
        alpha_cutoff: f32,
        unused0: f32,
        unused1: f32,
        unused2: f32,
    }
}

vertex_struct! {
    /// A vertex as its mesh has it.
    Vertex {
        position: Float3,
        normal: Float3,
        uv: Float2,
        color: Vector4,
    }
}

vertex_struct! {
    /// Palette entries, relative to the instance's first, and weights.
    Influences4 {
        weights0: Vector4,
        entries0: Index4,
    }
}

vertex_struct! {
    /// The same, for meshes with up to eight influences.
    Influences8 {
        weights0: Vector4,
        weights1: Vector4,
        entries0: Index4,
        entries1: Index4,
    }
}

vertex_struct! {
    /// One drawn character.
    InstanceData {
        /// `world_from_model`, three rows.
        world_row0: Vector4,
        world_row1: Vector4,
        world_row2: Vector4,
        tint: Float3,
        /// Within the page that is bound.
        palette_first: u32,
    }
}

/// Writes the `in` declarations of the attributes of several structs, one location after the other.
pub(crate) fn glsl_inputs(structs: &[&[Attribute]]) -> String {
    let attributes = structs.iter().copied().flatten().enumerate();
    attributes
        .map(|(location, a)| {
            format!("layout(location = {location}) in {} {};\n", a.glsl_type, a.name)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glsl_text_declares_what_rust_declares() {
        assert_eq!(
            Surface::GLSL,
            "layout(std140, binding = 1) uniform Surface {\n    vec4 base_color;\n    float \
             alpha_cutoff;\n    float unused0;\n    float unused1;\n    float unused2;\n};\n"
        );
        assert_eq!(
            glsl_inputs(&[Vertex::ATTRIBUTES, InstanceData::ATTRIBUTES]).lines().last().unwrap(),
            "layout(location = 8) in uint palette_first;"
        );
    }

    #[test]
    fn attributes_cover_their_struct() {
        let end = |a: &Attribute| {
            let width = if a.component == Component::U16 { 2 } else { 4 };
            a.offset_bytes + width * usize::from(a.component_count)
        };
        assert_eq!(Vertex::ATTRIBUTES.last().map(end), Some(size_of::<Vertex>()));
        assert_eq!(Influences8::ATTRIBUTES.last().map(end), Some(size_of::<Influences8>()));
        assert_eq!(InstanceData::ATTRIBUTES.last().map(end), Some(size_of::<InstanceData>()));
    }
}
