//! Work-items of the fused schedules: the members that each takes, and where it stores
//! `model_from_joint`.

use populace_device::layout::{Float4, JOINT_BLOCK};
use populace_device::{BackendError, Tables};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::handles::Kernel;
use crate::launch::{Launch, WorkSize};
use crate::tables::DeviceTables;
use crate::waits;

/// Work-items of the wide form for each core: enough to balance the load.
const ITEMS_PER_CORE: usize = 32;
/// Members side by side in the lanes of a work-item of the wide form.
const LANES: usize = JOINT_BLOCK as usize;
/// `Float4`s of a joint's matrices in lanes of members.
const MATRICES: usize = 12 * LANES / 4;
/// Extra elements in each array of rows in local memory. Bodies are padded to 16, so the first rows
/// of the three arrays are three times 16 bytes apart, modulo 128: the eight rows of the palette
/// that are computed at once then come from all 32 banks.
const STRIDE_PAST_BODY: usize = 3;

pub(super) enum Dispatch {
    /// `fused_wide.cl`: each of several work-items for each core takes a run of members, and a desk
    /// in global memory for the matrices of those in its lanes.
    Wide {
        /// A desk for each.
        cores: usize,
        /// For each desk 1 while a work-item has it.
        is_taken: Buffer<u32>,
        desks: Buffer<Float4>,
    },
    /// `fused_grouped.cl`: a work-group for each member. Matrices are in local memory.
    Grouped {
        group: usize,
        /// Elements of each of the three arrays of rows; 0 before the first update.
        stride: usize,
        /// Bytes of local memory that the kernel takes in addition to the rows.
        other_bytes: u64,
    },
}

impl Dispatch {
    pub(super) fn wide(device: &OpenClDevice) -> Result<Self, BackendError> {
        let cores = device.info.compute_units as usize;
        let mut is_taken = Buffer::new(device, cores, "a flag for each desk")?;
        let queue = device.queue()?;
        let cleared = is_taken.clear(&queue, 0..cores).and_then(|()| waits::for_queue(&queue));
        cleared.map_err(|e| device.failed("clear the flags of desks", &e))?;
        Ok(Self::Wide { cores, is_taken, desks: Buffer::new(device, 0, "an empty buffer")? })
    }

    /// For a kernel that was built for work-groups of `group` work-items.
    pub(super) fn grouped(
        device: &OpenClDevice,
        kernel: &Kernel,
        group: usize,
    ) -> Result<Self, BackendError> {
        let other_bytes = kernel.get_local_mem_size(device.device.id());
        let other_bytes =
            other_bytes.map_err(|e| device.failed("query a kernel's local memory", &e))?;
        Ok(Self::Grouped { group, stride: 0, other_bytes })
    }

    /// Grows to the matrices of the largest body.
    pub(super) fn update(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        if self.holds(tables) {
            return Ok(());
        }
        match self {
            Self::Wide { cores, desks, .. } => {
                let needed = desks_for(*cores, tables);
                *desks = Buffer::new(device, needed, "matrices of members in progress")?;
            }
            Self::Grouped { stride, other_bytes, .. } => {
                let needed = stride_for(tables);
                let bytes = (3 * needed * size_of::<Float4>()) as u64 + *other_bytes;
                let available = device.info.local_memory_bytes;
                if bytes > available {
                    let device = device.info.name.clone();
                    return Err(BackendError::BodyTooLarge {
                        device,
                        joints: joints_most(tables),
                        bytes,
                        available,
                    });
                }
                *stride = needed;
            }
        }
        Ok(())
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(super) fn holds(&self, tables: &Tables) -> bool {
        match self {
            Self::Wide { cores, desks, .. } => desks_for(*cores, tables) <= desks.len(),
            Self::Grouped { stride, .. } => stride_for(tables) <= *stride,
        }
    }

    /// Returns the bytes of global memory.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Wide { desks, is_taken, .. } => desks.bytes() + is_taken.bytes(),
            Self::Grouped { .. } => 0,
        }
    }

    /// Sets the tables that only one of the two forms reads.
    pub(super) fn tables<'a>(&self, launch: Launch<'a>, tables: &DeviceTables) -> Launch<'a> {
        match self {
            Self::Wide { .. } => launch
                .buffer("sources", &tables.sources.buffer)
                .buffer("source_lanes", &tables.source_lanes.buffer),
            Self::Grouped { .. } => launch
                .buffer("levels", &tables.levels.buffer)
                .buffer("joint_maps", &tables.joint_maps.buffer),
        }
    }

    /// Sets the scratch memory of the frame's kernel, and returns the work size for `members`
    /// members.
    pub(super) fn frame<'a>(
        &self,
        launch: Launch<'a>,
        host: &Tables,
        members: usize,
    ) -> (Launch<'a>, WorkSize) {
        match self {
            Self::Wide { cores, is_taken, desks } => {
                let run = members.div_ceil(cores * ITEMS_PER_CORE).next_multiple_of(LANES);
                let launch = launch
                    .count("member_count", members)
                    .count("run", run)
                    .count("padded_most", host.padded_most())
                    .count("desk_count", *cores)
                    .buffer("is_taken", is_taken)
                    .buffer("desks", desks);
                (launch, WorkSize::line(members.div_ceil(run), 1))
            }
            Self::Grouped { .. } => self.member(launch, members),
        }
    }

    /// Sets the scratch memory of a kernel with a work-item or a work-group for each member, and
    /// returns the work size for `members` members.
    pub(super) fn member<'a>(&self, launch: Launch<'a>, members: usize) -> (Launch<'a>, WorkSize) {
        match self {
            Self::Wide { desks, .. } => (launch.buffer("desks", desks), WorkSize::line(members, 1)),
            Self::Grouped { group, stride, .. } => {
                let launch =
                    launch.count("stride", *stride).local::<Float4>("model_rows", 3 * stride);
                (launch, WorkSize::line(members * group, *group))
            }
        }
    }
}

fn desks_for(cores: usize, tables: &Tables) -> usize {
    cores * tables.padded_most() * MATRICES
}

fn stride_for(tables: &Tables) -> usize {
    tables.padded_most() + STRIDE_PAST_BODY
}

fn joints_most(tables: &Tables) -> usize {
    tables.bodies().as_slice().iter().map(|body| body.joint_count as usize).max().unwrap_or(0)
}
