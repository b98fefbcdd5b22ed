use std::collections::BTreeMap;
use std::sync::Arc;

use populace::Device;

use super::*;
use crate::Stage;
use crate::plan::ScenePlan;

/// A lane of 60 m in which one vehicle drives, and a bay with another.
fn lane_with_bay(bay_m: f32) -> Result<(Crowd, Traffic), Error> {
    let text = "schema = 1\n[[cast]]\nname = \"a\"\nfrom = [\"@man\"]\n\
                [[crowd]]\ncast = \"a\"\ncount = 1\ndoes.stand = {}\n\
                [[lane]]\nname = \"east\"\nends = [[0, 0], [60, 0]]\nvehicles = 1\n\
                [[bay]]\nlane = \"east\"\nat = [30, 3]\ntaken = true\n";
    let mut plan = ScenePlan::parse(text).unwrap();
    plan.bays[0].at[0] = bay_m;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(8).build()?;
    let stage =
        Stage::new(&mut crowd, &plan, &BTreeMap::new(), &|character| Ok(Arc::new(character)))?;
    let traffic = Traffic::new(&mut crowd, &plan.lanes, &plan.bays, &stage.vehicles)?;
    Ok((crowd, traffic))
}

const PARKED: usize = 0;
const DRIVING: usize = 1;

#[test]
fn a_vehicle_is_back_in_its_lane_before_the_end() {
    let (mut crowd, mut traffic) = lane_with_bay(60.0 - SWERVE_M).unwrap();
    traffic.vehicles[DRIVING].along_m = 20.0;
    assert!(traffic.set_off(PARKED));
    let mut furthest_m = 0.0_f32;
    for _ in 0..300 {
        traffic.advance(&mut crowd, &[], (0.0, 1.0 / 30.0)).unwrap();
        let Vehicle { drive, along_m, .. } = traffic.vehicles[PARKED];
        furthest_m = furthest_m.max(along_m);
        if drive == Drive::Cruises {
            break;
        }
    }
    assert_eq!(traffic.vehicles[PARKED].drive, Drive::Cruises, "it got {furthest_m} m far");
    assert_eq!(traffic.bays[0].vehicle, None);
}

#[test]
fn bays_from_which_nobody_can_set_off_are_refused() {
    for bay_m in [-1.0, SWERVE_M - 0.1, 60.1 - SWERVE_M, 61.0] {
        let error = lane_with_bay(bay_m).err().map(|error| error.to_string());
        let told = error.as_ref().is_some_and(|error| error.contains("within 9 m of one"));
        assert!(told, "{bay_m}: {error:?}");
    }
}

#[test]
fn a_vehicle_that_sets_off_waits_for_one_that_comes_from_the_end() {
    let (_, mut traffic) = lane_with_bay(10.0).unwrap();
    traffic.vehicles[DRIVING].along_m = 58.0;
    assert!(!traffic.set_off(PARKED), "12 m behind it");
    traffic.vehicles[DRIVING].along_m = 25.0;
    assert!(traffic.set_off(PARKED), "15 m ahead");
}
