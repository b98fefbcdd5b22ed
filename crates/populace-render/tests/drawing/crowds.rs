//! Whole crowds: characters are uploaded when they are first seen, and crowds are kept apart.

use std::sync::Arc;

use populace_character::{Character, Level, Mesh, Part};
use populace_device::{Instance, Visibility};
use populace_model::Affine;

use crate::fixture::{at, palette, person};
use crate::rig::{NOTHING, Pages, Picture, Rig, instance};

const RED: [u8; 3] = [255, 0, 0];
const GREEN: [u8; 3] = [0, 255, 0];

/// A crowd of one member of its own character.
fn one([r, g, b]: [f32; 3], place: Affine, bones: Affine) -> Pages {
    let member = (Arc::new(person([r, g, b], [r, g, b])), place, 0);
    Pages::new(vec![palette(&[bones; 2])], vec![member])
}

impl Rig {
    fn draw_crowds(&mut self, crowds: [&mut Pages; 2]) -> Picture {
        let [a, b] = crowds;
        self.renderer.draw_crowds(&mut [a, b], &self.camera, &self.scene).unwrap();
        Picture(self.renderer.read_image().unwrap())
    }

    fn draw_crowd(&mut self, crowd: &mut Pages) -> Picture {
        self.renderer.draw(crowd, &self.camera, &self.scene).unwrap();
        Picture(self.renderer.read_image().unwrap())
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn crowds_share_a_picture_with_palettes_of_their_own() {
    let mut rig = Rig::new();
    let mut red = one([1.0, 0.0, 0.0], at(-1.0, 0.0, 0.0), Affine::IDENTITY);
    let mut green = one([0.0, 1.0, 0.0], at(1.0, 0.0, 0.0), at(0.0, -1.0, 0.0));
    for _ in 0..2 {
        let both = rig.draw_crowds([&mut red, &mut green]);
        both.expect(-1.0, 1.6, RED);
        both.expect(1.0, 0.1, GREEN);
        both.expect(1.0, 1.6, NOTHING);
        let alone = rig.draw_crowd(&mut green);
        alone.expect(-1.0, 1.6, NOTHING);
        alone.expect(1.0, 0.1, GREEN);
    }
}

/// A new character may get the address of one that was dropped.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn characters_are_not_confused_with_dropped_ones() {
    let mut rig = Rig::new();
    for round in 0..8 {
        for (color, wanted) in [([1.0, 0.0, 0.0], RED), ([0.0, 1.0, 0.0], GREEN)] {
            let mut crowd = one(color, Affine::IDENTITY, Affine::IDENTITY);
            let drawn = rig.draw_crowd(&mut crowd);
            assert_eq!(drawn.at(0.0, 1.1), wanted, "round {round}");
        }
    }
}

/// Characters that stay keep their models when others, before and after them, are released.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn other_characters_stay_when_some_are_released() {
    let mut rig = Rig::new();
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
    let mut crowd = Pages::new(vec![palette(&[Affine::IDENTITY; 2])], Vec::new());
    for (place, color) in [-1.5, -0.5, 0.5, 1.5].into_iter().zip(colors) {
        let member = (Arc::new(person(color, color)), at(place, 0.0, 0.0), 0);
        crowd.members.push(member);
    }
    rig.draw_crowd(&mut crowd);
    crowd.members.remove(2);
    crowd.members.remove(0);
    for _ in 0..2 {
        let drawn = rig.draw_crowd(&mut crowd);
        drawn.expect(-1.5, 1.1, NOTHING);
        drawn.expect(-0.5, 1.1, GREEN);
        drawn.expect(0.5, 1.1, NOTHING);
        drawn.expect(1.5, 1.1, [255, 255, 0]);
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn instances_and_visible_triangles_are_counted() {
    let mut rig = Rig::new();
    let mut crowd = one([1.0; 3], Affine::IDENTITY, Affine::IDENTITY);
    let (character, place, first) = crowd.members[0].clone();
    crowd.members.push((Arc::clone(&character), place, first));
    let triangles = |wanted: &str| {
        let parts = character.parts.iter().filter(|part| part.node_name.contains(wanted));
        2 * parts.map(|part| part.mesh.indices.len() / 3).sum::<usize>()
    };
    let all = rig.renderer.draw(&mut crowd, &rig.camera, &rig.scene).unwrap();
    assert_eq!((all.members.instances, all.members.triangles), (2, triangles("")));
    rig.renderer.upload_character(&character, &|part| part.node_name == "head").unwrap();
    let headless = rig.renderer.draw(&mut crowd, &rig.camera, &rig.scene).unwrap();
    assert!(triangles("head") > 0);
    assert_eq!(headless.members.triangles, all.members.triangles - triangles("head"));
}

/// Returns a red person whose coarser level is 0.1 m off and has no head.
fn headless_from_afar() -> Arc<Character> {
    let character = person([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let headless = |part: &Part| {
        let indices = if part.node_name == "head" { Vec::new() } else { part.mesh.indices.clone() };
        Mesh { indices, ..part.mesh.clone() }
    };
    let meshes = character.parts.iter().map(headless).collect();
    let level = Level { error_m: 0.1, meshes, joint_count: 1 };
    Arc::new(character.with_levels(vec![level]).unwrap())
}

/// Pixels are 0.03 m wide at the first member, and 0.16 m at the second.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn far_members_throw_shadows_of_coarser_levels() {
    let mut rig = Rig::new();
    rig.scene.sun.casts_shadows = true;
    let character = headless_from_afar();
    rig.upload(&[Affine::IDENTITY; 2]);
    let list = [0.0, -40.0].map(|z| instance(&character, at(0.0, 0.0, z), 0));
    let mut triangles = |error_px| {
        rig.scene.sun.error_px = error_px;
        let drawn = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
        (drawn.members.triangles, drawn.shadow.triangles)
    };
    let (all, all_thrown) = triangles(0.0);
    let [(far_seen, far), (both_seen, both)] = [1.0, 10.0].map(triangles);
    assert_eq!((all_thrown, far_seen, both_seen), (all, all, all));
    assert!(both < far && far - both == all - far, "{all}, {far}, {both}");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn instances_show_their_level_and_hidden_ones_nothing() {
    let mut rig = Rig::new();
    let character = headless_from_afar();
    let member = (Arc::clone(&character), Affine::IDENTITY, 0);
    let mut pages = Pages::new(vec![palette(&[Affine::IDENTITY; 2])], vec![member]);
    rig.renderer.acquire_palettes(&mut pages).unwrap();
    let whole = instance(&character, Affine::IDENTITY, 0);
    let mut draw = |instance| {
        let drawn = rig.renderer.draw_instances(&[instance], &rig.camera, &rig.scene).unwrap();
        (drawn, Picture(rig.renderer.read_image().unwrap()))
    };
    let (all, picture) = draw(whole);
    picture.expect(0.0, 1.6, RED);
    picture.expect(0.0, 1.1, RED);
    for level in [1, 9] {
        let (drawn, picture) = draw(Instance { level, ..whole });
        picture.expect(0.0, 1.6, NOTHING);
        picture.expect(0.0, 1.1, RED);
        assert!(drawn.members.triangles < all.members.triangles, "level {level}");
    }
    for visibility in [Visibility::ShadowOnly, Visibility::Hidden] {
        let (drawn, picture) = draw(Instance { visibility, ..whole });
        picture.expect(0.0, 1.1, NOTHING);
        assert_eq!((drawn.members.instances, drawn.members.triangles), (0, 0));
    }
}
