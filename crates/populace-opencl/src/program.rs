//! The text of the program: layouts and constants from `populace-core`, then the kernels.

/// OpenCL C of all stages as one string: the driver binding crashes when given a list.
pub(crate) fn source() -> String {
    // A fused product would differ from the native stages in the last bit.
    let rules = "#pragma OPENCL FP_CONTRACT OFF\n";
    let kernels = [
        include_str!("../kernels/quat.cl"),
        include_str!("../kernels/affine.cl"),
        include_str!("../kernels/evaluate.cl"),
        include_str!("../kernels/pose.cl"),
        include_str!("../kernels/transform.cl"),
        include_str!("../kernels/write_back.cl"),
    ];
    [rules, &populace_core::layout::opencl_prelude()].into_iter().chain(kernels).collect()
}
