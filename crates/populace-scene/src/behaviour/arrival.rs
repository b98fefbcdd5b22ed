//! Bringing the people of a plan into a crowd, each to where its behaviour begins.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec2;
use populace::{
    CharacterId, ClipPlayback, Crowd, LayerMode, LayerSettings, Placement, Target, Weight,
};
use populace_random::Rng;

use super::body::{Body, Use};
use super::falls::direction;
use super::loops::loops;
use super::person::{Doing, Kind, Person};
use super::places::PlacePlan;
use super::settling::Settling;
use super::standers::Stander;
use super::world::{Stand, WHOLE, World};
use super::{armies, driving, settled, traffic};
use crate::Error;
use crate::plan::{
    BehaviourPlan, CastPlan, CrowdPlan, FightPlan, LayerPlan, ScenePlan, SpectatePlan, StandPlan,
    StrollPlan,
};
use crate::replay::Person as CastPerson;
use crate::stage::Stage;

/// The last layer of clips that a plan adds to what people do.
const ADDED: usize = 3;

/// A crowd of a plan that is about to come.
pub(super) struct Arrival<'a> {
    pub(super) plan: &'a ScenePlan,
    pub(super) stage: &'a Stage,
    pub(super) cast: &'a CastPlan,
    pub(super) of: &'a CrowdPlan,
    /// The people of this crowd if they stand.
    pub(super) standers: &'a [Stander],
}

/// Where and how a person begins.
struct Start {
    at: [f32; 3],
    yaw_rad: f32,
    kind: Kind,
    doing: Doing,
    pace: f32,
    post: Vec2,
    is_in_front: bool,
}

impl Start {
    fn at(at: [f32; 3], yaw_rad: f32, (kind, doing): (Kind, Doing)) -> Self {
        let post = Vec2::new(at[0], at[2]);
        Self { at, yaw_rad, kind, doing, pace: 1.2, post, is_in_front: false }
    }
}

impl Arrival<'_> {
    /// Brings the people.
    pub(super) fn bring(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        people: &[CastPerson],
    ) -> Result<(), Error> {
        match &self.of.does {
            BehaviourPlan::Stroll(plan) => self.strollers(world, crowd, plan, people)?,
            BehaviourPlan::Spectate(plan) => self.spectators(world, crowd, plan, people)?,
            BehaviourPlan::Fight(plan) => self.soldiers(world, crowd, plan, people)?,
            BehaviourPlan::Stand(plan) => self.standers(world, crowd, plan, people)?,
        }
        let first = world.people.len() - people.len();
        for who in first..world.people.len() {
            self.add_layers(world, crowd, who)?;
            self.add_things(world, crowd, who)?;
            if let Some(gaze) = &self.of.gaze
                && world.body(who).can_look
            {
                let weight = Weight::new(gaze.weight)?;
                crowd.member_mut(world.member(who))?.look_at(Target::Point(gaze.at), weight)?;
            }
        }
        Ok(())
    }

    /// Brings people who stroll: drivers first, the others in the middle of what they do.
    fn strollers(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        habits: &StrollPlan,
        people: &[CastPerson],
    ) -> Result<(), Error> {
        let own = own_footways(self.plan, habits)?;
        world.strolls.push(habits.clone());
        let kind = Kind::Strolls(world.strolls.len() - 1);
        let mut on_foot = Vec::new();
        for of in people {
            let mut random = self.random(world);
            let pace = habits.speed * random.between_f32(0.82, 1.18);
            let start = Start::at([0.0; 3], 0.0, (kind, Doing::Strolls));
            let who = self.spawn(world, crowd, (of, random), Start { pace, ..start })?;
            let lacks_driver = |vehicle: &traffic::Vehicle| {
                vehicle.driver.is_none() && vehicle.drive == traffic::Drive::Cruises
            };
            let car = world.traffic.vehicles.iter().position(lacks_driver);
            match car.filter(|_| driving::may_drive(world, who)) {
                Some(car) => {
                    driving::board(world, crowd, who, car)?;
                    world.people[who].doing = Doing::Drives { car, since: 0.0 };
                }
                None => {
                    self.give_parcel(world, crowd, who, habits.carry)?;
                    on_foot.push(who);
                }
            }
        }
        let standing = world.standing.clone();
        let settling = Settling::new(&own, self.stage.ground(), &self.plan.walls, standing);
        settled::settle(world, crowd, (settling, habits), &on_foot)
    }

    /// Brings people who sit on the seats of the stage, in their order. Those without a seat stay
    /// away.
    fn spectators(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        plan: &SpectatePlan,
        people: &[CastPerson],
    ) -> Result<(), Error> {
        let free: Vec<usize> =
            (0..world.seats.len()).filter(|seat| world.seats.is_free(*seat)).collect();
        if free.len() < people.len() {
            let (people, seats) = (people.len(), free.len());
            return Err(Error::TooFewSeats { people, seats });
        }
        let stand = free.first().map(|seat| &world.seats[*seat]).map(|seat| Stand {
            plan: plan.clone(),
            first: seat.at(),
            along: Vec2::from_angle(-seat.facing_deg.to_radians()),
        });
        world.stands.extend(stand);
        let kind = Kind::Spectates(world.stands.len().saturating_sub(1));
        for (of, seat) in people.iter().zip(free) {
            let random = self.random(world);
            world.seats.take(seat);
            let yaw_rad = world.seats.yaw_rad(seat);
            let (sin, cos) = yaw_rad.sin_cos();
            let [x, y, z] = world.seats[seat].at;
            let back = populace_cast::SEAT_BACK_M;
            let at = [x + sin * back, y - populace_cast::SEAT_HEIGHT_M, z + cos * back];
            let start = Start::at(at, yaw_rad, (kind, Doing::Watches));
            let who = self.spawn(world, crowd, (of, random), start)?;
            if let Some(sit) = world.body(who).clip(Use::Sit) {
                let phase = world.people[who].random.unit();
                let playback = ClipPlayback::looping().phase(phase);
                crowd.member_mut(world.member(who))?.play(sit.id, playback)?;
            }
        }
        Ok(())
    }

    /// Brings soldiers in ranks, a way behind the line to which they advance.
    fn soldiers(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        plan: &FightPlan,
        people: &[CastPerson],
    ) -> Result<(), Error> {
        world.armies.push(plan.clone());
        let kind = Kind::Fights(world.armies.len() - 1);
        let yaw_rad = plan.facing_deg.to_radians();
        let ahead = direction(plan.facing_deg);
        let left = Vec2::new(ahead.y, -ahead.x);
        let rank = plan.rank.max(1);
        for (nth, of) in people.iter().enumerate() {
            let mut random = self.random(world);
            let (row, column) = (nth / rank, nth % rank);
            let [across, behind] = plan.spacing_m;
            let off = Vec2::new(random.between_f32(-0.12, 0.12), random.between_f32(-0.15, 0.15));
            let aside = (column as f32 - 0.5 * (rank - 1) as f32) * across + off.x;
            let post = Vec2::from(plan.at) + left * aside - ahead * (row as f32 * behind + off.y);
            let at = post - ahead * plan.advance_m;
            let height = self.stage.ground().height_at(at.x, at.y);
            let start = Start::at([at.x, height, at.y], yaw_rad, (kind, Doing::Advances));
            let (pace, is_in_front) = (random.between_f32(1.0, 1.12), row == 0);
            let start = Start { pace, post, is_in_front, ..start };
            let who = self.spawn(world, crowd, (of, random), start)?;
            let member = world.member(who);
            world.walkers.add(crowd, member)?;
            world.walkers.set_speed(member, pace)?;
            armies::hold_spear(world, crowd, who)?;
            let phase = world.people[who].random.unit();
            let playback = ClipPlayback::looping().phase(phase);
            world.play(crowd, who, Use::Shield, (WHOLE, playback))?;
        }
        Ok(())
    }

    /// Brings people who stand in rows and play a clip, once if it does not loop.
    fn standers(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        plan: &StandPlan,
        people: &[CastPerson],
    ) -> Result<(), Error> {
        let mut known = HashMap::new();
        for (of, Stander { at, yaw_rad, .. }) in people.iter().zip(self.standers.iter().copied()) {
            let mut random = self.random(world);
            let height = self.stage.ground().height_at(at.x, at.y);
            let phase = random.unit();
            let start = Start::at([at.x, height, at.y], yaw_rad, (Kind::Stands, Doing::Stands));
            let who = self.spawn(world, crowd, (of, random), start)?;
            let clip = crowd.clip(world.body(who).character, &plan.clip)?;
            let asset = Arc::clone(crowd.clip_mut(clip)?.asset());
            let (first_secs, is_looped) = match (known.get(&clip), plan.looping) {
                (Some(known), _) => *known,
                (None, Some(is_looped)) => (asset.start_secs(), is_looped),
                (None, None) => (asset.start_secs(), loops(&asset)),
            };
            known.insert(clip, (first_secs, is_looped));
            let mut member = crowd.member_mut(world.member(who))?;
            if is_looped {
                member.play(clip, ClipPlayback::looping().phase(phase))?;
            } else {
                member.play(clip, ClipPlayback::held_at_secs(first_secs))?;
                member.play(clip, ClipPlayback::once().after_secs(plan.start_s))?;
            }
        }
        Ok(())
    }

    /// Returns the random numbers of the next person.
    fn random(&self, world: &World) -> Rng {
        Rng::stream(self.plan.seed, world.people.len() as u64)
    }

    /// Spawns a person and sets its layers. Returns its number.
    fn spawn(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        (of, random): (&CastPerson, Rng),
        start: Start,
    ) -> Result<usize, Error> {
        let body = self.body(world, crowd, of.character)?;
        let Start { at, yaw_rad, kind, doing, pace, post, is_in_front } = start;
        let placement = Placement::at(at).facing(yaw_rad).scaled(of.scale);
        let member = crowd.spawn(of.character, placement)?;
        if let Some(look) = of.look {
            crowd.member_mut(member)?.set_look(look);
        }
        let (scale, goal) = (of.scale, Vec2::new(at[0], at[2]));
        world.people.push(Person {
            member,
            body,
            kind,
            scale,
            random,
            doing,
            pace,
            footway: 0,
            direction: 1.0,
            lane: 0.5,
            carries: false,
            group: None,
            held_up: 0,
            goal,
            post,
            is_in_front,
        });
        let who = world.people.len() - 1;
        world.set_layers(crowd, who)?;
        Ok(who)
    }

    /// Returns the index of the body of a character with the clips of the cast, and looks at the
    /// character if it is new.
    fn body(
        &self,
        world: &mut World,
        crowd: &mut Crowd,
        character: CharacterId,
    ) -> Result<usize, Error> {
        let names = &self.cast.clips;
        let known = world.bodies.iter().position(|body| body.is_of(character, names));
        if let Some(body) = known {
            return Ok(body);
        }
        world.bodies.push(Body::new(crowd, character, names)?);
        Ok(world.bodies.len() - 1)
    }

    /// Plays the clips of the plan over what a person does: on the layers above those of its
    /// behaviour.
    fn add_layers(&self, world: &mut World, crowd: &mut Crowd, who: usize) -> Result<(), Error> {
        let first = first_layer(world, who);
        let (layers, most) = (self.of.layers.len(), ADDED + 1 - first);
        if layers > most {
            return Err(Error::TooManyLayers { layers, most });
        }
        for (layer, plan) in (first..=ADDED).zip(&self.of.layers) {
            let LayerPlan { clip, weight, additive, mask, share } = plan;
            if !world.people[who].random.chance(*share) {
                continue;
            }
            let mask = world.body(who).mask(crowd, *mask)?;
            let clip = crowd.clip(world.body(who).character, clip)?;
            let phase = world.people[who].random.unit();
            let mode = if *additive { LayerMode::Additive } else { LayerMode::default() };
            let mut member = crowd.member_mut(world.member(who))?;
            member.set_layer(layer, LayerSettings { mode, weight: *weight }, mask)?;
            member.play(clip, ClipPlayback::looping().phase(phase).on_layer(layer).partial())?;
        }
        Ok(())
    }
}

/// Returns the first of the layers of clips that a plan adds to what a person does.
pub(super) fn first_layer(world: &World, who: usize) -> usize {
    if world.people[who].kind == Kind::Stands { WHOLE } else { ADDED }
}

/// Sends everybody off who is on foot.
pub(super) fn set_out(world: &mut World) -> Result<(), Error> {
    for who in 0..world.people.len() {
        if matches!(world.people[who].doing, Doing::Advances) {
            world.go_on(who)?;
        }
    }
    Ok(())
}

/// Returns the indices of the footways on which people stroll.
fn own_footways(plan: &ScenePlan, habits: &StrollPlan) -> Result<Vec<usize>, Error> {
    let names = || plan.footways.iter().map(|footway| &footway.name);
    let all: Vec<usize> = (0..plan.footways.len()).collect();
    let index = |name: &String| {
        let found = plan.footways.iter().position(|footway| footway.name == *name);
        found.ok_or_else(|| Error::unknown("footway", name, names()))
    };
    let own: Vec<usize> = habits.footways.iter().map(index).collect::<Result<_, _>>()?;
    match if own.is_empty() { all } else { own } {
        none if none.is_empty() => Err(Error::unknown("footway", "", names())),
        some => Ok(some),
    }
}
