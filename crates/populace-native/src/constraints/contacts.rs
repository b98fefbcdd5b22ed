//! Contacts of feet, mixed from the clips that a member plays on its lowest layer. Twin of
//! `kernels/contacts.cl`.
//!
//! Reads playing slots, bound clips, clips and contacts.

use populace_device::Tables;
use populace_device::layout::{
    CONTACT_WHOLE, Constraint, Contact, FOOT_NEAR_SECS, FOOT_STEPPING, Link, MAX_FEET,
};
use populace_model::math::Real;

use super::programs::{Company, Programs};
use crate::lanes::{Members, Simd, lane_of, load, put, store};
use crate::playback::Play;

const FEET: usize = MAX_FEET as usize;

/// Weights of the clips of a layer, by what they do with one foot: the sum over clips that lift
/// it, of weight times seconds within a contact (negative outside of one); the weight of those
/// clips; and that of clips in which it stands throughout.
type Mix<R> = [R; 3];

/// A clip that a member plays on its lowest layer.
#[derive(Clone, Copy, Default)]
struct Stepping<'a> {
    weight: f32,
    /// Time after the clip's start.
    secs: f32,
    duration_secs: f32,
    /// None if the member plays no such clip.
    contacts: &'a [Contact],
}

impl<'a> Stepping<'a> {
    /// Returns the clip of the `nth` slot with weight; `None` if the slot is not on the lowest
    /// layer, or the clip has no contacts.
    #[inline(always)]
    fn in_slot(tables: &'a Tables, play: &Play, nth: usize) -> Option<Self> {
        let (playing, secs) = play.nth(nth)?;
        let bound = &tables.bound_clips().as_slice()[playing.bound_clip as usize];
        if playing.layer != 0 || secs.is_nan() || bound.contact_count == 0 {
            return None;
        }
        let duration_secs = tables.clips().as_slice()[bound.rows as usize].duration_secs;
        let first = bound.contact_first as usize;
        let contacts = &tables.contacts().as_slice()[first..first + bound.contact_count as usize];
        Some(Self { weight: playing.weight, secs, duration_secs, contacts })
    }

    /// Adds the clip to the mixes of a foot of members that play it, with their weights and times.
    #[inline(always)]
    fn mix_contacts<R: Real>(&self, ankle: &Link, weight: R, secs: R, mix: &mut Mix<R>) {
        let near = R::splat(FOOT_NEAR_SECS);
        let (mut within, mut stands) = (-near, false);
        for contact in self.contacts.iter().filter(|contact| contact.joint == ankle.joint) {
            let of_contact = secs_within(contact, secs, self.duration_secs);
            within = R::choose(within.less(of_contact), of_contact, within);
            let lasts_secs = contact.until_secs - contact.from_secs;
            stands |= lasts_secs >= CONTACT_WHOLE * self.duration_secs;
        }
        let [sum, steps, standing] = *mix;
        *mix = if stands {
            [sum, steps, standing + weight]
        } else {
            let within = R::choose(within.less(near), within, near);
            [sum + weight * within, steps + weight, standing]
        };
    }
}

/// Returns the index of a foot's link to the ankle.
#[inline(always)]
pub(super) fn ankle_link(foot: &Constraint) -> usize {
    (foot.link_count - 1 - foot.toe_links) as usize
}

/// Returns the seconds from the nearest end of a contact to times, all in seconds after the start
/// of a cycle: positive within the contact.
#[inline(always)]
fn secs_within<R: Real>(contact: &Contact, secs: R, cycle_secs: f32) -> R {
    let (half, cycle) = (R::splat(0.5), R::splat(cycle_secs));
    let middle = half * R::splat(contact.from_secs + contact.until_secs);
    let away = (secs - middle).abs();
    let away = R::choose((half * cycle).less(away), (cycle - away).abs(), away);
    R::splat(0.5 * (contact.until_secs - contact.from_secs)) - away
}

/// The place of a foot in its contacts.
#[derive(Clone, Copy)]
pub(super) struct InContact<R: Real> {
    /// Seconds from the nearest end of a contact: positive within it, negative outside of it, at
    /// most [`FOOT_NEAR_SECS`] in size.
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

/// Returns numbers of [`InContact`] from a mix. A mean of times within contacts moves the ends of
/// contacts between those of the clips. Clips in which a foot always stands do not count, unless
/// nearly all do so: a standing clip mixed with a walk gives smaller steps.
#[inline(always)]
fn place_of<R: Real>([within, steps, stands]: Mix<R>) -> [R; 2] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let total = steps + stands;
    let stands_still = steps.at_most(R::splat(FOOT_STEPPING) * total);
    let secs = R::choose(stands_still, R::splat(FOOT_NEAR_SECS), within / steps);
    let known = zero.less(total);
    [R::choose(known, secs, zero), R::choose(known, one, zero)]
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Collects numbers of [`InContact`] for each foot. `feet` are the constraints of the first
    /// member.
    #[inline(always)]
    pub(super) fn put_contacts<R: Members>(
        &mut self,
        feet: &[Constraint],
    ) -> [[Simd<COUNT>; 2]; FEET] {
        let mut mixes = [[Simd([0.0; COUNT]); 3]; FEET];
        let tables = self.inputs.tables;
        let counts = self.plays.iter().flatten().map(|play| play.playing().len());
        let most = counts.max().unwrap_or(0);
        for nth in 0..most {
            let mut clips = [Stepping::default(); COUNT];
            for (clip, play) in clips.iter_mut().zip(self.plays.iter().flatten()) {
                *clip = Stepping::in_slot(tables, play, nth).unwrap_or_default();
            }
            self.mix_clips::<R>(&clips, feet, &mut mixes);
        }
        let mut contacts = [[Simd([0.0; COUNT]); 2]; FEET];
        for (contacts, mixes) in contacts.iter_mut().zip(&mixes).take(feet.len()) {
            for first in (0..self.members.len()).step_by(R::COUNT) {
                store(&place_of::<R>(load(mixes, first)), contacts, first);
            }
        }
        contacts
    }

    /// Adds a clip of each member to the mix of each foot: in lanes if all play the same clip.
    #[inline(always)]
    fn mix_clips<R: Members>(
        &self,
        clips: &[Stepping; COUNT],
        feet: &[Constraint],
        mixes: &mut [[Simd<COUNT>; 3]; FEET],
    ) {
        let members = self.members.len();
        let share = clips[..members].iter().all(|c| std::ptr::eq(c.contacts, clips[0].contacts));
        if share && clips[0].contacts.is_empty() {
            return;
        }
        let weights = [Simd::<COUNT>::from_fn(|lane| clips[lane].weight)];
        let times = [Simd::<COUNT>::from_fn(|lane| clips[lane].secs)];
        for (foot, mixes) in feet.iter().zip(mixes) {
            let ankle = &self.links(foot)[ankle_link(foot)];
            if share {
                for first in (0..members).step_by(R::COUNT) {
                    let ([weight], [secs]) = (load(&weights, first), load(&times, first));
                    let mut mix: Mix<R> = load(mixes, first);
                    clips[0].mix_contacts(ankle, weight, secs, &mut mix);
                    store(&mix, mixes, first);
                }
            } else {
                for (lane, clip) in clips[..members].iter().enumerate() {
                    let mut mix = lane_of(mixes, lane);
                    clip.mix_contacts(ankle, clip.weight, clip.secs, &mut mix);
                    put(mixes, lane, mix);
                }
            }
        }
    }
}
