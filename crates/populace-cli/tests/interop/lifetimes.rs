//! Lifetimes: crowds and renderers are created and dropped in every order.

use std::sync::Arc;

use populace::character::{
    Character, CharacterSource, Image, Influences, Mesh, PaletteEntry, Part,
};
use populace::clip::Clip;
use populace::interop::PAGE_ENTRIES;
use populace::model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs,
};
use populace::{ClipPlayback, Crowd, Device, Devices, Placement};

use crate::assert_same;
use crate::fixture::{ByCopy, Kept, PeopleCrowd, RenderSession, pictures_by_copy};

pub(crate) fn crowd_outlives_its_renderer(device: &Devices) {
    let pictures = pictures_by_copy(device, 30, 4);
    let mut people = PeopleCrowd::new(device, 30, &RenderSession::new());
    for wanted in &pictures {
        // The renderer is gone, but the pages can still be written and read.
        people.update();
        people
            .crowd
            .with_page(0, &mut |page| assert!(page.iter().any(|e| e.0 != [0.0; 4])))
            .unwrap();
        let mut session = RenderSession::new();
        assert_same(&session.draw_crowd(&mut people.crowd), wanted, "by a new renderer");
    }
}

pub(crate) fn renderer_outlives_a_running_crowd(device: &Devices) {
    let pictures = pictures_by_copy(device, 30, 3);
    let mut session = RenderSession::new();
    for _ in 0..3 {
        let mut people = PeopleCrowd::new(device, 30, &session);
        session.link(&mut people.crowd);
        people.update();
        assert_same(&session.draw_crowd(&mut people.crowd), &pictures[0], "the first frame");
        let kept = Kept::of(&people.crowd);
        people.update();
        drop(people);
        assert_same(&session.picture(&kept.instances()), &pictures[0], "after the crowd is gone");
    }
}

pub(crate) fn crowd_can_be_dropped_on_another_thread(device: &Devices) {
    let mut session = RenderSession::new();
    for renderer_first in [false, true] {
        let mut people = PeopleCrowd::new(device, 30, &session);
        session.link(&mut people.crowd);
        people.update();
        session.draw_crowd(&mut people.crowd);
        if renderer_first {
            session = RenderSession::new();
        }
        let work = move || {
            people.update();
            people.update();
        };
        std::thread::spawn(work).join().unwrap();
        let mut next = PeopleCrowd::new(device, 30, &session);
        next.update();
        session.draw_crowd(&mut next.crowd);
    }
}

pub(crate) fn two_crowds_share_a_renderer(device: &Devices) {
    let expected = [pictures_by_copy(device, 20, 4), pictures_by_copy(device, 35, 4)];
    let mut session = RenderSession::new();
    let mut crowds = [20, 35].map(|members| PeopleCrowd::new(device, members, &session));
    for frame in 0..4 {
        crowds.iter_mut().for_each(PeopleCrowd::update);
        for (people, pictures) in crowds.iter_mut().zip(&expected) {
            assert_same(
                &session.draw_crowd(&mut people.crowd),
                &pictures[frame],
                &format!("frame {frame}"),
            );
        }
    }
}

pub(crate) fn two_renderers_share_a_crowd(device: &Devices) {
    let pictures = pictures_by_copy(device, 20, 4);
    let mut sessions = [RenderSession::new(), RenderSession::new()];
    let mut people = PeopleCrowd::new(device, 20, &sessions[0]);
    for wanted in &pictures {
        people.update();
        for session in &mut sessions {
            assert_same(&session.draw_crowd(&mut people.crowd), wanted, "by either renderer");
        }
    }
}

#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn connected_crowd_moves_to_another_device() {
    let pictures = pictures_by_copy(&Device::native().into(), 30, 4);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(&Device::native().into(), 30, &session);
    session.link(&mut people.crowd);
    for (wanted, device) in
        pictures.iter().zip([0, 1, 2, 3].map(|i| [Device::opencl(0), Device::native()][i % 2]))
    {
        people.update();
        assert_same(
            &session.draw_crowd(&mut people.crowd),
            wanted,
            &format!("before it moves to {device}"),
        );
        people.crowd.move_to(device).unwrap();
    }
}

/// Creates a square on a joint that a clip lifts. A page holds the palettes of two such members.
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

pub(crate) fn second_page_is_drawn(device: &Devices) {
    let character = Arc::new(large());
    let pictures = |by_copy: bool| -> Vec<Image> {
        let mut session = RenderSession::new();
        let mut crowd = Crowd::builder()
            .devices(device.clone())
            .for_gl(session.renderer.gl_context())
            .build()
            .unwrap();
        let id = crowd.add_character(Arc::clone(&character)).unwrap();
        let rise = crowd.clip(id, "Rise").unwrap();
        let mut frames = Vec::new();
        for x in [-2.0, 0.0, 2.0] {
            let member = crowd.spawn(id, Placement::at([x, 0.0, -4.0])).unwrap();
            crowd.member_mut(member).unwrap().play(rise, ClipPlayback::looping()).unwrap();
            crowd.update(0.2).unwrap();
            frames.push(match by_copy {
                true => session.draw_crowd(&mut ByCopy(&mut crowd)),
                false => session.draw_crowd(&mut crowd),
            });
        }
        assert_eq!(crowd.instances().last().unwrap().palette_first, PAGE_ENTRIES);
        frames
    };
    let (found, wanted) = (pictures(false), pictures(true));
    for (members, (found, wanted)) in (1..).zip(found.iter().zip(&wanted)) {
        assert_same(found, wanted, &format!("{members} members"));
    }
    assert!(wanted[1] != wanted[2], "the third member must be visible");
}
