//! Work-items of the fused schedules: the members that each takes, and where it stores
//! `model_from_joint`.

use populace_device::layout::{Float4, MEMBERS_PER_BATCH};
use populace_device::{BackendError, Tables};

use super::MATRIX;
use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::handles::Kernel;
use crate::launch::{Launch, WorkSize};
use crate::tables::DeviceTables;

/// Scratches for each core: enough work-items to balance the load, few enough that their matrices
/// take little memory. If members wait for each other, there are twice as many scratches for a
/// fourth of the work-items.
const SCRATCH_PER_CORE: usize = 32;
/// Extra elements in each array of rows in local memory. Bodies are padded to 16, so the first rows
/// of the three arrays are three times 16 bytes apart, modulo 128: the eight rows of the palette
/// that are computed at once then come from all 32 banks.
const STRIDE_PAST_BODY: usize = 3;

pub(super) enum Dispatch {
    /// `fused_wide.cl`: each of several work-items for each core takes a run of members. The
    /// matrices of the members in progress are in global memory.
    Wide { cores: usize, matrices: Buffer<Float4> },
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
        Ok(Self::Wide { cores, matrices: Buffer::new(device, 0, "an empty buffer")? })
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
            Self::Wide { cores, matrices } => {
                *matrices = Buffer::new(
                    device,
                    matrices_for(*cores, tables),
                    "matrices of members in progress",
                )?;
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
            Self::Wide { cores, matrices } => matrices_for(*cores, tables) <= matrices.len(),
            Self::Grouped { stride, .. } => stride_for(tables) <= *stride,
        }
    }

    /// Returns the bytes of global memory.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Wide { matrices, .. } => matrices.bytes(),
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
            Self::Wide { cores, matrices } => {
                let scratch = WideScratch::of(host);
                let run = members.div_ceil(cores * scratch.per_core / scratch.per_item);
                let launch = launch
                    .count("member_count", members)
                    .count("run", run)
                    .count("abreast", scratch.per_item)
                    .count("padded_most", host.padded_most())
                    .buffer("matrices", matrices);
                (launch, WorkSize::line(members.div_ceil(run), 1))
            }
            Self::Grouped { .. } => self.member(launch, members),
        }
    }

    /// Sets the scratch memory of a kernel with a work-item or a work-group for each member, and
    /// returns the work size for `members` members.
    pub(super) fn member<'a>(&self, launch: Launch<'a>, members: usize) -> (Launch<'a>, WorkSize) {
        match self {
            Self::Wide { .. } => (launch, WorkSize::line(members, 1)),
            Self::Grouped { group, stride, .. } => {
                let launch =
                    launch.count("stride", *stride).local::<Float4>("model_rows", 3 * stride);
                (launch, WorkSize::line(members * group, *group))
            }
        }
    }
}

/// Size of the wide kernel's scratch memory. One scratch holds the matrices of one member.
struct WideScratch {
    per_core: usize,
    /// More than 1 only if members have constraints. Other members never wait.
    per_item: usize,
}

impl WideScratch {
    fn of(tables: &Tables) -> Self {
        if tables.controls().as_slice().is_empty() {
            Self { per_core: SCRATCH_PER_CORE, per_item: 1 }
        } else {
            Self { per_core: 2 * SCRATCH_PER_CORE, per_item: MEMBERS_PER_BATCH as usize }
        }
    }
}

fn matrices_for(cores: usize, tables: &Tables) -> usize {
    cores * WideScratch::of(tables).per_core * tables.padded_most() * MATRIX
}

fn stride_for(tables: &Tables) -> usize {
    tables.padded_most() + STRIDE_PAST_BODY
}

fn joints_most(tables: &Tables) -> usize {
    tables.bodies().as_slice().iter().map(|body| body.joint_count as usize).max().unwrap_or(0)
}
