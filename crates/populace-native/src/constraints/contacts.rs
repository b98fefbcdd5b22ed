//! Contacts of feet, mixed from the clips that a member plays on its lowest layer. Twin of
//! `kernels/contacts.cl`.
//!
//! Reads slots, the state of state machines, bound clips, clips and contacts.

use populace_device::layout::{
    CONTACT_WHOLE, Constraint, Contact, FOOT_NEAR_SECS, FOOT_STEPPING, Link, MAX_FEET, NONE,
    SLOT_LIVE, Slot,
};

use populace_model::math::Real;

use super::programs::{Company, Programs, Stop};
use super::targets::Solver;
use crate::lanes::{Simd, put};
use crate::machines::slot_now;
use crate::members::member_slots;

const FEET: usize = MAX_FEET as usize;

/// Weights of the clips of a layer, by what they do with one foot.
#[derive(Clone, Copy, Default)]
struct Mix {
    /// Sum over clips that lift the foot, of weight times seconds within a contact; negative
    /// outside of one.
    within: f32,
    /// Weight of the clips that lift the foot.
    steps: f32,
    /// Weight of the clips in which it stands throughout.
    stands: f32,
}

/// Returns the index of a foot's link to the ankle.
#[inline(always)]
pub(super) fn ankle_link(foot: &Constraint) -> usize {
    (foot.link_count - 1 - foot.toe_links) as usize
}

/// Returns the seconds from the nearest end of a contact to a time, both in seconds after the start
/// of a cycle: positive within the contact.
fn secs_within(contact: &Contact, secs: f32, cycle_secs: f32) -> f32 {
    let middle = 0.5 * (contact.from_secs + contact.until_secs);
    let away = (secs - middle).abs();
    let away = if away > 0.5 * cycle_secs { (cycle_secs - away).abs() } else { away };
    0.5 * (contact.until_secs - contact.from_secs) - away
}

/// The place of a foot in its contacts.
#[derive(Clone, Copy)]
pub(super) struct InContact<R: Real> {
    /// Seconds from the nearest end of a contact, see [`Solver::contacts_of`].
    pub(super) within_secs: R,
    /// False if no clip knows.
    pub(super) known: R::Choice,
}

impl<R: Real> InContact<R> {
    /// Returns it from its numbers: the seconds, and 1 if a clip knows.
    #[inline(always)]
    pub(super) fn of_numbers([within_secs, known]: [R; 2]) -> Self {
        Self { within_secs, known: R::splat(0.5).less(known) }
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Collects numbers of [`InContact`] for each foot. `feet` are the constraints of the first
    /// member.
    #[inline(always)]
    pub(super) fn put_contacts(&mut self, feet: &[Constraint]) -> [[Simd<COUNT>; 2]; FEET] {
        let mut contacts = [[Simd([0.0; COUNT]); 2]; FEET];
        let mut ankles = [Link::default(); FEET];
        for (ankle, foot) in ankles.iter_mut().zip(feet) {
            *ankle = self.links(foot)[ankle_link(foot)];
        }
        for lane in 0..self.members.len() {
            let Some(Stop { solver, .. }) = self.stop(lane) else { continue };
            let own = solver.contacts_of(&ankles, feet.len());
            for (all, secs) in contacts.iter_mut().zip(own) {
                put(all, lane, secs.map_or([0.0; 2], |secs| [secs, 1.0]));
            }
        }
        contacts
    }
}

impl Solver<'_> {
    /// Returns for each foot the seconds from the nearest end of a contact: positive within it,
    /// negative outside of it, at most [`FOOT_NEAR_SECS`] in size. `None` if no clip knows.
    ///
    /// A mean of these times over the clips moves the ends of contacts between those of the clips.
    /// Clips in which a foot always stands do not count, unless nearly all do so: a standing clip
    /// mixed with a walk gives smaller steps.
    pub(super) fn contacts_of(&self, ankles: &[Link; FEET], count: usize) -> [Option<f32>; FEET] {
        let mut mixes = [Mix::default(); FEET];
        for slot in member_slots(self.tables, self.control.member) {
            if slot.bound_clip != NONE && slot.layer() == 0 {
                self.mix_contacts(slot, &ankles[..count], &mut mixes);
            }
        }
        mixes.map(|Mix { within, steps, stands }| {
            let total = steps + stands;
            let stands_still = steps <= FOOT_STEPPING * total;
            (total > 0.0).then(|| if stands_still { FOOT_NEAR_SECS } else { within / steps })
        })
    }

    #[inline(always)]
    fn mix_contacts(&self, slot: &Slot, ankles: &[Link], mixes: &mut [Mix; FEET]) {
        let (tables, tick) = (self.tables, self.inputs.frame.tick);
        let slot = slot_now(tables, &self.inputs.history.running, slot, tick);
        let weight = if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
        if weight <= 0.0 || slot.mode() == SLOT_LIVE {
            return;
        }
        let bound = &tables.bound_clips().as_slice()[slot.bound_clip as usize];
        if bound.contact_count == 0 {
            return;
        }
        let clip = &tables.clips().as_slice()[bound.clip as usize];
        let secs = slot.time_at(tick, clip.start_secs, clip.duration_secs) - clip.start_secs;
        let first = bound.contact_first as usize;
        let contacts = &tables.contacts().as_slice()[first..first + bound.contact_count as usize];
        for (ankle, mix) in ankles.iter().zip(mixes) {
            let (mut within, mut stands) = (-FOOT_NEAR_SECS, false);
            for contact in contacts.iter().filter(|contact| contact.joint == ankle.joint) {
                let of_contact = secs_within(contact, secs, clip.duration_secs);
                within = if of_contact > within { of_contact } else { within };
                let lasts_secs = contact.until_secs - contact.from_secs;
                stands |= lasts_secs >= CONTACT_WHOLE * clip.duration_secs;
            }
            if stands {
                mix.stands += weight;
            } else {
                let within = if within < FOOT_NEAR_SECS { within } else { FOOT_NEAR_SECS };
                mix.within += weight * within;
                mix.steps += weight;
            }
        }
    }
}
