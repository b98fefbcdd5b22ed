//! Lights for cars and for people.

use glam::{DAffine3, DVec3};
use populace_character::{Character, Error, PartOption};

use crate::build::{Builder, Finish, bevelled, extrude, glow, lathe, satin, turned};

/// A lamp of a light. Its lit glass is an option of the character, in the group `lamp`: members
/// hide the options of the lamps that are off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lamp {
    /// Cars wait.
    Red,
    /// Cars get ready, or stop if they can.
    Amber,
    /// Cars drive.
    Green,
    /// People wait.
    Stop,
    /// People walk.
    Walk,
}

impl Lamp {
    /// The lamps of [`traffic_light`], from the top down.
    pub const OF_CARS: [Self; 3] = [Self::Red, Self::Amber, Self::Green];
    /// The lamps of [`walk_light`], from the top down.
    pub const OF_PEOPLE: [Self; 2] = [Self::Stop, Self::Walk];

    /// The name of the node with the lamp's lit glass.
    #[must_use]
    pub const fn node_name(self) -> &'static str {
        match self {
            Self::Red => "Option:lamp:red",
            Self::Amber => "Option:lamp:amber",
            Self::Green => "Option:lamp:green",
            Self::Stop => "Option:lamp:stop",
            Self::Walk => "Option:lamp:walk",
        }
    }

    /// Returns the number of the lamp's option, by which looks hide it; `None` if the character has
    /// no such lamp.
    #[must_use]
    pub fn option_in(self, light: &Character) -> Option<usize> {
        let own = PartOption::of_node(self.node_name())?;
        light.options().iter().position(|option| *option == own)
    }

    fn color(self) -> u32 {
        match self {
            Self::Red | Self::Stop => 0xFF_2A1A,
            Self::Amber => 0xFF_A412,
            Self::Green | Self::Walk => 0x22_E06A,
        }
    }
}

/// Returns a light for cars on a pole 3.4 m high. It faces +Z, and all of its [`Lamp::OF_CARS`] are
/// lit until a member hides some.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn traffic_light() -> Result<Character, Error> {
    let mut b = Builder::new("traffic light");
    let case = b.finish(satin("Case", 0x1E_2322));
    let iron = b.finish(satin("Pole", 0x5A_6062));
    pole(&mut b, iron, 3.35);
    let middle = 2.85;
    b.on(case);
    b.flat(&bevelled([-0.16, middle - 0.47, 0.07], [0.16, middle + 0.47, 0.27], 0.02));
    b.flat(&bevelled([-0.23, middle - 0.54, 0.1], [0.23, middle + 0.54, 0.13], 0.01));
    for y in [middle - 0.38, middle + 0.34] {
        b.block([-0.03, y, 0.0], [0.03, y + 0.05, 0.1]);
    }
    for (nth, lamp) in (0_u32..).zip(Lamp::OF_CARS) {
        lens(&mut b, case, lamp, DVec3::new(0.0, middle + 0.3 - 0.3 * f64::from(nth), 0.27), 0.105);
    }
    b.build(Vec::new())
}

/// Returns a light for people on a pole 2.7 m high. It faces +Z; its lit lamps are a standing and a
/// walking person, [`Lamp::OF_PEOPLE`]. All are lit until a member hides one.
///
/// # Errors
///
/// Those of [`Character::new`]; it causes none.
pub fn walk_light() -> Result<Character, Error> {
    let mut b = Builder::new("walk light");
    let case = b.finish(satin("Case", 0x1E_2322));
    let iron = b.finish(satin("Pole", 0x5A_6062));
    let button = b.finish(satin("Button box", 0xE0_B02E));
    pole(&mut b, iron, 2.65);
    let middle = 2.3;
    b.on(case);
    b.flat(&bevelled([-0.15, middle - 0.31, 0.07], [0.15, middle + 0.31, 0.25], 0.02));
    b.block([-0.03, middle - 0.25, 0.0], [0.03, middle - 0.2, 0.08]);
    b.block([-0.03, middle + 0.2, 0.0], [0.03, middle + 0.25, 0.08]);
    for (nth, lamp) in (0_u32..).zip(Lamp::OF_PEOPLE) {
        let at = DVec3::new(0.0, middle + 0.145 - 0.29 * f64::from(nth), 0.25);
        lens(&mut b, case, lamp, at, 0.11);
    }
    b.node(None);
    b.on(button);
    b.flat(&bevelled([-0.06, 1.0, 0.05], [0.06, 1.2, 0.12], 0.015));
    b.on(case);
    b.block([-0.025, 1.04, 0.12], [0.025, 1.09, 0.13]);
    b.build(Vec::new())
}

fn pole(b: &mut Builder, iron: Finish, height: f64) {
    b.on(iron);
    let foot = [[0.11, 0.0], [0.11, 0.03], [0.075, 0.06], [0.07, 0.5], [0.055, 0.54]];
    b.add(&lathe(&foot, 12), 35.0);
    b.add(
        &lathe(&[[0.055, 0.5], [0.055, height], [0.04, height + 0.03], [0.0, height + 0.04]], 12),
        35.0,
    );
}

/// Adds a lamp that faces +Z, with the dark glass that is always there, and the lit one before it.
fn lens(b: &mut Builder, case: Finish, lamp: Lamp, at: DVec3, radius: f64) {
    b.node(None);
    b.at = DAffine3::from_translation(at);
    let [_, red, green, blue] = lamp.color().to_be_bytes();
    let dim = u32::from_be_bytes([0, red / 4, green / 4, blue / 4]);
    let dark = b.finish(satin("Dark lamp", dim));
    let disc = |z: f64, bow: f64, radius: f64| {
        let profile = [[radius, z], [0.6 * radius, z + 0.7 * bow], [0.0, z + bow]];
        turned(lathe(&profile, 14), DVec3::Y, DVec3::Z)
    };
    b.on(dark).add(&disc(0.0, 0.015, radius), 60.0);
    // A hood over the lamp: a half tube that is open below.
    let (outer, inner) = (radius + 0.018, radius + 0.006);
    let point = |r: f64, step: u32| {
        let (sin, cos) = (std::f64::consts::PI * (f64::from(step) / 8.0 * 1.2 - 0.1)).sin_cos();
        [r * cos, r * sin]
    };
    let mut outline: Vec<[f64; 2]> = (0..=8).map(|step| point(outer, step)).collect();
    outline.extend((0..=8).rev().map(|step| point(inner, step)));
    b.on(case).add(&extrude(&outline, 0.0, 0.13), 30.0);
    let lit = b.finish(glow("Lit lamp", lamp.color(), 1.6));
    b.node(Some(lamp.node_name()));
    b.on(lit);
    match lamp {
        Lamp::Red | Lamp::Amber | Lamp::Green => {
            b.add(&disc(0.004, 0.02, radius), 60.0);
        }
        Lamp::Stop | Lamp::Walk => figure(b, lamp == Lamp::Walk, radius),
    }
    b.node(None);
    b.home();
}

/// Adds a person that stands or walks.
fn figure(b: &mut Builder, walks: bool, size: f64) {
    let mut draw = |outline: &[[f64; 2]]| {
        let scaled: Vec<[f64; 2]> = outline.iter().map(|p| p.map(|v| v * size)).collect();
        b.flat(&extrude(&scaled, 0.016, 0.022));
    };
    let head = |x: f64| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|k| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
            [x + 0.14 * cos, 0.7 + 0.14 * sin]
        })
    };
    if walks {
        draw(&head(0.08));
        draw(&[[-0.06, 0.52], [0.16, 0.52], [0.12, -0.05], [-0.12, -0.05]]);
        draw(&[
            [-0.12, -0.05],
            [0.06, -0.05],
            [-0.2, -0.45],
            [-0.42, -0.8],
            [-0.56, -0.72],
            [-0.34, -0.4],
        ]);
        draw(&[
            [-0.04, -0.05],
            [0.13, -0.05],
            [0.3, -0.38],
            [0.42, -0.8],
            [0.26, -0.82],
            [0.14, -0.42],
        ]);
        draw(&[[0.12, 0.5], [0.2, 0.46], [0.42, 0.12], [0.34, 0.04]]);
        draw(&[[-0.06, 0.5], [0.0, 0.4], [-0.26, 0.02], [-0.36, 0.1]]);
    } else {
        draw(&head(0.0));
        draw(&[[-0.22, 0.52], [0.22, 0.52], [0.16, -0.05], [-0.16, -0.05]]);
        draw(&[[-0.16, -0.05], [-0.02, -0.05], [-0.02, -0.82], [-0.16, -0.82]]);
        draw(&[[0.02, -0.05], [0.16, -0.05], [0.16, -0.82], [0.02, -0.82]]);
        draw(&[[-0.24, 0.5], [-0.36, 0.44], [-0.33, -0.12], [-0.23, -0.12]]);
        draw(&[[0.24, 0.5], [0.23, -0.12], [0.33, -0.12], [0.36, 0.44]]);
    }
}
