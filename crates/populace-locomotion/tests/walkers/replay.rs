//! The same calls give the same bits.

use std::sync::Arc;

use populace::{Device, Placement};
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings, Obstacle};
use populace_locomotion::{Goal, Path};

use crate::fixture::{FRAME_SECS, Town};

/// Enough walkers for more than one thread, who meet between walls.
fn busy(device: Device, walkers: u16) -> Town {
    let mut town = Town::on(device);
    let mut avoidance = Avoidance::new(AvoidanceSettings::default()).unwrap();
    avoidance.set_obstacles(&[Obstacle::line([[-9.0, 5.0], [30.0, 5.0]])]).unwrap();
    town.walkers.set_avoidance(Some(avoidance));
    let mut random = fastrand::Rng::with_seed(5);
    for nth in 0..walkers {
        let at = [f32::from(nth % 25), f32::from(nth / 25)].map(|m| 0.9 * m);
        let scale = 0.8 + 0.4 * random.f32();
        let member = town.add(Placement::at([at[0], 0.0, at[1]]).scaled(scale));
        let point = |random: &mut fastrand::Rng| [20.0 * random.f32(), 20.0 * random.f32()];
        let goal = match nth % 3 {
            0 => Goal::Point(point(&mut random)),
            1 => {
                let path = Path::new(&[point(&mut random), point(&mut random)]).unwrap();
                Goal::Path(Arc::new(path.closed()))
            }
            _ => Goal::Velocity([1.5, -0.5]),
        };
        town.send(member, 0.4 + 2.0 * random.f32(), goal);
        town.walkers
            .set_group(member, if nth % 10 < 2 { u32::from(nth / 10) + 1 } else { 0 })
            .unwrap();
    }
    town
}

/// Runs frames and returns the bits of all positions after each, and of all palettes at the end.
fn bits(town: &mut Town, frames: u32) -> (Vec<[u32; 2]>, Vec<u32>) {
    let (mut positions, mut palettes) = (Vec::new(), Vec::new());
    for _ in 0..frames {
        town.step();
        town.crowd.update(FRAME_SECS).unwrap();
        positions.extend(town.walkers.positions().iter().map(|at| at.map(f32::to_bits)));
    }
    let mut read = |_, palette: &[populace::Affine]| {
        let values = palette.iter().flat_map(|affine| affine.rows.as_flattened());
        palettes.extend(values.map(|value| value.to_bits()));
    };
    town.crowd.palettes(&mut read).unwrap();
    assert!(!palettes.is_empty());
    (positions, palettes)
}

#[test]
fn a_clone_and_a_snapshot_go_on_as_the_original() {
    let mut town = busy(Device::Native { threads: 2 }, 60);
    bits(&mut town, 50);
    let (walkers, snapshot) = (town.walkers.clone(), town.crowd.snapshot().unwrap());
    let first = bits(&mut town, 70);
    town.walkers = walkers;
    town.crowd.restore(&snapshot).unwrap();
    let again = bits(&mut town, 70);
    assert!(first == again, "positions or palettes differ");
    assert!(first != bits(&mut town, 70), "nobody moves");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bits(&mut busy(Device::Native { threads }, 600), 40))
    };
    let (one, two) = (run(1), run(2));
    assert!(one.0 == two.0, "positions differ");
    assert!(one.1 == two.1, "palettes differ");
}
