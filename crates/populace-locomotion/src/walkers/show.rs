//! Placements, mixes of clips and strides of the members of walkers.

use populace::Crowd;

use super::Walkers;
use super::goals::Manner;
use crate::Error;
use crate::avoidance::Stagger;

/// Seconds in which a walker changes to another mix of clips.
const BLENDED_SECS: f32 = 0.2;

impl Walkers {
    /// Tells the crowd where walkers are and how they step, and what a share of them plays.
    pub(super) fn show(&mut self, crowd: &mut Crowd, share: Stagger) -> Result<(), Error> {
        self.points.clear();
        for index in (share.nth..self.members.len()).step_by(share.count) {
            let walker = &self.walkers[index];
            let is_moved = self.orders[index].manner != Manner::Rests;
            if is_moved && walker.told != Some(walker.step) {
                self.points.push((self.members[index], walker.step.point()));
            }
        }
        self.let_walks_go(crowd);
        let all_move = self.orders.iter().all(|orders| orders.manner != Manner::Rests);
        let (placements, strides) = if all_move {
            (&self.placements, &self.strides)
        } else {
            let moves = |index: &usize| self.orders[*index].manner != Manner::Rests;
            let moving = || (0..self.orders.len()).filter(moves);
            let (placements, strides) = &mut self.shown;
            placements.clear();
            placements.extend(moving().map(|index| self.placements[index]));
            strides.clear();
            strides.extend(moving().map(|index| self.strides[index]));
            strides.extend(&self.let_go);
            (&*placements, &*strides)
        };
        // A member that the crowd refuses keeps as little as possible from the others.
        let placed = crowd.set_placements(placements);
        let blended = crowd.set_blend_parameters(&self.points, BLENDED_SECS);
        let stepped = crowd.set_strides(strides);
        if blended.is_ok() {
            for (member, _) in &self.points {
                let walker = &mut self.walkers[self.by_member[member.number() as usize] as usize];
                walker.told = Some(walker.step);
            }
        }
        Ok(placed.and(blended).and(stepped)?)
    }

    /// Sets the blend space of each walker that has begun to rest to standing. A member that plays
    /// something else by now keeps it.
    fn let_walks_go(&mut self, crowd: &Crowd) {
        self.let_go.clear();
        for (index, orders) in self.orders.iter().enumerate() {
            let (walker, member) = (&mut self.walkers[index], self.members[index]);
            if orders.manner != Manner::Rests || walker.told == Some(walker.step) {
                continue;
            }
            let walks = crowd.member(member).is_ok_and(|view| view.blend_space_phase().is_some());
            if walks {
                self.points.push((member, walker.step.point()));
                self.let_go.push((member, walker.stride));
            }
            walker.told = Some(walker.step);
        }
    }
}
