//! The checks, one for each kind of controls.

use glam::{DMat3, DQuat};
use populace_clip::{FIRST_TICK, MotionSettings, MotionSource, TICKS_PER_SEC, ticks_from_secs};
use populace_device::layout::Target;
use populace_device::{After, Backend, Controls, StageUse, UserStage};
use populace_model::Skeleton;
use populace_model::convert::single;

use super::{ControlScene, plans};
use crate::Rng;
use crate::conformance::plans::member;
use crate::oracle::{OracleStage, OracleStageInputs};
use crate::scenes::{Scene, body};

/// Members with controls in a check.
const MEMBERS: usize = 24;

/// Runs a check of random controls: `make` creates those of a member of a body.
fn check_random(
    name: &'static str,
    backend: &mut dyn Backend,
    seed: u64,
    make: impl Fn(&mut Rng, &Skeleton) -> Controls,
) {
    let (scene, mut rng) = (Scene::new(), Rng::new(seed));
    let mut members = ControlScene::new(name, &scene);
    for nth in 0..MEMBERS {
        let body = plans::BODIES[nth % plans::BODIES.len()];
        let controls = make(&mut rng, &scene.bodies[body].skeleton);
        members.add(&mut rng, body, controls);
    }
    members.judge(backend);
}

/// Checks look-at over chains of one to six joints, with random shares, limits and targets of all
/// kinds, before, while and after they ease in. Chains from the root on look at targets in front, and
/// straight up or down.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_gaze(backend: &mut dyn Backend) {
    check_random("gaze", backend, 71, |rng, skeleton| Controls {
        constraints: vec![plans::gaze(rng, skeleton)],
        ..Controls::default()
    });
    check_random("gaze from the root", backend, 76, |rng, skeleton| Controls {
        constraints: vec![plans::gaze_from_root(rng, skeleton)],
        ..Controls::default()
    });
}

/// Checks two-bone limbs, with goals in and out of reach and so near that they fold, with and
/// without a pole, whose ends keep their rotation or follow.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_limbs(backend: &mut dyn Backend) {
    check_random("limbs", backend, 72, |rng, skeleton| Controls {
        constraints: vec![plans::limb(rng, skeleton)],
        ..Controls::default()
    });
    check_random("limbs that fold", backend, 77, plans::folded_limb);
}

/// Checks chains of two to seven joints that reach for goals.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_chains(backend: &mut dyn Backend) {
    check_random("chains", backend, 73, |rng, skeleton| Controls {
        constraints: vec![plans::chain(rng, skeleton)],
        ..Controls::default()
    });
}

/// Checks overrides of local and model transforms, of any weight, under constraints of all kinds
/// that share joints with them and with each other.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_overrides(backend: &mut dyn Backend) {
    check_random("overrides", backend, 74, |rng, skeleton| {
        let mut constraints = vec![plans::gaze(rng, skeleton), plans::limb(rng, skeleton)];
        rng.shuffle(&mut constraints);
        constraints.truncate(rng.below(3));
        let overrides = plans::overrides(rng, skeleton, 4);
        Controls { constraints, overrides, ..Controls::default() }
    });
}

/// Checks user stages after Pose and after Transform, with constraints and overrides on the same
/// joints.
///
/// # Panics
///
/// If the backend is wrong or does not run stages.
pub fn check_user_stages(backend: &mut dyn Backend) {
    let (scene, mut rng) = (Scene::new(), Rng::new(75));
    let mut members = ControlScene::new("user stages", &scene);
    let (stages, oracle): (Vec<_>, Vec<_>) = user_stages().into_iter().unzip();
    members.stages = oracle;
    // 6.4 s on a crowd's clock, which stages read. All ramps of targets have ended by then.
    members.first_tick = FIRST_TICK + ticks_from_secs(6.4);
    backend.set_stages(&stages).expect("the stages are valid");
    for nth in 0..MEMBERS {
        let body = plans::BODIES[nth % plans::BODIES.len()];
        let skeleton = &scene.bodies[body].skeleton;
        let stages = [(0, After::Pose), (1, After::Transform)].map(|(stage, after)| StageUse {
            stage,
            after,
            joints: plans::joints(&mut rng, skeleton, 5),
            values: rng.turn(0.7).to_array().map(single),
        });
        let controls = Controls {
            constraints: vec![plans::gaze(&mut rng, skeleton)],
            overrides: plans::overrides(&mut rng, skeleton, 2),
            stages: stages.to_vec(),
            ..Controls::default()
        };
        members.add(&mut rng, body, controls);
    }
    members.judge(backend);
    backend.set_stages(&[]).expect("no stage is valid");
}

/// A stage that moves local transforms by the clock, turns and stretches them, and one that lifts
/// joints and turns them about themselves. Each leaves a number that is out of bounds on some
/// joints, whose transforms then stay as they were.
fn user_stages() -> [(Option<UserStage>, OracleStage); 2] {
    let shift = UserStage::new("kit_shift")
        .opencl_c(
            "void kit_shift(StageJoint *joint)
            {
                const float secs = (float)(joint->ticks % 705600ul) / 705600.0f;
                joint->translation.x += joint->values.x * (1.0f + secs);
                joint->rotation = joint->rotation + 0.25f * joint->values;
                joint->scale.z *= 1.0f + 0.1f * joint->values.y;
                if (joint->joint % 4 == 1) joint->translation.y = 1e30f;
            }",
        )
        .rust(|joint| {
            let secs = (joint.ticks % TICKS_PER_SEC) as f32 / TICKS_PER_SEC as f32;
            joint.local.translation[0] += joint.values[0] * (1.0 + secs);
            for (r, v) in joint.local.rotation.iter_mut().zip(joint.values) {
                *r += 0.25 * v;
            }
            joint.local.scale[2] *= 1.0 + 0.1 * joint.values[1];
            if joint.joint.0 % 4 == 1 {
                joint.local.translation[1] = 1e30;
            }
        });
    let lift = UserStage::new("kit_lift")
        .opencl_c(
            "void kit_lift(StageJoint *joint)
            {
                joint->row1.w += joint->values.y;
                stage_rotate(joint, joint->values);
                if (joint->joint % 4 == 2) joint->row2.x = NAN;
            }",
        )
        .rust(|joint| {
            joint.model.rows[1][3] += joint.values[1];
            joint.rotate(joint.values);
            if joint.joint.0 % 4 == 2 {
                joint.model.rows[2][0] = f32::NAN;
            }
        });
    let in_oracle = [
        OracleStage::Pose(|local, OracleStageInputs { values, joint, ticks }| {
            if joint.0 % 4 == 1 {
                return;
            }
            let secs = (ticks % TICKS_PER_SEC) as f64 / TICKS_PER_SEC as f64;
            local.translation.x += values[0] * (1.0 + secs);
            local.rotation += DQuat::from_array(*values) * 0.25;
            local.scale.z *= 1.0 + 0.1 * values[1];
        }),
        OracleStage::Transform(|model, OracleStageInputs { values, joint, .. }| {
            if joint.0 % 4 == 2 {
                return;
            }
            model.translation.y += values[1];
            model.matrix3 = DMat3::from_quat(DQuat::from_array(*values)) * model.matrix3;
        }),
    ];
    [(Some(shift), in_oracle[0]), (Some(lift), in_oracle[1])]
}

/// Checks members attached to joints of others, three deep, that constraints and overrides move,
/// and looks at joints of other members as of the frame before. Some members have no palette.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_attachments(backend: &mut dyn Backend) {
    let (scene, mut rng) = (Scene::new(), Rng::new(76));
    let mut members = ControlScene::new("attachments", &scene);
    let bodies = [&plans::BODIES[..], &[body::BARE]].concat();
    for nth in 0..MEMBERS {
        let body = bodies[nth % bodies.len()];
        let skeleton = &scene.bodies[body].skeleton;
        let watched = members.crowd.tables.add_watched();
        let [end] = plans::joints(&mut rng, skeleton, 1)[..] else { unreachable!("one joint") };
        let mut controls = Controls {
            constraints: vec![plans::limb(&mut rng, skeleton)],
            overrides: plans::overrides(&mut rng, skeleton, 1),
            watches: vec![(end, watched)],
            ..Controls::default()
        };
        if let Some(before) = nth.checked_sub(1) {
            let (_, seen) = members.all[before].controls.watches[0];
            let offset = rng.vector(-0.2, 0.2).to_array().map(single);
            let target = Target::watched(seen, offset).with_ramp(0, 0.0, 0.8, 1.0);
            controls.constraints.push(plans::gaze_at(&mut rng, skeleton, vec![target]));
        }
        let at = members.add(&mut rng, body, controls);
        if !at.is_multiple_of(4) {
            attach(&mut rng, &mut members, at);
        }
    }
    members.judge(backend);
}

/// Checks root motion: cycles forwards and backwards, of which some end within a frame, clips that
/// begin or change their weight within a frame, layers with masks, and clips without motion beside
/// others.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_root_motion(backend: &mut dyn Backend) {
    let (scene, mut rng) = (moving(Scene::new(), 1, 6), Rng::new(77));
    let mut members = ControlScene::new("root motion", &scene);
    let all: Vec<usize> = (0..scene.clips.len()).collect();
    let moves = |clip: &usize| scene.clips[*clip].clip.root_motion().is_some();
    let moving: Vec<usize> = all.iter().copied().filter(moves).collect();
    for nth in 0..MEMBERS {
        let body = plans::BODIES[nth % plans::BODIES.len()];
        let clips = if nth % 3 == 0 { &all } else { &moving };
        let mut plan = member(&mut rng, &scene, body, clips, 3);
        plans::change_within_frames(&mut rng, &mut plan);
        if nth % 2 == 0 {
            plans::hurry(&mut plan);
        }
        members.add_plan(&mut rng, plan, moved_by_clips(nth));
    }
    members.judge(backend);
}

/// Checks root motion while clips replace each other by inertialization, some before the last
/// transition has ended, and on layers.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_motion_transitions(backend: &mut dyn Backend) {
    let scene = moving(Scene::new(), 0, 6);
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    judge_transitions(backend, "root motion in transitions", &scene, |_| clips.clone());
}

/// Checks root motion by clips of other bodies, which is scaled to the member's legs, alone and in
/// transitions between clips of different bodies.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_motion_of_others(backend: &mut dyn Backend) {
    let scene = moving(Scene::of_humanoids(), 0, 4);
    judge_transitions(backend, "root motion of other bodies", &scene, |body| {
        (0..scene.clips.len()).filter(|clip| scene.clips[*clip].body != body).collect()
    });
}

/// Takes the motion of roots out of all clips from the `first` on, of which at least `least` must
/// have some.
fn moving(mut scene: Scene, first: usize, least: usize) -> Scene {
    let from_root = MotionSettings { from: MotionSource::Root, turns: true, rises: true };
    for clip in scene.clips.iter_mut().skip(first) {
        clip.clip = clip.clip.with_root_motion(&from_root).unwrap_or_else(|_| clip.clip.clone());
    }
    let count = scene.clips.iter().filter(|clip| clip.clip.root_motion().is_some()).count();
    assert!(count >= least, "only {count} clips move the body");
    scene
}

fn moved_by_clips(nth: usize) -> Controls {
    let epoch = u32::try_from(nth).expect("few members") + 1;
    Controls { motion: Some(epoch), ..Controls::default() }
}

/// Judges members that go over to another clip of `clips` of their body in some frames, each at a
/// tick within the frame.
fn judge_transitions(
    backend: &mut dyn Backend,
    name: &'static str,
    scene: &Scene,
    clips: impl Fn(usize) -> Vec<usize>,
) {
    // A clip on each of two layers, and three transitions.
    const SLOTS: usize = 8;
    let mut rng = Rng::new(78);
    let mut members = ControlScene::with_slots(name, scene, SLOTS);
    for nth in 0..MEMBERS {
        let body = nth % scene.bodies.len();
        let layers = if nth % 3 == 0 { 2 } else { 1 };
        let plan = plans::travelling(&mut rng, scene, body, &clips(body), layers);
        members.add_plan(&mut rng, plan, moved_by_clips(nth));
    }
    // The first frame gives the velocities that the first transitions keep.
    members.judge_frames(backend, 7, |members, span| {
        for at in 0..members.all.len() {
            let [member, twin] = [members.all[at].member, members.all[at].twin];
            let mut plan = members.crowd.plan(member).clone();
            let taken = plan.plays.len() + plan.inertialization.len();
            if taken + 2 <= SLOTS && rng.chance(0.4) {
                let clips = clips(plan.body);
                plans::inertialize(&mut rng, &mut plan, &clips, span);
                members.crowd.set_plan(member, plan.clone());
                members.crowd.set_plan(twin, plan);
            }
        }
    });
}

/// Attaches a member to a joint of the one before it in the list.
fn attach(rng: &mut Rng, members: &mut ControlScene<'_>, at: usize) {
    let carried = members.crowd.tables.add_watched();
    let parent = &mut members.all[at - 1];
    let skeleton = &members.crowd.scene.bodies[members.crowd.plan(parent.member).body].skeleton;
    let [joint] = plans::joints(rng, skeleton, 1)[..] else { unreachable!("one joint") };
    parent.controls.carries = vec![(joint, carried)];
    members.all[at].parent = Some((at - 1, skeleton.source_from_joint(joint)));
    members.all[at].place = members.all[at - 1].place;
    members.all[at].controls.attached = Some((carried, plans::transform(rng)));
    let index = members.crowd.index(members.all[at].member);
    let phase = u32::try_from(at % 4).expect("few phases");
    members.crowd.tables.set_phase(index, phase).expect("the member exists");
    members.set(at - 1);
    members.set(at);
}
