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

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{__m128, __m256, __m512};

#[cfg(not(target_arch = "x86_64"))]
use crate::lanes::Lanes;
#[cfg(target_arch = "x86_64")]
use crate::pair::Pair;
#[cfg(target_arch = "x86_64")]
use crate::registers::One;
use crate::widths::JointLanes;

/// Sixteen joints in the registers that every processor of the architecture has.
#[cfg(target_arch = "x86_64")]
type Baseline = Pair<Pair<One<__m128>>>;
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

/// Members side by side in the fused schedule, one in each lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemberLanes {
    /// Lanes of SSE and NEON.
    Four = 4,
    /// Lanes of AVX2.
    Eight = 8,
    /// Lanes of AVX-512.
    Sixteen = 16,
}

/// Registers, and the members that the fused schedule puts side by side in them. Results are the
/// same in all.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    pub(crate) registers: Dispatch,
    pub(crate) lanes: MemberLanes,
}

/// Returns whether work is compiled for registers of a number of lanes.
#[cfg(target_arch = "x86_64")]
const fn is_compiled<W: Work>(lanes: usize) -> bool {
    match W::LANES {
        Some(only) => only == lanes,
        None => true,
    }
}

impl Machine {
    /// Puts as many members side by side as the widest registers of this machine have lanes.
    #[must_use]
    pub fn detect() -> Self {
        let registers = Dispatch::detect();
        Self { registers, lanes: registers.lanes() }
    }

    /// Puts a number of members side by side, in registers of as many lanes if this machine has
    /// them.
    #[must_use]
    pub fn of_lanes(lanes: MemberLanes) -> Self {
        let found = Dispatch::available().into_iter().find(|registers| registers.lanes() == lanes);
        found.map_or(Self::narrow(lanes), |registers| Self { registers, lanes })
    }

    /// Puts a number of members side by side, in the registers that every processor of the
    /// architecture has.
    #[must_use]
    pub fn narrow(lanes: MemberLanes) -> Self {
        Self { registers: Dispatch::Baseline, lanes }
    }
}

/// Work that [`Dispatch::run`] compiles once for each kind of registers.
///
/// A closure would not do: it is compiled for the baseline unless the compiler chooses to inline
/// it.
pub(crate) trait Work: Sized {
    /// Lanes of the only registers, besides the baseline's, that the work is compiled for; `None`
    /// for all.
    #[cfg_attr(
        not(target_arch = "x86_64"),
        expect(dead_code, reason = "other processors have one kind of registers")
    )]
    const LANES: Option<usize> = None;

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
        self.run::<Pair<One<__m256>>>();
    }

    /// Does the work, compiled for AVX-512.
    ///
    /// # Safety
    ///
    /// The processor must have these parts of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl")]
    unsafe fn run_avx512(self) {
        self.run::<One<__m512>>();
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

    /// Detects the widest registers of this machine.
    pub(crate) fn detect() -> Self {
        Self::available().pop().unwrap_or(Self::Baseline)
    }

    /// Returns the lanes of a register.
    fn lanes(self) -> MemberLanes {
        match self {
            Self::Baseline => MemberLanes::Four,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => MemberLanes::Eight,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => MemberLanes::Sixteen,
        }
    }

    /// Does work, compiled for these registers or for the baseline.
    pub(crate) fn run<W: Work>(self, work: W) {
        match self {
            // SAFETY: `available` has this value only where the processor has AVX2.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 if const { is_compiled::<W>(8) } => unsafe { work.run_avx2() },
            // SAFETY: `available` has this value only where the processor has these parts of
            // AVX-512.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 if const { is_compiled::<W>(16) } => unsafe { work.run_avx512() },
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
