//! What can go wrong with ragdolls; none of it harms them or the crowd.

/// Why a call was refused. Ragdolls and crowd are as they were before.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The crowd refused: a stale member, or a failing device.
    #[error(transparent)]
    Crowd(#[from] populace::Error),
    /// A plan made for another skeleton.
    #[error(
        "the plan is for a skeleton of {plan} joints, and the member has {member}; plan from the \
         member's own"
    )]
    WrongPlan {
        /// Joints of the skeleton that the plan was made from.
        plan: usize,
        /// Joints of the member's skeleton.
        member: usize,
    },
    /// A joint that no body of the plan carries, or that the skeleton does not have.
    #[error("joint {joint} is carried by no body of the ragdoll")]
    NoBody {
        /// Index in level order.
        joint: u32,
    },
    /// A member that is not limp, or not at that joint.
    #[error("the member is not limp there; let it go limp first")]
    NotLimp,
    /// A number that would poison the simulation.
    #[error("{what} is {value}; it must be {rule}")]
    BadValue {
        /// What was given.
        what: &'static str,
        /// The value.
        value: f32,
        /// What is allowed.
        rule: &'static str,
    },
}

/// Refuses values that are not finite.
pub(crate) fn finite(what: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(Error::BadValue { what, value, rule: "a finite number" }),
        None => Ok(()),
    }
}

/// Refuses times that are negative or not finite.
pub(crate) fn seconds(what: &'static str, value: f32) -> Result<(), Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::BadValue { what, value, rule: "finite and not negative" })
    }
}
