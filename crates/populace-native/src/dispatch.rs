//! Processor features, chosen at run time.
//!
//! The same code is compiled for several processors. Results are equal bit for bit, because no
//! product is ever fused with a sum.
#![cfg_attr(
    target_arch = "x86_64",
    expect(
        unsafe_code,
        reason = "a function compiled for a feature of the processor may only be called where the \
                  processor has it"
    )
)]

#[cfg(not(target_arch = "x86_64"))]
use crate::lanes::Lanes;
#[cfg(target_arch = "x86_64")]
use crate::pair::Pair;
use crate::processor::Dispatch;
#[cfg(target_arch = "x86_64")]
use crate::registers::{Avx2, Avx512, Sse};
use crate::widths::JointLanes;

/// Sixteen joints in the registers that every processor of the architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = Pair<Pair<Sse>>;
#[cfg(not(target_arch = "x86_64"))]
type Baseline = Lanes;

/// Work that [`Dispatch::run`] compiles once for each kind of registers.
///
/// A closure would not do: it is compiled for the baseline unless the compiler chooses to inline
/// it.
pub(crate) trait Work: Sized {
    /// True for work that is compiled for AVX2 and AVX-512 too, false for the baseline alone.
    #[cfg_attr(
        not(target_arch = "x86_64"),
        expect(dead_code, reason = "other processors have one kind of registers")
    )]
    const IS_WIDE: bool = true;

    /// Does the work. Must be `#[inline(always)]`, as must be the functions that it calls, to be
    /// compiled for the caller's registers.
    ///
    /// `J` holds the lanes of sixteen joints.
    fn run<J: JointLanes>(self);

    /// Does the work, compiled for AVX2. As a method, it is built with the module of the work, and
    /// modules are built in parallel.
    ///
    /// # Safety
    ///
    /// The processor must have AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn run_avx2(self) {
        self.run::<Pair<Avx2>>();
    }

    /// Does the work, compiled for AVX-512.
    ///
    /// # Safety
    ///
    /// The processor must have these parts of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
    unsafe fn run_avx512(self) {
        self.run::<Avx512>();
    }
}

impl Dispatch {
    /// Does work, compiled for these registers or for the baseline.
    pub(crate) fn run<W: Work>(self, work: W) {
        match self {
            // SAFETY: `available` has this value only where the processor has AVX2.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 if W::IS_WIDE => unsafe { work.run_avx2() },
            // SAFETY: `available` has this value only where the processor has these parts of
            // AVX-512.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 if W::IS_WIDE => unsafe { work.run_avx512() },
            _ => work.run::<Baseline>(),
        }
    }
}
