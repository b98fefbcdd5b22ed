//! One scene for each group of features.

use populace::model::Role;
use populace::{
    After, BlendSpace, BlendSpacePlayback, ClipPlayback, Condition, Crowd, Error, Ground,
    JointOverride, LayerMode, LayerSettings, LiveSettings, MachinePlayback, Mask, MemberId,
    Placement, Reach, Space, StageJoint, StageUse, StateMachine, StatePlayback, Target, Trs,
    UserStage, Weight,
};

use crate::cast::Cast;

type Step = Box<dyn FnMut(&mut Crowd, usize) -> Result<(), Error>>;

/// A scene under way.
pub(crate) struct Run {
    pub(crate) members: Vec<MemberId>,
    /// Called before each frame.
    pub(crate) step: Step,
}

impl Run {
    fn still(members: Vec<MemberId>) -> Self {
        Self { members, step: Box::new(|_, _| Ok(())) }
    }
}

/// A scene, and the hash of all its palettes.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) start: fn(&mut Crowd, &Cast) -> Result<Run, Error>,
    pub(crate) hash: u64,
}

pub(crate) const ALL: [Scene; 12] = [
    Scene { name: "clips", start: clips, hash: 0x93e6_dc6f_7b48_0931 },
    Scene { name: "layers", start: layers, hash: 0x68ed_67f2_0cef_7b9c },
    Scene { name: "inertialization", start: inertialization, hash: 0xeca9_b0aa_3719_8dd6 },
    Scene { name: "retargeting", start: retargeting, hash: 0x0633_628f_c695_efcc },
    Scene { name: "blend spaces", start: blend_spaces, hash: 0xa6d3_5b41_1040_04b2 },
    Scene { name: "state machines", start: state_machines, hash: 0xbb07_b1de_4dca_7789 },
    Scene { name: "live clips", start: live_clips, hash: 0x35e7_c15f_6338_b980 },
    Scene { name: "gaze and reach", start: gaze_and_reach, hash: 0x9b93_f4f5_f83c_0cf9 },
    Scene { name: "feet", start: feet, hash: 0xb7a7_d673_b5c5_0014 },
    Scene { name: "overrides and proportions", start: overrides, hash: 0xdc81_67b5_5b47_e824 },
    Scene { name: "attachments and root motion", start: attachments, hash: 0x85f2_c0b5_1b22_a78b },
    Scene { name: "user stages", start: user_stages, hash: 0xd463_6b0f_d6dd_e337 },
];

fn clips(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 6)?;
    crowd.member_mut(men[0])?.play(cast.walk, ClipPlayback::looping().phase(0.3).speed(1.2))?;
    crowd.member_mut(men[1])?.play(cast.run, ClipPlayback::once().speed(2.0))?;
    crowd.member_mut(men[1])?.queue(cast.idle, ClipPlayback::looping().fade_in_secs(0.2))?;
    crowd.member_mut(men[2])?.play(cast.walk, ClipPlayback::held_at_secs(0.4))?;
    crowd.member_mut(men[3])?.play(cast.walk, ClipPlayback::looping())?;
    crowd
        .member_mut(men[3])?
        .blend(cast.idle, ClipPlayback::looping().weight(0.4).fade_in_secs(0.3))?;
    crowd.member_mut(men[4])?.play(cast.idle, ClipPlayback::looping().after_secs(0.2))?;
    let fading = crowd.member_mut(men[5])?.play(cast.walk, ClipPlayback::looping().speed(-0.7))?;
    let (four, walk, members) = (men[4], cast.walk, men.clone());
    let step = move |crowd: &mut Crowd, frame| match frame {
        6 => crowd.member_mut(four).and_then(|mut m| m.crossfade(walk, 0.4)).map(drop),
        9 => crowd
            .member_mut(fading.member())
            .and_then(|mut m| m.set_weight(fading, 0.5, 0.2))
            .and_then(|()| {
                crowd.member_mut(fading.member()).and_then(|mut m| m.set_speed(fading, 1.5))
            }),
        15 => crowd.member_mut(four).and_then(|mut m| m.stop(0, 0.25)),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}

fn layers(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 3)?;
    let skeleton = crowd.character(cast.man)?.asset().skeleton.clone();
    let upper = Mask::subtree(&skeleton, cast.joint(Role::Spine));
    let mask = crowd.character_mut(cast.man)?.add_mask(&upper)?;
    for (nth, man) in men.iter().enumerate() {
        crowd.member_mut(*man)?.play(cast.walk, ClipPlayback::looping().phase(0.2 * nth as f32))?;
        crowd
            .member_mut(*man)?
            .play(cast.run, ClipPlayback::looping().on_layer(1).fade_in_secs(0.1))?;
        crowd.member_mut(*man)?.play(cast.idle, ClipPlayback::looping().on_layer(2))?;
    }
    let over = LayerSettings { mode: LayerMode::Override, weight: 0.8 };
    let adds = LayerSettings { mode: LayerMode::Additive, weight: 0.6 };
    crowd.member_mut(men[0])?.set_layer(1, over, Some(mask))?;
    crowd.member_mut(men[1])?.set_layer(1, adds, Some(mask))?;
    crowd.member_mut(men[2])?.set_layer(1, over, None)?;
    crowd.member_mut(men[2])?.set_layer(2, adds, None)?;
    Ok(Run::still(men))
}

fn inertialization(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 3)?;
    for man in &men {
        crowd.member_mut(*man)?.play(cast.walk, ClipPlayback::looping())?;
    }
    let (members, [idle, walk, run]) = (men.clone(), [cast.idle, cast.walk, cast.run]);
    let step = move |crowd: &mut Crowd, frame| {
        let eases = |secs| ClipPlayback::looping().inertialize_in_secs(secs);
        match frame {
            3 => crowd.member_mut(men[0]).and_then(|mut m| m.play(idle, eases(0.3))).map(drop),
            5 => crowd.member_mut(men[1]).and_then(|mut m| m.play(run, eases(0.4))).map(drop),
            8 => crowd.member_mut(men[1]).and_then(|mut m| m.play(walk, eases(0.4))).map(drop),
            10 => crowd
                .member_mut(men[2])
                .and_then(|mut m| m.play(run, eases(0.2).after_secs(0.1)))
                .map(drop),
            _ => Ok(()),
        }
    };
    Ok(Run { members, step: Box::new(step) })
}

fn retargeting(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let child = crowd.spawn(cast.child, Placement::at([0.0; 3]).scaled(1.1))?;
    let other = crowd.spawn(cast.child, Placement::at([1.0, 0.0, 0.0]))?;
    crowd.member_mut(child)?.play(cast.walk, ClipPlayback::looping())?;
    crowd.member_mut(other)?.play(cast.run, ClipPlayback::looping().fade_in_secs(0.2))?;
    crowd.member_mut(other)?.blend(cast.idle, ClipPlayback::looping().weight(0.5))?;
    Ok(Run::still(vec![child, other]))
}

fn blend_spaces(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 2)?;
    let (idle, walk, run) = (cast.idle, cast.walk, cast.run);
    let line = crowd.add_blend_space(BlendSpace::line(&[(idle, 0.0), (walk, 1.4), (run, 3.5)])?)?;
    let corners = [(idle, [0.0, 0.0]), (walk, [1.0, 0.0]), (run, [0.0, 1.0])];
    let plane = crowd.add_blend_space(BlendSpace::plane(&corners)?)?;
    crowd.member_mut(men[0])?.play_blend_space(line, 0.5, BlendSpacePlayback::new())?;
    crowd.member_mut(men[1])?.play_blend_space(plane, [0.2, 0.3], BlendSpacePlayback::new())?;
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame| match frame {
        4 => crowd.member_mut(men[0]).and_then(|mut m| m.set_blend_parameter(2.5, 0.3)),
        8 => crowd.member_mut(men[1]).and_then(|mut m| m.set_blend_parameter([0.6, 0.1], 0.2)),
        14 => crowd.member_mut(men[0]).and_then(|mut m| m.set_blend_parameter(1.0, 0.0)),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}

fn state_machines(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 2)?;
    let machine = StateMachine::new()
        .parameter("speed", 0.0)
        .state("idle", cast.idle, StatePlayback::looping())
        .state("walk", cast.walk, StatePlayback::looping().speed(1.1))
        .state("run", cast.run, StatePlayback::looping())
        .transition("idle", "walk", 0.2, &[Condition::above("speed", 0.5)])
        .transition("walk", "run", 0.3, &[Condition::above("speed", 2.0)])
        .transition("run", "idle", 0.2, &[Condition::AfterSecs(0.2)]);
    let machine = crowd.add_machine(&machine)?;
    crowd.member_mut(men[0])?.play_machine(machine, MachinePlayback::new())?;
    crowd.member_mut(men[1])?.play(cast.walk, ClipPlayback::looping())?;
    crowd
        .member_mut(men[1])?
        .play_machine(machine, MachinePlayback::new().fade_in_secs(0.2).on_layer(1))?;
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame| match frame {
        3 => crowd.member_mut(men[0]).and_then(|mut m| m.set_parameter("speed", 1.0)),
        7 => crowd.member_mut(men[1]).and_then(|mut m| m.set_parameter("speed", 3.0)),
        9 => crowd.member_mut(men[0]).and_then(|mut m| m.set_parameter("speed", 2.5)),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}

fn live_clips(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 2)?;
    let rest: Vec<Trs> = {
        let skeleton = &crowd.character(cast.man)?.asset().skeleton;
        skeleton.joints().map(|joint| *skeleton.rest(joint)).collect()
    };
    let live = crowd.character_mut(cast.man)?.add_live_clip("live", &LiveSettings::default())?;
    crowd.member_mut(men[0])?.play(live, ClipPlayback::live(0.1))?;
    crowd.member_mut(men[1])?.play(cast.walk, ClipPlayback::looping())?;
    crowd.member_mut(men[1])?.blend(live, ClipPlayback::live(0.05).weight(0.5))?;
    let hips = cast.joint(Role::Hips).index();
    let step = move |crowd: &mut Crowd, frame: usize| {
        let mut pose = rest.clone();
        pose[hips].translation[1] -= 0.01 * (frame % 7) as f32;
        pose[hips].rotation = [0.0, 0.28, 0.0, 0.96];
        crowd.clip_mut(live)?.append(0.033 * frame as f64, &pose).map(drop)
    };
    Ok(Run { members: men, step: Box::new(step) })
}

fn gaze_and_reach(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 4)?;
    for man in &men {
        crowd.member_mut(*man)?.play(cast.walk, ClipPlayback::looping())?;
    }
    let head = cast.joint(Role::Head);
    crowd.member_mut(men[0])?.look_at([3.0, 1.2, 4.0], Weight::FULL)?;
    crowd
        .member_mut(men[1])?
        .look_at(Target::Joint { member: men[2], joint: head }, Weight::FULL)?;
    crowd.member_mut(men[2])?.reach(
        Reach::with(cast.hand()),
        [2.0, 1.3, 0.5],
        Weight::new(0.7)?,
    )?;
    let (spine, hand) = (cast.joint(Role::Spine), cast.hand());
    let near = Target::InModel([0.4, 1.5, 0.4]);
    crowd.member_mut(men[3])?.reach_with_chain(spine, hand, near, Weight::FULL.over_secs(0.2))?;
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame| match frame {
        6 => crowd.member_mut(men[0]).and_then(|mut m| m.look_at([-3.0, 1.8, 4.0], Weight::FULL)),
        9 => crowd.member_mut(men[2]).and_then(|mut m| m.clear_reach(hand, 0.2)),
        12 => crowd.member_mut(men[1]).and_then(|mut m| m.clear_look_at(0.3)),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}

fn feet(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 3)?;
    let heights = vec![0.0, 0.1, 0.05, 0.12, 0.0, 0.08, 0.02, 0.1, 0.15];
    crowd.set_ground(&Ground::height_field([-4.0; 2], 4.0, 3, heights)?)?;
    for (nth, man) in men.iter().enumerate() {
        crowd.member_mut(*man)?.play(cast.walk, ClipPlayback::looping().phase(0.3 * nth as f32))?;
        crowd.member_mut(*man)?.plant_feet(1.0 - 0.3 * nth as f32)?;
    }
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame: usize| {
        if frame == 18 {
            crowd.set_ground(&Ground::plane(0.05, [0.1, 0.02])?)?;
        }
        crowd
            .member_mut(men[0])
            .and_then(|mut m| m.set_placement(Placement::at([0.0, 0.0, 0.04 * frame as f32])))
    };
    Ok(Run { members, step: Box::new(step) })
}

fn overrides(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 3)?;
    for man in &men {
        crowd.member_mut(*man)?.play(cast.run, ClipPlayback::looping())?;
    }
    let hand = cast.hand();
    let set = |space, weight| JointOverride {
        joint: hand,
        space,
        transform: Trs { translation: [0.2, 1.1, 0.3], ..Trs::IDENTITY },
        weight,
    };
    crowd.member_mut(men[0])?.override_joints(&[set(Space::Model, 0.8)])?;
    crowd.member_mut(men[1])?.override_joints(&[set(Space::Local, 1.0)])?;
    let factors: Vec<f32> = (0..cast.joints).map(|n| 0.9 + 0.02 * (n % 9) as f32).collect();
    crowd.member_mut(men[2])?.set_proportions(&factors)?;
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame| match frame {
        12 => crowd.member_mut(men[0]).and_then(|mut m| m.release_joints(Space::Model, &[hand])),
        16 => crowd.member_mut(men[1]).and_then(|mut m| m.release_all_joints()),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}

fn attachments(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let men = cast.men(crowd, 3)?;
    crowd.member_mut(men[0])?.play(cast.walk_on, ClipPlayback::looping())?;
    crowd.member_mut(men[0])?.start_root_motion()?;
    crowd.member_mut(men[1])?.play(cast.idle, ClipPlayback::looping())?;
    let offset = Trs { translation: [0.1, 0.0, 0.05], ..Trs::IDENTITY };
    crowd.member_mut(men[1])?.attach_to(men[0], cast.hand(), offset)?;
    crowd.member_mut(men[2])?.play(cast.walk_on, ClipPlayback::looping().speed(1.5))?;
    crowd.member_mut(men[2])?.start_root_motion()?;
    let members = men.clone();
    let (run, spare) = (cast.run, cast.child);
    let mut extra = None;
    let step = move |crowd: &mut Crowd, frame| {
        match frame {
            5 => extra = Some(crowd.spawn(spare, Placement::at([4.0, 0.0, 1.0]))?),
            8 => drop(
                crowd
                    .member_mut(men[2])?
                    .play(run, ClipPlayback::looping().inertialize_in_secs(0.3))?,
            ),
            12 => crowd.member_mut(men[1])?.detach()?,
            15 => drop(crowd.member_mut(men[0])?.commit_root_motion()?),
            18 => crowd.despawn(extra.expect("spawned at frame 5"))?,
            _ => {}
        }
        Ok(())
    };
    Ok(Run { members, step: Box::new(step) })
}

fn lift(joint: &mut StageJoint) {
    joint.model.rows[1][3] += joint.parameters[0] + joint.values[1];
}

fn stretch(joint: &mut StageJoint) {
    joint.local.translation[1] += joint.parameters[1] * joint.values[0];
}

fn user_stages(crowd: &mut Crowd, cast: &Cast) -> Result<Run, Error> {
    let lifts =
        "void lift(StageJoint *joint) { joint->row1.w += joint->parameters[0] + joint->values.y; }";
    let stretches = "void stretch(StageJoint *joint) { joint->translation.y += \
                     joint->parameters[1] * joint->values.x; }";
    let men = cast.men(crowd, 2)?;
    let lifts = UserStage::new("lift").opencl_c(lifts).rust(lift);
    let stretches = UserStage::new("stretch").opencl_c(stretches).rust(stretch);
    let lifts = crowd.add_stage(After::Transform, lifts)?;
    let stretches = crowd.add_stage(After::Pose, stretches)?;
    let head = cast.joint(Role::Head);
    crowd
        .member_mut(men[0])?
        .set_stage(lifts, StageUse::on_all().with_values([0.0, 0.1, 0.0, 0.0]))?;
    crowd
        .member_mut(men[1])?
        .set_stage(stretches, StageUse::on([head]).with_values([0.5, 0.0, 0.0, 0.0]))?;
    for man in &men {
        crowd.member_mut(*man)?.play(cast.walk, ClipPlayback::looping())?;
    }
    let members = men.clone();
    let step = move |crowd: &mut Crowd, frame| match frame {
        4 => crowd.set_stage_parameters(lifts, &[0.05, 0.0]),
        6 => crowd.set_stage_parameters(stretches, &[0.0, 0.3]),
        14 => crowd.member_mut(men[0]).and_then(|mut m| m.clear_stage(lifts)),
        _ => Ok(()),
    };
    Ok(Run { members, step: Box::new(step) })
}
