//! Calls for constraints, attachments, root motion and ragdolls.

use std::sync::Arc;

use populace::{Error, Feet, Foot, Gaze, GazeLimits, Ground, JointIndex, Reach, Trs};

use crate::calls::{target, weight};
use crate::draw::Draw;
use crate::world::{Outcome, World};

pub(crate) fn look_with(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let joint = world.joint(draw, "joint", body);
    let limits = GazeLimits { yaw_rad: draw.number("yaw", 0.1, 1.5), up_rad: 0.7, down_rad: 0.8 };
    let gaze = Gaze { chain: vec![(joint, 1.0)], facing: [0.0, 0.0, 1.0], limits };
    let target = target(world, draw);
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.look_at_with(&gaze, target, weight(draw))),
    ))
}

pub(crate) fn look_at(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let target = target(world, draw);
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.look_at(target, weight(draw))),
    ))
}

pub(crate) fn look_ahead(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.clear_look_at(draw.secs("secs"))),
    ))
}

pub(crate) fn reach(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let mut reach = Reach::with(world.joint(draw, "end", body));
    if draw.chance("has_pole", 0.2) {
        reach = reach.pole(draw.vector("pole", -1.0, 1.0));
    }
    if draw.chance("keeps", 0.3) {
        reach = reach.keeping_rotation();
    }
    let target = target(world, draw);
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.reach(reach, target, weight(draw))),
    ))
}

pub(crate) fn reach_with_chain(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (first, end) = (world.joint(draw, "first", body), world.joint(draw, "end", body));
    let target = target(world, draw);
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.reach_with_chain(first, end, target, weight(draw))),
    ))
}

pub(crate) fn let_go(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let end = world.joint(draw, "end", body);
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.clear_reach(end, draw.secs("secs"))),
    ))
}

pub(crate) fn plant_feet(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let weight = draw.number("weight", 0.0, 1.0);
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.plant_feet(weight))))
}

/// Uses joints 1, 2 and 3 as a leg; they form a chain below joint 0 in all bodies.
pub(crate) fn plant_with(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let foot = Foot { hip: JointIndex(1), knee: JointIndex(2), ankle: JointIndex(3) };
    let feet =
        Feet { pelvis: JointIndex(0), feet: vec![foot], weight: draw.number("weight", 0.0, 1.0) };
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.plant_feet_with(&feet))))
}

pub(crate) fn set_ground(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let heights = draw.chance("is_field", 0.4);
    let ground = if heights {
        let heights = (0..9).map(|_| draw.number("height", -0.2, 0.2)).collect();
        Ground::height_field([-20.0; 2], 20.0, 3, heights)
    } else {
        Ground::plane(draw.number("height", -0.3, 0.3), [draw.number("slope", -0.3, 0.3), 0.0])
    };
    Some(Outcome::of(
        ground.map_err(Error::from).and_then(|ground| world.crowd.set_ground(&ground)),
    ))
}

/// Scales all bones by one of a few factors.
pub(crate) fn set_proportions(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let length = [0.8, 1.0, 1.3, f32::NAN][draw.index("length", 4)];
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.set_proportions(&vec![length; world.bodies[body].joints])),
    ))
}

pub(crate) fn attach(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let ((prop, _), (to, body)) = (world.member(draw, "prop")?, world.member(draw, "to")?);
    let joint = world.joint(draw, "joint", body);
    let offset = Trs { translation: draw.vector("offset", -0.3, 0.3), ..Trs::IDENTITY };
    Some(Outcome::of(world.crowd.member_mut(prop).and_then(|mut m| m.attach_to(to, joint, offset))))
}

pub(crate) fn detach(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.detach())))
}

pub(crate) fn move_by_clips(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let moves = draw.chance("moves", 0.7);
    let view = world.crowd.member_mut(member);
    Some(Outcome::of(
        view.and_then(|mut m| if moves { m.start_root_motion() } else { m.stop_root_motion() }),
    ))
}

pub(crate) fn place_where_moved(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let placed = world.crowd.member_mut(member).and_then(|mut m| m.commit_root_motion());
    Some(Outcome::read(placed.map(|p| p.position())))
}

fn physics<T>(result: Result<T, populace_physics::Error>) -> Outcome {
    match result {
        Ok(_) => Outcome::Done,
        Err(error) => Outcome::Refused(error.to_string()),
    }
}

pub(crate) fn go_limp(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let plan = Arc::clone(&world.bodies[body].plan);
    Some(physics(world.ragdolls.go_limp(&world.crowd, member, &plan)))
}

pub(crate) fn go_limp_from(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (plan, joint) = (Arc::clone(&world.bodies[body].plan), world.joint(draw, "joint", body));
    Some(physics(world.ragdolls.go_limp_from(&world.crowd, member, &plan, joint)))
}

pub(crate) fn push(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let joint = world.joint(draw, "joint", body);
    let impulse = draw.vector("impulse", -50.0, 50.0);
    Some(physics(world.ragdolls.push(member, joint, impulse, None)))
}

pub(crate) fn get_up(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let secs = draw.secs("secs");
    Some(physics(world.ragdolls.get_up(&mut world.crowd, member, secs)))
}
