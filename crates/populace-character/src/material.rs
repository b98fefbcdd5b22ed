//! Materials and their textures.

/// Treatment of texture coordinates outside 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeats the texture.
    #[default]
    Repeat,
    /// Repeats the texture, mirroring every second copy.
    MirroredRepeat,
    /// Uses the colour of the edge.
    ClampToEdge,
}

/// Interpolation between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// Interpolates linearly.
    #[default]
    Linear,
    /// Uses the nearest texel.
    Nearest,
}

/// An image and its sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Index into [`crate::CharacterSource::images`].
    pub image: usize,
    /// Wrapping along u.
    pub wrap_u: Wrap,
    /// Wrapping along v.
    pub wrap_v: Wrap,
    /// Interpolation between texels.
    pub filter: TextureFilter,
}

/// Meaning of the base colour's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Fragments with an alpha below the cutoff are discarded.
    Mask {
        /// Cutoff from 0 to 1.
        cutoff: f32,
    },
    /// Alpha is coverage.
    Blend,
}

/// A material: metallic and rough as in glTF 2.0, section 3.9. All textures have the texture
/// coordinates of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The material's name; may be empty.
    pub name: String,
    /// Linear RGBA that multiplies the texture.
    pub base_color: [f32; 4],
    /// Base colour texture, sRGB.
    pub base_color_texture: Option<Texture>,
    /// From 0 for plastic, cloth and skin to 1 for metal; multiplies the texture.
    pub metallic: f32,
    /// From 0 for a mirror to 1 for chalk; multiplies the texture.
    pub roughness: f32,
    /// Texture whose green is roughness and whose blue is metallic, both linear.
    pub metallic_roughness_texture: Option<Texture>,
    /// Texture of normals in tangent space, linear: red along u, green against v, blue outwards.
    pub normal_texture: Option<Texture>,
    /// Factor of the normals' red and green.
    pub normal_scale: f32,
    /// Texture whose red is the fraction of the sky's light that arrives, linear.
    pub occlusion_texture: Option<Texture>,
    /// From 0 to ignore the texture of occlusion to 1.
    pub occlusion_strength: f32,
    /// Linear colour of the light that the surface emits; multiplies the texture.
    pub emissive: [f32; 3],
    /// Texture of emitted light, sRGB.
    pub emissive_texture: Option<Texture>,
    /// Meaning of alpha.
    pub alpha: AlphaMode,
    /// True if back faces are drawn.
    pub double_sided: bool,
}

impl Material {
    /// All textures of the material.
    pub fn textures(&self) -> impl Iterator<Item = Texture> {
        let all = [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.occlusion_texture,
            self.emissive_texture,
        ];
        all.into_iter().flatten()
    }

    /// Returns whether all numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let numbers = [self.metallic, self.roughness, self.normal_scale, self.occlusion_strength];
        numbers.iter().chain(&self.base_color).chain(&self.emissive).all(|n| n.is_finite())
    }
}

impl Default for Material {
    /// Returns white that is rough and no metal. A material of a glTF file is metal unless the file
    /// says otherwise.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.9,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
        }
    }
}
