//! Members become walkers, and cease to be.

use populace::{BlendSpacePlayback, CharacterId, Crowd, MemberId, SpacePoint};

use super::goals::Orders;
use super::{NONE, Walkers};
use crate::Error;
use crate::error::within;
use crate::path::check_coordinate;
use crate::walker::{Lead, Walker};

/// The radius of a person in avoidance, in metres per metre of height.
const RADIUS: f32 = 0.14;

impl Walkers {
    /// Makes a member a walker that stands where it is placed: plays the gaits of its character and
    /// plants its feet. A member that is a walker already is reset, and keeps its place in slices.
    ///
    /// # Errors
    ///
    /// [`Error::NoGaits`] if the character has none, a body that is not from 0.1 to 20 metres high
    /// where it is placed, a coordinate that is not from -1e6 to 1e6, and errors of the crowd, such
    /// as a body without legs.
    pub fn add(&mut self, crowd: &mut Crowd, member: MemberId) -> Result<(), Error> {
        let (walker, orders, radius_m) = self.standing(crowd, member)?;
        self.start(crowd, member, (0.0.into(), 0.0), &orders)?;
        self.put(member, orders, walker, radius_m);
        Ok(())
    }

    /// Makes a member a walker that is under way as a lead says, at a phase of its step from 0 to
    /// 1. See [`follow`](Self::follow).
    ///
    /// # Errors
    ///
    /// As [`add`](Self::add), a lead with a number that is not from -1e6 to 1e6, or a phase that is
    /// not from 0 to 1.
    pub fn add_led(
        &mut self,
        crowd: &mut Crowd,
        member: MemberId,
        lead: &Lead,
        phase: f32,
    ) -> Result<(), Error> {
        lead.check()?;
        within("the phase of a step", phase, 0.0..=1.0, "from 0 to 1")?;
        let (mut walker, orders, radius_m) = self.standing(crowd, member)?;
        let phase = walker.begin(lead, &self.gaits[orders.gaits as usize], phase);
        self.start(crowd, member, (walker.step.point(), phase), &orders)?;
        self.put(member, orders, walker, radius_m);
        Ok(())
    }

    /// Ends a [`rest`](Self::rest): the walker stands where its member is placed, and its clips and
    /// strides are set again. It keeps its speed and its group.
    ///
    /// # Errors
    ///
    /// A member that is no walker, and the errors of [`add`](Self::add) for where it is placed.
    pub fn resume(&mut self, crowd: &Crowd, member: MemberId) -> Result<(), Error> {
        let index = self.index_of(member)?;
        let (walker, _, radius_m) = self.standing(crowd, member)?;
        self.orders[index].resume();
        self.walkers[index] = walker;
        self.positions[index] = walker.position.to_array();
        self.velocities[index] = [0.0; 2];
        self.radii_m[index] = radius_m;
        Ok(())
    }

    /// Returns a member as a walker that stands, with its orders and its radius in metres.
    fn standing(&self, crowd: &Crowd, member: MemberId) -> Result<(Walker, Orders, f32), Error> {
        let view = crowd.member(member)?;
        let (character, placement) = (view.character(), view.placement());
        let gaits = self.gaits_of(character).ok_or(Error::NoGaits)?;
        let height = crowd.character(character)?.asset().height_m() * placement.scale();
        within("the height of a walker", height, 0.1..=20.0, "from 0.1 to 20 metres")?;
        placement.position().into_iter().try_for_each(check_coordinate)?;
        let orders = Orders::to_stand(u32::try_from(gaits).unwrap_or(NONE));
        Ok((Walker::standing(&placement), orders, RADIUS * height))
    }

    /// Plants the feet of a member, and plays its gaits at a point and a phase.
    fn start(
        &self,
        crowd: &mut Crowd,
        member: MemberId,
        (at, phase): (SpacePoint, f32),
        orders: &Orders,
    ) -> Result<(), Error> {
        let mut view = crowd.member_mut(member)?;
        view.plant_feet(1.0)?;
        let space = self.gaits[orders.gaits as usize].space();
        let playback = BlendSpacePlayback::new().phase(phase);
        if let Err(error) = view.play_blend_space(space, at, playback) {
            // A walker that is added again goes on as it was.
            if self.index(member).is_none() {
                view.plant_feet(0.0)?;
            }
            return Err(error.into());
        }
        Ok(())
    }

    /// Puts a walker at the place of its member's number, or of one that was despawned, or at the
    /// end.
    fn put(&mut self, member: MemberId, orders: Orders, walker: Walker, radius_m: f32) {
        let number = member.number() as usize;
        self.by_member.resize(self.by_member.len().max(number + 1), NONE);
        let index = match self.by_member[number] {
            NONE => self.members.len(),
            index => index as usize,
        };
        if index == self.members.len() {
            self.by_member[number] = u32::try_from(index).unwrap_or(NONE);
            self.members.push(member);
            self.orders.push(orders.clone());
            self.walkers.push(walker);
            self.positions.push([0.0; 2]);
            self.velocities.push([0.0; 2]);
            self.preferred.push([0.0; 2]);
            self.steered.push([0.0; 2]);
            self.evades.push(false);
            self.radii_m.push(radius_m);
            self.most_speeds.push(0.0);
            self.groups.push(0);
            self.placements.push((member, walker.placement()));
            self.strides.push((member, walker.stride));
        }
        self.members[index] = member;
        self.orders[index] = orders;
        self.walkers[index] = walker;
        self.positions[index] = walker.position.to_array();
        self.velocities[index] = walker.velocity.to_array();
        self.evades[index] = false;
        self.placements[index] = (member, walker.placement());
        self.strides[index] = (member, walker.stride);
        self.radii_m[index] = radius_m;
        self.groups[index] = 0;
    }

    /// Forgets a walker; the member stays as it is. The last walker takes its place in slices.
    ///
    /// # Errors
    ///
    /// A member that is no walker.
    pub fn remove(&mut self, member: MemberId) -> Result<(), Error> {
        let index = self.index_of(member)?;
        self.members.swap_remove(index);
        self.orders.swap_remove(index);
        self.walkers.swap_remove(index);
        self.positions.swap_remove(index);
        self.velocities.swap_remove(index);
        self.preferred.swap_remove(index);
        self.steered.swap_remove(index);
        self.evades.swap_remove(index);
        self.radii_m.swap_remove(index);
        self.most_speeds.swap_remove(index);
        self.groups.swap_remove(index);
        self.placements.swap_remove(index);
        self.strides.swap_remove(index);
        self.by_member[member.number() as usize] = NONE;
        if let Some(moved) = self.members.get(index) {
            self.by_member[moved.number() as usize] = u32::try_from(index).unwrap_or(NONE);
        }
        Ok(())
    }

    fn gaits_of(&self, character: CharacterId) -> Option<usize> {
        self.gaits.iter().rposition(|gaits| gaits.character() == character)
    }

    /// Returns the index of a member in slices; `None` unless it is a walker. Indices change when
    /// walkers are removed.
    #[must_use]
    pub fn index(&self, member: MemberId) -> Option<usize> {
        self.index_of(member).ok()
    }

    pub(super) fn index_of(&self, member: MemberId) -> Result<usize, Error> {
        let number = member.number();
        let known = self.by_member.get(number as usize).map(|index| *index as usize);
        known
            .filter(|index| self.members.get(*index) == Some(&member))
            .ok_or(Error::NotAWalker { member: number })
    }
}
