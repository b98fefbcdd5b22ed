//! State machines: clips as states, and what leads from one to another.

use std::sync::Arc;

use populace_clip::ticks_from_secs;
use populace_device::layout::MACHINE_PARAMETERS;
use populace_device::{MachineState, Transition};
use populace_model::{did_you_mean, nearest_names};

use crate::error::bounded;
use crate::play::{Mode, check_secs};
use crate::{ClipId, Error, Play};

/// What must hold for a transition of a [`StateMachine`] to be taken.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// The member's parameter of this name is above the number.
    Above(String, f32),
    /// The member's parameter of this name is below the number.
    Below(String, f32),
    /// The state was entered so many seconds ago, or more.
    AfterSecs(f32),
    /// The state's clip, which plays once, has come to its end.
    Ended,
}

impl Condition {
    /// The member's parameter of a name is above a number.
    #[must_use]
    pub fn above(parameter: &str, value: f32) -> Self {
        Self::Above(parameter.to_owned(), value)
    }

    /// The member's parameter of a name is below a number.
    #[must_use]
    pub fn below(parameter: &str, value: f32) -> Self {
        Self::Below(parameter.to_owned(), value)
    }
}

#[derive(Clone, Debug, PartialEq)]
struct State {
    name: String,
    clip: ClipId,
    play: Play,
}

#[derive(Clone, Debug, PartialEq)]
struct Way {
    /// `None` for any state but the one that it leads to.
    from: Option<String>,
    to: String,
    fade_secs: f32,
    conditions: Vec<Condition>,
}

/// States that each play a clip, transitions between them, and parameters by which every member
/// that runs the machine goes its own way. Devices run it: a frame costs the host what parameters
/// it sets, and nothing else.
///
/// A member begins in the first state. Once a frame the transitions out of its state are looked at,
/// in the order in which they were added, and the first of which all conditions hold is taken, as
/// of that frame's tick: the new state's clip starts and fades in while the old one fades out. The
/// next is looked at once that fade is over, so two clips at most mix and no pose jumps, however
/// parameters change; one at most is taken a frame.
///
/// ```
/// # use populace::{Condition, Crowd, Device, Placement, Play, StateMachine};
/// # use populace::character::{Character, CharacterSource, PaletteEntry};
/// # use populace::clip::Clip;
/// # use populace::model::{Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs};
/// # let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
/// # let skeleton = Skeleton::new(&[joint])?;
/// # let clip = |name: &str, secs| { let track = Track { joint: "hips".into(), property: Property::Translation,
/// #     interpolation: Interpolation::Linear, times: vec![0.0, secs], values: vec![0.0; 6] };
/// #     Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, &skeleton) };
/// # let clips = vec![clip("Idle", 4.0)?.into(), clip("Walk", 1.0)?.into(), clip("Jump", 0.5)?.into()];
/// # let knight = Character::new(CharacterSource { name: "knight".into(), palette: vec![],
/// #     skeleton: skeleton.clone(), parts: vec![], materials: vec![], images: vec![], skins: vec![], clips })?;
/// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
/// # let knight = crowd.add_character(knight)?;
/// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
/// let (idle, walk, jump) = (crowd.clip(knight, "Idle")?, crowd.clip(knight, "Walk")?, crowd.clip(knight, "Jump")?);
/// let gait = StateMachine::new()
///     .parameter("speed", 0.0)
///     .parameter("jump", 0.0)
///     .state("idle", idle, Play::looping())
///     .state("walk", walk, Play::looping())
///     .state("jump", jump, Play::once())
///     .transition_from_any("jump", 0.1, &[Condition::above("jump", 0.5)])
///     .transition("idle", "walk", 0.2, &[Condition::above("speed", 0.5)])
///     .transition("walk", "idle", 0.2, &[Condition::below("speed", 0.4)])
///     .transition("jump", "idle", 0.2, &[Condition::Ended, Condition::below("jump", 0.5)]);
/// let gait = crowd.add_machine(&gait)?;
/// crowd.run_machine(member, gait, Play::looping())?;
/// crowd.set_parameter(member, "speed", 1.4)?;
/// crowd.update(0.1)?;
/// assert_eq!(&*crowd.state_of(member, 0)?, "walk");
/// # Ok::<(), populace::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateMachine {
    parameters: Vec<(String, f32)>,
    states: Vec<State>,
    ways: Vec<Way>,
}

impl StateMachine {
    /// Nothing yet. What is wrong with a machine [`Crowd::add_machine`](crate::Crowd::add_machine)
    /// tells.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Names a parameter, 8 at most, and what it is until it is set.
    #[must_use]
    pub fn parameter(mut self, name: &str, value: f32) -> Self {
        self.parameters.push((name.to_owned(), value));
        self
    }

    /// Adds a state that plays a clip: again and again, once, held or live, at a speed and from a
    /// phase on. The first state is the one that members begin in.
    #[must_use]
    pub fn state(mut self, name: &str, clip: ClipId, play: Play) -> Self {
        self.states.push(State { name: name.to_owned(), clip, play });
        self
    }

    /// Adds a transition, with a crossfade of so many seconds, for when all conditions hold;
    /// without any it is taken as soon as it can be. One that leads back to its own state starts
    /// the clip anew.
    #[must_use]
    pub fn transition(
        self,
        from: &str,
        to: &str,
        fade_secs: f32,
        conditions: &[Condition],
    ) -> Self {
        self.way(Some(from), to, fade_secs, conditions)
    }

    /// Adds a transition from every state but the one that it leads to.
    #[must_use]
    pub fn transition_from_any(self, to: &str, fade_secs: f32, conditions: &[Condition]) -> Self {
        self.way(None, to, fade_secs, conditions)
    }

    fn way(
        mut self,
        from: Option<&str>,
        to: &str,
        fade_secs: f32,
        conditions: &[Condition],
    ) -> Self {
        let from = from.map(str::to_owned);
        self.ways.push(Way { from, to: to.to_owned(), fade_secs, conditions: conditions.to_vec() });
        self
    }

    /// Checks all, and brings names to numbers. `duration_of` tells a clip's seconds, where it can
    /// be played so.
    pub(crate) fn compile(
        &self,
        duration_of: impl Fn(ClipId, Mode) -> Result<f32, Error>,
    ) -> Result<Compiled, Error> {
        self.check_names()?;
        let mut states = Vec::new();
        for state in &self.states {
            check_play(state)?;
            let duration = duration_of(state.clip, state.play.mode)?;
            let slot = state.play.slot(0, 0, duration);
            // One of no length is at its end at once; one that stands never comes to it.
            let end_ticks = if duration > 0.0 { slot.end_tick(0).unwrap_or(u64::MAX) } else { 0 };
            let transitions = self.transitions_of(state, end_ticks)?;
            let rows = MachineState { slot, transitions };
            let (clip, partial) = (state.clip, state.play.partial);
            states.push(CompiledState { name: state.name.as_str().into(), clip, partial, rows });
        }
        Ok(Compiled { parameters: self.parameters.clone(), states })
    }

    fn check_names(&self) -> Result<(), Error> {
        if self.states.is_empty() {
            return Err(bad("has no states; add one by StateMachine::state"));
        }
        let count = self.parameters.len();
        if count > MACHINE_PARAMETERS as usize {
            return Err(bad(&format!("has {count} parameters; {MACHINE_PARAMETERS} are the most")));
        }
        bounded(
            "a parameter of a state machine",
            &self.parameters.iter().map(|p| p.1).collect::<Vec<_>>(),
        )?;
        check_unique("states", self.states.iter().map(|state| state.name.as_str()))?;
        check_unique("parameters", self.parameters.iter().map(|(name, _)| name.as_str()))?;
        for way in &self.ways {
            self.check_way(way)?;
        }
        Ok(())
    }

    fn check_way(&self, way: &Way) -> Result<(), Error> {
        check_secs("the fade of a transition", way.fade_secs)?;
        let names = || self.states.iter().map(|state| state.name.as_str());
        for name in way.from.iter().chain([&way.to]) {
            find("state", name, names())?;
        }
        let from = way.from.as_deref();
        let mut left =
            self.states.iter().filter(|state| from.is_none_or(|from| state.name == from));
        let ends = left.any(|state| state.play.mode == Mode::Once);
        for condition in &way.conditions {
            match condition {
                Condition::Above(parameter, value) | Condition::Below(parameter, value) => {
                    bounded("what a parameter is compared with", &[*value])?;
                    self.parameter_of(parameter)?;
                }
                Condition::AfterSecs(secs) => check_secs("the time in a state", *secs)?,
                Condition::Ended if ends => {}
                Condition::Ended => {
                    let from = from.unwrap_or("any state");
                    return Err(bad(&format!(
                        "waits in \"{from}\" for the end of a clip that has none; play it by \
                         Play::once()"
                    )));
                }
            }
        }
        Ok(())
    }

    fn parameter_of(&self, name: &str) -> Result<usize, Error> {
        find("parameter", name, self.parameters.iter().map(|(name, _)| name.as_str()))
    }

    /// The transitions out of a state, in order.
    fn transitions_of(&self, state: &State, end_ticks: u64) -> Result<Vec<Transition>, Error> {
        let leads_out = |way: &&Way| match &way.from {
            Some(from) => *from == state.name,
            None => way.to != state.name,
        };
        let number = |condition: &Condition| {
            let parameter =
                |name: &str| Ok::<_, Error>(u32::try_from(self.parameter_of(name)?).unwrap_or(0));
            Ok(match condition {
                Condition::Above(name, value) => {
                    populace_device::Condition::Above(parameter(name)?, *value)
                }
                Condition::Below(name, value) => {
                    populace_device::Condition::Below(parameter(name)?, *value)
                }
                Condition::AfterSecs(secs) => {
                    populace_device::Condition::After(ticks_from_secs((*secs).into()))
                }
                // A clip that does not play once has no end.
                Condition::Ended if state.play.mode != Mode::Once => {
                    populace_device::Condition::After(u64::MAX)
                }
                Condition::Ended => populace_device::Condition::After(end_ticks),
            })
        };
        let transition = |way: &Way| {
            let to = find("state", &way.to, self.states.iter().map(|state| state.name.as_str()))?;
            let conditions: Result<_, Error> = way.conditions.iter().map(number).collect();
            Ok(Transition { to, fade_secs: way.fade_secs, conditions: conditions? })
        };
        self.ways.iter().filter(leads_out).map(transition).collect()
    }
}

/// A machine by numbers.
pub(crate) struct Compiled {
    /// Names, and what they are at the start.
    pub(crate) parameters: Vec<(String, f32)>,
    pub(crate) states: Vec<CompiledState>,
}

pub(crate) struct CompiledState {
    pub(crate) name: Arc<str>,
    pub(crate) clip: ClipId,
    /// Whether names alone may bind any share of the clip.
    pub(crate) partial: bool,
    /// Bound to no body yet.
    pub(crate) rows: MachineState,
}

impl Compiled {
    pub(crate) fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|(own, _)| own == name)
    }
}

pub(crate) fn bad(reason: &str) -> Error {
    Error::BadStateMachine { reason: reason.to_owned() }
}

/// Refuses a name that is not among others, and names those like it.
pub(crate) fn find<'a>(
    what: &str,
    name: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Error> {
    names.clone().position(|own| own == name).ok_or_else(|| {
        let nearest = nearest_names(name, names);
        bad(&format!("has no {what} \"{name}\"{}", did_you_mean(&nearest)))
    })
}

fn check_unique<'a>(what: &str, names: impl Iterator<Item = &'a str> + Clone) -> Result<(), Error> {
    for (index, name) in names.clone().enumerate() {
        if names.clone().take(index).any(|other| other == name) {
            return Err(bad(&format!("has two {what} \"{name}\"; give each a name of its own")));
        }
    }
    Ok(())
}

fn check_play(State { name, play, .. }: &State) -> Result<(), Error> {
    play.check()?;
    let Play { mode, speed, phase, partial, .. } = *play;
    if *play == (Play { mode, speed, phase, partial, ..Play::looping() }) {
        return Ok(());
    }
    Err(bad(&format!(
        "gives its state \"{name}\" a weight, layer, fade or delay; transitions fade, and the \
         rest is for run_machine"
    )))
}
