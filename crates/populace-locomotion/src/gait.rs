//! The gait of a clip, or of a mix of clips, on a body.

use std::sync::Arc;

use glam::Vec2;
use populace::character::Character;
use populace::clip::Clip;
use populace::model::{Role, Side};
use populace::{Allowed, CharacterId, ClipId, Crowd, Error};

use crate::contacts::{Contact, Standing};
use crate::mix::MixedClip;
use crate::soles::{SoleSample, Soles, Treadmill};

/// Contacts, speed and stride of a body in one cycle of a clip.
///
/// Pairs of values are of the left and of the right foot; `None` for a foot that never stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Gait {
    /// The contacts of both feet, in order of their beginning.
    pub contacts: Vec<Contact>,
    /// The velocity at which the clip walks, in metres per second: to the left (+X) and forwards
    /// (+Z). The ground passes beneath the body at the opposite velocity: the median of the soles'
    /// velocities over all contacts.
    pub velocity_m_per_sec: [f32; 2],
    /// Mean speed of the standing soles over the ground, in metres per second: how much the clip
    /// itself slides.
    pub skate_m_per_sec: f32,
    /// The length of one cycle in seconds.
    pub duration_secs: f32,
    /// The mean place of each ankle over its contacts, in metres along X and Z of model space.
    /// In a clip that carries the body along, relative to where the body would be at that velocity.
    pub stance_center_m: [Option<[f32; 2]>; 2],
    /// The mean height of each sole's lowest point over its contacts, in metres above the ground of
    /// model space (y = 0): above 0 the foot hovers, below it sinks.
    pub sole_height_m: [Option<f32>; 2],
}

impl Gait {
    /// Measures a clip on a body, which need not be the one that it was made for. `None` for a body
    /// without two feet, for a clip of no length, and for one in which no foot stands.
    ///
    /// Feet are found by humanoid roles, else by where the body touches the ground at rest. The
    /// clip is played on the native device at 120 samples a second, so a retargeted clip is
    /// measured as it is shown. A sole stands while its lowest points are near the ground or below
    /// it and move back with it. It ceases to stand at twice the height at which it begins to.
    ///
    /// # Errors
    ///
    /// A clip that does not fit the body.
    pub fn measure(character: &Arc<Character>, clip: &Arc<Clip>) -> Result<Option<Self>, Error> {
        Self::measure_mix(character, &[MixedClip::new(clip, 1.0)])
    }

    /// Measures a mix of clips that play in one phase, as
    /// [`measure`](Self::measure) does for one. This is the gait of a member between the samples of
    /// a [`BlendSpace`](populace::BlendSpace). The cycle's rate is the weighted mean of the clips'
    /// rates. A clip without length is held, and does not count towards the rate.
    ///
    /// # Errors
    ///
    /// A clip that does not fit the body; more clips than a member has slots; a weight below 0 or
    /// above 1, or an offset that is not finite.
    pub fn measure_mix(
        character: &Arc<Character>,
        clips: &[MixedClip],
    ) -> Result<Option<Self>, Error> {
        if let Some(bad) = clips.iter().find(|mixed| !(0.0..=1.0).contains(&mixed.weight)) {
            let (what, allowed) =
                ("the weight of a clip", Allowed::Range { least: 0.0, most: 1.0 });
            return Err(Error::BadValue { what, value: bad.weight, allowed });
        }
        let Some(soles) = Soles::sample(character, clips)? else { return Ok(None) };
        Ok(Self::of(&soles))
    }

    /// Measures a clip on a treadmill.
    pub(crate) fn on(treadmill: &mut Treadmill, clip: &Arc<Clip>) -> Result<Option<Self>, Error> {
        let soles = treadmill.sample(&[MixedClip::new(clip, 1.0)])?;
        Ok(soles.as_ref().and_then(Self::of))
    }

    pub(crate) fn of(soles: &Soles) -> Option<Self> {
        let standing = Standing::find(soles);
        let contacts = standing.contacts(soles.duration_secs);
        let of_foot = |foot| standing.samples(soles, foot);
        let all = || of_foot(0).chain(of_foot(1));
        let slide = |sample: &SoleSample| (sample.velocity - standing.ground).length();
        let skate_m_per_sec = mean(all().map(slide))?;
        let center = |foot| {
            let x = mean(of_foot(foot).map(|sample| sample.ankle.x))?;
            Some([x, mean(of_foot(foot).map(|sample| sample.ankle.y))?])
        };
        let height = |foot| mean(of_foot(foot).map(|sample| sample.height));
        Some(Self {
            contacts,
            velocity_m_per_sec: (-standing.ground).to_array(),
            skate_m_per_sec,
            duration_secs: soles.duration_secs,
            stance_center_m: [center(0), center(1)],
            sole_height_m: [height(0), height(1)],
        })
    }

    /// Tells a crowd when feet stand in the clip that was measured, or in the same motion as
    /// another clip, such as that with its root motion: planted feet then lock from contact to
    /// lift-off. Feet without a humanoid role are left out.
    ///
    /// # Errors
    ///
    /// The errors of [`CharacterMut::set_contacts`](populace::CharacterMut::set_contacts).
    pub fn set_contacts(
        &self,
        crowd: &mut Crowd,
        character: CharacterId,
        clip: ClipId,
    ) -> Result<(), Error> {
        let roles = crowd.character(character)?.roles().cloned();
        let ankle = |side| roles.as_ref()?.joint(Role::Foot(side));
        let contact = |contact: &Contact| {
            let (from_secs, until_secs) = (contact.from_secs, contact.until_secs);
            Some(populace::Contact { ankle: ankle(contact.foot)?, from_secs, until_secs })
        };
        let contacts: Vec<_> = self.contacts.iter().filter_map(contact).collect();
        crowd.character_mut(character)?.set_contacts(clip, &contacts)
    }

    /// The speed over the ground in metres per second.
    #[must_use]
    pub fn speed_m_per_sec(&self) -> f32 {
        Vec2::from(self.velocity_m_per_sec).length()
    }

    /// The number of steps in a cycle: times at which a foot touches down.
    #[must_use]
    pub fn step_count(&self) -> usize {
        let lifts =
            |contact: &&Contact| contact.until_secs - contact.from_secs < self.duration_secs;
        self.contacts.iter().filter(lifts).count()
    }

    /// Steps in a minute; `None` if no foot lifts.
    #[must_use]
    pub fn cadence_per_min(&self) -> Option<f32> {
        let steps = self.step_count();
        (steps > 0).then(|| 60.0 * steps as f32 / self.duration_secs)
    }

    /// The length of a stride, two steps, in metres; `None` if no foot lifts.
    #[must_use]
    pub fn stride_m(&self) -> Option<f32> {
        self.cadence_per_min().map(|steps| self.speed_m_per_sec() * 120.0 / steps)
    }

    /// The share of the cycle in which a foot stands, mean of both feet, 0 to 1.
    #[must_use]
    pub fn contact_share(&self) -> f32 {
        0.5 * (self.contact_share_of(Side::Left) + self.contact_share_of(Side::Right))
    }

    /// The share of the cycle in which one foot stands, 0 to 1.
    #[must_use]
    pub fn contact_share_of(&self, foot: Side) -> f32 {
        let own = self.contacts.iter().filter(|contact| contact.foot == foot);
        own.map(|contact| contact.until_secs - contact.from_secs).sum::<f32>() / self.duration_secs
    }
}

/// Returns the mean; `None` of no values.
fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}
