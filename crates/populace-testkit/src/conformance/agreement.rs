//! Checks that two backends agree.

use populace_clip::ticks_from_secs;
use populace_device::{Backend, Stage};

use super::stages::{two_of_each, write_locals};
use super::{inertialize, plans, retarget};
use crate::compare::Judge;
use crate::expected::Expected;
use crate::scenes::Scene;
use crate::tolerance::{LOCAL_CAP, SampleBound};
use crate::{MemberPlan, MemberReading, Rng, TestCrowd};

/// Checks that Transform and Write-back return the same bits for the same local transforms, since
/// both only add and multiply, and that Pose agrees within twice the rounding bound.
///
/// # Panics
///
/// If the backends differ.
pub fn check_agreement(a: &mut dyn Backend, b: &mut dyn Backend) {
    same_bits(a, b);
    same_pose(a, b);
}

/// Checks that whole frames of all skeletons, clips and layers give the same palettes, bit for bit.
/// This holds for the schedules of one device, and for devices that round quotients correctly.
///
/// # Panics
///
/// If the backends differ.
pub fn check_same_frames(a: &mut dyn Backend, b: &mut dyn Backend) {
    let scene = Scene::new();
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    same_frames(a, b, &scene, &plans::members(83, &scene, &clips, 60, 8));
    let humanoids = Scene::of_humanoids();
    let plans = retarget::plans(&mut Rng::new(84), &humanoids);
    let rolled = same_frames(a, b, &humanoids.clone().on_soles(), &plans);
    assert_ne!(same_frames(a, b, &humanoids, &plans), rolled, "the scene must make some foot roll");
    let inertialization =
        inertialize::plans(&mut Rng::new(85), &scene, &clips, ticks_from_secs(7.0));
    same_frames(a, b, &scene, &inertialization);
}

/// Compares whole frames and returns the palettes of `a`.
fn same_frames(
    a: &mut dyn Backend,
    b: &mut dyn Backend,
    scene: &Scene,
    plans: &[MemberPlan],
) -> Vec<Vec<[f32; 12]>> {
    let mut judge = Judge::new("same frames");
    let frame = |backend: &mut dyn Backend| {
        let mut crowd = plans::crowd(scene, 8, plans.iter().cloned());
        crowd.run(backend, ticks_from_secs(7.1));
        (0..plans.len()).map(|member| crowd.read_palette(backend, member)).collect::<Vec<_>>()
    };
    let (one, other) = (frame(a), frame(b));
    for (member, (one, other)) in one.iter().zip(&other).enumerate() {
        judge.same_matrices(&format!("member {member} palette entry"), other, one);
    }
    judge.done();
    one
}

fn same_bits(a: &mut dyn Backend, b: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::of_stage("agreement");
    let from_locals = |backend: &mut dyn Backend| {
        let mut rng = Rng::new(81);
        let mut crowd = two_of_each(&scene);
        crowd.run_stages(backend, 0);
        for member in 0..12 {
            write_locals(&mut rng, backend, &crowd, member);
        }
        crowd.run_stage(backend, 0, Stage::Transform);
        crowd.run_stage(backend, 0, Stage::WriteBack);
        (0..12).map(|member| crowd.read(backend, member)).collect::<Vec<_>>()
    };
    let (one, other) = (from_locals(a), from_locals(b));
    for (member, (one, other)) in one.iter().zip(&other).enumerate() {
        judge.same_matrices(
            &format!("member {member} model_from_joint"),
            &other.models,
            &one.models,
        );
        judge.same_matrices(
            &format!("member {member} palette entry"),
            &other.palette,
            &one.palette,
        );
    }
    judge.done();
}

fn same_pose(a: &mut dyn Backend, b: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("agreement of poses");
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    let plans = plans::members(82, &scene, &clips, 48, 8);
    let tick = ticks_from_secs(7.7);
    let run = |backend: &mut dyn Backend, crowd: &mut TestCrowd<'_>| {
        crowd.run_stages(backend, tick);
        (0..48).map(|member| crowd.read(backend, member)).collect::<Vec<_>>()
    };
    let mut crowd = plans::crowd(&scene, 8, plans.clone());
    let one = run(a, &mut crowd);
    let other = run(b, &mut plans::crowd(&scene, 8, plans));
    for (member, _, plan) in crowd.members() {
        let jumps = plan
            .shown(tick)
            .any(|(p, tick)| p.timing.is_near_jump(tick, &scene.clips[p.clip].clip));
        if jumps {
            judge.skip(10 * one[member].rotations.len());
            continue;
        }
        // Both backends sample the same rows, so the error of a clip's rows is the same on both.
        let bounds = plan.plays.iter().map(|p| scene.clips[p.clip].at_keys);
        let bound = bounds.fold(SampleBound::default(), SampleBound::or);
        let wanted = crowd.expected_within(member, tick, bound);
        compare_locals(&mut judge, member, &other[member], &one[member], &wanted);
    }
    judge.done();
}

/// Compares one member's local transforms from both backends. Each may be off by its bound.
fn compare_locals(
    judge: &mut Judge,
    member: usize,
    got: &MemberReading,
    with: &MemberReading,
    wanted: &Expected,
) {
    for (joint, bound) in wanted.locals.iter().enumerate() {
        let mut pair = |what: &str, got: &[f32], with: &[f32], bound: f64| {
            let cosine: f32 = got.iter().zip(with).map(|(g, w)| g * w).sum();
            let sign = if got.len() == 4 && cosine < 0.0 { -1.0 } else { 1.0 };
            for (c, (got, with)) in got.iter().zip(with).enumerate() {
                let name = || format!("member {member} joint {joint} {what} {c}");
                judge.number(sign * got, f64::from(*with), 2.0 * bound, 2.0 * LOCAL_CAP, name);
            }
        };
        pair("rotation", &got.rotations[joint], &with.rotations[joint], bound.rotation);
        pair("translation", &got.translations[joint], &with.translations[joint], bound.translation);
        pair("scale", &got.scales[joint], &with.scales[joint], bound.scale);
    }
}
