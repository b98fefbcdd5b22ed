//! People in lanes away from crossings: vehicles stop for them.

use populace::Crowd;

use super::person::Doing;
use super::traffic::Stop;
use super::world::World;
use crate::Error;

/// Half the width of the strip of a lane in which people stop vehicles, in metres: half a van, and
/// a shoulder.
const HALF_M: f32 = 1.3;
/// How far vehicles stop before somebody, in metres.
const STOP_M: f32 = 1.5;
/// How far past somebody a vehicle begins that drives on, in metres.
const PAST_M: f32 = 0.4;
/// Differences of height from which on people are on a bridge, or below one, in metres.
const STOREY_M: f32 = 2.5;
/// People nearer to each other along a lane than this, in metres, stop vehicles together.
const TOGETHER_M: f32 = 0.5;

/// Returns the lanes in which people are, and the lengths along them, in order.
fn places(world: &World, crowd: &Crowd) -> Result<Vec<(usize, f32)>, Error> {
    let mut places = Vec::new();
    if world.traffic.vehicles.is_empty() {
        return Ok(places);
    }
    for (who, person) in world.people.iter().enumerate() {
        if !stops_vehicles(&person.doing) {
            continue;
        }
        let at = world.position(who);
        for (index, lane) in world.traffic.lanes.iter().enumerate() {
            let [along_m, aside_m] = lane.place(at);
            if aside_m.abs() > HALF_M || !(-STOP_M..lane.length_m()).contains(&along_m) {
                continue;
            }
            let [_, height_m, _] = crowd.member(person.member)?.placement().position();
            if (height_m - lane.height_m()).abs() < STOREY_M {
                places.push((index, along_m));
            }
        }
    }
    places.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    places.dedup_by(|next, kept| next.0 == kept.0 && next.1 - kept.1 < TOGETHER_M);
    Ok(places)
}

/// Returns false for people with whom vehicles deal in another way: on crossings, and at their
/// doors.
fn stops_vehicles(doing: &Doing) -> bool {
    !matches!(
        doing,
        Doing::NearsCrossing { .. }
            | Doing::LooksBothWays { .. }
            | Doing::Waits { .. }
            | Doing::Crosses { .. }
            | Doing::NearsCar { .. }
            | Doing::FacesCar { .. }
            | Doing::OpensDoor { .. }
            | Doing::StepsIn { .. }
            | Doing::GetsIn { .. }
            | Doing::Drives { .. }
            | Doing::GetsOut { .. }
            | Doing::WalksFromCar { .. }
    )
}

/// Adds where vehicles must stop for people in their lanes.
pub(crate) fn stops(world: &World, crowd: &Crowd, stops: &mut Vec<Stop>) -> Result<(), Error> {
    for (lane, along_m) in places(world, crowd)? {
        let length_m = world.traffic.lanes[lane].length_m();
        // Vehicles at the end of the lane come to its start.
        for along_m in [along_m, along_m + length_m] {
            let (along_m, past_m) = (along_m - STOP_M, STOP_M + PAST_M);
            stops.push(Stop { lane, along_m, past_m, is_polite: false });
        }
    }
    Ok(())
}

/// Queues the vehicles that begin at people in their lanes.
pub(crate) fn hold(world: &mut World, crowd: &mut Crowd) -> Result<(), Error> {
    // From the end on, so that no vehicle is put back to where somebody stands.
    for (lane, along_m) in places(world, crowd)?.into_iter().rev() {
        world.traffic.hold(crowd, lane, [along_m - STOP_M, along_m + PAST_M])?;
    }
    Ok(())
}
