//! The device's copies of the host's tables.

use populace_device::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Condition, Constraint, Contact, Control, Entry, Float4,
    Ground, Layer, Link, MachineInstance, MachineState, Member, Override, Slot, Step, Target,
    Transition,
};
use populace_device::{BackendError, Tables};

use crate::OpenClDevice;
use crate::upload::{BatchUploader, Copies, DeviceTable, UploadBatch};

macro_rules! device_tables {
    ($set:ident; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
        pub(crate) struct $set { $(pub(crate) $name: DeviceTable<$element>),* }

        impl $set {
            pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
                Ok(Self { $($name: DeviceTable::new(device)?),* })
            }

            /// Returns whether the memory suffices for the tables, as it does after an update.
            pub(crate) fn hold(&self, tables: &Tables) -> bool {
                true $(&& tables.$name().as_slice().len() <= self.$name.buffer.len())*
            }

            pub(crate) fn bytes(&self) -> usize {
                0 $(+ self.$name.buffer.bytes())*
            }
        }

        impl Copies for $set {
            fn pack(
                &mut self,
                device: &OpenClDevice,
                tables: &Tables,
                batch: &mut UploadBatch,
            ) -> Result<(), BackendError> {
                $(self.$name.pack(device, tables.$name(), batch)?;)*
                Ok(())
            }

            fn send(
                &mut self,
                tables: &Tables,
                uploader: &mut BatchUploader,
            ) -> Result<(), BackendError> {
                $(self.$name.send(tables.$name(), uploader)?;)*
                Ok(())
            }

            fn discard(&mut self) {
                $(self.$name.discard();)*
            }
        }
    };
}

// Tables that every schedule reads.
populace_device::with_tables!(device_tables, DeviceTables);
// Tables that only the staged schedule reads.
populace_device::with_block_tables!(device_tables, DeviceBlockTables);

/// The members of each page, over which the fused schedules iterate. Lists may shorten, so launches
/// take the host's count.
pub(crate) struct DevicePages {
    pub(crate) lists: Vec<DeviceTable<u32>>,
}

impl DevicePages {
    pub(crate) fn new() -> Self {
        Self { lists: Vec::new() }
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let pages = tables.page_lengths().len();
        let holds = |(page, list): (usize, &DeviceTable<u32>)| {
            tables.page_members(page).as_slice().len() <= list.buffer.len()
        };
        pages <= self.lists.len() && self.lists[..pages].iter().enumerate().all(holds)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.lists.iter().map(|list| list.buffer.bytes()).sum()
    }
}

impl Copies for DevicePages {
    fn pack(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
        batch: &mut UploadBatch,
    ) -> Result<(), BackendError> {
        for page in 0..tables.page_lengths().len() {
            if self.lists.len() <= page {
                self.lists.push(DeviceTable::new(device)?);
            }
            self.lists[page].pack(device, tables.page_members(page), batch)?;
        }
        Ok(())
    }

    fn send(&mut self, tables: &Tables, uploader: &mut BatchUploader) -> Result<(), BackendError> {
        let pages = tables.page_lengths().len();
        self.lists
            .iter_mut()
            .enumerate()
            .take(pages)
            .try_for_each(|(page, list)| list.send(tables.page_members(page), uploader))
    }

    fn discard(&mut self) {
        self.lists.iter_mut().for_each(DeviceTable::discard);
    }
}
