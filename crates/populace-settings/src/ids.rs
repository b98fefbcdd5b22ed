//! Handles to what a crowd holds.

/// The parts of most ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Key {
    /// The number of the crowd.
    pub crowd: u32,
    /// The index in the crowd. Indices are used again.
    pub index: u32,
    /// Tells the uses of one index apart.
    pub generation: u32,
}

/// A character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterId(pub(crate) Key);

impl CharacterId {
    /// The character's index, unique among the present characters of the crowd. Characters that are
    /// added one after the other have the indices 0, 1, 2 and so on; the index of a removed
    /// character is used again.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0.index as usize
    }
}

/// A clip of a crowd. Any member can play it: it binds to joints by name, and to other bodies by
/// their humanoid roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClipId(pub(crate) Key);

/// A mask of a crowd, for the members of one character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskId(pub(crate) MaskParts);

/// The parts of a [`MaskId`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskParts {
    /// The character that the mask is for.
    pub character: CharacterId,
    /// The index among the masks of the character.
    pub index: u32,
    /// Tells the uses of one index apart.
    pub generation: u32,
}

/// A blend space of a crowd. Members of any character can play it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlendSpaceId(pub(crate) Key);

/// A state machine of a crowd. Members of any character can run it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MachineId(pub(crate) Key);

/// A handle to a member. It goes stale when the member is despawned, and is then refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MemberId(pub(crate) Key);

impl MemberId {
    /// The member's index, below the crowd's capacity and unique among present members. User stages
    /// receive it.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.0.index
    }
}

/// A handle to a clip or state machine that was started on a member. It goes stale when another
/// clip takes its slot after it has faded out, and when something else replaces it before its
/// scheduled start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlaybackId(pub(crate) PlaybackParts);

/// The parts of a [`PlaybackId`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlaybackParts {
    /// The member that plays it.
    pub member: MemberId,
    /// The number of the start, which no other start of the crowd has.
    pub serial: u64,
}

impl PlaybackId {
    /// The member that plays it.
    #[must_use]
    pub const fn member(self) -> MemberId {
        self.0.member
    }
}

/// A parameter of a state machine, in place of its name; see `Crowd::parameter`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterId(pub(crate) ParameterParts);

/// The parts of a [`ParameterId`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterParts {
    /// The machine that has the parameter.
    pub machine: MachineId,
    /// The index among the parameters of the machine.
    pub index: u32,
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
