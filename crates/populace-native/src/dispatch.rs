//! Features of the processor, chosen at run time.
//!
//! What is below is the same text compiled for different processors; results are the same bit for
//! bit, since no product is ever fused with a sum.
#![expect(
    unsafe_code,
    reason = "a function compiled for a feature of the processor may only be called where the \
              processor has it"
)]

use populace_device::layout::Float4;

use crate::fused::{self, Desk, Evaluation};
use crate::joint::Posing;
use crate::lanes::Lanes;
use crate::rows::Local;

/// The widest registers that the processor and this crate both know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dispatch {
    /// What every processor of the architecture has.
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Compiles a function for each kind of registers, and makes the method that calls the one for this
/// machine.
macro_rules! for_each_processor {
    ($(#[$doc:meta])* $name:ident, $of_avx2:ident, $of_avx512:ident, $function:path, ($($arg:ident: $type:ty),*)) => {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        fn $of_avx2($($arg: $type),*) {
            $function($($arg),*);
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
        fn $of_avx512($($arg: $type),*) {
            $function($($arg),*);
        }

        impl Dispatch {
            $(#[$doc])*
            pub(crate) fn $name(self, $($arg: $type),*) {
                match self {
                    Self::Baseline => $function($($arg),*),
                    // SAFETY: `detect` makes this value only where the processor has AVX2.
                    #[cfg(target_arch = "x86_64")]
                    Self::Avx2 => unsafe { $of_avx2($($arg),*) },
                    // SAFETY: `detect` makes this value only where the processor has these parts of
                    // AVX-512.
                    #[cfg(target_arch = "x86_64")]
                    Self::Avx512 => unsafe { $of_avx512($($arg),*) },
                }
            }
        }
    };
}

for_each_processor!(
    /// See [`fused::write_palette`].
    write_palette, write_palette_avx2, write_palette_avx512, fused::write_palette,
    (member: Evaluation, desk: &mut Desk, palette: &mut [Float4])
);
for_each_processor!(
    /// See [`Posing::lay_over`].
    lay_over, lay_over_avx2, lay_over_avx512, Posing::lay_over,
    (posing: &Posing, rest: &Local<Lanes>, pose: &mut Local<Lanes>)
);

impl Dispatch {
    /// What this machine has.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let wide = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl");
            if wide {
                return Self::Avx512;
            }
            if is_x86_feature_detected!("avx2") {
                return Self::Avx2;
            }
        }
        Self::Baseline
    }

    /// The name of the registers, for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "AVX-512",
        }
    }
}
