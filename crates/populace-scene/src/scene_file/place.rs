//! Checks of where a scene takes place.

use glam::Vec2;

use super::fault::{Fault, first, first_of, unknown};
use super::limits::{COORDINATE, DRIVING_SPEED, HEADING, LIGHTS_AHEAD, Limits, WIDTH};
use super::props;
use crate::behaviour::{Lane, SWERVE_M};
use crate::plan::{
    BayPlan, CrossingPlan, FootwayPlan, LanePlan, LeanPlan, ScenePlan, SeatPlan, SpotPlan, WallPlan,
};

/// The least length of a lane in metres, and the length of it that a vehicle needs.
const LEAST_LANE_M: f32 = 1.0;
const VEHICLE_M: f32 = 6.0;

pub(super) fn check(plan: &ScenePlan) -> Option<Fault> {
    let ground = COORDINATE.check("height_m", plan.ground.height_m);
    ground
        .map(|fault| fault.within("ground"))
        .or_else(|| first_of("footway", &plan.footways, check_footway))
        .or_else(|| first_of("spot", &plan.spots, check_spot))
        .or_else(|| first_of("lean", &plan.leans, check_lean))
        .or_else(|| first_of("seat", &plan.seats, check_seat))
        .or_else(|| first_of("crossing", &plan.crossings, check_crossing))
        .or_else(|| first_of("lane", &plan.lanes, check_lane))
        .or_else(|| first_of("bay", &plan.bays, |bay| check_bay(plan, bay)))
        .or_else(|| first_of("wall", &plan.walls, check_wall))
        .or_else(|| first_of("prop", &plan.props, |prop| props::check(plan, prop)))
}

fn check_footway(footway: &FootwayPlan) -> Option<Fault> {
    let points = &footway.points;
    if let Some(fault) = COORDINATE.check_all("points", points.as_flattened()) {
        return Some(fault);
    }
    if points.windows(2).all(|pair| pair[0] == pair[1]) {
        return Some(Fault::of("points", "at least two points, not all of them equal"));
    }
    WIDTH.check("width_m", footway.width_m)
}

fn check_spot(spot: &SpotPlan) -> Option<Fault> {
    first([
        COORDINATE.check_all("at", &spot.at),
        HEADING.check("facing_deg", spot.facing_deg),
        COORDINATE.check_all("look_at", &spot.look_at),
    ])
}

fn check_lean(lean: &LeanPlan) -> Option<Fault> {
    let at = COORDINATE.check_all("at", &lean.at);
    first([at, HEADING.check("facing_deg", lean.facing_deg)])
}

fn check_seat(seat: &SeatPlan) -> Option<Fault> {
    let at = COORDINATE.check_all("at", &seat.at);
    first([at, HEADING.check("facing_deg", seat.facing_deg)])
}

fn check_crossing(crossing: &CrossingPlan) -> Option<Fault> {
    let [from, to] = crossing.ends;
    first([
        COORDINATE.check_all("ends", crossing.ends.as_flattened()),
        (from == to).then(|| Fault::of("ends", "two different points")),
        WIDTH.check("width_m", crossing.width_m),
        LIGHTS_AHEAD.check("ahead_s", crossing.ahead_s),
    ])
}

fn check_lane(lane: &LanePlan) -> Option<Fault> {
    let [from, to] = lane.ends.map(Vec2::from);
    let length_m = from.distance(to);
    let is_short = length_m < LEAST_LANE_M;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let most = (length_m / VEHICLE_M) as usize;
    first([
        COORDINATE.check_all("ends", lane.ends.as_flattened()),
        is_short
            .then(|| Fault::of("ends", format!("two points {LEAST_LANE_M} metre apart or more"))),
        Limits::new(0, most, " vehicles, one for each 6 metres").check("vehicles", lane.vehicles),
        DRIVING_SPEED.check("speed", lane.speed),
        COORDINATE.check("height_m", lane.height_m),
    ])
}

fn check_bay(plan: &ScenePlan, bay: &BayPlan) -> Option<Fault> {
    let lanes = plan.lanes.iter().map(|lane| lane.name.as_str());
    let lane = unknown("a lane of the file", &bay.lane, lanes);
    first([
        lane.map(|rule| Fault::of("lane", rule)),
        COORDINATE.check_all("at", &bay.at),
        is_at_end(plan, bay).then(|| {
            let rule = format!("beside the lane, {SWERVE_M} metres or more from both of its ends");
            Fault::of("at", rule)
        }),
    ])
}

fn is_at_end(plan: &ScenePlan, bay: &BayPlan) -> bool {
    let lane = plan.lanes.iter().find(|lane| lane.name == bay.lane);
    lane.is_some_and(|lane| !Lane::new(lane).has_room_for_bay(bay.at.into()))
}

fn check_wall(wall: &WallPlan) -> Option<Fault> {
    let points = &wall.points;
    let are_equal = |pair: &[[f32; 2]]| pair[0] == pair[1];
    let is_repeated =
        points.windows(2).any(are_equal) || wall.closed && points.first() == points.last();
    first([
        COORDINATE.check_all("points", points.as_flattened()),
        (points.len() < 2).then(|| Fault::of("points", "at least two points")),
        is_repeated.then(|| {
            let rule = "of points that differ from the one before; leave the second of two equal \
                        ones out, and the last of a closed wall if it is the first again";
            Fault::of("points", rule)
        }),
    ])
}
