//! The conformance suite on the native backend. Built apart from the crate's unit tests, which would
//! compile all stages a second time.
#![allow(clippy::unwrap_used, reason = "a backend that cannot be made fails the test")]

use populace_device::layout::Float4;
use populace_device::{Backend, Schedule, StageBuffer, Tables};
use populace_native::{Machine, NativeBackend, RegisterLanes};

fn staged(threads: usize) -> NativeBackend {
    NativeBackend::new(threads, Schedule::Staged).unwrap()
}

fn fused(threads: usize, machine: Machine) -> NativeBackend {
    NativeBackend::on(machine, threads, Schedule::Fused).unwrap()
}

mod conformance {
    populace_testkit::backend_conformance!(super::staged(3));
}

mod broken {
    populace_testkit::broken_conformance!(super::staged(3));
}

mod conformance_fused {
    populace_testkit::fused_conformance!(super::fused(3, super::Machine::detect()));
}

/// More numbers of threads, and narrower registers.
mod slow {
    use super::*;

    mod conformance_on_1_thread {
        populace_testkit::backend_conformance!(super::staged(1), ignore = "make test-slow");
    }

    mod conformance_fused_on_16_threads {
        populace_testkit::fused_conformance!(
            super::fused(16, super::Machine::detect()),
            ignore = "make test-slow"
        );
    }

    mod conformance_fused_of_4_lanes {
        populace_testkit::fused_conformance!(
            super::fused(1, super::Machine::at_most(super::RegisterLanes::Four)),
            ignore = "make test-slow"
        );
    }

    mod conformance_fused_of_8_lanes {
        populace_testkit::fused_conformance!(
            super::fused(1, super::Machine::at_most(super::RegisterLanes::Eight)),
            ignore = "make test-slow"
        );
    }
}

#[test]
fn reads_and_writes_past_the_end_are_errors() {
    let mut backend = staged(1);
    let mut into = [Float4::default()];
    assert!(backend.read(&Tables::new(1), StageBuffer::Palette, 0, &mut into).is_err());
    assert!(backend.write(StageBuffer::Scales, 9, &[Float4::default()]).is_err());
}
