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
#[cfg(target_arch = "x86_64")]
use crate::registers::{Avx2, Avx512, Sse};
use crate::widths::JointLanes;

/// Sixteen joints in the registers that every processor of the architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = Pair<Pair<Sse>>;
#[cfg(not(target_arch = "x86_64"))]
type Baseline = Lanes;

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

/// Number of lanes of a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegisterLanes {
    /// SSE and NEON.
    Four = 4,
    /// AVX2.
    Eight = 8,
    /// AVX-512.
    Sixteen = 16,
}

/// Registers to compute in. Results are the same in all.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    pub(crate) registers: Dispatch,
}

impl Machine {
    /// Takes the widest registers of this machine.
    #[must_use]
    pub fn detect() -> Self {
        Self::at_most(RegisterLanes::Sixteen)
    }

    /// Takes the widest registers of this machine that have no more than some lanes.
    #[must_use]
    pub fn at_most(lanes: RegisterLanes) -> Self {
        let fit = |registers: &Dispatch| registers.lanes() as usize <= lanes as usize;
        let widest = Dispatch::available().into_iter().rfind(fit);
        Self { registers: widest.unwrap_or(Dispatch::Baseline) }
    }
}

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
    /// Lists what this machine has, the widest registers last.
    pub(crate) fn available() -> Vec<Self> {
        let all = std::iter::once(Self::Baseline);
        #[cfg(target_arch = "x86_64")]
        let all = {
            let wide = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl");
            all.chain(is_x86_feature_detected!("avx2").then_some(Self::Avx2))
                .chain(wide.then_some(Self::Avx512))
        };
        all.collect()
    }

    /// Returns the lanes of a register.
    fn lanes(self) -> RegisterLanes {
        match self {
            Self::Baseline => RegisterLanes::Four,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => RegisterLanes::Eight,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => RegisterLanes::Sixteen,
        }
    }

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
