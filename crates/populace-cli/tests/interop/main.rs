//! Tests of palettes that are written straight into OpenGL's memory, with crowds and renderers in
//! one process. Each picture must equal the picture by copies, byte for byte.
#![expect(clippy::unwrap_used, reason = "a failing step fails the test")]

mod fixture;
mod lifetimes;
mod times;

use populace::character::Image;
use populace::interop::PaletteTransport;
use populace::{Device, Devices, Split};

use fixture::{Kept, PeopleCrowd, RenderSession, pictures_by_copy};

fn assert_same(found: &Image, wanted: &Image, what: &str) {
    let different = found.rgba.iter().zip(&wanted.rgba).filter(|(a, b)| a != b).count();
    assert!(found == wanted, "{what}: {different} bytes differ");
}

fn frames_equal_those_by_copies(device: &Devices) {
    let pictures = pictures_by_copy(device, 60, 5);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 60, &session);
    session.link(&mut people.crowd);
    for (frame, wanted) in pictures.iter().enumerate() {
        people.update();
        assert_same(&session.draw_crowd(&mut people.crowd), wanted, &format!("frame {frame}"));
    }
}

/// The device computes frame N + 1 before OpenGL draws frame N, or before its picture is read.
fn drawing_overlaps_with_the_next_update(device: &Devices) {
    const FRAMES: usize = 6;
    let pictures = pictures_by_copy(device, 300, FRAMES);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 300, &session);
    session.link(&mut people.crowd);
    let kept = Kept::of(&people.crowd);
    people.update();
    for (frame, wanted) in pictures.iter().enumerate() {
        session.renderer.acquire_palettes(&mut people.crowd).unwrap();
        let before = frame % 2 == 0;
        if before {
            people.update();
        }
        session.draw(&kept.instances());
        if !before {
            people.update();
        }
        let what =
            format!("frame {frame}, drawn {} the next", if before { "after" } else { "before" });
        assert_same(&session.renderer.read_image().unwrap(), wanted, &what);
    }
}

/// Some frames are never acquired, and some are acquired several times.
fn updates_and_acquisitions_need_not_alternate(device: &Devices) {
    let pictures = pictures_by_copy(device, 40, 4);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 40, &session);
    session.link(&mut people.crowd);
    (0..3).for_each(|_| people.update());
    for _ in 0..3 {
        assert_same(&session.draw_crowd(&mut people.crowd), &pictures[2], "acquired again");
    }
    people.update();
    assert_same(&session.draw_crowd(&mut people.crowd), &pictures[3], "the next frame");
}

fn pages_grow_while_connected(device: &Devices) {
    let (mut session, mut by_copy) = (RenderSession::new(), RenderSession::new());
    let [mut people, mut twin] =
        [&session, &by_copy].map(|session| PeopleCrowd::new(device, 10, session));
    session.link(&mut people.crowd);
    for more in [0, 3, 200, 1] {
        for people in [&mut people, &mut twin] {
            people.spawn(more);
            people.update();
        }
        let what = format!("{} members", people.crowd.member_count());
        assert_same(
            &session.draw_crowd(&mut people.crowd),
            &by_copy.draw_crowd(&mut twin.by_copy()),
            &what,
        );
    }
}

/// An acquired frame can be drawn while the crowd outgrows its pages.
fn acquired_frame_survives_page_growth(device: &Devices) {
    let pictures = pictures_by_copy(device, 20, 1);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 20, &session);
    session.link(&mut people.crowd);
    people.update();
    session.renderer.acquire_palettes(&mut people.crowd).unwrap();
    let kept = Kept::of(&people.crowd);
    people.spawn(500);
    people.update();
    assert_same(&session.picture(&kept.instances()), &pictures[0], "20 members");
}

fn palettes_can_be_read_back_from_any_memory(device: &Devices) {
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 30, &session);
    let mut twin = PeopleCrowd::new(device, 30, &session);
    let same = |people: &mut PeopleCrowd, twin: &mut PeopleCrowd, when: &str| {
        let (mut pages, mut wanted) = (Vec::new(), Vec::new());
        people.crowd.with_page(0, &mut |page| pages = page.to_vec()).unwrap();
        twin.crowd.with_page(0, &mut |page| wanted = page.to_vec()).unwrap();
        let [a, b] =
            [&*people, &*twin].map(|t| t.crowd.members().map(|m| m.id()).collect::<Vec<_>>());
        for (i, (a, b)) in a.into_iter().zip(b).enumerate() {
            let (a, b) = (
                people.crowd.member_mut(a).unwrap().palette().unwrap(),
                twin.crowd.member_mut(b).unwrap().palette().unwrap(),
            );
            assert!(a == b, "{when}: member {i}");
        }
        assert!(
            pages.len() == wanted.len(),
            "{when}: {} and {} elements",
            pages.len(),
            wanted.len()
        );
    };
    [&mut people, &mut twin].into_iter().for_each(PeopleCrowd::update);
    session.link(&mut people.crowd);
    same(&mut people, &mut twin, "once connected");
    for _ in 0..3 {
        [&mut people, &mut twin].into_iter().for_each(PeopleCrowd::update);
        same(&mut people, &mut twin, "before acquisition");
        session.draw_crowd(&mut people.crowd);
        same(&mut people, &mut twin, "after acquisition");
    }
    session.renderer.acquire_palettes(&mut people.by_copy()).unwrap();
    same(&mut people, &mut twin, "still connected");
    session.renderer.connect_palettes(&mut people.by_copy()).unwrap();
    same(&mut people, &mut twin, "back in the device's own memory");
}

fn transport_is_reported_with_reasons(device: &Devices) {
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, 1, &session);
    let interop = session.link(&mut people.crowd);
    if interop.transport == PaletteTransport::Mapped {
        let native = device.as_slice()[0] == Device::native();
        let reason = if native {
            "it needs an OpenCL device"
        } else {
            "its driver does not offer cl_khr_gl_sharing"
        };
        assert_eq!(interop.refused, [(PaletteTransport::Shared, reason.to_owned())]);
        assert!(interop.to_string().contains(reason), "{interop}");
    } else {
        assert_eq!(interop.refused, [], "sharing is the best transport");
    }
    let copied = session.renderer.connect_palettes(&mut people.by_copy()).unwrap();
    assert_eq!((copied.transport, copied.refused.len()), (PaletteTransport::Copied, 2));
}

/// The picture does not depend on the shares of devices, or on the device connected to OpenGL.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn split_crowd_draws_the_same_pictures() {
    let pictures = pictures_by_copy(&Device::native().into(), 60, 8);
    let halves = [1, 2].map(|part| Device::opencl_part(0, part, 2));
    let [native, opencl] = [Device::native(), Device::opencl(0)];
    for devices in [[native, opencl], [opencl, native], halves].map(Devices::from) {
        let mut session = RenderSession::new();
        let mut people = PeopleCrowd::new(&devices, 60, &session);
        session.link(&mut people.crowd);
        for (frame, wanted) in pictures.iter().enumerate() {
            let parts = [[1.0, 0.0], [0.0, 1.0], [0.3, 0.7]].get(frame % 4);
            let split = parts.map_or(Split::Measured, |parts| Split::Fixed(parts.to_vec()));
            people.crowd.set_split(&split).unwrap();
            people.update();
            assert_same(
                &session.draw_crowd(&mut people.crowd),
                wanted,
                &format!("{devices}, {split}, frame {frame}"),
            );
        }
    }
}

/// The first device has no members, but holds the pages that OpenGL draws from.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn acquired_frame_is_unaffected_by_other_devices() {
    let threads = |threads| Device::Native { threads };
    let pictures = pictures_by_copy(&threads(1).into(), 40, 4);
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(&[threads(1), threads(2)].into(), 40, &session);
    people.crowd.set_split(&Split::Fixed(vec![0.0, 1.0])).unwrap();
    session.link(&mut people.crowd);
    let kept = Kept::of(&people.crowd);
    people.update();
    for (frame, wanted) in pictures.iter().enumerate() {
        session.renderer.acquire_palettes(&mut people.crowd).unwrap();
        people.update();
        people.crowd.with_page(0, &mut |_| ()).unwrap();
        assert_same(&session.picture(&kept.instances()), wanted, &format!("frame {frame}"));
    }
}

macro_rules! on_devices {
    ($($test:path as $name:ident),* $(,)?) => {
        mod native {
            $(
                #[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
                #[test]
                fn $name() { $test(&populace::Device::native().into()); }
            )*
        }
        mod native_and_opencl {
            $(
                #[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
                #[test]
                fn $name() {
                    $test(&[populace::Device::native(), populace::Device::opencl(0)].into());
                }
            )*
        }
        mod opencl_and_native {
            $(
                #[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
                #[test]
                fn $name() {
                    $test(&[populace::Device::opencl(0), populace::Device::native()].into());
                }
            )*
        }
        mod opencl {
            $(
                #[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
                #[test]
                fn $name() { $test(&populace::Device::opencl(0).into()); }
            )*
        }
    };
}
on_devices!(
    crate::frames_equal_those_by_copies as frames_equal_those_by_copies,
    crate::drawing_overlaps_with_the_next_update as drawing_overlaps_with_the_next_update,
    crate::updates_and_acquisitions_need_not_alternate
        as updates_and_acquisitions_need_not_alternate,
    crate::pages_grow_while_connected as pages_grow_while_connected,
    crate::acquired_frame_survives_page_growth as acquired_frame_survives_page_growth,
    crate::palettes_can_be_read_back_from_any_memory as palettes_can_be_read_back_from_any_memory,
    crate::transport_is_reported_with_reasons as transport_is_reported_with_reasons,
    crate::lifetimes::crowd_outlives_its_renderer as crowd_outlives_its_renderer,
    crate::lifetimes::renderer_outlives_a_running_crowd as renderer_outlives_a_running_crowd,
    crate::lifetimes::crowd_can_be_dropped_on_another_thread
        as crowd_can_be_dropped_on_another_thread,
    crate::lifetimes::two_crowds_share_a_renderer as two_crowds_share_a_renderer,
    crate::lifetimes::two_renderers_share_a_crowd as two_renderers_share_a_crowd,
    crate::lifetimes::second_page_is_drawn as second_page_is_drawn,
);
