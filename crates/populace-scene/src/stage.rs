//! The stage of a scene: its props in a crowd, and what they offer to people.

use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::sync::Arc;

use populace::character::Character;
use populace::{CharacterId, ClipId, Crowd, Ground, MemberId, MemberLook, Placement};
use populace_props::{CarKind, Crossing, CrossingKind, Lamp, Road, RoadPlan};
use rayon::prelude::*;

use self::ground::PlacedRoad;
use crate::Error;
use crate::plan::{BehaviourPlan, CrowdPlan, LeanPlan, PropPlan, ScenePlan, SeatPlan, SpotPlan};
use crate::prop_sizes::size_of;

mod ground;

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

/// The kinds of things that people hold and wear.
pub const THING_KINDS: [&str; 5] = ["box", "helmet", "phone", "shield", "spear"];

/// The thing that people carry with both hands.
pub(crate) const PARCEL: &str = "box";

/// The thing that people telephone with and read.
pub(crate) const PHONE: &str = "phone";

/// Number of different shields and helmets.
const VARIANTS: u64 = 4;
/// Kinds and seeds of the vehicles of lanes and bays.
const VEHICLES: [(CarKind, u64); 6] = [
    (CarKind::Hatchback, 1),
    (CarKind::Saloon, 2),
    (CarKind::Hatchback, 3),
    (CarKind::Van, 4),
    (CarKind::Saloon, 5),
    (CarKind::Hatchback, 6),
];

/// The lights of a crossing.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lights {
    /// People walk.
    Walk,
    /// Nobody moves: the road is cleared of people.
    ClearOfPeople,
    /// Vehicles drive.
    Drive,
    /// Nobody moves: the road is cleared of vehicles.
    ClearOfVehicles,
}

/// A kind of vehicle: its character in a crowd and its measures. It faces +Z.
#[derive(Clone, Debug)]
pub(crate) struct VehicleModel {
    /// The character.
    pub(crate) character: CharacterId,
    /// Its length in metres.
    pub(crate) length_m: f32,
    /// The way in metres that its wheels roll in one loop of `roll`.
    pub(crate) roll_m: f32,
    /// The loop that turns its wheels.
    pub(crate) roll: Option<ClipId>,
    /// The motions that open and close the driver's door.
    pub(crate) doors: Option<[ClipId; 2]>,
    /// The middle of the driver's seat, in metres.
    pub(crate) seat: [f32; 3],
    /// Where the driver stands before getting in, facing the vehicle: `[x, z]` in metres.
    pub(crate) entry: [f32; 2],
    /// The handle of the driver's door, and its hinge, in metres.
    pub(crate) handle: [f32; 3],
    pub(crate) hinge: [f32; 3],
}

/// Changes a character before it comes into a crowd.
pub type Prepare<'a> =
    dyn Fn(Character) -> Result<Arc<Character>, populace::character::Error> + Sync + 'a;

/// The props of a scene in a crowd.
#[derive(Clone, Debug)]
pub struct Stage {
    pub(crate) spots: Vec<SpotPlan>,
    pub(crate) leans: Vec<LeanPlan>,
    pub(crate) seats: Vec<SeatPlan>,
    pub(crate) vehicles: Vec<VehicleModel>,
    ground: Ground,
    lights: Vec<Light>,
    /// Things that people hold and wear, by kind.
    things: BTreeMap<String, Vec<CharacterId>>,
}

/// Lights that are shown by a member.
#[derive(Clone, Debug)]
struct Light {
    member: MemberId,
    crossing: usize,
    /// True for those that people look at.
    is_for_people: bool,
    /// The options of its lamps.
    lamps: Vec<(Lamp, usize)>,
    shown: Option<Lights>,
}

/// A prop, and the places in its own space that it offers.
struct Made {
    character: Arc<Character>,
    windows: Vec<([f32; 3], f32, [f32; 3])>,
    seats: Vec<([f32; 3], f32)>,
    /// The foot of a wall that faces +Z.
    wall: Option<[f32; 3]>,
    road: Option<Road>,
    lamps: Vec<(Lamp, usize)>,
}

impl Stage {
    /// Brings the props of a plan into a crowd, and sets the crowd's ground. `prepare` may change
    /// each character first, such as by adding levels of detail; it is called on all cores. `files`
    /// holds the characters of files, by their names in the plan.
    ///
    /// # Errors
    ///
    /// A kind that there is not, a file that is not among `files`, and errors of the crowd and of
    /// `prepare`.
    pub fn new(
        crowd: &mut Crowd,
        plan: &ScenePlan,
        files: &BTreeMap<String, Character>,
        prepare: &Prepare<'_>,
    ) -> Result<Self, Error> {
        let mut stage = Self {
            spots: plan.spots.clone(),
            leans: plan.leans.clone(),
            seats: plan.seats.clone(),
            vehicles: Vec::new(),
            ground: Ground::plane(plan.ground.height_m, [0.0; 2]).map_err(populace::Error::from)?,
            lights: Vec::new(),
            things: BTreeMap::new(),
        };
        let carry = |does: &BehaviourPlan| match does {
            BehaviourPlan::Stroll(stroll) => stroll.carry > 0.0,
            _ => false,
        };
        let parcel = plan.crowds.iter().any(|crowd| carry(&crowd.does)).then(|| PARCEL.to_owned());
        let strolls = |crowd: &CrowdPlan| matches!(crowd.does, BehaviourPlan::Stroll(_));
        let phone = plan.crowds.iter().any(strolls).then(|| PHONE.to_owned());
        let held = plan.casts.iter().flat_map(|cast| &cast.holds);
        for kind in held.chain(&parcel).chain(&phone) {
            if !stage.things.contains_key(kind) {
                stage.things.insert(kind.clone(), things(crowd, kind, files, prepare)?);
            }
        }
        let mut firsts: BTreeMap<Key, &PropPlan> = BTreeMap::new();
        for prop in &plan.props {
            firsts.entry(key(prop)).or_insert(prop);
        }
        let made = firsts.into_par_iter().map(|(key, prop)| Ok((key, make(prop, files, prepare)?)));
        let made: BTreeMap<Key, Made> = made.collect::<Result<_, Error>>()?;
        let mut ids: BTreeMap<&Key, CharacterId> = BTreeMap::new();
        for (key, made) in &made {
            ids.insert(key, crowd.add_character(Arc::clone(&made.character))?);
        }
        let mut roads = Vec::new();
        for prop in &plan.props {
            let key = key(prop);
            let Some((id, made)) = ids.get(&key).zip(made.get(&key)) else { continue };
            stage.put(crowd, prop, (*id, made))?;
            let placement = placement(prop);
            roads.extend(made.road.as_ref().map(|road| PlacedRoad { road, placement }));
        }
        if let Some(ground) = ground::of_roads(&roads, plan.ground.height_m)? {
            stage.ground = ground;
        }
        crowd.set_ground(&stage.ground)?;
        if !plan.lanes.is_empty() {
            stage.vehicles = vehicles(crowd, prepare)?;
        }
        Ok(stage)
    }

    /// The ground.
    #[must_use]
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// The characters of a kind of things, among which people choose.
    pub(crate) fn things(&self, kind: &str) -> &[CharacterId] {
        self.things.get(kind).map_or(&[], Vec::as_slice)
    }

    /// Lights the lamps of crossings, given the lights of each.
    ///
    /// # Errors
    ///
    /// A light that was despawned.
    pub fn light(
        &mut self,
        crowd: &mut Crowd,
        lights: impl Iterator<Item = Option<Lights>>,
    ) -> Result<(), Error> {
        let lights: Vec<_> = lights.collect();
        for light in &mut self.lights {
            let now = lights.get(light.crossing).copied().flatten();
            if now == light.shown {
                continue;
            }
            light.shown = now;
            let lit = now.map(|now| lit(now, light.is_for_people));
            let off = light.lamps.iter().filter(|(lamp, _)| lit != Some(*lamp));
            let look = off.fold(MemberLook::PLAIN, |look, (_, at)| look.without_option(*at));
            crowd.member_mut(light.member)?.set_look(look);
        }
        Ok(())
    }

    fn put(
        &mut self,
        crowd: &mut Crowd,
        prop: &PropPlan,
        (character, made): (CharacterId, &Made),
    ) -> Result<(), Error> {
        let placement = placement(prop);
        let member = crowd.spawn(character, placement)?;
        let world = placement.world_from_model();
        for (stand, yaw_rad, look_at) in &made.windows {
            let [x, _, z] = world.transform_point(*stand);
            let facing_deg = prop.facing_deg + yaw_rad.to_degrees();
            let look_at = world.transform_point(*look_at);
            self.spots.push(SpotPlan { at: [x, z], facing_deg, look_at });
        }
        if let Some([x, y, z]) = made.wall {
            let [x, _, z] = world.transform_point([x, y, z + populace_cast::LEAN_WALL_M]);
            self.leans.push(LeanPlan { at: [x, z], facing_deg: prop.facing_deg });
        }
        for (at, yaw_rad) in &made.seats {
            let facing_deg = prop.facing_deg + yaw_rad.to_degrees();
            self.seats.push(SeatPlan { at: world.transform_point(*at), facing_deg });
        }
        if let Some(crossing) = prop.crossing
            && !made.lamps.is_empty()
        {
            self.lights.push(Light {
                member,
                crossing,
                is_for_people: prop.kind == "walk_light",
                lamps: made.lamps.clone(),
                shown: None,
            });
            let off = made.lamps.iter();
            let look = off.fold(MemberLook::PLAIN, |look, (_, at)| look.without_option(*at));
            crowd.member_mut(member)?.set_look(look);
        }
        Ok(())
    }
}

/// Returns the lamp that is lit.
fn lit(lights: Lights, is_for_people: bool) -> Lamp {
    match (lights, is_for_people) {
        (Lights::Walk, true) => Lamp::Walk,
        (_, true) => Lamp::Stop,
        (Lights::Drive, false) => Lamp::Green,
        (Lights::ClearOfVehicles, false) => Lamp::Amber,
        (_, false) => Lamp::Red,
    }
}

/// What makes two props the same: kind or file, seed and sizes.
type Key = (String, u64, Vec<u32>);

fn key(prop: &PropPlan) -> Key {
    let sizes = prop.size_m.iter().map(|size| size.to_bits()).collect();
    let name = prop.file.as_ref().map_or_else(|| prop.kind.clone(), |file| format!("file {file}"));
    (name, prop.seed, sizes)
}

/// Makes a prop of a kind, or takes that of a file.
fn make(
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

/// Brings the things of a kind into a crowd, those that vary in some variants.
fn things(
    crowd: &mut Crowd,
    kind: &str,
    files: &BTreeMap<String, Character>,
    prepare: &Prepare<'_>,
) -> Result<Vec<CharacterId>, Error> {
    let mut all = Vec::new();
    for seed in 0..VARIANTS {
        let thing = match (kind, seed) {
            ("shield", _) => populace_props::shield(seed),
            ("helmet", _) => populace_props::helmet(seed),
            ("spear", 0) => populace_props::spear(),
            ("phone", 0) => populace_props::phone(),
            ("box", 0) => populace_props::box_parcel(),
            ("spear" | "phone" | "box", _) => break,
            (file, 0) => match files.get(file) {
                Some(character) => Ok(character.clone()),
                None => {
                    let kinds = THING_KINDS.map(str::to_owned);
                    return Err(Error::unknown("kind of thing to hold", file, kinds.iter()));
                }
            },
            _ => break,
        };
        let thing =
            prepare(thing.map_err(populace::Error::from)?).map_err(populace::Error::from)?;
        all.push(crowd.add_character(thing)?);
    }
    Ok(all)
}

fn placement(prop: &PropPlan) -> Placement {
    Placement::at(prop.at).facing(prop.facing_deg.to_radians())
}

/// Returns the plan of a road with a crossing in its middle: a zebra for an even seed, one with
/// signals for an odd one.
fn road_plan(seed: u64, length_m: f32, sidewalk_m: f32, parking_m: f32) -> RoadPlan {
    let kind = if seed.is_multiple_of(2) { CrossingKind::Zebra } else { CrossingKind::Signals };
    let crossing = Crossing { x_m: 0.0, width_m: 4.0, kind };
    RoadPlan { length_m, sidewalk_m, parking_m, crossings: vec![crossing] }
}

/// Brings the characters of vehicles into a crowd.
fn vehicles(crowd: &mut Crowd, prepare: &Prepare<'_>) -> Result<Vec<VehicleModel>, Error> {
    let mut models = Vec::new();
    let cars = VEHICLES.into_par_iter().map(|(kind, seed)| {
        let car = populace_props::car(kind, seed)?;
        Ok((prepare(car.character)?, car.plan))
    });
    let cars: Vec<_> =
        cars.collect::<Result<_, populace::character::Error>>().map_err(populace::Error::from)?;
    for (character, plan) in cars {
        let character = crowd.add_character(character)?;
        let clip = |name: &str| crowd.clip(character, name).ok();
        let [x, _, z] = plan.entry;
        models.push(VehicleModel {
            character,
            length_m: plan.length_m(),
            roll_m: TAU * plan.wheel_radius_m,
            roll: clip("Roll"),
            doors: clip("Door_Open").zip(clip("Door_Close")).map(|(open, close)| [open, close]),
            seat: plan.seat,
            entry: [x, z],
            handle: plan.door_handle,
            hinge: plan.door_hinge,
        });
    }
    Ok(models)
}
