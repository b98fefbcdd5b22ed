//! Materials: metal and roughness, and the maps of glTF.

use std::sync::Arc;

use populace_character::{Character, Image, Material, Texture, TextureFilter, Wrap};
use populace_model::Affine;
use populace_render::Ambient;

use crate::fixture::{part, plain, quad_mesh, source};
use crate::rig::{NOTHING, Rig, instance, srgb};

/// A texture of one texel.
const MAP: Option<Texture> = Some(Texture {
    image: 0,
    wrap_u: Wrap::Repeat,
    wrap_v: Wrap::Repeat,
    filter: TextureFilter::Linear,
});

/// Returns a square that faces +Z. Textures of its material have this texel.
fn quad(material: Material, texel: [u8; 3]) -> Arc<Character> {
    let mut pieces = source(vec![part("quad", 0, quad_mesh(0))], vec![material], 1);
    let [r, g, b] = texel;
    pieces.images = vec![Image { width: 1, height: 1, rgba: vec![r, g, b, 255] }];
    Arc::new(Character::new(pieces).unwrap())
}

/// Returns a rig with full reflections and no light.
fn dark() -> Rig {
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.reflections = 1.0;
    rig.upload(&[Affine::IDENTITY]);
    rig
}

fn color(rig: &mut Rig, quad: &Arc<Character>) -> [u8; 3] {
    rig.draw(&[instance(quad, Affine::IDENTITY, 0)]).at(0.2, 0.1)
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn white_surfaces_keep_equal_light_from_everywhere() {
    let mut rig = dark();
    rig.scene.ambient = Ambient::uniform([0.5; 3]);
    for (metallic, roughness) in [(0.0, 1.0), (0.0, 0.2), (1.0, 1.0), (1.0, 0.2)] {
        let white = quad(Material { metallic, roughness, ..plain([1.0; 4]) }, [0; 3]);
        let shown = color(&mut rig, &white);
        assert!(
            shown.iter().all(|c| c.abs_diff(srgb(0.5)) <= 2),
            "{metallic} {roughness} {shown:?}"
        );
    }
    let gold = Material { metallic: 1.0, roughness: 1.0, ..plain([0.8, 0.5, 0.2, 1.0]) };
    let shown = color(&mut rig, &quad(gold, [0; 3]));
    let wanted = [0.4, 0.25, 0.1].map(srgb);
    assert!((0..3).all(|c| shown[c].abs_diff(wanted[c]) <= 2), "{shown:?}");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn smooth_surfaces_mirror_the_sun_where_it_is_seen() {
    let mut rig = dark();
    rig.scene.sun.color = [0.2; 3];
    let mut shade = |roughness, to_sun| {
        rig.scene.sun.to_sun = to_sun;
        color(&mut rig, &quad(Material { roughness, ..plain([0.5, 0.5, 0.5, 1.0]) }, [0; 3]))[0]
    };
    // The camera stands before the square.
    let (ahead, aside) = ([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]);
    assert!(shade(0.2, ahead) > shade(0.9, ahead) + 40);
    assert!(shade(0.2, aside) < shade(0.9, aside) + 4, "the highlight is elsewhere");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn substance_map_multiplies_metallic_and_roughness() {
    let mut rig = dark();
    (rig.scene.ambient, rig.scene.sun.color) = (Ambient::uniform([0.3; 3]), [0.2; 3]);
    let base = || plain([0.6, 0.3, 0.1, 1.0]);
    let mapped =
        Material { metallic: 1.0, roughness: 1.0, metallic_roughness_texture: MAP, ..base() };
    let by_map = color(&mut rig, &quad(mapped, [0, 102, 51]));
    let by_factor = Material { metallic: 0.2, roughness: 0.4, ..base() };
    let wanted = color(&mut rig, &quad(by_factor, [0; 3]));
    assert!((0..3).all(|c| by_map[c].abs_diff(wanted[c]) <= 1), "{by_map:?} {wanted:?}");
    let metal = Material { metallic: 1.0, roughness: 1.0, ..base() };
    assert_ne!(by_map, color(&mut rig, &quad(metal, [0; 3])));
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn normal_map_turns_the_surface_to_the_light() {
    let mut rig = dark();
    (rig.scene.sun.color, rig.scene.reflections) = ([0.5; 3], 0.0);
    // Normals 60 degrees to the right, and 60 degrees upwards.
    let [right, up] = [[238, 128, 191], [128, 238, 191]]
        .map(|texel| quad(Material { normal_texture: MAP, ..plain([1.0; 4]) }, texel));
    let mut light = |quad: &Arc<Character>, to_sun| {
        rig.scene.sun.to_sun = to_sun;
        color(&mut rig, quad)[0]
    };
    let tilted = srgb(0.5 * f64::sqrt(0.75));
    for (quad, towards) in [(&right, [1.0, 0.0, 0.0]), (&up, [0.0, 1.0, 0.0])] {
        let seen = light(quad, towards);
        assert!(seen.abs_diff(tilted) <= 3, "{towards:?}: {seen}, not {tilted}");
        assert_eq!(light(quad, towards.map(|c: f32| -c)), 0);
    }
    let flat = Material { normal_texture: MAP, normal_scale: 0.0, ..plain([1.0; 4]) };
    let seen = light(&quad(flat, [238, 128, 191]), [0.0, 0.0, 1.0]);
    assert!(seen.abs_diff(srgb(0.5)) <= 2, "{seen}");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn occlusion_takes_the_skys_light_and_not_the_suns() {
    let mut rig = dark();
    rig.scene.reflections = 0.0;
    let occluded = |strength| Material {
        occlusion_texture: MAP,
        occlusion_strength: strength,
        ..plain([1.0; 4])
    };
    let [half, none] = [0.5, 1.0].map(|strength| quad(occluded(strength), [0, 255, 255]));
    rig.scene.ambient = Ambient::uniform([0.4; 3]);
    let [shown, dark] = [color(&mut rig, &half), color(&mut rig, &none)];
    assert!(shown[0].abs_diff(srgb(0.2)) <= 2, "{shown:?}");
    assert_eq!(dark, NOTHING);
    rig.scene.sun.color = [0.5; 3];
    assert!(color(&mut rig, &none)[0].abs_diff(srgb(0.5)) <= 2);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn emitted_light_needs_no_other() {
    let mut rig = dark();
    let emissive = [0.5, 0.25, 1.0];
    let plain_glow = Material { emissive, ..plain([1.0; 4]) };
    let mapped = Material { emissive_texture: MAP, ..plain_glow.clone() };
    let near = |found: [u8; 3], wanted: [f64; 3]| {
        assert!((0..3).all(|c| found[c].abs_diff(srgb(wanted[c])) <= 2), "{found:?}");
    };
    near(color(&mut rig, &quad(plain_glow, [0; 3])), [0.5, 0.25, 1.0]);
    near(color(&mut rig, &quad(mapped, [255, 0, 188])), [0.5, 0.0, 0.503]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn light_reaches_further_around_skin() {
    let mut rig = dark();
    (rig.scene.sun.color, rig.scene.reflections) = ([0.8; 3], 0.0);
    rig.scene.sun.to_sun = [1.0, 0.0, 0.0];
    let named = |name: &str| Material { name: name.into(), ..plain([1.0; 4]) };
    let [r, g, b] = color(&mut rig, &quad(named("Skin"), [0; 3]));
    assert!(r > g && g > b && b > 0, "red scatters most: {r} {g} {b}");
    assert_eq!(color(&mut rig, &quad(named("Top"), [0; 3])), NOTHING);
}
