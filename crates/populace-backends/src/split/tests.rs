use populace_native::NativeBackend;
use populace_testkit::conformance::check_same_frames;
use populace_testkit::{Broken, Corruption};

use super::*;

fn native(threads: usize, schedule: Schedule) -> Box<dyn Backend> {
    Box::new(NativeBackend::new(threads, schedule).unwrap())
}

/// A split over native devices of one thread each, with fixed shares.
fn natives(schedule: Schedule, shares: &[f64]) -> SplitBackend {
    let backends = shares.iter().map(|_| native(1, schedule)).collect();
    SplitBackend::new(backends, Some(shares.to_vec()))
}

/// Shares of native devices.
mod slow {
    use super::*;

    mod three_native_devices_staged {
        populace_testkit::backend_conformance!(
            super::natives(super::Schedule::Staged, &[0.2, 0.5, 0.3]),
            ignore = "make test-slow"
        );
    }

    mod first_native_device_has_all_members {
        populace_testkit::fused_conformance!(
            super::natives(super::Schedule::Fused, &[1.0, 0.0]),
            ignore = "make test-slow"
        );
    }

    mod first_and_last_native_device_have_no_members {
        populace_testkit::fused_conformance!(
            super::natives(super::Schedule::Fused, &[0.0, 0.7, 0.3, 0.0]),
            ignore = "make test-slow"
        );
    }
}

#[test]
fn several_native_devices_give_equal_frames() {
    for schedule in [Schedule::Staged, Schedule::Fused] {
        let mut whole = NativeBackend::new(2, schedule).unwrap();
        for shares in [&[0.5, 0.5][..], &[0.01, 0.98, 0.01], &[0.125; 8], &[0.0, 1.0]] {
            check_same_frames(&mut whole, &mut natives(schedule, shares));
        }
    }
}

#[test]
#[should_panic(expected = "off by")]
fn one_bit_of_difference_on_the_second_device_is_detected() {
    let wrong =
        Broken::new(NativeBackend::new(1, Schedule::Fused).unwrap(), Corruption::palette_bit());
    let mut split =
        SplitBackend::new(vec![native(1, Schedule::Fused), Box::new(wrong)], Some(vec![0.5, 0.5]));
    check_same_frames(&mut NativeBackend::new(2, Schedule::Fused).unwrap(), &mut split);
}

/// A device that is slow for a while has the least share of few members, and later more again.
#[test]
fn shares_of_few_members_follow_the_speeds() {
    let mut balance = Balance::new(3, None);
    let mut run = |ms_each: [f64; 3]| {
        for _ in 0..90 {
            let ends = balance.ends(100);
            let counts = [ends[0], ends[1] - ends[0], ends[2] - ends[1]];
            assert_eq!((ends[2], counts.contains(&0)), (100, false), "{ends:?}");
            let times = counts.iter().zip(ms_each).map(|(count, ms)| Some(*count as f64 * ms));
            balance.measured(counts.into_iter().zip(times.collect::<Vec<_>>()));
        }
        balance.shares().to_vec()
    };
    for (ms_each, wanted) in [
        ([300.0, 1.0, 1.0], [1.0 / 256.0, 0.5, 0.5]),
        ([1.0, 2.0, 300.0], [2.0 / 3.0, 1.0 / 3.0, 1.0 / 256.0]),
    ] {
        let shares = run(ms_each);
        for (share, wanted) in shares.iter().zip(wanted) {
            assert!((share - wanted).abs() < 5e-3, "{shares:?}");
        }
    }
}

#[test]
fn devices_without_a_share_or_a_member_for_each_have_none() {
    let fixed = Balance::new(3, Some(vec![0.0, 0.999, 0.001]));
    assert_eq!(fixed.ends(100), [0, 100, 100]);
    assert_eq!(Balance::new(4, None).ends(2), [1, 1, 2, 2]);
    assert_eq!(Balance::new(2, None).ends(0), [0, 0]);
}

#[cfg(feature = "opencl")]
mod with_opencl {
    use std::sync::{Arc, OnceLock};

    use populace_opencl::{DevicePart, OpenClBackend, OpenClDevice};

    use super::*;

    /// The whole device (0) or one of its halves (1, 2). All tests of a process share them.
    fn opencl(which: usize, schedule: Schedule) -> Box<dyn Backend> {
        static DEVICES: OnceLock<[Arc<OpenClDevice>; 3]> = OnceLock::new();
        let open = |which| match which {
            0 => OpenClDevice::open(0)
                .expect("an OpenCL device; set POPULACE_SKIP=opencl to go without"),
            part => OpenClDevice::open_part(0, DevicePart { part, parts: 2 })
                .expect("a device that can be partitioned"),
        };
        let devices = DEVICES.get_or_init(|| [0, 1, 2].map(open));
        Box::new(OpenClBackend::new(&devices[which], schedule).expect("a backend"))
    }

    fn native_and_opencl(schedule: Schedule, shares: Option<[f64; 2]>) -> SplitBackend {
        let backends = vec![native(1, schedule), opencl(0, schedule)];
        SplitBackend::new(backends, shares.map(|shares| shares.to_vec()))
    }

    fn halves(schedule: Schedule, shares: Option<[f64; 2]>) -> SplitBackend {
        let backends = vec![opencl(1, schedule), opencl(2, schedule)];
        SplitBackend::new(backends, shares.map(|shares| shares.to_vec()))
    }

    mod native_and_opencl_measured {
        populace_testkit::fused_conformance!(
            super::native_and_opencl(super::Schedule::Fused, None),
            cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
        );
    }

    /// More shares and schedules.
    #[cfg(not(skip_opencl))]
    mod slow {
        use super::*;

        mod native_and_opencl_staged {
            populace_testkit::backend_conformance!(
                super::native_and_opencl(super::Schedule::Staged, Some([0.4, 0.6])),
                ignore = "make test-slow"
            );
        }

        mod halves_of_an_opencl_device {
            populace_testkit::fused_conformance!(
                super::halves(super::Schedule::Fused, None),
                ignore = "make test-slow"
            );
        }

        mod opencl_has_all_members_and_native_the_palettes {
            populace_testkit::fused_conformance!(
                super::native_and_opencl(super::Schedule::Fused, Some([0.0, 1.0])),
                ignore = "make test-slow"
            );
        }
    }

    /// Tests run on PoCL, which gives the same bits as the native device.
    #[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
    #[test]
    fn every_split_gives_the_frames_of_one_device() {
        for schedule in [Schedule::Staged, Schedule::Fused] {
            let mut whole = NativeBackend::new(2, schedule).unwrap();
            for share in [0.0, 0.03, 0.5, 0.9, 1.0] {
                let shares = Some([share, 1.0 - share]);
                check_same_frames(&mut whole, &mut native_and_opencl(schedule, shares));
                check_same_frames(&mut whole, &mut halves(schedule, shares));
            }
        }
    }
}
