//! Calls that add masks, blend spaces, machines, live clips and user stages, and play them.

use populace::model::Skeleton;
use populace::{
    After, BlendSpace, BlendSpacePlayback, ClipId, Condition, JointIndex, LiveSettings,
    MachinePlayback, Mask, SpacePoint, StateMachine, StatePlayback, Trs,
};

use crate::calls::record_play;
use crate::draw::Draw;
use crate::fixture::stages;
use crate::world::{Outcome, World};

/// Largest number of assets of each kind in a crowd, since they cannot be removed.
const MAX_ADDED: usize = 4;

fn skeleton(world: &World, body: usize) -> Skeleton {
    world
        .crowd
        .character(world.bodies[body].id)
        .expect("a character that was added")
        .asset()
        .skeleton
        .clone()
}

pub(crate) fn add_mask(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let body = draw.index("body", world.bodies.len());
    if world.bodies[body].masks.len() >= MAX_ADDED {
        return None;
    }
    let joint = draw.index("joint", world.bodies[body].joints);
    let joint = JointIndex(u32::try_from(joint).expect("few joints"));
    let mask = Mask::subtree(&skeleton(world, body), joint);
    let result =
        world.crowd.character_mut(world.bodies[body].id).and_then(|mut view| view.add_mask(&mask));
    if let Ok(mask) = result {
        world.bodies[body].masks.push(mask);
    }
    Some(Outcome::of(result))
}

/// Returns the two clips of a body with a duration.
fn cycles(world: &World, body: usize) -> [ClipId; 2] {
    [world.bodies[body].clips[0], world.bodies[body].clips[1]]
}

pub(crate) fn add_space(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    if world.spaces.len() >= MAX_ADDED {
        return None;
    }
    let [first, second] = cycles(world, draw.index("body", world.bodies.len()));
    let space = if draw.chance("is_line", 0.5) {
        BlendSpace::line(&[(first, 0.0), (second, 1.0)])
    } else {
        BlendSpace::plane(&[(first, [0.0, 0.0]), (second, [1.0, 0.0]), (first, [0.0, 1.0])])
    };
    let result = space.and_then(|space| world.crowd.add_blend_space(space));
    if let Ok(space) = result {
        world.spaces.push(space);
    }
    Some(Outcome::of(result))
}

fn point(draw: &mut Draw) -> SpacePoint {
    let [x, y, _] = draw.vector("at", -0.2, 1.2);
    [x, y].into()
}

pub(crate) fn play_space(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let count = world.spaces.len();
    let space = (count > 0).then(|| world.spaces[draw.index("space", count)])?;
    let secs = draw.secs("secs");
    let (at, speed) = (point(draw), draw.number("speed", -2.0, 2.0));
    let play = BlendSpacePlayback::new().fade_in_secs(secs).speed(speed);
    let play = play.weight(draw.number("weight", 0.0, 1.0)).on_layer(draw.index("layer", 5));
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.play_blend_space(space, at, play)),
    ))
}

pub(crate) fn steer(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let at = point(draw);
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.set_blend_parameter(at, draw.secs("secs"))),
    ))
}

pub(crate) fn add_machine(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    if world.machines.len() >= MAX_ADDED {
        return None;
    }
    let [first, second] = cycles(world, draw.index("body", world.bodies.len()));
    let machine = StateMachine::new()
        .parameter("speed", 0.0)
        .state("slow", first, StatePlayback::looping())
        .state("fast", second, StatePlayback::looping().speed(draw.number("speed", 0.5, 2.0)))
        .transition("slow", "fast", draw.secs("fade"), &[Condition::above("speed", 0.5)])
        .transition(
            "fast",
            "slow",
            0.2,
            &[Condition::below("speed", 0.4), Condition::AfterSecs(0.1)],
        );
    let result = world.crowd.add_machine(&machine);
    if let Ok(machine) = result {
        world.machines.push(machine);
    }
    Some(Outcome::of(result))
}

pub(crate) fn run_machine(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let count = world.machines.len();
    let machine = (count > 0).then(|| world.machines[draw.index("machine", count)])?;
    let play =
        MachinePlayback::new().fade_in_secs(draw.secs("secs")).on_layer(draw.index("layer", 5));
    let result = world.crowd.member_mut(member).and_then(|mut m| m.play_machine(machine, play));
    Some(record_play(world, result))
}

pub(crate) fn set_parameter(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.set_parameter("speed", draw.number("value", 0.0, 1.0))),
    ))
}

pub(crate) fn add_live_clip(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    if world.live.len() >= MAX_ADDED {
        return None;
    }
    let body = draw.index("body", world.bodies.len());
    let settings = LiveSettings { secs: draw.number("secs", 0.2, 1.0), ..LiveSettings::default() };
    let name = format!("live {}", world.live.len());
    let result = world
        .crowd
        .character_mut(world.bodies[body].id)
        .and_then(|mut view| view.add_live_clip(&name, &settings));
    if let Ok(clip) = result {
        world.live.push((clip, body, 0.0));
        world.bodies[body].clips.push(clip);
    }
    Some(Outcome::of(result))
}

pub(crate) fn append(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.live.len();
    let index = (count > 0).then(|| draw.index("live", count))?;
    let (clip, body, before) = world.live[index];
    let secs = before + f64::from(draw.number("later", 0.001, 0.05));
    let pose: Vec<Trs> = (0..world.bodies[body].joints)
        .map(|_| Trs {
            translation: draw.vector("t", -0.1, 0.3),
            rotation: draw.rotation("r"),
            ..Trs::IDENTITY
        })
        .collect();
    let result = world.crowd.clip_mut(clip).and_then(|mut view| view.append(secs, &pose));
    if result.is_ok() {
        world.live[index].2 = secs;
    }
    Some(Outcome::of(result))
}

pub(crate) fn tie_live(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.live.len();
    let (clip, _, newest) = (count > 0).then(|| world.live[draw.index("live", count)])?;
    let at_secs = newest - f64::from(draw.number("ago", 0.0, 0.2));
    Some(Outcome::of(world.crowd.clip_mut(clip).and_then(|mut view| view.resync(at_secs))))
}

/// Runs rarely, since moments cannot be removed.
pub(crate) fn name_moment(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    if !draw.chance("names", 0.01) {
        return None;
    }
    let clip = world.bodies[draw.index("body", world.bodies.len())].clips[0];
    let secs = draw.number("secs", 0.0, 0.5);
    let clip = world.crowd.clip_mut(clip);
    Some(Outcome::of(clip.and_then(|mut view| view.add_event_marker("moment", secs))))
}

pub(crate) fn add_stage(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let which = draw.index("which", 2);
    if world.staged[which].is_some() || !world.setup.has_stages {
        return None;
    }
    let after = [After::Transform, After::Pose][which];
    let [lift, stretch] = stages();
    let result = world.crowd.add_stage(after, if which == 0 { lift } else { stretch });
    if let Ok(stage) = result {
        world.staged[which] = Some(stage);
        World::keep(&mut world.stages, stage);
    }
    Some(Outcome::of(result))
}

pub(crate) fn remove_stage(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let which = draw.index("which", 2);
    let stage = world.staged[which].take()?;
    Some(Outcome::of(world.crowd.remove(stage)))
}

pub(crate) fn set_stage_parameters(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.stages.len();
    let stage = (count > 0).then(|| world.stages[draw.index("stage", count)])?;
    let parameters = draw.vector("parameters", -0.2, 0.2);
    Some(Outcome::of(world.crowd.set_stage_parameters(stage, &parameters)))
}
