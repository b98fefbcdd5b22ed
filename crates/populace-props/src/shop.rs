//! Houses with a shop on the ground floor.

mod facade;
mod front;
mod goods;
mod roof;
mod signs;
mod style;

use glam::DVec3;
use populace_character::{Character, Error};
use populace_model::convert::single;

use crate::build::{Builder, plate};
use crate::hinge;
use style::{Finishes, Style};

/// Depth of a house in metres, from its front to its back.
pub const HOUSE_DEPTH_M: f32 = 8.0;

/// Distance in metres from the glass at which people stand who look in.
const LOOK_M: f64 = 0.7;

/// A place from which a person looks into a shop window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShopWindow {
    /// The point on the ground, in metres: 0.7 m in front of the glass.
    pub stand: [f32; 3],
    /// Heading in radians about +Y of a person who faces the glass.
    pub yaw_rad: f32,
    /// A point on display behind the glass, at which the person looks.
    pub look_at: [f32; 3],
}

/// A house with a shop.
#[derive(Clone, Debug)]
pub struct Shopfront {
    /// The house: the front at z = 0 faces +Z, its foot at y = 0, its middle at x = 0. Goods can be
    /// seen behind the shop's glass. The joint `Door` turns the shop's door; the clips `Door_Open`
    /// and `Door_Close` play once, in 0.8 s.
    pub character: Character,
    /// Width in metres.
    pub width_m: f32,
    /// Places to look into the window, from left to right as seen by them.
    pub windows: Vec<ShopWindow>,
    /// The point on the ground in front of the door, in metres, 0.9 m from it.
    pub door: [f32; 3],
    /// The door's handle, in metres, while it is closed.
    pub door_handle: [f32; 3],
    /// The foot of the wall's pier at the left end, seen from the house, in metres. It is flat, and
    /// as wide as a back with the pier of the house beside.
    pub pier: [f32; 3],
}

/// Returns a house of three or four storeys with a shop. Walls, roof, goods, sign and awning follow
/// from the seed. `width_m` is kept from 5 to 12 m; anything else counts as the nearest of these,
/// and NaN as 7 m.
///
/// The material `Top wall` is the wall's, and `Trousers joinery` that of the shop's wood; members
/// may tint these regions.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn shopfront(seed: u64, width_m: f32) -> Result<Shopfront, Error> {
    let width = if width_m.is_nan() { 7.0 } else { f64::from(width_m).clamp(5.0, 12.0) };
    let style = Style::new(seed, width);
    let mut b = Builder::new("shopfront");
    let finishes = Finishes::new(&mut b, &style);
    facade::build(&mut b, &style, &finishes);
    roof::build(&mut b, &style, &finishes);
    front::build(&mut b, &style, &finishes);
    goods::build(&mut b, &style, &finishes);
    shell(&mut b, &style, &finishes);
    let windows = style.shop_panes().into_iter().flat_map(spots).collect();
    let door = [style.door_middle(), 0.0, front::GLASS_Z + 0.9].map(single);
    let door_handle = front::handle(&style).to_array().map(single);
    let clips = hinge::clips(front::DOOR, hinge_turn(&style));
    let character = b.build(clips)?;
    let pier = [single(0.5 * width), 0.0, 0.0];
    Ok(Shopfront { character, width_m: single(width), windows, door, door_handle, pier })
}

/// Returns places to look through a pane, at least 0.6 m apart.
fn spots([from, to]: [f64; 2]) -> Vec<ShopWindow> {
    let wide = to - from;
    let fractions: &[f64] = if wide < 1.1 { &[0.5] } else { &[0.25, 0.75] };
    let spot = |fraction: &f64| {
        let x = from + wide * fraction;
        ShopWindow {
            stand: [x, 0.0, front::GLASS_Z + LOOK_M].map(single),
            yaw_rad: std::f32::consts::PI,
            look_at: [x, 1.15, front::GLASS_Z - 0.35].map(single),
        }
    };
    fractions.iter().map(spot).collect()
}

/// The turn of the open door in radians about +Y: inwards.
fn hinge_turn(style: &Style) -> f64 {
    // The hinge is on the side of the house's end.
    if style.door_left { -1.4 } else { 1.4 }
}

/// Adds the walls at the sides and at the back.
fn shell(b: &mut Builder, style: &Style, finishes: &Finishes) {
    let (half, top, back) = (0.5 * style.width, style.wall_top(), -f64::from(HOUSE_DEPTH_M));
    b.on(finishes.side).faded([0.0, 4.0], [0.8, 1.0]);
    b.flat(&plate(&[[half, 0.0, 0.0], [half, 0.0, back], [half, top, back], [half, top, 0.0]]));
    b.flat(&plate(&[[-half, 0.0, back], [-half, 0.0, 0.0], [-half, top, 0.0], [-half, top, back]]));
    b.flat(&plate(&[[half, 0.0, back], [-half, 0.0, back], [-half, top, back], [half, top, back]]));
    let at = |x: f64, y: f64| DVec3::new(x, y, back - 0.01);
    b.on(finishes.pane);
    for storey in 0..=style.storeys {
        for side in [-0.25, 0.25] {
            let (x, y) = (side * style.width, 1.1 + 3.2 * f64::from(storey));
            let corners =
                [at(x + 0.5, y), at(x - 0.5, y), at(x - 0.5, y + 1.4), at(x + 0.5, y + 1.4)];
            b.flat(&plate(&corners.map(|c| c.to_array())));
        }
    }
}
