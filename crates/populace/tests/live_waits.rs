//! Poses that come in while they play never make the host wait for the device. Alone in its
//! process: waits are counted over all devices of one.
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    clippy::disallowed_methods,
    dead_code,
    reason = "a test that cannot go on fails; bodies are shared with others"
)]

#[path = "controls/body.rs"]
mod body;

use body::{skeleton, stage};
use populace::{ClipPlayback, Device, LiveSettings, Placement, Schedule};

fn frames(stage: &mut body::Stage) {
    let settings = LiveSettings { rows_per_sec: 120.0, secs: 0.2, ..LiveSettings::default() };
    let live = stage.crowd.add_live_clip(stage.body, "actor", &settings).expect("a live clip");
    for nth in 0..20_u8 {
        let member = stage.member(Placement::at([f32::from(nth), 0.0, 0.0]));
        stage
            .crowd
            .member_mut(member)
            .expect("a live clip")
            .play(live, ClipPlayback::live(f32::from(nth) * 0.01))
            .expect("a live clip");
    }
    let mut pose: Vec<_> = skeleton().joints().map(|joint| *skeleton().rest(joint)).collect();
    let mut waited = 0;
    for frame in 0..120_u32 {
        if frame == 10 {
            waited = stage.crowd.host_waits();
        }
        for half in [0.0, 0.5] {
            pose[1].translation[1] += 0.001;
            stage.crowd.append(live, (f64::from(frame) + half) / 60.0, &pose).expect("a pose");
        }
        stage.update(1.0 / 60.0);
        // A host that runs many frames ahead of the device waits for it, with or without poses.
        std::thread::sleep(std::time::Duration::from_millis(6));
    }
    assert_eq!(stage.crowd.host_waits(), waited, "{:?}: the host waited", stage.crowd.schedule());
    stage.crowd.finish().expect("a device");
    let opencl = stage.crowd.device_name().starts_with("OpenCL");
    assert_eq!(stage.crowd.host_waits(), waited + u64::from(opencl), "an explicit wait is counted");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn no_pose_that_comes_in_waits_for_the_device() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        frames(&mut stage(Device::opencl(0), schedule));
    }
    frames(&mut stage(Device::native(), Schedule::Fused));
}
