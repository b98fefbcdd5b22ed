//! Materials: factors and textures (glTF 2.0, sections 3.8 and 3.9).

use populace_character::{AlphaMode, Image, Material, Texture, TextureFilter, Wrap};

use crate::budget::Budget;
use crate::data::Data;
use crate::extensions::SPECULAR_GLOSSINESS;
use crate::folder::Folder;
use crate::images::ImageStore;
use crate::json::{Cursor, to_f32};
use crate::log::{Checked, Log};

/// A transform of texture coordinates (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UvTransform {
    offset: [f64; 2],
    /// Radians, counter-clockwise.
    rotation: f64,
    scale: [f64; 2],
}

impl UvTransform {
    const IDENTITY: Self = Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] };

    /// Applies scale, then rotation, then offset.
    pub(crate) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        let [u, v] = [f64::from(uv[0]) * self.scale[0], f64::from(uv[1]) * self.scale[1]];
        let (sin, cos) = self.rotation.sin_cos();
        [cos * u + sin * v + self.offset[0], cos * v - sin * u + self.offset[1]].map(to_f32)
    }
}

/// The use of a texture by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureUse {
    /// Index of the set of texture coordinates.
    pub(crate) set: usize,
    pub(crate) transform: Option<UvTransform>,
}

/// Materials, textures and images of a file.
pub(crate) struct Surfaces {
    pub(crate) materials: Vec<Material>,
    /// Texture use of each material.
    pub(crate) textures: Vec<Option<TextureUse>>,
    pub(crate) images: Vec<Image>,
}

/// Reads all materials and decodes their images. An image that is not available is noted and left
/// out, since the character can be animated without it.
pub(crate) fn read<'a>(
    root: &Cursor<'a>,
    data: &'a Data<'a>,
    log: &'a Log,
    budget: &'a Budget<'a>,
    folder: &'a Folder,
) -> Surfaces {
    let mut store = ImageStore::new(root, data, log, budget, folder);
    let sampler_count = root.objects("samplers").len();
    let samplers: Vec<_> = root.objects("samplers").iter().map(read_sampler).collect();
    let textures: Vec<_> = root
        .objects("textures")
        .iter()
        .map(|at| read_texture(at, store.count(), sampler_count, &samplers))
        .collect();
    let mut surfaces = Surfaces { materials: Vec::new(), textures: Vec::new(), images: Vec::new() };
    for at in root.objects("materials") {
        let (material, texture) = read_material(&at, &textures, &mut store).unwrap_or_default();
        surfaces.materials.push(material);
        surfaces.textures.push(texture);
    }
    surfaces.images = store.into_images();
    surfaces
}

type Sampler = (Wrap, Wrap, TextureFilter);

fn read_sampler(at: &Cursor) -> Sampler {
    let wrap = |key| match at.optional(key, Cursor::uint).ok().flatten() {
        None | Some(10497) => Wrap::Repeat,
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        Some(other) => {
            at.note(format!("has the unknown {key} {other}; the texture repeats"));
            Wrap::Repeat
        }
    };
    let filter = |key| at.optional(key, Cursor::uint).ok().flatten();
    // 9728, 9984 and 9986 are the filters that use the nearest texel. `magFilter` has precedence.
    let nearest = match filter("magFilter") {
        Some(filter) => filter == 9728,
        None => matches!(filter("minFilter"), Some(9728 | 9984 | 9986)),
    };
    let filter = if nearest { TextureFilter::Nearest } else { TextureFilter::Linear };
    (wrap("wrapS"), wrap("wrapT"), filter)
}

/// Reads a texture with the index of its encoded image. Returns `None` if it has no supported
/// image.
fn read_texture(
    at: &Cursor,
    image_count: usize,
    sampler_count: usize,
    samplers: &[Sampler],
) -> Checked<Option<Texture>> {
    let image = |i: &Cursor| i.index(image_count, "image");
    let webp = at.extension("EXT_texture_webp").map_or(Ok(None), |e| e.optional("source", image));
    let source = at.optional("source", image);
    let sampler = at.optional("sampler", |s| s.index(sampler_count, "sampler"))?;
    let (wrap_u, wrap_v, filter) = sampler.map_or_else(Default::default, |s| samplers[s]);
    let image = webp?.or(source?);
    if image.is_none() {
        at.note("has no image of a supported format");
    }
    Ok(image.map(|image| Texture { image, wrap_u, wrap_v, filter }))
}

type Textures = [Checked<Option<Texture>>];

fn read_material(
    at: &Cursor,
    textures: &Textures,
    store: &mut ImageStore,
) -> Checked<(Material, Option<TextureUse>)> {
    // Materials of files are metal and rough unless they say otherwise (section 5.22).
    let mut material =
        Material { name: at.name(), metallic: 1.0, roughness: 1.0, ..Material::default() };
    material.double_sided = at.optional("doubleSided", Cursor::flag)?.unwrap_or(false);
    material.alpha = read_alpha(at)?;
    let mut maps = Maps { textures, store, used: None };
    if let Some(metallic) = at.get("pbrMetallicRoughness") {
        metallic.object()?;
        material.base_color = factors(&metallic, "baseColorFactor")?.unwrap_or([1.0; 4]);
        material.metallic = factor(&metallic, "metallicFactor", 1.0)?;
        material.roughness = factor(&metallic, "roughnessFactor", 1.0)?;
        material.base_color_texture = maps.read(metallic.get("baseColorTexture"))?;
        let texture = metallic.get("metallicRoughnessTexture");
        let is_named = texture.is_some();
        material.metallic_roughness_texture = maps.read(texture)?;
        // Without the texture that it multiplies, the usual factor of 1 would make all of it metal.
        if is_named && material.metallic_roughness_texture.is_none() {
            material.metallic = 0.0;
        }
    } else if let Some(glossy) = at.extension(SPECULAR_GLOSSINESS) {
        read_glossy(at, &glossy, &mut material, &mut maps)?;
    }
    let normal = at.get("normalTexture");
    if let Some(info) = &normal {
        material.normal_scale = to_f32(info.optional("scale", Cursor::number)?.unwrap_or(1.0));
    }
    material.normal_texture = maps.read(normal)?;
    let occlusion = at.get("occlusionTexture");
    if let Some(info) = &occlusion {
        material.occlusion_strength = factor(info, "strength", 1.0)?;
    }
    material.occlusion_texture = maps.read(occlusion)?;
    let strength = at.extension("KHR_materials_emissive_strength");
    let strength = strength.map_or(Ok(None), |e| e.optional("emissiveStrength", Cursor::number))?;
    let strength = to_f32(strength.unwrap_or(1.0).max(0.0));
    let emissive = factors(at, "emissiveFactor")?.unwrap_or([0.0; 3]);
    let texture = at.get("emissiveTexture");
    let is_named = texture.is_some();
    material.emissive_texture = maps.read(texture)?;
    // Without the texture that it multiplies, the factor would make the whole surface glow.
    let is_dark = is_named && material.emissive_texture.is_none();
    material.emissive = if is_dark { [0.0; 3] } else { emissive.map(|channel| channel * strength) };
    Ok((material, maps.used))
}

/// Reads a material of the older kind, with diffuse and specular colours
/// (KHR_materials_pbrSpecularGlossiness), as one that is no metal.
fn read_glossy(at: &Cursor, glossy: &Cursor, to: &mut Material, maps: &mut Maps) -> Checked<()> {
    glossy.object()?;
    to.base_color = factors(glossy, "diffuseFactor")?.unwrap_or([1.0; 4]);
    to.metallic = 0.0;
    to.roughness = 1.0 - factor(glossy, "glossinessFactor", 1.0)?;
    to.base_color_texture = maps.read(glossy.get("diffuseTexture"))?;
    let lost = ["specularFactor", "specularGlossinessTexture"];
    if lost.iter().any(|key| glossy.get(key).is_some()) {
        at.note(
            "has specular colours, of which only the glossiness factor is read; its surface is no \
             metal",
        );
    }
    Ok(())
}

/// Reads linear factors from 0 to 1. Others are clamped.
fn factors<const N: usize>(at: &Cursor, key: &str) -> Checked<Option<[f32; N]>> {
    let Some(factors) = at.optional(key, Cursor::numbers::<N>)? else { return Ok(None) };
    if factors.iter().any(|v| !(0.0..=1.0).contains(v)) {
        at.note(format!("has a value of {key} outside 0 to 1; it is clamped"));
    }
    Ok(Some(factors.map(|v| to_f32(v.clamp(0.0, 1.0)))))
}

/// Reads a factor from 0 to 1. Others are clamped.
fn factor(at: &Cursor, key: &str, default: f64) -> Checked<f32> {
    let factor = at.optional(key, Cursor::number)?.unwrap_or(default);
    if !(0.0..=1.0).contains(&factor) {
        at.note(format!("has a value of {key} outside 0 to 1; it is clamped"));
    }
    Ok(to_f32(factor.clamp(0.0, 1.0)))
}

/// The textures of one material. The first that is read sets the texture coordinates of all.
struct Maps<'a, 'b> {
    textures: &'a Textures,
    store: &'a mut ImageStore<'b>,
    used: Option<TextureUse>,
}

impl Maps<'_, '_> {
    /// Reads a texture. One that is not available, or that needs other texture coordinates than the
    /// first, is noted and left out.
    fn read(&mut self, info: Option<Cursor>) -> Checked<Option<Texture>> {
        let Some(info) = info else { return Ok(None) };
        let index = info.require("index").and_then(|i| i.index(self.textures.len(), "texture"));
        let usage = read_use(&info);
        let (index, usage) = (index?, usage?);
        let Some(texture) = self.textures[index]? else { return Ok(None) };
        if self.used.is_some_and(|used| used != usage) {
            info.note(
                "has other texture coordinates than the material's first texture; it is left out",
            );
            return Ok(None);
        }
        let image = self.store.decoded(texture.image)?;
        self.used = self.used.or(image.map(|_| usage));
        Ok(image.map(|image| Texture { image, ..texture }))
    }
}

fn read_alpha(at: &Cursor) -> Checked<AlphaMode> {
    let cutoff = at.optional("alphaCutoff", Cursor::number)?.unwrap_or(0.5);
    match at.optional("alphaMode", Cursor::text)? {
        None | Some("OPAQUE") => Ok(AlphaMode::Opaque),
        Some("MASK") => Ok(AlphaMode::Mask { cutoff: to_f32(cutoff) }),
        Some("BLEND") => Ok(AlphaMode::Blend),
        Some(other) => {
            at.note(format!("has the unknown alphaMode \"{other}\"; it is treated as opaque"));
            Ok(AlphaMode::Opaque)
        }
    }
}

fn read_use(info: &Cursor) -> Checked<TextureUse> {
    let set = info.optional("texCoord", Cursor::uint)?.unwrap_or(0);
    let Some(at) = info.extension("KHR_texture_transform") else {
        return Ok(TextureUse { set, transform: None });
    };
    at.object()?;
    let unchanged = UvTransform::IDENTITY;
    let transform = UvTransform {
        offset: at.optional("offset", Cursor::numbers)?.unwrap_or(unchanged.offset),
        rotation: at.optional("rotation", Cursor::number)?.unwrap_or(unchanged.rotation),
        scale: at.optional("scale", Cursor::numbers)?.unwrap_or(unchanged.scale),
    };
    let set = at.optional("texCoord", Cursor::uint)?.unwrap_or(set);
    Ok(TextureUse { set, transform: Some(transform).filter(|t| *t != UvTransform::IDENTITY) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_transform_scales_then_rotates_then_offsets() {
        let transform = UvTransform {
            offset: [0.5, 0.25],
            rotation: std::f64::consts::FRAC_PI_2,
            scale: [2.0, 4.0],
        };
        // The extension's matrix for a rotation by 90 degrees maps (u, v) to (v, -u).
        let [u, v] = transform.apply([0.25, 0.5]);
        assert!((u - 2.5).abs() < 1e-6 && (v + 0.25).abs() < 1e-6, "{u} {v}");
    }
}
