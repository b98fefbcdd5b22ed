//! Groups: side by side, together, and walked around.

use populace_locomotion::avoidance::{AvoidanceSettings, Error, GroupSettings};

use crate::walk::{Walk, distance};

/// Three who start one behind another and walk along +X with unequal speeds.
fn three(group: u32) -> Result<Walk, Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    for nth in 0..3 {
        walk.add([nth as f32 * -1.5, nth as f32 * 0.01], 0.25, group);
    }
    for _ in 0..30 * 60 {
        walk.step(|nth, _| [1.4 - 0.15 * nth as f32, 0.0])?;
    }
    Ok(walk)
}

#[test]
fn a_group_waits_and_walks_side_by_side() -> Result<(), Error> {
    let spread = |walk: &Walk, c: usize| {
        let all = walk.positions.iter().map(|at| at[c]);
        all.clone().fold(f32::NEG_INFINITY, f32::max) - all.fold(f32::INFINITY, f32::min)
    };
    let together = three(7)?;
    assert!(spread(&together, 0) < 1.0, "along {}", spread(&together, 0));
    let abreast = spread(&together, 1);
    assert!((1.0..2.0).contains(&abreast), "{abreast} wide");
    assert_eq!(together.overlaps(0.0), 0);
    assert!(together.positions[0][0] > 30.0, "they walk on");
    let strangers = three(0)?;
    assert!(spread(&strangers, 0) > 8.0, "strangers do not wait");
    Ok(())
}

#[test]
fn a_member_who_stands_is_waited_for_only_within_limits() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    walk.add([0.0, 0.0], 0.25, 3);
    walk.add([0.0, 1.0], 0.25, 3);
    for _ in 0..20 * 60 {
        walk.step(|nth, _| [if nth == 0 { 1.3 } else { 0.0 }, 0.0])?;
    }
    let [x, _] = walk.positions[0];
    assert!((7.0..20.0).contains(&x), "slowly, but on: {x}");
    Ok(())
}

/// Whether somebody who meets a pair head on walks between them.
fn passes_between(is_walked_around: bool) -> Result<bool, Error> {
    let groups = GroupSettings { is_walked_around, spacing_m: 1.2, ..Default::default() };
    let settings = AvoidanceSettings { groups, keep_right: 0.0, ..Default::default() };
    let mut walk = Walk::new(settings, &[])?;
    walk.add([-7.0, 0.0], 0.25, 0);
    walk.add([7.0, 0.65], 0.25, 5);
    walk.add([7.0, -0.65], 0.25, 5);
    for _ in 0..10 * 60 {
        walk.step(|nth, _| [if nth == 0 { 1.3 } else { -1.3 }, 0.0])?;
        let [own, a, b] = [0, 1, 2].map(|nth| walk.positions[nth]);
        if own[0] > a[0] {
            let between = (own[1] - a[1]) * (own[1] - b[1]) < 0.0;
            assert!(distance(a, b) < 2.5, "the pair stays together");
            return Ok(between);
        }
    }
    panic!("they never meet");
}

#[test]
fn strangers_walk_around_a_pair() -> Result<(), Error> {
    assert!(!passes_between(true)?);
    assert!(passes_between(false)?, "otherwise the way between is free");
    Ok(())
}
