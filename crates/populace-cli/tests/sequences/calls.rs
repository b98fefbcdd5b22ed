//! The calls of a sequence.

use populace::character::Region;
use populace::{
    Affine, ClipPlayback, JointOverride, LayerMode, LayerSettings, Placement, Space, StageUse,
    Target, Trs, Weight,
};

use crate::draw::Draw;
use crate::world::{Outcome, World};
use crate::{assets, controls, reads};

/// A call: its kind, and the seed of its arguments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Call {
    pub(crate) kind: CallKind,
    pub(crate) seed: u64,
}

macro_rules! calls {
    ($($name:ident: $weight:literal => $function:path,)*) => {
        /// The kind of a call.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) enum CallKind { $($name),* }

        /// All kinds of calls, with their relative frequency.
        pub(crate) const ALL: &[(CallKind, usize)] = &[$((CallKind::$name, $weight)),*];

        impl CallKind {
            /// Makes the call. Returns `None` if there is no object for it.
            pub(crate) fn run(self, world: &mut World, draw: &mut Draw) -> Option<Outcome> {
                match self { $(Self::$name => $function(world, draw)),* }
            }
        }
    };
}

calls! {
    Update: 60 => update,
    Spawn: 14 => spawn,
    Despawn: 10 => despawn,
    Place: 8 => place,
    SetLook: 2 => set_look,
    ClipPlayback: 14 => play,
    Blend: 4 => blend,
    Queue: 4 => queue,
    Crossfade: 6 => crossfade,
    Stop: 3 => stop,
    SetWeight: 4 => set_weight,
    SetSpeed: 3 => set_speed,
    SetLayer: 5 => set_layer,
    ActiveClip: 2 => reads::playing,
    OverrideJoints: 8 => override_joints,
    ReleaseJoints: 3 => release_joints,
    ReleaseAll: 2 => release_all,
    LookWith: 4 => controls::look_with,
    LookAt: 5 => controls::look_at,
    LookAhead: 2 => controls::look_ahead,
    Reach: 10 => controls::reach,
    ReachWithChain: 4 => controls::reach_with_chain,
    LetGo: 3 => controls::let_go,
    PlantFeet: 3 => controls::plant_feet,
    PlantWith: 2 => controls::plant_with,
    SetGround: 1 => controls::set_ground,
    SetProportions: 2 => controls::set_proportions,
    Attach: 6 => controls::attach,
    Detach: 3 => controls::detach,
    MoveByClips: 4 => controls::move_by_clips,
    PlaceWhereMoved: 1 => controls::place_where_moved,
    GoLimp: 1 => controls::go_limp,
    GoLimpFrom: 1 => controls::go_limp_from,
    Push: 1 => controls::push,
    GetUp: 4 => controls::get_up,
    Watch: 5 => reads::watch,
    Unwatch: 4 => reads::unwatch,
    JointReadback: 3 => reads::sighting,
    Listen: 1 => reads::listen,
    Ignore: 1 => reads::ignore,
    Events: 2 => reads::events,
    Moved: 1 => reads::moved,
    Palette: 1 => reads::palette,
    Joints: 2 => reads::joints,
    LocalPose: 2 => reads::local_pose,
    Page: 1 => reads::page,
    Instances: 1 => reads::instances,
    StateOf: 2 => reads::state_of,
    AddMask: 1 => assets::add_mask,
    AddSpace: 1 => assets::add_space,
    PlaySpace: 4 => assets::play_space,
    Steer: 4 => assets::steer,
    AddMachine: 1 => assets::add_machine,
    RunMachine: 4 => assets::run_machine,
    SetParameter: 5 => assets::set_parameter,
    AddLiveClip: 1 => assets::add_live_clip,
    Append: 6 => assets::append,
    TieLive: 1 => assets::tie_live,
    NameMoment: 1 => assets::name_moment,
    AddStage: 1 => assets::add_stage,
    RemoveStage: 1 => assets::remove_stage,
    SetStageParameters: 1 => assets::set_stage_parameters,
    UseStage: 3 => use_stage,
    LeaveStage: 1 => leave_stage,
    MoveTo: 1 => move_to,
    SetSplit: 1 => set_split,
}

/// Simulates ragdolls, then updates the crowd.
fn update(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    // Long steps are rare, since ragdolls divide them into many small ones.
    const LONG: [f32; 3] = [0.4, 3.0, 1000.0];
    const STEPS: [f32; 5] = [1.0 / 60.0, 1.0 / 60.0, 1.0 / 30.0, 0.0, 1e-5];
    let steps: &[f32] = if draw.chance("is_long", 0.03) { &LONG } else { &STEPS };
    let secs = steps[draw.index("step", steps.len())];
    if let Err(error) = world.ragdolls.step(&mut world.crowd, secs) {
        return Some(Outcome::Refused(error.to_string()));
    }
    Some(Outcome::of(world.crowd.update(secs)))
}

pub(crate) fn placement(draw: &mut Draw) -> Placement {
    let placement =
        Placement::at(draw.vector("position", -20.0, 20.0)).facing(draw.number("yaw", -4.0, 4.0));
    if draw.chance("is_scaled", 0.2) {
        placement.scaled(draw.number("scale", 0.3, 3.0))
    } else {
        placement
    }
}

fn spawn(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let body = draw.index("body", world.bodies.len());
    let result = world.crowd.spawn(world.bodies[body].id, placement(draw));
    if let Ok(member) = result {
        world.members.push((member, body));
    }
    Some(Outcome::of(result))
}

fn despawn(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let member = world.member(draw, "member")?;
    let result = world.crowd.despawn(member.0);
    if result.is_ok() {
        world.retire(member);
    }
    Some(Outcome::of(result))
}

fn place(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.set_placement(placement(draw))),
    ))
}

fn set_look(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let region = Region::ALL[draw.index("region", Region::COUNT)];
    let tint = draw.vector("tint", -0.5, 2.5);
    Some(Outcome::of(world.crowd.member_mut(member).map(|mut m| {
        let look = m.look().tinted(region, tint);
        m.set_look(look);
    })))
}

/// Draws play settings: mostly looping, on layer 0.
pub(crate) fn play_settings(draw: &mut Draw, secs: f32) -> ClipPlayback {
    let play = match draw.index("mode", 8) {
        0 => ClipPlayback::once(),
        1 => ClipPlayback::held_at_secs(draw.number("at", -0.5, 1.5)),
        2 => ClipPlayback::live(draw.number("delay", 0.0, 0.3)),
        _ => ClipPlayback::looping().phase(draw.number("phase", 0.0, 1.0)),
    };
    let play = if draw.chance("inertializes", 0.3) {
        play.inertialize_in_secs(secs)
    } else {
        play.fade_in_secs(secs)
    };
    let play = if draw.chance("has_speed", 0.3) {
        play.speed(draw.number("speed", -2.0, 2.0))
    } else {
        play
    };
    let play = if draw.chance("is_weighed", 0.3) {
        play.weight(draw.number("weight", 0.0, 1.0))
    } else {
        play
    };
    let play = if draw.chance("waits", 0.2) {
        play.after_secs(draw.number("after", 0.0, 0.5))
    } else {
        play
    };
    if draw.chance("is_layered", 0.3) { play.on_layer(draw.index("layer", 5)) } else { play }
}

/// Draws a clip: mostly of the member's own body.
fn clip(world: &World, draw: &mut Draw, own: usize) -> populace::ClipId {
    let others = draw.chance("of_another", 0.15);
    let body = if others { draw.index("body", world.bodies.len()) } else { own };
    let clips = &world.bodies[body].clips;
    clips[draw.index("clip", clips.len())]
}

fn play(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (clip, secs) = (clip(world, draw, body), draw.secs("secs"));
    let result =
        world.crowd.member_mut(member).and_then(|mut m| m.play(clip, play_settings(draw, secs)));
    Some(record_play(world, result))
}

fn blend(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (clip, secs) = (clip(world, draw, body), draw.secs("secs"));
    let result =
        world.crowd.member_mut(member).and_then(|mut m| m.blend(clip, play_settings(draw, secs)));
    Some(record_play(world, result))
}

fn queue(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (clip, secs) = (clip(world, draw, body), draw.secs("secs"));
    let result =
        world.crowd.member_mut(member).and_then(|mut m| m.queue(clip, play_settings(draw, secs)));
    Some(record_play(world, result))
}

fn crossfade(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let (clip, secs) = (clip(world, draw, body), draw.secs("secs"));
    let result = world.crowd.member_mut(member).and_then(|mut m| m.crossfade(clip, secs));
    Some(record_play(world, result))
}

pub(crate) fn record_play(
    world: &mut World,
    result: Result<populace::PlaybackId, populace::Error>,
) -> Outcome {
    if let Ok(play) = result {
        World::keep(&mut world.plays, play);
    }
    Outcome::of(result)
}

fn stop(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let (layer, secs) = (draw.index("layer", 5), draw.secs("secs"));
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.stop(layer, secs))))
}

fn set_weight(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.plays.len();
    let play = (count > 0).then(|| world.plays[draw.index("play", count)])?;
    let (weight, secs) = (draw.number("weight", 0.0, 1.0), draw.secs("secs"));
    Some(Outcome::of(
        world.crowd.member_mut(play.member()).and_then(|mut m| m.set_weight(play, weight, secs)),
    ))
}

fn set_speed(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let count = world.plays.len();
    let play = (count > 0).then(|| world.plays[draw.index("play", count)])?;
    Some(Outcome::of(
        world
            .crowd
            .member_mut(play.member())
            .and_then(|mut m| m.set_speed(play, draw.number("speed", -2.0, 2.0))),
    ))
}

fn set_layer(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let masks = &world.bodies[body].masks;
    let is_masked = !masks.is_empty() && draw.chance("is_masked", 0.6);
    let mask = is_masked.then(|| masks[draw.index("mask", masks.len())]);
    let additive = draw.chance("is_additive", 0.4);
    let mode = if additive { LayerMode::Additive } else { LayerMode::Override };
    let settings = LayerSettings { mode, weight: draw.number("weight", 0.0, 1.0) };
    let layer = draw.index("layer", 5);
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.set_layer(layer, settings, mask)),
    ))
}

fn space(draw: &mut Draw) -> Space {
    if draw.chance("is_model", 0.5) { Space::Model } else { Space::Local }
}

fn override_joints(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let count = 1 + draw.index("count_less_1", 3);
    let mut one = || JointOverride {
        joint: world.joint(draw, "joint", body),
        space: space(draw),
        transform: Trs {
            translation: draw.vector("translation", -0.5, 0.5),
            rotation: draw.rotation("rotation"),
            scale: draw.vector("scale", 0.5, 1.5),
        },
        weight: draw.number("weight", 0.0, 1.0),
    };
    let overrides: Vec<_> = (0..count).map(|_| one()).collect();
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.override_joints(&overrides)),
    ))
}

fn release_joints(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let joints = [world.joint(draw, "joint", body), world.joint(draw, "other", body)];
    Some(Outcome::of(
        world.crowd.member_mut(member).and_then(|mut m| m.release_joints(space(draw), &joints)),
    ))
}

fn release_all(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.release_all_joints())))
}

/// Draws a target for looking or reaching; often a joint of another member.
pub(crate) fn target(world: &World, draw: &mut Draw) -> Target {
    match draw.index("target", 5) {
        0 => Target::Direction(draw.vector("direction", -1.0, 1.0)),
        1 => Target::InModel(draw.vector("in_model", -1.0, 2.0)),
        2 => Target::Point(draw.vector("point", -20.0, 20.0)),
        _ => match world.member(draw, "other") {
            Some((member, body)) => Target::Joint { member, joint: world.joint(draw, "its", body) },
            None => Target::Point([1.0; 3]),
        },
    }
}

pub(crate) fn weight(draw: &mut Draw) -> Weight {
    let value = draw.number("weight", 0.0, 1.0);
    Weight::new(value).unwrap_or_default().over_secs(draw.secs("secs"))
}

fn use_stage(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, body) = world.member(draw, "member")?;
    let count = world.stages.len();
    let stage = (count > 0).then(|| world.stages[draw.index("stage", count)])?;
    let on_all = draw.chance("on_all", 0.3);
    let on =
        if on_all { StageUse::on_all() } else { StageUse::on([world.joint(draw, "joint", body)]) };
    let [x, y, z] = draw.vector("values", -0.1, 0.1);
    Some(Outcome::of(
        world
            .crowd
            .member_mut(member)
            .and_then(|mut m| m.set_stage(stage, on.with_values([x, y, z, 0.0]))),
    ))
}

fn leave_stage(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let (member, _) = world.member(draw, "member")?;
    let count = world.stages.len();
    let stage = (count > 0).then(|| world.stages[draw.index("stage", count)])?;
    Some(Outcome::of(world.crowd.member_mut(member).and_then(|mut m| m.clear_stage(stage))))
}

fn move_to(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    if !draw.chance("moves", 0.3) {
        return None;
    }
    world.device = (world.device + 1) % world.setup.devices.len();
    let devices = world.setup.devices[world.device].clone();
    Some(Outcome::of(world.crowd.move_to(devices)))
}

/// Sets uneven shares for two devices; does nothing if there is only one.
fn set_split(world: &mut World, draw: &mut Draw) -> Option<Outcome> {
    let share = f64::from(draw.number("share", 0.0, 1.0));
    if world.setup.devices[world.device].as_slice().len() < 2 {
        return None;
    }
    let _refused = world.crowd.set_split(&populace::Split::Fixed(vec![share, 1.0 - share]));
    Some(Outcome::Done)
}

/// Returns the elements of transforms.
pub(crate) fn numbers(transforms: Vec<Affine>) -> Vec<f32> {
    transforms.into_iter().flat_map(|m| m.rows).flatten().collect()
}
