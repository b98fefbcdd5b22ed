//! Columns in a clip's rows of the sixteen joints of a block. Twin of `kernels/rows.cl`.

use populace_device::layout::{BLOCK_CORRECTED, BLOCK_STRAIGHT, BoundBlock, BoundClip, ROW_FLOATS};
#[cfg(target_arch = "x86_64")]
use populace_device::layout::{NONE, ROW_PARTS};
use populace_model::Property;

use crate::encoding::{Encoding, Planes, Rows};
use crate::lanes::{LANES, Lanes, Simd};
#[cfg(target_arch = "x86_64")]
use crate::registers::Registers;
use crate::rows::{Columns, JointColumn, Joints, RowWidth};

/// Columns of the sixteen joints of a block: all in one block of columns and in the joints' order,
/// or scattered over several.
pub(crate) struct BlockColumns<'a> {
    joints: Joints<'a>,
    clip: &'a BoundClip,
    bound: &'a BoundBlock,
}

impl RowWidth for Lanes {
    type Columns<'a> = BlockColumns<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &'a BoundClip) -> BlockColumns<'a> {
        BlockColumns { joints: *joints, clip: bound, bound: joints.bound_block(bound) }
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

    /// Returns whether all columns are in one block, each in the lane of its joint.
    #[inline(always)]
    fn are_straight(&self) -> bool {
        self.bound.flags & BLOCK_STRAIGHT != 0
    }

    /// Returns whether all columns are straight 16-bit numbers, and need no correction.
    #[inline(always)]
    fn are_straight_halves(&self) -> bool {
        let rows = self.bound.rows();
        let lanes = rows.rotation_lanes | rows.translation_lanes | rows.scale_lanes;
        self.are_straight() && self.bound.flags & BLOCK_CORRECTED == 0 && lanes & ROW_FLOATS == 0
    }

    /// Returns the words of a component in two rows, and their encoding, of straight columns.
    #[inline(always)]
    fn straight(
        &self,
        planes: Planes,
        property: Property,
        at: &Rows,
        component: usize,
    ) -> (&'a [u32], &'a [u32], Encoding) {
        let (from, encoding) = planes.plane_at(property, at.from, component);
        let (to, _) = planes.plane_at(property, at.to, component);
        let rows = self.joints.tables.rows().as_slice();
        (&rows[from..from + LANES], &rows[to..to + LANES], encoding)
    }

    /// Iterates over the joints' own columns, with their lanes.
    #[inline(always)]
    fn columns(&self) -> impl Iterator<Item = (usize, JointColumn<'a>)> {
        let Joints { first, body, .. } = self.joints;
        let joints = first..(first + LANES).min(body.joint_count as usize);
        joints.map(|joint| JointColumn::of(&self.joints, self.clip, joint)).enumerate()
    }

    /// Reads components of any columns joint by joint.
    #[inline(always)]
    fn one_by_one<const COUNT: usize>(&self, property: Property, at: &Rows) -> [Lanes; COUNT] {
        let mut found = [Simd([0.0; LANES]); COUNT];
        for (lane, column) in self.columns() {
            if column.planes(property).are_still() {
                continue;
            }
            for (component, values) in found.iter_mut().enumerate() {
                values.0[lane] = column.parts(property, at, component);
            }
        }
        found
    }

    /// Collects the words of both planes of a property: of the first plane in both rows, then of
    /// the second. The second plane of translations and scales becomes lower halves. `None` if any
    /// column has floats.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn gathered(&self, property: Property, at: &Rows) -> Option<[[u32; LANES]; 4]> {
        if self.planes_of(property).are_floats() {
            return None;
        }
        let tables = self.joints.tables;
        let (rows, mut found) = (tables.rows().as_slice(), [[0; LANES]; 4]);
        let first = self.bound.source_first as usize;
        for source in &tables.sources().as_slice()[first..][..self.bound.source_count as usize] {
            let block = &tables.row_blocks().as_slice()[source.block as usize];
            let planes = Planes::of(block, property);
            if planes.are_still() {
                continue;
            }
            let lanes = &tables.source_lanes().as_slice()[source.lanes_first as usize..][..LANES];
            let places = [(at.from, 0), (at.to, 0), (at.from, 2), (at.to, 2)];
            for (words, (row, component)) in found.iter_mut().zip(places) {
                let (plane, encoding) = planes.plane_at(property, row, component);
                let plane = &rows[plane..][..LANES];
                let shift = usize::from(matches!(encoding, Encoding::Packed));
                for (word, &lane) in words.iter_mut().zip(lanes) {
                    // `NONE` gives some lane too, so that no index is out of bounds. Its word is
                    // not taken.
                    let from = lane as usize % LANES;
                    let found = plane[from >> shift] >> (16 * (from & shift));
                    *word = if lane == NONE { *word } else { found };
                }
            }
        }
        Some(found)
    }
}

impl Columns<Lanes> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        self.planes_of(property)
    }

    #[inline(always)]
    fn are_common(&self) -> bool {
        self.are_straight_halves()
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
        if !COMMON && !self.are_straight() {
            return self.one_by_one(property, at);
        }
        let planes = self.planes_of(property);
        let planes = if COMMON { planes.of_halves() } else { planes };
        let mut found = [Simd([0.0; LANES]); COUNT];
        for (component, values) in found.iter_mut().enumerate() {
            let (from, to, encoding) = self.straight(planes, property, at, component);
            *values = encoding.parts(from, to, at);
        }
        found
    }

    /// Returns a component of straight 16-bit numbers in registers.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn half_parts<R: Registers>(&self, property: Property, at: &Rows, component: usize) -> R {
        let planes = self.planes_of(property).of_halves();
        let (from, to, encoding) = self.straight(planes, property, at, component);
        match encoding {
            Encoding::HighHalf => R::mix_high(from, to, at.halves),
            Encoding::Packed => R::mix_packed(from, to, at.halves),
            // `of_halves` leaves no floats.
            Encoding::LowHalf | Encoding::Float => R::mix_low(from, to, at.halves),
        }
    }

    /// Returns a component of straight floats in registers.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn float_parts<R: Registers>(&self, property: Property, at: &Rows, component: usize) -> R {
        let (from, to, _) = self.straight(self.planes_of(property), property, at, component);
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
        self.are_straight_halves()
    }

    #[inline(always)]
    fn rotation<const COMMON: bool>(&self, at: &Rows) -> [R; 4] {
        let property = Property::Rotation;
        if COMMON || self.are_straight() && !self.planes_of(property).are_floats() {
            return [
                self.half_parts(property, at, 0),
                self.half_parts(property, at, 1),
                self.half_parts(property, at, 2),
                self.half_parts(property, at, 3),
            ];
        }
        if self.are_straight() {
            return [
                self.float_parts(property, at, 0),
                self.float_parts(property, at, 1),
                self.float_parts(property, at, 2),
                self.float_parts(property, at, 3),
            ];
        }
        let Some([xy, next_xy, zw, next_zw]) = self.gathered(property, at) else {
            let [x, y, z, w] = self.one_by_one(property, at);
            return [R::load(&x.0), R::load(&y.0), R::load(&z.0), R::load(&w.0)];
        };
        [
            R::mix_low(&xy, &next_xy, at.halves),
            R::mix_high(&xy, &next_xy, at.halves),
            R::mix_low(&zw, &next_zw, at.halves),
            R::mix_high(&zw, &next_zw, at.halves),
        ]
    }

    #[inline(always)]
    fn vector<const COMMON: bool>(&self, property: Property, at: &Rows) -> [R; 3] {
        if COMMON || self.are_straight() && !self.planes_of(property).are_floats() {
            return [
                self.half_parts(property, at, 0),
                self.half_parts(property, at, 1),
                self.half_parts(property, at, 2),
            ];
        }
        if self.are_straight() {
            return [
                self.float_parts(property, at, 0),
                self.float_parts(property, at, 1),
                self.float_parts(property, at, 2),
            ];
        }
        let Some([xy, next_xy, z, next_z]) = self.gathered(property, at) else {
            let [x, y, z] = self.one_by_one(property, at);
            return [R::load(&x.0), R::load(&y.0), R::load(&z.0)];
        };
        [
            R::mix_low(&xy, &next_xy, at.halves),
            R::mix_high(&xy, &next_xy, at.halves),
            R::mix_low(&z, &next_z, at.halves),
        ]
    }
}
