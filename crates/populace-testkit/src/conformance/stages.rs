//! Checks of Transform and Write-back alone, on arbitrary numbers, and of whole palette pages.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_clip::ticks_from_secs;
use populace_device::layout::Float4;
use populace_device::{Backend, Stage, StageBuffer};
use populace_model::convert::single;

use super::plans;
use crate::compare::Judge;
use crate::expected::Expected;
use crate::oracle::{Gain, Local, OraclePose, model_from_joints, palettes};
use crate::scenes::Scene;
use crate::tolerance::{AffineBound, LocalBound, model_bounds, palette_bounds};
use crate::{MemberPlan, Rng, TestCrowd};

/// Creates two members of each body, with different neighbours.
pub(super) fn two_of_each(scene: &Scene) -> TestCrowd<'_> {
    let bodies = (0..scene.bodies.len()).chain((0..scene.bodies.len()).rev());
    plans::crowd(scene, 1, bodies.map(|body| MemberPlan::plain(body, vec![])))
}

/// Writes random local transforms for a member and returns them.
pub(super) fn write_locals(
    rng: &mut Rng,
    backend: &mut dyn Backend,
    crowd: &TestCrowd<'_>,
    member: usize,
) -> Vec<Local> {
    let count = crowd.scene.bodies[crowd.plan(member).body].joints.len();
    let mut translations = Vec::new();
    let mut rotations = Vec::new();
    let mut scales = Vec::new();
    for _ in 0..count {
        let [x, y, z] = rng.vector(-0.3, 0.3).to_array().map(single);
        translations.push([x, y, z, 0.0]);
        rotations.push(rng.rotation().to_array().map(single));
        let [x, y, z] = rng.vector(0.8, 1.15).to_array().map(single);
        scales.push([x, y, z, 0.0]);
    }
    crowd.write_joints(backend, member, StageBuffer::Translations, &translations);
    crowd.write_joints(backend, member, StageBuffer::Rotations, &rotations);
    crowd.write_joints(backend, member, StageBuffer::Scales, &scales);
    let three = |v: [f32; 4]| DVec3::from_slice(&v.map(f64::from)[..3]);
    (0..count)
        .map(|joint| Local {
            translation: three(translations[joint]),
            rotation: DQuat::from_array(rotations[joint].map(f64::from)),
            scale: three(scales[joint]),
        })
        .collect()
}

/// Checks Transform alone with random local transforms on every body.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_transform_alone(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::of_stage("transform alone");
    let mut rng = Rng::new(51);
    let mut crowd = two_of_each(&scene);
    crowd.run_stages(backend, 0);
    let locals: Vec<Vec<Local>> =
        (0..12).map(|member| write_locals(&mut rng, backend, &crowd, member)).collect();
    crowd.run_stage(backend, 0, Stage::Transform);
    for (member, locals) in locals.into_iter().enumerate() {
        let body = &scene.bodies[crowd.plan(member).body].oracle;
        let model_from_joint = model_from_joints(body, &locals);
        let exact = vec![LocalBound::default(); locals.len()];
        let models = model_bounds(body, &locals, &model_from_joint, &exact);
        let wanted = expected(locals, model_from_joint, models, vec![], vec![]);
        judge.models(&crowd, member, &crowd.read(backend, member), &wanted);
    }
    judge.done();
}

/// Checks Write-back alone with random matrices on every body.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_write_back_alone(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::of_stage("write-back alone");
    let mut rng = Rng::new(52);
    let mut crowd = two_of_each(&scene);
    crowd.run_stages(backend, 0);
    let models: Vec<Vec<DAffine3>> =
        (0..12).map(|member| write_models(&mut rng, backend, &crowd, member)).collect();
    crowd.run_stage(backend, 0, Stage::WriteBack);
    for (member, models) in models.into_iter().enumerate() {
        let body = &scene.bodies[crowd.plan(member).body].oracle;
        let palette = palettes(body, &models);
        let exact = vec![AffineBound::default(); models.len()];
        let bounds = palette_bounds(body, &models, &exact);
        let wanted = expected(vec![], models, exact, palette, bounds);
        judge.palette(member, &crowd.read_palette(backend, member), &wanted);
    }
    judge.done();
}

fn write_models(
    rng: &mut Rng,
    backend: &mut dyn Backend,
    crowd: &TestCrowd<'_>,
    member: usize,
) -> Vec<DAffine3> {
    let count = crowd.scene.bodies[crowd.plan(member).body].joints.len();
    let mut rows: [Vec<[f32; 4]>; 3] = Default::default();
    for row in &mut rows {
        row.extend((0..count).map(|_| [(); 4].map(|()| single(rng.between(-1.2, 1.2)))));
    }
    let buffers = [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2];
    for (buffer, row) in buffers.into_iter().zip(&rows) {
        crowd.write_joints(backend, member, buffer, row);
    }
    let column = |joint: usize, c: usize| {
        DVec3::from_array([0, 1, 2].map(|r: usize| f64::from(rows[r][joint][c])))
    };
    (0..count)
        .map(|joint| DAffine3 {
            matrix3: DMat3::from_cols(column(joint, 0), column(joint, 1), column(joint, 2)),
            translation: column(joint, 3),
        })
        .collect()
}

fn expected(
    locals: Vec<Local>,
    model_from_joint: Vec<DAffine3>,
    models: Vec<AffineBound>,
    palette: Vec<[f64; 12]>,
    palette_bounds: Vec<AffineBound>,
) -> Expected {
    Expected {
        pose: OraclePose { gains: Vec::<Gain>::new(), locals, model_from_joint, palette },
        locals: vec![],
        models,
        palette: palette_bounds,
    }
}

/// Checks that whole pages equal single reads, up to the last entry in use.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_pages(backend: &mut dyn Backend) {
    let scene = Scene::new();
    let mut judge = Judge::of_stage("pages");
    let clips: Vec<usize> = (0..scene.clips.len()).collect();
    let mut crowd = plans::crowd(&scene, 4, plans::members(53, &scene, &clips, 18, 4));
    crowd.run(backend, ticks_from_secs(6.0));
    let mut pages: Vec<Vec<Float4>> = Vec::new();
    for (page, length) in crowd.tables.page_lengths().enumerate() {
        let mut copy = Vec::new();
        backend.with_page(page, &mut |elements| copy = elements.to_vec()).expect("the page exists");
        assert!(
            copy.len() >= 3 * length,
            "page {page} has {} elements, off by {}",
            copy.len(),
            3 * length - copy.len()
        );
        copy.truncate(3 * length);
        pages.push(copy);
    }
    let all = pages.concat();
    for (member, index, _) in crowd.members() {
        let first = 3 * crowd.tables.members().as_slice()[index as usize].palette_first as usize;
        for (entry, matrix) in crowd.read_palette(backend, member).iter().enumerate() {
            for (element, value) in matrix.iter().enumerate() {
                let in_page = all[first + 3 * entry + element / 4].0[element % 4];
                let name = || {
                    format!("member {member} palette entry {entry} element {element} in its page")
                };
                judge.bits(in_page, *value, name);
            }
        }
    }
    judge.done();
}
