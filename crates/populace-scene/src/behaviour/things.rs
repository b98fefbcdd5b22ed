//! Things that people hold and wear.

use populace::{ClipPlayback, Crowd, MemberId, Placement};

use super::arrival::{Arrival, first_layer};
use super::body::Use;
use super::grips::Grip;
use super::world::{UPPER, World};
use crate::Error;
use crate::plan::MaskPlan;
use crate::stage::{Bearer, PARCEL, PHONE};

impl Arrival<'_> {
    /// Gives a person the things that its cast holds and wears.
    pub(super) fn add_things(
        &self,
        world: &World,
        crowd: &mut Crowd,
        who: usize,
    ) -> Result<(), Error> {
        for kind in &self.cast.holds {
            if kind == PARCEL && world.people[who].carries {
                continue;
            }
            let things = self.stage.things(kind);
            let Some(nth) = who.checked_rem(things.len()) else { continue };
            let place = self.place(world, crowd, who, kind)?;
            let Some((joint, offset)) = place else { continue };
            let owner = world.member(who);
            let thing: MemberId = crowd.spawn(things[nth], Placement::at([0.0; 3]))?;
            crowd.member_mut(thing)?.attach_to(owner, joint, offset)?;
        }
        Ok(())
    }

    /// Returns where somebody bears a thing, by what it plays.
    fn place(
        &self,
        world: &World,
        crowd: &Crowd,
        who: usize,
        kind: &str,
    ) -> Result<Option<Grip>, Error> {
        let grips = &world.body(who).grips;
        let [at_ear, to_read] = grips.phones;
        let by_use = match (Bearer::of(kind), kind) {
            (Bearer::Head, _) => return Ok(grips.helmet),
            (Bearer::LeftHand, _) => return Ok(grips.left),
            (Bearer::RightHand, PARCEL) => vec![(Use::Carry, grips.parcel)],
            (Bearer::RightHand, PHONE) => vec![(Use::Phone, at_ear), (Use::Text, to_read)],
            (Bearer::RightHand, _) => vec![],
        };
        for (usage, place) in by_use {
            if place.is_some() && self.plays(world, crowd, who, usage)? {
                return Ok(place);
            }
        }
        Ok(grips.right)
    }

    /// Returns true for somebody whose arms play the clip of a use, by the plan: both to carry, and
    /// the right one else.
    fn plays(&self, world: &World, crowd: &Crowd, who: usize, usage: Use) -> Result<bool, Error> {
        let Some(used) = world.body(who).clip(usage) else { return Ok(false) };
        let first = first_layer(world, who);
        let moves_arms = |layer: usize| {
            let plan = layer.checked_sub(first).and_then(|nth| self.of.layers.get(nth));
            plan.is_none_or(|plan| {
                let moves = match plan.mask {
                    MaskPlan::WholeBody | MaskPlan::UpperBody => true,
                    MaskPlan::RightArm => usage != Use::Carry,
                    MaskPlan::LeftArm => false,
                };
                moves && !plan.additive
            })
        };
        let clips = crowd.member(world.member(who))?.active_clips();
        Ok(clips.iter().any(|clip| clip.clip == used.id && moves_arms(clip.layer)))
    }

    /// Gives somebody a parcel with a chance, if its body can carry it.
    pub(super) fn give_parcel(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        who: usize,
        chance: f32,
    ) -> Result<(), Error> {
        let place = world.body(who).grips.parcel;
        let (Some((joint, offset)), Some(parcel)) = (place, self.stage.things(PARCEL).first())
        else {
            return Ok(());
        };
        if !world.people[who].random.chance(chance) || !world.body(who).has(&[Use::Carry]) {
            return Ok(());
        }
        let parcel = crowd.spawn(*parcel, Placement::at([0.0; 3]))?;
        crowd.member_mut(parcel)?.attach_to(world.member(who), joint, offset)?;
        let phase = world.people[who].random.unit();
        let looping = ClipPlayback::looping().phase(phase);
        world.play(crowd, who, Use::Carry, (UPPER, looping))?;
        world.people[who].carries = true;
        world.counts.carried += 1;
        Ok(())
    }
}
