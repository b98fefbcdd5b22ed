use std::sync::{Arc, OnceLock};

use populace_device::layout::device_structs;

use super::*;
use crate::shape::GPU_SHAPE;

mod faults;
mod fused;
mod parity;
mod parity_slots;

/// One context for all tests of this process.
fn device() -> Arc<OpenClDevice> {
    static DEVICE: OnceLock<Arc<OpenClDevice>> = OnceLock::new();
    let open =
        || OpenClDevice::open(0).expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
    Arc::clone(DEVICE.get_or_init(open))
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn shared_structs_have_the_same_layout() {
    // The kernel returns the size and the field offsets of each struct, as the device's compiler
    // sees them.
    let structs = device_structs();
    let mut body = String::new();
    let mut expected = Vec::new();
    for layout in &structs {
        body += &format!("*out++ = sizeof({});\n", layout.name);
        expected.push(u32::try_from(layout.size).unwrap());
        for (field, offset) in layout.fields {
            body += &format!(
                "{{ {0} x; *out++ = (uint)((char *)&x.{field} - (char *)&x); }}\n",
                layout.name
            );
            expected.push(u32::try_from(*offset).unwrap());
        }
    }
    let source = format!(
        "{}\n__kernel void probe(__global uint *out) {{\n{body}}}\n",
        Form::Staged.source("")
    );
    let device = device();
    let program = device.build(&source).unwrap();
    let (kernel, queue) = (Kernel::create(&program, "probe").unwrap(), device.queue().unwrap());
    let out =
        crate::buffer::Buffer::<u32>::new(&device, expected.len(), "the probe's answers").unwrap();
    Launch::of(&kernel).buffer("out", &out).run(&queue, crate::launch::WorkSize::of(1, 1)).unwrap();
    let mut answers = vec![0; expected.len()];
    out.read(&queue, 0, &mut answers).unwrap();
    assert_eq!(answers, expected, "{structs:#?}");
}

/// Returns the flags of the memory around an address, as the system shows them.
#[cfg(target_os = "linux")]
fn memory_flags(address: usize) -> Option<String> {
    let maps = std::fs::read_to_string("/proc/self/smaps").ok()?;
    let mut is_around = false;
    for line in maps.lines() {
        let range = line.split(' ').next().and_then(|range| range.split_once('-'));
        let ends = range.map(|(from, to)| [from, to].map(|end| usize::from_str_radix(end, 16)));
        if let Some([Ok(from), Ok(to)]) = ends {
            is_around = (from..to).contains(&address);
        }
        if let Some(flags) = line.strip_prefix("VmFlags:").filter(|_| is_around) {
            return Some(flags.to_owned());
        }
    }
    None
}

#[cfg(target_os = "linux")]
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn palettes_of_large_crowds_are_in_large_pages() {
    if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
        return;
    }
    let device = device();
    if device.info.kind != DeviceKind::Cpu {
        return;
    }
    let (queue, elements) = (device.queue().unwrap(), (8 << 20) / size_of::<Float4>());
    let mut page = crate::pages::own_page(&device, &queue, elements).unwrap();
    let mut middle = 0;
    page.map(&queue, &mut |page| middle = page[page.len() / 2..].as_ptr().addr()).unwrap();
    let flags = memory_flags(middle).unwrap();
    assert!(flags.split_whitespace().any(|flag| flag == "hg"), "{flags}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn access_past_the_end_is_an_error() {
    let mut backend = OpenClBackend::new(&device(), Schedule::Staged).unwrap();
    assert!(
        backend.read(&Tables::new(1), StageBuffer::Palette, 0, &mut [Float4::default()]).is_err()
    );
    assert!(backend.write(StageBuffer::Scales, 9, &[Float4::default()]).is_err());
    assert!(backend.with_page(0, &mut |_| ()).is_err());
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn failed_allocation_names_its_size() {
    let result = crate::buffer::Buffer::<Float4>::new(&device(), 1 << 50, "a test");
    let Err(error) = result else { panic!("16 PiB were allocated") };
    assert!(error.to_string().contains("18014398509481984 bytes of a test"), "{error}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn build_error_contains_the_compiler_log() {
    let error = device().build("__kernel void broken(int x) { y = x; }").unwrap_err();
    assert!(error.to_string().contains("build the kernels"), "{error}");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn unknown_device_index_is_refused() {
    let error = OpenClDevice::open(99).unwrap_err();
    assert!(matches!(error, BackendError::NoDevice { index: 99, .. }), "{error}");
}

/// Opens half of PoCL's device.
fn half(part: usize) -> Result<Arc<OpenClDevice>, BackendError> {
    OpenClDevice::open_part(0, crate::DevicePart { part, parts: 2 })
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn parts_divide_the_compute_units_equally() {
    let whole = device().info().compute_units;
    assert_eq!(device().info().most_parts, whole, "PoCL splits into single units");
    let [first, second] = [1, 2].map(|part| half(part).unwrap().info().compute_units);
    assert_eq!((first, second), (whole / 2, whole / 2));
    assert!(half(2).unwrap().info().name.ends_with(", part 2 of 2"), "errors name the part");
    for (part, parts, words) in [
        (1, 9999, "compute units, for at most"),
        (1, 0, "compute units, for at most"),
        (3, 2, "has no part 3 of 2: parts count from 1"),
        (0, 2, "has no part 0 of 2: parts count from 1"),
    ] {
        let error = OpenClDevice::open_part(0, crate::DevicePart { part, parts }).unwrap_err();
        assert!(
            matches!(error, BackendError::NoPart { .. }) && error.to_string().contains(words),
            "{error}"
        );
    }
}

/// A context without valid handles. A driver without the extension must refuse it unseen.
#[derive(Debug)]
struct NoContext;

#[expect(unsafe_code, reason = "a promise about handles that are refused before they are used")]
// SAFETY: `OpenClDevice::open_for_gl` and `OpenClBackend::refuses` use no handle where the
// extension is missing.
unsafe impl GlContext for NoContext {
    fn handles(&self) -> populace_device::EglHandles {
        populace_device::EglHandles { display: 0, context: 0 }
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn gl_sharing_is_refused_without_driver_support() {
    let plain = crate::devices().unwrap().into_iter().find(|device| !device.shares_with_gl);
    let index = plain.expect("a driver without the extension, such as PoCL").index;
    let error = OpenClDevice::open_for_gl(index, None, Arc::new(NoContext)).unwrap_err();
    assert!(error.to_string().contains("does not offer cl_khr_gl_sharing"), "{error}");
    let backend = OpenClBackend::new(&OpenClDevice::open(index).unwrap(), Schedule::Fused).unwrap();
    let reason = backend.refuses(PaletteTransport::Shared, &NoContext).unwrap();
    assert_eq!(reason, "its driver does not offer cl_khr_gl_sharing");
    assert_eq!(backend.refuses(PaletteTransport::Copied, &NoContext), None);
}

mod conformance {
    populace_testkit::backend_conformance!(
        super::OpenClBackend::new(&super::device(), super::Schedule::Staged).expect("a backend"),
        cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
    );
}

mod conformance_fused_wide {
    populace_testkit::fused_conformance!(
        super::OpenClBackend::new(&super::device(), super::Schedule::FusedWide).expect("a backend"),
        cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
    );
}

mod conformance_fused_grouped {
    populace_testkit::fused_conformance!(
        super::OpenClBackend::new(&super::device(), super::Schedule::FusedGrouped)
            .expect("a backend"),
        cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")
    );
}

/// Returns a backend with `lanes` members side by side.
fn in_lanes(lanes: usize) -> OpenClBackend {
    let shape = DispatchShape { lanes, ..GPU_SHAPE };
    OpenClBackend::with_shape(&device(), Schedule::FusedWide, shape).expect("a backend")
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn lanes_do_not_change_a_bit() {
    populace_testkit::conformance::check_same_frames(&mut in_lanes(8), &mut in_lanes(16));
}

/// More shapes of groups, and a part of the device.
#[cfg(not(skip_opencl))]
mod slow {
    use super::*;

    fn small_groups() -> DispatchShape {
        let mut shape = GPU_SHAPE;
        (shape.group, shape.fused_group) = (16, 16);
        shape
    }

    /// Groups smaller than most bodies and levels, so that every loop runs more than once.
    mod conformance_fused_in_small_groups {
        populace_testkit::fused_conformance!(
            super::OpenClBackend::with_shape(
                &super::device(),
                super::Schedule::FusedGrouped,
                super::small_groups()
            )
            .expect("a backend"),
            ignore = "make test-slow"
        );
    }

    /// Lanes of AVX2, on any processor.
    mod conformance_fused_in_eight_lanes {
        populace_testkit::fused_conformance!(super::in_lanes(8), ignore = "make test-slow");
    }

    /// Lanes of AVX-512, on any processor.
    mod conformance_fused_in_sixteen_lanes {
        populace_testkit::fused_conformance!(super::in_lanes(16), ignore = "make test-slow");
    }

    /// The settings for GPUs, on any device.
    mod conformance_with_gpu_shape {
        populace_testkit::backend_conformance!(
            super::OpenClBackend::with_shape(
                &super::device(),
                super::Schedule::Staged,
                super::GPU_SHAPE
            )
            .expect("a backend"),
            ignore = "make test-slow"
        );
    }

    mod conformance_on_a_part {
        populace_testkit::fused_conformance!(
            super::OpenClBackend::new(
                &super::half(2).expect("a second half"),
                super::Schedule::FusedWide
            )
            .expect("a backend"),
            ignore = "make test-slow"
        );
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn run_refuses_tables_that_grew_since_the_update() {
    let joint = populace_model::JointSource {
        name: "root".into(),
        parent: None,
        rest: populace_model::Trs::IDENTITY,
    };
    let mut tables = Tables::new(1);
    let body = tables.add_body(&populace_model::Skeleton::new(&[joint]).unwrap(), &[]).unwrap();
    let mut backend = OpenClBackend::new(&device(), Schedule::Staged).unwrap();
    backend.update(&tables).unwrap();
    tables.add_member(body).unwrap();
    let error = backend.run(&tables, Frame::of_all(0)).unwrap_err();
    assert!(error.to_string().contains("update first"), "{error}");
    backend.update(&tables).unwrap();
    backend.run(&tables, Frame::of_all(0)).unwrap();
}

/// Opens a device with a changed description.
fn device_described_as(claim: impl FnOnce(&mut crate::DeviceInfo)) -> Arc<OpenClDevice> {
    let mut device = OpenClDevice::open(0).unwrap();
    claim(&mut Arc::get_mut(&mut device).unwrap().info);
    device
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn crowd_resumes_after_a_failed_allocation() {
    let joint = |name: &str| populace_model::JointSource {
        name: name.into(),
        parent: None,
        rest: populace_model::Trs { translation: [1.0, 2.0, 3.0], ..populace_model::Trs::IDENTITY },
    };
    let entry = populace_character::PaletteEntry {
        joint: populace_model::JointIndex(0),
        joint_from_bind: populace_model::Affine::IDENTITY,
    };
    let mut tables = Tables::new(4);
    let body = tables
        .add_body(&populace_model::Skeleton::new(&[joint("root")]).unwrap(), &[entry; 6])
        .unwrap();
    let mut backend = OpenClBackend::new(
        &device_described_as(|info| info.max_allocation_bytes = 200_000),
        Schedule::Staged,
    )
    .unwrap();
    let frame = Frame::of_all(0);
    let mut taken: Vec<u32> = (0..10).map(|_| tables.add_member(body).unwrap()).collect();
    // Too many members for slots, for the joint buffer, and for palettes.
    for (members, what) in [
        (1100, "211200 bytes of slots"),
        (900, "bytes of joint translations"),
        (600, "bytes of matrix palettes"),
    ] {
        while taken.len() < members {
            taken.push(tables.add_member(body).unwrap());
        }
        let error = backend.update(&tables).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
        let error = backend.run(&tables, frame).unwrap_err();
        assert!(error.to_string().contains("update first"), "{error}");
        taken.drain(10..).for_each(|place| tables.remove_member(place));
        backend.update(&tables).unwrap();
        tables.mark_clean();
        backend.run(&tables, frame).unwrap();
        for place in &taken {
            let first = tables.members().as_slice()[*place as usize].palette_first as usize * 3;
            let mut palette = [Float4::default(); 18];
            backend.read(&Tables::new(1), StageBuffer::Palette, first, &mut palette).unwrap();
            assert_eq!(palette[16], Float4([0.0, 1.0, 0.0, 2.0]), "member {place} after {what}");
        }
    }
}

/// Returns the source of a kernel that writes `number`, for tests of the program cache.
fn source_of(number: u32) -> String {
    format!("__kernel void number(__global uint *out) {{ *out = {number}u; }}")
}

/// Builds `source` on a device with a cache in `folder`, runs its kernel, and returns the number.
fn number_by(folder: &std::path::Path, source: &str) -> u32 {
    let mut device = Arc::into_inner(OpenClDevice::open(0).unwrap()).unwrap();
    device.cache = Some(crate::cache::Cache::in_folder(folder));
    let program = device.build(source).unwrap();
    let (kernel, queue) = (Kernel::create(&program, "number").unwrap(), device.queue().unwrap());
    let out = crate::buffer::Buffer::<u32>::new(&device, 1, "a number").unwrap();
    Launch::of(&kernel).buffer("out", &out).run(&queue, crate::launch::WorkSize::of(1, 1)).unwrap();
    let mut answer = [0];
    out.read(&queue, 0, &mut answer).unwrap();
    answer[0]
}

/// Lists the files in a folder.
fn programs_in(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn cached_program_is_not_rebuilt() {
    let [one, two] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    assert_eq!(
        (number_by(one.path(), &source_of(1)), number_by(two.path(), &source_of(2))),
        (1, 2)
    );
    // Puts the second binary in place of the first: a rebuild of the first would return 1.
    let ([first], [second]) = (&programs_in(one.path())[..], &programs_in(two.path())[..]) else {
        panic!("each program is one file")
    };
    std::fs::copy(second, first).unwrap();
    assert_eq!(number_by(one.path(), &source_of(1)), 2);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn damaged_cache_entry_is_rebuilt_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(number_by(folder.path(), &source_of(3)), 3);
    let file = programs_in(folder.path()).remove(0);
    let good = std::fs::read(&file).unwrap();
    let no_program = {
        let other = tempfile::tempdir().unwrap();
        let cache = crate::cache::Cache::in_folder(other.path());
        cache.entry(std::iter::empty()).write(b"no program of any driver");
        std::fs::read(programs_in(other.path()).remove(0)).unwrap()
    };
    for bad in [no_program, good[..good.len() / 2].to_vec(), Vec::new()] {
        std::fs::write(&file, &bad).unwrap();
        assert_eq!(number_by(folder.path(), &source_of(3)), 3);
        assert_ne!(
            std::fs::read(&file).unwrap(),
            bad,
            "the bad entry of {} bytes was kept",
            bad.len()
        );
    }
}

/// Environment variable with the folder that a test shares with its child processes.
const SHARED_FOLDER: &str = "POPULACE_TEST_SHARED_FOLDER";

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn concurrent_builds_leave_one_complete_program() {
    if let Some(folder) = std::env::var_os(SHARED_FOLDER) {
        for number in 0..2 {
            assert_eq!(number_by(folder.as_ref(), &source_of(number)), number);
        }
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let this_test = "backend::tests::concurrent_builds_leave_one_complete_program";
    let start = |_| {
        let mut process = std::process::Command::new(std::env::current_exe().unwrap());
        process.args(["--exact", this_test]).env(SHARED_FOLDER, folder.path()).spawn().unwrap()
    };
    let processes: Vec<_> = (0..2).map(start).collect();
    for mut process in processes {
        assert!(process.wait().unwrap().success());
    }
    assert_eq!(programs_in(folder.path()).len(), 2);
    assert_eq!(number_by(folder.path(), &source_of(1)), 1);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn grown_buffer_keeps_elements_and_appends_zeros() {
    let (device, count) = (device(), 150_000);
    let queue = device.queue().unwrap();
    let mut buffer = crate::buffer::Buffer::<u32>::new(&device, 3, "a test").unwrap();
    buffer.write(&queue, 0, &[7, 8, 9]).unwrap();
    buffer.grow(&device, &queue, count, "a test").unwrap();
    let mut elements = vec![1; buffer.len()];
    buffer.read(&queue, 0, &mut elements).unwrap();
    assert!(
        elements.len() >= count
            && elements[..3] == [7, 8, 9]
            && elements[3..].iter().all(|e| *e == 0)
    );
}
