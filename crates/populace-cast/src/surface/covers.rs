//! Cloth by region: which covers which part of a body, and how far from it.

use super::{Cover, PLAIN, Paint, Region};
use crate::{Bottom, Look, Top};

/// Distance of cloth from the body, as fractions of the body's height.
const TROUSERS_LIFT: f64 = 0.0016;
const SHIRT_LIFT: f64 = 0.0034;
const JACKET_LIFT: f64 = 0.0072;

/// Which cloth covers the trunk and the limbs.
pub(super) struct Covers {
    top: Top,
    /// Lowest row of the trunk that the top covers.
    hem: usize,
    /// The shirt under an open jacket, or the top itself.
    pub(super) shirt: Cover,
    pub(super) sleeve: Cover,
    pub(super) legs: Cover,
    /// Paint of the second colour of a top.
    second: Paint,
}

impl Covers {
    pub(super) fn of(look: &Look, height: f64) -> Self {
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
