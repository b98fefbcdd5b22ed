//! Handles to what a crowd holds.

/// A character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterId {
    pub(crate) crowd: u32,
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

impl CharacterId {
    /// The character's index, unique among the present characters of the crowd. Characters that are
    /// added one after the other have the indices 0, 1, 2 and so on; the index of a removed
    /// character is used again.
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
    pub(crate) generation: u32,
}

/// The index of a clip in the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ClipIndex(pub(crate) u32);

/// A mask of a crowd, for the members of one character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskId {
    pub(crate) character: CharacterId,
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// A blend space of a crowd. Members of any character can play it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlendSpaceId {
    pub(crate) crowd: u32,
    pub(crate) index: u32,
    pub(crate) generation: u32,
}

/// A state machine of a crowd. Members of any character can run it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MachineId {
    pub(crate) crowd: u32,
    pub(crate) index: u32,
    pub(crate) generation: u32,
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

/// A parameter of a state machine, in place of its name; see
/// [`Crowd::parameter`](crate::Crowd::parameter).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterId {
    pub(crate) machine: MachineId,
    pub(crate) index: u32,
}

/// A parameter of a state machine, by name or by id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter<'a> {
    /// The parameter of this name, of whatever machines the member runs.
    Name(&'a str),
    /// A parameter of one machine.
    Id(ParameterId),
}

impl<'a> From<&'a str> for Parameter<'a> {
    fn from(name: &'a str) -> Self {
        Self::Name(name)
    }
}

impl From<ParameterId> for Parameter<'_> {
    fn from(id: ParameterId) -> Self {
        Self::Id(id)
    }
}
