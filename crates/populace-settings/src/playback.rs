//! Settings of playback: of clips, blend spaces and state machines.

use populace_clip::ticks_from_secs;
use populace_device::layout::Slot;

use crate::check::{Check, bounded, check_layer, check_secs, check_weight};
use crate::error::Error;
use crate::ids::{ClipId, PlaybackId};

/// The settings of everything that plays in a slot. The public types each show those that apply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// How the clip plays.
    pub mode: Mode,
    /// The factor on the clip's own speed.
    pub speed: f32,
    /// The phase at which a loop starts, in cycles.
    pub phase: f32,
    /// The weight within the layer, 0 to 1.
    pub weight: f32,
    /// The time in which the weight is reached.
    pub fade_in_secs: f32,
    /// Whether `fade_in_secs` is the time of an inertialization rather than of a fade.
    pub inertializes: bool,
    /// The time until the start.
    pub after_secs: f32,
    /// The layer.
    pub layer: usize,
    /// Whether a clip bound by names alone may bind any share of its joints.
    pub partial: bool,
}

/// How a clip plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Again and again.
    Looping,
    /// Once; then its end holds.
    Once,
    /// Held at a time.
    Held {
        /// The time on the clip's own axis.
        secs: f32,
    },
    /// Live, behind the present.
    Live {
        /// The time behind the present.
        delay_secs: f32,
    },
}

/// Builder methods that several kinds of playback share, written once.
macro_rules! shared_settings {
    ($type:ty: $($setting:ident)*) => { impl $type { $(shared_settings!(@ $setting);)* } };
    (@ modes) => {
        /// Plays the clip again and again.
        #[must_use]
        pub const fn looping() -> Self {
            Self(Playback::new(Mode::Looping))
        }

        /// Plays the clip once, then holds its end.
        #[must_use]
        pub const fn once() -> Self {
            Self(Playback::new(Mode::Once))
        }

        /// Holds the clip at `secs` on its own time axis: before the first key that key holds,
        /// after the last key the last.
        #[must_use]
        pub const fn held_at_secs(secs: f32) -> Self {
            Self(Playback::new(Mode::Held { secs }))
        }

        /// Plays a live clip `delay_secs` behind the present. Past its newest pose that pose
        /// holds, before its oldest pose that one. For smooth motion the delay is a little longer
        /// than the time between poses plus their latency. Speed and phase have no effect.
        #[must_use]
        pub const fn live(delay_secs: f32) -> Self {
            Self(Playback::new(Mode::Live { delay_secs }))
        }
    };
    (@ speed) => {
        /// Sets the factor on the clip's own speed; negative plays backwards. 1 unless set.
        #[must_use]
        pub const fn speed(mut self, speed: f32) -> Self {
            self.0.speed = speed;
            self
        }
    };
    (@ phase) => {
        /// Sets the phase at which a loop starts, 0 to 1; 0 unless set. Whole cycles of other
        /// numbers, to 1e9 in size, are left out: 1.25 and -0.75 are 0.25.
        #[must_use]
        pub const fn phase(mut self, phase: f32) -> Self {
            self.0.phase = phase;
            self
        }
    };
    (@ weight) => {
        /// Sets the weight within the layer, 0 to 1. 1 unless set.
        #[must_use]
        pub const fn weight(mut self, weight: f32) -> Self {
            self.0.weight = weight;
            self
        }
    };
    (@ fade_in_secs) => {
        /// Reaches the weight over `secs`. The first playback of a member starts at full weight
        /// all the same, so that its rest pose never shows by accident.
        #[must_use]
        pub const fn fade_in_secs(mut self, secs: f32) -> Self {
            self.0.fade_in_secs = secs;
            self.0.inertializes = false;
            self
        }
    };
    (@ after_secs) => {
        /// Starts `secs` later, on the tick. The layer goes on as it is until then.
        #[must_use]
        pub const fn after_secs(mut self, secs: f32) -> Self {
            self.0.after_secs = secs;
            self
        }
    };
    (@ on_layer) => {
        /// Sets the layer, 0 to 3. 0 unless set.
        #[must_use]
        pub const fn on_layer(mut self, layer: usize) -> Self {
            self.0.layer = layer;
            self
        }
    };
    (@ partial) => {
        /// Plays clips even if names alone bind less than 30 % of the joints that they move, which
        /// is refused otherwise. For clips of which only a part is wanted, such as through a mask.
        /// `CharacterRef::binding` returns the share. A clip that
        /// moves no joint of the body is refused all the same.
        #[must_use]
        pub const fn partial(mut self) -> Self {
            self.0.partial = true;
            self
        }
    };
}

/// Settings with which a clip plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlayback(pub(crate) Playback);

shared_settings!(ClipPlayback: modes speed phase weight fade_in_secs after_secs on_layer partial);

impl ClipPlayback {
    /// Starts with an inertialized transition in place of a fade: the clip has its full weight at
    /// once, and the difference in pose and speed between the layer's motion and the clip decays
    /// to zero within `secs`. 0.1 to 0.5 seconds are usual; over longer times fast motion
    /// overshoots. The speed of root motion changes over in the same time without overshooting.
    ///
    /// It applies to `MemberMut::play` and `MemberMut::queue`. It is a fade of the same time in
    /// `MemberMut::blend`, if the layer plays nothing, and if a live clip or a state machine starts
    /// or ends. On a layer above 0 whose total weight differs from the clip's, the weight runs to
    /// the clip's in that time.
    #[must_use]
    pub const fn inertialize_in_secs(mut self, secs: f32) -> Self {
        self.0.fade_in_secs = secs;
        self.0.inertializes = true;
        self
    }
}

/// Settings with which a blend space plays. Its clips loop on one shared phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlendSpacePlayback(pub(crate) Playback);

shared_settings!(BlendSpacePlayback: speed phase weight fade_in_secs after_secs on_layer partial);

impl BlendSpacePlayback {
    /// Full weight on layer 0, at the clips' own speed.
    #[must_use]
    pub const fn new() -> Self {
        Self(Playback::new(Mode::Looping))
    }
}

impl Default for BlendSpacePlayback {
    fn default() -> Self {
        Self::new()
    }
}

/// Settings with which a state machine plays. Its states set speed and phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachinePlayback(pub(crate) Playback);

shared_settings!(MachinePlayback: weight fade_in_secs after_secs on_layer);

impl MachinePlayback {
    /// Full weight on layer 0.
    #[must_use]
    pub const fn new() -> Self {
        Self(Playback::new(Mode::Looping))
    }
}

impl Default for MachinePlayback {
    fn default() -> Self {
        Self::new()
    }
}

/// Settings with which a state plays its clip. Transitions set the fades, and
/// [`MachinePlayback`] sets weight and layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatePlayback(pub(crate) Playback);

shared_settings!(StatePlayback: modes speed phase partial);

impl Playback {
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

    /// Returns a slot of layer 0 at full weight that plays the bound clip from `tick` on.
    #[must_use]
    #[inline]
    pub fn slot(&self, bound: u32, tick: u64, duration_secs: f32) -> Slot {
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
}

impl Check for Playback {
    fn check(&self) -> Result<(), Error> {
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

/// The state of a clip that a member plays, as of the last update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveClip {
    /// The handle by which to change it; `None` for a clip of a blend space.
    pub id: Option<PlaybackId>,
    /// The clip.
    pub clip: ClipId,
    /// The layer that mixes it.
    pub layer: usize,
    /// The time at which the clip is sampled, in seconds on its own axis; for a live clip the
    /// stream's time, in single precision.
    pub time_secs: f32,
    /// Its weight among the clips of its layer.
    pub weight: f32,
    /// The factor on the clip's own speed; negative plays backwards, 0 holds; 1 for a live clip.
    pub speed: f32,
    /// Seconds until a clip that plays once ends, 0 from then on; `None` for all others and at
    /// speed 0.
    pub ends_in_secs: Option<f64>,
}
