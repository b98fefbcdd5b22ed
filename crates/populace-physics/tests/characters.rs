//! Falls of downloaded people and animals. One test per character in the folder
//! `POPULACE_TEST_DATA` (environment variable).

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use std::path::{Path, PathBuf};

use common::{Scene, beyond_limits, length, minus};
use libtest_mimic::{Arguments, Failed, Trial};
use populace::Placement;
use populace_assets::load;
use populace_physics::{Limits, RagdollPlan};

const VARIABLE: &str = "POPULACE_TEST_DATA";
/// Files, the scale that gives them about life size, and the expected number of bodies if known.
const FILES: [(&str, f32, Option<usize>); 9] = [
    ("characters/kaykit_knight.glb", 1.0, Some(16)),
    ("characters/kaykit_mage.glb", 1.0, Some(16)),
    ("characters/m2m_human_base.glb", 1.0, Some(15)),
    ("characters/rigged_figure.glb", 1.0, None),
    ("characters/cesium_man.gltf", 1.0, None),
    ("characters/quaternius_robot.glb", 0.4, None),
    ("characters/girl.glb", 1.0, None),
    ("animals/m2m_fox.glb", 0.3, None),
    ("animals/fox.glb", 0.01, None),
];

fn main() {
    let arguments = Arguments::from_args();
    let trials = match std::env::var_os(VARIABLE) {
        Some(root) => trials(Path::new(&root)),
        None => vec![
            Trial::test(format!("characters (set {VARIABLE})"), || Ok(())).with_ignored_flag(true),
        ],
    };
    libtest_mimic::run(&arguments, trials).exit();
}

fn trials(root: &Path) -> Vec<Trial> {
    let one = |(file, scale, bodies): (&'static str, f32, Option<usize>)| {
        let path = root.join(file);
        Trial::test(file, move || fall(&path, scale, bodies))
    };
    FILES.into_iter().map(one).collect()
}

fn fall(path: &PathBuf, scale: f32, bodies: Option<usize>) -> Result<(), Failed> {
    let mut scene =
        Scene::new(load(path)?.character, None, Placement::at([1.0, 0.0, 2.0]).scaled(scale));
    let plan = scene.plan.clone();
    let size = scene.skeleton().size_m() * scale;
    check_plan(&plan, bodies)?;
    let hips = plan.bodies()[0].joint();
    scene.go_limp();
    scene.ragdolls.push(
        scene.member,
        hips,
        [0.0, 0.0, -0.5 * plan.mass_kg() * scale.powi(3)],
        None,
    )?;
    scene.frames(2);
    let mut beyond: f32 = 0.0;
    let mut worst = None;
    for frame in 0..400 {
        scene.frame();
        for angles in scene.ragdolls.joint_angles(scene.member) {
            if beyond_limits(&angles) > beyond {
                beyond = beyond_limits(&angles);
                worst = Some((frame, angles));
            }
        }
    }
    let before = scene.positions();
    scene.frames(20);
    let lying = scene.positions();
    let heads: Vec<usize> = plan.bodies().iter().map(|b| b.joint().index()).collect();
    let lowest = heads.iter().map(|j| lying[*j][1]).fold(f32::MAX, f32::min) / size;
    let moved =
        heads.iter().map(|j| length(minus(lying[*j], before[*j]))).fold(0.0, f32::max) / size;
    let measured = format!(
        "{} bodies; limits exceeded by {:.1} degrees; lowest joint at {lowest:.3} of the size, \
         moves by {moved:.4}; {worst:?}",
        plan.bodies().len(),
        beyond.to_degrees()
    );
    println!("{}: {measured}", path.display());
    let is_good = beyond < 0.14 && lowest > -0.06 && moved < 0.02;
    if is_good { Ok(()) } else { Err(measured.into()) }
}

fn check_plan(plan: &RagdollPlan, bodies: Option<usize>) -> Result<(), Failed> {
    let hinges =
        plan.bodies().iter().filter(|b| matches!(b.limits(), Some(Limits::Hinge { .. }))).count();
    let sane = plan
        .bodies()
        .iter()
        .all(|b| b.radius_m() > 0.0 && b.mass_kg() > 0.0 && b.length_m().is_finite());
    if !sane || hinges < 2 || bodies.is_some_and(|count| count != plan.bodies().len()) {
        return Err(format!("{hinges} hinges, {:#?}", plan.bodies()).into());
    }
    Ok(())
}
