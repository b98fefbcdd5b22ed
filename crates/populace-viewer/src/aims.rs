//! Targets of gaze and hands that people set.

use populace::model::{Role, Side};
use populace::{Crowd, Error, JointIndex, MemberId, Placement, Reach, Target, Weight};

/// Hands in the order of [`Aims::hands`].
pub(crate) const HANDS: [Side; 2] = [Side::Left, Side::Right];

/// A target that goes along with its member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aim {
    /// From the ground between the feet, in model space in metres.
    pub(crate) point: [f32; 3],
    pub(crate) weight: f32,
}

/// The targets of a member.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Aims {
    pub(crate) gaze: Option<Aim>,
    /// Left and right hand.
    pub(crate) hands: [Option<Aim>; 2],
}

impl Aims {
    /// Sets the targets of a member that is at a placement. Targets with weight 0 are cleared.
    pub(crate) fn apply(
        &self,
        crowd: &mut Crowd,
        member: MemberId,
        at: &Placement,
    ) -> Result<(), Error> {
        let world = at.world_from_model();
        // Targets in model space would stay behind a member that root motion moves.
        let target = |aim: Aim| Target::Point(world.transform_point(aim.point));
        if let Some(aim) = self.gaze {
            let mut view = crowd.member_mut(member)?;
            if aim.weight > 0.0 {
                view.look_at(target(aim), Weight::new(aim.weight)?.over_secs(0.0))?;
            } else {
                view.clear_look_at(0.0)?;
            }
        }
        for (aim, side) in self.hands.into_iter().zip(HANDS) {
            let hand = crowd.member(member)?.joint(Role::Hand(side));
            if let (Some(aim), Some(hand)) = (aim, hand) {
                reach(crowd, member, hand, (target(aim), aim.weight))?;
            }
        }
        Ok(())
    }
}

fn reach(
    crowd: &mut Crowd,
    member: MemberId,
    hand: JointIndex,
    (target, weight): (Target, f32),
) -> Result<(), Error> {
    let mut view = crowd.member_mut(member)?;
    if weight > 0.0 {
        view.reach(Reach::with(hand), target, Weight::new(weight)?.over_secs(0.0))
    } else {
        view.clear_reach(hand, 0.0)
    }
}
