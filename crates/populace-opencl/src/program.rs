//! Source texts of the programs: layouts and constants from `populace-device`, then the kernels.

use populace_device::UserStage;
use populace_device::layout::{JOINT_BLOCK, MAX_SLOTS, MAX_STEP_ROTATIONS};

/// Variants of the kernels: what a work-item computes at once, and where fused kernels keep a
/// member's slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Form {
    /// Upload of changes, for all schedules.
    Common,
    /// Lower bound of a schedule's time, for benchmarks.
    Floor,
    /// One joint for each work-item, through global memory.
    Staged,
    /// Members of a body side by side, and joints of one while clips are mixed: 8 or 16 of each.
    Wide { lanes: usize },
    /// One joint at a time, and work-groups that compute a few members of one body side by side.
    Grouped(GroupShape),
}

/// Work-groups of the grouped form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct GroupShape {
    /// Work-items in a work-group; a multiple of `batch`.
    pub(crate) group: usize,
    /// Members of one body that a group computes side by side, at most.
    pub(crate) batch: usize,
}

/// Elements of local memory for each slot, as many as a `Playing` of 32 bytes takes.
const PLAYING_ELEMENTS: usize = 2;
/// Extra elements in each array of rows in local memory. Bodies are padded to 16, so the first rows
/// of the three arrays are three times 16 bytes apart, modulo 128: the eight rows of the palette
/// that are computed at once then come from all 32 banks.
const STRIDE_PAST_BODY: usize = 3;

/// Returns the elements of a member's share of a group's local memory: three arrays of rows, what
/// it plays, and rotations of its steps unless it is plain. The number is odd, so that the same row
/// of eight members comes from all 32 banks. `padded` is a multiple of 16.
pub(crate) fn share_of(padded: usize, plain: bool) -> usize {
    let rotations = if plain { 0 } else { MAX_STEP_ROTATIONS as usize };
    3 * (padded + STRIDE_PAST_BODY) + PLAYING_ELEMENTS * MAX_SLOTS as usize + rotations
}

impl GroupShape {
    /// Divides a group of at most `work_items` among members: up to 16 work-items each, for a block
    /// of joints in a row of a clip.
    pub(crate) fn of(work_items: usize) -> Self {
        let batch = (work_items / JOINTS_MOST).max(1);
        Self { group: batch * work_items.min(JOINTS_MOST), batch }
    }
}

/// Most work-items of a member.
const JOINTS_MOST: usize = JOINT_BLOCK as usize;
// While a work-item computes a pose, it keeps three elements in place of its member's rotations.
const _: () = assert!(3 * JOINTS_MOST <= MAX_STEP_ROTATIONS as usize);

impl Form {
    fn settings(self) -> String {
        match self {
            Self::Common | Self::Floor => String::new(),
            Self::Staged => "#define LANES 1\n".into(),
            Self::Wide { lanes } => format!("#define LANES {lanes}\n#define FUSED __private\n"),
            Self::Grouped(GroupShape { group, batch }) => format!(
                "#define LANES 1\n#define FUSED __local\n\
                 #define GROUP {group}u\n#define BATCH {batch}u\n#define JOINTS {}u\n\
                 #define PLAYING_ELEMENTS {PLAYING_ELEMENTS}u\n\
                 #define STRIDE_PAST_BODY {STRIDE_PAST_BODY}u\n",
                group / batch
            ),
        }
    }

    fn kernels(self) -> &'static [&'static str] {
        match self {
            Self::Common => &[include_str!("../kernels/apply_changes.cl")],
            Self::Floor => &[include_str!("../kernels/floor.cl")],
            Self::Staged => &[
                include_str!("../kernels/evaluate.cl"),
                include_str!("../kernels/pose.cl"),
                include_str!("../kernels/transform.cl"),
                include_str!("../kernels/write_back.cl"),
            ],
            Self::Wide { .. } => &[
                include_str!("../kernels/fused.cl"),
                include_str!("../kernels/company.cl"),
                include_str!("../kernels/layers.cl"),
                include_str!("../kernels/abreast.cl"),
                include_str!("../kernels/fused_wide.cl"),
            ],
            Self::Grouped(_) => {
                &[include_str!("../kernels/fused.cl"), include_str!("../kernels/fused_grouped.cl")]
            }
        }
    }

    /// Returns the OpenCL C text as one string, since the driver binding crashes when given a list.
    /// `stages` is the text that users' stages add, or empty.
    pub(crate) fn source(self, stages: &str) -> String {
        // Contraction to a fused multiply-add would differ from the native stages in the last bit.
        let rules = "#pragma OPENCL FP_CONTRACT OFF\n";
        let settings = self.settings();
        let arithmetic = [
            include_str!("../kernels/lanes.cl"),
            include_str!("../kernels/real.cl"),
            include_str!("../kernels/quat.cl"),
            include_str!("../kernels/vec3.cl"),
            include_str!("../kernels/local.cl"),
            include_str!("../kernels/affine.cl"),
            include_str!("../kernels/angle.cl"),
            include_str!("../kernels/matrices.cl"),
            include_str!("../kernels/members.cl"),
            include_str!("../kernels/slot.cl"),
            include_str!("../kernels/machines.cl"),
            include_str!("../kernels/rows.cl"),
            include_str!("../kernels/playback.cl"),
            include_str!("../kernels/stages.cl"),
            include_str!("../kernels/sums.cl"),
            include_str!("../kernels/joint.cl"),
            include_str!("../kernels/inertialize.cl"),
            include_str!("../kernels/hierarchy.cl"),
            include_str!("../kernels/targets.cl"),
            include_str!("../kernels/kernel_parameters.cl"),
            include_str!("../kernels/programs.cl"),
            include_str!("../kernels/gaze.cl"),
            include_str!("../kernels/limb.cl"),
            include_str!("../kernels/chain.cl"),
            include_str!("../kernels/contacts.cl"),
            include_str!("../kernels/foot_state.cl"),
            include_str!("../kernels/foothold.cl"),
            include_str!("../kernels/foot.cl"),
            include_str!("../kernels/feet.cl"),
            include_str!("../kernels/motion.cl"),
            include_str!("../kernels/constraints.cl"),
        ];
        let arithmetic =
            if matches!(self, Self::Common | Self::Floor) { &[][..] } else { &arithmetic };
        let prelude = populace_device::layout::opencl_prelude();
        let declared = if stages.is_empty() { "" } else { UserStage::OPENCL_C };
        let switch = if stages.is_empty() { "" } else { "#define USER_STAGES\n" };
        let head = [rules, switch, &settings, &prelude, declared].into_iter();
        let parts = head.chain(arithmetic.iter().copied()).chain(self.kernels().iter().copied());
        parts.chain([stages]).collect()
    }
}

#[cfg(test)]
mod tests;
