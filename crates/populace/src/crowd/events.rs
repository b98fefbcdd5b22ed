//! Events of clips: footsteps, ends and markers. Slots are closed-form, so the host finds events
//! from the clock alone and reads nothing from a device. It does not know what state machines play.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use populace_clip::{FIRST_TICK, TICKS_PER_SEC};
use populace_device::layout::{NONE, SLOT_LOOP, SLOT_ONCE, Slot};

use super::base::{Base, ClipIndex};
use super::{ClipId, MemberId};
use crate::{Allowed, Error};

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

/// Subscriptions to events, the markers of clips, and the events of the last update.
#[derive(Clone, Debug, Default)]
pub(super) struct Events {
    /// Members whose events are reported, by the order in which they subscribed.
    listening: BTreeMap<u64, MemberId>,
    /// The places of members in that order.
    places: HashMap<MemberId, u64>,
    subscribed: u64,
    marks: HashMap<ClipIndex, Vec<Mark>>,
    found: Vec<Event>,
}

impl Events {
    pub(super) fn subscribe(&mut self, member: MemberId) {
        self.places.entry(member).or_insert_with(|| {
            self.subscribed += 1;
            self.listening.insert(self.subscribed, member);
            self.subscribed
        });
    }

    pub(super) fn unsubscribe(&mut self, member: MemberId) {
        if let Some(place) = self.places.remove(&member) {
            self.listening.remove(&place);
        }
    }

    /// The events of the last update, in order of time.
    pub(super) fn as_slice(&self) -> &[Event] {
        &self.found
    }

    pub(super) fn add_marker(
        &mut self,
        base: &Base,
        clip: ClipId,
        name: &str,
        secs: f32,
    ) -> Result<(), Error> {
        let known = base.known_clip(clip)?;
        let (start, duration) = (known.start_secs(), known.duration_secs());
        if !(start..=start + duration).contains(&secs) {
            return Err(Error::BadValue {
                what: "the time of an event marker",
                value: secs,
                allowed: Allowed::Range { least: start.into(), most: (start + duration).into() },
            });
        }
        let phase = phase_of(secs, start, duration);
        let mark = Mark { phase, kind: EventKind::Marker { name: name.into() } };
        marks_of(&mut self.marks, base, ClipIndex::of(clip)).push(mark);
        Ok(())
    }

    /// Forgets the markers of a clip that is removed.
    pub(super) fn forget(&mut self, clip: ClipIndex) {
        self.marks.remove(&clip);
    }

    /// Collects the events after tick `after` and up to tick `until`. `left` holds the slots that
    /// ended during the update: member index, slot and tick.
    pub(super) fn find(
        &mut self,
        base: &Base,
        mut left: Vec<(u32, Slot, u64)>,
        (after, until): (u64, u64),
    ) {
        let Self { listening, places, marks, found, .. } = self;
        found.clear();
        left.sort_by_key(|(index, ..)| *index);
        listening.retain(|_, member| {
            let is_present = base.check(*member).is_ok();
            if !is_present {
                places.remove(member);
            }
            is_present
        });
        for &member in listening.values() {
            let first = left.partition_point(|(index, ..)| *index < member.number());
            let of_member = left[first..].iter().take_while(|left| left.0 == member.number());
            let gone = of_member.map(|(_, slot, tick)| (slot, *tick));
            let there = base.slots(member.number()).iter().map(|slot| (slot, until));
            for (slot, until) in gone.chain(there) {
                if slot.bound_clip != NONE && runs(slot) && slot.start_tick <= until {
                    let clip = base.tables.bound_clips().as_slice()[slot.bound_clip as usize].clip;
                    let clip = base.clip_id(clip);
                    let marks = marks_of(marks, base, ClipIndex::of(clip));
                    let during = (after.max(slot.start_tick), until);
                    let tell = |kind, tick| event(member, clip, slot, kind, tick);
                    found
                        .extend(kinds_of_slot(slot, marks, during).filter_map(|(k, t)| tell(k, t)));
                }
            }
        }
        found.sort_by(|a, b| a.at_secs.total_cmp(&b.at_secs));
    }
}

/// Returns the markers of a clip: its footsteps, and those added by the caller.
fn marks_of<'a>(
    marks: &'a mut HashMap<ClipIndex, Vec<Mark>>,
    base: &Base,
    clip: ClipIndex,
) -> &'a mut Vec<Mark> {
    marks.entry(clip).or_insert_with(|| {
        let Some(known) = base.assets.clips.at(clip.0) else { return Vec::new() };
        let (start, duration) = (known.start_secs(), known.duration_secs());
        let mark = |step: &populace_clip::Footstep| Mark {
            phase: phase_of(step.secs, start, duration),
            kind: EventKind::Footstep { joint: Arc::clone(&step.joint) },
        };
        known.footsteps().iter().map(mark).collect()
    })
}

/// Iterates over the events of a slot after tick `after` and up to tick `until`.
fn kinds_of_slot(
    slot: &Slot,
    marks: &[Mark],
    (after, until): (u64, u64),
) -> impl Iterator<Item = (EventKind, u64)> {
    let run = Run::of(slot);
    let end = run.end_tick().filter(|tick| after < *tick && *tick <= until);
    let marked = marks.iter().flat_map(move |mark| {
        run.crossings(mark.phase, after, until).map(|tick| (mark.kind.clone(), tick))
    });
    marked.chain(end.map(|tick| (EventKind::ClipEnd, tick)))
}

/// Returns the event of a slot at a tick, unless the slot has no weight then.
fn event(member: MemberId, clip: ClipId, slot: &Slot, kind: EventKind, tick: u64) -> Option<Event> {
    let weight = slot.weight_at(tick);
    let at_secs = tick.saturating_sub(FIRST_TICK) as f64 / TICKS_PER_SEC as f64;
    (weight > 0.0).then_some(Event { member, clip, kind, at_secs, weight })
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
#[derive(Clone, Copy)]
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
