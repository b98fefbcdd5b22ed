//! Cars.

mod body;
mod cabin;
mod details;
mod shape;
mod wheels;

use glam::DVec3;
use populace_character::{Character, Error, Material};
use populace_model::convert::single;

use crate::build::{Builder, Finish, Solid, alpha, glass, glow, matt, metal, pane, satin};
use crate::dice::Dice;
use crate::hinge;
use shape::Shape;

pub use shape::CarKind;

/// Seat surface of the driver, in metres in the car's space: [`CarPlan::seat`] of all cars.
pub const DRIVER_SEAT: [f32; 3] = [0.38, 0.50, 0.05];

/// The turn of the open door, in radians about +Y. The free edge swings to +X.
pub const DOOR_TURN_RAD: f32 = -1.15;

/// Places of a car, in metres in its own space: it faces +Z, its left is +X, and its wheels stand
/// on y = 0. Traffic is right-hand: the driver sits on the left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarPlan {
    /// The z of its foremost point.
    pub front_m: f32,
    /// The z of its rearmost point.
    pub back_m: f32,
    /// Width without mirrors.
    pub width_m: f32,
    /// Height of the roof.
    pub height_m: f32,
    /// Radius of the wheels. A turn of the clip `Roll` is `TAU` times as far.
    pub wheel_radius_m: f32,
    /// The z of the front axle.
    pub front_axle_m: f32,
    /// The z of the rear axle.
    pub back_axle_m: f32,
    /// The middle of the surface on which the driver sits; the cushion yields around it.
    pub seat: [f32; 3],
    /// Height of the floor.
    pub floor_m: f32,
    /// Height of the roof's lower edge over the driver's door.
    pub roof_edge_m: f32,
    /// The point on the ground at which a person stands who gets in, facing -X.
    pub entry: [f32; 3],
    /// The handle of the driver's door while it is closed.
    pub door_handle: [f32; 3],
    /// The hinge of the driver's door, where the joint `Door` is.
    pub door_hinge: [f32; 3],
    /// The middle of the steering wheel, where the joint `SteeringWheel` is.
    pub steering_wheel: [f32; 3],
    /// Radius of the steering wheel.
    pub steering_radius_m: f32,
    /// Direction of the steering wheel's axis, of length 1, towards the driver.
    pub steering_axis: [f32; 3],
}

impl CarPlan {
    /// Length in metres.
    #[must_use]
    pub fn length_m(&self) -> f32 {
        self.front_m - self.back_m
    }
}

/// A car.
#[derive(Clone, Debug)]
pub struct Car {
    /// The car. Its joints are `WheelFrontLeft`, `WheelFrontRight`, `WheelBackLeft` and
    /// `WheelBackRight` at the hubs, `SteeringWheel`, and `Door` for the driver's. Its clips are
    /// `Roll`, one turn of the wheels in a second, which loops, and `Door_Open` and `Door_Close`,
    /// which play once in 0.8 s.
    pub character: Character,
    /// Its places.
    pub plan: CarPlan,
}

/// Returns a car. Its paint and rims follow from the seed. The material `Top paint` is the paint;
/// members may tint that region.
///
/// # Errors
///
/// Those of [`Character::new`]; no seed causes one.
pub fn car(kind: CarKind, seed: u64) -> Result<Car, Error> {
    let shape = Shape::new(kind);
    let mut dice = Dice::new(seed, 41);
    let mut b = Builder::new("car");
    let finishes = Finishes::new(&mut b, &mut dice);
    let rims = dice.below(3);
    let hinge = shape.hinge();
    let door = b.joint("Door", hinge, None);
    let wheel = b.joint("SteeringWheel", shape::wheel_middle(), None);
    cabin::build(&mut b, &shape, &finishes);
    cabin::steering(&mut b, &finishes, wheel);
    let mut panels = Panels::default();
    body::build(&mut panels, &shape, &finishes);
    cabin::shell(&mut panels, &shape, &finishes);
    details::build(&mut panels, &shape, &finishes);
    panels.flush(&mut b, door);
    wheels::build(&mut b, &shape, &finishes, rims);
    details::shadow(&mut b, &shape, &finishes);
    let mut clips = vec![hinge::roll(&wheels::NAMES)];
    clips.extend(hinge::clips("Door", f64::from(DOOR_TURN_RAD)));
    let character = b.build(clips)?;
    let high = character.rest_bounds().map_or(0.0, |bounds| bounds.high[1]);
    Ok(Car { plan: plan(&shape, high), character })
}

fn plan(shape: &Shape, height_m: f32) -> CarPlan {
    let narrow = |v: DVec3| v.to_array().map(single);
    let [x, _, z] = DRIVER_SEAT;
    CarPlan {
        front_m: single(shape.front_most()),
        back_m: single(shape.back_most()),
        width_m: single(2.0 * shape.half),
        height_m,
        wheel_radius_m: single(shape.wheel),
        front_axle_m: single(shape.axles[0]),
        back_axle_m: single(shape.axles[1]),
        seat: DRIVER_SEAT,
        floor_m: single(shape::FLOOR_M),
        roof_edge_m: single(shape.roof_side(f64::from(z)).y),
        entry: [x + 0.95, 0.0, z],
        door_handle: narrow(shape.handle()),
        door_hinge: narrow(shape.hinge()),
        steering_wheel: narrow(shape::wheel_middle()),
        steering_radius_m: single(shape::STEERING_M),
        steering_axis: narrow(shape::wheel_axis()),
    }
}

struct Finishes {
    paint: Finish,
    plastic: Finish,
    trim: Finish,
    lining: Finish,
    roof_lining: Finish,
    seat: Finish,
    glass: Finish,
    chrome: Finish,
    rim: Finish,
    tyre: Finish,
    head: Finish,
    tail: Finish,
    turn: Finish,
    plate: Finish,
    mirror: Finish,
    shadow: Finish,
}

impl Finishes {
    fn new(b: &mut Builder, dice: &mut Dice) -> Self {
        let paint = dice.pick([
            0xB8_2F2C, 0x2E_5C8A, 0xD6_D3CB, 0x3B_4046, 0x6E_8C86, 0xD9_A93C, 0x8E_9AA4, 0x2F_6B54,
            0xC9_6B3A, 0x6C_2B3A,
        ]);
        let paint = Material { roughness: 0.38, ..satin("Top paint", paint) };
        let seat = dice.pick([0x4A_4640, 0x8A_6E52, 0x3E_444C]);
        Self {
            // In the order in which they are drawn: outside first.
            paint: b.finish(paint),
            plastic: b.finish(satin("Plastic", 0x24_2628)),
            plate: b.finish(satin("Number plate", 0xE8_E6DC)),
            turn: b.finish(satin("Turn lamps", 0xD9_7A1C)),
            chrome: b.finish(metal("Chrome", 0xD8_DADC, 0.25)),
            trim: b.finish(satin("Black trim", 0x12_1314)),
            mirror: b.finish(pane("Mirror", 0xA8_BAC6)),
            rim: b.finish(metal("Rims", 0xB4_B8BC, 0.4)),
            tyre: b.finish(matt("Tyres", 0x1C_1C1D)),
            roof_lining: b.finish(matt("Roof lining", 0xA8_A49C)),
            seat: b.finish(matt("Seats", seat)),
            lining: b.finish(matt("Lining", 0x4A_4845)),
            head: b.finish(glow("Head lamps", 0xE8_EEF2, 0.25)),
            tail: b.finish(glow("Tail lamps", 0xB0_1A18, 0.35)),
            shadow: b.finish(alpha("Shadow", 0)),
            glass: b.finish(glass("Car glass", 0x2A_363A, 0.25)),
        }
    }
}

/// The joint that moves a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Hung {
    Body,
    Door,
}

/// Adds a face that need not be flat: two triangles, cut where they bend least.
fn bent(solid: &mut Solid, [a, b, c, d]: [DVec3; 4]) {
    let normal = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).normalize_or_zero();
    let cuts = [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]];
    let bend = |[one, other]: [[DVec3; 3]; 2]| {
        normal(one[0], one[1], one[2]).dot(normal(other[0], other[1], other[2]))
    };
    let cut = if bend(cuts[0]) + 1e-9 >= bend(cuts[1]) { cuts[0] } else { cuts[1] };
    for triangle in cut {
        solid.face(&triangle);
    }
}

/// Faces by what moves them and by their material, so that those that touch are smooth together.
#[derive(Default)]
struct Panels {
    solids: std::collections::BTreeMap<(Hung, Finish), Solid>,
}

impl Panels {
    fn of(&mut self, hung: Hung, finish: Finish) -> &mut Solid {
        self.solids.entry((hung, finish)).or_default()
    }

    /// Adds the cells between rows of points. Seen from outside, rows run to the right, and each
    /// lies above the one before. `of` returns what a cell is of; `None` leaves it out.
    fn cells(&mut self, rows: &[Vec<DVec3>], of: impl Fn(usize, usize) -> Option<(Hung, Finish)>) {
        for row in 1..rows.len() {
            let (below, above) = (&rows[row - 1], &rows[row]);
            for column in 1..below.len().min(above.len()) {
                if let Some((hung, finish)) = of(row - 1, column - 1) {
                    let corners =
                        [below[column - 1], below[column], above[column], above[column - 1]];
                    bent(self.of(hung, finish), corners);
                }
            }
        }
    }

    fn flush(self, b: &mut Builder, door: crate::build::Joint) {
        for ((hung, finish), solid) in self.solids {
            b.moved_by((hung == Hung::Door).then_some(door));
            b.on(finish).add(&solid, 32.0);
        }
        b.moved_by(None);
    }
}
