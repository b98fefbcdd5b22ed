//! Events of clips: footsteps, ends and markers. Slots are closed-form, so the host finds events
//! from the clock alone and reads nothing from a device. It does not know what state machines play.

use std::sync::Arc;

use populace_clip::{ClipIndex, TICKS_PER_SEC};
use populace_device::layout::{NONE, SLOT_LOOP, SLOT_ONCE, Slot};

use super::{ClipId, Crowd, FIRST_TICK, MemberId};
use crate::Error;

/// The most repeats of one marker that are reported per update; earlier ones are dropped.
const TOLD_MOST: i128 = 16;

/// The kind of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A foot touched the ground.
    Footstep {
        /// The name of the joint that touches the ground, in the clip's own skeleton.
        joint: Arc<str>,
    },
    /// A clip that plays once ended.
    ClipEnd,
    /// A clip reached a marker.
    Marker {
        /// The marker's name.
        name: Arc<str>,
    },
}

/// An event of a member.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The member.
    pub member: MemberId,
    /// The clip that caused it.
    pub clip: ClipId,
    /// The kind of event.
    pub kind: EventKind,
    /// The time of the event, in seconds since the crowd was built.
    pub at_secs: f64,
    /// The weight of the clip at that time, before the weights of its layer are normalised.
    pub weight: f32,
}

/// A marker of a clip; its phase in 2^-64 of the clip.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    phase: i128,
    kind: EventKind,
}

impl Crowd {
    pub(super) fn listen(&mut self, member: MemberId) {
        if !self.listening.contains(&member) {
            self.listening.push(member);
        }
    }

    pub(super) fn ignore(&mut self, member: MemberId) {
        self.listening.retain(|other| *other != member);
    }

    /// Adds an event marker to a clip, at `secs` on the clip's own time axis. Members with
    /// [subscribed events](crate::MemberMut::subscribe_events) report it.
    ///
    /// # Errors
    ///
    /// A clip of another crowd, or a time outside of the clip.
    pub fn add_event_marker(&mut self, clip: ClipId, name: &str, secs: f32) -> Result<(), Error> {
        self.check_crowd("clip", clip.crowd, clip.index.0)?;
        let known = self.clips.get(clip.index);
        let known = known.ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?;
        let (start, duration) = (known.start_secs(), known.duration_secs());
        if !(start..=start + duration).contains(&secs) {
            return Err(Error::BadValue {
                what: "the time of an event marker",
                value: secs,
                rule: "within the clip",
            });
        }
        let phase = phase_of(secs, start, duration);
        self.marks_of(clip.index)
            .push(Mark { phase, kind: EventKind::Marker { name: name.into() } });
        Ok(())
    }

    /// The events of the last update, in order of time, of members that
    /// [subscribed](crate::MemberMut::subscribe_events). Clips of state machines report none: only
    /// the device knows their state.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// The markers of a clip: its footsteps, and those added by the caller.
    fn marks_of(&mut self, clip: ClipIndex) -> &mut Vec<Mark> {
        let clips = &self.clips;
        self.marks.entry(clip).or_insert_with(|| {
            let Some(known) = clips.get(clip) else { return Vec::new() };
            let (start, duration) = (known.start_secs(), known.duration_secs());
            let mark = |step: &populace_clip::Footstep| Mark {
                phase: phase_of(step.secs, start, duration),
                kind: EventKind::Footstep { joint: Arc::clone(&step.joint) },
            };
            known.footsteps().iter().map(mark).collect()
        })
    }

    /// Collects the events after tick `after` and up to tick `until`.
    pub(super) fn find_events(&mut self, after: u64, until: u64) {
        self.events.clear();
        let mut listening = std::mem::take(&mut self.listening);
        listening.retain(|member| self.check(*member).is_ok());
        let mut found = std::mem::take(&mut self.events);
        let left = std::mem::take(&mut self.left);
        for &member in &listening {
            let of_member = left.iter().filter(|(place, ..)| *place == member.index);
            let gone = of_member.map(|(_, slot, tick)| (*slot, *tick));
            let there = self.slots(member.index).iter().map(|slot| (*slot, until));
            for (slot, until) in gone.chain(there).collect::<Vec<_>>() {
                if slot.bound_clip != NONE && runs(&slot) && slot.start_tick <= until {
                    let clip = self.tables.bound_clips().as_slice()[slot.bound_clip as usize].clip;
                    self.events_of_slot(
                        member,
                        &slot,
                        ClipIndex(clip),
                        (after.max(slot.start_tick), until),
                        &mut found,
                    );
                }
            }
        }
        found.sort_by(|a, b| a.at_secs.total_cmp(&b.at_secs));
        self.events = found;
        self.listening = listening;
    }

    fn events_of_slot(
        &mut self,
        member: MemberId,
        slot: &Slot,
        clip: ClipIndex,
        (after, until): (u64, u64),
        found: &mut Vec<Event>,
    ) {
        let number = self.number;
        let run = Run::of(slot);
        let mut tell = |tick: u64, kind: EventKind| {
            let weight = slot.weight_at(tick);
            if weight > 0.0 {
                let at_secs = tick.saturating_sub(FIRST_TICK) as f64 / TICKS_PER_SEC as f64;
                found.push(Event {
                    member,
                    clip: ClipId { crowd: number, index: clip },
                    kind,
                    at_secs,
                    weight,
                });
            }
        };
        for mark in &*self.marks_of(clip) {
            run.crossings(mark.phase, after, until).for_each(|tick| tell(tick, mark.kind.clone()));
        }
        if let Some(tick) = run.end_tick().filter(|tick| after < *tick && *tick <= until) {
            tell(tick, EventKind::ClipEnd);
        }
    }
}

/// Returns whether a slot plays through a clip of known length.
fn runs(slot: &Slot) -> bool {
    matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE)
}

/// Returns the phase of a time within a clip, in 2^-64 of its length.
#[expect(clippy::cast_possible_truncation, reason = "a fraction of 2^64")]
fn phase_of(secs: f32, start: f32, duration: f32) -> i128 {
    let part = if duration > 0.0 {
        (f64::from(secs) - f64::from(start)) / f64::from(duration)
    } else {
        0.0
    };
    (part * 18_446_744_073_709_551_616.0) as i128
}

/// The phase of a slot over time, in 2^-64 of its clip.
struct Run {
    start_tick: u64,
    start: i128,
    /// Per tick.
    rate: i128,
    once: bool,
}

const CYCLE: i128 = 1 << 64;

impl Run {
    #[expect(clippy::cast_possible_wrap, reason = "rates are in two's complement")]
    fn of(slot: &Slot) -> Self {
        let (once, rate) = (slot.mode() == SLOT_ONCE, i128::from(slot.phase_rate as i64));
        let start = if !once {
            i128::from(slot.start_phase) << 32
        } else if rate < 0 {
            CYCLE
        } else {
            0
        };
        Self { start_tick: slot.start_tick, start, rate, once }
    }

    /// The tick at which a clip that plays once ends.
    fn end_tick(&self) -> Option<u64> {
        let ticks = CYCLE.checked_div(self.rate.abs())? + i128::from(CYCLE % self.rate.abs() != 0);
        let ticks = u64::try_from(ticks).ok().filter(|_| self.once)?;
        self.start_tick.checked_add(ticks)
    }

    /// Iterates over the ticks after `after` and up to `until` at which a phase is reached. The
    /// phase at which the slot starts counts as reached one tick later.
    fn crossings(&self, phase: i128, after: u64, until: u64) -> impl Iterator<Item = u64> + use<> {
        let at = |tick: u64| self.start + self.rate * i128::from(tick - self.start_tick);
        let (from, to) = (at(after.max(self.start_tick)), at(until.max(self.start_tick)));
        // Forwards, phases in [from, to) are reached; backwards, those in (to, from]. Each cycle of
        // the clip has one.
        let cycles = if self.rate >= 0 {
            (from - phase + CYCLE - 1).div_euclid(CYCLE)..(to - phase + CYCLE - 1).div_euclid(CYCLE)
        } else {
            (to - phase).div_euclid(CYCLE) + 1..(from - phase).div_euclid(CYCLE) + 1
        };
        let cycles = if self.once { cycles.start.max(0)..cycles.end.min(1) } else { cycles };
        let (start, rate, start_tick) = (self.start, self.rate, self.start_tick);
        let first = cycles.start.max(cycles.end - TOLD_MOST);
        (first..cycles.end).filter(move |_| rate != 0).filter_map(move |cycle| {
            let distance = phase + cycle * CYCLE - start;
            let ticks = (distance * rate.signum()).div_euclid(rate.abs()) + 1;
            start_tick.checked_add(u64::try_from(ticks).ok()?).map(|tick| tick.min(until))
        })
    }
}
