//! Draws with the same state are one call.

use std::sync::Arc;

use populace_character::{
    AlphaMode, Character, Image, Influences, Material, Mesh, Texture, TextureFilter, Wrap,
};
use populace_model::Affine;

use crate::fixture::{at, one_influence, part, plain, quad_mesh, source};
use crate::rig::{NOTHING, Rig, instance, srgb};

const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const GREEN: [f32; 4] = [0.0, 1.0, 0.0, 1.0];

fn quad(material: Material) -> Arc<Character> {
    let parts = vec![part("quad", 0, quad_mesh(0))];
    Arc::new(Character::new(source(parts, vec![material], 1)).unwrap())
}

/// Returns a quad with 4 more vertices for each of `more`.
fn quads(color: [f32; 4], more: usize) -> Arc<Character> {
    let mesh = quad_mesh(0);
    let count = more + 1;
    let indices =
        (0..).step_by(4).take(count).flat_map(|first| [0, 1, 2, 0, 2, 3].map(|i| first + i));
    let mesh = Mesh {
        positions: mesh.positions.repeat(count),
        normals: mesh.normals.repeat(count),
        uvs: mesh.uvs.repeat(count),
        influences: one_influence(4 * count, 0),
        indices: indices.collect(),
        ..mesh
    };
    let parts = vec![part("quads", 0, mesh)];
    Arc::new(Character::new(source(parts, vec![plain(color)], 1)).unwrap())
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn characters_with_the_same_state_share_a_call() {
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let [red, green] = [RED, GREEN].map(|color| quad(plain(color)));
    let emitting = quad(Material { emissive: [0.0, 0.0, 1.0], ..plain([0.0, 0.0, 0.0, 1.0]) });
    let shining = quad(Material { emissive: [0.0, 1.0, 1.0], ..plain([0.0, 0.0, 0.0, 1.0]) });
    let places = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let mut list = Vec::new();
    for (character, [x, y], calls) in [
        (&red, places[0], 1),
        (&green, places[1], 1),
        (&emitting, places[2], 2),
        // The colour of emitted light is a constant of a call.
        (&shining, places[3], 3),
        (&red, [5.0, 0.0], 3),
    ] {
        list.push(instance(character, at(x, y, 0.0), 0));
        let drawn = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
        assert_eq!(drawn.members.draw_calls, calls);
    }
    let drawn = rig.draw(&list);
    let wanted = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [0, 255, 255]];
    for ([x, y], wanted) in places.into_iter().zip(wanted) {
        drawn.expect(x, y, wanted);
    }
    // A mirrored instance has the other winding.
    let mirror = crate::fixture::transform([3.0, 0.0, 0.0], 0.0, [-1.0, 1.0, 1.0]);
    list.push(instance(&red, mirror, 0));
    let drawn = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
    assert_eq!(drawn.members.draw_calls, 4);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn each_texture_has_a_call_of_its_own() {
    let (wrap_u, wrap_v, filter) = (Wrap::Repeat, Wrap::Repeat, TextureFilter::Linear);
    let map = Some(Texture { image: 0, wrap_u, wrap_v, filter });
    let white = plain([1.0; 4]);
    let materials = [
        Material { base_color_texture: map, ..white.clone() },
        Material { metallic_roughness_texture: map, ..white.clone() },
        Material { normal_texture: map, ..white.clone() },
        Material { occlusion_texture: map, ..white.clone() },
        Material { emissive_texture: map, emissive: [1.0; 3], ..white.clone() },
    ];
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    for (kind, material) in materials.into_iter().enumerate() {
        let quads = [0, 255].map(|texel| {
            let parts = vec![part("quad", 0, quad_mesh(0))];
            let mut pieces = source(parts, vec![material.clone()], 1);
            pieces.images =
                vec![Image { width: 1, height: 1, rgba: vec![texel, texel, texel, 255] }];
            Arc::new(Character::new(pieces).unwrap())
        });
        let list = [0, 1, 0].map(|quad| instance(&quads[quad], Affine::IDENTITY, 0));
        let drawn = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
        assert_eq!(drawn.members.draw_calls, 2, "texture {kind}");
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn meshes_stay_when_others_come_and_go() {
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let red = quads(RED, 0);
    let left = at(-1.0, 0.0, 0.0);
    for (more, color, wanted) in [
        (0, GREEN, [0, 255, 0]),
        (9, GREEN, [0, 255, 0]),
        (2, [0.0, 0.0, 1.0, 1.0], [0, 0, 255]),
        (300, GREEN, [0, 255, 0]),
        (1, [0.0, 0.0, 1.0, 1.0], [0, 0, 255]),
    ] {
        // The last one's place is free from here on.
        let other = quads(color, more);
        let list = [instance(&red, left, 0), instance(&other, at(1.0, 0.0, 0.0), 0)];
        let counts = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
        assert_eq!(counts.members.triangles, 4 + 2 * more);
        let drawn = rig.draw(&list);
        drawn.expect(-1.0, 0.0, [255, 0, 0]);
        drawn.expect(1.0, 0.0, wanted);
    }
}

/// Blended surfaces keep their order, though the first and the last would share a call.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn blended_surfaces_keep_their_order() {
    let mut rig = Rig::new();
    rig.upload(&[Affine::IDENTITY]);
    let half = |[r, g, b]: [f32; 3], double_sided| {
        let material = plain([r, g, b, 0.5]);
        quad(Material { alpha: AlphaMode::Blend, double_sided, ..material })
    };
    let red = half([1.0, 0.0, 0.0], false);
    let green = half([0.0, 1.0, 0.0], true);
    let list = [(&red, 0.0), (&green, 0.5), (&red, 1.0), (&red, 1.5)]
        .map(|(character, z)| instance(character, at(0.0, 0.0, z), 0));
    let counts = rig.renderer.draw_instances(&list, &rig.camera, &rig.scene).unwrap();
    assert_eq!(counts.members.draw_calls, 3);
    let mix = |behind: f64, front: f64| 0.5 * (behind + front);
    let red = [1.0, 0.0, 1.0, 1.0].into_iter().fold(0.0, mix);
    let green = [0.0, 1.0, 0.0, 0.0].into_iter().fold(0.0, mix);
    rig.draw(&list).expect(0.0, 0.0, [srgb(red), srgb(green), 0]);
}

/// Sides of a mesh are drawn apart, and one of them may have fewer influences than the mesh.
#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn vertices_with_room_for_eight_influences_may_have_fewer() {
    let mut mesh = quad_mesh(0);
    let weights = [0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let entries = [1, 2, 0, 0, 0, 0, 0, 0];
    mesh.influences =
        Influences { per_vertex: 8, entries: entries.repeat(4), weights: weights.repeat(4) };
    let parts = vec![part("quad", 0, mesh)];
    let quad = Arc::new(Character::new(source(parts, vec![plain([1.0; 4])], 3)).unwrap());
    let mut rig = Rig::new();
    rig.upload(&[at(0.0, 9.0, 0.0), at(2.0, 0.0, 0.0), at(0.0, 0.0, 0.0)]);
    let drawn = rig.draw(&[instance(&quad, Affine::IDENTITY, 0)]);
    drawn.expect(1.0, 0.0, [255; 3]);
    drawn.expect(-0.5, 0.0, NOTHING);
}
