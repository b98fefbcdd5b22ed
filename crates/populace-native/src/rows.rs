//! Local transforms of one joint, or of sixteen neighbouring ones, from a clip's rows; the twin of
//! `kernels/rows.cl`.
//!
//! A component is `offset + step * n`: a joint that the clip does not drive, or that stands still,
//! has a step of 0, so the arithmetic is the same for all.

use populace_device::Tables;
use populace_device::layout::{
    BLOCK_STRAIGHT, BLOCK_TURNED, Body, BoundBlock, BoundClip, JOINT_BLOCK, MAP_COLUMN,
    MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION, NONE, REST_SCALE, REST_TRANSLATION, ROW_FLOATS,
    RowBlock, SlotSample,
};
use populace_model::Property;
use populace_model::math::{Real, quat};

use crate::joint::Posing;
use crate::lanes::{LANES, Lanes, Several};
use crate::turns::turn;

/// Translation, rotation and scale of one joint, or of sixteen.
#[derive(Clone, Copy)]
pub(crate) struct Local<R> {
    pub(crate) t: [R; 3],
    pub(crate) r: [R; 4],
    pub(crate) s: [R; 3],
}

/// What is computed at once: one joint, or the sixteen of a block.
pub(crate) trait Width: Real {
    /// Where their columns stand in a clip's rows.
    type Columns<'a>: Columns<Self>;

    /// Joints computed at once.
    const COUNT: usize;

    /// From a table of floats, at the first joint's place.
    fn load(from: &[f32]) -> Self;

    /// One of them.
    fn lane(self, lane: usize) -> f32;

    /// Chooses one of them.
    fn only(lane: usize) -> Self::Choice;

    /// Whether any is chosen.
    fn any(which: Self::Choice) -> bool;

    fn columns<'a>(tables: &'a Tables, bound: &BoundClip, joint: usize) -> Self::Columns<'a>;

    /// Lays a member's layers over a pose. Apart: it is seldom, and must not take the registers of
    /// what is not.
    fn lay_over(posing: &Posing, rest: &Local<Self>, pose: &mut Local<Self>);
}

/// Where the columns of what is computed at once stand in a clip's rows.
pub(crate) trait Columns<R> {
    /// Where the property's planes stand; its first word is [`NONE`] where nothing moves.
    fn planes(&self, property: Property) -> Planes;

    /// A component of a row, in steps.
    fn steps(&self, property: Property, row: u32, component: usize) -> R;
}

/// Where a property's planes stand in a row, and the words from one plane to the next.
#[derive(Clone, Copy)]
pub(crate) struct Planes {
    pub(crate) first: u32,
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

    /// The first word of the plane that holds a component, and how it is held.
    #[inline(always)]
    fn place(self, property: Property, row: u32, component: usize) -> (usize, Held) {
        let start = (row + self.first) as usize;
        let lanes = (self.lanes & !ROW_FLOATS) as usize;
        if self.lanes & ROW_FLOATS != 0 {
            return (start + component * lanes, Held::Float);
        }
        let held = match component {
            2 if property != Property::Rotation => Held::Packed,
            0 | 2 => Held::Low,
            _ => Held::High,
        };
        (start + component / 2 * lanes, held)
    }
}

/// How a plane holds a component.
#[derive(Clone, Copy)]
enum Held {
    Float,
    /// The low half of each lane's word.
    Low,
    /// The high half.
    High,
    /// A half for each lane.
    Packed,
}

impl Held {
    /// A lane's steps in a plane.
    #[inline(always)]
    fn decode(self, plane: &[u32], lane: usize) -> f32 {
        #[expect(
            clippy::cast_possible_wrap,
            reason = "16 bits fit; processors convert signed numbers faster"
        )]
        let half = |word: u32| (word & 0xffff) as i32 as f32;
        match self {
            Self::Float => f32::from_bits(plane[lane]),
            Self::Low => half(plane[lane]),
            Self::High => half(plane[lane] >> 16),
            Self::Packed => half(plane[lane / 2] >> (16 * (lane % 2))),
        }
    }
}

/// One joint's column.
pub(crate) struct JointColumn<'a> {
    rows: &'a [u32],
    block: RowBlock,
    lane: usize,
}

impl Width for f32 {
    type Columns<'a> = JointColumn<'a>;

    const COUNT: usize = 1;

    #[inline(always)]
    fn lane(self, _lane: usize) -> f32 {
        self
    }

    #[inline(always)]
    fn only(_lane: usize) -> bool {
        true
    }

    #[inline(always)]
    fn any(which: bool) -> bool {
        which
    }

    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        from[0]
    }

    #[inline(always)]
    fn columns<'a>(tables: &'a Tables, bound: &BoundClip, joint: usize) -> JointColumn<'a> {
        let map = tables.joint_maps().as_slice()[bound.map_first as usize + joint];
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

    #[inline(never)]
    fn lay_over(posing: &Posing, rest: &Local<Self>, pose: &mut Local<Self>) {
        posing.lay_over(rest, pose);
    }
}

impl Columns<f32> for JointColumn<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.block, property)
    }

    #[inline(always)]
    fn steps(&self, property: Property, row: u32, component: usize) -> f32 {
        let (at, held) = self.planes(property).place(property, row, component);
        held.decode(&self.rows[at..], self.lane)
    }
}

/// The columns of sixteen neighbouring joints: in one block, each in its own lane, or here and
/// there in several.
pub(crate) struct BlockColumns<'a> {
    tables: &'a Tables,
    bound: &'a BoundBlock,
}

impl Width for Lanes {
    type Columns<'a> = BlockColumns<'a>;

    const COUNT: usize = LANES;

    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.0[lane]
    }

    #[inline(always)]
    fn only(lane: usize) -> [bool; LANES] {
        std::array::from_fn(|other| other == lane)
    }

    #[inline(always)]
    fn any(which: [bool; LANES]) -> bool {
        which.contains(&true)
    }

    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        Self::load(from)
    }

    #[inline(always)]
    fn columns<'a>(tables: &'a Tables, bound: &BoundClip, joint: usize) -> BlockColumns<'a> {
        BlockColumns { tables, bound: bound_block(tables, bound, joint) }
    }

    #[inline(always)]
    fn lay_over(posing: &Posing, rest: &Local<Self>, pose: &mut Local<Self>) {
        posing.dispatch.lay_over(posing, rest, pose);
    }
}

impl<'a> BlockColumns<'a> {
    /// The blocks followed, and each joint's lane in them.
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

    /// Each lane's steps in the source that it follows.
    fn gather(&self, property: Property, row: u32, component: usize) -> Lanes {
        let mut found = [0.0; LANES];
        for (block, lanes) in self.sources() {
            let planes = Planes::of(&block, property);
            if planes.first == NONE {
                continue;
            }
            let (at, held) = planes.place(property, row, component);
            let plane = &self.tables.rows().as_slice()[at..];
            for (value, &lane) in found.iter_mut().zip(lanes) {
                if lane != NONE {
                    *value = held.decode(plane, lane as usize);
                }
            }
        }
        Several(found)
    }
}

impl Columns<Lanes> for BlockColumns<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.bound.rows(), property)
    }

    #[inline(always)]
    fn steps(&self, property: Property, row: u32, component: usize) -> Lanes {
        if self.bound.flags & BLOCK_STRAIGHT == 0 {
            return self.gather(property, row, component);
        }
        let (at, held) = self.planes(property).place(property, row, component);
        let plane = &self.tables.rows().as_slice()[at..at + LANES];
        match held {
            Held::Float => Lanes::from_fn(|lane| Held::Float.decode(plane, lane)),
            Held::Low => Lanes::from_fn(|lane| Held::Low.decode(plane, lane)),
            Held::High => Lanes::from_fn(|lane| Held::High.decode(plane, lane)),
            Held::Packed => Lanes::from_fn(|lane| Held::Packed.decode(plane, lane)),
        }
    }
}

/// Three planes of `padded` floats.
#[inline(always)]
pub(crate) fn load_vec3<R: Width>(planes: &[f32], padded: usize) -> [R; 3] {
    [R::load(planes), R::load(&planes[padded..]), R::load(&planes[2 * padded..])]
}

/// Four planes of `padded` floats.
#[inline(always)]
pub(crate) fn load_quat<R: Width>(planes: &[f32], padded: usize) -> [R; 4] {
    [
        R::load(planes),
        R::load(&planes[padded..]),
        R::load(&planes[2 * padded..]),
        R::load(&planes[3 * padded..]),
    ]
}

// Closures below would not be compiled for the processor that their caller is, so what is hot is
// functions.

/// A component between two rows: `offset + step * n`.
#[inline(always)]
pub(crate) fn component<R: Width>(
    columns: &R::Columns<'_>,
    property: Property,
    at: &SlotSample,
    index: usize,
    step: R,
    offset: R,
) -> R {
    let from = columns.steps(property, at.row0, index);
    let to = columns.steps(property, at.row1, index);
    from.mix(to, R::splat(at.between)) * step + offset
}

/// Translations or scales between two rows; `range` starts with planes of offsets, and a plane of
/// steps follows.
#[inline(always)]
pub(crate) fn sample_vector<R: Width>(
    columns: &R::Columns<'_>,
    property: Property,
    at: &SlotSample,
    range: &[f32],
    padded: usize,
) -> [R; 3] {
    let [x, y, z] = load_vec3::<R>(range, padded);
    if columns.planes(property).first == NONE {
        return [x, y, z];
    }
    let step = R::load(&range[3 * padded..]);
    [
        component(columns, property, at, 0, step, x),
        component(columns, property, at, 1, step, y),
        component(columns, property, at, 2, step, z),
    ]
}

/// Where sixteen neighbouring joints, of which this is one, find their columns.
#[inline(always)]
pub(crate) fn bound_block<'a>(
    tables: &'a Tables,
    bound: &BoundClip,
    joint: usize,
) -> &'a BoundBlock {
    &tables.bound_blocks().as_slice()[bound.block_first as usize + joint / LANES]
}

/// A sample of a clip: a rotation not yet of length 1, with the factor that brings it to that and
/// to the hemisphere of the rest rotation, or to nothing where it has no length; and what stands at
/// rest, of [`REST_TRANSLATION`] and [`REST_SCALE`].
pub(crate) struct Sample<R> {
    pub(crate) local: Local<R>,
    pub(crate) unit: R,
    pub(crate) at_rest: u32,
}

impl<R: Real> Sample<R> {
    /// With a rotation of length 1.
    #[inline(always)]
    pub(crate) fn normalized(self) -> Local<R> {
        Local { r: quat::scale(self.local.r, self.unit), ..self.local }
    }
}

/// Local transforms between two rows.
#[inline(always)]
pub(crate) fn sample_joint<R: Width>(
    tables: &Tables,
    bound: &BoundClip,
    body: &Body,
    joint: usize,
    at: &SlotSample,
    rest: &Local<R>,
) -> Sample<R> {
    let columns = R::columns(tables, bound, joint);
    let padded = body.padded_count as usize;
    let range = &tables.poses().as_slice()[bound.range_first as usize + joint..];
    let mut r = load_quat::<R>(range, padded);
    if columns.planes(Property::Rotation).first != NONE {
        let step = R::load(&range[4 * padded..]);
        r = [
            component(&columns, Property::Rotation, at, 0, step, r[0]),
            component(&columns, Property::Rotation, at, 1, step, r[1]),
            component(&columns, Property::Rotation, at, 2, step, r[2]),
            component(&columns, Property::Rotation, at, 3, step, r[3]),
        ];
    }
    let flags = bound_block(tables, bound, joint).flags;
    let at_rest = flags & (REST_TRANSLATION | REST_SCALE);
    let (mut t, mut s) = (rest.t, rest.s);
    if at_rest & REST_TRANSLATION == 0 {
        t = sample_vector::<R>(&columns, Property::Translation, at, &range[5 * padded..], padded);
    }
    if at_rest & REST_SCALE == 0 {
        s = sample_vector::<R>(&columns, Property::Scale, at, &range[9 * padded..], padded);
    }
    if flags & BLOCK_TURNED != 0 {
        (t, r) = turn::<R>(tables, bound, body, joint, at, (t, r));
    }
    let unit = quat::dot(r, r).inverse_sqrt() * quat::side(r, rest.r);
    Sample { local: Local { r, t, s }, unit, at_rest }
}
