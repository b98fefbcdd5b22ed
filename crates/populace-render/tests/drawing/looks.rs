//! Looks: tints of regions, and options that members do not show.

use std::sync::Arc;

use populace_character::{Character, Level, Material, Region};
use populace_device::MemberLook;
use populace_model::Affine;
use populace_render::Ambient;

use crate::fixture::{at, box_mesh, part, plain, quad_mesh, source, transform};
use crate::rig::{NOTHING, Rig, instance, linear, srgb};

/// Returns a shirt on the left and trousers on the right; both materials are grey.
fn dressed() -> Character {
    let names = ["Top cotton", "Trousers"];
    let materials = names.map(|name| Material { name: name.into(), ..plain([0.5, 0.5, 0.5, 1.0]) });
    let [left, right] = [-1.0, 1.0].map(|side: f32| {
        let mut mesh = quad_mesh(0);
        mesh.positions.iter_mut().for_each(|p| p[0] = 0.5 * (p[0] + side));
        mesh
    });
    let parts = vec![part("shirt", 0, left), part("trousers", 1, right)];
    Character::new(source(parts, materials.to_vec(), 1)).unwrap()
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn each_region_of_each_member_has_its_own_tint() {
    let character = dressed();
    let meshes = character.parts.iter().map(|part| part.mesh.clone()).collect();
    let level = Level { error_m: 0.1, meshes, joint_count: 1 };
    let character = Arc::new(character.with_levels(vec![level]).unwrap());
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let mut list = [0.0, -1.2].map(|y| instance(&character, at(0.0, y, 0.0), 0));
    list[0].world_from_model = transform([0.0, 0.6, 0.0], 0.0, [1.0, 0.5, 1.0]);
    list[1].world_from_model = transform([0.0, -0.6, 0.0], 0.0, [1.0, 0.5, 1.0]);
    list[0].look = MemberLook::PLAIN
        .tinted(Region::Top, [1.5, 1.0, 0.5])
        .tinted(Region::Trousers, [0.0, 0.0, 1.0]);
    list[1].look = MemberLook::PLAIN.tinted(Region::Skin, [0.0; 3]);
    for level in [0, 1] {
        list.iter_mut().for_each(|one| one.level = level);
        let drawn = rig.draw(&list);
        drawn.expect(-0.5, 0.6, [srgb(0.75), srgb(0.5), srgb(0.25)]);
        drawn.expect(0.5, 0.6, [0, 0, srgb(0.5)]);
        drawn.expect(-0.5, -0.6, [srgb(0.5); 3]);
        drawn.expect(0.5, -0.6, [srgb(0.5); 3]);
    }
    let drawn = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
    assert_eq!(drawn.members.draw_calls, 1, "looks take no further calls");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn hidden_options_are_not_drawn_and_cast_no_shadow() {
    let parts = vec![
        part("Option:hat:cap", 0, box_mesh([-1.0, -0.5, 0.0], [-0.2, 0.5, 0.1], 0)),
        part("Option:hat:crown", 0, box_mesh([0.2, -0.5, 0.0], [1.0, 0.5, 0.1], 0)),
    ];
    let hats = Arc::new(Character::new(source(parts, vec![plain([1.0; 4])], 1)).unwrap());
    let wall = Arc::new(
        Character::new(source(vec![part("wall", 0, quad_mesh(0))], vec![plain([1.0; 4])], 1))
            .unwrap(),
    );
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let both = [1.0, 1.0].map(|_| [255; 3]);
    for (hidden, wanted) in
        [(None, both), (Some(0), [NOTHING, [255; 3]]), (Some(1), [[255; 3], NOTHING])]
    {
        let mut one = instance(&hats, Affine::IDENTITY, 0);
        one.look = hidden.map_or(one.look, |option| one.look.without_option(option));
        let drawn = rig.draw(&[one]);
        drawn.expect(-0.6, 0.0, wanted[0]);
        drawn.expect(0.6, 0.0, wanted[1]);
    }
    // The sun stands above the camera: the hats, 1 m before the wall, shade it 0.5 m lower.
    rig.scene.ambient = Ambient::uniform([0.0; 3]);
    rig.scene.sun.color = [0.5; 3];
    rig.scene.sun.to_sun = [0.0, 1.0, 2.0];
    rig.scene.sun.casts_shadows = true;
    let mut one = instance(&hats, at(0.0, 0.0, 1.0), 0);
    one.look = one.look.without_option(0);
    let wall = instance(&wall, transform([0.0; 3], 0.0, [2.0, 2.0, 1.0]), 0);
    let drawn = rig.draw(&[one, wall]);
    assert!(drawn.at(-0.6, -0.8)[0] > 100, "{:?}", drawn.at(-0.6, -0.8));
    drawn.expect(0.6, -0.8, NOTHING);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn members_that_fade_cover_a_part_of_their_samples() {
    let square = source(vec![part("square", 0, quad_mesh(0))], vec![plain([1.0; 4])], 1);
    let square = Arc::new(Character::new(square).unwrap());
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let mut covered = |opacity: f32| {
        let mut one = instance(&square, Affine::IDENTITY, 0);
        one.look = one.look.with_opacity(opacity);
        let drawn = rig.draw(&[one]);
        drawn.0.rgba.chunks(4).map(|pixel| linear(pixel[0])).sum::<f64>()
    };
    let whole = covered(1.0);
    assert!(whole > 100.0, "{whole}");
    for opacity in [0.0, 0.25, 0.5, 0.75] {
        let share = covered(opacity) / whole;
        assert!((share - f64::from(opacity)).abs() < 0.06, "{opacity}: {share}");
    }
}
