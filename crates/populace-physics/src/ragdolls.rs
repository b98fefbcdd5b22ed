//! The ragdolls of a crowd and their states.

mod get_up;

use std::sync::Arc;

use populace::{Crowd, JointIndex, MemberId, Watch};

use crate::error::{self, finite};
use crate::math::Vector;
use crate::member_ragdoll::{BuildParams, JointAngles, MemberRagdoll};
use crate::snapshot::Snapshot;
use crate::world::World;
use crate::{Error, RagdollPlan};
use get_up::Rising;

pub use get_up::GetUp;

/// Longest time that is accepted. A longer one is considered a mistake of the caller.
const LONGEST_SECS: f32 = 1e6;
const SECS_RULE: &str = "from 0 to 1,000,000 seconds";

/// Ragdoll state of a member.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    /// Clips move the member; it has no ragdoll.
    Animated,
    /// The member will go limp as soon as its velocity is known, which takes two frames.
    GoingLimp,
    /// The simulation moves the member or a part of it.
    Limp {
        /// Whether all of its bodies have come to rest.
        asleep: bool,
    },
    /// The member blends back to its clips, or gets up with a motion.
    GettingUp {
        /// Remaining weight of the ragdoll, from 1 to 0. It is 0 while a motion plays.
        weight: f32,
    },
}

/// An impulse in newton-seconds on a body, at a point in world space or at the centre of mass.
#[derive(Clone)]
struct Push {
    body: usize,
    impulse: Vector,
    at: Option<Vector>,
}

/// A member that goes limp once its velocity has been measured.
#[derive(Clone)]
struct PendingRagdoll {
    member: MemberId,
    plan: Arc<RagdollPlan>,
    limp: Vec<bool>,
    /// The first snapshot, and the time to the next one in seconds.
    before: Option<(Snapshot, f32)>,
    /// Makes updates evaluate the member, which its view hides.
    watch: Option<Watch>,
    pushes: Vec<Push>,
}

impl PendingRagdoll {
    fn unwatch(&mut self, crowd: &mut Crowd) -> Result<(), Error> {
        if let Some(watch) = self.watch.take() {
            crowd.member_mut(self.member)?.unwatch_joint(watch);
        }
        Ok(())
    }
}

/// The ragdolls of a crowd, simulated in one world with a floor and boxes.
///
/// A frame consists of [`step`](Self::step), then changes of placements by the application, then
/// [`Crowd::update`]. Do not move a member that is limp as a whole: its bodies are in world space,
/// so it would follow the new placement only one frame later. A limp member keeps its handle, its
/// buffer ranges and its clips, because a ragdoll only writes joint overrides.
///
/// A clone, with a snapshot of the crowd, goes on as the original does. Joints are evaluated again by
/// [`Crowd::restore`], which can change those of members with planted feet or with targets at joints
/// of others slightly, and with them a fall that has not begun.
#[derive(Clone)]
pub struct Ragdolls {
    world: World,
    pending: Vec<PendingRagdoll>,
    active: Vec<MemberRagdoll>,
    rising: Vec<Rising>,
    next_id: u64,
}

impl Ragdolls {
    /// Creates a world with `gravity` in m/s² (usually `[0.0, -9.81, 0.0]`) and a floor at height
    /// 0.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if a component of the gravity is not from -1,000 to 1,000 m/s².
    pub fn new(gravity: [f32; 3]) -> Result<Self, Error> {
        error::gravity(&gravity)?;
        let world = World::new(Vector::from_array(gravity));
        Ok(Self { world, pending: Vec::new(), active: Vec::new(), rising: Vec::new(), next_id: 1 })
    }

    /// Sets the height of the floor in metres.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if the height is not finite.
    pub fn set_floor(&mut self, height_m: f32) -> Result<(), Error> {
        finite("the height of the floor", &[height_m])?;
        self.world.set_ground(height_m);
        Ok(())
    }

    /// Adds a fixed box with its centre and half sides in metres, rotated by `yaw_rad` about +Y.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if a number is not finite or a half side is not above zero.
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

    /// Makes a whole member go limp with its current pose and velocity. The velocity is measured
    /// from this frame to the next, so the second [`step`](Self::step) from now is the first to
    /// move the member; a member that the crowd's view hides takes one step more. Has no effect on
    /// a member that is already limp as a whole. A member that is getting up falls again.
    ///
    /// # Errors
    ///
    /// [`Error::Crowd`] for a stale member, or [`Error::WrongPlan`].
    pub fn go_limp(
        &mut self,
        crowd: &Crowd,
        member: MemberId,
        plan: &Arc<RagdollPlan>,
    ) -> Result<(), Error> {
        self.request(crowd, member, plan, vec![true; plan.bodies().len()])
    }

    /// Makes a part of a member go limp: the body of `joint` and all of its descendants, for
    /// example an arm, given its upper joint. The other joints follow their clips bit for bit as
    /// before and move the limp part along. Calls for several parts add up.
    ///
    /// # Errors
    ///
    /// [`Error::Crowd`] for a stale member, [`Error::WrongPlan`], or [`Error::NoBody`].
    pub fn go_limp_from(
        &mut self,
        crowd: &Crowd,
        member: MemberId,
        plan: &Arc<RagdollPlan>,
        joint: JointIndex,
    ) -> Result<(), Error> {
        let body = plan.body_of(joint).ok_or(Error::NoBody { joint: joint.0 })?;
        self.request(crowd, member, plan, plan.with_descendants(body))
    }

    fn request(
        &mut self,
        crowd: &Crowd,
        member: MemberId,
        plan: &Arc<RagdollPlan>,
        mut limp: Vec<bool>,
    ) -> Result<(), Error> {
        let skeleton = &crowd.character(crowd.member(member)?.character())?.asset().skeleton;
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
        let replaced = self.pending.iter().position(|w| w.member == member);
        let watch = replaced.and_then(|at| self.pending.remove(at).watch);
        let (plan, before, pushes) = (Arc::clone(plan), None, Vec::new());
        self.pending.push(PendingRagdoll { member, plan, limp, before, watch, pushes });
        Ok(())
    }

    /// Applies an impulse in newton-seconds to the body of `joint`. `at` is the point of
    /// application in world space in metres; if it is `None`, the centre of mass is used. The
    /// member must be limp or about to go limp. An impulse of 75 Ns changes the velocity of a
    /// person of 75 kg by 1 m/s.
    ///
    /// # Errors
    ///
    /// [`Error::NotLimp`], [`Error::NoBody`], or [`Error::BadValue`] if a component of the impulse
    /// is not from -10,000,000 to 10,000,000 Ns or one of the point is not finite.
    pub fn push(
        &mut self,
        member: MemberId,
        joint: JointIndex,
        impulse_ns: [f32; 3],
        at: Option<[f32; 3]>,
    ) -> Result<(), Error> {
        error::impulse(&impulse_ns)?;
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

    /// Advances the simulation by `dt_secs` and writes the joint overrides for the following
    /// update. The frame is divided into equal steps of at most 1/120 s, and at most half a second
    /// is simulated. Ragdolls of despawned members are removed.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`] if the time is negative, not finite or above 1,000,000 s.
    /// [`Error::Crowd`] if a device fails.
    pub fn step(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<(), Error> {
        if !(0.0..=LONGEST_SECS).contains(&dt_secs) {
            let (what, rule) = ("the time step", SECS_RULE);
            return Err(Error::BadValue { what, value: dt_secs, rule });
        }
        self.remove_despawned(crowd);
        if dt_secs <= 0.0 {
            return Ok(());
        }
        self.start_pending(crowd, dt_secs)?;
        self.advance_rising(crowd, dt_secs)?;
        let mut moves = Vec::new();
        for ragdoll in self.active.iter_mut().filter(|d| !d.is_fully_limp()) {
            if let Some(now) = Snapshot::of(crowd, ragdoll.member)? {
                moves.append(&mut ragdoll.kinematic_moves(&self.world, now, dt_secs));
            }
        }
        if !self.active.is_empty() {
            self.world.step(dt_secs, &moves);
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

    /// Removes the ragdolls of despawned members.
    fn remove_despawned(&mut self, crowd: &Crowd) {
        self.pending.retain(|w| crowd.member(w.member).is_ok());
        for ragdoll in self.active.iter().filter(|d| crowd.member(d.member).is_err()) {
            ragdoll.remove(&mut self.world);
        }
        self.active.retain(|d| crowd.member(d.member).is_ok());
        self.rising.retain(|r| crowd.member(r.member).is_ok());
    }

    /// Takes a snapshot of each pending member, and builds the ragdolls of those that have two.
    /// Members that the last update has not evaluated stay pending, and are watched, so that the
    /// next one does.
    fn start_pending(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<(), Error> {
        let snapshots = self.pending.iter().map(|pending| Snapshot::of(crowd, pending.member));
        let snapshots: Vec<_> = snapshots.collect::<Result<_, _>>()?;
        for (mut pending, now) in std::mem::take(&mut self.pending).into_iter().zip(snapshots) {
            let Some(now) = now else {
                if pending.watch.is_none() {
                    let mut member = crowd.member_mut(pending.member)?;
                    pending.watch = Some(member.watch_joint(JointIndex(0))?);
                }
                self.pending.push(pending);
                continue;
            };
            let Some((before, between_secs)) = pending.before.take() else {
                pending.before = Some((now, dt_secs));
                self.pending.push(pending);
                continue;
            };
            pending.unwatch(crowd)?;
            let before = before.without_jump(&now, between_secs);
            if let Some(old) = self.active.iter().position(|d| d.member == pending.member) {
                let old = self.active.remove(old);
                old.release(crowd)?;
                old.remove(&mut self.world);
            }
            if pending.limp.iter().all(|limp| *limp) {
                self.end_rising(crowd, pending.member)?;
            }
            let character = crowd.character(crowd.member(pending.member)?.character())?.asset();
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

    /// Returns the ragdoll state of a member.
    #[must_use]
    pub fn state(&self, member: MemberId) -> State {
        if self.pending.iter().any(|w| w.member == member) {
            return State::GoingLimp;
        }
        match self.active.iter().find(|d| d.member == member) {
            None => match self.rising.iter().find(|r| r.member == member) {
                Some(rising) => State::GettingUp { weight: rising.weight() },
                None => State::Animated,
            },
            Some(ragdoll) if ragdoll.fade.is_some() => {
                State::GettingUp { weight: ragdoll.weight() }
            }
            Some(ragdoll) => State::Limp { asleep: ragdoll.is_asleep(&self.world) },
        }
    }

    /// Returns the angles of each limp body against its parent body, with their limits. Empty for a
    /// member that is not limp.
    #[must_use]
    pub fn joint_angles(&self, member: MemberId) -> Vec<JointAngles> {
        let ragdoll = self.active.iter().find(|d| d.member == member);
        ragdoll.map_or_else(Vec::new, |d| d.joint_angles(&self.world).collect())
    }

    /// Returns the kinetic plus potential energy of a member's limp bodies in joules. The potential
    /// energy is relative to height 0. Returns `None` for a member that is not limp.
    #[must_use]
    pub fn energy_j(&self, member: MemberId) -> Option<f32> {
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
