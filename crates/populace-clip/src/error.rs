//! Errors in clips.

use populace_model::{ErrorKind, Property, Trs};

/// Data of no valid clip, or an invalid use of a clip. Messages say what is wrong, where, and how
/// to mend it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An invalid skeleton, track or name.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// Two tracks for one joint and property.
    #[error("two {property:?} tracks drive joint \"{joint}\"; only one is allowed")]
    DuplicateTrack {
        /// Name of the joint.
        joint: String,
        /// The property both drive.
        property: Property,
    },
    /// A live clip that is invalid, or used in an invalid way.
    #[error("the clip \"{clip}\" {fault}")]
    BadLive {
        /// The clip's name.
        clip: String,
        /// The defect.
        fault: LiveFault,
    },
    /// A clip without root motion.
    #[error("the clip \"{clip}\" {fault}")]
    NoMotion {
        /// The clip's name.
        clip: String,
        /// The reason.
        fault: MotionFault,
    },
}

impl Error {
    /// The kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Model(error) => error.kind(),
            Self::BadLive { fault: LiveFault::NoPose, .. } => ErrorKind::Stale,
            Self::DuplicateTrack { .. } | Self::BadLive { .. } | Self::NoMotion { .. } => {
                ErrorKind::InvalidInput
            }
        }
    }
}

/// The defect of a live clip, or of its use.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LiveFault {
    /// A rate of rows out of range.
    #[error("has {rows_per_sec} rows per second; it must be from 1 to 1000")]
    RowRate {
        /// The rate given.
        rows_per_sec: f32,
    },
    /// A length of the ring out of range.
    #[error("keeps {secs} seconds of rows; it must be above 0 s and at most 3.6 million rows")]
    RingLength {
        /// The length given, in seconds.
        secs: f32,
    },
    /// A clip that is not live.
    #[error("is not live; CharacterMut::add_live_clip and Clip::live make live clips")]
    NotLive,
    /// A live clip that is to be played like one that ends or loops.
    #[error("is live and has neither end nor cycle; play it with ClipPlayback::live")]
    NoEnd,
    /// A live clip that no pose has reached yet.
    #[error("has no pose yet; its first pose aligns it with the crowd's clock")]
    NoPose,
    /// A time that is not finite, or far from that of the first pose.
    #[error("got the time {time_secs} s; it must be finite and within 1e10 s of the first pose's")]
    Time {
        /// The time given, in seconds.
        time_secs: f64,
    },
    /// A pose that is not later than the one before.
    #[error("got a pose at {time_secs} s after one at {last_secs} s; times must increase")]
    TimeOrder {
        /// The pose's time in seconds.
        time_secs: f64,
        /// The time of the pose before.
        last_secs: f64,
    },
    /// A pose of another number of joints.
    #[error("got a pose of {count} joints; its skeleton has {joints}")]
    PoseLength {
        /// Transforms given.
        count: usize,
        /// Joints of the clip's skeleton.
        joints: usize,
    },
    /// A transform that no joint can have.
    #[error(
        "got {transform:?} for the joint \"{joint}\"; numbers must be finite, translations at most \
         1e9, scales at most 10,000, and rotations have a length"
    )]
    Transform {
        /// Name of the joint.
        joint: String,
        /// The transform given.
        transform: Trs,
    },
}

/// The reason why no root motion can be taken out of a clip.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MotionFault {
    /// A live clip, or one that has its root motion already.
    #[error("is live, or its root motion has been taken out already")]
    Taken,
    /// A clip that was converted to another skeleton, which has rows but no source curves.
    #[error(
        "has no source curves, because it was converted to another skeleton; take the motion out \
         of the original clip before it is converted"
    )]
    NoSource,
    /// A clip whose feet do not tell a speed.
    #[error("has no touch-down of a joint with a known foot name, so its walking speed is unknown")]
    NoTouchDown,
    /// Several joints of the name that was asked for.
    #[error("has more than one joint of the requested name")]
    AmbiguousJoint,
    /// A joint whose ancestor moves too.
    #[error("moves \"{ancestor}\", an ancestor of \"{joint}\"; choose that joint or one above it")]
    MovingAncestor {
        /// Name of the ancestor.
        ancestor: String,
        /// Name of the joint that was asked for.
        joint: String,
    },
    /// A clip that does not move the body.
    #[error(
        "has no moving joint from the root down to the hips; for a clip that walks in place use \
         MotionSource::Feet"
    )]
    NoMovingJoint,
}
