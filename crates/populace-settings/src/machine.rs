//! State machines: clips as states, and the transitions between them.

use std::sync::Arc;

use populace_clip::ticks_from_secs;
use populace_device::layout::MACHINE_PARAMETERS;
use populace_device::{MachineState, Transition};
use populace_model::nearest_names;

use crate::check::{Check, bounded, check_secs};
use crate::error::Error;
use crate::fault::{MachineFault, MachinePart};
use crate::ids::ClipId;
use crate::playback::{Mode, Playback, StatePlayback};

/// A condition of a transition of a [`StateMachine`].
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// The member's parameter of this name is above the value.
    Above(String, f32),
    /// The member's parameter of this name is below the value.
    Below(String, f32),
    /// The state was entered at least this many seconds ago.
    AfterSecs(f32),
    /// The state's clip, which plays once, has ended.
    Ended,
}

impl Condition {
    /// Holds while the member's parameter is above `value`.
    #[must_use]
    pub fn above(parameter: &str, value: f32) -> Self {
        Self::Above(parameter.to_owned(), value)
    }

    /// Holds while the member's parameter is below `value`.
    #[must_use]
    pub fn below(parameter: &str, value: f32) -> Self {
        Self::Below(parameter.to_owned(), value)
    }
}

#[derive(Clone, Debug, PartialEq)]
struct State {
    name: String,
    clip: ClipId,
    play: Playback,
}

#[derive(Clone, Debug, PartialEq)]
struct Way {
    /// `None` for every state except `to`.
    from: Option<String>,
    to: String,
    fade_secs: f32,
    conditions: Vec<Condition>,
}

/// States that play clips, transitions between them, and parameters that each member sets for
/// itself. Devices evaluate machines: the host uploads changed parameters and does nothing else.
///
/// A member starts in the first state. In each frame the device checks the transitions out of the
/// state in the order in which they were added, and takes the first whose conditions all hold: the
/// new state's clip starts at that frame's tick and fades in while the old one fades out. During
/// the fade no transition is taken, so at most two clips are mixed and the pose never jumps.
///
/// ```
/// # use populace::{Condition, Crowd, Device, MachinePlayback, Placement, StateMachine, StatePlayback};
/// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
/// # let knight = populace::doc_fixture::knight(&mut crowd)?;
/// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
/// let idle = crowd.clip(knight, "Idle")?;
/// let walk = crowd.clip(knight, "Walk")?;
/// let jump = crowd.clip(knight, "Jump")?;
/// let gait = StateMachine::new()
///     .parameter("speed", 0.0)
///     .parameter("jump", 0.0)
///     .state("idle", idle, StatePlayback::looping())
///     .state("walk", walk, StatePlayback::looping())
///     .state("jump", jump, StatePlayback::once())
///     .transition_from_any("jump", 0.1, &[Condition::above("jump", 0.5)])
///     .transition("idle", "walk", 0.2, &[Condition::above("speed", 0.5)])
///     .transition("walk", "idle", 0.2, &[Condition::below("speed", 0.4)])
///     .transition("jump", "idle", 0.2, &[Condition::Ended, Condition::below("jump", 0.5)]);
/// let gait = crowd.add_machine(&gait)?;
/// let mut knight = crowd.member_mut(member)?;
/// knight.play_machine(gait, MachinePlayback::new())?;
/// knight.set_parameter("speed", 1.4)?;
/// crowd.update(0.1)?;
/// assert_eq!(&*crowd.member_mut(member)?.machine_state(0)?, "walk");
/// # Ok::<(), populace::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateMachine {
    parameters: Vec<(String, f32)>,
    states: Vec<State>,
    ways: Vec<Way>,
}

impl StateMachine {
    /// Returns a machine without states. `Crowd::add_machine` checks the finished machine.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a parameter and its initial value. A machine has at most 8.
    #[must_use]
    pub fn parameter(mut self, name: &str, value: f32) -> Self {
        self.parameters.push((name.to_owned(), value));
        self
    }

    /// Adds a state that plays a clip. Members start in the first state.
    #[must_use]
    pub fn state(mut self, name: &str, clip: ClipId, playback: StatePlayback) -> Self {
        let play = playback.0;
        self.states.push(State { name: name.to_owned(), clip, play });
        self
    }

    /// Adds a transition that is taken when all conditions hold, with a crossfade of `fade_secs`.
    /// Without conditions it is taken as soon as the state has faded in. A transition to its own
    /// state restarts the clip.
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

    /// Adds a transition from every state except `to`.
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

    fn check_names(&self) -> Result<(), Error> {
        if self.states.is_empty() {
            return Err(bad(MachineFault::NoStates));
        }
        let count = self.parameters.len();
        if count > MACHINE_PARAMETERS as usize {
            return Err(bad(MachineFault::TooManyParameters(count)));
        }
        bounded(
            "a parameter of a state machine",
            &self.parameters.iter().map(|p| p.1).collect::<Vec<_>>(),
        )?;
        check_unique(MachinePart::State, self.states.iter().map(|state| state.name.as_str()))?;
        check_unique(
            MachinePart::Parameter,
            self.parameters.iter().map(|(name, _)| name.as_str()),
        )?;
        for way in &self.ways {
            self.check_way(way)?;
        }
        Ok(())
    }

    fn check_way(&self, way: &Way) -> Result<(), Error> {
        check_secs("the fade of a transition", way.fade_secs)?;
        let names = || self.states.iter().map(|state| state.name.as_str());
        for name in way.from.iter().chain([&way.to]) {
            find(MachinePart::State, name, names())?;
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
                    let state = from.unwrap_or("any state").to_owned();
                    return Err(bad(MachineFault::NoEnd { state }));
                }
            }
        }
        Ok(())
    }

    fn parameter_of(&self, name: &str) -> Result<usize, Error> {
        find(MachinePart::Parameter, name, self.parameters.iter().map(|(name, _)| name.as_str()))
    }

    /// Returns the transitions out of a state, in order.
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
            let to = find(
                MachinePart::State,
                &way.to,
                self.states.iter().map(|state| state.name.as_str()),
            )?;
            let conditions: Result<_, Error> = way.conditions.iter().map(number).collect();
            Ok(Transition { to, fade_secs: way.fade_secs, conditions: conditions? })
        };
        self.ways.iter().filter(leads_out).map(transition).collect()
    }
}

/// A machine whose names are resolved to indices.
#[derive(Clone)]
pub struct Compiled {
    /// The names and initial values of the parameters.
    pub parameters: Vec<(String, f32)>,
    /// The states, of which the first is the initial one.
    pub states: Vec<CompiledState>,
}

/// A state of a [`Compiled`] machine.
#[derive(Clone)]
pub struct CompiledState {
    /// The name.
    pub name: Arc<str>,
    /// The clip.
    pub clip: ClipId,
    /// Whether names alone may bind any share of the clip's joints.
    pub partial: bool,
    /// Its rows, not yet bound to a body.
    pub rows: MachineState,
}

impl Compiled {
    /// Returns the index of a parameter.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|(own, _)| own == name)
    }
}

/// Checks a machine and resolves names to indices. `duration_of` returns the seconds of a clip, or
/// an error if the clip cannot be played in this mode.
///
/// # Errors
///
/// [`Error::BadStateMachine`], a number out of its range, or an error of `duration_of`.
pub fn compile(
    machine: &StateMachine,
    duration_of: impl Fn(ClipId, Mode) -> Result<f32, Error>,
) -> Result<Compiled, Error> {
    machine.check_names()?;
    let mut states = Vec::new();
    for state in &machine.states {
        state.play.check()?;
        let duration = duration_of(state.clip, state.play.mode)?;
        let slot = state.play.slot(0, 0, duration);
        // A clip of no length ends at once; one at speed 0 never ends.
        let end_ticks = if duration > 0.0 { slot.end_tick(0).unwrap_or(u64::MAX) } else { 0 };
        let transitions = machine.transitions_of(state, end_ticks)?;
        let rows = MachineState { slot, transitions };
        let (clip, partial) = (state.clip, state.play.partial);
        states.push(CompiledState { name: state.name.as_str().into(), clip, partial, rows });
    }
    Ok(Compiled { parameters: machine.parameters.clone(), states })
}

fn bad(fault: MachineFault) -> Error {
    Error::BadStateMachine(fault)
}

/// Returns the index of a name, or an error with similar names.
///
/// # Errors
///
/// [`Error::BadStateMachine`] if the name is not among `names`.
pub fn find<'a>(
    part: MachinePart,
    name: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Error> {
    names.clone().position(|own| own == name).ok_or_else(|| {
        let nearest = nearest_names(name, names);
        bad(MachineFault::Unknown { part, name: name.to_owned(), nearest })
    })
}

fn check_unique<'a>(
    part: MachinePart,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), Error> {
    for (index, name) in names.clone().enumerate() {
        if names.clone().take(index).any(|other| other == name) {
            return Err(bad(MachineFault::Duplicate { part, name: name.to_owned() }));
        }
    }
    Ok(())
}
