//! Components of local transforms from a clip's rows, for one joint or for sixteen neighbouring
//! ones. Twin of `kernels/rows.cl`.
//!
//! A component is `offset + part * n`, where `n` is the sum of both rows' numbers, each times its
//! weight in [`ROW_PARTS`](populace_device::layout::ROW_PARTS). Joints that the clip does not
//! drive, or that do not move in it, have a part of 0, so the arithmetic is the same for all.

use populace_device::Tables;
use populace_device::layout::{Body, BoundBlock, BoundClip, RowBlock};
use populace_model::Property;

use crate::encoding::{Planes, Rows};
use crate::lanes::{LANES, Load};
use crate::processor::Dispatch;

/// Joints computed together: those of one [`Width`] from `first` on.
#[derive(Clone, Copy)]
pub(crate) struct Joints<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) body: &'a Body,
    pub(crate) first: usize,
    /// Registers that sixteen joints are computed in.
    pub(crate) registers: Dispatch,
}

impl<'a> Joints<'a> {
    /// Returns where the block of sixteen joints finds its columns in a clip's rows.
    #[inline(always)]
    pub(crate) fn bound_block(&self, bound: &BoundClip) -> &'a BoundBlock {
        &self.tables.bound_blocks().as_slice()[bound.block_first as usize + self.first / LANES]
    }

    /// Returns stored floats from the first joint's on, in a table with `planes` planes. Planes are
    /// [`LANES`] floats apart.
    #[inline(always)]
    pub(crate) fn stored(&self, poses_first: u32, planes: u32) -> &'a [f32] {
        let block = self.first / LANES * LANES * planes as usize;
        &self.tables.poses().as_slice()[poses_first as usize + block + self.first % LANES..]
    }
}

/// A width that finds its columns in a clip's rows.
pub(crate) trait RowWidth: Load {
    /// Positions of the columns.
    type Columns<'a>: Columns<Self>;

    /// Finds the columns of the joints.
    fn columns<'a>(joints: &Joints<'a>, bound: &'a BoundClip) -> Self::Columns<'a>;
}

/// Positions in a clip's rows of the columns of joints computed together.
pub(crate) trait Columns<R> {
    /// Returns the position of a property's planes.
    fn planes(&self, property: Property) -> Planes;

    /// Returns whether the columns may take the path of most columns.
    fn are_common(&self) -> bool;

    /// Returns the components of rotations between two rows, in `ROW_PARTS` of a step. `COMMON`
    /// columns are [common](Self::are_common).
    fn rotation<const COMMON: bool>(&self, at: &Rows) -> [R; 4];

    /// Returns the components of translations or scales.
    fn vector<const COMMON: bool>(&self, property: Property, at: &Rows) -> [R; 3];
}

/// Column of one joint.
pub(crate) struct JointColumn<'a> {
    rows: &'a [u32],
    block: RowBlock,
    lane: usize,
}

impl JointColumn<'_> {
    /// Returns a component between two rows, in `ROW_PARTS` of a step.
    #[inline(always)]
    fn parts(&self, property: Property, at: &Rows, component: usize) -> f32 {
        let planes = Planes::of(&self.block, property);
        let (from, encoding) = planes.plane_at(property, at.from, component);
        let (to, _) = planes.plane_at(property, at.to, component);
        encoding.parts_in(&self.rows[from..], &self.rows[to..], self.lane, at)
    }
}

impl RowWidth for f32 {
    type Columns<'a> = JointColumn<'a>;

    #[inline(always)]
    fn columns<'a>(joints: &Joints<'a>, bound: &'a BoundClip) -> JointColumn<'a> {
        JointColumn {
            rows: joints.tables.rows().as_slice(),
            block: joints.bound_block(bound).rows(),
            lane: joints.first % LANES,
        }
    }
}

impl Columns<f32> for JointColumn<'_> {
    #[inline(always)]
    fn planes(&self, property: Property) -> Planes {
        Planes::of(&self.block, property)
    }

    #[inline(always)]
    fn are_common(&self) -> bool {
        true
    }

    #[inline(always)]
    fn rotation<const COMMON: bool>(&self, at: &Rows) -> [f32; 4] {
        [0, 1, 2, 3].map(|component| self.parts(Property::Rotation, at, component))
    }

    #[inline(always)]
    fn vector<const COMMON: bool>(&self, property: Property, at: &Rows) -> [f32; 3] {
        [0, 1, 2].map(|component| self.parts(property, at, component))
    }
}

// The functions below are no closures: a closure would not be compiled for the same processor as
// its caller.

/// Loads a number of each joint from a plane.
#[inline(always)]
pub(crate) fn load_plane<R: Load>(stored: &[f32], plane: usize) -> R {
    R::load(&stored[plane * LANES..])
}

/// Loads a quaternion from four planes.
#[inline(always)]
pub(crate) fn load_quat<R: Load>(stored: &[f32], plane: usize) -> [R; 4] {
    [
        load_plane(stored, plane),
        load_plane(stored, plane + 1),
        load_plane(stored, plane + 2),
        load_plane(stored, plane + 3),
    ]
}

/// Loads a vector from three planes.
#[inline(always)]
pub(crate) fn load_vec3<R: Load>(stored: &[f32], plane: usize) -> [R; 3] {
    [load_plane(stored, plane), load_plane(stored, plane + 1), load_plane(stored, plane + 2)]
}

/// Samples rotations between two rows.
#[inline(always)]
pub(crate) fn sample_rotation<R: RowWidth, const COMMON: bool>(
    columns: &R::Columns<'_>,
    at: &Rows,
    range: &[f32],
) -> [R; 4] {
    let [x, y, z, w] = load_quat::<R>(range, 0);
    if columns.planes(Property::Rotation).are_still() {
        return [x, y, z, w];
    }
    let part = load_plane::<R>(range, 4);
    let [nx, ny, nz, nw] = columns.rotation::<COMMON>(at);
    [nx * part + x, ny * part + y, nz * part + z, nw * part + w]
}

/// Samples translations or scales between two rows. `plane` is the first of their offset; after it
/// comes their part.
#[inline(always)]
pub(crate) fn sample_vector<R: RowWidth, const COMMON: bool>(
    columns: &R::Columns<'_>,
    property: Property,
    at: &Rows,
    range: &[f32],
    plane: usize,
) -> [R; 3] {
    let [x, y, z] = load_vec3::<R>(range, plane);
    if columns.planes(property).are_still() {
        return [x, y, z];
    }
    let part = load_plane::<R>(range, plane + 3);
    let [nx, ny, nz] = columns.vector::<COMMON>(property, at);
    [nx * part + x, ny * part + y, nz * part + z]
}
