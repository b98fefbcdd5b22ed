//! Calls that read results.

use populace::character::Region;
use populace::{Instance, Trs};

use crate::calls::numbers;
use crate::draw::Draw;
use crate::world::{Outcome, World};

pub(crate) fn playing(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let playing = world.crowd.member(member).map(|m| m.active_clips());
    let numbers =
        playing.map(|all| all.into_iter().flat_map(|p| [p.time_secs, p.weight, p.speed]).collect());
    Some(Outcome::read::<Vec<f32>>(numbers))
}

pub(crate) fn watch(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let joint = world.joint(draw, "joint", body);
    let result = world.crowd.member_mut(member).and_then(|mut m| m.watch_joint(joint));
    if let Ok(watch) = result {
        World::keep(&mut world.watches, watch);
    }
    Some(Outcome::of(result))
}

pub(crate) fn unwatch(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.watches.len();
    let watch = (count > 0).then(|| world.watches[draw.index("watch", count)])?;
    let view = world.crowd.member_mut(watch.member());
    Some(Outcome::of(view.map(|mut member| member.unwatch_joint(watch))))
}

/// The position is not compared on OpenCL, where it depends on how far the device lags behind.
pub(crate) fn sighting(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.watches.len();
    let watch = (count > 0).then(|| world.watches[draw.index("watch", count)])?;
    let sighting = world.crowd.readback(watch);
    if world.setup.needs_opencl {
        return Some(Outcome::of(sighting));
    }
    Some(Outcome::read(
        sighting.map(|seen| numbers(seen.into_iter().map(|s| s.world_from_joint).collect())),
    ))
}

pub(crate) fn listen(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(world.crowd.member_mut(member).map(|mut m| m.subscribe_events())))
}

pub(crate) fn ignore(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let view = world.crowd.member_mut(member);
    Some(Outcome::of(view.map(|mut m| m.unsubscribe_events())))
}

#[expect(clippy::cast_possible_truncation, reason = "close enough for the comparison")]
pub(crate) fn events(world: &mut World, _draw: &mut Draw) -> Option<Outcome> {
    let events = world.crowd.events().iter();
    let numbers: Vec<f32> = events.flat_map(|event| [event.at_secs as f32, event.weight]).collect();
    Some(Outcome::read(Ok(numbers)))
}

pub(crate) fn moved(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let moved = world.crowd.member_mut(member).and_then(|mut m| m.moved_placement());
    Some(Outcome::read(moved.map(|p| p.position().into_iter().chain([p.yaw_rad(), p.scale()]))))
}

pub(crate) fn palette(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::read(world.crowd.member_mut(member).and_then(|mut m| m.palette()).map(numbers)))
}

pub(crate) fn joints(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::read(
        world.crowd.member_mut(member).and_then(|mut m| m.model_from_joints()).map(numbers),
    ))
}

pub(crate) fn local_pose(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let numbers = |trs: Trs| trs.translation.into_iter().chain(trs.rotation).chain(trs.scale);
    let pose = world.crowd.member_mut(member).and_then(|mut m| m.local_pose());
    Some(Outcome::read(pose.map(|pose| pose.into_iter().flat_map(numbers))))
}

/// Reads a page without comparing it: the data between palettes is undefined.
pub(crate) fn page(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let page = draw.index("page", 2);
    let mut count = 0;
    Some(Outcome::of(world.crowd.with_page(page, &mut |elements| count += elements.len())))
}

pub(crate) fn instances(world: &mut World, _draw: &mut Draw) -> Option<Outcome> {
    let tints = |i: &Instance<'_>| Region::ALL.map(|r| i.look.tint(r)).into_iter().flatten();
    let place = |i: &Instance<'_>| i.world_from_model.rows.into_iter().flatten();
    let numbers = |i: Instance<'_>| place(&i).chain(tints(&i)).collect::<Vec<_>>();
    let numbers: Vec<f32> = world.crowd.instances().flat_map(numbers).collect();
    Some(Outcome::read(Ok(numbers)))
}

pub(crate) fn state_of(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let state =
        world.crowd.member_mut(member).and_then(|mut m| m.machine_state(draw.index("layer", 5)));
    Some(Outcome::read(state.map(|name| name.bytes().map(f32::from).collect::<Vec<_>>())))
}
