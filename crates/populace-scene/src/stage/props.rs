//! Props that are made by code or come from files, and what they offer to people.

use std::collections::BTreeMap;
use std::sync::Arc;

use populace::character::Character;
use populace_props::{Crossing, CrossingKind, Lamp, Road, RoadPlan};

use super::Prepare;
use crate::Error;
use crate::plan::PropPlan;
use crate::prop_sizes::size_of;

/// The kinds of props that are made by code.
pub const PROP_KINDS: [&str; 15] = [
    "bench",
    "bin",
    "bollard",
    "cafe_table",
    "earth",
    "lawn",
    "meadow",
    "planter",
    "road",
    "shopfront",
    "stand",
    "street_lamp",
    "traffic_light",
    "tree",
    "walk_light",
];

/// A prop, and the places in its own space that it offers.
pub(super) struct Made {
    pub(super) character: Arc<Character>,
    pub(super) windows: Vec<([f32; 3], f32, [f32; 3])>,
    pub(super) seats: Vec<([f32; 3], f32)>,
    /// The foot of a wall that faces +Z.
    pub(super) wall: Option<[f32; 3]>,
    pub(super) road: Option<Road>,
    pub(super) lamps: Vec<(Lamp, usize)>,
}

/// Kind or file, seed and sizes of a prop. Props of one key share a character.
pub(super) type Key = (String, u64, Vec<u32>);

pub(super) fn key(prop: &PropPlan) -> Key {
    let sizes = prop.size_m.iter().map(|size| size.to_bits()).collect();
    let name = prop.file.as_ref().map_or_else(|| prop.kind.clone(), |file| format!("file {file}"));
    (name, prop.seed, sizes)
}

/// Makes a prop of a kind, or takes that of a file.
pub(super) fn make(
    prop: &PropPlan,
    files: &BTreeMap<String, Character>,
    prepare: &Prepare<'_>,
) -> Result<Made, Error> {
    use populace_props as props;
    let (mut windows, mut seats, mut lamps) = (Vec::new(), Vec::new(), Vec::new());
    let (mut road, mut wall) = (None, None);
    if let Some(file) = &prop.file {
        let character = files.get(file).cloned();
        let character =
            character.ok_or_else(|| Error::unknown("file of a prop", file, files.keys()))?;
        let character = prepare(character).map_err(populace::Error::from)?;
        return Ok(Made { character, windows, seats, wall, road, lamps });
    }
    let mut seating = |made: props::Seating| {
        seats = made.seats.iter().map(|seat| (seat.position, seat.yaw_rad)).collect();
        made.character
    };
    let size = |nth: usize| size_of(prop, nth);
    let character = match prop.kind.as_str() {
        "bench" => props::bench().map(&mut seating),
        "bin" => props::bin(),
        "bollard" => props::bollard(),
        "cafe_table" => props::cafe_table().map(&mut seating),
        "earth" => props::ground(props::GroundKind::Earth, size(0)),
        "lawn" => props::ground(props::GroundKind::Lawn, size(0)),
        "meadow" => props::ground(props::GroundKind::Meadow, size(0)),
        "planter" => props::planter(prop.seed),
        "stand" => props::stand(whole(size(0)), whole(size(1))).map(|made| {
            seats = made.seats().iter().map(|seat| (seat.position, seat.yaw_rad)).collect();
            made.character
        }),
        "street_lamp" => props::street_lamp(),
        "traffic_light" => props::traffic_light(),
        "tree" => props::tree(prop.seed),
        "walk_light" => props::walk_light(),
        "road" => props::road(&road_plan(prop.seed, size(0), size(1), size(2)))
            .map(|made| road.insert(made).character.clone()),
        "shopfront" => props::shopfront(prop.seed, size(0)).map(|made| {
            windows = made.windows.iter().map(|at| (at.stand, at.yaw_rad, at.look_at)).collect();
            wall = Some(made.pier);
            made.character
        }),
        kind => {
            let kinds = PROP_KINDS.map(str::to_owned);
            return Err(Error::unknown("kind of prop", kind, kinds.iter()));
        }
    };
    let character =
        prepare(character.map_err(populace::Error::from)?).map_err(populace::Error::from)?;
    for lamp in Lamp::OF_CARS.into_iter().chain(Lamp::OF_PEOPLE) {
        lamps.extend(lamp.option_in(&character).map(|option| (lamp, option)));
    }
    Ok(Made { character, windows, seats, wall, road, lamps })
}

/// Returns a number of rows or of seats.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to 1000")]
fn whole(number: f32) -> u32 {
    number.clamp(1.0, 1000.0) as u32
}

/// Returns the plan of a road with a crossing in its middle: a zebra for an even seed, one with
/// signals for an odd one.
fn road_plan(seed: u64, length_m: f32, sidewalk_m: f32, parking_m: f32) -> RoadPlan {
    let kind = if seed.is_multiple_of(2) { CrossingKind::Zebra } else { CrossingKind::Signals };
    let crossing = Crossing { x_m: 0.0, width_m: 4.0, kind };
    RoadPlan { length_m, sidewalk_m, parking_m, crossings: vec![crossing] }
}
