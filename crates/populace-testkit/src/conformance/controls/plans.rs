//! Random controls.

use glam::DVec3;
use populace_clip::ticks_from_secs;
use populace_device::layout::Target;
use populace_device::{
    Chain, Constraint, Controls, Gaze, GazeLimits, JointOverride, LayerMode, Limb, Place, Space,
};
use populace_model::convert::single;
use populace_model::{JointIndex, Skeleton, Trs};

use crate::conformance::plans::mask;
use crate::oracle::{Timing, Weighting};
use crate::scenes::{Scene, body};
use crate::{Inertialization, LayerPlan, MemberPlan, Play, Rng};

/// Bodies with chains that are long enough.
pub(super) const BODIES: [usize; 4] = [body::SMALL, body::TWO_ROOTS, body::SCALED, body::LARGE];

/// Places a member anywhere near the origin, of 0.7 to 1.4 times its size.
pub(super) fn place(rng: &mut Rng) -> Place {
    let (sin, cos) = rng.between(-3.1, 3.1).sin_cos();
    Place {
        position: rng.vector(-3.0, 3.0).to_array().map(single),
        sin_cos: [sin, cos].map(single),
        scale: single(rng.between(0.7, 1.4)),
    }
}

/// Returns a random run of `least` to `most` joints, each the parent of the next.
fn run(rng: &mut Rng, skeleton: &Skeleton, least: usize, most: usize) -> Vec<JointIndex> {
    loop {
        let end = JointIndex(u32::try_from(rng.below(skeleton.joint_count())).expect("few joints"));
        let wanted = least + rng.below(most - least + 1);
        let up = std::iter::successors(Some(end), |joint| skeleton.parent(*joint));
        let mut run: Vec<_> = up.take(wanted).collect();
        if run.len() == wanted {
            run.reverse();
            return run;
        }
    }
}

/// Returns the joints from a root down to a joint.
fn from_root(skeleton: &Skeleton, end: JointIndex) -> Vec<JointIndex> {
    let mut joints = vec![end];
    joints.extend(skeleton.ancestors(end));
    joints.reverse();
    joints
}

/// Returns one to three targets of all kinds but joints. Together they may weigh more than 1.
fn targets(rng: &mut Rng) -> Vec<Target> {
    (0..1 + rng.below(3)).map(|_| target(rng)).collect()
}

fn target(rng: &mut Rng) -> Target {
    let point = rng.vector(-1.5, 1.5).to_array().map(single);
    let target = match rng.below(3) {
        0 => Target::in_model(point),
        1 => Target::in_world(point),
        _ => Target::direction(point),
    };
    eased(rng, target)
}

/// A target whose weight changes before, while or after the frames of a check.
fn eased(rng: &mut Rng, target: Target) -> Target {
    let (from, to) = (single(rng.between(0.0, 1.0)), single(rng.between(0.2, 1.0)));
    let to = if rng.chance(0.4) { 1.0 } else { to };
    let began = ticks_from_secs(rng.between(5.0, 6.2));
    target.with_ramp(began, from, to, single(rng.between(0.0, 0.8)))
}

/// A gaze at random targets.
pub(super) fn gaze(rng: &mut Rng, skeleton: &Skeleton) -> Constraint {
    let targets = targets(rng);
    gaze_at(rng, skeleton, targets)
}

/// A gaze of one to six joints, some of which take no part.
pub(super) fn gaze_at(rng: &mut Rng, skeleton: &Skeleton, targets: Vec<Target>) -> Constraint {
    let joints = run(rng, skeleton, 1, 6);
    Constraint::Gaze(gaze_of(rng, joints, targets))
}

/// A gaze from a root on, whose carrier is model space itself. It faces forwards, at one target in
/// front and within the limits, or at steep directions, up or down.
pub(super) fn gaze_from_root(rng: &mut Rng, skeleton: &Skeleton) -> Constraint {
    let end = run(rng, skeleton, 1, 1)[0];
    let mut joints = from_root(skeleton, end);
    joints.truncate(1 + rng.below(6));
    let targets = if rng.chance(0.5) {
        let [x, y, z] = [rng.between(-2.0, 2.0), rng.between(-0.8, 0.8), rng.between(8.0, 12.0)];
        vec![eased(rng, Target::in_model([x, y, z].map(single)))]
    } else {
        let steep = |rng: &mut Rng| {
            let up = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let direction = [rng.between(-0.1, 0.1), up, rng.between(-0.1, 0.1)];
            eased(rng, Target::direction(direction.map(single)))
        };
        (0..1 + rng.below(2)).map(|_| steep(rng)).collect()
    };
    let facing = (DVec3::Z + rng.vector(-0.5, 0.5)).normalize().to_array().map(single);
    Constraint::Gaze(Gaze { facing, ..gaze_of(rng, joints, targets) })
}

/// A gaze of a run of joints with random shares, limits and facing.
fn gaze_of(rng: &mut Rng, joints: Vec<JointIndex>, targets: Vec<Target>) -> Gaze {
    let share = |rng: &mut Rng| if rng.chance(0.2) { 0.0 } else { rng.between(0.1, 1.0) };
    let mut chain: Vec<_> = joints.into_iter().map(|joint| (joint, single(share(rng)))).collect();
    chain.last_mut().expect("at least one joint").1 = 0.4;
    Gaze {
        chain,
        facing: rng.direction().to_array().map(single),
        limits: GazeLimits {
            yaw_rad: single(rng.between(0.3, 2.2)),
            up_rad: single(rng.between(0.1, 1.3)),
            down_rad: single(rng.between(0.1, 1.3)),
        },
        targets,
    }
}

/// A limb whose bones have one to three joints each.
pub(super) fn limb(rng: &mut Rng, skeleton: &Skeleton) -> Constraint {
    let joints = run(rng, skeleton, 3, 5);
    Constraint::Limb(limb_of(rng, &joints))
}

fn limb_of(rng: &mut Rng, joints: &[JointIndex]) -> Limb {
    Limb {
        first: joints[0],
        middle: joints[1 + rng.below(joints.len() - 2)],
        end: joints[joints.len() - 1],
        bend: rng.direction().to_array().map(single),
        pole: rng.chance(0.5).then(|| rng.direction().to_array().map(single)),
        keeps_end: rng.chance(0.5),
        soft: single(rng.between(0.02, 0.3)),
        targets: targets(rng),
    }
}

/// A limb from a root on, whose goal is so near that it folds: in the part of its reach in which it
/// eases, down to the difference of its bones. Overrides give its joints their places.
pub(super) fn folded_limb(rng: &mut Rng, skeleton: &Skeleton) -> Controls {
    let end = run(rng, skeleton, 3, 3)[2];
    let mut joints = from_root(skeleton, end);
    joints.truncate(3);
    let mut places = Vec::new();
    let overrides = joints.iter().map(|joint| {
        let away = rng.direction() * rng.between(0.2, 0.6);
        places.push(away);
        let translation = away.to_array().map(single);
        let transform = Trs { translation, scale: [1.0; 3], ..transform(rng) };
        JointOverride { joint: *joint, space: Space::Local, transform, weight: 1.0 }
    });
    let overrides = overrides.collect();
    let (a, b) = (places[1].length(), places[2].length());
    let (least, soft) = ((a - b).abs(), rng.between(0.1, 0.3));
    let distance = least + rng.between(0.05, 0.95) * soft * (a + b - least);
    let goal = (places[0] + rng.direction() * distance).to_array().map(single);
    let targets = vec![eased(rng, Target::in_model(goal))];
    let limb = Limb { soft: single(soft), pole: None, targets, ..limb_of(rng, &joints) };
    Controls { constraints: vec![Constraint::Limb(limb)], overrides, ..Controls::default() }
}

/// A chain of two to seven joints.
pub(super) fn chain(rng: &mut Rng, skeleton: &Skeleton) -> Constraint {
    let joints = run(rng, skeleton, 2, 7);
    Constraint::Chain(Chain {
        first: joints[0],
        end: joints[joints.len() - 1],
        soft: single(rng.between(0.02, 0.3)),
        targets: targets(rng),
    })
}

/// Returns `count` different joints.
pub(super) fn joints(rng: &mut Rng, skeleton: &Skeleton, count: usize) -> Vec<JointIndex> {
    let mut all: Vec<_> = skeleton.joints().collect();
    rng.shuffle(&mut all);
    all.truncate(count);
    all
}

/// Lets some clips of a member start, and some weights change, within the frames of a check.
pub(super) fn change_within_frames(rng: &mut Rng, plan: &mut MemberPlan) {
    for play in &mut plan.plays {
        if let (Timing::Loop { start_tick, .. } | Timing::Once { start_tick, .. }, true) =
            (&mut play.timing, rng.chance(0.4))
        {
            *start_tick = ticks_from_secs(rng.between(5.96, 6.06));
        }
        if rng.chance(0.4) {
            play.weighting = Weighting::Ramp {
                tick: ticks_from_secs(rng.between(5.95, 6.05)),
                from: single(rng.between(0.1, 1.0)),
                to: single(rng.between(0.1, 1.0)),
                secs: single(rng.between(0.005, 0.2)),
            };
        }
    }
}

/// Plays loops 40 times as fast, so that most pass the end of their clips within a frame.
pub(super) fn hurry(plan: &mut MemberPlan) {
    for play in &mut plan.plays {
        if let Timing::Loop { speed, .. } = &mut play.timing {
            *speed *= 40.0;
        }
    }
}

/// A member with one clip in each of `layers` layers, which replace each other.
pub(super) fn travelling(
    rng: &mut Rng,
    scene: &Scene,
    body: usize,
    clips: &[usize],
    layers: u32,
) -> MemberPlan {
    let plays = (0..layers).map(|layer| looping(rng, clips, 0, layer)).collect();
    let mut plan = MemberPlan::plain(body, plays);
    for _ in 1..layers {
        let mask = Some(mask(rng, scene.bodies[body].joints.len()));
        let weight = single(rng.between(0.2, 1.0));
        plan.layers.push(LayerPlan { mode: LayerMode::Override, weight, mask });
    }
    plan
}

/// Loops a random clip from a tick on.
fn looping(rng: &mut Rng, clips: &[usize], start_tick: u64, layer: u32) -> Play {
    let (phase, speed) = (rng.between(0.0, 1.0), single(rng.between(-1.5, 2.0)));
    let timing = Timing::Loop { start_tick, phase, speed };
    let clip = clips[rng.below(clips.len())];
    Play { clip, timing, weighting: Weighting::Constant(1.0), layer }
}

/// Cuts the newest clip of a random layer at a tick after `from` and up to `until`, and starts
/// another with a transition by inertialization.
pub(super) fn inertialize(
    rng: &mut Rng,
    plan: &mut MemberPlan,
    clips: &[usize],
    [from, until]: [u64; 2],
) {
    let length = usize::try_from(until - from).expect("a short frame");
    let tick = until - rng.below(length) as u64;
    let layer = u32::try_from(rng.below(plan.layers.len())).expect("few layers");
    let of_layer = plan.plays.iter_mut().rev().find(|play| play.layer == layer);
    let outgoing = of_layer.expect("each layer plays a clip");
    let held = *outgoing;
    outgoing.weighting = Weighting::Ramp { tick, from: 1.0, to: 0.0, secs: 0.0 };
    let incoming = looping(rng, clips, tick, layer);
    plan.plays.push(incoming);
    plan.inertialization.push(Inertialization {
        outgoing: held,
        incoming,
        tick,
        ticks: ticks_from_secs(rng.between(0.05, 0.2)),
        share: 1.0,
        share_per_sec: 0.0,
    });
}

/// A transform that a host might give.
pub(in crate::conformance) fn transform(rng: &mut Rng) -> Trs {
    Trs {
        translation: rng.vector(-0.5, 0.5).to_array().map(single),
        rotation: rng.rotation().to_array().map(single),
        scale: rng.vector(0.7, 1.3).to_array().map(single),
    }
}

/// Overrides of up to `most` joints, in either space.
pub(super) fn overrides(rng: &mut Rng, skeleton: &Skeleton, most: usize) -> Vec<JointOverride> {
    let count = 1 + rng.below(most);
    let joints = joints(rng, skeleton, count);
    let given = |(nth, joint)| {
        let mut given = JointOverride {
            joint,
            space: if rng.chance(0.5) { Space::Local } else { Space::Model },
            transform: transform(rng),
            weight: if rng.chance(0.3) { 1.0 } else { single(rng.between(0.0, 1.0)) },
        };
        // The same rotation, in the other hemisphere.
        if nth % 2 == 1 {
            given.transform.rotation = given.transform.rotation.map(|part| -part);
        }
        given
    };
    joints.into_iter().enumerate().map(given).collect()
}
