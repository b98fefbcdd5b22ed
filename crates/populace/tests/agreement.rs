//! The native device and OpenCL on the same input.
#![cfg(feature = "opencl")]

use populace_native::NativeBackend;
use populace_opencl::{OpenClBackend, OpenClDevice};
use populace_testkit::conformance::check_agreement;
use populace_testkit::{Broken, Corruption};

fn opencl() -> OpenClBackend {
    let device = OpenClDevice::open(0).expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
    OpenClBackend::new(&device).expect("a backend")
}

/// Bit for bit where `+ - *` and copies decide, within a derived bound elsewhere.
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn native_and_opencl_agree() {
    check_agreement(&mut NativeBackend::new(3).expect("threads"), &mut opencl());
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
#[should_panic(expected = "off by")]
fn a_bit_of_difference_is_found() {
    let native = NativeBackend::new(3).expect("threads");
    check_agreement(&mut Broken::new(native, Corruption::palette_bit()), &mut opencl());
}
