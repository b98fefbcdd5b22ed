use std::sync::Arc;

use populace_character::PaletteEntry;
use populace_device::layout::{LAYERS_PER_MEMBER, Layer, Member, NONE, Slot};
use populace_device::{BodyIndex, LayerSettings};
use populace_model::{Affine, JointIndex, JointSource, Mask, Skeleton, Trs};
use populace_testkit::Rng;

use super::*;
use crate::tables::{DeviceBlockTables, DevicePages, DeviceTables};

/// All tables that a device keeps.
struct Device {
    device: Arc<OpenClDevice>,
    queue: CommandQueue,
    uploader: Uploader,
    tables: DeviceTables,
    blocks: DeviceBlockTables,
    pages: DevicePages,
}

impl Device {
    fn new() -> Self {
        Self::with_room(u64::MAX)
    }

    fn with_room(bytes: u64) -> Self {
        let mut device = OpenClDevice::open(0)
            .expect("an OpenCL device; set POPULACE_SKIP=opencl to go without");
        let info = &mut Arc::get_mut(&mut device).unwrap().info;
        info.max_allocation_bytes = info.max_allocation_bytes.min(bytes);
        Self {
            queue: device.queue().unwrap(),
            uploader: Uploader::new(&device, device.group_size(64)).unwrap(),
            tables: DeviceTables::new(&device).unwrap(),
            blocks: DeviceBlockTables::new(&device).unwrap(),
            pages: DevicePages::new(),
            device,
        }
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let copies: &mut [&mut dyn Copies] =
            &mut [&mut self.tables, &mut self.blocks, &mut self.pages];
        self.uploader.update(&self.device, &self.queue, tables, copies)
    }

    /// Compares every element with the host's.
    #[track_caller]
    fn assert_holds(&self, tables: &Tables) {
        macro_rules! compare {
            ($set:ident; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
                $(self.assert_same(tables.$name(), &self.$set.$name);)*
            };
        }
        populace_device::with_tables!(compare, tables);
        populace_device::with_block_tables!(compare, blocks);
        for (page, list) in self.pages.lists.iter().enumerate().take(tables.page_lengths().len()) {
            self.assert_same(tables.page_members(page), list);
        }
        assert!(self.tables.hold(tables) && self.blocks.hold(tables) && self.pages.hold(tables));
    }

    #[track_caller]
    fn assert_same<T: Element>(&self, host: &Table<T>, device: &DeviceTable<T>) {
        let mut copy = vec![T::zeroed(); host.as_slice().len()];
        device.buffer.read(&self.queue, 0, &mut copy).unwrap();
        let wrong = (0..copy.len())
            .find(|i| bytemuck::bytes_of(&copy[*i]) != bytemuck::bytes_of(&host.as_slice()[*i]));
        assert_eq!(wrong, None, "element of {} (of {} elements)", host.name(), copy.len());
    }
}

fn skeleton(joints: usize) -> Skeleton {
    let joint = |j| JointSource { name: format!("{j}"), parent: None, rest: Trs::IDENTITY };
    Skeleton::new(&(0..joints).map(joint).collect::<Vec<_>>()).unwrap()
}

fn add_body(tables: &mut Tables, joints: usize, entries: usize) -> BodyIndex {
    let entry = PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY };
    tables.add_body(&skeleton(joints), &vec![entry; entries]).unwrap()
}

fn add_members(tables: &mut Tables, body: BodyIndex, count: usize) -> Vec<u32> {
    (0..count).map(|_| tables.add_member(body).unwrap()).collect()
}

/// Makes one random change of any kind.
fn change(tables: &mut Tables, taken: &mut Vec<u32>, rng: &mut Rng, step: u64) {
    let bodies = u32::try_from(tables.bodies().as_slice().len()).unwrap();
    if taken.is_empty() || rng.below(20) == 0 {
        let body = BodyIndex(u32::try_from(rng.below(bodies as usize)).unwrap());
        return taken.push(tables.add_member(body).unwrap());
    }
    let one = rng.below(taken.len());
    match rng.below(40) {
        0 => tables.remove_member(taken.swap_remove(one)),
        1 => {
            tables.add_mask(&Mask::new(&skeleton(3), vec![0.5; 3]).unwrap()).unwrap();
        }
        2..10 => {
            let settings = LayerSettings { weight: step as f32, ..LayerSettings::default() };
            let index = rng.below(LAYERS_PER_MEMBER as usize);
            tables.set_layer(taken[one], index, Layer::new(settings, None)).unwrap();
        }
        _ => {
            let slot =
                Slot { start_tick: step, weight_tick: !step, bound_clip: NONE, ..Slot::default() };
            let index = rng.below(tables.slots_per_member());
            tables.set_slot(taken[one], index, &slot.on_layer(1)).unwrap();
        }
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn device_tables_follow_random_changes() {
    let mut tables = Tables::new(4);
    for (joints, entries) in [(1, 300_000), (33, 20), (3, 1)] {
        add_body(&mut tables, joints, entries);
    }
    let (mut taken, mut rng) = (Vec::new(), Rng::new(5));
    let mut devices = [Device::new(), Device::new()];
    for frame in 0..60 {
        // A few changes, many, or none.
        let changes = [1, 5, 40, 600, 0][rng.below(5)];
        (0..changes)
            .for_each(|step| change(&mut tables, &mut taken, &mut rng, frame * 1000 + step));
        devices.iter_mut().for_each(|d| d.update(&tables).unwrap());
        if frame % 7 == 0 {
            devices[0].assert_holds(&tables);
        }
        tables.mark_clean();
        if frame == 30 {
            // A device that joins later.
            tables.mark_dirty();
            devices[1] = Device::new();
        }
    }
    devices.iter().for_each(|d| d.assert_holds(&tables));
    assert!(taken.len() > 30, "{} members are too few for this test", taken.len());
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn run_too_long_for_staging_is_uploaded() {
    let mut tables = Tables::new(1);
    add_body(&mut tables, 1, STAGED_BYTES / 64 + 1);
    let mut device = Device::new();
    device.update(&tables).unwrap();
    device.assert_holds(&tables);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn crowd_of_known_size_allocates_exactly() {
    let mut tables = Tables::with_capacity(4, 3000);
    let body = add_body(&mut tables, 1, 1);
    let mut device = Device::new();
    device.update(&tables).unwrap();
    let without = device.tables.bytes();
    for more in [1, 999, 2000] {
        add_members(&mut tables, body, more);
        device.update(&tables).unwrap();
        let of_one = size_of::<Member>() + 4 * size_of::<Slot>() + 4 * size_of::<Layer>();
        assert_eq!(device.tables.bytes() - without, 3000 * of_one);
        tables.mark_clean();
    }
    device.assert_holds(&tables);
    assert!(device.pages.bytes() <= 3000 * 6);
    // One member more than announced.
    tables.add_member(body).unwrap();
    device.update(&tables).unwrap();
    device.assert_holds(&tables);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn growth_reserve_falls_back_to_exact_size() {
    for members in [1_000_000, usize::MAX] {
        let mut tables = Tables::with_capacity(4, members);
        let body = add_body(&mut tables, 1, 1);
        let mut device = Device::with_room(20_000);
        add_members(&mut tables, body, 100); // 19,200 bytes of slots
        device.update(&tables).unwrap();
        device.assert_holds(&tables);
        tables.mark_clean();
        add_members(&mut tables, body, 5);
        let before = device.tables.bytes();
        let error = device.update(&tables).unwrap_err();
        assert!(error.to_string().contains("20160 bytes of slots"), "{error}");
        assert_eq!(device.tables.bytes(), before, "all copies stay as they were");
        assert!(!device.tables.hold(&tables));
    }
}
