//! The result of a bench, held against the oracle.

use glam::{DAffine3, DVec3};
use populace::Error;
use populace::core::layout::PAGE_ENTRIES;
use populace::core::{Affine, Clip, TICKS_PER_SEC};
use populace_testkit::oracle::{OracleBody, OracleSlot, evaluate};

use super::scene::{PlayedSlot, Scene, Staging};
use crate::placement::Random;

/// Members looked at, beside the first and the last of each page.
const SAMPLE: usize = 64;
/// Errors are measured this far from each joint, on a body of 1.8 m.
const PROBE_M: f64 = 0.03;

/// The largest distance between a probe as the device moved it and as the oracle does, over 64 random members and the
/// first and last of each page; and what may be expected: twice the clips' own tolerance, since two clips that each
/// stray by it are blended joint by joint.
pub(crate) fn worst_error_m(scene: &Scene, staging: &mut Staging, tick: u64) -> Result<(f64, f64), Error> {
    let bodies: Vec<_> = scene.characters.iter().map(|c| OracleBody::from_character(c)).collect();
    let (mut worst, mut allowed): (f64, f64) = (0.0, 0.0);
    for index in chosen(staging) {
        let (member, kind, played) = &staging.members[index];
        let character = &scene.characters[*kind];
        let slots: Vec<_> =
            played.iter().map(|slot| oracle_slot(&character.clips[slot.clip], slot, tick)).collect();
        let wanted = evaluate(&bodies[*kind], &slots, &[]);
        let found = staging.crowd.palette(*member)?;
        let probe = PROBE_M * f64::from(character.skeleton.size_m()) / 1.8;
        for ((found, wanted), entry) in found.iter().zip(&wanted.palette).zip(&character.palette) {
            worst = worst.max(distance(found, wanted, &entry.joint_from_bind, probe));
        }
        let tolerance = character.clips.iter().map(|clip| clip.stats().tolerance_m).fold(0.0, f32::max);
        allowed = allowed.max(2.0 * f64::from(tolerance));
    }
    Ok((worst, allowed))
}

fn chosen(staging: &Staging) -> Vec<usize> {
    let count = staging.members.len();
    let mut random = Random::new(count as u64);
    let mut chosen: Vec<usize> = (0..SAMPLE.min(count)).map(|_| random.below(count)).collect();
    let pages: Vec<u32> = staging.crowd.instances().map(|i| i.palette_first / PAGE_ENTRIES).collect();
    let on_border = |at: &usize| {
        let other = |neighbour: Option<usize>| neighbour.and_then(|n| pages.get(n)) != Some(&pages[*at]);
        other(at.checked_sub(1)) || other(at.checked_add(1))
    };
    chosen.extend((0..count).filter(on_border));
    chosen
}

fn oracle_slot<'a>(clip: &'a Clip, slot: &PlayedSlot, tick: u64) -> OracleSlot<'a> {
    let duration = f64::from(clip.duration_secs());
    let elapsed = tick as f64 / TICKS_PER_SEC as f64;
    let phase = (f64::from(slot.phase) + elapsed / duration).rem_euclid(1.0);
    OracleSlot {
        clip: clip.source(),
        time_secs: f64::from(clip.start_secs()) + phase * duration,
        weight: f64::from(slot.weight),
        layer: 0,
    }
}

fn distance(found: &Affine, wanted: &[f64; 12], joint_from_bind: &Affine, probe: f64) -> f64 {
    let bind_from_joint = wide(joint_from_bind).inverse();
    let [a, b, c] = found.rows.map(|row| row.map(f64::from));
    let rows = [a, b, c];
    let probes = [DVec3::ZERO, DVec3::X * probe, DVec3::Y * probe, DVec3::Z * probe];
    let stray = |point: DVec3| {
        let p = bind_from_joint.transform_point3(point);
        let of = |row: usize| {
            let d: [f64; 4] = std::array::from_fn(|i| rows[row][i] - wanted[row * 4 + i]);
            d[0] * p.x + d[1] * p.y + d[2] * p.z + d[3]
        };
        DVec3::new(of(0), of(1), of(2)).length()
    };
    probes.into_iter().map(stray).fold(0.0, f64::max)
}

fn wide(m: &Affine) -> DAffine3 {
    let [a, b, c] = m.rows.map(|row| row.map(f64::from));
    DAffine3::from_cols_array(&[a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2], a[3], b[3], c[3]])
}
