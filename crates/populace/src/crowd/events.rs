//! What happens while clips play: feet that come down, clips that end, moments that were named.
//! Slots are closed-form, so the host knows of all of it from the clock alone: nothing is read from
//! a device. What state machines play it does not know.

use std::sync::Arc;

use populace_clip::{ClipIndex, TICKS_PER_SEC};
use populace_device::layout::{NONE, SLOT_LOOP, SLOT_ONCE, Slot};

use super::{ClipId, Crowd, FIRST_TICK, Member};
use crate::Error;

/// Of one moment of one clip at most so many in one step of the clock are told, the last ones.
const TOLD_MOST: i128 = 16;

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A foot came down.
    Footstep {
        /// The joint that touches the ground, by its name in the clip's own skeleton.
        joint: Arc<str>,
    },
    /// A clip that plays once came to its end.
    ClipEnd,
    /// A clip came to a moment that was named.
    Moment {
        /// Its name.
        name: Arc<str>,
    },
}

/// Something that happened to a member.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The member.
    pub member: Member,
    /// The clip by which it happened.
    pub clip: ClipId,
    /// What it was.
    pub kind: EventKind,
    /// When, on the crowd's clock from its beginning on.
    pub at_secs: f64,
    /// How much the clip weighed then, before its layer's weights are divided by their sum.
    pub weight: f32,
}

/// A moment of a clip, as a fraction of it in 2^-64.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    phase: i128,
    kind: EventKind,
}

impl Crowd {
    /// Tells from the next update on what happens to a member, but for the clips that its state
    /// machines play.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn listen(&mut self, member: Member) -> Result<(), Error> {
        self.check(member)?;
        if !self.listening.contains(&member) {
            self.listening.push(member);
        }
        Ok(())
    }

    /// Tells nothing more of a member.
    pub fn ignore(&mut self, member: Member) {
        self.listening.retain(|other| *other != member);
    }

    /// Names a moment of a clip, on its own axis; those who are listened to then tell of it.
    ///
    /// # Errors
    ///
    /// A clip of another crowd, or a moment that is not within it.
    pub fn name_moment(&mut self, clip: ClipId, name: &str, secs: f32) -> Result<(), Error> {
        self.check_crowd("clip", clip.crowd, clip.index.0)?;
        let known = self.clips.get(clip.index);
        let known = known.ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?;
        let (start, duration) = (known.start_secs(), known.duration_secs());
        if !(start..=start + duration).contains(&secs) {
            return Err(Error::BadValue {
                what: "a moment of a clip",
                value: secs,
                rule: "within the clip",
            });
        }
        let phase = phase_of(secs, start, duration);
        self.marks_of(clip.index)
            .push(Mark { phase, kind: EventKind::Moment { name: name.into() } });
        Ok(())
    }

    /// What happened in the last update to the members that are listened to, in order of time.
    /// Nothing is told of clips that state machines play: only the device knows which, and
    /// [`state_of`](Self::state_of), which asks it, waits.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// A clip's moments: its footsteps, and those that were named.
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

    /// Finds out what happens after one tick and up to another.
    pub(super) fn find_events(&mut self, after: u64, until: u64) {
        self.events.clear();
        let mut listening = std::mem::take(&mut self.listening);
        listening.retain(|member| self.check(*member).is_ok());
        let mut found = std::mem::take(&mut self.events);
        let left = std::mem::take(&mut self.left);
        for &member in &listening {
            let of_member = left.iter().filter(|(place, ..)| *place == member.place);
            let gone = of_member.map(|(_, slot, tick)| (*slot, *tick));
            let there = self.slots(member.place).iter().map(|slot| (*slot, until));
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
        member: Member,
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

/// Whether a slot goes through a clip of a length that is known.
fn runs(slot: &Slot) -> bool {
    matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE)
}

/// Where in a clip a moment is, in 2^-64 of its length.
#[expect(clippy::cast_possible_truncation, reason = "a fraction of 2^64")]
fn phase_of(secs: f32, start: f32, duration: f32) -> i128 {
    let part = if duration > 0.0 {
        (f64::from(secs) - f64::from(start)) / f64::from(duration)
    } else {
        0.0
    };
    (part * 18_446_744_073_709_551_616.0) as i128
}

/// How a slot runs through its clip, in 2^-64 of its length.
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

    /// When a clip that plays once is at its end.
    fn end_tick(&self) -> Option<u64> {
        let ticks = CYCLE.checked_div(self.rate.abs())? + i128::from(CYCLE % self.rate.abs() != 0);
        let ticks = u64::try_from(ticks).ok().filter(|_| self.once)?;
        self.start_tick.checked_add(ticks)
    }

    /// The ticks after `after` and up to `until` at which a moment is reached. A moment at which
    /// the slot begins counts as reached a tick later.
    fn crossings(&self, phase: i128, after: u64, until: u64) -> impl Iterator<Item = u64> + use<> {
        let at = |tick: u64| self.start + self.rate * i128::from(tick - self.start_tick);
        let (from, to) = (at(after.max(self.start_tick)), at(until.max(self.start_tick)));
        // Forwards the moments in [from, to) are reached, backwards those in (to, from]; each turn
        // of the clip has one.
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
