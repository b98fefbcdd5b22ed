//! Behaviours of the people of a scene: a layer over walkers, ragdolls, clips and gazes.

mod armies;
mod arrival;
mod body;
mod crossings;
mod driving;
mod falls;
mod footways;
mod grips;
mod groups;
mod habits;
mod hands;
mod in_lanes;
mod leans;
mod loops;
mod person;
mod phones;
mod places;
mod seats;
mod settled;
mod settling;
mod standers;
mod stands;
mod stroll;
mod taken;
mod talks;
mod things;
mod traffic;
mod ways;
mod windows;
mod world;

use glam::Vec2;
use populace::{Crowd, MemberId};
use populace_locomotion::avoidance::{self, Avoidance, AvoidanceSettings, Bystander, Obstacle};
use populace_locomotion::{GaitSpace, WalkerSettings, Walkers};
use populace_physics::Ragdolls;

use crate::Error;
use crate::plan::{CrowdPlan, ScenePlan};
use crate::replay::Person as CastPerson;
use crate::stage::{Lights, PHONE, Stage};

use arrival::Arrival;
use footways::Footway;
use hands::Phones;
use places::Places;
use taken::Taken;
use traffic::{Stop, Traffic};
use world::{Crossing, World};

pub(crate) use body::use_keys;
pub(crate) use traffic::{Lane, SWERVE_M};
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
    /// the plan, with as many people as the crowd counts. `gaits` are those of all characters that
    /// stroll or fight; who stands or watches needs none.
    ///
    /// # Errors
    ///
    /// Lists of other lengths, names that nothing in the plan has, footways without length, bays at
    /// the ends of lanes, somebody who has to walk and has no gaits, and errors of the crowd, such
    /// as one without room for all people and vehicles.
    pub fn new(
        crowd: &mut Crowd,
        plan: &ScenePlan,
        stage: &Stage,
        people: &[Vec<CastPerson>],
        gaits: Vec<GaitSpace>,
    ) -> Result<Self, Error> {
        let footways = plan.footways.iter().map(Footway::new).collect::<Result<Vec<_>, _>>()?;
        let traffic = Traffic::new(crowd, &plan.lanes, &plan.bays, &stage.vehicles)?;
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        gaits.into_iter().for_each(|gaits| walkers.add_gaits(gaits));
        let standers = standers::of_plan(crowd, plan, people)?;
        let bystanders = standers::bystanders(&standers);
        let avoidance = avoidance(plan, &bystanders).map_err(populace_locomotion::Error::from)?;
        walkers.set_avoidance(Some(avoidance));
        walkers.set_ground(stage.ground().clone());
        let mut ragdolls = Ragdolls::new(GRAVITY)?;
        ragdolls.set_floor(plan.ground.height_m)?;
        let crossings = plan.crossings.iter().map(|plan| crossing(plan, &footways, &traffic));
        let world = World {
            now: 0.0,
            step_secs: 0.0,
            walkers,
            ragdolls,
            bodies: Vec::new(),
            strolls: Vec::new(),
            stands: Vec::new(),
            armies: Vec::new(),
            people: Vec::new(),
            crossings: crossings.collect(),
            footways,
            standing: Taken::by(&bystanders),
            spots: Places::new(stage.spots.clone()),
            leans: Places::new(stage.leans.clone()),
            seats: Places::new(stage.seats.clone()),
            traffic,
            talks: Vec::new(),
            groups: Vec::new(),
            phones: Phones::new(stage.things(PHONE).first().copied()),
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
            let standers = standers.get(nth).map_or(&[][..], Vec::as_slice);
            let arrival = Arrival { plan, stage, cast, of: crowd_plan, standers };
            arrival.bring(&mut behaviours.world, crowd, people)?;
        }
        arrival::set_out(&mut behaviours.world)?;
        in_lanes::hold(&mut behaviours.world, crowd)?;
        driving::fade(&behaviours.world, crowd)?;
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
        in_lanes::stops(world, crowd, &mut self.stops)?;
        world.traffic.advance(crowd, &self.stops, (world.now, secs))?;
        stroll::step(world, crowd)?;
        driving::fade(world, crowd)?;
        world.phones.step(crowd, (world.now, world.step_secs))?;
        world.walkers.update(crowd, secs)?;
        Ok(world.ragdolls.step(crowd, secs)?)
    }

    /// Names the habits that the plan asks for and no person of a crowd has the clips for, with the
    /// cure. A plan asks for a habit by a rate other than the usual one. `plan` is that of
    /// [`new`](Self::new).
    #[must_use]
    pub fn doubts(&self, plan: &ScenePlan) -> Vec<String> {
        let mut first = 0;
        let doubt = |of: &CrowdPlan| {
            let people = self.world.people.iter().skip(first).take(of.count);
            first += of.count;
            let mut bodies: Vec<usize> = people.map(|person| person.body).collect();
            bodies.sort_unstable();
            bodies.dedup();
            let bodies: Vec<_> =
                bodies.into_iter().filter_map(|body| self.world.bodies.get(body)).collect();
            let cast = plan.casts.iter().find(|cast| cast.name == of.cast)?;
            habits::doubt(of, cast, &bodies)
        };
        plan.crowds.iter().filter_map(doubt).collect()
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
}

/// Creates the avoidance of walls and of people who stand.
fn avoidance(plan: &ScenePlan, bystanders: &[Bystander]) -> Result<Avoidance, avoidance::Error> {
    let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
    avoidance.set_obstacles(&obstacles(plan))?;
    avoidance.set_bystanders(bystanders)?;
    Ok(avoidance)
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
