//! What a crowd will take, and what there is.

use populace::character::Character;
use populace::hand_over::PaletteSource;
use populace::model::Affine;
use populace::{Error, Schedule};
use populace_device::layout::{
    JOINT_BLOCK, LAYERS_PER_MEMBER, Layer, Member, PALETTE_BLOCK, Slot, SlotSample,
};

use super::scene::{Scene, Setup};

/// A palette entry: one 3x4 float matrix.
pub(crate) const ENTRY_BYTES: usize = size_of::<Affine>();
/// Of what is free this share is taken at most.
const SHARE: f64 = 0.85;
/// Bytes of what a joint keeps between stages: its local and its model transform.
const STAGED_JOINT_BYTES: usize = 2 * ENTRY_BYTES;
/// On the host a table that grows stands there up to three times: what it was, and twice that.
const GROWTH: usize = 3;
/// Bytes beside the tables that the host keeps for each member: its placement, handle and places in
/// lists.
const HOST_MEMBER_BYTES: usize = 80;
/// Members of the smaller crowd of two that are compared.
const FEW: usize = 2000;

/// Bytes that may still be taken; without limit where the system does not tell.
pub(crate) fn free_bytes() -> usize {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|rest| rest.trim().trim_end_matches(" kB").parse::<usize>().ok());
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count, not negative"
    )]
    let share = |kib: usize| (kib as f64 * 1024.0 * SHARE) as usize;
    kib.map_or(usize::MAX, share)
}

/// Bytes of all palettes of a scene.
pub(crate) fn palette_bytes(scene: &Scene) -> usize {
    scene.total(|character| character.palette.len().next_multiple_of(PALETTE_BLOCK as usize))
        * ENTRY_BYTES
}

/// Bytes that a crowd will take in all, on the device and on the host; rather too many than too
/// few.
pub(crate) fn crowd_bytes(scene: &Scene, on: &Setup, schedule: Schedule) -> usize {
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
    let each = playing * (GROWTH + copies) + HOST_MEMBER_BYTES;
    palette_bytes(scene) + between_stages + scene.member_count * each
}

/// Bytes that each further member takes on a device beyond its palette: what a crowd of 4,000 takes
/// more than one of 2,000, by member. `None` for the native device, which works on the host's own
/// tables, and for several at once.
pub(crate) fn bytes_per_member(
    scene: &Scene,
    on: &Setup,
    schedule: Schedule,
) -> Result<Option<f64>, Error> {
    if on.is_native() || on.is_shared() {
        return Ok(None);
    }
    let beside_palettes = |members: usize| {
        let crowd = scene.with_members(members).stage(on, schedule)?.crowd;
        let entries: usize = crowd.page_lengths().iter().sum();
        Ok::<_, Error>(crowd.device_memory_bytes() as f64 - (entries * ENTRY_BYTES) as f64)
    };
    Ok(Some((beside_palettes(2 * FEW)? - beside_palettes(FEW)?) / FEW as f64))
}
