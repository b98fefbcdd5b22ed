//! The device's copy of the host's tables.

use std::ops::Range;

use opencl3::command_queue::CommandQueue;
use populace_core::layout::{
    Body, BoundBlock, BoundClip, ClipRows, Entry, Layer, Member, RowBlock, Slot, Source,
};
use populace_core::{BackendError, Table, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Element};

/// One table on the device, with room to grow.
pub(crate) struct DeviceTable<T> {
    pub(crate) buffer: Buffer<T>,
}

impl<T: Element> DeviceTable<T> {
    fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        Ok(Self { buffer: Buffer::new(device, 0, "an empty table")? })
    }

    fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        table: &Table<T>,
    ) -> Result<(), BackendError> {
        let all = table.as_slice();
        if all.len() > self.buffer.len() {
            // Half as much again, so that a growing crowd is not copied at every step.
            let room =
                if self.buffer.len() == 0 { all.len() } else { all.len().max(self.buffer.len() * 3 / 2) };
            let mut grown = Buffer::new(device, room, table.name())?;
            write(device, queue, &mut grown, table, 0..all.len())?;
            // Only now: a buffer that could not be filled must not be taken for a full one.
            self.buffer = grown;
            return Ok(());
        }
        let first = table.changed().min().map_or(0, |first| first as usize);
        let end = table.changed().max().map_or(0, |last| last as usize + 1);
        write(device, queue, &mut self.buffer, table, first..end)?;
        write(device, queue, &mut self.buffer, table, table.tail())
    }
}

fn write<T: Element>(
    device: &OpenClDevice,
    queue: &CommandQueue,
    buffer: &mut Buffer<T>,
    table: &Table<T>,
    changed: Range<usize>,
) -> Result<(), BackendError> {
    let result = buffer.write(queue, changed.start, &table.as_slice()[changed]);
    result.map_err(|e| device.failed(&format!("write {}", table.name()), &e))
}

macro_rules! device_tables {
    ($($(#[$doc:meta])* $name:ident: $element:ty),* $(,)?) => {
        /// All tables on the device.
        pub(crate) struct DeviceTables { $(pub(crate) $name: DeviceTable<$element>),* }

        impl DeviceTables {
            pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
                Ok(Self { $($name: DeviceTable::new(device)?),* })
            }

            pub(crate) fn update(
                &mut self,
                device: &OpenClDevice,
                queue: &CommandQueue,
                tables: &Tables,
            ) -> Result<(), BackendError> {
                $(self.$name.update(device, queue, tables.$name())?;)*
                Ok(())
            }

            /// Whether every table of the host has room here, as it has after an update.
            pub(crate) fn hold(&self, tables: &Tables) -> bool {
                true $(&& tables.$name().as_slice().len() <= self.$name.buffer.len())*
            }

            pub(crate) fn bytes(&self) -> usize {
                0 $(+ self.$name.buffer.bytes())*
            }
        }
    };
}

populace_core::with_tables!(device_tables);
