//! The texts of the programs: layouts and constants from `populace-core`, then the kernels.

/// What a program's kernels compute at once, and where the fused ones keep what a member plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Form {
    /// One joint for each work-item, through global memory: the staged schedule, and what all schedules use.
    Staged,
    /// Sixteen joints at a time.
    Wide,
}

impl Form {
    /// OpenCL C as one string: the driver binding crashes when given a list.
    pub(crate) fn source(self) -> String {
        // A fused product would differ from the native stages in the last bit.
        let rules = "#pragma OPENCL FP_CONTRACT OFF\n";
        let settings = match self {
            Self::Staged => "#define LANES 1\n",
            Self::Wide => "#define LANES 16\n#define FUSED __private\n",
        };
        let shared = [
            include_str!("../kernels/lanes.cl"),
            include_str!("../kernels/quat.cl"),
            include_str!("../kernels/slot.cl"),
            include_str!("../kernels/rows.cl"),
            include_str!("../kernels/playback.cl"),
            include_str!("../kernels/joint.cl"),
            include_str!("../kernels/affine.cl"),
        ];
        let kernels: &[&str] = match self {
            Self::Staged => &[
                include_str!("../kernels/evaluate.cl"),
                include_str!("../kernels/pose.cl"),
                include_str!("../kernels/transform.cl"),
                include_str!("../kernels/write_back.cl"),
                include_str!("../kernels/floor.cl"),
            ],
            Self::Wide => &[include_str!("../kernels/fused.cl"), include_str!("../kernels/fused_wide.cl")],
        };
        let prelude = populace_core::layout::opencl_prelude();
        [rules, settings, &prelude].into_iter().chain(shared).chain(kernels.iter().copied()).collect()
    }
}
