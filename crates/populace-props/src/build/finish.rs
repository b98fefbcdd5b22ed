//! Materials.

use populace_character::{AlphaMode, Material};
use populace_model::convert::single;

/// Returns the linear colour of an sRGB one, such as 0xFF8000.
pub(crate) fn linear(srgb: u32) -> [f64; 3] {
    let [_, r, g, b] = srgb.to_be_bytes();
    [r, g, b].map(|byte| {
        let v = f64::from(byte) / 255.0;
        if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    })
}

/// Returns a matt material of an sRGB colour.
pub(crate) fn matt(name: &str, srgb: u32) -> Material {
    rough(name, srgb, 0.9)
}

/// Returns a painted or polished material.
pub(crate) fn satin(name: &str, srgb: u32) -> Material {
    rough(name, srgb, 0.45)
}

fn rough(name: &str, srgb: u32, roughness: f32) -> Material {
    let [r, g, b] = linear(srgb).map(single);
    Material { name: name.into(), base_color: [r, g, b, 1.0], roughness, ..Material::default() }
}

/// Returns a metal.
pub(crate) fn metal(name: &str, srgb: u32, roughness: f32) -> Material {
    Material { metallic: 0.9, ..rough(name, srgb, roughness) }
}

/// Returns clear glass: what is behind it shows through.
pub(crate) fn glass(name: &str, srgb: u32, alpha: f32) -> Material {
    let mut material = rough(name, srgb, 0.15);
    material.base_color[3] = alpha;
    Material { alpha: AlphaMode::Blend, ..material }
}

/// Returns glass with a dark room behind it, which hides it.
pub(crate) fn pane(name: &str, srgb: u32) -> Material {
    rough(name, srgb, 0.15)
}

/// Returns a material that is blended by the alpha of its vertices.
pub(crate) fn alpha(name: &str, srgb: u32) -> Material {
    Material { alpha: AlphaMode::Blend, ..matt(name, srgb) }
}

/// Returns a material that shines. `strength` 1 adds as much light as a white wall in the sun.
pub(crate) fn glow(name: &str, srgb: u32, strength: f64) -> Material {
    Material { emissive: linear(srgb).map(|c| single(c * strength)), ..satin(name, srgb) }
}
