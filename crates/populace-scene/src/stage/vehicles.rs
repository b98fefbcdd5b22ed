//! The vehicles of lanes and bays.

use std::f32::consts::TAU;

use populace::{CharacterId, ClipId, Crowd};
use populace_props::CarKind;
use rayon::prelude::*;

use super::Prepare;
use crate::Error;

/// Kinds and seeds of the vehicles of lanes and bays.
const VEHICLES: [(CarKind, u64); 6] = [
    (CarKind::Hatchback, 1),
    (CarKind::Saloon, 2),
    (CarKind::Hatchback, 3),
    (CarKind::Van, 4),
    (CarKind::Saloon, 5),
    (CarKind::Hatchback, 6),
];

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

/// Brings the characters of vehicles into a crowd.
pub(super) fn vehicles(
    crowd: &mut Crowd,
    prepare: &Prepare<'_>,
) -> Result<Vec<VehicleModel>, Error> {
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
