//! The clock of a crowd: updates, and jumps to another time.

use std::time::Instant;

use populace_clip::{FIRST_TICK, TICKS_PER_SEC, ticks_from_secs};
use populace_device::Frame;
use populace_device::layout::{NONE, SLOT_LIVE, Slot};

use super::player::slots::faded_out;
use super::state::State;
use super::{Crowd, MemberId};
use crate::{Allowed, Error};

/// The longest time step that is accepted, in seconds.
const MAX_STEP_SECS: f32 = 1e6;
/// The most ticks that devices count in a frame: 6,087 seconds.
const MOST_TICKS: u64 = u32::MAX as u64;
/// The latest time that can be sought, in seconds.
const MAX_SECS: f64 = 1e9;

/// A kind of state that depends on the frames before, so that a jump in time does not give the
/// result of updates up to that time.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum History {
    /// Planted feet keep the place at which they were planted.
    PlantedFeet,
    /// Look-at and reach targets at joints of other members follow them one frame late.
    JointTargets,
    /// Overridden joints, such as those of ragdolls, stay as they were set.
    Overrides,
    /// Root motion adds up over frames. A jump back does not undo it, and one by more than 6,087 s
    /// forwards moves members for 6,087 s.
    RootMotion,
    /// State machines take at most one transition in a jump forwards, and stay in their state on a
    /// jump back.
    StateMachines,
    /// Clips that have started since do not give way to those that they replaced.
    Playbacks,
    /// Live clips hold the poses of the last seconds only.
    LiveClips,
}

/// The state that makes the result of a [`seek`](Crowd::seek) inexact.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SeekReport {
    /// The kinds of state, with the members concerned; empty if the result is exact.
    pub inexact: Vec<(History, Vec<MemberId>)>,
}

impl Crowd {
    /// Advances the clock by `dt_secs`, at most 1e6, starts what is scheduled by then, and
    /// evaluates every member. Longer times than 6,087 s take several frames of at most 6,087 s, in
    /// each of which state machines can take a transition.
    ///
    /// # Errors
    ///
    /// A time that is negative, not finite or above 1e6 s, or a failing device. The crowd's state
    /// survives a failing device: [`move_to`](Self::move_to) continues on another.
    pub fn update(&mut self, dt_secs: f32) -> Result<(), Error> {
        if !(0.0..=MAX_STEP_SECS).contains(&dt_secs) {
            let allowed = Allowed::Range { least: 0.0, most: MAX_STEP_SECS.into() };
            return Err(Error::BadValue { what: "the time step", value: dt_secs, allowed });
        }
        let clock = &self.state.base.clock;
        let ticks = f64::from(dt_secs) * TICKS_PER_SEC as f64 + clock.left_over;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; `as` saturates"
        )]
        let whole = ticks.round().max(0.0) as u64;
        let (tick, left_over) = (clock.tick.wrapping_add(whole), ticks - whole as f64);
        if whole <= MOST_TICKS {
            return self.evaluate_at(tick, left_over);
        }
        // A failing device takes back the frame that failed, but not those before it.
        let history = self.device.history(&self.state.base.tables)?;
        let advanced = self.advance_to(tick, left_over);
        if advanced.is_err() {
            self.device.take_history(history);
        }
        advanced
    }

    /// Goes to a time in seconds since the crowd was built, and evaluates every member there.
    ///
    /// Clips, blend spaces, transitions, layers and attachments are functions of time and go along,
    /// forwards and backwards. What is scheduled by then starts. State that depends on the frames
    /// between does not: the report names it. A [snapshot](Self::snapshot) from before that time
    /// and updates from there give the exact result.
    ///
    /// ```
    /// # use populace::{ClipPlayback, Crowd, Device, Placement};
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = populace::doc_fixture::knight(&mut crowd)?;
    /// # let rise = crowd.clip(knight, "Rise")?;
    /// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// crowd.member_mut(member)?.play(rise, ClipPlayback::looping())?;
    /// for at_secs in [10.25, 0.5, 3600.75] {
    ///     assert!(crowd.seek(at_secs)?.inexact.is_empty());
    ///     let hips = crowd.member_mut(member)?.model_from_joints()?[0];
    ///     assert!((hips.rows[1][3] - 2.0 * at_secs.fract() as f32).abs() < 1e-3);
    /// }
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A time that is negative, not finite or above 1e9 seconds, or a failing device.
    pub fn seek(&mut self, secs: f64) -> Result<SeekReport, Error> {
        if !(0.0..=MAX_SECS).contains(&secs) {
            let (what, allowed) =
                ("the time to go to", Allowed::Range { least: 0.0, most: MAX_SECS });
            #[expect(clippy::cast_possible_truncation, reason = "for a message")]
            return Err(Error::BadValue { what, value: secs as f32, allowed });
        }
        let tick = FIRST_TICK + ticks_from_secs(secs);
        let report = self.state.inexact_at(tick);
        self.evaluate_at(tick, 0.0)?;
        Ok(report)
    }

    /// The time of the last update, in seconds since the crowd was built.
    #[must_use]
    pub fn time_secs(&self) -> f64 {
        (self.state.base.clock.tick - FIRST_TICK) as f64 / TICKS_PER_SEC as f64
    }

    /// Evaluates every member at a tick, in one frame.
    fn evaluate_at(&mut self, tick: u64, left_over: f64) -> Result<(), Error> {
        self.prepare()?;
        self.end_at((self.state.base.clock.tick, tick), left_over)
    }

    /// Evaluates every member at a tick, and on the way there as often as devices need it to count
    /// all ticks.
    fn advance_to(&mut self, tick: u64, left_over: f64) -> Result<(), Error> {
        self.prepare()?;
        let mut from = self.state.base.clock.tick;
        while tick - from > MOST_TICKS {
            let until = from + MOST_TICKS;
            self.begin_frame(until)?;
            self.device.run(&mut self.state.base.tables, frame((from, until)), false)?;
            from = until;
        }
        self.end_at((from, tick), left_over)
    }

    fn prepare(&mut self) -> Result<(), Error> {
        // An update that failed may have left some.
        self.state.player.take_left();
        // A view goes by where the last update has moved members, however fast the device is.
        if self.state.base.view.is_some() && !self.state.motion.is_empty() {
            self.device.backend_mut().finish()?;
        }
        Ok(self.update_offsets()?)
    }

    fn begin_frame(&mut self, tick: u64) -> Result<(), Error> {
        self.state.begin_due(tick)?;
        let start = Instant::now();
        self.state.apply_view();
        self.view_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Runs the last frame of an update, which begins and ends at two ticks, and sets the clock.
    fn end_at(&mut self, ticks: (u64, u64), left_over: f64) -> Result<(), Error> {
        self.begin_frame(ticks.1)?;
        let Self { state, device, .. } = self;
        device.run(&mut state.base.tables, frame(ticks), !state.readbacks.is_empty())?;
        state.end_frame(ticks.1, left_over);
        // The frame is done: a failing device is reported by the next call.
        let _ = self.update_offsets();
        Ok(())
    }
}

/// Returns a frame of all members from one tick to another. It takes no time after a jump back.
fn frame((from, until): (u64, u64)) -> Frame {
    let elapsed = u32::try_from(until.saturating_sub(from)).unwrap_or(u32::MAX);
    Frame::of_all(until).after_ticks(elapsed)
}

impl State {
    /// Lists the state that makes a jump to `tick` inexact.
    fn inexact_at(&self, tick: u64) -> SeekReport {
        let now = self.base.clock.tick;
        let mut inexact = Vec::new();
        if tick == now {
            return SeekReport { inexact };
        }
        let mut report = |kind, concerns: &dyn Fn(MemberId) -> bool| {
            let members = self.members().map(|member| member.id());
            let members: Vec<_> = members.filter(|member| concerns(*member)).collect();
            if !members.is_empty() {
                inexact.push((kind, members));
            }
        };
        let any_slot = |member: MemberId, which: &dyn Fn(&Slot) -> bool| {
            let heard = |slot: &&Slot| {
                slot.bound_clip != NONE && (!faded_out(slot, now) || !faded_out(slot, tick))
            };
            self.base.slots(member.number()).iter().filter(heard).any(which)
        };
        report(History::PlantedFeet, &|member| self.constraints.plants_feet(member));
        report(History::JointTargets, &|member| self.constraints.watches_others(member));
        report(History::Overrides, &|member| self.constraints.overrides_joints(member));
        let is_machine = |slot: &Slot| slot.machine_instance().is_some();
        let starts_machine = |member: MemberId| {
            let mut scheduled = self.player.scheduled.of(member.number());
            scheduled.any(|(due, start)| due <= tick && start.machine().is_some())
        };
        let runs_machine = |member| any_slot(member, &is_machine) || starts_machine(member);
        if tick < now {
            let is_later = |slot: &Slot| slot.start_tick > tick || slot.weight_tick > tick;
            let is_live = |slot: &Slot| slot.mode() == SLOT_LIVE;
            report(History::RootMotion, &|member| self.constraints.motion(member).is_some());
            report(History::StateMachines, &runs_machine);
            report(History::Playbacks, &|member| any_slot(member, &is_later));
            report(History::LiveClips, &|member| any_slot(member, &is_live));
        } else {
            if tick - now > MOST_TICKS {
                report(History::RootMotion, &|member| self.constraints.motion(member).is_some());
            }
            report(History::StateMachines, &runs_machine);
        }
        SeekReport { inexact }
    }
}

#[cfg(test)]
mod tests;
