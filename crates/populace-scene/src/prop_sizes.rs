//! The sizes that props have.

use crate::plan::PropPlan;

/// The most seats of a stand.
pub(crate) const MOST_SEATS: f32 = 512.0;

/// A number of `size_m`.
#[derive(Debug)]
pub(crate) struct Size {
    pub(crate) what: &'static str,
    /// The value if the number is left out.
    usual: f32,
    pub(crate) least: f32,
    pub(crate) most: f32,
    /// With a space before it, or empty.
    pub(crate) unit: &'static str,
}

const fn metres(what: &'static str, usual: f32, [least, most]: [f32; 2]) -> Size {
    Size { what, usual, least, most, unit: " metres" }
}

const fn number(what: &'static str, usual: f32) -> Size {
    Size { what, usual, least: 1.0, most: MOST_SEATS, unit: "" }
}

const GROUND: [Size; 1] = [metres("side", 100.0, [1.0, 2000.0])];
const ROAD: [Size; 3] = [
    metres("length", 60.0, [4.0, 1000.0]),
    metres("footway", 4.0, [2.0, 20.0]),
    metres("parking strip", 0.0, [0.0, 6.0]),
];
const SHOPFRONT: [Size; 1] = [metres("width", 7.0, [5.0, 12.0])];
const STAND: [Size; 2] = [number("number of rows", 10.0), number("number of seats in a row", 40.0)];

/// Returns the sizes of a kind of props, in the order of `size_m`.
pub(crate) fn sizes_of(kind: &str) -> &'static [Size] {
    match kind {
        "earth" | "lawn" | "meadow" => &GROUND,
        "road" => &ROAD,
        "shopfront" => &SHOPFRONT,
        "stand" => &STAND,
        _ => &[],
    }
}

/// Returns a size of a prop, and 0 for one that its kind does not have.
pub(crate) fn size_of(prop: &PropPlan, nth: usize) -> f32 {
    let usual = || sizes_of(&prop.kind).get(nth).map_or(0.0, |size| size.usual);
    prop.size_m.get(nth).copied().unwrap_or_else(usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_props::{GroundKind, RoadPlan, ground, road, shopfront, stand};

    /// Makes props at the ends of the ranges, and beyond them, where makers clamp.
    #[test]
    fn the_ranges_are_those_of_the_makers() {
        let [least, most] = [SHOPFRONT[0].least, SHOPFRONT[0].most];
        for (width_m, made_m) in [(least, least), (0.0, least), (most, most), (20.0, most)] {
            assert_eq!(shopfront(1, width_m).unwrap().width_m, made_m);
        }
        let [least, most] = [ROAD[0].least, ROAD[0].most];
        for (length_m, made_m) in [(least, least), (0.0, least), (most, most), (2e3, most)] {
            let plan = RoadPlan { length_m, ..RoadPlan::default() };
            assert_eq!(road(&plan).unwrap().length_m(), made_m);
        }
        for (nth, usual_m) in [(1, 4.0), (2, 0.0)] {
            let front_m = |value: f32| {
                let [sidewalk_m, parking_m] = if nth == 1 { [value, 0.0] } else { [4.0, value] };
                let plan = RoadPlan { sidewalk_m, parking_m, ..RoadPlan::default() };
                road(&plan).unwrap().front_m()
            };
            let Size { least, most, .. } = ROAD[nth];
            let base_m = front_m(usual_m) - usual_m;
            for (value, made_m) in [(least, least), (-1.0, least), (most, most), (90.0, most)] {
                assert!((front_m(value) - base_m - made_m).abs() < 1e-4, "{nth}: {value}");
            }
        }
        let side_m = |size_m: f32| {
            let bounds = ground(GroundKind::Earth, size_m).unwrap().rest_bounds().unwrap();
            bounds.high[0] - bounds.low[0]
        };
        let [least, most] = [GROUND[0].least, GROUND[0].most];
        assert_eq!([0.0, least, most, 9e3].map(side_m), [least, least, most, most]);
        for (rows, seats, made) in [(512, 1, 512), (1, 512, 512), (600, 1, 512), (30, 40, 510)] {
            assert_eq!(stand(rows, seats).unwrap().seats().len(), made, "{rows} x {seats}");
        }
    }
}
