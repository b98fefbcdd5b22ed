//! What the people of a scene do: a layer over walkers, ragdolls, clips and gazes.

mod body;
mod crossings;
mod driving;
mod falls;
mod footways;
mod person;
mod phones;
mod random;
mod seats;
mod stroll;
mod talks;
mod traffic;
mod windows;
mod world;

use glam::Vec2;
use populace::{CharacterId, Crowd, MemberId, Placement};
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings, Obstacle};
use populace_locomotion::{GaitSpace, WalkerSettings, Walkers};
use populace_physics::Ragdolls;

use crate::Error;
use crate::plan::{BehaviourPlan, CastPlan, CrowdPlan, ScenePlan, StrollPlan};
use crate::replay::Person as CastPerson;
use crate::stage::{Lights, Stage};

use body::Body;
use footways::{Footway, Place};
use person::{Doing, Person};
use random::Random;
use traffic::{Stop, Traffic};
use world::{Crossing, World};

pub use world::Counts;

/// Acceleration of gravity in metres per second squared.
const GRAVITY: [f32; 3] = [0.0, -9.81, 0.0];

/// The people of a scene and what they do. Every member is driven by public calls alone.
///
/// A frame consists of [`advance`](Self::advance) and [`Crowd::update`]. A clone, with a snapshot of
/// the crowd, goes on as the original does, and equal plans give equal frames.
#[derive(Clone)]
pub struct Behaviours {
    world: World,
    stops: Vec<Stop>,
}

impl Behaviours {
    /// Brings the people and vehicles of a plan into a crowd. `people` has a list for each crowd of
    /// the plan, with as many people as the crowd counts. `gaits` are those of all their characters.
    ///
    /// # Errors
    ///
    /// Lists of other lengths, names that nothing in the plan has, and errors of the crowd, such as
    /// one without room for all people and vehicles.
    pub fn new(
        crowd: &mut Crowd,
        plan: &ScenePlan,
        stage: &Stage,
        people: &[Vec<CastPerson>],
        gaits: Vec<GaitSpace>,
    ) -> Result<Self, Error> {
        let traffic = Traffic::new(crowd, &plan.lanes, &plan.bays, &stage.vehicles)?;
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        gaits.into_iter().for_each(|gaits| walkers.add_gaits(gaits));
        let mut avoidance = Avoidance::new(AvoidanceSettings::default())
            .map_err(populace_locomotion::Error::from)?;
        avoidance.set_obstacles(&obstacles(plan)).map_err(populace_locomotion::Error::from)?;
        walkers.set_avoidance(Some(avoidance));
        walkers.set_ground(stage.ground().clone());
        let mut ragdolls = Ragdolls::new(GRAVITY)?;
        ragdolls.set_floor(plan.ground.height_m)?;
        let footways: Vec<_> = plan.footways.iter().filter_map(Footway::new).collect();
        let crossings = plan.crossings.iter().map(|plan| crossing(plan, &footways, &traffic));
        let world = World {
            now: 0.0,
            step_secs: 0.0,
            walkers,
            ragdolls,
            bodies: Vec::new(),
            habits: Vec::new(),
            people: Vec::new(),
            crossings: crossings.collect(),
            footways,
            spots: stage.spots.iter().map(|spot| (spot.clone(), None)).collect(),
            seats: stage.seats.iter().map(|seat| (seat.clone(), None)).collect(),
            traffic,
            talks: Vec::new(),
            counts: Counts::default(),
        };
        let mut behaviours = Self { world, stops: Vec::new() };
        for (nth, crowd_plan) in plan.crowds.iter().enumerate() {
            let people = people.get(nth).map_or(&[][..], Vec::as_slice);
            if people.len() != crowd_plan.count {
                let count = crowd_plan.count;
                return Err(Error::UnequalCrowd { people: people.len(), count });
            }
            let cast = plan.casts.iter().find(|cast| cast.name == crowd_plan.cast);
            let names = plan.casts.iter().map(|cast| &cast.name);
            let cast = cast.ok_or_else(|| Error::unknown("cast", &crowd_plan.cast, names))?;
            behaviours.bring(crowd, plan, (cast, crowd_plan), people)?;
        }
        behaviours.set_out()?;
        Ok(behaviours)
    }

    /// Moves everybody on by `secs`. Call [`Crowd::update`] with the same time afterwards.
    ///
    /// # Errors
    ///
    /// Errors of the crowd, such as a member that was despawned.
    pub fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        let world = &mut self.world;
        world.step_secs = f64::from(secs);
        world.now += world.step_secs;
        if secs <= 0.0 {
            return Ok(());
        }
        crossings::stops(world, &mut self.stops);
        world.traffic.advance(crowd, &self.stops, (world.now, secs))?;
        stroll::step(world, crowd)?;
        world.walkers.update(crowd, secs)?;
        Ok(world.ragdolls.step(crowd, secs)?)
    }

    /// The time in seconds since the beginning.
    #[must_use]
    pub fn secs(&self) -> f64 {
        self.world.now
    }

    /// The things that have happened so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.world.counts
    }

    /// The people, in the order of the plan's crowds.
    pub fn people(&self) -> impl Iterator<Item = MemberId> + '_ {
        self.world.people.iter().map(|person| person.member)
    }

    /// The vehicles.
    pub fn vehicles(&self) -> impl Iterator<Item = MemberId> + '_ {
        self.world.traffic.vehicles.iter().map(|vehicle| vehicle.member)
    }

    /// The lights of each crossing of the plan; `None` for those without.
    pub fn lights(&self) -> impl Iterator<Item = Option<Lights>> + '_ {
        let world = &self.world;
        let lights = |crossing: &Crossing| crossings::lights(crossing, world.now).0;
        world.crossings.iter().map(move |at| at.plan.lights.then(|| lights(at)))
    }

    /// Brings the people of a crowd of the plan.
    fn bring(
        &mut self,
        crowd: &mut Crowd,
        plan: &ScenePlan,
        (cast, of): (&CastPlan, &CrowdPlan),
        people: &[CastPerson],
    ) -> Result<(), Error> {
        match &of.does {
            BehaviourPlan::Stroll(habits) => {
                self.bring_strollers(crowd, plan, (cast, habits), people)
            }
            _ => Ok(()),
        }
    }

    /// Brings people who stroll: drivers first, the others spread over their footways.
    fn bring_strollers(
        &mut self,
        crowd: &mut Crowd,
        plan: &ScenePlan,
        (cast, habits): (&CastPlan, &StrollPlan),
        people: &[CastPerson],
    ) -> Result<(), Error> {
        let own = own_footways(plan, habits)?;
        let lengths: Vec<f32> =
            own.iter().map(|footway| self.world.footways[*footway].length_m()).collect();
        let all: f32 = lengths.iter().sum();
        self.world.habits.push(habits.clone());
        let habits_index = self.world.habits.len() - 1;
        let first = self.world.people.len();
        for (nth, of) in people.iter().enumerate() {
            let body = self.body(crowd, of.character, cast)?;
            let mut random = Random::new(plan.seed, (first + nth) as u64);
            let pace = habits.speed * random.between(0.82, 1.18);
            let mut along = random.part() * all;
            let footway = lengths.iter().position(|length| {
                let is_here = along < *length;
                along -= if is_here { 0.0 } else { *length };
                is_here
            });
            let footway = own.get(footway.unwrap_or(0)).copied().unwrap_or(0);
            let direction = if random.chance(0.5) { 1.0 } else { -1.0 };
            let lane = random.between(0.05, 0.95);
            let (at, yaw_rad) = match self.world.footways.get(footway) {
                Some(strip) => {
                    let aside_m = -direction * lane * strip.half_m;
                    let (at, along) = strip.at(Place { along_m: along.max(0.0), aside_m });
                    let ahead = along * direction;
                    (at, ahead.x.atan2(ahead.y))
                }
                None => (Vec2::ZERO, 0.0),
            };
            let placement = Placement::at([at.x, 0.0, at.y]).facing(yaw_rad).scaled(of.scale);
            let member = crowd.spawn(of.character, placement)?;
            if let Some(look) = of.look {
                crowd.member_mut(member)?.set_look(look);
            }
            let person = Person {
                member,
                body,
                habits: habits_index,
                scale: of.scale,
                random,
                doing: Doing::Strolls,
                pace,
                footway,
                direction,
                lane,
                goal: at,
            };
            self.add(crowd, person)?;
        }
        Ok(())
    }

    /// Adds a person: to the driver's seat of a vehicle that drives without one, or on foot.
    fn add(&mut self, crowd: &mut Crowd, person: Person) -> Result<(), Error> {
        let (who, member) = (self.world.people.len(), person.member);
        self.world.people.push(person);
        self.world.set_layers(crowd, who)?;
        let lacks_driver = |vehicle: &traffic::Vehicle| {
            vehicle.driver.is_none() && vehicle.drive == traffic::Drive::Cruises
        };
        let vehicle = self.world.traffic.vehicles.iter().position(lacks_driver);
        let drives = driving::may_drive(&self.world, who);
        match vehicle.filter(|_| drives) {
            Some(car) => {
                driving::board(&mut self.world, crowd, who, car)?;
                self.world.people[who].doing = Doing::Drives { car, since: 0.0 };
                Ok(())
            }
            None => Ok(self.world.walkers.add(crowd, member)?),
        }
    }

    /// Sends everybody off who is on foot.
    fn set_out(&mut self) -> Result<(), Error> {
        for who in 0..self.world.people.len() {
            if self.world.people[who].strolls() && !self.world.footways.is_empty() {
                self.world.go_on(who)?;
            }
        }
        Ok(())
    }

    /// Returns the index of the body of a character, and looks at the character if it is new.
    fn body(
        &mut self,
        crowd: &mut Crowd,
        character: CharacterId,
        cast: &CastPlan,
    ) -> Result<usize, Error> {
        let bodies = &mut self.world.bodies;
        if let Some(body) = bodies.iter().position(|body| body.character == character) {
            return Ok(body);
        }
        bodies.push(Body::new(crowd, character, &|key| cast.clips.get(key).cloned())?);
        Ok(bodies.len() - 1)
    }
}

/// Returns the indices of the footways on which people stroll.
fn own_footways(plan: &ScenePlan, habits: &StrollPlan) -> Result<Vec<usize>, Error> {
    if habits.footways.is_empty() {
        return Ok((0..plan.footways.len()).collect());
    }
    let index = |name: &String| {
        let names = plan.footways.iter().map(|footway| &footway.name);
        let found = plan.footways.iter().position(|footway| footway.name == *name);
        found.ok_or_else(|| Error::unknown("footway", name, names))
    };
    habits.footways.iter().map(index).collect()
}

fn obstacles(plan: &ScenePlan) -> Vec<Obstacle> {
    let obstacle = |wall: &crate::plan::WallPlan| {
        let points = wall.points.iter().copied();
        if wall.closed { Obstacle::polygon(points) } else { Obstacle::line(points) }
    };
    plan.walls.iter().map(obstacle).collect()
}

/// Finds the footways and lanes of a crossing.
fn crossing(plan: &crate::plan::CrossingPlan, footways: &[Footway], traffic: &Traffic) -> Crossing {
    let nearest = |end: [f32; 2]| {
        let distance = |footway: &usize| footways[*footway].distance_m(end.into());
        let nearest = (0..footways.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(0)
    };
    let [a, b] = plan.ends.map(Vec2::from);
    let lanes = traffic.lanes.iter().enumerate().filter_map(|(index, lane)| {
        let ([along, from], [_, to]) = (lane.place(a), lane.place(b));
        (from * to < 0.0).then_some((index, along))
    });
    let lanes = lanes.collect();
    Crossing { plan: plan.clone(), footways: plan.ends.map(nearest), lanes }
}
