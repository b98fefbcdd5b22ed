//! The suite that every device and schedule passes, and that is seen to fail on a [`Broken`](crate::Broken) twin.
//!
//! Each check panics with a message that says which member, joint and number is off, and by how much.
//! [`backend_conformance!`](crate::backend_conformance) makes a test of each check and of each twin.

mod agreement;
mod blend;
mod clock;
mod layers;
mod mixed;
mod plans;
mod running;
mod sampling;
mod stages;

pub use agreement::check_agreement;
pub use blend::{check_blends, check_slot_order, check_small_totals, check_zero_weights};
pub use clock::{check_clock, check_weights};
pub use layers::{check_additive_layers, check_override_layers};
pub use mixed::{check_churn, check_mixed_dispatch};
pub use running::{check_growth, check_long_run};
pub use sampling::{check_sampling_at_keys, check_sampling_between_keys};
pub use stages::{check_pages, check_transform_alone, check_write_back_alone};

/// Expands to one `#[test]` for each check of the conformance suite, run on the backend that the expression makes, and
/// one for its twin, which must fail. The expression is evaluated anew for each test, and for some several times.
#[macro_export]
macro_rules! backend_conformance {
    ($backend:expr) => {
        $crate::backend_conformance! { @one $backend;
            check_clock clock_holds clock_can_fail rotation;
            check_weights weights_hold weights_can_fail weight;
            check_sampling_at_keys sampling_at_keys_holds sampling_at_keys_can_fail translation;
            check_sampling_between_keys sampling_between_keys_holds sampling_between_keys_can_fail model;
            check_blends blends_hold blends_can_fail rotation;
            check_slot_order slot_order_holds slot_order_can_fail rotation;
            check_zero_weights zero_weights_hold zero_weights_can_fail palette_bit;
            check_small_totals small_totals_hold small_totals_can_fail scale;
            check_override_layers override_layers_hold override_layers_can_fail palette;
            check_additive_layers additive_layers_hold additive_layers_can_fail rotation;
            check_transform_alone transform_alone_holds transform_alone_can_fail model_rounding;
            check_write_back_alone write_back_alone_holds write_back_alone_can_fail palette_rounding;
            check_pages pages_hold pages_can_fail palette_bit;
            check_growth growth_holds growth_can_fail palette;
            check_long_run long_run_holds long_run_can_fail rotation;
        }
        $crate::backend_conformance! { @many $backend;
            check_mixed_dispatch mixed_dispatch_holds mixed_dispatch_can_fail palette_bit;
            check_churn churn_holds churn_can_fail palette_bit;
        }
    };
    (@one $backend:expr; $($check:ident $holds:ident $can_fail:ident $wrong:ident;)*) => { $(
        #[test]
        fn $holds() {
            $crate::conformance::$check(&mut $backend);
        }

        #[test]
        #[should_panic(expected = "off by")]
        fn $can_fail() {
            $crate::conformance::$check(&mut $crate::Broken::new($backend, $crate::Corruption::$wrong()));
        }
    )* };
    (@many $backend:expr; $($check:ident $holds:ident $can_fail:ident $wrong:ident;)*) => { $(
        #[test]
        fn $holds() {
            $crate::conformance::$check(&mut || ::std::boxed::Box::new($backend));
        }

        #[test]
        #[should_panic(expected = "off by")]
        fn $can_fail() {
            $crate::conformance::$check(&mut || {
                ::std::boxed::Box::new($crate::Broken::new($backend, $crate::Corruption::$wrong()))
            });
        }
    )* };
}

/// Expands to tests that two backends, made by the two expressions, agree, and that they are seen to differ where one
/// is broken.
#[macro_export]
macro_rules! backends_agree {
    ($first:expr, $second:expr) => {
        #[test]
        fn agreement_holds() {
            $crate::conformance::check_agreement(&mut $first, &mut $second);
        }

        #[test]
        #[should_panic(expected = "off by")]
        fn agreement_can_fail() {
            let mut second = $crate::Broken::new($second, $crate::Corruption::palette_bit());
            $crate::conformance::check_agreement(&mut $first, &mut second);
        }
    };
}
