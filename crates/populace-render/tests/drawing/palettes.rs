//! Skinning: vertices follow their palette entries.

use std::sync::Arc;

use populace_character::{Character, Influences};
use populace_device::MemberLook;
use populace_device::layout::PAGE_ENTRIES;
use populace_model::Affine;

use crate::fixture::{at, palette, part, person, plain, quad_mesh, source, transform};
use crate::rig::{NOTHING, Picture, Rig, instance};

const RED: [u8; 3] = [255, 0, 0];
const GREEN: [u8; 3] = [0, 255, 0];

fn red_and_green() -> Character {
    person([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn each_part_follows_its_palette_entry() {
    let mut rig = Rig::new();
    let person = Arc::new(red_and_green());
    let list = [instance(&person, Affine::IDENTITY, 0)];
    rig.upload(&[Affine::IDENTITY; 2]);
    let still = rig.draw(&list);
    still.expect(0.0, 1.1, RED);
    still.expect(0.0, 1.6, GREEN);
    still.expect(0.0, 0.5, NOTHING);
    still.expect(0.13, 0.5, RED);
    still.expect(0.6, 1.1, NOTHING);

    rig.upload(&[at(1.0, -1.0, 0.0), at(-1.0, -2.0, 0.0)]);
    let moved = rig.draw(&list);
    moved.expect(0.0, 1.1, NOTHING);
    moved.expect(1.0, 0.1, RED);
    moved.expect(-1.0, -0.4, GREEN);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn palette_rotates_and_scales_about_the_model_origin() {
    let mut rig = Rig::new();
    let person = Arc::new(red_and_green());
    rig.upload(&[
        transform([0.0; 3], std::f32::consts::FRAC_PI_2, [1.0; 3]),
        transform([0.0; 3], 0.0, [0.5; 3]),
    ]);
    let drawn = rig.draw(&[instance(&person, Affine::IDENTITY, 0)]);
    drawn.expect(-1.1, 0.0, RED);
    drawn.expect(0.0, 0.8, GREEN);
    drawn.expect(0.0, 1.6, NOTHING);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn instances_have_their_own_palette_transform_and_tint() {
    let mut rig = Rig::new();
    let white = Arc::new(person([1.0; 3], [1.0; 3]));
    rig.upload(&[Affine::IDENTITY, Affine::IDENTITY, at(0.0, -1.0, 0.0), at(0.0, -3.0, 0.0)]);
    let mut list =
        [instance(&white, at(-1.0, 0.0, 0.0), 0), instance(&white, at(1.0, 0.0, 0.0), 2)];
    list[1].look = MemberLook::PLAIN.all_tinted([0.0, 1.0, 0.0]);
    let drawn = rig.draw(&list);
    drawn.expect(-1.0, 1.6, [255; 3]);
    drawn.expect(-1.0, -0.1, NOTHING);
    drawn.expect(1.0, 0.1, GREEN);
    drawn.expect(1.0, -1.4, GREEN);
    drawn.expect(1.0, 1.1, NOTHING);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn palettes_are_read_from_their_page() {
    let mut rig = Rig::new();
    let person = Arc::new(red_and_green());
    let page0 = [at(50.0, 0.0, 0.0); 4];
    let page1 = [at(50.0, 0.0, 0.0), at(50.0, 0.0, 0.0), at(0.0, -1.0, 0.0), Affine::IDENTITY];
    rig.upload_pages(vec![palette(&page0), palette(&page1)]).unwrap();
    let drawn = rig.draw(&[
        instance(&person, at(-50.0 + 1.0, 0.0, 0.0), 2),
        instance(&person, Affine::IDENTITY, PAGE_ENTRIES + 2),
    ]);
    drawn.expect(0.0, 0.1, RED);
    drawn.expect(0.0, 1.6, GREEN);
    drawn.expect(1.0, 1.1, RED);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn page_can_grow_and_shrink() {
    let mut rig = Rig::new();
    let person = Arc::new(red_and_green());
    for count in [2, 400, 4] {
        let mut entries = vec![at(50.0, 0.0, 0.0); count];
        entries[count - 2..].fill(Affine::IDENTITY);
        rig.upload(&entries);
        let last = u32::try_from(count - 2).unwrap();
        rig.draw(&[instance(&person, Affine::IDENTITY, last)]).expect(0.0, 1.1, RED);
        assert!(rig.try_draw(&[instance(&person, Affine::IDENTITY, last + 1)]).is_err());
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn all_influences_of_a_vertex_contribute() {
    for width in [4_u16, 8] {
        let mut mesh = quad_mesh(0);
        let share = 1.0 / f32::from(width);
        mesh.influences = Influences {
            per_vertex: usize::from(width),
            entries: (0..width).collect::<Vec<_>>().repeat(4),
            weights: vec![share; 4 * usize::from(width)],
        };
        let character = Character::new(source(
            vec![part("quad", 0, mesh)],
            vec![plain([1.0; 4])],
            u32::from(width),
        ))
        .unwrap();
        let mut rig = Rig::new();
        let quad = Arc::new(character);
        // Each entry scales to a tenth and translates, so that the mean would change if any one
        // entry were ignored.
        let steps = [
            [8.0, 0.0],
            [0.0, 4.0],
            [8.0, 0.0],
            [0.0, 8.0],
            [-8.0, 0.0],
            [0.0, -8.0],
            [-8.0, 4.0],
            [-8.0, 0.0],
        ];
        let steps = &steps[..usize::from(width)];
        let entries: Vec<_> =
            steps.iter().map(|[x, y]| transform([*x, *y, 0.0], 0.0, [0.1; 3])).collect();
        rig.upload(&entries);
        let mean = |axis: usize| steps.iter().map(|step| step[axis]).sum::<f32>() * share;
        let drawn = rig.draw(&[instance(&quad, at(0.0, 0.0, 0.0), 0)]);
        let (x, y) = (mean(0), mean(1));
        assert_ne!((x, y), (0.0, 0.0));
        // With four influences the quad leaves the picture; the instance moves it back.
        let drawn =
            if width == 4 { rig.draw(&[instance(&quad, at(-x, -y, 0.0), 0)]) } else { drawn };
        let (x, y) = if width == 4 { (0.0, 0.0) } else { (x, y) };
        drawn.expect(x, y, [255; 3]);
        drawn.expect(x + 0.3, y, NOTHING);
        drawn.expect(x, y + 0.3, NOTHING);
    }
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn hidden_parts_are_not_drawn() {
    let mut rig = Rig::new();
    let headless = Arc::new(red_and_green());
    rig.renderer.upload_character(&headless, &|part| part.node_name == "head").unwrap();
    rig.upload(&[Affine::IDENTITY; 2]);
    let drawn = rig.draw(&[instance(&headless, Affine::IDENTITY, 0)]);
    drawn.expect(0.0, 1.6, NOTHING);
    drawn.expect(0.0, 1.1, RED);
    rig.renderer.upload_character(&headless, &|_| false).unwrap();
    rig.draw(&[instance(&headless, Affine::IDENTITY, 0)]).expect(0.0, 1.6, GREEN);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn nearer_instance_hides_farther_one_in_any_order() {
    let mut rig = Rig::new();
    let red = Arc::new(person([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    let green = Arc::new(person([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]));
    rig.upload(&[Affine::IDENTITY; 2]);
    let (near, far) = (at(0.0, 0.0, 1.0), at(0.0, 0.0, -1.0));
    for list in [
        [instance(&red, near, 0), instance(&green, far, 0)],
        [instance(&green, far, 0), instance(&red, near, 0)],
    ] {
        rig.draw(&list).expect(0.0, 1.1, RED);
    }
    rig.draw(&[instance(&red, far, 0), instance(&green, near, 0)]).expect(0.0, 1.1, GREEN);
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn non_finite_member_does_not_affect_others() {
    let mut rig = Rig::new();
    let person = Arc::new(red_and_green());
    let non_finite = transform([f32::NAN; 3], 0.0, [1.0; 3]);
    rig.upload(&[Affine::IDENTITY, Affine::IDENTITY, non_finite, non_finite]);
    rig.scene.sun.casts_shadows = true;
    let alone = rig.draw(&[instance(&person, Affine::IDENTITY, 0)]);
    let together = rig.draw(&[
        instance(&person, non_finite, 0),
        instance(&person, at(0.0, 0.0, 1.0), 2),
        instance(&person, Affine::IDENTITY, 0),
    ]);
    alone.expect(0.0, 1.1, RED);
    assert!(alone.0 == together.0, "a non-finite member changed the picture");
}

#[test]
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
fn renderers_on_one_thread_are_independent() {
    let mut rigs = [Rig::new(), Rig::new()];
    let colors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let people = [0, 1].map(|i| Arc::new(person(colors[i], colors[i])));
    for rig in &mut rigs {
        rig.upload(&[Affine::IDENTITY; 2]);
    }
    let [first, second] = &mut rigs;
    first.draw(&[instance(&people[0], Affine::IDENTITY, 0)]);
    second.draw(&[instance(&people[1], Affine::IDENTITY, 0)]).expect(0.0, 1.1, GREEN);
    let [mut first, mut second] = rigs;
    Picture(first.renderer.read_image().unwrap()).expect(0.0, 1.1, RED);
    drop(first);
    second.draw(&[instance(&people[1], at(1.0, 0.0, 0.0), 0)]).expect(1.0, 1.1, GREEN);
}
