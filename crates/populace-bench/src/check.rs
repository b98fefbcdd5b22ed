//! Compares the results of a benchmark with the oracle.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};
use populace::character::Character;
use populace::interop::PAGE_ENTRIES;
use populace::model::Affine;
use populace::{Crowd, Error};
use populace_testkit::Rng;
use populace_testkit::oracle::{OracleBody, evaluate};

use crate::changes::{ChangingSlots, SlotState};
use crate::constraints;
use crate::errors::larger;
use crate::scene::{Load, Scene};
use crate::spec::FRAME_TICKS;

/// Number of random members that are compared.
const SAMPLE_COUNT: usize = 64;
/// Distance from each joint at which errors are measured, on a body of 1.8 m.
const PROBE_M: f64 = 0.03;

/// A comparison of members of a benchmark with the oracle.
pub(crate) struct OracleCheck<'a> {
    pub(crate) scene: &'a Scene,
    /// Number of frames since the start.
    pub(crate) frames: u32,
    /// Indices of the members to compare.
    pub(crate) members: Vec<usize>,
    /// Number of slots that were evaluated; the first ones.
    pub(crate) slots: usize,
}

impl OracleCheck<'_> {
    /// Returns the largest distance between probe points moved by a member's palette and by the
    /// oracle's.
    pub(crate) fn worst_error_m<E: From<Error>>(
        &self,
        mut palette: impl FnMut(usize) -> Result<Vec<Affine>, E>,
    ) -> Result<f64, E> {
        let scene = self.scene;
        let bodies: Vec<_> =
            scene.characters.iter().map(|c| OracleBody::from_character(c)).collect();
        let tick = u64::from(self.frames) * FRAME_TICKS;
        let mut worst: f64 = 0.0;
        for (member, states) in self.slot_states() {
            let index = scene.character_index(member);
            let character = &scene.characters[index];
            let slots: Vec<_> = states.iter().map(|slot| slot.at(tick, character)).collect();
            let full = scene.load == Load::Full;
            let layers = if full { constraints::oracle_layers(character)? } else { Vec::new() };
            let wanted = evaluate(&bodies[index], &slots, &layers);
            let probe = PROBE_M * f64::from(character.skeleton.size_m()) / 1.8;
            let found = palette(member)?;
            if found.len() != wanted.palette.len() {
                return Ok(f64::INFINITY);
            }
            if scene.load.is_constrained() {
                let models = models_from_palette(character, &found);
                let target = scene.target(member);
                let error = constraints::worst_error_m(character, &models, &wanted, target, probe);
                worst = larger(worst, error);
                continue;
            }
            for ((found, wanted), entry) in
                found.iter().zip(&wanted.palette).zip(&character.palette)
            {
                worst = larger(worst, distance(found, wanted, &entry.joint_from_bind, probe));
            }
        }
        Ok(worst)
    }

    /// Returns the slots of the members after all frames.
    fn slot_states(&self) -> BTreeMap<usize, Vec<SlotState>> {
        let start = |member: &usize| {
            (*member, ChangingSlots::new(self.scene.initial_slots(*member).take(self.slots)))
        };
        let mut changing: BTreeMap<_, _> = self.members.iter().map(start).collect();
        for frame in 0..self.frames {
            let tick = u64::from(frame) * FRAME_TICKS;
            for (member, clip) in self.scene.changes(frame) {
                if let Some(member) = changing.get_mut(&member) {
                    member.advance_to(tick);
                    member.crossfade(clip, tick);
                }
            }
        }
        let end = u64::from(self.frames) * FRAME_TICKS;
        changing.values_mut().for_each(|member| member.advance_to(end));
        changing.into_iter().map(|(index, member)| (index, member.slots)).collect()
    }
}

impl Scene {
    /// Returns the largest error in metres of palettes that another program computed, after a
    /// number of frames of 1/60 s. The same members are compared as for a measured crowd. The error
    /// is infinite if a palette has another size or a number is not finite.
    ///
    /// # Errors
    ///
    /// Errors of `palette`, which returns the palette of a member.
    pub fn error_of<E: From<Error>>(
        &self,
        frames: u32,
        palette: impl FnMut(usize) -> Result<Vec<Affine>, E>,
    ) -> Result<f64, E> {
        let (members, slots) = (sample(self), self.slot_count);
        OracleCheck { scene: self, frames, members, slots }.worst_error_m(palette)
    }
}

/// Returns the allowed error of a crowd: twice the clips' own tolerance, since two clips with that
/// error each are blended joint by joint.
pub(crate) fn allowed_m(scene: &Scene) -> f64 {
    let clips = scene.characters.iter().flat_map(|character| &character.clips);
    2.0 * f64::from(clips.map(|clip| clip.stats().tolerance_m).fold(0.0, f32::max))
}

/// Returns random members of a scene, and its first and last if it has any.
pub(crate) fn sample(scene: &Scene) -> Vec<usize> {
    let count = scene.member_count;
    let mut random = Rng::from_state(count as u64);
    let random = (0..SAMPLE_COUNT.min(count)).map(|_| random.below(count));
    random.chain([0, count.saturating_sub(1)]).filter(|member| *member < count).collect()
}

/// Returns the members on either side of each page boundary.
pub(crate) fn at_page_boundaries(crowd: &Crowd) -> Vec<usize> {
    let pages: Vec<u32> = crowd.instances().map(|i| i.palette_first / PAGE_ENTRIES).collect();
    let boundaries = (1..pages.len()).filter(|at| pages[at - 1] != pages[*at]);
    boundaries.flat_map(|at| [at - 1, at]).collect()
}

/// Computes `model_from_joint` in source order from a palette with an entry for each joint.
fn models_from_palette(character: &Character, palette: &[Affine]) -> Vec<DAffine3> {
    let mut models = vec![DAffine3::IDENTITY; character.skeleton.joint_count()];
    for (entry, matrix) in character.palette.iter().zip(palette) {
        let source = character.skeleton.source_from_joint(entry.joint);
        models[source] = wide(matrix) * wide(&entry.joint_from_bind).inverse();
    }
    models
}

fn distance(found: &Affine, wanted: &[f64; 12], joint_from_bind: &Affine, probe: f64) -> f64 {
    let bind_from_joint = wide(joint_from_bind).inverse();
    let [a, b, c] = found.rows.map(|row| row.map(f64::from));
    let rows = [a, b, c];
    let probes = [DVec3::ZERO, DVec3::X * probe, DVec3::Y * probe, DVec3::Z * probe];
    let error = |point: DVec3| {
        let p = bind_from_joint.transform_point3(point);
        let of = |row: usize| {
            let d: [f64; 4] = std::array::from_fn(|i| rows[row][i] - wanted[row * 4 + i]);
            d[0] * p.x + d[1] * p.y + d[2] * p.z + d[3]
        };
        DVec3::new(of(0), of(1), of(2)).length()
    };
    probes.into_iter().map(error).fold(0.0, larger)
}

fn wide(m: &Affine) -> DAffine3 {
    let [a, b, c] = m.rows.map(|row| row.map(f64::from));
    DAffine3::from_cols_array(&[
        a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2], a[3], b[3], c[3],
    ])
}

#[cfg(test)]
mod tests {
    use populace::{Device, Schedule, Split};

    use super::*;
    use crate::scene::{DeviceSetup, SceneSettings, Staging};

    const FRAMES: u32 = 45;

    fn scene(load: Load, slots: usize) -> Scene {
        let settings = SceneSettings { joints: Some(20), slots, seed: 0 };
        Scene::new(settings, load).unwrap().with_members(12)
    }

    /// Runs a crowd for more frames than a fade takes.
    fn after_frames(scene: &Scene) -> Staging {
        let mut staging = scene
            .set_up(
                &DeviceSetup { devices: Device::native().into(), split: Split::Measured },
                Schedule::Fused,
                &mut (),
            )
            .unwrap();
        for frame in 0..FRAMES {
            staging.change(scene, frame).unwrap();
            staging.crowd.update(1.0 / 60.0).unwrap();
        }
        staging
    }

    fn error_m(scene: &Scene, staging: &mut Staging, of: impl Fn(usize) -> usize) -> f64 {
        let members = (0..scene.member_count).collect();
        let check = OracleCheck { scene, frames: FRAMES, members, slots: scene.slot_count };
        check
            .worst_error_m(|member| {
                staging.crowd.member_mut(staging.members[of(member)]).and_then(|mut m| m.palette())
            })
            .unwrap()
    }

    #[test]
    fn crowds_pass_under_every_load() {
        let changing = Load::Changing { percent: 9.0 };
        let loads = [Load::Plain, Load::Retargeted, changing, Load::Constraints, Load::Full];
        for (load, slots) in loads.into_iter().flat_map(|load| [1, 2, 4].map(|slots| (load, slots)))
        {
            let scene = scene(load, slots);
            let error = error_m(&scene, &mut after_frames(&scene), |member| member);
            assert!(error > 0.0 && error < allowed_m(&scene), "{load}, {slots} slots: {error} m");
        }
    }

    #[test]
    fn numbers_that_are_none_are_infinite_errors() {
        let plain = scene(Load::Plain, 1);
        let rows = [[f32::NAN; 4]; 3];
        let error = plain.error_of(FRAMES, |_| Ok::<_, Error>(vec![Affine { rows }; 20]));
        assert!(error.unwrap().is_infinite());
    }

    #[test]
    fn check_detects_swapped_and_stale_palettes() {
        let plain = scene(Load::Plain, 2);
        let error = error_m(&plain, &mut after_frames(&plain), |member| (member + 1) % 12);
        assert!(error > 10.0 * allowed_m(&plain), "{error} m");
        // Swapped constraints are detected as well.
        let full = scene(Load::Full, 2);
        let error = error_m(&full, &mut after_frames(&full), |member| (member + 1) % 12);
        assert!(error > 10.0 * allowed_m(&full), "{error} m");
        let free = scene(Load::Constraints, 2);
        let error = error_m(&free, &mut after_frames(&plain), |member| member);
        assert!(error > 10.0 * allowed_m(&plain), "{error} m without constraints");
        let changing = scene(Load::Changing { percent: 9.0 }, 2);
        let error = error_m(&changing, &mut after_frames(&plain), |member| member);
        assert!(error > 10.0 * allowed_m(&plain), "{error} m");
    }
}
