//! The dressed body: which cloth covers which part of it, and the options on its joints.

use super::{Cover, PLAIN, Paint, Region, Surface};
use super::{arm, collar, extras, hair, head, layers, leg, skirt, skull::Skull, trunk};
use crate::anatomy::{Body, Side};
use crate::{Bottom, Extra, Look, Top};

/// Distance of cloth from the body, as fractions of the body's height.
const TROUSERS_LIFT: f64 = 0.0016;
const SHIRT_LIFT: f64 = 0.0034;
const JACKET_LIFT: f64 = 0.0072;

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
    /// What the person always wears.
    pub(crate) body: Surface,
    /// The surface that touches the ground when the person lies: body and hair, without what gives
    /// way.
    pub(crate) touching: Surface,
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
        let mut touching = dressed(body);
        let mut dressed = touching.clone();
        collar::build(&mut dressed, body, &Covers::of(look, body.height));
        skirt::build(&mut dressed, body);
        for hair in items.iter().filter(|item| item.group == "hair").take(1) {
            touching.append(&hair.surface);
        }
        Self { body: dressed, touching, items }
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

/// Which cloth covers the trunk and the limbs.
pub(super) struct Covers {
    top: Top,
    /// Lowest row of the trunk that the top covers.
    hem: usize,
    /// What is worn under an open jacket, or the top itself.
    pub(super) shirt: Cover,
    pub(super) sleeve: Cover,
    pub(super) legs: Cover,
    /// Paint of the second colour of a top.
    second: Paint,
}

impl Covers {
    fn of(look: &Look, height: f64) -> Self {
        let cover = |region, lift: f64, paint: Paint| Cover { region, lift: lift * height, paint };
        let jacket = look.top == Top::Jacket;
        let shirt = cover(Region::Top, SHIRT_LIFT, if jacket { look.under_paint() } else { PLAIN });
        let sleeve = if jacket { cover(Region::Top, JACKET_LIFT, PLAIN) } else { shirt };
        let legs = match look.bottom {
            Bottom::Dress => cover(Region::Top, 0.0, PLAIN),
            Bottom::Skirt => cover(Region::Trousers, 0.0, PLAIN),
            Bottom::Trousers | Bottom::Shorts => cover(Region::Trousers, TROUSERS_LIFT, PLAIN),
        };
        let hem = match (look.bottom, look.top) {
            (Bottom::Dress | Bottom::Skirt, _) => 3,
            (_, Top::Shirt) => 2,
            _ => 1,
        };
        Self { top: look.top, hem, shirt, sleeve, legs, second: look.under_paint() }
    }

    /// Returns the cover above row `row` of the trunk, beside point `column` of a half ring.
    pub(super) fn trunk(&self, row: usize, column: usize) -> Cover {
        if row < self.hem {
            return self.legs;
        }
        // The jacket is open in front.
        if self.top == Top::Striped && (6..8).contains(&row) {
            return Cover { paint: self.second, ..self.shirt };
        }
        if self.top == Top::Jacket && column == 0 { self.shirt } else { self.sleeve }
    }
}
