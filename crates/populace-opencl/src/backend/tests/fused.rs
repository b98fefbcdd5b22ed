//! The fused schedules: which form a device gets, and how work-groups share out members.

use super::*;
use crate::program::share_of;

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn fused_is_wide_on_cpus_and_grouped_elsewhere() {
    let form = |kind, schedule| {
        let device = device_described_as(|info| info.kind = kind);
        let backend = OpenClBackend::new(&device, schedule).unwrap();
        let SchedulePlan::Fused(fused) = &backend.plan else { panic!("{schedule} is not fused") };
        fused.kernel_name()
    };
    for (kind, fused) in [
        (DeviceKind::Cpu, "fused_wide"),
        (DeviceKind::Gpu, "fused_grouped"),
        (DeviceKind::Other, "fused_grouped"),
    ] {
        assert_eq!(form(kind, Schedule::Fused), fused, "{kind:?}");
        assert_eq!(form(kind, Schedule::FusedWide), "fused_wide", "{kind:?}");
        assert_eq!(form(kind, Schedule::FusedGrouped), "fused_grouped", "{kind:?}");
    }
}

/// Tables with one member whose body is a chain of `joint_count` joints.
fn tables_with_chain(joint_count: usize) -> Tables {
    let mut tables = Tables::new(4);
    let body = add_chain(&mut tables, joint_count);
    tables.add_member(body).unwrap();
    tables
}

/// Adds a body that is a chain of joints, each 1 m from its parent, with an entry for the last.
fn add_chain(tables: &mut Tables, joint_count: usize) -> populace_device::BodyIndex {
    let joint = |n: usize| populace_model::JointSource {
        name: format!("joint {n}"),
        parent: n.checked_sub(1),
        rest: populace_model::Trs { translation: [1.0, 0.0, 0.0], ..populace_model::Trs::IDENTITY },
    };
    let joints: Vec<_> = (0..joint_count).map(joint).collect();
    let entry = populace_character::PaletteEntry {
        joint: populace_model::JointIndex(u32::try_from(joint_count - 1).unwrap()),
        joint_from_bind: populace_model::Affine::IDENTITY,
    };
    tables.add_body(&populace_model::Skeleton::new(&joints).unwrap(), &[entry]).unwrap()
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn frame_of_some_members_leaves_other_palettes_unchanged() {
    let mut tables = tables_with_chain(3);
    for _ in 0..3 {
        tables.add_member(populace_device::BodyIndex(0)).unwrap();
    }
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        let mut backend = OpenClBackend::new(&device(), schedule).unwrap();
        tables.mark_dirty();
        backend.update(&tables).unwrap();
        let first = |place: usize| tables.members().as_slice()[place].palette_first as usize * 3;
        for place in 0..4 {
            backend.write(StageBuffer::Palette, first(place), &[Float4([9.0; 4]); 3]).unwrap();
        }
        backend.run(&tables, Frame { place_first: 1, place_end: 3, ..Frame::of_all(0) }).unwrap();
        let rows = [0, 1, 2, 3].map(|place| {
            let mut row = [Float4::default()];
            backend.read(&tables, StageBuffer::Palette, first(place), &mut row).unwrap();
            row[0].0
        });
        let (untouched, written) = ([9.0; 4], [1.0, 0.0, 0.0, 3.0]);
        assert_eq!(rows, [untouched, written, written, untouched], "{schedule}");
    }
}

/// Members of a group have batches of their own if their bodies differ, and if local memory has no
/// room for all.
#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn batches_cover_bodies_in_turn_with_little_local_memory() {
    let lengths = [3, 3, 5, 3, 5, 5, 5, 3, 3, 3, 3];
    for room in [1, 2, 3, 100] {
        let mut tables = tables_with_chain(lengths[0]);
        let other = add_chain(&mut tables, 5);
        for length in &lengths[1..] {
            let body = if *length == 5 { other } else { populace_device::BodyIndex(0) };
            tables.add_member(body).unwrap();
        }
        let (share, list) = (16 * share_of(16, false) as u64, 8 * 128);
        let device =
            device_described_as(|info| info.local_memory_bytes = room * share + list + 100);
        let mut backend = OpenClBackend::new(&device, Schedule::FusedGrouped).unwrap();
        backend.update(&tables).unwrap();
        backend.run(&tables, Frame::of_all(0)).unwrap();
        let ends = tables.members().as_slice().iter().map(|member| {
            let mut row = [Float4::default()];
            let at = member.palette_first as usize * 3;
            backend.read(&tables, StageBuffer::Palette, at, &mut row).unwrap();
            row[0].0[3]
        });
        let ends: Vec<f32> = ends.collect();
        assert_eq!(ends, lengths.map(|length| length as f32), "room for {room}");
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn body_too_large_for_local_memory_names_the_remedy() {
    // A member's share, and the list of the group: 64 joints fit, 80 do not.
    let bytes_of = |padded| 16 * share_of(padded, false) as u64 + 8 * 8;
    let available = bytes_of(64) + 100;
    let device = device_described_as(|info| info.local_memory_bytes = available);
    let mut backend = OpenClBackend::new(&device, Schedule::FusedGrouped).unwrap();
    let fits = tables_with_chain(64);
    backend.update(&fits).unwrap();
    backend.run(&fits, Frame::of_all(0)).unwrap();
    let mut palette = [Float4::default(); 3];
    backend.read(&fits, StageBuffer::Palette, 0, &mut palette).unwrap();
    assert_eq!(palette[0], Float4([1.0, 0.0, 0.0, 64.0]));

    let mut backend = OpenClBackend::new(&device, Schedule::FusedGrouped).unwrap();
    let too_large = tables_with_chain(65);
    let error = backend.update(&too_large).unwrap_err();
    let BackendError::BodyTooLarge { joints: 65, bytes, .. } = error else { panic!("{error}") };
    assert!((bytes_of(80)..bytes_of(80) + 100).contains(&bytes), "{error}");
    let expected = format!(
        "has {available} bytes of local memory, and a body of 65 joints takes {bytes} bytes"
    );
    assert!(error.to_string().contains(&expected), "{error}");
    assert!(error.to_string().contains("--schedule staged"), "{error}");
    let error = backend.run(&too_large, Frame::of_all(0)).unwrap_err();
    assert!(error.to_string().contains("update first"), "{error}");
    let mut staged = OpenClBackend::new(&device, Schedule::Staged).unwrap();
    staged.update(&too_large).unwrap();
    staged.run(&too_large, Frame::of_all(0)).unwrap();
}
