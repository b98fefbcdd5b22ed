//! Checks of sampling: clips held at a time.

use glam::DVec3;
use populace_device::Backend;
use populace_model::convert::single;

use super::plans;
use crate::compare::{Judge, joint_name};
use crate::expected::Expected;
use crate::scenes::{Scene, body};
use crate::{MemberPlan, MemberReading, Play, Rng, TestCrowd};

/// Checks every clip exactly at keys (a STEP key holds from its own time on), before the first key,
/// after the last key, and one unit in the last place before a key, on its own and on other bodies.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_sampling_at_keys(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("sampling at keys");
    let mut rng = Rng::new(21);
    let mut plans = Vec::new();
    for (index, clip) in scene.clips.iter().enumerate() {
        let keys = &clip.exact_times;
        let (first, last) = (keys[0], keys[keys.len() - 1]);
        let mut times = vec![first, last, first - 1.0, last + 1.0, last.next_up()];
        times.extend((0..20).map(|_| keys[rng.below(keys.len())]));
        if clip.between_keys.is_some() {
            times.extend((0..6).map(|_| keys[rng.below(keys.len())].next_down()));
        }
        let bodies = [clip.body, clip.body, clip.body, body::SMALL, body::LARGE];
        for (n, time) in times.into_iter().enumerate() {
            plans.push(MemberPlan::plain(bodies[n % bodies.len()], vec![Play::held(index, time)]));
        }
    }
    let mut crowd = plans::crowd(&scene, 1, plans);
    judge.frame(backend, &mut crowd, 0);
    judge.done();
}

/// Checks clips with STEP tracks, and with LINEAR tracks of small rotations, between their keys,
/// within rounding.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_sampling_between_keys(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("sampling between keys");
    let mut crowd = between_keys(&scene, 22, scene.tight_clips());
    judge.frame(backend, &mut crowd, 0);
    judge.done();
}

/// Checks every clip between its keys, including wide rotations and splines, within the bound that
/// the clip states. Points around each joint of its own body are compared.
///
/// # Panics
///
/// If the backend is wrong, or a clip's own bound is above the promised bound.
pub fn check_sampling_within_clip_bounds(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::new("sampling within clip bounds");
    let mut crowd = between_keys(&scene, 23, (0..scene.clips.len()).collect());
    crowd.run_stages(backend, 0);
    for (member, _, plan) in crowd.members() {
        let clip = &scene.clips[plan.plays[0].clip];
        let tolerance_m = promised_m(&scene, clip.body);
        let stated = f64::from(clip.clip.stats().error_bound_m);
        assert!(
            stated <= tolerance_m * 1.000_1,
            "{}: the clip's own bound, {stated} m, is above the promised {tolerance_m} m",
            clip.clip.name()
        );
        let got = crowd.read(backend, member);
        let wanted = crowd.expected_within(member, 0, clip.at_keys);
        let reach_m = probe_m(&scene, clip.body);
        let bound_m = |joint: usize| tolerance_m + wanted.models[joint].at_reach(reach_m);
        compare_probes(&mut judge, &crowd, member, bound_m, &got, &wanted);
    }
    judge.done();
}

/// Returns the distance from joints at which the promise holds, in metres.
fn probe_m(scene: &Scene, body: usize) -> f64 {
    f64::from(scene.bodies[body].skeleton.size_m()) * 0.03 / 1.8
}

/// Returns the promised deviation of clips on a body from their source curves, in metres.
pub(super) fn promised_m(scene: &Scene, body: usize) -> f64 {
    f64::from(scene.bodies[body].skeleton.size_m()) * 0.000_3 / 1.8
}

fn between_keys(scene: &Scene, seed: u64, clips: Vec<usize>) -> TestCrowd<'_> {
    let mut rng = Rng::new(seed);
    let mut crowd = plans::crowd(scene, 1, None);
    for index in clips {
        let clip = &scene.clips[index];
        let (start, duration) = (clip.clip.start_secs(), clip.clip.duration_secs());
        for _ in 0..24 {
            let time = single(f64::from(start) + rng.between(0.0, 1.0) * f64::from(duration));
            crowd.add(MemberPlan::plain(clip.body, vec![Play::held(index, time)]));
        }
    }
    crowd
}

/// Compares points around each joint, at a distance of 3 cm on a body of 1.8 m, as in the
/// definition of the clip's bound. `bound_m` is that of each joint's points.
pub(super) fn compare_probes(
    judge: &mut Judge,
    crowd: &TestCrowd<'_>,
    member: usize,
    bound_m: impl Fn(usize) -> f64,
    got: &MemberReading,
    wanted: &Expected,
) {
    let plan = crowd.plan(member);
    let reach_m = probe_m(crowd.scene, plan.body);
    let name = crowd.scene.clips[plan.plays[0].clip].clip.name();
    let points = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * reach_m);
    for (joint, model) in wanted.pose.model_from_joint.iter().enumerate() {
        let bound = bound_m(joint);
        for point in points.into_iter().flat_map(|p| [p, -p]) {
            let image = model.transform_point3(point);
            for (axis, row) in got.models[joint].chunks(4).enumerate() {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i: usize| f64::from(row[i]));
                let got = single(a * point.x + b * point.y + c * point.z + d);
                judge.number(got, image[axis], bound, f64::INFINITY, || {
                    let joint = joint_name(crowd, member, joint);
                    let time = plan.plays[0].timing;
                    format!("{joint}, clip \"{name}\" {time:?}, point {point} axis {axis}")
                });
            }
        }
    }
}
