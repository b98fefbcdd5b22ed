//! Who lends to whom, in every order of coming and going.

use std::sync::Arc;

use populace::character::{
    Character, CharacterSource, Image, Influences, Mesh, PaletteEntry, Part,
};
use populace::clip::Clip;
use populace::hand_over::PAGE_ENTRIES;
use populace::model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs,
};
use populace::{Crowd, Device, Devices, Placement, Play};

use crate::assert_same;
use crate::stage::{ByCopy, Stage, Troupe, film_by_copy};

pub(crate) fn a_crowd_outlives_its_renderer(device: &Devices) {
    let film = film_by_copy(device, 30, 4);
    let mut troupe = Troupe::new(device, 30, &Stage::new());
    for wanted in &film {
        // Its renderer is gone; the pages are still there to be written and read.
        troupe.update();
        troupe
            .crowd
            .with_page(0, &mut |page| assert!(page.iter().any(|e| e.0 != [0.0; 4])))
            .unwrap();
        let mut stage = Stage::new();
        assert_same(&stage.shoot(&mut troupe.crowd), wanted, "by a new renderer");
    }
}

pub(crate) fn a_renderer_outlives_a_crowd_at_work(device: &Devices) {
    let film = film_by_copy(device, 30, 3);
    let mut stage = Stage::new();
    for _ in 0..3 {
        let mut troupe = Troupe::new(device, 30, &stage);
        stage.link(&mut troupe.crowd);
        troupe.update();
        assert_same(&stage.shoot(&mut troupe.crowd), &film[0], "the first frame");
        let instances = stage.instances(&troupe.crowd);
        troupe.update();
        drop(troupe);
        assert_same(&stage.picture(&instances), &film[0], "after the crowd is gone");
    }
}

pub(crate) fn a_crowd_ends_on_another_thread(device: &Devices) {
    let mut stage = Stage::new();
    for renderer_first in [false, true] {
        let mut troupe = Troupe::new(device, 30, &stage);
        stage.link(&mut troupe.crowd);
        troupe.update();
        stage.shoot(&mut troupe.crowd);
        if renderer_first {
            stage = Stage::new();
        }
        let work = move || {
            troupe.update();
            troupe.update();
        };
        std::thread::spawn(work).join().unwrap();
        let mut next = Troupe::new(device, 30, &stage);
        next.update();
        stage.shoot(&mut next.crowd);
    }
}

pub(crate) fn two_crowds_take_turns_on_one_renderer(device: &Devices) {
    let films = [film_by_copy(device, 20, 4), film_by_copy(device, 35, 4)];
    let mut stage = Stage::new();
    let mut troupes = [20, 35].map(|members| Troupe::new(device, members, &stage));
    for frame in 0..4 {
        troupes.iter_mut().for_each(Troupe::update);
        for (troupe, film) in troupes.iter_mut().zip(&films) {
            assert_same(&stage.shoot(&mut troupe.crowd), &film[frame], &format!("frame {frame}"));
        }
    }
}

pub(crate) fn two_renderers_take_turns_on_one_crowd(device: &Devices) {
    let film = film_by_copy(device, 20, 4);
    let mut stages = [Stage::new(), Stage::new()];
    let mut troupe = Troupe::new(device, 20, &stages[0]);
    for wanted in &film {
        troupe.update();
        for stage in &mut stages {
            assert_same(&stage.shoot(&mut troupe.crowd), wanted, "by either");
        }
    }
}

#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn a_crowd_moves_to_another_device_under_way() {
    let film = film_by_copy(&Device::native().into(), 30, 4);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(&Device::native().into(), 30, &stage);
    stage.link(&mut troupe.crowd);
    for (wanted, device) in
        film.iter().zip([0, 1, 2, 3].map(|i| [Device::opencl(0), Device::native()][i % 2]))
    {
        troupe.update();
        assert_same(
            &stage.shoot(&mut troupe.crowd),
            wanted,
            &format!("before it moves to {device}"),
        );
        troupe.crowd.move_to(device).unwrap();
    }
}

/// A square on a joint that a clip lifts, with so many palette entries that a page holds two
/// members.
fn large() -> Character {
    let joint = JointSource { name: "base".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint]).unwrap();
    let track = Track {
        joint: "base".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    };
    let clip =
        Clip::new(ClipSource { name: "Rise".into(), tracks: vec![track] }, &skeleton).unwrap();
    let mesh = Mesh {
        positions: vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [-0.5, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences {
            per_vertex: 4,
            entries: [60_000, 0, 0, 0].repeat(4),
            weights: [1.0, 0.0, 0.0, 0.0].repeat(4),
        },
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    let part = Part { node: 0, node_name: "square".into(), primitive: 0, material: None, mesh };
    let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
    Character::new(CharacterSource {
        name: "large".into(),
        skeleton,
        palette: vec![entry; 400_000],
        parts: vec![part],
        materials: Vec::new(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: vec![clip.into()],
    })
    .unwrap()
}

pub(crate) fn palettes_on_the_second_page_are_drawn(device: &Devices) {
    let character = Arc::new(large());
    let film = |by_copy: bool| -> Vec<Image> {
        let mut stage = Stage::with(&[Arc::clone(&character)]);
        let mut crowd = Crowd::builder()
            .devices(device.clone())
            .for_gl(stage.renderer.gl_context())
            .build()
            .unwrap();
        let id = crowd.add_character(Arc::clone(&character)).unwrap();
        let rise = crowd.clip(id, "Rise").unwrap();
        let mut frames = Vec::new();
        for x in [-2.0, 0.0, 2.0] {
            let member = crowd.spawn(id, Placement::at([x, 0.0, -4.0])).unwrap();
            crowd.play(member, rise, Play::looping()).unwrap();
            crowd.update(0.2).unwrap();
            if by_copy {
                stage.renderer.take_palettes(&mut ByCopy(&mut crowd)).unwrap();
            } else {
                stage.renderer.take_palettes(&mut crowd).unwrap();
            }
            let instances = stage.instances(&crowd);
            frames.push(stage.picture(&instances));
        }
        assert_eq!(crowd.instances().last().unwrap().palette_first, PAGE_ENTRIES);
        frames
    };
    let (found, wanted) = (film(false), film(true));
    for (members, (found, wanted)) in (1..).zip(found.iter().zip(&wanted)) {
        assert_same(found, wanted, &format!("{members} members"));
    }
    assert!(wanted[1] != wanted[2], "the third member shows");
}
