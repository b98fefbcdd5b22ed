//! The device's copies of the host's tables.

use populace_device::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Condition, Constraint, Control, Entry, Float4, Ground,
    Layer, Link, MachineInstance, MachineState, Member, Override, RowBlock, Slot, Source, Step,
    Target, Transition,
};
use populace_device::{BackendError, Tables};

use crate::OpenClDevice;
use crate::upload::{Copies, DeviceTable, Parcel, Route};

macro_rules! device_tables {
    ($set:ident; $($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
        pub(crate) struct $set { $(pub(crate) $name: DeviceTable<$element>),* }

        impl $set {
            pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
                Ok(Self { $($name: DeviceTable::new(device)?),* })
            }

            /// Whether every table of the host has room here, as it has after an update.
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
                parcel: &mut Parcel,
            ) -> Result<(), BackendError> {
                $(self.$name.pack(device, tables.$name(), parcel)?;)*
                Ok(())
            }

            fn send(&mut self, tables: &Tables, route: &mut Route) -> Result<(), BackendError> {
                $(self.$name.send(tables.$name(), route)?;)*
                Ok(())
            }

            fn forget(&mut self) {
                $(self.$name.forget();)*
            }
        }
    };
}

// What every schedule reads.
populace_device::with_tables!(device_tables, DeviceTables);
// What the staged schedule alone reads.
populace_device::with_block_tables!(device_tables, DeviceBlockTables);

/// The members of each page, for the fused schedules, which walk them. Lists shorten: launches take
/// the host's count.
pub(crate) struct DevicePages {
    pub(crate) lists: Vec<DeviceTable<u32>>,
}

impl DevicePages {
    pub(crate) fn new() -> Self {
        Self { lists: Vec::new() }
    }

    /// Whether the lists of all pages have room here, as they have after an update.
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
        parcel: &mut Parcel,
    ) -> Result<(), BackendError> {
        for page in 0..tables.page_lengths().len() {
            if self.lists.len() <= page {
                self.lists.push(DeviceTable::new(device)?);
            }
            self.lists[page].pack(device, tables.page_members(page), parcel)?;
        }
        Ok(())
    }

    fn send(&mut self, tables: &Tables, route: &mut Route) -> Result<(), BackendError> {
        let pages = tables.page_lengths().len();
        self.lists
            .iter_mut()
            .enumerate()
            .take(pages)
            .try_for_each(|(page, list)| list.send(tables.page_members(page), route))
    }

    fn forget(&mut self) {
        self.lists.iter_mut().for_each(DeviceTable::forget);
    }
}
