//! People who stand and evade nobody.

use populace_locomotion::avoidance::{AvoidanceSettings, Bystander, Error};

use crate::walk::{FRAME_SECS, Walk, distance};

const RADIUS_M: f32 = 0.25;

#[test]
fn walkers_go_around_bystanders_in_rows() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    let rows = (0..7).flat_map(|row| (0..5).map(move |column| [row, column]));
    let rows = rows.map(|[x, z]| [x as f32 * 1.3 - 4.0, z as f32 * 1.3 + 0.03]);
    let bystanders: Vec<_> =
        rows.map(|position| Bystander { position, radius_m: RADIUS_M }).collect();
    walk.avoidance.set_bystanders(&bystanders)?;
    for nth in 0..10_u16 {
        walk.add([-8.0 - f32::from(nth % 2), f32::from(nth) * 0.6], RADIUS_M, 0);
    }
    let mut nearest = f32::INFINITY;
    for _ in 0..1500 {
        walk.step(|_, _| [1.3, 0.0])?;
        for at in &walk.positions {
            let near = bystanders.iter().map(|of| distance(of.position, *at));
            nearest = near.fold(nearest, f32::min);
        }
    }
    assert!(nearest > 0.8 * 2.0 * RADIUS_M - 1e-3, "{nearest} m");
    assert!(walk.positions.iter().all(|at| at[0] > 6.0), "{:?}", walk.positions);
    Ok(())
}

/// Also who heeds nobody does not go through them.
#[test]
fn steps_slide_around_bystanders() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    let bystander = Bystander { position: [2.0, 0.05], radius_m: RADIUS_M };
    walk.avoidance.set_bystanders(&[bystander])?;
    let (mut at, mut nearest) = ([0.0, 0.0], f32::INFINITY);
    for _ in 0..240 {
        let to = [at[0] + 1.3 * FRAME_SECS, at[1]];
        at = walk.avoidance.slide(at, to, RADIUS_M);
        nearest = nearest.min(distance(at, bystander.position));
    }
    assert!((0.399..0.41).contains(&nearest), "{nearest} m");
    assert!(at[0] > 3.0, "{at:?}");
    Ok(())
}

#[test]
fn bystanders_out_of_range_are_refused() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    let of = |position, radius_m| [Bystander { position, radius_m }];
    for (bystanders, says) in [
        (of([f32::NAN, 0.0], 0.2), "the position of bystander 0 is NaN"),
        (of([0.0, 0.0], 0.0), "the radius of bystander 0 is 0; it must be above 0 and at most 3"),
    ] {
        let error = walk.avoidance.set_bystanders(&bystanders).unwrap_err().to_string();
        assert!(error.starts_with(says), "{error}");
    }
    Ok(())
}
