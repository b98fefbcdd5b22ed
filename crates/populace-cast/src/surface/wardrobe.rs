//! The dressed body: which cloth covers which part of it, and the options on its joints.

use glam::DVec3;

use super::covers::Covers;
use super::{Region, Surface};
use super::{arm, collar, extras, hair, head, layers, leg, skirt, skull::Skull, trunk};
use crate::Extra;
use crate::anatomy::{Body, Limb, Side};

/// A part that can be hidden or swapped: hair, hats, glasses and bags.
#[derive(Clone, Debug)]
pub(crate) struct Item {
    /// Of all items in one group at most one is worn.
    pub(crate) group: &'static str,
    pub(crate) name: &'static str,
    pub(crate) region: Region,
    /// Linear base colour.
    pub(crate) color: [f32; 3],
    pub(crate) surface: Surface,
}

/// A dressed body and its options.
#[derive(Clone, Debug)]
pub(crate) struct Wardrobe {
    /// The body with the clothes that are always worn.
    pub(crate) body: Surface,
    /// Worn options, and others after them if they were asked for.
    pub(crate) items: Vec<Item>,
}

impl Wardrobe {
    /// Dresses a body in what its look wears, and in all other options if `all`.
    pub(crate) fn of(body: &Body, all: bool) -> Self {
        let look = &body.look;
        let spare = if all { look.spare.as_slice() } else { &[] };
        let extras = look.worn().into_iter().chain(spare.iter().copied());
        let items: Vec<Item> = extras.map(|extra| item(body, extra)).collect();
        let mut dressed = dressed(body);
        collar::build(&mut dressed, body, &Covers::of(look, body.height));
        skirt::build(&mut dressed, body);
        Self { body: dressed, items }
    }

    /// Returns how far a skirt is before the model's origin above a thigh at a height, all in
    /// metres. 0 without a skirt.
    pub(crate) fn lap(body: &Body, y: f64) -> f64 {
        let mut cloth = Surface::default();
        skirt::build(&mut cloth, body);
        let hip = body.joint(Limb::Thigh, Side::Left);
        let near = |p: &&DVec3| {
            (p.x - hip.x).abs() < 0.04 * body.height && (p.y - y).abs() < 0.09 * body.height
        };
        cloth.points.iter().filter(near).map(|p| p.z).fold(0.0, f64::max)
    }

    /// Returns the surface with which a person touches the ground or a seat: body and hair, without
    /// what gives way.
    pub(crate) fn touching(body: &Body) -> Surface {
        let mut touching = dressed(body);
        touching.append(&item(body, Extra::Hair(body.look.hair)).surface);
        touching
    }
}

/// Returns the part of an option.
fn item(body: &Body, extra: Extra) -> Item {
    let look = &body.look;
    let [group, name] = extra.names();
    let skull = Skull { body };
    let (region, color, surface) = match extra {
        Extra::Hair(crate::Hair::Headscarf) => {
            (Region::Accessory, look.colors.accessory, extras::headscarf(skull))
        }
        Extra::Hair(cut) => (Region::Hair, look.colors.hair, hair::build(skull, cut)),
        Extra::Hat(hat) => (Region::Accessory, look.colors.accessory, extras::hat(skull, hat)),
        Extra::Glasses(glasses) => {
            (Region::Accessory, [0.02, 0.018, 0.02], extras::glasses(skull, glasses))
        }
        Extra::Bag(bag) => (Region::Accessory, look.colors.bag, extras::bag(body, bag)),
    };
    Item { group, name, region, color, surface }
}

/// Returns the body in close-fitting clothes.
fn dressed(body: &Body) -> Surface {
    let covers = Covers::of(&body.look, body.height);
    let mut base = Surface::default();
    let trunk = trunk::build(&mut base, body, &covers);
    for (opening, side) in trunk.arms.iter().zip(Side::BOTH) {
        arm::build(&mut base, body, &covers, side, opening);
    }
    for (opening, side) in trunk.legs.iter().zip(Side::BOTH) {
        leg::build(&mut base, body, &covers, side, opening);
    }
    let mut surface = layers::lifted(&base);
    head::build(&mut surface, body);
    surface
}
