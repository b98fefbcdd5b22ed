use std::collections::BTreeSet;

use populace_device::layout::MAX_STEP_ROTATIONS;

use super::{Form, GroupShape};
use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::handles::Kernel;
use crate::launch::{Launch, WorkSize};
use crate::shape::GPU_SHAPE;

/// Environment variable with the folder that receives the text of each program for GPUs.
const TEXTS: &str = "POPULACE_KERNEL_TEXTS";

/// The programs that GPUs run, by the names of their texts.
fn programs_of_gpus() -> [(&'static str, Form); 4] {
    let grouped = Form::Grouped(GroupShape::of(GPU_SHAPE.fused_group));
    [
        ("common", Form::Common),
        ("floor", Form::Floor),
        ("staged", Form::Staged),
        ("fused_grouped", grouped),
    ]
}

/// Returns the names of the kernels in a text.
fn kernels_of(text: &str) -> BTreeSet<&str> {
    let after = text.split("__kernel").skip(1);
    after.filter_map(|rest| rest.split_once(" void ")?.1.split('(').next()).collect()
}

/// With the environment variable, `scripts/gpu-budget.py` compiles what this writes.
#[test]
fn texts_of_gpus_hold_the_kernels_that_they_run() {
    let folder = std::env::var_os(TEXTS);
    let mut found = BTreeSet::new();
    for (name, form) in programs_of_gpus() {
        let text = form.source("");
        found.extend(kernels_of(&text).into_iter().map(str::to_owned));
        if let Some(folder) = &folder {
            let path = std::path::Path::new(folder).join(name).with_extension("cl");
            std::fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        }
    }
    for wanted in [
        "apply_changes",
        "evaluate",
        "pose",
        "transform",
        "write_back",
        "fused_grouped",
        "fused_grouped_plain",
    ] {
        assert!(found.contains(wanted), "no {wanted} among {found:?}");
    }
}

/// Reference scales, and the ratio of 2 to each. The test of the same name in populace-native has
/// the same numbers.
const RATIOS: [(f32, f32); 6] =
    [(4.0, 0.5), (-4.0, -0.5), (0.0, 1.0), (-0.0, 1.0), (f32::NAN, 1.0), (f32::INFINITY, 0.0)];

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn scale_ratio_to_no_number_is_one() {
    let device =
        OpenClDevice::open(0).expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
    let one = |(reference, _): &(f32, f32)| {
        format!(
            "to.s.x = to.s.y = to.s.z = (Real)(as_float({}u));\n\
             found = quotient(from, to, quat_identity(), 0).s;\n\
             *out++ = as_uint(LANE(found.x, 0)); *out++ = as_uint(LANE(found.z, 0));\n",
            reference.to_bits()
        )
    };
    let body: String = RATIOS.iter().map(one).collect();
    let wanted: Vec<u32> = RATIOS.iter().flat_map(|(_, wanted)| [wanted.to_bits(); 2]).collect();
    for form in [Form::Staged, Form::Wide { lanes: 8 }, Form::Wide { lanes: 16 }] {
        let source = format!(
            "{}\n__kernel void probe(__global uint *out) {{\n\
             Local from = {{ {{ 0.0f, 0.0f, 0.0f }}, {{ 0.0f, 0.0f, 0.0f, 1.0f }},\n\
             {{ 2.0f, 2.0f, 2.0f }} }}, to = from;\nVec3 found;\n{body}}}\n",
            form.source("")
        );
        let program = device.build(&source).unwrap();
        let (kernel, queue) = (Kernel::create(&program, "probe").unwrap(), device.queue().unwrap());
        let out = Buffer::<u32>::new(&device, wanted.len(), "the probe's answers").unwrap();
        Launch::of(&kernel).buffer("out", &out).run(&queue, WorkSize::of(1, 1)).unwrap();
        let mut found = vec![0; wanted.len()];
        out.read(&queue, 0, &mut found).unwrap();
        assert_eq!(found, wanted, "{form:?}");
    }
}

#[test]
fn groups_divide_evenly_and_members_keep_their_poses_among_rotations() {
    for work_items in 1..=300 {
        let GroupShape { group, batch } = GroupShape::of(work_items);
        assert!(
            group <= work_items && group.is_multiple_of(batch),
            "{work_items}: {group}/{batch}"
        );
        assert!(3 * group / batch <= MAX_STEP_ROTATIONS as usize, "{work_items}: {group}/{batch}");
    }
}
