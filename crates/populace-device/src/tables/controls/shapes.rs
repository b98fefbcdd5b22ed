//! Shapes of constraint programs: a number for each, so that members with programs of one shape are
//! found by comparing numbers.

use std::collections::HashMap;
use std::sync::Arc;

use populace_model::convert::u32_from;

use crate::layout::NONE;

/// The shapes of all programs in use.
#[derive(Clone, Debug, Default)]
pub(super) struct Shapes {
    numbers: HashMap<Arc<[u32]>, u32>,
    /// Each shape and the number of programs that have it, by number.
    used: Vec<(Arc<[u32]>, usize)>,
    /// Numbers of no shape.
    free: Vec<u32>,
}

impl Shapes {
    /// Counts a program of a shape, and returns the shape's number.
    pub(super) fn take(&mut self, shape: &[u32]) -> u32 {
        if let Some(number) = self.numbers.get(shape) {
            self.used[*number as usize].1 += 1;
            return *number;
        }
        let shape: Arc<[u32]> = shape.into();
        let entry = (Arc::clone(&shape), 1);
        let number = if let Some(number) = self.free.pop() {
            self.used[number as usize] = entry;
            number
        } else {
            self.used.push(entry);
            u32_from(self.used.len() - 1)
        };
        self.numbers.insert(shape, number);
        number
    }

    /// Counts one program of a shape less. A number that nobody uses is given to another shape.
    /// Does nothing for [`NONE`].
    pub(super) fn release(&mut self, number: u32) {
        if number == NONE {
            return;
        }
        let (shape, count) = &mut self.used[number as usize];
        *count -= 1;
        if *count == 0 {
            self.numbers.remove(shape);
            self.free.push(number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Shapes;

    #[test]
    fn equal_shapes_share_a_number_as_long_as_somebody_uses_it() {
        let mut shapes = Shapes::default();
        let (one, other) = (shapes.take(&[1, 2]), shapes.take(&[1]));
        assert_ne!(one, other);
        assert_eq!(shapes.take(&[1, 2]), one);
        shapes.release(one);
        assert_eq!(shapes.take(&[1, 2]), one);
        shapes.release(one);
        shapes.release(one);
        assert_eq!(shapes.take(&[3]), one);
        assert_ne!(shapes.take(&[1, 2]), one);
    }
}
