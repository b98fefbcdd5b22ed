//! Handles to what a crowd holds.

use populace_clip::ClipIndex;

/// A character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterId {
    pub(crate) crowd: u32,
    pub(crate) index: u32,
}

impl CharacterId {
    /// The order in which the character was added, from 0.
    #[must_use]
    pub const fn index(self) -> usize {
        self.index as usize
    }
}

/// A clip of a crowd. Any member can play it: it binds to joints by name, and to other bodies by
/// their humanoid roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClipId {
    pub(crate) crowd: u32,
    pub(crate) index: ClipIndex,
}

/// A mask of a crowd, for the members of one character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskId {
    pub(crate) character: CharacterId,
    pub(crate) first: u32,
}

/// A handle to a member. It goes stale when the member is despawned, and is then refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MemberId {
    pub(crate) crowd: u32,
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

impl MemberId {
    /// The member's index, below the crowd's capacity and unique among present members. User stages
    /// receive it.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.index
    }
}

/// A handle to a clip or state machine that was started on a member. It goes stale when another
/// clip takes its slot after it has faded out, and when something else replaces it before its
/// scheduled start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlaybackId {
    pub(crate) member: MemberId,
    pub(crate) serial: u32,
}

impl PlaybackId {
    /// The member that plays it.
    #[must_use]
    pub const fn member(self) -> MemberId {
        self.member
    }
}
