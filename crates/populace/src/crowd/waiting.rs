//! What is to start later, on its tick: queued and delayed clips, and those that wait for a slot.
//!
//! A start that waits takes no slot. When the clock passes its tick it is carried out as of that
//! very tick, so that the slot is the same, to the bit, as if somebody had called at that instant.

use std::collections::{BTreeMap, HashMap};

use populace_device::layout::MACHINE_PARAMETERS;

use crate::Play;
use crate::blend_space::SpacePoint;

/// What starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// A clip, in place of what its layer plays or beside it.
    Clip { bound: u32, alone: bool },
    /// A blend space, in place of what its layer plays.
    Space { index: u32, at: SpacePoint },
    /// Another point of the blend space that plays, reached in so many seconds.
    Steer { at: SpacePoint, over_secs: f32 },
    /// A state machine, in place of what its layer plays, and its parameters at the start.
    Machine { state: u32, parameters: [f32; MACHINE_PARAMETERS as usize] },
}

/// A start that waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    pub(crate) serial: u32,
    pub(crate) action: Action,
    pub(crate) play: Play,
    /// Follows the end of what its layer plays before it, after so many ticks.
    pub(crate) follows_after: Option<u64>,
}

impl Start {
    /// The same once its time has come, though it waits for a slot.
    pub(crate) fn at_its_time(&self) -> Self {
        Self { follows_after: None, ..*self }
    }

    /// The state in which the machine begins that is to start, if it is one.
    pub(crate) fn machine(&self) -> Option<u32> {
        if let Action::Machine { state, .. } = self.action { Some(state) } else { None }
    }
}

/// A start, when it is due, and its place in the order of all.
type Entry = (u64, u64, Start);

/// All starts that wait, by member and by time.
#[derive(Default)]
pub(crate) struct Waiting {
    by_place: HashMap<u32, Vec<Entry>>,
    by_time: BTreeMap<(u64, u64), u32>,
    pushed: u64,
}

impl Waiting {
    pub(crate) fn push(&mut self, place: u32, due: u64, start: Start) {
        self.pushed += 1;
        self.by_time.insert((due, self.pushed), place);
        let starts = self.by_place.entry(place).or_default();
        starts.push((due, self.pushed, start));
        starts.sort_by_key(|(due, order, _)| (*due, *order));
    }

    /// What waits for a member, in order of time, and when it is due.
    pub(crate) fn of(&self, place: u32) -> impl Iterator<Item = (u64, &Start)> {
        self.by_place.get(&place).into_iter().flatten().map(|(due, _, start)| (*due, start))
    }

    /// The first that is due at or before a tick.
    pub(crate) fn take_due(&mut self, tick: u64) -> Option<(u64, u32, Start)> {
        let (&(due, order), &place) = self.by_time.first_key_value()?;
        if due > tick {
            return None;
        }
        self.by_time.remove(&(due, order));
        let starts = self.by_place.get_mut(&place)?;
        let at = starts.iter().position(|entry| entry.1 == order)?;
        let (_, _, start) = starts.remove(at);
        if starts.is_empty() {
            self.by_place.remove(&place);
        }
        Some((due, place, start))
    }

    /// Forgets those of a member that are not to be kept.
    pub(crate) fn retain(&mut self, place: u32, keep: impl Fn(&Start) -> bool) {
        let Some(starts) = self.by_place.get_mut(&place) else { return };
        starts.retain(|(due, order, start)| {
            let kept = keep(start);
            if !kept {
                self.by_time.remove(&(*due, *order));
            }
            kept
        });
        if starts.is_empty() {
            self.by_place.remove(&place);
        }
    }

    /// Changes those of a member, and when they are due.
    pub(crate) fn change(&mut self, place: u32, mut change: impl FnMut(&mut u64, &mut Start)) {
        for (due, order, start) in self.by_place.get_mut(&place).into_iter().flatten() {
            self.by_time.remove(&(*due, *order));
            change(due, start);
            self.by_time.insert((*due, *order), place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start(serial: u32, layer: usize) -> Start {
        let action = Action::Clip { bound: 0, alone: true };
        Start { serial, action, play: Play::once().on_layer(layer), follows_after: None }
    }

    #[test]
    fn starts_come_in_order_of_time_then_of_asking() {
        let mut waiting = Waiting::default();
        for (place, due, serial) in [(1, 30, 0), (2, 10, 1), (1, 10, 2), (3, 50, 3), (2, 10, 4)] {
            waiting.push(place, due, start(serial, 0));
        }
        waiting.change(1, |due, start| *due = if start.serial == 0 { 5 } else { *due });
        let taken: Vec<_> = std::iter::from_fn(|| waiting.take_due(30)).collect();
        let order: Vec<_> =
            taken.iter().map(|(due, place, start)| (*due, *place, start.serial)).collect();
        assert_eq!(order, [(5, 1, 0), (10, 2, 1), (10, 1, 2), (10, 2, 4)]);
        assert_eq!(waiting.of(3).count(), 1);
        assert!(waiting.take_due(49).is_none() && waiting.take_due(50).is_some());
        assert!(waiting.by_place.is_empty() && waiting.by_time.is_empty());
    }

    #[test]
    fn those_of_one_layer_are_forgotten_alone() {
        let mut waiting = Waiting::default();
        (0..4).for_each(|n| waiting.push(n % 2, 10, start(n, n as usize / 2)));
        waiting.retain(1, |start| start.play.layer != 1);
        let left: Vec<_> =
            std::iter::from_fn(|| waiting.take_due(10)).map(|(_, _, s)| s.serial).collect();
        assert_eq!(left, [0, 1, 2]);
    }
}
