//! Scheduled starts: queued and delayed playbacks, and those that wait for a free slot.
//!
//! A scheduled start takes no slot. When the clock passes its tick it is executed as of that tick,
//! so the slot has the same bits as if the call had been made at that time.

use std::collections::BTreeMap;

use populace_device::layout::MACHINE_PARAMETERS;
use populace_settings::parts::Playback;

use crate::SpacePoint;
use crate::crowd::by_member::ByMember;

/// The action of a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    /// Plays a clip, in place of the layer's clips if `alone`, else beside them.
    Clip { bound: u32, alone: bool },
    /// Plays a blend space, in place of what the layer plays.
    Space { index: u32, at: SpacePoint },
    /// Moves the active blend space to another position within `over_secs`.
    Move { at: SpacePoint, over_secs: f32 },
    /// Runs a state machine with initial parameters, in place of what the layer plays.
    Machine { state: u32, parameters: [f32; MACHINE_PARAMETERS as usize] },
}

/// A scheduled start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    pub(crate) serial: u64,
    pub(crate) action: Action,
    pub(crate) play: Playback,
    /// Ticks after the end of the layer's previous playback; `None` unless queued.
    pub(crate) follows_after: Option<u64>,
}

impl Start {
    /// Returns the start as due, no longer bound to the end of another.
    pub(crate) fn at_its_time(&self) -> Self {
        Self { follows_after: None, ..*self }
    }

    /// The initial state of the machine that is to start, if it is one.
    pub(crate) fn machine(&self) -> Option<u32> {
        if let Action::Machine { state, .. } = self.action { Some(state) } else { None }
    }
}

/// The tick at which a start is due, its number in order of calls, and the start.
type Entry = (u64, u64, Start);

/// All scheduled starts, by member and by time.
#[derive(Clone, Default)]
pub(crate) struct ScheduledStarts {
    by_member: ByMember<Vec<Entry>>,
    by_time: BTreeMap<(u64, u64), u32>,
    pushed: u64,
}

impl ScheduledStarts {
    pub(crate) fn push(&mut self, member_index: u32, due: u64, start: Start) {
        self.pushed += 1;
        self.by_time.insert((due, self.pushed), member_index);
        let starts = self.by_member.get_or_default(member_index);
        starts.push((due, self.pushed, start));
        sort(starts);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.by_time.is_empty()
    }

    /// Iterates over the starts of a member in order of time, with the ticks at which they are due.
    pub(crate) fn of(&self, member_index: u32) -> impl Iterator<Item = (u64, &Start)> {
        self.by_member.get(member_index).into_iter().flatten().map(|(due, _, start)| (*due, start))
    }

    /// Returns whether `which` selects any start.
    pub(crate) fn any(&self, which: impl Fn(&Start) -> bool) -> bool {
        self.by_member.iter().flat_map(|(_, starts)| starts).any(|(_, _, start)| which(start))
    }

    /// Takes the first start that is due at or before `tick`.
    pub(crate) fn take_due(&mut self, tick: u64) -> Option<(u64, u32, Start)> {
        let (&(due, order), &member_index) = self.by_time.first_key_value()?;
        if due > tick {
            return None;
        }
        self.by_time.remove(&(due, order));
        let starts = self.by_member.get_mut(member_index)?;
        let at = starts.iter().position(|entry| entry.1 == order)?;
        let (_, _, start) = starts.remove(at);
        if starts.is_empty() {
            self.by_member.remove(member_index);
        }
        Some((due, member_index, start))
    }

    /// Drops the starts of a member for which `keep` returns false.
    pub(crate) fn retain(&mut self, member_index: u32, keep: impl Fn(&Start) -> bool) {
        let Some(starts) = self.by_member.get_mut(member_index) else { return };
        starts.retain(|(due, order, start)| {
            let kept = keep(start);
            if !kept {
                self.by_time.remove(&(*due, *order));
            }
            kept
        });
        if starts.is_empty() {
            self.by_member.remove(member_index);
        }
    }

    /// Changes the starts of a member and the ticks at which they are due.
    pub(crate) fn change(
        &mut self,
        member_index: u32,
        mut change: impl FnMut(&mut u64, &mut Start),
    ) {
        let Some(starts) = self.by_member.get_mut(member_index) else { return };
        for (due, order, start) in &mut *starts {
            self.by_time.remove(&(*due, *order));
            change(due, start);
            self.by_time.insert((*due, *order), member_index);
        }
        sort(starts);
    }
}

fn sort(starts: &mut [Entry]) {
    starts.sort_by_key(|(due, order, _)| (*due, *order));
}

#[cfg(test)]
mod tests {
    use populace_settings::parts::Parts;

    use super::*;
    use crate::ClipPlayback;

    fn start(serial: u64, layer: usize) -> Start {
        let action = Action::Clip { bound: 0, alone: true };
        let play = ClipPlayback::once().on_layer(layer).parts();
        Start { serial, action, play, follows_after: None }
    }

    #[test]
    fn starts_are_taken_by_time_and_then_by_call_order() {
        let mut scheduled = ScheduledStarts::default();
        for (member_index, due, serial) in
            [(1, 30, 0), (2, 10, 1), (1, 10, 2), (3, 50, 3), (2, 10, 4)]
        {
            scheduled.push(member_index, due, start(serial, 0));
        }
        scheduled.change(1, |due, start| *due = if start.serial == 0 { 5 } else { *due });
        let taken: Vec<_> = std::iter::from_fn(|| scheduled.take_due(30)).collect();
        let order: Vec<_> = taken
            .iter()
            .map(|(due, member_index, start)| (*due, *member_index, start.serial))
            .collect();
        assert_eq!(order, [(5, 1, 0), (10, 2, 1), (10, 1, 2), (10, 2, 4)]);
        assert_eq!(scheduled.of(3).count(), 1);
        assert!(scheduled.take_due(49).is_none() && scheduled.take_due(50).is_some());
        assert!(scheduled.by_member.is_empty() && scheduled.by_time.is_empty());
    }

    #[test]
    fn starts_of_a_member_stay_in_order_of_time() {
        let mut scheduled = ScheduledStarts::default();
        for (due, serial) in [(10, 0), (20, 1), (30, 2)] {
            scheduled.push(1, due, start(serial, 0));
        }
        scheduled.change(1, |due, start| *due = if start.serial == 0 { 25 } else { *due });
        let order: Vec<_> = scheduled.of(1).map(|(due, start)| (due, start.serial)).collect();
        assert_eq!(order, [(20, 1), (25, 0), (30, 2)]);
    }

    #[test]
    fn retain_drops_starts_of_one_layer_only() {
        let mut scheduled = ScheduledStarts::default();
        (0..4).for_each(|n| scheduled.push(n % 2, 10, start(n.into(), n as usize / 2)));
        scheduled.retain(1, |start| start.play.layer != 1);
        let left: Vec<_> =
            std::iter::from_fn(|| scheduled.take_due(10)).map(|(_, _, s)| s.serial).collect();
        assert_eq!(left, [0, 1, 2]);
    }
}
