//! Things made by code for scenes of crowds.

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

pub use arms::{SPEAR_GRIP_M, SPEAR_M, box_parcel, helmet, phone, shield, spear};
pub use car::{Car, CarKind, CarPlan, DOOR_TURN_RAD, DRIVER_SEAT, car};
pub use furniture::{
    SEAT_M, SeatPoint, Seating, bench, bin, bollard, cafe_table, planter, street_lamp,
};
pub use leaves::tree;
pub use lights::{Lamp, traffic_light, walk_light};
pub use road::{Crossing, CrossingKind, KERB_M, LANE_M, Road, RoadPlan, road};
pub use shop::{HOUSE_DEPTH_M, ShopWindow, Shopfront, shopfront};
pub use stand::{GroundKind, SEAT_WIDTH_M, STEP_M, STEP_RISE_M, Stand, ground, stand};
