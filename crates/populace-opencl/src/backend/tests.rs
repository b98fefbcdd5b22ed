use std::sync::{Arc, OnceLock};

use populace_core::layout::device_structs;

use super::*;

/// One context for all tests of this process.
fn device() -> Arc<OpenClDevice> {
    static DEVICE: OnceLock<Arc<OpenClDevice>> = OnceLock::new();
    let open = || OpenClDevice::open(0).expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
    Arc::clone(DEVICE.get_or_init(open))
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn shared_structs_are_laid_out_alike() {
    // A kernel that returns each struct's size and field offsets, as the device's compiler sees them.
    let structs = device_structs();
    let mut body = String::new();
    let mut expected = Vec::new();
    for layout in &structs {
        body += &format!("*out++ = sizeof({});\n", layout.name);
        expected.push(u32::try_from(layout.size).unwrap());
        for (field, offset) in layout.fields {
            body += &format!("{{ {0} x; *out++ = (uint)((char *)&x.{field} - (char *)&x); }}\n", layout.name);
            expected.push(u32::try_from(*offset).unwrap());
        }
    }
    let source = format!("{}\n__kernel void probe(__global uint *out) {{\n{body}}}\n", Form::Staged.source());
    let device = device();
    let program = device.build(&source).unwrap();
    let (kernel, queue) = (Kernel::create(&program, "probe").unwrap(), device.queue().unwrap());
    let out = crate::buffer::Buffer::<u32>::new(&device, expected.len(), "the probe's answers").unwrap();
    Launch::of(&kernel).buffer("out", &out).run(&queue, [1, 1], [1, 1]).unwrap();
    let mut answers = vec![0; expected.len()];
    out.read(&queue, 0, &mut answers).unwrap();
    assert_eq!(answers, expected, "{structs:#?}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn past_the_end_is_an_error() {
    let mut backend = OpenClBackend::new(&device()).unwrap();
    assert!(backend.read(StageBuffer::Palette, 0, &mut [Float4::default()]).is_err());
    assert!(backend.write(StageBuffer::Scales, 9, &[Float4::default()]).is_err());
    assert!(backend.with_page(0, &mut |_| ()).is_err());
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn more_memory_than_there_is_is_an_error_that_says_how_much() {
    let result = crate::buffer::Buffer::<Float4>::new(&device(), 1 << 50, "a test");
    let Err(error) = result else { panic!("16 PiB were allocated") };
    assert!(error.to_string().contains("18014398509481984 bytes of a test"), "{error}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn a_kernel_that_does_not_build_gives_the_compilers_words() {
    let error = device().build("__kernel void broken(int x) { y = x; }").unwrap_err();
    assert!(error.to_string().contains("build the kernels"), "{error}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn a_device_that_does_not_exist_is_refused() {
    let error = OpenClDevice::open(99).unwrap_err();
    assert!(matches!(error, BackendError::NoDevice { index: 99, .. }), "{error}");
}

mod conformance {
    populace_testkit::backend_conformance!(
        super::OpenClBackend::new(&super::device()).expect("a backend"),
        cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
    );
}

/// The shape for GPUs, on whatever device there is.
mod conformance_of_the_gpu_shape {
    populace_testkit::backend_conformance!(
        super::OpenClBackend::with_shape(&super::device(), super::GPU_SHAPE).expect("a backend"),
        cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
    );
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn tables_that_grew_since_the_update_are_refused() {
    let joint =
        populace_core::JointSource { name: "root".into(), parent: None, rest: populace_core::Trs::IDENTITY };
    let mut tables = Tables::new(1);
    let body = tables.add_body(&populace_core::Skeleton::new(&[joint]).unwrap(), &[]).unwrap();
    let mut backend = OpenClBackend::new(&device()).unwrap();
    backend.update(&tables).unwrap();
    tables.add_member(body).unwrap();
    let error = backend.run(&tables, Frame { tick: 0 }).unwrap_err();
    assert!(error.to_string().contains("update first"), "{error}");
    backend.update(&tables).unwrap();
    backend.run(&tables, Frame { tick: 0 }).unwrap();
}
