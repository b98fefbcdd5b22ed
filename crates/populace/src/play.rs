//! How clips are started and members are placed.

use populace_clip::ticks_from_secs;
use populace_device::layout::Slot;
use populace_model::{Affine, LARGEST, LARGEST_SCALE};

use crate::error::bounded;
use crate::{ClipId, Error, PlayId};

/// How a clip plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    pub(crate) mode: Mode,
    pub(crate) speed: f32,
    pub(crate) phase: f32,
    pub(crate) weight: f32,
    pub(crate) fade_in_secs: f32,
    /// Whether what is left inertializes in that time, rather than fades.
    pub(crate) inertializes: bool,
    pub(crate) after_secs: f32,
    pub(crate) layer: usize,
    /// Whether names alone may bind any share of the clip.
    pub(crate) partial: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mode {
    Looping,
    Once,
    Held { secs: f32 },
    Live { delay_secs: f32 },
}

impl Play {
    const fn new(mode: Mode) -> Self {
        Self {
            mode,
            speed: 1.0,
            phase: 0.0,
            weight: 1.0,
            fade_in_secs: 0.0,
            inertializes: false,
            after_secs: 0.0,
            layer: 0,
            partial: false,
        }
    }

    /// Again and again.
    #[must_use]
    pub const fn looping() -> Self {
        Self::new(Mode::Looping)
    }

    /// Once, then holding the end.
    #[must_use]
    pub const fn once() -> Self {
        Self::new(Mode::Once)
    }

    /// Standing at one time of the clip's own axis, in seconds; the first key holds before it, the
    /// last after it.
    #[must_use]
    pub const fn held_at_secs(secs: f32) -> Self {
        Self::new(Mode::Held { secs })
    }

    /// A live clip as it was so many seconds ago, following what comes in; where nothing more comes
    /// its newest pose holds, before its oldest that one. A delay of somewhat more than the time
    /// between poses, and what they are late by, shows smooth motion. Speed and phase are not
    /// looked at.
    #[must_use]
    pub const fn live(delay_secs: f32) -> Self {
        Self::new(Mode::Live { delay_secs })
    }

    /// Times the clip's own pace; negative plays backwards.
    #[must_use]
    pub const fn speed(mut self, speed: f32) -> Self {
        self.speed = speed;
        self
    }

    /// Where a looping clip starts, from 0 to 1.
    #[must_use]
    pub const fn phase(mut self, phase: f32) -> Self {
        self.phase = phase;
        self
    }

    /// The weight among the clips of its layer, from 0 to 1.
    #[must_use]
    pub const fn weight(mut self, weight: f32) -> Self {
        self.weight = weight;
        self
    }

    /// Takes this long to reach its weight. A member's first clip starts at full weight all the
    /// same: nobody sees the rest pose by accident.
    #[must_use]
    pub const fn fade_in_secs(mut self, secs: f32) -> Self {
        self.fade_in_secs = secs;
        self.inertializes = false;
        self
    }

    /// In place of a fade, an inertialised transition: has its full weight at once, and the
    /// difference between what the layer showed and this clip, in pose and in speed, decays to
    /// nothing within so many seconds. A tenth to half a second is usual; over longer times what
    /// moved fast overshoots. The speed at which clips move a member (that of the update before)
    /// goes over into the new one's in the same time, without overshooting.
    ///
    /// It is for [`Crowd::play`](crate::Crowd::play) and [`Crowd::queue`](crate::Crowd::queue).
    /// Where nothing is left, in [`Crowd::blend`](crate::Crowd::blend), where a blend space begins,
    /// and where a live clip or a state machine begins or is among those left, this is a fade of
    /// the same time. Where a layer above 0 weighed more or less than this clip does, its weight
    /// runs to this clip's in that time.
    #[must_use]
    pub const fn inertialize_in_secs(mut self, secs: f32) -> Self {
        self.fade_in_secs = secs;
        self.inertializes = true;
        self
    }

    /// Starts so much later, on the tick. What the layer plays goes on until then.
    #[must_use]
    pub const fn after_secs(mut self, secs: f32) -> Self {
        self.after_secs = secs;
        self
    }

    /// The layer to play in, 0 to 3.
    #[must_use]
    pub const fn on_layer(mut self, layer: usize) -> Self {
        self.layer = layer;
        self
    }

    /// Plays the clip even where names alone bind less than 30 % of the joints that it moves, which
    /// is refused otherwise: for clips of which a part is wanted, such as through a mask.
    /// [`Crowd::binding`](crate::Crowd::binding) tells the share. A clip that moves no joint of the
    /// body is refused all the same.
    #[must_use]
    pub const fn partial(mut self) -> Self {
        self.partial = true;
        self
    }

    /// A slot in layer 0 that plays a bound clip of that length so from a tick on, at full weight.
    pub(crate) fn slot(&self, bound: u32, tick: u64, duration_secs: f32) -> Slot {
        match self.mode {
            Mode::Looping => {
                Slot::looping(bound, tick, duration_secs, f64::from(self.phase), self.speed)
            }
            Mode::Once => Slot::once(bound, tick, duration_secs, self.speed),
            Mode::Held { secs } => Slot::held(bound, tick, secs),
            Mode::Live { delay_secs } => {
                Slot::live(bound, tick, ticks_from_secs(f64::from(delay_secs)))
            }
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        bounded("the speed of a clip", &[self.speed])?;
        bounded("the phase of a clip", &[self.phase])?;
        if let Mode::Held { secs } = self.mode {
            bounded("the time to hold a clip at", &[secs])?;
        }
        if let Mode::Live { delay_secs } = self.mode {
            check_secs("the delay of a live clip", delay_secs)?;
        }
        check_weight("the weight of a clip", self.weight)?;
        check_layer(self.layer)?;
        let what =
            if self.inertializes { "the time to inertialize in" } else { "the time to fade in" };
        check_secs(what, self.fade_in_secs)?;
        check_secs("the time to start after", self.after_secs)
    }
}

/// A clip that a member plays, as it stands at the last update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playing {
    /// What to change it by; `None` for a clip of a blend space, which is steered.
    pub id: Option<PlayId>,
    /// The clip.
    pub clip: ClipId,
    /// The layer that it is mixed in.
    pub layer: usize,
    /// Where it stands, in seconds on the clip's own axis; of a live clip the stream's own time, as
    /// far as single precision tells it.
    pub time_secs: f32,
    /// Its weight among the clips of its layer.
    pub weight: f32,
    /// Times the clip's own pace; negative runs backwards, 0 stands; 1 for a live clip.
    pub speed: f32,
    /// Seconds until a clip that plays once has ended, 0 from then on; `None` for others and for
    /// one that stands.
    pub ends_in_secs: Option<f64>,
}

pub(crate) fn check_weight(what: &'static str, value: f32) -> Result<(), Error> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(Error::BadValue { what, value, rule: "from 0 to 1" })
    }
}

pub(crate) fn check_secs(what: &'static str, value: f32) -> Result<(), Error> {
    if (0.0..=LARGEST).contains(&value) {
        Ok(())
    } else {
        Err(Error::BadValue { what, value, rule: "from 0 to 1e9" })
    }
}

pub(crate) fn check_layer(layer: usize) -> Result<(), Error> {
    if layer < populace_device::MAX_LAYERS {
        Ok(())
    } else {
        Err(Error::BadValue { what: "the layer", value: layer as f32, rule: "0 to 3" })
    }
}

/// Where a member stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    pub(crate) position: [f32; 3],
    pub(crate) yaw_rad: f32,
    pub(crate) scale: f32,
}

impl Placement {
    /// At a point in metres, facing +Z.
    #[must_use]
    pub const fn at(position: [f32; 3]) -> Self {
        Self { position, yaw_rad: 0.0, scale: 1.0 }
    }

    /// Turned about +Y: 0 faces +Z, a quarter turn faces +X.
    #[must_use]
    pub const fn facing(mut self, yaw_rad: f32) -> Self {
        self.yaw_rad = yaw_rad;
        self
    }

    /// Times the character's own size.
    #[must_use]
    pub const fn scaled(mut self, scale: f32) -> Self {
        self.scale = scale;
        self
    }

    /// The point where it stands, in metres.
    #[must_use]
    pub const fn position(&self) -> [f32; 3] {
        self.position
    }

    /// Its heading about +Y: 0 faces +Z, a quarter turn faces +X.
    #[must_use]
    pub const fn yaw_rad(&self) -> f32 {
        self.yaw_rad
    }

    /// Times the character's own size.
    #[must_use]
    pub const fn scale(&self) -> f32 {
        self.scale
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        bounded("the position of a member", &self.position)?;
        bounded("the heading of a member", &[self.yaw_rad])?;
        if (1.0 / LARGEST_SCALE..=LARGEST_SCALE).contains(&self.scale) {
            Ok(())
        } else {
            let rule = "from 0.0001 to 10,000";
            Err(Error::BadValue { what: "the scale of a member", value: self.scale, rule })
        }
    }

    /// The placement as a matrix.
    #[must_use]
    pub fn world_from_model(&self) -> Affine {
        let (sin, cos) = f64::from(self.yaw_rad).sin_cos();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to the nearest f32 is what is wanted"
        )]
        let (sin, cos) = (sin as f32 * self.scale, cos as f32 * self.scale);
        let [x, y, z] = self.position;
        Affine { rows: [[cos, 0.0, sin, x], [0.0, self.scale, 0.0, y], [-sin, 0.0, cos, z]] }
    }
}
