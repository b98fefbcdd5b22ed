//! User stages: functions that run on single joints within the crowd pipeline.

use std::fmt;
use std::sync::Arc;

use populace_clip::TICKS_PER_SEC;
use populace_model::math::quat;
use populace_model::{Affine, JointIndex, Trs};

use crate::Error;
use crate::fault::StageFault;
use crate::layout::STAGE_PARAMETERS;
use crate::place::Place;

/// The pipeline stage after which a user stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum After {
    /// Runs when a joint's local transform is known, including local overrides. Constraints are
    /// applied to the result.
    Pose,
    /// Runs when a joint's model transform is known, including constraints, and before an override
    /// in model space. Its children are computed afterwards, so that they follow, on every
    /// schedule.
    Transform,
}

/// A joint of a member, as passed to a [`UserStage`] in Rust. The OpenCL C equivalent is
/// [`UserStage::OPENCL_C`].
#[derive(Clone, Debug, PartialEq)]
pub struct StageJoint {
    /// With [`After::Pose`], to read and write: the local transform, in metres. Its rotation is
    /// normalised afterwards.
    pub local: Trs,
    /// With [`After::Transform`], to read and write: `model_from_joint`, in metres.
    pub model: Affine,
    /// The place of the member in the world.
    pub place: Place,
    /// The member's own values, as given when it began to use the stage.
    pub values: [f32; 4],
    /// The stage's parameters; those that were not set are 0.
    pub parameters: [f32; STAGE_PARAMETERS as usize],
    /// Ticks since the crowd began, [`TICKS_PER_SEC`] per second. Exact for all time, see
    /// [`phase`](Self::phase).
    pub ticks: u64,
    /// Seconds since the previous frame.
    pub elapsed_secs: f32,
    /// The joint, in level order.
    pub joint: JointIndex,
    /// The number of the member, which is unique among the members of the crowd.
    pub member: u32,
}

impl StageJoint {
    /// Returns the elapsed fraction, from 0 to 1, of a repeating period in seconds. It is as exact
    /// after days as after seconds. Periods must be between 0.0001 and 1,000,000 seconds; others
    /// give 0. OpenCL C: `stage_phase(joint, period_secs)`.
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

    /// Converts a direction from world space to the member's model space. OpenCL C:
    /// `stage_to_model(joint, direction)`.
    #[must_use]
    pub fn to_model(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [sin, cos] = self.place.sin_cos;
        [cos * x - sin * z, y, sin * x + cos * z]
    }

    /// Rotates the joint about its own position by a unit quaternion `x y z w`: with
    /// [`After::Transform`] in model space, with [`After::Pose`] in the space of its parent. OpenCL
    /// C: `stage_rotate(joint, quaternion)`.
    pub fn rotate(&mut self, rotation: [f32; 4]) {
        // Only the transform of the stage that runs is taken from the result.
        self.model = self.model.rotated(rotation);
        self.local.rotation = quat::mul(rotation, self.local.rotation);
    }
}

/// The Rust function of a [`UserStage`].
pub type StageFn = Arc<dyn Fn(&mut StageJoint) + Send + Sync>;

/// A user stage: a function on one joint of one member, in OpenCL C for OpenCL devices, in Rust for
/// the native device, or both. A crowd runs it for the members and joints that are set to use it.
///
/// The OpenCL C text defines `void NAME(StageJoint *joint)`, with the stage's own name for `NAME`
/// and
#[doc = concat!("```c\n", include_str!("stage/joint.cl"), "```")]
/// and the functions `float stage_phase(const StageJoint *, float period_secs)`, `float4
/// stage_to_model(const StageJoint *, float4 direction)` and
/// `void stage_rotate(StageJoint *, float4 quaternion)`, which do what the methods of [`StageJoint`]
/// do.
///
/// The texts of a crowd's stages are compiled together, each distinct text once, so helper
/// functions need unique names as well. They are OpenCL C 1.2, compiled for a single joint on every
/// schedule: no barriers and no work-item functions. `+ - *` are never fused, so that both
/// languages compute the same bits with these operations.
///
/// A stage is part of the program: a text that writes out of bounds or never returns harms the
/// process, as such Rust code would. Results are checked: a joint with a value that is not finite,
/// or beyond 1e9 in magnitude, keeps its transform from before the stage, so that it never affects
/// another member.
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
    /// The declaration of `StageJoint` in OpenCL C, which precedes each stage's text.
    pub const OPENCL_C: &'static str = include_str!("stage/joint.cl");

    /// Creates a stage. The name is that of its function in OpenCL C. It still needs
    /// [`opencl_c`](Self::opencl_c), [`rust`](Self::rust) or both.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), opencl_c: None, rust: None }
    }

    /// Sets the text in OpenCL C.
    #[must_use]
    pub fn opencl_c(mut self, text: impl Into<Arc<str>>) -> Self {
        self.opencl_c = Some(text.into());
        self
    }

    /// Sets the function in Rust. It is called from many threads at once, and must give the same
    /// result for the same joint. A panic in it propagates to the caller of the crowd's update.
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

    /// The text in OpenCL C, if there is one.
    #[must_use]
    pub fn opencl_c_text(&self) -> Option<&str> {
        self.opencl_c.as_deref()
    }

    /// The function in Rust, if there is one.
    #[must_use]
    pub fn rust_function(&self) -> Option<&StageFn> {
        self.rust.as_ref()
    }

    /// Checks that the stage is complete and its name valid.
    ///
    /// # Errors
    ///
    /// [`Error::BadStage`] if the name is not a valid C identifier, the text contains a zero
    /// character, or the stage has neither text nor function.
    pub fn check(&self) -> Result<(), Error> {
        let Self { name, opencl_c, rust } = self;
        let bad = |fault| Err(Error::BadStage { stage: name.clone(), fault });
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return bad(StageFault::Name);
        }
        match (opencl_c, rust) {
            (None, None) => bad(StageFault::NoForm),
            (Some(text), _) if text.contains('\0') => bad(StageFault::ZeroCharacter),
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

/// A member's use of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StageUse {
    /// The stage's number in the crowd, below [`MAX_STAGES`](crate::layout::MAX_STAGES).
    pub stage: u32,
    /// The pipeline stage after which it runs.
    pub after: After,
    /// The joints that it runs on.
    pub joints: Vec<JointIndex>,
    /// The member's own values.
    pub values: [f32; 4],
}
