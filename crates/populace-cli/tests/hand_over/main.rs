//! Palettes written straight into OpenGL's memory, seen from both sides: crowds and renderers in
//! one process. Each picture is held against the one by copies, byte for byte.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod loans;
mod stage;
mod times;

use populace::character::Image;
use populace::hand_over::PaletteTransport;
use populace::{Device, Devices, Split};

use stage::{Stage, Troupe, film_by_copy};

fn assert_same(found: &Image, wanted: &Image, what: &str) {
    let different = found.rgba.iter().zip(&wanted.rgba).filter(|(a, b)| a != b).count();
    assert!(found == wanted, "{what}: {different} bytes differ");
}

fn every_frame_is_the_one_by_copies(device: &Devices) {
    let film = film_by_copy(device, 60, 5);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 60, &stage);
    stage.link(&mut troupe.crowd);
    for (frame, wanted) in film.iter().enumerate() {
        troupe.update();
        assert_same(&stage.shoot(&mut troupe.crowd), wanted, &format!("frame {frame}"));
    }
}

/// The device works on frame N + 1 before OpenGL is told to draw frame N, and again before its
/// picture is read.
fn frames_are_drawn_while_the_next_ones_are_computed(device: &Devices) {
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

/// Frames that nobody takes, and takes without a frame.
fn frames_and_takes_need_not_alternate(device: &Devices) {
    let film = film_by_copy(device, 40, 4);
    let mut stage = Stage::new();
    let mut troupe = Troupe::new(device, 40, &stage);
    stage.link(&mut troupe.crowd);
    (0..3).for_each(|_| troupe.update());
    for _ in 0..3 {
        assert_same(&stage.shoot(&mut troupe.crowd), &film[2], "taken again");
    }
    troupe.update();
    assert_same(&stage.shoot(&mut troupe.crowd), &film[3], "the next");
}

fn a_page_grows_under_way(device: &Devices) {
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

/// What was taken stays to be drawn while the crowd outgrows it.
fn a_frame_outlives_the_pages_it_was_written_into(device: &Devices) {
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

fn palettes_read_back_wherever_they_stand(device: &Devices) {
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
    same(&mut troupe, &mut twin, "once linked");
    for _ in 0..3 {
        [&mut troupe, &mut twin].into_iter().for_each(Troupe::update);
        same(&mut troupe, &mut twin, "before it is taken");
        stage.shoot(&mut troupe.crowd);
        same(&mut troupe, &mut twin, "once it is taken");
    }
    stage.renderer.take_palettes(&mut troupe.by_copy()).unwrap();
    same(&mut troupe, &mut twin, "still linked");
    stage.renderer.link_palettes(&mut troupe.by_copy()).unwrap();
    same(&mut troupe, &mut twin, "back in the device's own memory");
}

fn the_way_and_the_reason_are_told(device: &Devices) {
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
        assert_eq!(hand_over.refused, [], "nothing is better than sharing");
    }
    let copied = stage.renderer.link_palettes(&mut troupe.by_copy()).unwrap();
    assert_eq!((copied.way, copied.refused.len()), (PaletteTransport::Copied, 2));
}

/// Whoever has the members, and whoever OpenGL is linked to.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn a_split_crowd_looks_like_an_undivided_one() {
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

/// The first device has no member, but the pages that OpenGL draws from.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn what_is_drawn_stays_as_it_is_while_others_palettes_come() {
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
                fn $name() { $test(&[populace::Device::native(), populace::Device::opencl(0)].into()); }
            )*
        }
        mod opencl_and_native {
            $(
                #[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
                #[test]
                fn $name() { $test(&[populace::Device::opencl(0), populace::Device::native()].into()); }
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
    crate::every_frame_is_the_one_by_copies as every_frame_is_the_one_by_copies,
    crate::frames_are_drawn_while_the_next_ones_are_computed
        as frames_are_drawn_while_the_next_ones_are_computed,
    crate::frames_and_takes_need_not_alternate as frames_and_takes_need_not_alternate,
    crate::a_page_grows_under_way as a_page_grows_under_way,
    crate::a_frame_outlives_the_pages_it_was_written_into
        as a_frame_outlives_the_pages_it_was_written_into,
    crate::palettes_read_back_wherever_they_stand as palettes_read_back_wherever_they_stand,
    crate::the_way_and_the_reason_are_told as the_way_and_the_reason_are_told,
    crate::loans::a_crowd_outlives_its_renderer as a_crowd_outlives_its_renderer,
    crate::loans::a_renderer_outlives_a_crowd_at_work as a_renderer_outlives_a_crowd_at_work,
    crate::loans::a_crowd_ends_on_another_thread as a_crowd_ends_on_another_thread,
    crate::loans::two_crowds_take_turns_on_one_renderer as two_crowds_take_turns_on_one_renderer,
    crate::loans::two_renderers_take_turns_on_one_crowd as two_renderers_take_turns_on_one_crowd,
    crate::loans::palettes_on_the_second_page_are_drawn as palettes_on_the_second_page_are_drawn,
);
