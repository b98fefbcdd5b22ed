//! Registers of the processor, found at run time.

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
