//! All ragdolls of a crowd: who is limp, who goes limp, who gets up.

use std::sync::Arc;

use populace::{Crowd, JointIndex, Member};

use crate::error::{finite, seconds};
use crate::math::Vector;
use crate::member_ragdoll::{BuildParams, Fade, JointAngles, MemberRagdoll};
use crate::snapshot::Snapshot;
use crate::world::World;
use crate::{Error, RagdollPlan};

/// The longest step of the clock; a longer one is a mistake.
const LONGEST_SECS: f32 = 1e6;

/// How limp a member is.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Its clips move it.
    Animated,
    /// Asked to go limp; its speed is measured from this frame to the next.
    GoingLimp,
    /// The simulation moves it, or a part of it.
    Limp {
        /// Whether all its bodies have come to rest.
        asleep: bool,
    },
    /// On its way back to its clips.
    GettingUp {
        /// What is left of the ragdoll's weight, from 1 to 0.
        weight: f32,
    },
}

/// An impulse for a body, in newton-seconds, at a point of the world.
struct Push {
    body: usize,
    impulse: Vector,
    at: Option<Vector>,
}

/// A member whose speed is being measured.
struct PendingRagdoll {
    member: Member,
    plan: Arc<RagdollPlan>,
    limp: Vec<bool>,
    /// The first reading, and how long after it the next one is.
    before: Option<(Snapshot, f32)>,
    pushes: Vec<Push>,
}

/// The ragdolls of a crowd, in a world of their own with a floor and boxes to fall on.
///
/// A frame is [`step`](Self::step), then placing those members that move by themselves, then
/// [`Crowd::update`]. The placement of one that is limp as a whole is best left alone: its body
/// lies in the world, and follows a placement only a frame later. A member keeps its handle, its
/// place in the buffers and its clips throughout: being limp is a set of overrides.
pub struct Ragdolls {
    world: World,
    pending: Vec<PendingRagdoll>,
    active: Vec<MemberRagdoll>,
    next_id: u64,
}

impl Ragdolls {
    /// A world with this gravity, in m/s² (usually `[0.0, -9.81, 0.0]`), and a floor at height 0.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if the gravity is not finite.
    pub fn new(gravity: [f32; 3]) -> Result<Self, Error> {
        finite("gravity", &gravity)?;
        let world = World::new(Vector::from_array(gravity));
        Ok(Self { world, pending: Vec::new(), active: Vec::new(), next_id: 1 })
    }

    /// Puts the floor at another height, in metres.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if the height is not finite.
    pub fn set_floor(&mut self, height_m: f32) -> Result<(), Error> {
        finite("the height of the floor", &[height_m])?;
        self.world.set_ground(height_m);
        Ok(())
    }

    /// Adds a box that stands still, by its centre and its half sides in metres, turned about +Y.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] for numbers that are not finite, or sides that are not above zero.
    pub fn add_box(
        &mut self,
        centre: [f32; 3],
        half_sides_m: [f32; 3],
        yaw_rad: f32,
    ) -> Result<(), Error> {
        finite("the centre of a box", &centre)?;
        finite("the heading of a box", &[yaw_rad])?;
        finite("the half side of a box", &half_sides_m)?;
        if let Some(&value) = half_sides_m.iter().find(|side| **side <= 0.0) {
            return Err(Error::BadValue {
                what: "the half side of a box",
                value,
                rule: "above zero",
            });
        }
        self.world.add_box(Vector::from_array(centre), Vector::from_array(half_sides_m), yaw_rad);
        Ok(())
    }

    /// Lets a member go limp as a whole, with the pose and the speed that it has. The speed is
    /// measured from this frame to the next: the second [`step`](Self::step) from now moves it
    /// first. A member that is limp already stays so, and one that is getting up falls again.
    ///
    /// # Errors
    ///
    /// A stale member, or [`Error::WrongPlan`].
    pub fn go_limp(
        &mut self,
        crowd: &Crowd,
        member: Member,
        plan: &Arc<RagdollPlan>,
    ) -> Result<(), Error> {
        self.request(crowd, member, plan, vec![true; plan.bodies().len()])
    }

    /// Lets a part of a member go limp: the body that carries a joint, and all that hang on it,
    /// such as an arm by its upper joint. The rest follows its clips, bit for bit as before, and
    /// carries the limp part along. Parts add up.
    ///
    /// # Errors
    ///
    /// A stale member, [`Error::WrongPlan`], or [`Error::NoBody`].
    pub fn go_limp_from(
        &mut self,
        crowd: &Crowd,
        member: Member,
        plan: &Arc<RagdollPlan>,
        joint: JointIndex,
    ) -> Result<(), Error> {
        let body = plan.body_of(joint).ok_or(Error::NoBody { joint: joint.0 })?;
        self.request(crowd, member, plan, plan.with_all_below(body))
    }

    fn request(
        &mut self,
        crowd: &Crowd,
        member: Member,
        plan: &Arc<RagdollPlan>,
        mut limp: Vec<bool>,
    ) -> Result<(), Error> {
        let skeleton = &crowd.character(crowd.character_of(member)?)?.skeleton;
        if plan.joint_count() != skeleton.joint_count() {
            return Err(Error::WrongPlan {
                plan: plan.joint_count(),
                member: skeleton.joint_count(),
            });
        }
        let same = |other: &Arc<RagdollPlan>| Arc::ptr_eq(other, plan);
        let current =
            self.active.iter().find(|d| d.member == member && d.fade.is_none() && same(&d.plan));
        if let Some(ragdoll) = current {
            if limp.iter().zip(&ragdoll.limp).all(|(new, old)| *old || !new) {
                return Ok(());
            }
            limp.iter_mut().zip(&ragdoll.limp).for_each(|(new, old)| *new |= old);
        }
        if let Some(pending) = self.pending.iter_mut().find(|w| w.member == member && same(&w.plan))
        {
            pending.limp.iter_mut().zip(&limp).for_each(|(old, new)| *old |= new);
            return Ok(());
        }
        self.pending.retain(|w| w.member != member);
        self.pending.push(PendingRagdoll {
            member,
            plan: Arc::clone(plan),
            limp,
            before: None,
            pushes: Vec::new(),
        });
        Ok(())
    }

    /// Pushes a limp member, or one that was asked to go limp, at the body that carries a joint: an
    /// impulse in newton-seconds in the world, at a point of the world in metres or else at the
    /// body's centre of mass. A person of 75 kg who is pushed with 75 Ns is 1 m/s faster.
    ///
    /// # Errors
    ///
    /// [`Error::NotLimp`], [`Error::NoBody`], or numbers that are not finite.
    pub fn push(
        &mut self,
        member: Member,
        joint: JointIndex,
        impulse_ns: [f32; 3],
        at: Option<[f32; 3]>,
    ) -> Result<(), Error> {
        finite("an impulse", &impulse_ns)?;
        finite("the point of a push", at.as_ref().map_or(&[], |p| p))?;
        let no_body = Error::NoBody { joint: joint.0 };
        let (impulse, at) = (Vector::from_array(impulse_ns), at.map(Vector::from_array));
        if let Some(pending) = self.pending.iter_mut().find(|w| w.member == member) {
            let body = pending.plan.body_of(joint).ok_or(no_body)?;
            if !pending.limp[body] {
                return Err(Error::NotLimp);
            }
            pending.pushes.push(Push { body, impulse, at });
            return Ok(());
        }
        let ragdoll = self.active.iter().find(|d| d.member == member).ok_or(Error::NotLimp)?;
        let body = ragdoll.plan.body_of(joint).ok_or(no_body)?;
        push(ragdoll, &mut self.world, &Push { body, impulse, at })
    }

    /// Lets a limp member get up: over this time its joints go back to what its clips say, and at
    /// its end are exactly that. One that is limp as a whole is placed where it lies, facing the
    /// way that takes the least turning, on what is under its hips. Until then it can still be
    /// pushed. A member that was only asked to go limp stays as it is.
    ///
    /// # Errors
    ///
    /// A stale member, [`Error::NotLimp`], or a time that is negative or not finite.
    pub fn get_up(
        &mut self,
        crowd: &mut Crowd,
        member: Member,
        over_secs: f32,
    ) -> Result<(), Error> {
        seconds("the time to get up", over_secs)?;
        crowd.placement(member)?;
        let was_pending = self.pending.iter().any(|w| w.member == member);
        self.pending.retain(|w| w.member != member);
        let Some(ragdoll) = self.active.iter_mut().find(|d| d.member == member) else {
            return if was_pending { Ok(()) } else { Err(Error::NotLimp) };
        };
        if ragdoll.fade.is_some() {
            return Ok(());
        }
        if ragdoll.is_fully_limp() {
            crowd.place(
                member,
                ragdoll.placement_to_get_up(crowd.placement(member)?, &self.world),
            )?;
        }
        ragdoll.fade = Some(Fade { elapsed_secs: 0.0, over_secs });
        ragdoll.write(crowd, &self.world)
    }

    /// Moves all limp members on and tells the crowd where their joints are, for the update that
    /// follows. Frames are simulated in even steps of 1/120 s at most, and half a second at most.
    /// Members that were despawned are forgotten.
    ///
    /// # Errors
    ///
    /// A time that is negative or not finite, or a failing device.
    pub fn step(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<(), Error> {
        if !(0.0..=LONGEST_SECS).contains(&dt_secs) {
            let rule = "from 0 to 1,000,000 seconds";
            return Err(Error::BadValue { what: "the time step", value: dt_secs, rule });
        }
        self.forget(crowd);
        if dt_secs <= 0.0 {
            return Ok(());
        }
        self.start(crowd, dt_secs)?;
        let mut driven = Vec::new();
        for ragdoll in self.active.iter_mut().filter(|d| !d.is_fully_limp()) {
            if let Some(now) = Snapshot::of(crowd, ragdoll.member)? {
                driven.append(&mut ragdoll.drive(&self.world, now, dt_secs));
            }
        }
        if !self.active.is_empty() {
            self.world.step(dt_secs, &driven);
        }
        for ragdoll in &mut self.active {
            if let Some(fade) = &mut ragdoll.fade {
                fade.elapsed_secs += dt_secs;
            }
            if ragdoll.weight() > 0.0 {
                ragdoll.write(crowd, &self.world)?;
            } else {
                ragdoll.release(crowd)?;
                ragdoll.remove(&mut self.world);
            }
        }
        self.active.retain(|d| d.weight() > 0.0);
        Ok(())
    }

    /// Lets go of members that are no more.
    fn forget(&mut self, crowd: &Crowd) {
        self.pending.retain(|w| crowd.placement(w.member).is_ok());
        for ragdoll in self.active.iter().filter(|d| crowd.placement(d.member).is_err()) {
            ragdoll.remove(&mut self.world);
        }
        self.active.retain(|d| crowd.placement(d.member).is_ok());
    }

    /// Reads those who request for their speed, and puts into the world those who have it. Those whom
    /// no update has evaluated go on pending.
    fn start(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<(), Error> {
        let snapshots = self.pending.iter().map(|pending| Snapshot::of(crowd, pending.member));
        let snapshots: Vec<_> = snapshots.collect::<Result<_, _>>()?;
        for (mut pending, now) in std::mem::take(&mut self.pending).into_iter().zip(snapshots) {
            let Some(now) = now else {
                self.pending.push(pending);
                continue;
            };
            let Some((before, between_secs)) = pending.before.take() else {
                pending.before = Some((now, dt_secs));
                self.pending.push(pending);
                continue;
            };
            let before = before.without_jump(&now, between_secs);
            if let Some(old) = self.active.iter().position(|d| d.member == pending.member) {
                let old = self.active.remove(old);
                old.release(crowd)?;
                old.remove(&mut self.world);
            }
            let character = crowd.character(crowd.character_of(pending.member)?)?;
            let params = BuildParams {
                member: pending.member,
                skeleton: &character.skeleton,
                plan: &pending.plan,
                id: self.next_id,
                limp: pending.limp,
                before: &before,
                now,
                dt_secs: between_secs,
            };
            self.next_id += 1;
            let ragdoll = MemberRagdoll::build(params, &mut self.world);
            for given in &pending.pushes {
                push(&ragdoll, &mut self.world, given)?;
            }
            self.active.push(ragdoll);
        }
        Ok(())
    }

    /// How limp a member is.
    #[must_use]
    pub fn state(&self, member: Member) -> State {
        if self.pending.iter().any(|w| w.member == member) {
            return State::GoingLimp;
        }
        match self.active.iter().find(|d| d.member == member) {
            None => State::Animated,
            Some(ragdoll) if ragdoll.fade.is_some() => {
                State::GettingUp { weight: ragdoll.weight() }
            }
            Some(ragdoll) => State::Limp { asleep: ragdoll.is_asleep(&self.world) },
        }
    }

    /// How each limp body of a member is bent against the one that it hangs on, and what limits
    /// that.
    #[must_use]
    pub fn joint_angles(&self, member: Member) -> Vec<JointAngles> {
        let ragdoll = self.active.iter().find(|d| d.member == member);
        ragdoll.map_or_else(Vec::new, |d| d.joint_angles(&self.world).collect())
    }

    /// Kinetic and potential energy of a member's limp bodies in joules, the latter counted from
    /// height 0; `None` for a member that is not limp.
    #[must_use]
    pub fn energy_j(&self, member: Member) -> Option<f32> {
        Some(self.active.iter().find(|d| d.member == member)?.energy_j(&self.world))
    }
}

fn push(ragdoll: &MemberRagdoll, world: &mut World, given: &Push) -> Result<(), Error> {
    let body = ragdoll.body_mut(world, given.body).ok_or(Error::NotLimp)?;
    match given.at {
        Some(at) => body.apply_impulse_at_point(given.impulse, at, true),
        None => body.apply_impulse(given.impulse, true),
    }
    Ok(())
}
