//! Columns in a clip's rows of the sixteen joints of a block. Twin of `kernels/rows.cl`.

#[cfg(target_arch = "x86_64")]
use populace_device::layout::ROW_PARTS;
use populace_device::layout::{BoundBlock, BoundClip};
use populace_model::Property;

use crate::encoding::{Encoding, Planes, Rows};
use crate::lanes::{LANES, Lanes, Simd};
#[cfg(target_arch = "x86_64")]
use crate::registers::Registers;
use crate::rows::{Columns, Joints, RowWidth};

/// Columns of the sixteen joints of a block, each in the lane of its joint.
pub(crate) struct BlockColumns<'a> {
    rows: &'a [u32],
    bound: &'a BoundBlock,
}

impl RowWidth for Lanes {
    type Columns<'a> = BlockColumns<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &'a BoundClip) -> BlockColumns<'a> {
        BlockColumns { rows: joints.tables.rows().as_slice(), bound: joints.bound_block(bound) }
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> RowWidth for R {
    type Columns<'a> = BlockColumns<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &'a BoundClip) -> BlockColumns<'a> {
        <Lanes as RowWidth>::columns(joints, bound)
    }
}

impl<'a> BlockColumns<'a> {
    #[inline(always)]
    fn planes_of(&self, property: Property) -> Planes {
        Planes::of(&self.bound.rows(), property)
    }

    /// Returns whether all columns are 16-bit numbers.
    #[inline(always)]
    fn are_halves(&self) -> bool {
        !self.bound.has_floats()
    }

    /// Returns the words of a component in two rows, and their encoding.
    #[inline(always)]
    fn words(
        &self,
        planes: Planes,
        property: Property,
        at: &Rows,
        component: usize,
    ) -> (&'a [u32], &'a [u32], Encoding) {
        let (from, encoding) = planes.plane_at(property, at.from, component);
        let (to, _) = planes.plane_at(property, at.to, component);
        (&self.rows[from..from + LANES], &self.rows[to..to + LANES], encoding)
    }
}

impl Columns<Lanes> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        self.planes_of(property)
    }

    #[inline(always)]
    fn are_common(&self) -> bool {
        self.are_halves()
    }

    #[inline(always)]
    fn rotation<const COMMON: bool>(&self, at: &Rows) -> [Lanes; 4] {
        self.lanes::<COMMON, 4>(Property::Rotation, at)
    }

    #[inline(always)]
    fn vector<const COMMON: bool>(&self, property: Property, at: &Rows) -> [Lanes; 3] {
        self.lanes::<COMMON, 3>(property, at)
    }
}

impl BlockColumns<'_> {
    /// Returns components as plain lanes.
    #[inline(always)]
    fn lanes<const COMMON: bool, const COUNT: usize>(
        &self,
        property: Property,
        at: &Rows,
    ) -> [Lanes; COUNT] {
        let planes = self.planes_of(property);
        let planes = if COMMON { planes.of_halves() } else { planes };
        let mut found = [Simd([0.0; LANES]); COUNT];
        for (component, values) in found.iter_mut().enumerate() {
            let (from, to, encoding) = self.words(planes, property, at, component);
            *values = encoding.parts(from, to, at);
        }
        found
    }

    /// Returns a component of 16-bit numbers in registers.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn half_parts<R: Registers>(&self, property: Property, at: &Rows, component: usize) -> R {
        let planes = self.planes_of(property).of_halves();
        let (from, to, encoding) = self.words(planes, property, at, component);
        match encoding {
            Encoding::HighHalf => R::mix_high(from, to, at.halves),
            Encoding::Packed => R::mix_packed(from, to, at.halves),
            // `of_halves` leaves no floats.
            Encoding::LowHalf | Encoding::Float => R::mix_low(from, to, at.halves),
        }
    }

    /// Returns a component of floats in registers.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn float_parts<R: Registers>(&self, property: Property, at: &Rows, component: usize) -> R {
        let (from, to, _) = self.words(self.planes_of(property), property, at, component);
        let (from, to) = (R::load(bytemuck::cast_slice(from)), R::load(bytemuck::cast_slice(to)));
        from.mix(to, R::splat(at.between)) * R::splat(ROW_PARTS)
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> Columns<R> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        self.planes_of(property)
    }

    #[inline(always)]
    fn are_common(&self) -> bool {
        self.are_halves()
    }

    #[inline(always)]
    fn rotation<const COMMON: bool>(&self, at: &Rows) -> [R; 4] {
        let property = Property::Rotation;
        if COMMON || !self.planes_of(property).are_floats() {
            return [
                self.half_parts(property, at, 0),
                self.half_parts(property, at, 1),
                self.half_parts(property, at, 2),
                self.half_parts(property, at, 3),
            ];
        }
        [
            self.float_parts(property, at, 0),
            self.float_parts(property, at, 1),
            self.float_parts(property, at, 2),
            self.float_parts(property, at, 3),
        ]
    }

    #[inline(always)]
    fn vector<const COMMON: bool>(&self, property: Property, at: &Rows) -> [R; 3] {
        if COMMON || !self.planes_of(property).are_floats() {
            return [
                self.half_parts(property, at, 0),
                self.half_parts(property, at, 1),
                self.half_parts(property, at, 2),
            ];
        }
        [
            self.float_parts(property, at, 0),
            self.float_parts(property, at, 1),
            self.float_parts(property, at, 2),
        ]
    }
}
