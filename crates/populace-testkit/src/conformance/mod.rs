//! The conformance suite: checks that every device and schedule must pass, and must fail if a
//! number is [`Broken`](crate::Broken).
//!
//! A failing check panics with the member, joint and number, and its error.
//! [`backend_conformance!`](crate::backend_conformance) expands to one test per check.

mod agreement;
mod blend;
mod clock;
mod controls;
mod feet;
mod inertialize;
mod layers;
mod live;
mod machines;
mod mixed;
mod plans;
mod retarget;
mod running;
mod sampling;
mod stages;

pub use agreement::{check_agreement, check_same_frames};
pub use blend::{check_blends, check_slot_order, check_small_totals, check_zero_weights};
pub use clock::{check_clock, check_weights};
pub use controls::{
    check_attachments, check_chains, check_gaze, check_limbs, check_motion_of_others,
    check_motion_transitions, check_overrides, check_root_motion, check_user_stages,
};
pub use feet::check_feet;
pub use inertialize::check_inertialization;
pub use layers::{check_additive_layers, check_far_rotations, check_override_layers};
pub use live::check_live_clips;
pub use machines::check_machines;
pub use mixed::{check_churn, check_mixed_dispatch};
pub use retarget::{check_retarget, check_retarget_between_keys};
pub use running::{check_growth, check_long_run};
pub use sampling::{
    check_sampling_at_keys, check_sampling_between_keys, check_sampling_within_clip_bounds,
};
pub use stages::{check_pages, check_transform_alone, check_write_back_alone};

/// Expands to one `#[test]` per check of the conformance suite, on a staged backend.
///
/// The first argument is an expression that creates the backend; it is evaluated at least once per
/// test. Further arguments, such as `cfg_attr(no_device, ignore = "why")`, become attributes of all
/// tests.
#[macro_export]
macro_rules! backend_conformance {
    ($backend:expr $(, $attribute:meta)* $(,)?) => {
        $crate::conformance_checks! { holds [$($attribute),*] $backend }
        $crate::conformance_checks_of_stages! { holds [$($attribute),*] $backend }
    };
}

/// Expands to the tests of [`backend_conformance!`](crate::backend_conformance) for a backend with
/// a fused schedule: all checks except those that run one stage alone.
#[macro_export]
macro_rules! fused_conformance {
    ($backend:expr $(, $attribute:meta)* $(,)?) => {
        $crate::conformance_checks! { holds [$($attribute),*] $backend }
    };
}

/// Expands to one `#[test]` per check that compares numbers: on a [`Broken`](crate::Broken) copy of
/// a staged backend, the check must fail. Numbers are changed as they are read back, so every
/// backend gives the same result, and one is enough. Arguments are those of
/// [`backend_conformance!`](crate::backend_conformance).
#[macro_export]
macro_rules! broken_conformance {
    ($backend:expr $(, $attribute:meta)* $(,)?) => {
        $crate::conformance_checks! { can_fail [$($attribute),*] $backend }
        $crate::conformance_checks_of_stages! { can_fail [$($attribute),*] $backend }
    };
}

/// The checks of all backends: how many backends a check needs, its function, its test, and, if it
/// compares numbers, the test on a broken backend and the number that is wrong there.
#[doc(hidden)]
#[macro_export]
macro_rules! conformance_checks {
    ($test:ident $attributes:tt $backend:expr) => {
        $crate::conformance_tests! { $test $attributes $backend;
            one check_clock clock_holds clock_can_fail rotation;
            one check_weights weights_hold weights_can_fail weight;
            one check_sampling_at_keys sampling_at_keys_holds sampling_at_keys_can_fail translation;
            one check_sampling_between_keys
                sampling_between_keys_holds sampling_between_keys_can_fail model;
            one check_sampling_within_clip_bounds
                sampling_within_clip_bounds_holds sampling_within_clip_bounds_can_fail position;
            one check_blends blends_hold blends_can_fail rotation;
            one check_slot_order slot_order_holds slot_order_can_fail rotation;
            one check_zero_weights zero_weights_hold zero_weights_can_fail palette_bit;
            one check_small_totals small_totals_hold small_totals_can_fail scale;
            one check_override_layers override_layers_hold override_layers_can_fail palette;
            one check_additive_layers additive_layers_hold additive_layers_can_fail rotation;
            one check_far_rotations far_rotations_hold far_rotations_can_fail coarse_rotation;
            one check_retarget retarget_holds retarget_can_fail coarse_rotation;
            one check_retarget_between_keys
                retarget_between_keys_holds retarget_between_keys_can_fail position;
            one check_inertialization
                inertialization_holds inertialization_can_fail coarse_rotation;
            one check_gaze gaze_holds;
            one check_limbs limbs_hold;
            one check_chains chains_hold;
            one check_overrides overrides_hold;
            one check_user_stages user_stages_hold;
            one check_attachments attachments_hold;
            one check_root_motion root_motion_holds;
            one check_motion_transitions motion_transitions_hold;
            one check_motion_of_others motion_of_others_holds;
            one check_machines machines_hold;
            one check_feet feet_hold;
            one check_live_clips live_clips_hold;
            one check_pages pages_hold pages_can_fail palette_bit;
            one check_growth growth_holds growth_can_fail palette;
            one check_long_run long_run_holds long_run_can_fail rotation;
            many check_mixed_dispatch mixed_dispatch_holds mixed_dispatch_can_fail palette_bit;
            many check_churn churn_holds churn_can_fail palette_bit;
        }
    };
}

/// The checks that run one stage alone.
#[doc(hidden)]
#[macro_export]
macro_rules! conformance_checks_of_stages {
    ($test:ident $attributes:tt $backend:expr) => {
        $crate::conformance_tests! { $test $attributes $backend;
            one check_transform_alone transform_alone_holds transform_alone_can_fail model_rounding;
            one check_write_back_alone
                write_back_alone_holds write_back_alone_can_fail palette_rounding;
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! conformance_tests {
    ($test:ident $attributes:tt $backend:expr;
        $($kind:ident $check:ident $holds:ident $($can_fail:ident $wrong:ident)?;)*) => {
        $( $crate::conformance_test! {
            $test $attributes $kind $backend, $check $holds $($can_fail $wrong)?
        } )*
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! conformance_test {
    (holds [$($attribute:meta),*]
        many $backend:expr, $check:ident $holds:ident $($can_fail:ident $wrong:ident)?) => {
        #[test]
        $(#[$attribute])*
        fn $holds() {
            $crate::conformance::$check(&mut || ::std::boxed::Box::new($backend));
        }
    };
    (holds [$($attribute:meta),*]
        $one:ident $backend:expr, $check:ident $holds:ident $($can_fail:ident $wrong:ident)?) => {
        #[test]
        $(#[$attribute])*
        fn $holds() {
            $crate::conformance::$check(&mut $backend);
        }
    };
    (can_fail [$($attribute:meta),*] one $backend:expr, $check:ident $holds:ident) => {};
    (can_fail [$($attribute:meta),*]
        one $backend:expr, $check:ident $holds:ident $can_fail:ident $wrong:ident) => {
        #[test]
        $(#[$attribute])*
        #[should_panic(expected = "off by")]
        fn $can_fail() {
            let mut broken = $crate::Broken::new($backend, $crate::Corruption::$wrong());
            $crate::conformance::$check(&mut broken);
        }
    };
    (can_fail [$($attribute:meta),*]
        many $backend:expr, $check:ident $holds:ident $can_fail:ident $wrong:ident) => {
        #[test]
        $(#[$attribute])*
        #[should_panic(expected = "off by")]
        fn $can_fail() {
            $crate::conformance::$check(&mut || {
                ::std::boxed::Box::new($crate::Broken::new($backend, $crate::Corruption::$wrong()))
            });
        }
    };
}

/// Expands to a test that two backends agree, and to a test that a difference is found if one is
/// broken. The arguments are two expressions that create the backends, then attributes of both
/// tests.
#[macro_export]
macro_rules! backends_agree {
    ($first:expr, $second:expr $(, $attribute:meta)* $(,)?) => {
        #[test]
        $(#[$attribute])*
        fn agreement_holds() {
            $crate::conformance::check_agreement(&mut $first, &mut $second);
        }

        #[test]
        $(#[$attribute])*
        #[should_panic(expected = "off by")]
        fn agreement_can_fail() {
            let mut second = $crate::Broken::new($second, $crate::Corruption::palette_bit());
            $crate::conformance::check_agreement(&mut $first, &mut second);
        }
    };
}
