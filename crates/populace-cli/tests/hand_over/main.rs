//! Tests of palettes that are written straight into OpenGL's memory, with crowds and renderers in
//! one process. Each picture must equal the picture by copies, byte for byte.
#![expect(clippy::unwrap_used, reason = "a failing step fails the test")]

mod loans;
mod stage;
mod times;

use populace::core::{Image, PaletteTransport};
use populace::{Device, Devices, Split};

use stage::{Stage, Troupe, film_by_copy};

fn assert_same(found: &Image, wanted: &Image, what: &str) {
    let different = found.rgba.iter().zip(&wanted.rgba).filter(|(a, b)| a != b).count();
    assert!(found == wanted, "{what}: {different} bytes differ");
}

fn frames_equal_those_by_copies(device: &Devices) {
    let film = film_by_copy(device, 60, 5);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 60, &stage);
    stage.link(&mut troupe.crowd);
    for (frame, wanted) in film.iter().enumerate() {
        troupe.update();
        assert_same(&stage.shoot(&mut troupe.crowd), wanted, &format!("frame {frame}"));
    }
}

/// The device computes frame N + 1 before OpenGL draws frame N, or before its picture is read.
fn drawing_overlaps_with_the_next_update(device: &Devices) {
    const FRAMES: usize = 6;
    let film = film_by_copy(device, 300, FRAMES);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 300, &stage);
    stage.link(&mut troupe.crowd);
    let instances = stage.instances(&troupe.crowd);
    troupe.update();
    for (frame, wanted) in film.iter().enumerate() {
        stage.renderer.take_palettes(&mut troupe.crowd).unwrap();
        let before = frame % 2 == 0;
        if before {
            troupe.update();
        }
        stage.draw(&instances);
        if !before {
            troupe.update();
        }
        let what =
            format!("frame {frame}, drawn {} the next", if before { "after" } else { "before" });
        assert_same(&stage.renderer.read_image().unwrap(), wanted, &what);
    }
}

/// Some frames are never acquired, and some are acquired several times.
fn updates_and_acquisitions_need_not_alternate(device: &Devices) {
    let film = film_by_copy(device, 40, 4);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 40, &stage);
    stage.link(&mut troupe.crowd);
    (0..3).for_each(|_| troupe.update());
    for _ in 0..3 {
        assert_same(&stage.shoot(&mut troupe.crowd), &film[2], "acquired again");
    }
    troupe.update();
    assert_same(&stage.shoot(&mut troupe.crowd), &film[3], "the next frame");
}

fn pages_grow_while_connected(device: &Devices) {
    let (mut stage, mut by_copy) = (Stage::new(), Stage::new());
    let [mut troupe, mut twin] = [&stage, &by_copy].map(|stage| Troupe::new(device, 10, stage));
    stage.link(&mut troupe.crowd);
    for more in [0, 3, 200, 1] {
        for troupe in [&mut troupe, &mut twin] {
            troupe.spawn(more);
            troupe.update();
        }
        let what = format!("{} members", troupe.crowd.member_count());
        assert_same(&stage.shoot(&mut troupe.crowd), &by_copy.shoot_by_copy(&mut twin), &what);
    }
}

/// An acquired frame can be drawn while the crowd outgrows its pages.
fn acquired_frame_survives_page_growth(device: &Devices) {
    let film = film_by_copy(device, 20, 1);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 20, &stage);
    stage.link(&mut troupe.crowd);
    troupe.update();
    stage.renderer.take_palettes(&mut troupe.crowd).unwrap();
    let instances = stage.instances(&troupe.crowd);
    troupe.spawn(500);
    troupe.update();
    assert_same(&stage.picture(&instances), &film[0], "20 members");
}

fn palettes_can_be_read_back_from_any_memory(device: &Devices) {
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 30, &stage);
    let mut twin = Troupe::new(device, 30, &stage);
    let same = |troupe: &mut Troupe, twin: &mut Troupe, when: &str| {
        let (mut pages, mut wanted) = (Vec::new(), Vec::new());
        troupe.crowd.with_page(0, &mut |page| pages = page.to_vec()).unwrap();
        twin.crowd.with_page(0, &mut |page| wanted = page.to_vec()).unwrap();
        let [a, b] =
            [&*troupe, &*twin].map(|t| t.crowd.instances().map(|i| i.member).collect::<Vec<_>>());
        for (i, (a, b)) in a.into_iter().zip(b).enumerate() {
            let (a, b) = (troupe.crowd.palette(a).unwrap(), twin.crowd.palette(b).unwrap());
            assert!(a == b, "{when}: member {i}");
        }
        assert!(
            pages.len() == wanted.len(),
            "{when}: {} and {} elements",
            pages.len(),
            wanted.len()
        );
    };
    [&mut troupe, &mut twin].into_iter().for_each(Troupe::update);
    stage.link(&mut troupe.crowd);
    same(&mut troupe, &mut twin, "once connected");
    for _ in 0..3 {
        [&mut troupe, &mut twin].into_iter().for_each(Troupe::update);
        same(&mut troupe, &mut twin, "before acquisition");
        stage.shoot(&mut troupe.crowd);
        same(&mut troupe, &mut twin, "after acquisition");
    }
    stage.renderer.take_palettes(&mut troupe.by_copy()).unwrap();
    same(&mut troupe, &mut twin, "still connected");
    stage.renderer.link_palettes(&mut troupe.by_copy()).unwrap();
    same(&mut troupe, &mut twin, "back in the device's own memory");
}

fn transport_is_reported_with_reasons(device: &Devices) {
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 1, &stage);
    let hand_over = stage.link(&mut troupe.crowd);
    if hand_over.way == PaletteTransport::Mapped {
        let native = device.as_slice()[0] == Device::native();
        let reason = if native {
            "it takes an OpenCL device"
        } else {
            "its driver does not offer cl_khr_gl_sharing"
        };
        assert_eq!(hand_over.refused, [(PaletteTransport::Shared, reason.to_owned())]);
        assert!(hand_over.to_string().contains(reason), "{hand_over}");
    } else {
        assert_eq!(hand_over.refused, [], "sharing is the best transport");
    }
    let copied = stage.renderer.link_palettes(&mut troupe.by_copy()).unwrap();
    assert_eq!((copied.way, copied.refused.len()), (PaletteTransport::Copied, 2));
}

/// The picture does not depend on the shares of devices, or on the device connected to OpenGL.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn split_crowd_draws_the_same_pictures() {
    let film = film_by_copy(&Device::native().into(), 60, 8);
    let halves = [1, 2].map(|part| Device::opencl_part(0, part, 2));
    let [native, opencl] = [Device::native(), Device::opencl(0)];
    for devices in [[native, opencl], [opencl, native], halves].map(Devices::from) {
        let mut stage = Stage::new();
        let mut troupe = Troupe::new(&devices, 60, &stage);
        stage.link(&mut troupe.crowd);
        for (frame, wanted) in film.iter().enumerate() {
            let parts = [[1.0, 0.0], [0.0, 1.0], [0.3, 0.7]].get(frame % 4);
            let split = parts.map_or(Split::Measured, |parts| Split::Fixed(parts.to_vec()));
            troupe.crowd.set_split(&split).unwrap();
            troupe.update();
            assert_same(
                &stage.shoot(&mut troupe.crowd),
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
    let film = film_by_copy(&threads(1).into(), 40, 4);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(&[threads(1), threads(2)].into(), 40, &stage);
    troupe.crowd.set_split(&Split::Fixed(vec![0.0, 1.0])).unwrap();
    stage.link(&mut troupe.crowd);
    let instances = stage.instances(&troupe.crowd);
    troupe.update();
    for (frame, wanted) in film.iter().enumerate() {
        stage.renderer.take_palettes(&mut troupe.crowd).unwrap();
        troupe.update();
        troupe.crowd.with_page(0, &mut |_| ()).unwrap();
        assert_same(&stage.picture(&instances), wanted, &format!("frame {frame}"));
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
    crate::loans::crowd_outlives_its_renderer as crowd_outlives_its_renderer,
    crate::loans::renderer_outlives_a_running_crowd as renderer_outlives_a_running_crowd,
    crate::loans::crowd_can_be_dropped_on_another_thread as crowd_can_be_dropped_on_another_thread,
    crate::loans::two_crowds_share_a_renderer as two_crowds_share_a_renderer,
    crate::loans::two_renderers_share_a_crowd as two_renderers_share_a_crowd,
    crate::loans::second_page_is_drawn as second_page_is_drawn,
);
