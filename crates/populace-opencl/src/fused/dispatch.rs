//! Work-items of the fused schedules: the members that each takes, and where it stores
//! `model_from_joint`.

use populace_device::layout::Float4;
use populace_device::{BackendError, Tables};

use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::handles::Kernel;
use crate::launch::{Launch, WorkSize};
use crate::program::{GroupShape, share_of};
use crate::tables::DeviceTables;
use crate::waits;

/// Work-items of the wide form for each core: enough to balance the load.
const ITEMS_PER_CORE: usize = 32;

/// Division of a frame among work-items, and their scratch memory.
pub(super) enum Dispatch {
    /// `fused_wide.cl`: each of several work-items for each core takes a run of members, and a desk
    /// in global memory for the matrices of those in its lanes.
    Wide {
        /// A desk for each.
        cores: usize,
        /// Members side by side in a work-item.
        lanes: usize,
        /// For each desk 1 while a work-item has it.
        is_taken: Buffer<u32>,
        desks: Buffer<Float4>,
    },
    /// `fused_grouped.cl`: a work-group for a batch of members. Matrices are in local memory.
    Grouped {
        shape: GroupShape,
        /// Joints of the largest body, padded; 0 before the first update.
        padded: usize,
        /// Elements of local memory for members.
        room: usize,
        /// Bytes of local memory that the kernel takes in addition to those of members.
        other_bytes: u64,
    },
}

impl Dispatch {
    pub(super) fn wide(device: &OpenClDevice, lanes: usize) -> Result<Self, BackendError> {
        let cores = device.info.compute_units as usize;
        let mut is_taken = Buffer::new(device, cores, "a flag for each desk")?;
        let queue = device.queue()?;
        let cleared = is_taken.clear(&queue, 0..cores).and_then(|()| waits::for_queue(&queue));
        cleared.map_err(|e| device.failed("clear the flags of desks", &e))?;
        let desks = Buffer::new(device, 0, "an empty buffer")?;
        Ok(Self::Wide { cores, lanes, is_taken, desks })
    }

    /// For a kernel that was built for work-groups of this shape.
    pub(super) fn grouped(
        device: &OpenClDevice,
        kernel: &Kernel,
        shape: GroupShape,
    ) -> Result<Self, BackendError> {
        let other_bytes = kernel.get_local_mem_size(device.device.id());
        let other_bytes =
            other_bytes.map_err(|e| device.failed("query a kernel's local memory", &e))?;
        Ok(Self::Grouped { shape, padded: 0, room: 0, other_bytes })
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
            Self::Wide { cores, lanes, desks, .. } => {
                let needed = desks_for(*cores, *lanes, tables);
                *desks = Buffer::new(device, needed, "matrices of members in progress")?;
            }
            Self::Grouped { padded, room, other_bytes, .. } => {
                let needed = tables.padded_most();
                let share = share_of(needed, false);
                let available = device.info.local_memory_bytes;
                let left = available.saturating_sub(*other_bytes) / size_of::<Float4>() as u64;
                let left = usize::try_from(left).unwrap_or(usize::MAX);
                if left < share {
                    return Err(BackendError::BodyTooLarge {
                        device: device.info.name.clone(),
                        joints: joints_most(tables),
                        bytes: (share * size_of::<Float4>()) as u64 + *other_bytes,
                        available,
                    });
                }
                (*padded, *room) = (needed, left);
            }
        }
        Ok(())
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(super) fn holds(&self, tables: &Tables) -> bool {
        match self {
            Self::Wide { cores, lanes, desks, .. } => {
                desks_for(*cores, *lanes, tables) <= desks.len()
            }
            Self::Grouped { padded, room, .. } => *room > 0 && tables.padded_most() <= *padded,
        }
    }

    /// Returns the bytes of global memory.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Wide { desks, is_taken, .. } => desks.bytes() + is_taken.bytes(),
            Self::Grouped { .. } => 0,
        }
    }

    /// Sets the tables that only the grouped form reads.
    pub(super) fn tables<'a>(&self, launch: Launch<'a>, tables: &DeviceTables) -> Launch<'a> {
        match self {
            Self::Wide { .. } => launch,
            Self::Grouped { .. } => launch.buffer("levels", &tables.levels.buffer),
        }
    }

    /// Sets the scratch memory of a kernel of the frame, and returns the work size for `members`
    /// members. Members of the plain kernel have no step rotations.
    pub(super) fn frame<'a>(
        &self,
        launch: Launch<'a>,
        host: &Tables,
        members: usize,
        plain: bool,
    ) -> (Launch<'a>, WorkSize) {
        match self {
            Self::Wide { cores, lanes, is_taken, desks } => {
                let run = members.div_ceil(cores * ITEMS_PER_CORE).next_multiple_of(*lanes);
                let launch = launch
                    .count("member_count", members)
                    .count("run", run)
                    .count("padded_most", host.padded_most())
                    .count("desk_count", *cores)
                    .buffer("is_taken", is_taken)
                    .buffer("desks", desks);
                (launch, WorkSize::of(members.div_ceil(run), 1))
            }
            Self::Grouped { shape, padded, room, .. } => {
                let share = share_of(*padded, plain);
                // Where only few of the largest body fit, others of the crowd fill whole batches.
                let fit = *room / share;
                let run = if 2 * fit < shape.batch { shape.batch } else { shape.batch.min(fit) };
                let launch = launch.count("member_count", members).count("run", run);
                let size = WorkSize::of(members.div_ceil(run) * shape.group, shape.group);
                (local_memory(launch, (shape.batch * share).min(*room)), size)
            }
        }
    }

    /// Sets the scratch memory of the kernel of one member, and returns its work size.
    pub(super) fn member<'a>(&self, launch: Launch<'a>) -> (Launch<'a>, WorkSize) {
        match self {
            Self::Wide { desks, .. } => (launch.buffer("desks", desks), WorkSize::of(1, 1)),
            Self::Grouped { shape, padded, .. } => {
                let memory = share_of(*padded, false);
                (local_memory(launch, memory), WorkSize::of(1, shape.group))
            }
        }
    }
}

/// Sets the local memory for the members of a group.
fn local_memory(launch: Launch<'_>, elements: usize) -> Launch<'_> {
    launch.count("room", elements).local::<Float4>("memory", elements)
}

/// Returns the `Float4`s of all desks: twelve numbers for each joint and lane.
fn desks_for(cores: usize, lanes: usize, tables: &Tables) -> usize {
    cores * tables.padded_most() * (12 * lanes / 4)
}

fn joints_most(tables: &Tables) -> usize {
    tables.bodies().as_slice().iter().map(|body| body.joint_count as usize).max().unwrap_or(0)
}
