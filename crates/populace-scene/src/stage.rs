//! The stage of a scene: its props in a crowd, and what they offer to people.

use std::collections::BTreeMap;
use std::sync::Arc;

use populace::character::Character;
use populace::{CharacterId, Crowd, Ground, MemberId, MemberLook, Placement};
use populace_props::Lamp;
use rayon::prelude::*;

use self::ground::PlacedRoad;
use self::props::{Key, Made, key, make};
use self::things::things;
use self::vehicles::vehicles;
use crate::Error;
use crate::plan::{BehaviourPlan, CrowdPlan, LeanPlan, PropPlan, ScenePlan, SeatPlan, SpotPlan};

pub use self::props::PROP_KINDS;
pub use self::things::THING_KINDS;
pub(crate) use self::things::{Bearer, PARCEL, PHONE};
pub(crate) use self::vehicles::VehicleModel;

mod ground;
mod props;
mod things;
mod vehicles;

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

fn placement(prop: &PropPlan) -> Placement {
    Placement::at(prop.at).facing(prop.facing_deg.to_radians())
}
