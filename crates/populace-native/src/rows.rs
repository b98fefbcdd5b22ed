//! Components of local transforms from a clip's rows, for one joint or for sixteen neighbouring
//! ones. Twin of `kernels/rows.cl`.
//!
//! A component is `offset + step * n`, where `n` is what a row holds. Joints that the clip does not
//! drive, or that do not move in it, have a step of 0, so the arithmetic is the same for all.

use populace_device::Tables;
use populace_device::layout::{
    BLOCK_STRAIGHT, Body, BoundBlock, BoundClip, JOINT_BLOCK, MAP_COLUMN, MAP_ROTATION, MAP_SCALE,
    MAP_TRANSLATION, NONE, ROW_FLOATS, RowBlock, SlotSample,
};
use populace_model::Property;
use populace_model::math::Real;

use crate::lanes::{LANES, Lanes, Load, Simd};
#[cfg(target_arch = "x86_64")]
use crate::registers::Registers;

/// Joints computed together: those of one [`Width`] from `first` on.
#[derive(Clone, Copy)]
pub(crate) struct Joints<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) body: &'a Body,
    pub(crate) first: usize,
}

impl<'a> Joints<'a> {
    /// Returns where the block of sixteen joints finds its columns in a clip's rows.
    #[inline(always)]
    pub(crate) fn bound_block(&self, bound: &BoundClip) -> &'a BoundBlock {
        &self.tables.bound_blocks().as_slice()[bound.block_first as usize + self.first / LANES]
    }

    /// Returns stored floats from the first joint's on.
    #[inline(always)]
    pub(crate) fn planes(&self, poses_first: u32) -> &'a [f32] {
        &self.tables.poses().as_slice()[poses_first as usize + self.first..]
    }
}

/// A width that finds its columns in a clip's rows.
pub(crate) trait RowWidth: Load {
    /// Positions of the columns.
    type Columns<'a>: Columns<Self>;

    /// Finds the columns of the joints.
    fn columns<'a>(joints: &Joints<'a>, bound: &BoundClip) -> Self::Columns<'a>;
}

/// Positions in a clip's rows of the columns of joints computed together.
pub(crate) trait Columns<R> {
    /// Returns the position of a property's planes.
    fn planes(&self, property: Property) -> Planes;

    /// Returns a component between two rows, in steps.
    fn steps(&self, property: Property, at: &SlotSample, component: usize) -> R;
}

/// Position of a property's planes in a row.
#[derive(Clone, Copy)]
pub(crate) struct Planes {
    /// First word; [`NONE`] if the property does not move.
    first: u32,
    /// Words from one plane to the next, and [`ROW_FLOATS`] if components are floats.
    lanes: u32,
}

impl Planes {
    #[inline(always)]
    fn of(block: &RowBlock, property: Property) -> Self {
        let (first, lanes) = match property {
            Property::Rotation => (block.rotation_first, block.rotation_lanes),
            Property::Translation => (block.translation_first, block.translation_lanes),
            Property::Scale => (block.scale_first, block.scale_lanes),
        };
        Self { first, lanes }
    }

    /// Returns whether the property does not move.
    #[inline(always)]
    pub(crate) fn are_still(self) -> bool {
        self.first == NONE
    }

    /// Returns the first word of the plane that holds a component, and its encoding.
    #[inline(always)]
    fn plane_at(self, property: Property, row: u32, component: usize) -> (usize, Encoding) {
        let start = (row + self.first) as usize;
        let lanes = (self.lanes & !ROW_FLOATS) as usize;
        if self.lanes & ROW_FLOATS != 0 {
            return (start + component * lanes, Encoding::Float);
        }
        let encoding = match component {
            2 if property != Property::Rotation => Encoding::Packed,
            0 | 2 => Encoding::LowHalf,
            _ => Encoding::HighHalf,
        };
        (start + component / 2 * lanes, encoding)
    }
}

/// Encoding of a component in its plane.
#[derive(Clone, Copy)]
enum Encoding {
    Float,
    /// The low 16 bits of each lane's word.
    LowHalf,
    /// The high 16 bits of each lane's word.
    HighHalf,
    /// 16 bits for each lane, two lanes in a word.
    Packed,
}

impl Encoding {
    /// Decodes a lane's steps from a plane.
    #[inline(always)]
    fn steps_in(self, plane: &[u32], lane: usize) -> f32 {
        #[expect(
            clippy::cast_possible_wrap,
            reason = "16 bits fit; processors convert signed numbers faster"
        )]
        let half = |word: u32| (word & 0xffff) as i32 as f32;
        match self {
            Self::Float => f32::from_bits(plane[lane]),
            Self::LowHalf => half(plane[lane]),
            Self::HighHalf => half(plane[lane] >> 16),
            Self::Packed => half(plane[lane / 2] >> (16 * (lane % 2))),
        }
    }

    /// Decodes sixteen lanes between two planes.
    #[inline(always)]
    fn between(self, from: &[u32], to: &[u32], between: f32) -> Lanes {
        Lanes::from_fn(|lane| self.steps_in(from, lane))
            .mix(Lanes::from_fn(|lane| self.steps_in(to, lane)), Lanes::splat(between))
    }
}

/// Column of one joint.
pub(crate) struct JointColumn<'a> {
    rows: &'a [u32],
    block: RowBlock,
    lane: usize,
}

impl RowWidth for f32 {
    type Columns<'a> = JointColumn<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &BoundClip) -> JointColumn<'a> {
        let tables = joints.tables;
        let map = tables.joint_maps().as_slice()[bound.map_first as usize + joints.first];
        let column = map & MAP_COLUMN;
        let block = (bound.row_block_first + column / JOINT_BLOCK) as usize;
        let mut block = tables.row_blocks().as_slice()[block];
        for (flag, first) in [
            (MAP_ROTATION, &mut block.rotation_first),
            (MAP_TRANSLATION, &mut block.translation_first),
            (MAP_SCALE, &mut block.scale_first),
        ] {
            if map & flag == 0 {
                *first = NONE;
            }
        }
        JointColumn { rows: tables.rows().as_slice(), block, lane: (column % JOINT_BLOCK) as usize }
    }
}

impl Columns<f32> for JointColumn<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.block, property)
    }

    #[inline(always)]
    fn steps(&self, property: Property, at: &SlotSample, component: usize) -> f32 {
        let [from, to] = [at.row0, at.row1].map(|row: u32| {
            let (plane, encoding) = self.planes(property).plane_at(property, row, component);
            encoding.steps_in(&self.rows[plane..], self.lane)
        });
        from.mix(to, at.between)
    }
}

/// Columns of the sixteen joints of a block: all in one block of columns and in the joints' order,
/// or scattered over several.
pub(crate) struct BlockColumns<'a> {
    tables: &'a Tables,
    bound: &'a BoundBlock,
}

impl RowWidth for Lanes {
    type Columns<'a> = BlockColumns<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &BoundClip) -> BlockColumns<'a> {
        BlockColumns { tables: joints.tables, bound: joints.bound_block(bound) }
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> RowWidth for R {
    type Columns<'a> = BlockColumns<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &BoundClip) -> BlockColumns<'a> {
        <Lanes as RowWidth>::columns(joints, bound)
    }
}

impl<'a> BlockColumns<'a> {
    /// Iterates over the blocks of columns, with each joint's lane in them ([`NONE`] if the joint's
    /// column is in another one).
    #[inline(always)]
    fn sources(&self) -> impl Iterator<Item = (RowBlock, &'a [u32])> + use<'a> {
        let tables = self.tables;
        let first = self.bound.source_first as usize;
        let sources = &tables.sources().as_slice()[first..first + self.bound.source_count as usize];
        sources.iter().map(|source| {
            let lanes = &tables.source_lanes().as_slice()[source.lanes_first as usize..];
            (tables.row_blocks().as_slice()[source.block as usize], &lanes[..LANES])
        })
    }

    /// Collects each joint's steps from the block of columns that has it.
    #[inline(never)]
    fn gathered_steps(&self, property: Property, at: &SlotSample, component: usize) -> Lanes {
        let mut found = [[0.0; LANES]; 2];
        for (block, lanes) in self.sources() {
            let planes = Planes::of(&block, property);
            if planes.are_still() {
                continue;
            }
            for (found, row) in found.iter_mut().zip([at.row0, at.row1]) {
                let (plane, encoding) = planes.plane_at(property, row, component);
                let plane = &self.tables.rows().as_slice()[plane..];
                for (value, &lane) in found.iter_mut().zip(lanes) {
                    if lane != NONE {
                        *value = encoding.steps_in(plane, lane as usize);
                    }
                }
            }
        }
        let [from, to] = found.map(Simd);
        from.mix(to, Simd::splat(at.between))
    }
}

impl BlockColumns<'_> {
    /// Returns a component's words in two rows, and their encoding; `None` if the columns are
    /// scattered.
    #[inline(always)]
    fn straight(
        &self,
        property: Property,
        at: &SlotSample,
        component: usize,
    ) -> Option<(&[u32], &[u32], Encoding)> {
        if self.bound.flags & BLOCK_STRAIGHT == 0 {
            return None;
        }
        let planes = Planes::of(&self.bound.rows(), property);
        let (from, encoding) = planes.plane_at(property, at.row0, component);
        let (to, _) = planes.plane_at(property, at.row1, component);
        let rows = self.tables.rows().as_slice();
        Some((&rows[from..from + LANES], &rows[to..to + LANES], encoding))
    }
}

impl Columns<Lanes> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.bound.rows(), property)
    }

    #[inline(always)]
    fn steps(&self, property: Property, at: &SlotSample, component: usize) -> Lanes {
        let Some((from, to, encoding)) = self.straight(property, at, component) else {
            return self.gathered_steps(property, at, component);
        };
        // One branch holds all that depends on the encoding, so that its values stay in registers.
        match encoding {
            Encoding::Float => Encoding::Float.between(from, to, at.between),
            Encoding::LowHalf => Encoding::LowHalf.between(from, to, at.between),
            Encoding::HighHalf => Encoding::HighHalf.between(from, to, at.between),
            Encoding::Packed => Encoding::Packed.between(from, to, at.between),
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> Columns<R> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.bound.rows(), property)
    }

    #[inline(always)]
    fn steps(&self, property: Property, at: &SlotSample, component: usize) -> R {
        let Some((from, to, encoding)) = self.straight(property, at, component) else {
            return R::load(&self.gathered_steps(property, at, component).0);
        };
        let (from, to) = match encoding {
            Encoding::Float => {
                (R::load(bytemuck::cast_slice(from)), R::load(bytemuck::cast_slice(to)))
            }
            Encoding::LowHalf => (R::low_halves(from), R::low_halves(to)),
            Encoding::HighHalf => (R::high_halves(from), R::high_halves(to)),
            Encoding::Packed => (R::packed(from), R::packed(to)),
        };
        from.mix(to, R::splat(at.between))
    }
}

// The functions below are no closures: a closure would not be compiled for the same processor as
// its caller.

/// Returns a component between two rows, `offset + step * n`.
#[inline(always)]
pub(crate) fn component<R: RowWidth>(
    columns: &R::Columns<'_>,
    property: Property,
    at: &SlotSample,
    index: usize,
    step: R,
    offset: R,
) -> R {
    columns.steps(property, at, index) * step + offset
}

/// Loads a quaternion from four planes of `padded` floats.
#[inline(always)]
pub(crate) fn load_quat<R: Load>(planes: &[f32], padded: usize) -> [R; 4] {
    [
        R::load(planes),
        R::load(&planes[padded..]),
        R::load(&planes[2 * padded..]),
        R::load(&planes[3 * padded..]),
    ]
}

/// Loads a vector from three planes of `padded` floats.
#[inline(always)]
pub(crate) fn load_vec3<R: Load>(planes: &[f32], padded: usize) -> [R; 3] {
    [R::load(planes), R::load(&planes[padded..]), R::load(&planes[2 * padded..])]
}

/// Samples translations or scales between two rows. `range` begins with three planes of offsets,
/// followed by a plane of steps.
#[inline(always)]
pub(crate) fn sample_vector<R: RowWidth>(
    columns: &R::Columns<'_>,
    property: Property,
    at: &SlotSample,
    range: &[f32],
    padded: usize,
) -> [R; 3] {
    let [x, y, z] = load_vec3::<R>(range, padded);
    if columns.planes(property).are_still() {
        return [x, y, z];
    }
    let step = R::load(&range[3 * padded..]);
    [
        component(columns, property, at, 0, step, x),
        component(columns, property, at, 1, step, y),
        component(columns, property, at, 2, step, z),
    ]
}
