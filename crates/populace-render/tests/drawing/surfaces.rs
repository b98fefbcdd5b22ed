//! Shading: colours, textures, alpha, winding and normals.

use std::sync::Arc;

use populace_character::{
    AlphaMode, Character, CharacterSource, Image, Level, Material, Mesh, Texture, TextureFilter,
    Wrap,
};
use populace_device::MemberLook;
use populace_model::Affine;
use populace_render::{Ambient, Highlights};

use crate::fixture::{at, part, plain, quad_mesh, source, transform};
use crate::rig::{NOTHING, Rig, instance, srgb};

const WHITE: [u8; 3] = [255; 3];

fn quad_of(material: Material) -> Character {
    mesh_of(quad_mesh(0), material)
}

fn mesh_of(mesh: Mesh, material: Material) -> Character {
    Character::new(source(vec![part("quad", 0, mesh)], vec![material], 1)).unwrap()
}

fn textured(image: Image, filter: TextureFilter) -> Character {
    let texture = Texture { image: 0, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat, filter };
    let material = Material { base_color_texture: Some(texture), ..Material::default() };
    let mut pieces = source(vec![part("quad", 0, quad_mesh(0))], vec![material], 1);
    pieces.images = vec![image];
    Character::new(pieces).unwrap()
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn textures_are_upright_and_srgb() {
    let rgba =
        [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [128, 128, 128, 255]].concat();
    let mut rig = Rig::new();
    let quad = Arc::new(textured(Image { width: 2, height: 2, rgba }, TextureFilter::Nearest));
    rig.upload(&[Affine::IDENTITY]);
    let drawn = rig.draw(&[instance(&quad, Affine::IDENTITY, 0)]);
    drawn.expect(-0.5, 0.5, [255, 0, 0]);
    drawn.expect(0.5, 0.5, [0, 255, 0]);
    drawn.expect(-0.5, -0.5, [0, 0, 255]);
    drawn.expect(0.5, -0.5, [128; 3]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn mip_levels_average_linear_light() {
    let rgba = (0..64 * 64)
        .flat_map(|i| [if (i / 64 + i) % 2 == 0 { 255 } else { 0 }, 0, 0, 255])
        .collect();
    let mut rig = Rig::new();
    let quad = Arc::new(textured(Image { width: 64, height: 64, rgba }, TextureFilter::Linear));
    rig.upload(&[Affine::IDENTITY]);
    // The quad's 64 texels cover 32 pixels.
    let drawn = rig.draw(&[instance(&quad, transform([0.0; 3], 0.0, [0.5; 3]), 0)]);
    drawn.expect(0.0, 0.0, [srgb(0.5), 0, 0]);
    drawn.expect(0.3, -0.2, [srgb(0.5), 0, 0]);
}

/// In a coarse level, an opaque texture is in the colours of the vertices. One that masks is not,
/// since holes have the shape of its texels.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn coarse_levels_blend_opaque_textures_between_vertices() {
    let row: Vec<u8> =
        (0..64).flat_map(|x| if x < 32 { [255, 0, 0, 255] } else { [0, 0, 255, 255] }).collect();
    let image = Image { width: 64, height: 64, rgba: row.repeat(64) };
    let quad = textured(image, TextureFilter::Linear);
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    for alpha in [AlphaMode::Opaque, AlphaMode::Mask { cutoff: 0.5 }] {
        let mut pieces = CharacterSource::clone(&quad);
        pieces.materials[0].alpha = alpha;
        let level = Level { error_m: 0.1, meshes: vec![quad_mesh(0)], joint_count: 1 };
        let quad = Character::new(pieces).unwrap().with_levels(vec![level]).unwrap();
        let quad = Arc::new(quad);
        let mut one = instance(&quad, Affine::IDENTITY, 0);
        let drawn = rig.draw(std::slice::from_ref(&one));
        drawn.expect(-0.1, 0.0, [255, 0, 0]);
        drawn.expect(0.1, 0.0, [0, 0, 255]);
        one.level = 1;
        let drawn = rig.draw(&[one]);
        if alpha == AlphaMode::Opaque {
            drawn.expect(0.0, 0.0, [srgb(0.5), 0, srgb(0.5)]);
        } else {
            drawn.expect(-0.1, 0.0, [255, 0, 0]);
        }
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn material_vertex_and_tint_colors_multiply() {
    let mut mesh = quad_mesh(0);
    mesh.colors = vec![[0.5, 1.0, 1.0, 1.0]; 4];
    let mut rig = Rig::new();
    let quad = Arc::new(mesh_of(mesh, plain([0.5, 0.5, 1.0, 1.0])));
    rig.upload(&[Affine::IDENTITY]);
    let mut one = instance(&quad, Affine::IDENTITY, 0);
    one.look = MemberLook::PLAIN.all_tinted([1.0, 1.0, 0.2]);
    rig.draw(&[one]).expect(0.0, 0.0, [srgb(0.25), srgb(0.5), srgb(0.2)]);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn back_faces_show_only_if_double_sided() {
    let mut rig = Rig::new();
    let single = Arc::new(quad_of(plain([1.0; 4])));
    let double = Arc::new(quad_of(Material { double_sided: true, ..plain([1.0; 4]) }));
    rig.upload(&[Affine::IDENTITY]);
    // A half turn about y.
    let behind = transform([0.0; 3], 0.0, [-1.0, 1.0, -1.0]);
    rig.draw(&[instance(&single, Affine::IDENTITY, 0)]).expect(0.0, 0.0, WHITE);
    rig.draw(&[instance(&single, behind, 0)]).expect(0.0, 0.0, NOTHING);
    rig.draw(&[instance(&double, Affine::IDENTITY, 0)]).expect(0.0, 0.0, WHITE);
    rig.draw(&[instance(&double, behind, 0)]).expect(0.0, 0.0, WHITE);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn both_sides_are_lit_by_the_light_they_face() {
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.5; 3];
    let double = Arc::new(quad_of(Material { double_sided: true, ..plain([1.0; 4]) }));
    rig.upload(&[Affine::IDENTITY]);
    let lit = [srgb(0.5); 3];
    for world in [
        Affine::IDENTITY,
        transform([0.0; 3], 0.0, [-1.0, 1.0, -1.0]),
        transform([0.0; 3], 0.0, [-1.0, 1.0, 1.0]),
        transform([0.0; 3], 0.0, [1.0, 1.0, -1.0]),
    ] {
        rig.draw(&[instance(&double, world, 0)]).expect(0.0, 0.0, lit);
    }
    rig.scene.sun.to_sun = [0.0, 0.0, -1.0];
    rig.draw(&[instance(&double, Affine::IDENTITY, 0)]).expect(0.0, 0.0, NOTHING);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn mirrored_meshes_keep_their_front_faces() {
    let mirror = transform([0.0; 3], 0.0, [-1.0, 1.0, 1.0]);
    let mut pieces = source(vec![part("quad", 0, quad_mesh(0))], vec![plain([1.0; 4])], 1);
    pieces.palette[0].joint_from_bind = mirror;
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.5; 3];
    let plain_quad = Arc::new(quad_of(plain([1.0; 4])));
    let mirrored_at_rest = Arc::new(Character::new(pieces).unwrap());
    rig.upload(&[Affine::IDENTITY, mirror]);
    let lit = [srgb(0.5); 3];
    rig.draw(&[instance(&plain_quad, mirror, 0)]).expect(0.0, 0.0, lit);
    rig.draw(&[instance(&mirrored_at_rest, Affine::IDENTITY, 1)]).expect(0.0, 0.0, lit);
    rig.draw(&[instance(&mirrored_at_rest, mirror, 1)]).expect(0.0, 0.0, lit);
    let behind = transform([0.0; 3], 0.0, [1.0, 1.0, -1.0]);
    rig.draw(&[instance(&plain_quad, behind, 0)]).expect(0.0, 0.0, NOTHING);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn normals_stay_perpendicular_under_nonuniform_scale() {
    let mut mesh = quad_mesh(0);
    // Rotated by 45 degrees about y: z = -x.
    for position in &mut mesh.positions {
        position[2] = -position[0];
    }
    let slant = std::f32::consts::FRAC_1_SQRT_2;
    mesh.normals = vec![[slant, 0.0, slant]; 4];
    let mut rig = Rig::new();
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.5; 3];
    let quad = Arc::new(mesh_of(mesh, plain([1.0; 4])));
    let wide = transform([0.0; 3], 0.0, [4.0, 1.0, 1.0]);
    rig.upload(&[Affine::IDENTITY, wide]);
    // The plane z = -x / 4 has the normal (1, 0, 4).
    let lit = [srgb(0.5 * 4.0 / 17_f64.sqrt()); 3];
    rig.draw(&[instance(&quad, Affine::IDENTITY, 1)]).expect(0.0, 0.0, lit);
    rig.draw(&[instance(&quad, wide, 0)]).expect(0.0, 0.0, lit);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn masked_parts_are_discarded_and_blended_parts_mix() {
    let alpha = |mode, alpha| quad_of(Material { alpha: mode, ..plain([1.0, 1.0, 1.0, alpha]) });
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let cut = Arc::new(alpha(AlphaMode::Mask { cutoff: 0.5 }, 0.4));
    let kept = Arc::new(alpha(AlphaMode::Mask { cutoff: 0.5 }, 0.6));
    let opaque = Arc::new(alpha(AlphaMode::Opaque, 0.1));
    rig.draw(&[instance(&cut, Affine::IDENTITY, 0)]).expect(0.0, 0.0, NOTHING);
    rig.draw(&[instance(&kept, Affine::IDENTITY, 0)]).expect(0.0, 0.0, WHITE);
    rig.draw(&[instance(&opaque, Affine::IDENTITY, 0)]).expect(0.0, 0.0, WHITE);

    let half = |[r, g, b]: [f32; 3]| {
        quad_of(Material { alpha: AlphaMode::Blend, ..plain([r, g, b, 0.5]) })
    };
    let red = Arc::new(half([1.0, 0.0, 0.0]));
    let green = Arc::new(half([0.0, 1.0, 0.0]));
    let (near, far) = (at(0.0, 0.0, 1.0), at(0.0, 0.0, 0.0));
    let wanted = [srgb(0.5), srgb(0.25), 0];
    for list in [
        [instance(&red, near, 0), instance(&green, far, 0)],
        [instance(&green, far, 0), instance(&red, near, 0)],
    ] {
        rig.draw(&list).expect(0.0, 0.0, wanted);
    }
    // An opaque instance behind shows through, although its character was added later.
    let blue = Arc::new(quad_of(plain([0.0, 0.0, 1.0, 1.0])));
    rig.draw(&[instance(&red, near, 0), instance(&blue, far, 0)]).expect(
        0.0,
        0.0,
        [srgb(0.5), 0, srgb(0.5)],
    );
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn highlights_approach_white_without_reaching_it() {
    let mut rig = Rig::new();
    let quad = Arc::new(quad_of(Material::default()));
    rig.upload(&[Affine::IDENTITY]);
    let mut shade = |light: f32, highlights| {
        rig.scene.highlights = highlights;
        rig.scene.ambient = Ambient::uniform([light; 3]);
        rig.draw(&[instance(&quad, Affine::IDENTITY, 0)]).at(0.0, 0.0)[0]
    };
    let (dark, gray) = (shade(0.02, Highlights::Filmic), shade(0.18, Highlights::Filmic));
    assert!(dark < shade(0.02, Highlights::Clipped), "shadows gain contrast: {dark}");
    assert!(gray.abs_diff(shade(0.18, Highlights::Clipped)) <= 6, "grey stays: {gray}");
    let (bright, brighter) = (shade(1.0, Highlights::Filmic), shade(1.5, Highlights::Filmic));
    assert!(bright < brighter && brighter < 255, "{bright} {brighter}");
    assert_eq!((shade(1.0, Highlights::Clipped), shade(1.5, Highlights::Clipped)), (255, 255));
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn pixels_are_averages_of_the_samples_on_their_edges() {
    let white = Arc::new(quad_of(plain([1.0; 4])));
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let pixel_m = 1.0 / 32.0;
    // A square that ends within the pixel right of the middle or above it.
    for (end, wanted) in [(0.25, 0.25), (0.75, 0.75), (0.9, 0.75)] {
        let by = end * pixel_m - 1.0;
        let right = rig.draw(&[instance(&white, at(by, 0.0, 0.0), 0)]);
        right.expect(0.5 * pixel_m, 0.3, [srgb(wanted); 3]);
        let up = rig.draw(&[instance(&white, at(0.0, by, 0.0), 0)]);
        up.expect(0.3, 0.5 * pixel_m, [srgb(wanted); 3]);
    }
    // Nothing is missing along the edges of the picture.
    let whole = rig.draw(&[instance(&white, transform([0.0; 3], 0.0, [2.1, 2.1, 1.0]), 0)]);
    assert!(whole.0.rgba.iter().all(|byte| *byte == 255));
}
