//! Devices and schedules agree on the same input.
#![cfg(feature = "opencl")]

use populace_device::Schedule::{self, Fused, FusedGrouped, FusedWide, Staged};
use populace_native::NativeBackend;
use populace_opencl::{OpenClBackend, OpenClDevice};
use populace_testkit::conformance::{check_agreement, check_same_frames};
use populace_testkit::{Broken, Corruption};

fn opencl(schedule: Schedule) -> OpenClBackend {
    let device =
        OpenClDevice::open(0).expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
    OpenClBackend::new(&device, schedule).expect("a backend")
}

fn native(schedule: Schedule) -> NativeBackend {
    NativeBackend::new(3, schedule).expect("threads")
}

/// Results of `+`, `-`, `*` and copies are equal bit for bit; others agree within a derived bound.
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn native_and_opencl_agree() {
    check_agreement(&mut native(Staged), &mut opencl(Staged));
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
#[should_panic(expected = "off by")]
fn one_bit_of_difference_is_detected() {
    check_agreement(
        &mut Broken::new(native(Staged), Corruption::palette_bit()),
        &mut opencl(Staged),
    );
}

/// Tests run on PoCL, which rounds quotients correctly.
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn native_and_opencl_schedules_give_equal_frames() {
    check_same_frames(&mut native(Staged), &mut native(Fused));
    check_same_frames(&mut native(Staged), &mut opencl(Staged));
    check_same_frames(&mut native(Staged), &mut opencl(FusedWide));
    check_same_frames(&mut native(Staged), &mut opencl(FusedGrouped));
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
#[should_panic(expected = "off by")]
fn one_bit_of_difference_in_a_frame_is_detected() {
    let mut broken = Broken::new(opencl(FusedWide), Corruption::palette_bit());
    check_same_frames(&mut native(Staged), &mut broken);
}
