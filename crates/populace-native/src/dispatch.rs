//! Processor features, chosen at run time.
//!
//! The same code is compiled for several processors. Results are equal bit for bit, because no
//! product is ever fused with a sum.
#![expect(
    unsafe_code,
    reason = "a function compiled for a feature of the processor may only be called where the \
              processor has it"
)]

/// Widest registers that both the processor and this crate support.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dispatch {
    /// The registers that every processor of the architecture has.
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Work that [`Dispatch::run`] compiles once for each kind of registers.
///
/// A closure would not do: it is compiled for the baseline unless the compiler chooses to inline
/// it.
pub(crate) trait Work {
    /// Does the work. Must be `#[inline(always)]`, as must be the functions that it calls, to be
    /// compiled for the caller's registers.
    fn run(self);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2<W: Work>(work: W) {
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
fn run_avx512<W: Work>(work: W) {
    work.run();
}

impl Dispatch {
    /// Detects what this machine has.
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

    /// Does work, compiled for these registers.
    pub(crate) fn run<W: Work>(self, work: W) {
        match self {
            Self::Baseline => work.run(),
            // SAFETY: `detect` makes this value only where the processor has AVX2.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_avx2(work) },
            // SAFETY: `detect` makes this value only where the processor has these parts of
            // AVX-512.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_avx512(work) },
        }
    }

    /// Returns the name of the registers.
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
