//! Errors of ragdolls.

use populace::ErrorKind;

/// The reason why a call was refused. Ragdolls and crowd are unchanged after an error.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The crowd refused the call: a stale member, or a failing device.
    #[error(transparent)]
    Crowd(#[from] populace::Error),
    /// The plan was made for another skeleton.
    #[error(
        "the plan is for a skeleton of {plan} joints, but the member has {member}; make the plan \
         from the member's own skeleton"
    )]
    WrongPlan {
        /// Number of joints of the plan's skeleton.
        plan: usize,
        /// Number of joints of the member's skeleton.
        member: usize,
    },
    /// The joint belongs to no body of the plan, or the skeleton does not have it.
    #[error("joint {joint} belongs to no body of the ragdoll; see `RagdollPlan::body_of`")]
    NoBody {
        /// Index of the joint in level order.
        joint: u32,
    },
    /// The member is not limp, or not at that joint.
    #[error(
        "the member is not limp at that joint; call `Ragdolls::go_limp` or `go_limp_from` first"
    )]
    NotLimp,
    /// A number is out of range and would corrupt the simulation.
    #[error("{what} is {value}; it must be {rule}")]
    BadValue {
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
}

impl Error {
    /// Returns the kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Crowd(error) => error.kind(),
            _ => ErrorKind::InvalidInput,
        }
    }
}

/// Fails if a value is not finite.
pub(crate) fn finite(what: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(&value) => Err(Error::BadValue { what, value, rule: "a finite number" }),
        None => Ok(()),
    }
}

/// Largest size of a gravity in m/s², a hundred times that of the Earth.
const GRAVITY_MOST: f32 = 1e3;
/// Largest size of an impulse in newton-seconds, more than that of a lorry on a motorway.
const IMPULSE_MOST: f32 = 1e7;

/// Fails if a component of a gravity is out of its range.
pub(crate) fn gravity(values: &[f32]) -> Result<(), Error> {
    within("gravity", values, GRAVITY_MOST, "from -1,000 to 1,000 m/s²")
}

/// Fails if a component of an impulse is out of its range.
pub(crate) fn impulse(values: &[f32]) -> Result<(), Error> {
    within("an impulse", values, IMPULSE_MOST, "from -10,000,000 to 10,000,000 Ns")
}

fn within(what: &'static str, values: &[f32], most: f32, rule: &'static str) -> Result<(), Error> {
    match values.iter().find(|value| !(-most..=most).contains(*value)) {
        Some(&value) => Err(Error::BadValue { what, value, rule }),
        None => Ok(()),
    }
}

/// Fails if a time is negative or not finite.
pub(crate) fn seconds(what: &'static str, value: f32) -> Result<(), Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::BadValue { what, value, rule: "finite and not negative" })
    }
}
