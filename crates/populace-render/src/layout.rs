//! Structs shared by Rust and GLSL, each declared once.
//!
//! [`glsl_block!`] emits a `#[repr(C)]` [`bytemuck::Pod`] type and the GLSL text of a `std140`
//! uniform block. [`vertex_struct!`] emits such a type and the table of its vertex attributes, from
//! which [`glsl_inputs`] writes the `in` declarations of vertex shaders. Only types with the same
//! layout in both languages have a name here. Blocks have no three-component vector, because
//! `std140` aligns it to 16 bytes.

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

/// Two-component vertex attribute.
pub(crate) type Float2 = [f32; 2];
/// Three-component vertex attribute. Vertex attributes, unlike block fields, need no padding.
pub(crate) type Float3 = [f32; 3];
/// Four-component vertex attribute, aligned to 4 bytes.
pub(crate) type Vector4 = [f32; 4];
/// Four 16-bit indices as one vertex attribute.
pub(crate) type Index4 = [u16; 4];
/// Four bytes as one vertex attribute.
pub(crate) type Bytes4 = [u8; 4];
/// Two 32-bit numbers as one vertex attribute.
pub(crate) type Index32x2 = [u32; 2];
/// Four 32-bit numbers as one vertex attribute.
pub(crate) type Index32x4 = [u32; 4];

/// A uniform block, filled from Rust.
pub(crate) trait UniformBlock: bytemuck::Pod {
    /// Binding point, unique to the block.
    const BINDING: u32;
    /// Declaration of the block in GLSL.
    const GLSL: &'static str;
    /// Name and offset in bytes of each field.
    #[cfg(test)]
    const FIELDS: &'static [(&'static str, usize)];
}

/// Storage type of an attribute's components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    F32,
    U8,
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
    (
        $(#[$doc:meta])*
        $name:ident, binding $binding:literal {
            $( $(#[$fd:meta])* $field:ident : $ty:ident ),* $(,)?
        }
    ) => {
        $(#[$doc])*
        #[repr(C, align(16))]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name { $( $(#[$fd])* pub(crate) $field: $ty ),* }
        impl UniformBlock for $name {
            const BINDING: u32 = $binding;
            const GLSL: &'static str = concat!(
                "layout(std140, binding = ", stringify!($binding), ") uniform ",
                stringify!($name), " {\n",
                $( "    ", block_type!($ty), " ", stringify!($field), ";\n", )* "};\n");
            #[cfg(test)]
            const FIELDS: &'static [(&'static str, usize)] =
                &[$( (stringify!($field), std::mem::offset_of!($name, $field)) ),*];
        }
    };
}

macro_rules! attribute_type {
    (f32) => {
        ("float", Component::F32, 1)
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
    (Bytes4) => {
        ("uvec4", Component::U8, 4)
    };
    (Index32x2) => {
        ("uvec2", Component::U32, 2)
    };
    (Index32x4) => {
        ("uvec4", Component::U32, 4)
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
    /// Per-frame constants of all shaders. Colours are linear; unused w components are 0.
    Frame, binding 0 {
        clip_from_world: Mat4,
        /// xy: width and height of the picture in pixels. zw: the same relative to their sum.
        picture: Float4,
        /// Inverse of `clip_from_world`, used for view directions only.
        world_from_clip: Mat4,
        shadow_from_world: Mat4,
        /// xyz: camera position in world space, in metres. w: distance of the far plane in metres.
        eye: Float4,
        /// xyz: unit vector to the sun. w: size of a shadow texel in metres, 0 without shadows.
        to_sun: Float4,
        /// rgb: colour of the sun.
        sun_color: Float4,
        /// rgb: the sky's light on upright surfaces. w: fraction of contact shadows.
        ambient_base: Float4,
        /// rgb: factor of the height of the normal. w: fraction of reflections.
        ambient_slope: Float4,
        /// rgb: factor of the squared height of the normal.
        ambient_bow: Float4,
        /// rgb: factor of the component of the normal towards the sun. w: height of the floor in
        /// metres.
        ambient_glow: Float4,
        /// rgb: colour of the sky overhead.
        zenith_color: Float4,
        /// rgb: colour of the sky at the horizon, and of the haze. w: binary logarithm by which
        /// haze weakens contrasts, per metre.
        horizon_color: Float4,
        /// rgb: colour that the sky has more towards the sun. w: 1 if the sun is drawn, else 0.
        glow_color: Float4,
        /// Coefficients of the tone mapping curve.
        tone: Float4,
        /// rgb: colour of the paving. w: size in metres of a pixel at a depth of one metre, 0
        /// without ground.
        ground_color: Float4,
        /// rgb: colour of the lines on the paving. w: height of the ground in metres.
        line_color: Float4,
    }
}

glsl_block! {
    /// Material constants of one part.
    Surface, binding 1 {
        /// Fragments of masked parts with a lower alpha are discarded.
        alpha_cutoff: f32,
        normal_scale: f32,
        occlusion_strength: f32,
        unused: f32,
        /// rgb: colour of emitted light.
        emissive: Float4,
    }
}

vertex_struct! {
    /// A vertex in bind space, without its influences.
    Vertex {
        position: Float3,
        normal: Float3,
        uv: Float2,
        /// Linear rgb and alpha, white for meshes without vertex colours.
        color: Vector4,
        /// Number of the region; number of the option that hides the vertex plus 1, or 0; metallic
        /// and roughness in 1/255.
        marks: Bytes4,
    }
}

vertex_struct! {
    /// Four skinning influences: weights, and palette entries relative to the instance's first.
    Influences4 {
        weights0: Vector4,
        entries0: Index4,
    }
}

vertex_struct! {
    /// Eight skinning influences, as in [`Influences4`].
    Influences8 {
        weights0: Vector4,
        weights1: Vector4,
        entries0: Index4,
        entries1: Index4,
    }
}

vertex_struct! {
    /// A corner of a rectangle on the ground around the contact shadow of a capsule.
    Contact {
        /// xyz: first end of the capsule's axis in bind space. w: its radius there.
        from: Vector4,
        /// The other end.
        to: Vector4,
        /// Which end, and which side: -1 or 1.
        corner: Float2,
        /// Palette entry that moves it, relative to the instance's first, and three that are not
        /// used.
        entries0: Index4,
    }
}

vertex_struct! {
    /// A corner of a triangle of the user interface.
    Corner {
        /// Position in clip space.
        position: Float2,
        uv: Float2,
        /// sRGB with premultiplied alpha.
        color: Bytes4,
    }
}

vertex_struct! {
    /// Per-instance vertex attributes.
    InstanceData {
        /// First of the three rows of `world_from_model`.
        world_row0: Vector4,
        world_row1: Vector4,
        world_row2: Vector4,
        /// First half of a [`MemberLook`](populace_device::MemberLook): tints of regions 0 to 3.
        look0: Index32x4,
        /// Second half: tints of regions 4 to 6, and the hidden options.
        look1: Index32x4,
        /// First palette entry, relative to the bound page, and index in the caller's list.
        entry_and_number: Index32x2,
        /// Greatest distance in metres between the surface in the picture and the shadow caster.
        caster_apart_m: f32,
    }
}

impl InstanceData {
    /// Returns the index in the caller's list.
    pub(crate) fn number(&self) -> u32 {
        self.entry_and_number[1]
    }
}

/// Returns the `in` declarations of all attributes, at consecutive locations from 0.
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
    fn glsl_declarations_match_rust_structs() {
        assert_eq!(
            Surface::GLSL,
            "layout(std140, binding = 1) uniform Surface {\n    float alpha_cutoff;\n    float \
             normal_scale;\n    float occlusion_strength;\n    float unused;\n    vec4 \
             emissive;\n};\n"
        );
        assert_eq!(
            glsl_inputs(&[Vertex::ATTRIBUTES, InstanceData::ATTRIBUTES]).lines().last().unwrap(),
            "layout(location = 11) in float caster_apart_m;"
        );
    }

    #[test]
    fn attributes_cover_their_whole_struct() {
        let end = |a: &Attribute| {
            let width = match a.component {
                Component::U8 => 1,
                Component::U16 => 2,
                Component::F32 | Component::U32 => 4,
            };
            a.offset_bytes + width * usize::from(a.component_count)
        };
        assert_eq!(Vertex::ATTRIBUTES.last().map(end), Some(size_of::<Vertex>()));
        assert_eq!(Influences8::ATTRIBUTES.last().map(end), Some(size_of::<Influences8>()));
        assert_eq!(InstanceData::ATTRIBUTES.last().map(end), Some(size_of::<InstanceData>()));
    }
}
