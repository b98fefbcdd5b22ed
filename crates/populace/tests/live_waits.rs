//! Poses appended to a playing live clip never make the host wait for the device. The test has a
//! process of its own, because waits are counted over all devices of a process.
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    clippy::disallowed_methods,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]

#[path = "controls/fixture.rs"]
mod fixture;

use fixture::{scene, skeleton};
use populace::{ClipPlayback, Device, LiveSettings, Placement, Schedule};

fn assert_no_waits(scene: &mut fixture::Scene) {
    let settings = LiveSettings { rows_per_sec: 120.0, secs: 0.2, ..LiveSettings::default() };
    let live = scene
        .crowd
        .character_mut(scene.body)
        .expect("a live clip")
        .add_live_clip("actor", &settings)
        .expect("a live clip");
    for nth in 0..20_u8 {
        let member = scene.member(Placement::at([f32::from(nth), 0.0, 0.0]));
        scene
            .edit(member)
            .play(live, ClipPlayback::live(f32::from(nth) * 0.01))
            .expect("a live clip");
    }
    let mut pose: Vec<_> = skeleton().joints().map(|joint| *skeleton().rest(joint)).collect();
    let mut waits = 0;
    for frame in 0..120_u32 {
        if frame == 10 {
            waits = scene.crowd.device_info().host_waits;
        }
        for half in [0.0, 0.5] {
            pose[1].translation[1] += 0.001;
            scene
                .crowd
                .clip_mut(live)
                .expect("a pose")
                .append((f64::from(frame) + half) / 60.0, &pose)
                .expect("a pose");
        }
        scene.update(1.0 / 60.0);
        // Slow down: a host many frames ahead of the device waits for it even without live poses.
        std::thread::sleep(std::time::Duration::from_millis(6));
    }
    assert_eq!(
        scene.crowd.device_info().host_waits,
        waits,
        "{:?}: the host waited",
        scene.crowd.device_info().schedule
    );
    scene.crowd.finish().expect("a device");
    let opencl = scene.crowd.device_info().name.starts_with("OpenCL");
    assert_eq!(
        scene.crowd.device_info().host_waits,
        waits + u64::from(opencl),
        "an explicit wait was not counted"
    );
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn appended_poses_never_wait_for_the_device() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        assert_no_waits(&mut scene(Device::opencl(0), schedule));
    }
    assert_no_waits(&mut scene(Device::native(), Schedule::Fused));
}
