//! Getting up: motions from the ground, and the plain blend to the clips.

use std::sync::Arc;

use populace::clip::Clip;
use populace::{
    CharacterId, ClipId, ClipPlayback, Crowd, LayerSettings, MAX_LAYERS, MemberId, Placement,
};

use super::{LONGEST_SECS, Ragdolls, SECS_RULE};
use crate::Error;
use crate::error::seconds;
use crate::member_ragdoll::{Ease, Fade};
use crate::motion::LyingPose;

/// Motions with which a member gets up, by the side of the body that lies on the ground. A motion
/// starts lying on the ground and ends standing, with the feet around the model's origin, in the
/// pose in which what the member plays goes on. With one that is missing the member gets up from
/// the side nearest to it.
///
/// The motion plays on a layer above what the member plays, which goes on beneath and shows again
/// when the motion has ended: a clip, a blend space or a state machine. It takes one of the
/// member's slots. If none is free, the weakest clip gives way to it, as to any other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GetUp {
    /// The motion of a member that lies on its back.
    pub back: Option<ClipId>,
    /// The motion of a member that lies on its front.
    pub front: Option<ClipId>,
    /// The motion of a member that lies on its left side.
    pub left: Option<ClipId>,
    /// The motion of a member that lies on its right side.
    pub right: Option<ClipId>,
    /// The layer that plays the motion, 1 to 3; 3 unless set. It is set to override the layers
    /// beneath at full weight, and is empty afterwards.
    pub layer: usize,
    /// The time in seconds in which the ragdoll's pose eases into the motion's first pose; 0.8
    /// unless set, at most 1,000,000. The motion starts then.
    pub ease_secs: f32,
    /// The time in seconds from the end of the motion until the member is back in what it plays;
    /// 0.5 unless set, at most 1,000,000.
    pub return_secs: f32,
}

impl Default for GetUp {
    fn default() -> Self {
        Self {
            back: None,
            front: None,
            left: None,
            right: None,
            layer: MAX_LAYERS - 1,
            ease_secs: 0.8,
            return_secs: 0.5,
        }
    }
}

impl GetUp {
    /// Finds motions by name among a character's clips: `GetUp_Back`, `GetUp_Front`, `GetUp_Left`
    /// and `GetUp_Right`, as the built-in people have them. Those that the character lacks are
    /// `None`.
    #[must_use]
    pub fn find(crowd: &Crowd, character: CharacterId) -> Self {
        let named = |name: &str| crowd.clip(character, name).ok();
        Self {
            back: named("GetUp_Back"),
            front: named("GetUp_Front"),
            left: named("GetUp_Left"),
            right: named("GetUp_Right"),
            ..Self::default()
        }
    }

    /// Returns the motion for the side that points down most. `front_up` and `left_up` are the
    /// heights, from -1 to 1, of unit vectors out of the front and the left of the body.
    fn motion(&self, front_up: f32, left_up: f32) -> Option<ClipId> {
        let sides = [
            (self.back, front_up),
            (self.front, -front_up),
            (self.left, -left_up),
            (self.right, left_up),
        ];
        let given = sides.into_iter().filter_map(|(clip, down)| Some((clip?, down)));
        // Of equal sides the first.
        given.reduce(|a, b| if b.1 > a.1 { b } else { a }).map(|(clip, _)| clip)
    }

    fn check(&self) -> Result<(), Error> {
        let times = [
            ("the time to ease into a get-up motion", self.ease_secs),
            ("the time to return from a get-up motion", self.return_secs),
        ];
        for (what, value) in times {
            if !(0.0..=LONGEST_SECS).contains(&value) {
                return Err(Error::BadValue { what, value, rule: SECS_RULE });
            }
        }
        if (1..MAX_LAYERS).contains(&self.layer) {
            Ok(())
        } else {
            let (what, rule) = ("the layer of a get-up motion", "from 1 to 3");
            Err(Error::BadValue { what, value: self.layer as f32, rule })
        }
    }
}

/// A get-up motion that plays.
#[derive(Clone)]
pub(super) struct Rising {
    pub(super) member: MemberId,
    /// The way from the pose of the ragdoll into the motion.
    ease: Option<Ease>,
    layer: usize,
    /// Time until the motion ends, then until the member is back in what it plays.
    left_secs: f32,
    /// The time to return once the motion has ended; `None` while it returns.
    return_secs: Option<f32>,
}

impl Rising {
    /// Returns the remaining weight of the ragdoll's pose.
    pub(super) fn weight(&self) -> f32 {
        self.ease.as_ref().map_or(0.0, Ease::weight)
    }
}

impl Ragdolls {
    /// Blends a limp member back to its clips over `over_secs` seconds. Afterwards its joints are
    /// exactly those of the clips. A member that is limp as a whole is first placed where it lies,
    /// on the floor below its hips, with the heading that needs the least rotation. It can be
    /// pushed until the blend ends. A member that has not gone limp yet stays as it is.
    ///
    /// A body that blends rises without using its limbs. [`get_up_with`](Self::get_up_with) plays a
    /// motion instead.
    ///
    /// # Errors
    ///
    /// [`Error::Crowd`] for a stale member, [`Error::NotLimp`], or [`Error::BadValue`] if the time
    /// is negative or not finite.
    pub fn get_up(
        &mut self,
        crowd: &mut Crowd,
        member: MemberId,
        over_secs: f32,
    ) -> Result<(), Error> {
        seconds("the time to get up", over_secs)?;
        let Some(ragdoll) = self.limp(crowd, member)? else {
            return self.withdraw(crowd, member);
        };
        if self.active[ragdoll].is_fully_limp() {
            let placement = crowd.member(member)?.placement();
            let placement = self.active[ragdoll].placement_to_get_up(placement, &self.world);
            crowd.member_mut(member)?.set_placement(placement)?;
        }
        self.withdraw(crowd, member)?;
        self.active[ragdoll].fade = Some(Fade { elapsed_secs: 0.0, over_secs });
        self.active[ragdoll].write(crowd, &self.world)
    }

    /// Lets a limp member get up with the motion for the side on which it lies. The member is
    /// placed so that the motion starts where it lies and as it lies, on the floor below its hips.
    /// Its pose eases into the motion, the motion plays, and the member returns to what it plays.
    /// Afterwards its joints are exactly those of the clips. It can fall again at any time.
    ///
    /// The pose of the ragdoll stands still from this call on, so it should have come to rest:
    /// [`State::Limp`](crate::State::Limp) tells.
    ///
    /// Without any motion, and if only a part of the member is limp, this is
    /// [`get_up`](Self::get_up) in `ease_secs + return_secs`.
    ///
    /// # Errors
    ///
    /// As for [`get_up`](Self::get_up), and [`Error::Crowd`] for a motion that does not fit the
    /// member's character, or [`Error::BadValue`] for a layer other than 1 to 3.
    pub fn get_up_with(
        &mut self,
        crowd: &mut Crowd,
        member: MemberId,
        get_up: &GetUp,
    ) -> Result<(), Error> {
        get_up.check()?;
        let Some(ragdoll) = self.limp(crowd, member)? else {
            return self.withdraw(crowd, member);
        };
        let posture = self.active[ragdoll].posture(crowd, &self.world)?;
        let motion = get_up.motion(posture.front.y, posture.left.y);
        let Some(motion) = motion.filter(|_| self.active[ragdoll].is_fully_limp()) else {
            return self.get_up(crowd, member, get_up.ease_secs + get_up.return_secs);
        };
        let clip = Arc::clone(crowd.clip_mut(motion)?.asset());
        let placement = self.placement_for(crowd, ragdoll, &clip)?;
        let before = crowd.member(member)?.placement();
        crowd.member_mut(member)?.set_placement(placement)?;
        if let Err(error) = play(crowd, member, get_up, (motion, &clip)) {
            crowd.member_mut(member)?.set_placement(before)?;
            return Err(error);
        }
        self.withdraw(crowd, member)?;
        let ragdoll = self.active.remove(ragdoll);
        let ease = ragdoll.ease(crowd, &self.world, &placement, get_up.ease_secs);
        ease.start(crowd)?;
        ragdoll.remove(&mut self.world);
        self.rising.push(Rising {
            member,
            ease: Some(ease),
            layer: get_up.layer,
            left_secs: get_up.ease_secs + clip.duration_secs(),
            return_secs: Some(get_up.return_secs),
        });
        Ok(())
    }

    /// Returns the index of a ragdoll that can get up. Returns `None` for a member that gets up
    /// already, and for one that is about to go limp for the first time.
    fn limp(&self, crowd: &Crowd, member: MemberId) -> Result<Option<usize>, Error> {
        crowd.member(member)?;
        let is_pending = self.pending.iter().any(|w| w.member == member);
        let is_rising = self.rising.iter().any(|r| r.member == member);
        match self.active.iter().position(|d| d.member == member) {
            Some(ragdoll) => Ok(self.active[ragdoll].fade.is_none().then_some(ragdoll)),
            None if is_pending || is_rising => Ok(None),
            None => Err(Error::NotLimp),
        }
    }

    /// Drops the request that a member goes limp.
    fn withdraw(&mut self, crowd: &mut Crowd, member: MemberId) -> Result<(), Error> {
        match self.pending.iter().position(|w| w.member == member) {
            Some(at) => self.pending.remove(at).unwatch(crowd),
            None => Ok(()),
        }
    }

    /// Returns the placement at which a motion starts where a ragdoll lies.
    fn placement_for(
        &self,
        crowd: &Crowd,
        ragdoll: usize,
        motion: &Clip,
    ) -> Result<Placement, Error> {
        let ragdoll = &self.active[ragdoll];
        let view = crowd.member(ragdoll.member)?;
        let skeleton = &crowd.character(view.character())?.asset().skeleton;
        let Some(lying) = LyingPose::of(motion, skeleton) else {
            return Ok(ragdoll.placement_to_get_up(view.placement(), &self.world));
        };
        let posture = ragdoll.posture(crowd, &self.world)?;
        Ok(ragdoll.placement_for(&lying, &posture, view.placement(), &self.world))
    }

    /// Advances all motions by `dt_secs`. Those that have ended fade out.
    pub(super) fn advance_rising(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<(), Error> {
        for rising in &mut self.rising {
            if let Some(ease) = &mut rising.ease
                && !ease.advance(crowd, dt_secs)?
            {
                rising.ease = None;
            }
            rising.left_secs -= dt_secs;
            if rising.left_secs > 0.0 {
                continue;
            }
            if let Some(secs) = rising.return_secs.take() {
                crowd.member_mut(rising.member)?.stop(rising.layer, secs)?;
                rising.left_secs += secs + dt_secs;
            }
        }
        self.rising.retain(|r| r.return_secs.is_some() || r.left_secs > 0.0);
        Ok(())
    }

    /// Ends the motion of a member that falls again.
    pub(super) fn end_rising(&mut self, crowd: &mut Crowd, member: MemberId) -> Result<(), Error> {
        for rising in self.rising.iter().filter(|r| r.member == member) {
            if let Some(ease) = &rising.ease {
                ease.release(crowd)?;
            }
            crowd.member_mut(member)?.stop(rising.layer, 0.0)?;
        }
        self.rising.retain(|r| r.member != member);
        Ok(())
    }
}

/// Plays a motion after holding its first pose for the time of easing.
fn play(
    crowd: &mut Crowd,
    member: MemberId,
    get_up: &GetUp,
    (motion, clip): (ClipId, &Clip),
) -> Result<(), Error> {
    let mut view = crowd.member_mut(member)?;
    let held = ClipPlayback::held_at_secs(clip.start_secs()).on_layer(get_up.layer);
    view.play(motion, held)?;
    let once = ClipPlayback::once().on_layer(get_up.layer).after_secs(get_up.ease_secs);
    view.play(motion, once)?;
    view.set_layer(get_up.layer, LayerSettings::default(), None)?;
    Ok(())
}
