//! Checks of different members in one dispatch.

use populace_clip::ticks_from_secs;
use populace_device::Backend;

use super::plans;
use crate::compare::Judge;
use crate::scenes::Scene;
use crate::{MemberPlan, Rng};

type Palette = Vec<[f32; 12]>;

/// Returns the palette of a member that is alone in its crowd.
fn alone(
    make: &mut dyn FnMut() -> Box<dyn Backend>,
    scene: &Scene,
    plan: &MemberPlan,
    tick: u64,
) -> Palette {
    let mut backend = make();
    let mut crowd = plans::crowd(scene, 8, [plan.clone()]);
    crowd.run(&mut *backend, tick);
    crowd.read_palette(&mut *backend, 0)
}

fn any_members(seed: u64, scene: &Scene, count: usize) -> Vec<MemberPlan> {
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    plans::members(seed, scene, &clips, count, 8)
}

/// Checks that every member of a crowd with all skeletons, clips and layers gets the same bits as
/// alone, in any order of members.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_mixed_dispatch(make: &mut dyn FnMut() -> Box<dyn Backend>) {
    let scene = Scene::new();
    let mut judge = Judge::new("mixed dispatch");
    let plans = any_members(61, &scene, 25);
    let tick = ticks_from_secs(7.3);
    let expected: Vec<Palette> = plans.iter().map(|plan| alone(make, &scene, plan, tick)).collect();
    for seed in 0..3 {
        let mut order: Vec<usize> = (0..plans.len()).collect();
        if seed > 0 {
            Rng::new(seed).shuffle(&mut order);
        }
        let mut backend = make();
        let mut crowd = plans::crowd(&scene, 8, order.iter().map(|&n| plans[n].clone()));
        crowd.run(&mut *backend, tick);
        for (member, &n) in order.iter().enumerate() {
            let name = format!("order {seed} member {member} (plan {n}) palette entry");
            judge.same_matrices(&name, &crowd.read_palette(&mut *backend, member), &expected[n]);
        }
    }
    judge.done();
}

/// Checks that every member still gets the same bits as alone after members were removed and others
/// took their indices.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_churn(make: &mut dyn FnMut() -> Box<dyn Backend>) {
    let scene = Scene::new();
    let mut judge = Judge::new("churn");
    let mut rng = Rng::new(62);
    let mut backend = make();
    let mut crowd = plans::crowd(&scene, 8, any_members(63, &scene, 18));
    for round in 0..4 {
        let tick = ticks_from_secs(6.0 + 0.21 * f64::from(round));
        crowd.run(&mut *backend, tick);
        let existing: Vec<usize> = crowd.members().map(|(member, ..)| member).collect();
        for member in existing {
            if rng.chance(0.4) {
                crowd.remove(member);
            }
        }
        if round == 2 {
            // A frame in which some indices are free.
            crowd.run(&mut *backend, tick);
        }
        for plan in any_members(70 + u64::try_from(round).expect("few rounds"), &scene, 7) {
            crowd.add(plan);
        }
    }
    let tick = ticks_from_secs(8.4);
    crowd.run(&mut *backend, tick);
    for (member, _, plan) in crowd.members() {
        let name = format!("member {member} palette entry");
        let got = crowd.read_palette(&mut *backend, member);
        judge.same_matrices(&name, &got, &alone(make, &scene, plan, tick));
    }
    judge.done();
}
