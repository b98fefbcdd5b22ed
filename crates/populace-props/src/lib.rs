//! Things made by code for scenes of crowds: a street's houses, road, furniture, trees, lights and
//! vehicles; a stand; arms. No asset files are needed.
//!
//! Spaces and units are those of [`populace_model`]: metres, Y up. Everything faces +Z and stands on
//! y = 0 unless its function says otherwise. Each thing is a
//! [`Character`](populace_character::Character): members of a crowd show it, play its clips and tint
//! it. Equal seeds give equal data.
//!
//! ```
//! use populace_props::{CarKind, RoadPlan, car, road, shopfront};
//!
//! let road = road(&RoadPlan::default())?;
//! // Houses stand at the back of the sidewalks; those at +Z are turned about.
//! let front_m = road.front_m();
//! let house = shopfront(7, 6.5)?;
//! let looker = house.windows[0];
//! assert!(looker.stand[2] - front_m < 1.0);
//! // People walk at the height of the surface.
//! assert_eq!(road.height_m(20.0, 0.0), -populace_props::KERB_M);
//! // A car tells where its driver sits, and where the door's handle is.
//! let car = car(CarKind::Saloon, 1)?;
//! assert!(car.plan.door_handle[0] > car.plan.seat[0]);
//! assert!(car.character.clips.iter().any(|clip| clip.name() == "Door_Open"));
//! # Ok::<(), populace_character::Error>(())
//! ```
//!
//! Colours. The names of materials that members may tint start with the name of a
//! [`Region`](populace_character::Region): `Top paint` of a car, `Top wall`, `Trousers joinery` and
//! `Accessory awning` of a house. A tint multiplies the colour that the seed gave.
//!
//! Lights are options of a character, as hats of people are: see [`Lamp`].

mod arms;
mod build;
mod car;
mod dice;
mod furniture;
mod hinge;
mod images;
mod leaves;
mod lights;
mod road;
mod shop;
mod stand;

pub use arms::{PARCEL_WIDTH_M, SPEAR_GRIP_M, SPEAR_M, box_parcel, helmet, phone, shield, spear};
pub use car::{Car, CarKind, CarPlan, DOOR_TURN_RAD, DRIVER_SEAT, car};
pub use furniture::{
    SEAT_M, SeatPoint, Seating, bench, bin, bollard, cafe_table, planter, street_lamp,
};
pub use leaves::tree;
pub use lights::{Lamp, traffic_light, walk_light};
pub use road::{Crossing, CrossingKind, KERB_M, LANE_M, Road, RoadPlan, road};
pub use shop::{HOUSE_DEPTH_M, ShopWindow, Shopfront, shopfront};
pub use stand::{GroundKind, SEAT_WIDTH_M, STEP_M, STEP_RISE_M, Stand, ground, stand};
