//! Going on with what people do, and deciding what strollers do next.

use populace::Crowd;

use super::person::{Doing, Kind};
use super::world::{World, per_turn};
use super::{
    armies, crossings, driving, falls, groups, leans, phones, seats, stands, talks, windows,
};
use crate::Error;

/// Things that somebody may decide to do.
const CHOICES: [Choice; 9] = [
    |world, _, who| windows::begin(world, who),
    |world, _, who| crossings::begin(world, who),
    |world, _, who| seats::begin(world, who),
    |world, _, who| talks::begin(world, who),
    |world, _, who| leans::begin(world, who),
    |world, crowd, who| phones::call(world, crowd, who),
    |world, crowd, who| phones::read(world, crowd, who),
    |world, _, who| driving::begin(world, who),
    |world, _, who| falls::begin(world, who),
];

/// The first of them need no hands.
const FOR_FULL_HANDS: usize = 2;

type Choice = fn(&mut World, &mut Crowd, usize) -> Result<bool, Error>;

/// Lets everybody go on with what they do.
pub(crate) fn step(world: &mut World, crowd: &mut Crowd) -> Result<(), Error> {
    talks::step_all(world, crowd)?;
    groups::step_all(world, crowd)?;
    for who in 0..world.people.len() {
        match world.people[who].doing {
            Doing::Strolls => {
                // Groups only walk.
                let is_alone = world.people[who].group.is_none();
                if !is_alone || !world.is_turn(who) || !decide(world, crowd, who)? {
                    world.keep_going(who)?;
                }
            }
            Doing::NearsSpot { .. } | Doing::FacesSpot { .. } | Doing::LooksIn { .. } => {
                windows::step(world, crowd, who)?;
            }
            Doing::NearsSeat { .. }
            | Doing::FacesSeat { .. }
            | Doing::SitsDown { .. }
            | Doing::Sits { .. }
            | Doing::StandsUp { .. } => seats::step(world, crowd, who)?,
            Doing::NearsWall { .. }
            | Doing::FacesAway { .. }
            | Doing::Leans { .. }
            | Doing::Straightens { .. } => leans::step(world, crowd, who)?,
            Doing::NearsCrossing { .. }
            | Doing::LooksBothWays { .. }
            | Doing::Waits { .. }
            | Doing::Crosses { .. } => crossings::step(world, crowd, who)?,
            Doing::Meets { .. } | Doing::Talks { .. } | Doing::Points { .. } => {}
            Doing::Leaves { .. } => talks::step(world, crowd, who)?,
            Doing::Phones { .. } | Doing::Texts { .. } => phones::step(world, crowd, who)?,
            Doing::NearsCar { .. }
            | Doing::FacesCar { .. }
            | Doing::OpensDoor { .. }
            | Doing::StepsIn { .. }
            | Doing::GetsIn { .. }
            | Doing::Drives { .. }
            | Doing::GetsOut { .. }
            | Doing::WalksFromCar { .. } => driving::step(world, crowd, who)?,
            Doing::Hurries { .. } | Doing::Stops { .. } | Doing::Falls { .. } | Doing::GetsUp => {
                falls::step(world, crowd, who)?;
            }
            Doing::Watches
            | Doing::Claps { .. }
            | Doing::Cheers { .. }
            | Doing::Rises { .. }
            | Doing::Subsides { .. } => stands::step(world, crowd, who)?,
            Doing::Advances | Doing::Guards | Doing::Thrusts { .. } | Doing::Flinches { .. } => {
                armies::step(world, crowd, who)?;
            }
            Doing::Stands => {}
        }
    }
    Ok(())
}

/// Decides what somebody who strolls does next. Returns true for something else than before.
fn decide(world: &mut World, crowd: &mut Crowd, who: usize) -> Result<bool, Error> {
    let Kind::Strolls(habits) = world.people[who].kind else { return Ok(false) };
    let habits = &world.strolls[habits];
    let rates = [
        habits.look_in,
        habits.cross,
        habits.sit,
        habits.talk,
        habits.lean,
        habits.phone,
        habits.text,
        habits.drive,
        habits.hurry,
    ];
    // Who carries something only looks into windows and crosses.
    let count = if world.people[who].carries { FOR_FULL_HANDS } else { CHOICES.len() };
    for (rate, choice) in rates.into_iter().zip(CHOICES).take(count) {
        if world.people[who].random.chance(per_turn(rate)) && choice(world, crowd, who)? {
            return Ok(true);
        }
    }
    Ok(false)
}
