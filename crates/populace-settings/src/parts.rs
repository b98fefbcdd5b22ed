//! The parts of ids and settings, for the crowd alone: `populace` does not re-export this module.

use crate::{
    BlendSpaceId, BlendSpacePlayback, CharacterId, ClipId, ClipPlayback, MachineId,
    MachinePlayback, MaskId, MemberId, ParameterId, PlaybackId, Reach, StageUse, Weight,
};

pub use crate::blend_space::{MOST, Weights, phase_offset, slots_needed, weights_at};
pub use crate::check::{Check, bounded, check_layer, check_secs, check_weight, finite};
pub use crate::control::{ReachParts, WeightParts, device_target};
pub use crate::feet::{check_contact, contact_row, stride_row};
pub use crate::ids::{Key, MaskParts, ParameterParts, PlaybackParts};
pub use crate::machine::{Compiled, CompiledState, compile, find};
pub use crate::playback::{Mode, Playback};
pub use crate::stage::StageUseParts;

/// A type whose parts its users do not see.
pub trait Parts {
    /// The parts.
    type Parts;

    /// Returns the value that is made of `parts`.
    fn from_parts(parts: Self::Parts) -> Self;

    /// Returns the parts of the value.
    fn parts(self) -> Self::Parts;
}

macro_rules! made_of {
    ($($whole:ident: $parts:ident,)*) => {
        $(impl Parts for $whole {
            type Parts = $parts;

            fn from_parts(parts: $parts) -> Self {
                Self(parts)
            }

            fn parts(self) -> $parts {
                self.0
            }
        })*
    };
}
made_of!(
    CharacterId: Key,
    ClipId: Key,
    BlendSpaceId: Key,
    MachineId: Key,
    MemberId: Key,
    MaskId: MaskParts,
    PlaybackId: PlaybackParts,
    ParameterId: ParameterParts,
    ClipPlayback: Playback,
    BlendSpacePlayback: Playback,
    MachinePlayback: Playback,
    Reach: ReachParts,
    StageUse: StageUseParts,
    Weight: WeightParts,
);
