//! Playback on every device and schedule: layers, fades, queues, speeds, blend spaces.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::disallowed_methods,
    reason = "device and oracle get the same rounded input"
)]

mod crowds;
mod fixture;
mod inertialize;
mod layers;
mod roles;
mod slots;
mod space_oracle;
mod spaces;
mod timing;

/// Makes a test for each device and schedule out of each given function of a crowd builder.
macro_rules! on_every_device {
    ($($test:ident),* $(,)?) => {
        on_every_device! { @mode native_staged, native, Staged, $($test)* }
        on_every_device! { @mode native_fused, native, Fused, $($test)* }
        on_every_device! { @mode opencl_staged, opencl, Staged, $($test)* }
        on_every_device! { @mode opencl_fused_wide, opencl, FusedWide, $($test)* }
        on_every_device! { @mode opencl_fused_grouped, opencl, FusedGrouped, $($test)* }
    };
    (@mode $mode:ident, native, $schedule:ident, $($test:ident)*) => {
        mod $mode {
            $(#[test] fn $test() {
                let builder = populace::Crowd::builder().device(populace::Device::native());
                super::$test(&builder.schedule(populace::Schedule::$schedule));
            })*
        }
    };
    (@mode $mode:ident, opencl, $schedule:ident, $($test:ident)*) => {
        mod $mode {
            $(
                #[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
                #[test]
                fn $test() {
                    let builder = populace::Crowd::builder().device(populace::Device::opencl(0));
                    super::$test(&builder.schedule(populace::Schedule::$schedule));
                }
            )*
        }
    };
}
pub(crate) use on_every_device;
