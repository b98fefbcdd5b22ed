//! Estimates the memory of crowds, and reads the free memory.

use populace::character::Character;
use populace::interop::PaletteSource;
use populace::model::Affine;
use populace::{Error, Schedule};
use populace_device::layout::{
    JOINT_BLOCK, LAYERS_PER_MEMBER, Layer, Member, PALETTE_BLOCK, Slot, SlotSample,
};

use crate::observer::Observer;
use crate::scene::{DeviceSetup, Scene};

/// A palette entry: one 3x4 float matrix.
pub(crate) const ENTRY_BYTES: usize = size_of::<Affine>();
/// Fraction of the free memory that is used at most.
const USABLE_SHARE: f64 = 0.85;
/// Bytes per joint stored between stages: its local and its model transform.
const STAGED_JOINT_BYTES: usize = 2 * ENTRY_BYTES;
/// Host memory of a growing table in units of its size: the old table, and a new one of twice the
/// size.
const GROWTH_FACTOR: usize = 3;
/// Host bytes per member besides the tables: its placement, handle and list entries.
const HOST_MEMBER_BYTES: usize = 80;
/// Size of the smaller of two crowds that are compared.
const SMALL_CROWD: usize = 2000;

/// Returns the bytes that may be used; `usize::MAX` if the system does not report free memory.
pub(crate) fn free_bytes() -> usize {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|rest| rest.trim().trim_end_matches(" kB").parse::<usize>().ok());
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count, not negative"
    )]
    let share = |kib: usize| (kib as f64 * 1024.0 * USABLE_SHARE) as usize;
    kib.map_or(usize::MAX, share)
}

/// Returns the bytes of all palettes of a scene.
pub(crate) fn palette_bytes(scene: &Scene) -> usize {
    scene.total(|character| character.palette.len().next_multiple_of(PALETTE_BLOCK as usize))
        * ENTRY_BYTES
}

/// Returns an upper estimate of a crowd's bytes on the device and the host together.
pub(crate) fn crowd_bytes(scene: &Scene, on: &DeviceSetup, schedule: Schedule) -> usize {
    let playing = size_of::<Member>()
        + scene.slot_count * size_of::<Slot>()
        + LAYERS_PER_MEMBER as usize * size_of::<Layer>()
        + size_of::<u32>();
    let copies = usize::from(!on.is_native());
    let padded = |c: &Character| c.skeleton.joint_count().next_multiple_of(JOINT_BLOCK as usize);
    let between_stages = match schedule {
        Schedule::Staged => {
            scene.total(padded) * STAGED_JOINT_BYTES
                + scene.member_count * scene.slot_count * size_of::<SlotSample>()
        }
        _ => 0,
    };
    let each = playing * (GROWTH_FACTOR + copies) + HOST_MEMBER_BYTES;
    palette_bytes(scene) + between_stages + scene.member_count * each
}

/// Returns the device bytes per further member without its palette, from the difference between
/// crowds of 4,000 and 2,000 members. `None` for the native device, which uses the host's tables,
/// and for several devices.
pub(crate) fn bytes_per_member(
    scene: &Scene,
    on: &DeviceSetup,
    schedule: Schedule,
    observer: &mut dyn Observer,
) -> Result<Option<f64>, Error> {
    if on.is_native() || on.is_shared() {
        return Ok(None);
    }
    let mut bytes = |members: usize| {
        let crowd = scene.with_members(members).set_up(on, schedule, observer)?.crowd;
        let entries: usize = crowd.page_lengths().iter().sum();
        Ok::<_, Error>(crowd.device_info().memory_bytes as f64 - (entries * ENTRY_BYTES) as f64)
    };
    Ok(Some((bytes(2 * SMALL_CROWD)? - bytes(SMALL_CROWD)?) / SMALL_CROWD as f64))
}
