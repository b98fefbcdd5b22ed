//! Errors of bindings.

use populace_model::ErrorKind;

/// A clip and a skeleton that do not fit. Messages say what is wrong, where, and how to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A clip that cannot move a skeleton.
    #[error("the clip \"{clip}\" cannot move this skeleton: {fault}")]
    CannotBind {
        /// The clip's name.
        clip: String,
        /// The reason.
        fault: BindingFault,
    },
}

impl Error {
    /// The kind of the error.
    #[must_use]
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::CannotBind { .. } => ErrorKind::InvalidInput,
        }
    }
}

/// The reason why a clip cannot move a skeleton.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BindingFault {
    /// A map of roles for another skeleton.
    #[error("its role map is for {wanted} joints, but the skeleton has {joints}")]
    OtherSkeleton {
        /// Joints of the map's skeleton.
        wanted: usize,
        /// Joints of the skeleton that it was given for.
        joints: usize,
    },
    /// A clip that drives nothing that both bodies have.
    #[error("it drives no joint with a humanoid role that both bodies have")]
    NoCommonRole,
    /// A clip none of whose joints the skeleton has, for lack of roles.
    #[error(
        "no joint of the skeleton has the name of a joint that the clip drives, such as \
         \"{joint}\"; humanoid roles are needed on both skeletons, but this skeleton {} them and \
         the clip's own {}; give roles with RoleMap::from_names",
        has(*skeleton_has_roles),
        has(*clip_has_roles)
    )]
    NoCommonName {
        /// Name of a joint that the clip drives.
        joint: String,
        /// Whether the skeleton's roles are known.
        skeleton_has_roles: bool,
        /// Whether the roles of the clip's own skeleton are known.
        clip_has_roles: bool,
    },
    /// A clip too few of whose joints are found by name.
    #[error(
        "only {bound} of the {moving} joints that the clip moves are found by name, less than \
         {:.0} %, and humanoid roles are not known for both skeletons; give roles with \
         RoleMap::from_names, or play the clip as it is with ClipPlayback::partial",
        100.0 * least_share
    )]
    FewJoints {
        /// Joints that were found.
        bound: usize,
        /// Joints that the clip moves.
        moving: usize,
        /// The share of them that must be found, from 0 to 1.
        least_share: f32,
    },
}

const fn has(roles: bool) -> &'static str {
    if roles { "has" } else { "has not" }
}
