//! What members play, on every device and schedule: layers, fades, queues, speeds, blend spaces.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::disallowed_methods,
    reason = "scenes may be rounded as they come: each is made once for the device and for what \
              judges it"
)]

mod crowds;
mod inertialize;
mod layers;
mod rig;
mod room;
mod spaces;
mod timing;

/// Makes of each test, which takes a builder, one for each device and schedule.
macro_rules! on_every_way {
    ($($test:ident),* $(,)?) => {
        on_every_way! { @way native_staged, native, Staged, $($test)* }
        on_every_way! { @way native_fused, native, Fused, $($test)* }
        on_every_way! { @way opencl_staged, opencl, Staged, $($test)* }
        on_every_way! { @way opencl_fused_wide, opencl, FusedWide, $($test)* }
        on_every_way! { @way opencl_fused_grouped, opencl, FusedGrouped, $($test)* }
    };
    (@way $way:ident, native, $schedule:ident, $($test:ident)*) => {
        mod $way {
            $(#[test] fn $test() {
                let device = populace::Device::native();
                super::$test(&populace::Crowd::builder().device(device).schedule(populace::Schedule::$schedule));
            })*
        }
    };
    (@way $way:ident, opencl, $schedule:ident, $($test:ident)*) => {
        mod $way {
            $(
                #[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
                #[test]
                fn $test() {
                    let device = populace::Device::opencl(0);
                    super::$test(&populace::Crowd::builder().device(device).schedule(populace::Schedule::$schedule));
                }
            )*
        }
    };
}
pub(crate) use on_every_way;
