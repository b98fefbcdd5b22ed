//! Stages that users write: functions over one joint of one member, that run in the crowd pipeline.

use std::fmt;
use std::sync::Arc;

use populace_clip::TICKS_PER_SEC;
use populace_model::{Affine, JointIndex, Trs};

use crate::Error;
use crate::layout::STAGE_PARAMETERS;
use crate::place::Place;

/// After which stage of the pipeline a user's stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum After {
    /// Once a joint's local transform is known, with local overrides in it: before constraints,
    /// which work on what comes out.
    Pose,
    /// Once a joint's model transform is known, with constraints in it, and before an override in
    /// model space. Its children are computed after that, so that they follow, on every schedule.
    Transform,
}

/// A joint of a member, as a [`UserStage`] in Rust gets it. Its twin in OpenCL C is
/// [`UserStage::OPENCL_C`].
#[derive(Clone, Debug, PartialEq)]
pub struct StageJoint {
    /// After [`After::Pose`], to read and write: the local transform, in metres. The rotation is
    /// brought to length 1.
    pub local: Trs,
    /// After [`After::Transform`], to read and write: `model_from_joint`, in metres.
    pub model: Affine,
    /// Where the member stands in the world.
    pub place: Place,
    /// The member's own, as given when it began to use the stage.
    pub values: [f32; 4],
    /// The stage's; 0 past those that were set.
    pub parameters: [f32; STAGE_PARAMETERS as usize],
    /// Since the crowd began, [`TICKS_PER_SEC`] a second: exact for all time; see
    /// [`phase`](Self::phase).
    pub ticks: u64,
    /// Seconds since the frame before.
    pub elapsed_secs: f32,
    /// The joint, in level order.
    pub joint: JointIndex,
    /// The number of the member: that of no other while it is there.
    pub member: u32,
}

impl StageJoint {
    /// How much of a period of so many seconds has gone by, from 0 to 1: as exact after days as
    /// after seconds. Periods lie between 0.0001 and 1,000,000 seconds; others give 0. In OpenCL C
    /// `stage_phase(joint, period_secs)`.
    #[must_use]
    pub fn phase(&self, period_secs: f32) -> f32 {
        if !(1e-4..=1e6).contains(&period_secs) {
            return 0.0;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and far below 2^64"
        )]
        let period = (period_secs * TICKS_PER_SEC as f32) as u64;
        (self.ticks % period) as f32 / period as f32
    }

    /// A direction of the world in the member's model space. In OpenCL C
    /// `stage_to_model(joint, direction)`.
    #[must_use]
    pub fn to_model(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [sin, cos] = self.place.sin_cos;
        [cos * x - sin * z, y, sin * x + cos * z]
    }

    /// After [`After::Transform`]: turns the joint about its own place, by a quaternion `x y z w`
    /// of length 1 in model space. In OpenCL C `stage_turn(joint, quaternion)`.
    pub fn turn(&mut self, rotation: [f32; 4]) {
        self.model = self.model.turned(rotation);
    }
}

/// What a [`UserStage`] in Rust does with a joint.
pub type StageFn = Arc<dyn Fn(&mut StageJoint) + Send + Sync>;

/// A user's own stage: a function over one joint of one member, in OpenCL C for OpenCL devices, in
/// Rust for the native one, or in both. A crowd runs it for the members and joints that are told to
/// use it.
///
/// In OpenCL C it is a text that defines `void NAME(StageJoint *joint)` for the stage's own name,
/// with
#[doc = concat!("```c\n", include_str!("stage/joint.cl"), "```")]
/// and the functions `float stage_phase(const StageJoint *, float period_secs)`, `float4
/// stage_to_model(const StageJoint *, float4 direction)` and
/// `void stage_turn(StageJoint *, float4 quaternion)`, which are those of [`StageJoint`].
///
/// Texts of a crowd's stages are compiled as one, each distinct text once, so functions beside the
/// stage's own need names of their own too. They are OpenCL C 1.2, compiled for a single joint on
/// every schedule: no barriers, no work-item functions. `+ - *` are never fused, so that what both
/// languages compute with these alone is the same to the bit.
///
/// A stage is part of the program: a text that writes past what it is given, or never returns,
/// harms the process as such Rust would. What comes out may be anything else: a joint with a number
/// that is not finite, or beyond 1e9 either way, stays as it was before the stage, so that it never
/// reaches another member.
///
/// ```
/// use populace_device::UserStage;
///
/// let lift = UserStage::new("lift")
///     .opencl_c("void lift(StageJoint *joint) { joint->row1.w += joint->parameters[0]; }")
///     .rust(|joint| joint.model.rows[1][3] += joint.parameters[0]);
/// assert_eq!(lift.name(), "lift");
/// ```
#[derive(Clone)]
pub struct UserStage {
    name: String,
    opencl_c: Option<Arc<str>>,
    rust: Option<StageFn>,
}

impl UserStage {
    /// The declaration of `StageJoint` in OpenCL C, as it stands before each stage's text.
    pub const OPENCL_C: &'static str = include_str!("stage/joint.cl");

    /// A stage of a name, which is that of its function in OpenCL C. It needs a form yet.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), opencl_c: None, rust: None }
    }

    /// With a text in OpenCL C.
    #[must_use]
    pub fn opencl_c(mut self, text: impl Into<Arc<str>>) -> Self {
        self.opencl_c = Some(text.into());
        self
    }

    /// With a function in Rust. It is called from many threads at once, and must give the same for
    /// the same joint. A panic in it goes on to whoever updates the crowd.
    #[must_use]
    pub fn rust(mut self, function: impl Fn(&mut StageJoint) + Send + Sync + 'static) -> Self {
        self.rust = Some(Arc::new(function));
        self
    }

    /// The stage's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its text in OpenCL C, if it has one.
    #[must_use]
    pub fn opencl_c_text(&self) -> Option<&str> {
        self.opencl_c.as_deref()
    }

    /// Its function in Rust, if it has one.
    #[must_use]
    pub fn rust_function(&self) -> Option<&StageFn> {
        self.rust.as_ref()
    }

    /// Whether it can be a stage at all.
    ///
    /// # Errors
    ///
    /// [`Error::BadStage`] for a name that no function can have in C, a text with a zero character,
    /// or a stage without any form.
    pub fn check(&self) -> Result<(), Error> {
        let Self { name, opencl_c, rust } = self;
        let bad = |what: &str| Err(Error::BadStage { stage: name.clone(), what: what.into() });
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return bad(
                "a name is made of A to Z, a to z, 0 to 9 and _, and does not begin with a digit",
            );
        }
        match (opencl_c, rust) {
            (None, None) => bad("it needs a text in OpenCL C, a function in Rust, or both"),
            (Some(text), _) if text.contains('\0') => {
                bad("its text in OpenCL C holds a zero character")
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for UserStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, opencl_c, rust } = self;
        write!(f, "UserStage({name:?}, OpenCL C: {}, Rust: {})", opencl_c.is_some(), rust.is_some())
    }
}

/// That a member uses a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StageUse {
    /// The stage's number among those of the crowd, below
    /// [`STAGES_MOST`](crate::layout::STAGES_MOST).
    pub stage: u32,
    /// When it runs.
    pub after: After,
    /// For which joints.
    pub joints: Vec<JointIndex>,
    /// The member's own values.
    pub values: [f32; 4],
}
