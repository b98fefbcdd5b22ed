//! Members that fall as ragdolls and get up.

use std::collections::HashMap;
use std::sync::Arc;

use populace::{CharacterId, Crowd, MemberId};
use populace_physics::{Error, GetUp, RagdollPlan, Ragdolls, State};

/// Acceleration of falling bodies in m/s².
const GRAVITY: [f32; 3] = [0.0, -9.81, 0.0];
/// Push of a falling person in newton-seconds, forwards: a firm shove.
const SHOVE_NS: f32 = 60.0;
/// Time of getting up without clips for it, in seconds.
const UP_SECS: f32 = 1.2;

/// Ragdolls of a crowd.
pub(crate) struct Falls {
    ragdolls: Ragdolls,
    plans: HashMap<CharacterId, Arc<RagdollPlan>>,
    /// Those that fell at least once.
    fallen: Vec<MemberId>,
}

impl Falls {
    /// Creates a world with a floor at a height in metres.
    pub(crate) fn new(floor_m: f32) -> Result<Self, Error> {
        let mut ragdolls = Ragdolls::new(GRAVITY)?;
        ragdolls.set_floor(floor_m)?;
        Ok(Self { ragdolls, plans: HashMap::new(), fallen: Vec::new() })
    }

    /// Returns true if a member does not stand by itself.
    pub(crate) fn is_down(&self, member: MemberId) -> bool {
        !matches!(self.ragdolls.state(member), State::Animated)
    }

    /// Returns what a member does, in words.
    pub(crate) fn describe(&self, member: MemberId) -> &'static str {
        match self.ragdolls.state(member) {
            State::Animated => "animated",
            State::GoingLimp => "falls",
            State::Limp { asleep: true } => "lies",
            State::GettingUp { .. } => "gets up",
            _ => "falls",
        }
    }

    /// Makes a member fall, shoved in a direction `[x, z]` of length 1.
    pub(crate) fn fall(
        &mut self,
        crowd: &Crowd,
        member: MemberId,
        [x, z]: [f32; 2],
    ) -> Result<(), Error> {
        let character = crowd.member(member).map_err(Error::Crowd)?.character();
        let skeleton = &crowd.character(character).map_err(Error::Crowd)?.asset().skeleton;
        let plan = self
            .plans
            .entry(character)
            .or_insert_with(|| Arc::new(RagdollPlan::from_skeleton(skeleton)));
        self.ragdolls.go_limp(crowd, member, plan)?;
        if let Some(body) = plan.bodies().iter().max_by(|a, b| a.mass_kg().total_cmp(&b.mass_kg()))
        {
            let shove = [SHOVE_NS * x, 0.15 * SHOVE_NS, SHOVE_NS * z];
            self.ragdolls.push(member, body.joint(), shove, None)?;
        }
        if !self.fallen.contains(&member) {
            self.fallen.push(member);
        }
        Ok(())
    }

    /// Makes a member get up, by clips for it if it has some.
    pub(crate) fn get_up(&mut self, crowd: &mut Crowd, member: MemberId) -> Result<(), Error> {
        let character = crowd.member(member).map_err(Error::Crowd)?.character();
        let clips = GetUp::find(crowd, character);
        let has_clips =
            [clips.back, clips.front, clips.left, clips.right].iter().any(Option::is_some);
        if has_clips {
            self.ragdolls.get_up_with(crowd, member, &clips)
        } else {
            self.ragdolls.get_up(crowd, member, UP_SECS)
        }
    }

    /// Moves all ragdolls on. Before the crowd's update.
    pub(crate) fn step(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        if self.fallen.is_empty() {
            return Ok(());
        }
        self.ragdolls.step(crowd, secs)
    }
}
