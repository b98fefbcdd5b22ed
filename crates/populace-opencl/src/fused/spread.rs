//! How the fused schedules spread members over work-items, and where these keep `model_from_joint`.

use opencl3::kernel::Kernel;
use populace_device::layout::{Float4, MEMBERS_PER_BATCH};
use populace_device::{BackendError, Tables};

use super::MATRIX;
use crate::OpenClDevice;
use crate::backend::narrow;
use crate::buffer::Buffer;
use crate::launch::Launch;
use crate::tables::DeviceTables;

/// Desks for each core, where the matrices of one member lie: enough work-items to even out their
/// work, few enough that their matrices take little memory.
const DESKS_PER_CORE: usize = 32;
/// The same where members wait for each other: twice as many for a fourth of the work-items.
const SCRATCH_BATCHES: usize = 2 * DESKS_PER_CORE;
/// What rows of matrices in local memory are longer than the largest body by. Bodies are padded to
/// 16, so that the first rows of the three arrays stand three times 16 bytes apart, modulo 128: the
/// eight rows of the palette that are computed at once then come out of all 32 banks.
const STRIDE_PAST_BODY: usize = 3;

pub(super) enum Spread {
    /// `fused_wide.cl`: each of some work-items for each core takes a run of members; the matrices
    /// of those that it is at are in global memory.
    Wide { cores: usize, matrices: Buffer<Float4> },
    /// `fused_grouped.cl`: a work-group for each member; matrices are in local memory.
    Grouped {
        group: usize,
        /// Elements of each of the three arrays of rows; 0 before the first update.
        stride: usize,
        /// Bytes of local memory that the kernel takes beside them.
        beside_bytes: u64,
    },
}

/// Global and local sizes of a launch.
type Range = ([usize; 2], [usize; 2]);

impl Spread {
    pub(super) fn wide(device: &OpenClDevice) -> Result<Self, BackendError> {
        let cores = device.info.compute_units as usize;
        Ok(Self::Wide { cores, matrices: Buffer::new(device, 0, "an empty buffer")? })
    }

    /// For a kernel built for groups of that size.
    pub(super) fn grouped(
        device: &OpenClDevice,
        kernel: &Kernel,
        group: usize,
    ) -> Result<Self, BackendError> {
        let beside_bytes = kernel.get_local_mem_size(device.device.id());
        let beside_bytes =
            beside_bytes.map_err(|e| device.failed("tell a kernel's local memory", &e))?;
        Ok(Self::Grouped { group, stride: 0, beside_bytes })
    }

    /// Makes room for the matrices of the largest body.
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
                    room_for(*cores, tables),
                    "the matrices of members at work",
                )?;
            }
            Self::Grouped { stride, beside_bytes, .. } => {
                let wished = stride_for(tables);
                let bytes = (3 * wished * size_of::<Float4>()) as u64 + *beside_bytes;
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
                *stride = wished;
            }
        }
        Ok(())
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(super) fn holds(&self, tables: &Tables) -> bool {
        match self {
            Self::Wide { cores, matrices } => room_for(*cores, tables) <= matrices.len(),
            Self::Grouped { stride, .. } => stride_for(tables) <= *stride,
        }
    }

    /// Bytes of global memory.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Wide { matrices, .. } => matrices.bytes(),
            Self::Grouped { .. } => 0,
        }
    }

    /// Sets the tables that one form reads and the other does not.
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

    /// Sets what the frame's kernel works in for so many members.
    pub(super) fn frame<'a>(
        &self,
        launch: Launch<'a>,
        host: &Tables,
        members: usize,
    ) -> (Launch<'a>, Range) {
        match self {
            Self::Wide { cores, matrices } => {
                let (desks, abreast) = desks(host);
                let run = members.div_ceil(cores * desks / abreast);
                let launch = launch
                    .uint("member_count", narrow(members))
                    .uint("run", narrow(run))
                    .uint("abreast", narrow(abreast))
                    .uint("padded_most", narrow(host.padded_most()))
                    .buffer("matrices", matrices);
                (launch, ([members.div_ceil(run), 1], [1, 1]))
            }
            Self::Grouped { .. } => self.member(launch, members),
        }
    }

    /// Sets what a kernel works in that takes a work-item or a work-group for each of so many
    /// members.
    pub(super) fn member<'a>(&self, launch: Launch<'a>, members: usize) -> (Launch<'a>, Range) {
        match self {
            Self::Wide { .. } => (launch, ([members, 1], [1, 1])),
            Self::Grouped { group, stride, .. } => {
                let launch = launch
                    .uint("stride", narrow(*stride))
                    .local::<Float4>("model_rows", 3 * stride);
                (launch, ([members * group, 1], [*group, 1]))
            }
        }
    }
}

/// Desks for each core, and how many of them a work-item has: members that nothing but clips moves
/// never wait for others.
fn desks(tables: &Tables) -> (usize, usize) {
    if tables.controls().as_slice().is_empty() {
        (DESKS_PER_CORE, 1)
    } else {
        (SCRATCH_BATCHES, MEMBERS_PER_BATCH as usize)
    }
}

fn room_for(cores: usize, tables: &Tables) -> usize {
    cores * desks(tables).0 * tables.padded_most() * MATRIX
}

fn stride_for(tables: &Tables) -> usize {
    tables.padded_most() + STRIDE_PAST_BODY
}

fn joints_most(tables: &Tables) -> usize {
    tables.bodies().as_slice().iter().map(|body| body.joint_count as usize).max().unwrap_or(0)
}
