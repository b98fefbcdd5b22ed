//! Row storage as devices read it: signed 16-bit numbers over each joint's own range, in blocks of 16
//! columns.
//!
//! [`RowBlock`] describes the planes of a block. A component's value is `offset + step * n` for the
//! stored `n`. A column that does not move has a step of 0, so the stored bits do not matter. If 16
//! bits cannot represent a property of a block within the error bound, it is stored as floats, in
//! planes of all 16 columns. Devices may read columns that do not move; the words there must be
//! finite as floats, also times 32,767, because only finite values times 0 are 0.

use glam::{DQuat, DVec4};
use populace_model::{JointIndex, Property, Trs, f64math};

use crate::curves::Local;
use crate::probes::{Judge, distance_at_probes};
use crate::row::Row;
use crate::row_block::{BLOCK, NO_PLANES, ROW_FLOATS, RowBlock};

/// The greatest number that is stored. Its negative is the least, so that 0 is in the middle.
const GREATEST: f64 = 32767.0;
/// Number of block properties that are converted to floats one by one.
const ONE_BY_ONE: usize = 6;
/// A value counts as constant if it moves no probe by more than this part of the allowed storage
/// error.
const STILL: f64 = 0.01;

/// Range of a column's stored numbers `n`: a component is `offset + step * n`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    /// The middle of each component's values, or the constant value.
    pub offset: [f32; 4],
    /// 0 if the column is constant.
    pub step: f32,
}

impl Range {
    /// Creates the range of a constant value. Zeros are made positive, as the result of `0 * n +
    /// offset` is.
    #[must_use]
    pub fn still(value: [f32; 4]) -> Self {
        Self { offset: value.map(|v| v + 0.0), step: 0.0 }
    }

    /// Creates the range from the minimum to the maximum of each component. Components that do not
    /// move are exact, since their `n` is 0.
    fn over([low, high]: [[f32; 4]; 2]) -> Self {
        let widest = (0..4).map(|c| f64::from(high[c]) - f64::from(low[c])).fold(0.0, f64::max);
        let [step] = f64math::to_f32([widest / (2.0 * GREATEST)]);
        let middle = [0, 1, 2, 3].map(|c| 0.5 * (f64::from(low[c]) + f64::from(high[c])));
        Self { offset: f64math::to_f32(middle).map(|v| v + 0.0), step: step.max(f32::MIN_POSITIVE) }
    }
}

/// The stored rows of one clip.
#[derive(Clone, Debug, Default)]
pub(crate) struct Storage {
    /// All rows, one after the other.
    pub(crate) words: Vec<u32>,
    /// Words from one row to the next.
    pub(crate) stride: usize,
    /// Location of each block of 16 columns within a row.
    pub(crate) blocks: Vec<RowBlock>,
    /// The range of each column and [`Property`].
    pub(crate) ranges: Vec<[Range; 3]>,
    /// Largest error of a stored component, for each column and [`Property`]: in metres, quaternion
    /// components or factors.
    pub(crate) worst: Vec<[f32; 3]>,
    /// Largest distance that storage moves a probe, in metres.
    pub(crate) error_m: f64,
}

impl Storage {
    /// Stores rows as 16-bit numbers. While these move a probe too far, the block properties with
    /// the largest error are converted to floats. They are converted one by one at first, then in
    /// growing batches. `poses` are the rows in single precision, with neighbouring rotations in
    /// one hemisphere.
    pub(crate) fn new(rows: &[Row], poses: &[Vec<Trs>], judge: &Judge) -> Self {
        let ranges = ranges(poses, judge);
        let mut floats = vec![[false; 3]; ranges.len().div_ceil(BLOCK)];
        let mut found = 0;
        loop {
            let mut stored = Self::of_poses(poses, ranges.clone(), &floats);
            stored.measure(rows, judge);
            let coarsest = stored.coarsest(judge, &floats);
            if coarsest.is_empty() || stored.error_m <= judge.allowed {
                return stored;
            }
            let at_once = if found < ONE_BY_ONE { 1 } else { 3 * found };
            for &(block, property) in coarsest.iter().take(at_once) {
                floats[block][property as usize] = true;
                found += 1;
            }
        }
    }

    /// Returns the block properties that are not stored as floats, largest effect on probes first.
    fn coarsest(&self, judge: &Judge, floats: &[[bool; 3]]) -> Vec<(usize, Property)> {
        let effect_m = |block: usize, property: Property| {
            let columns = block * BLOCK..self.worst.len().min((block + 1) * BLOCK);
            let moved = columns.map(|column| {
                let worst = f64::from(self.worst[column][property as usize]);
                if property == Property::Translation {
                    worst
                } else {
                    2.0 * worst * judge.reach[column]
                }
            });
            moved.fold(0.0, f64::max)
        };
        let all =
            (0..floats.len()).flat_map(|block| Property::ALL.map(|property| (block, property)));
        let coarse = all.filter(|&(block, property)| {
            !floats[block][property as usize]
                && planes(&self.blocks[block], property).0 != NO_PLANES
        });
        let mut coarse: Vec<_> =
            coarse.map(|(block, p)| (effect_m(block, p), (block, p))).collect();
        coarse.sort_by(|a, b| a.0.total_cmp(&b.0));
        coarse.into_iter().rev().map(|(_, which)| which).collect()
    }

    fn of_poses(poses: &[Vec<Trs>], ranges: Vec<[Range; 3]>, floats: &[[bool; 3]]) -> Self {
        Self::encode(poses.len(), ranges, floats, |row, column, property| {
            property.of(&poses[row][column]).map(f64::from)
        })
    }

    /// Stores `row_count` rows of `values`, which are given the row, the column and the property.
    fn encode(
        row_count: usize,
        mut ranges: Vec<[Range; 3]>,
        floats: &[[bool; 3]],
        values: impl Fn(usize, usize, Property) -> [f64; 4],
    ) -> Self {
        for (column, ranges) in ranges.iter_mut().enumerate() {
            for (range, is_float) in ranges.iter_mut().zip(floats[column / BLOCK]) {
                if is_float && range.step > 0.0 {
                    *range = Range { offset: [0.0; 4], step: 1.0 };
                }
            }
        }
        let (blocks, stride) = lay_out(&ranges, floats);
        let mut stored =
            Self { words: vec![0; stride * row_count], stride, blocks, ranges, ..Self::default() };
        for row in 0..row_count {
            for column in 0..stored.ranges.len() {
                for property in Property::ALL {
                    if stored.ranges[column][property as usize].step > 0.0 {
                        stored.put(row, column, property, values(row, column, property));
                    }
                }
            }
        }
        stored
    }

    /// Creates storage of one row whose properties in `moves` (for each column and [`Property`])
    /// are floats that will be overwritten.
    pub(crate) fn live(pose: Vec<Trs>, moves: &[[bool; 3]]) -> Self {
        let range = |(trs, moves): (&Trs, &[bool; 3])| {
            Property::ALL.map(|property| Range {
                step: if moves[property as usize] { 1.0 } else { 0.0 },
                ..Range::still(property.of(trs))
            })
        };
        let ranges: Vec<_> = pose.iter().zip(moves).map(range).collect();
        let floats = vec![[true; 3]; ranges.len().div_ceil(BLOCK)];
        let worst = vec![[0.0; 3]; ranges.len()];
        Self { worst, ..Self::of_poses(&[pose], ranges, &floats) }
    }

    /// Copies the rows in another order of columns. `columns` names the column that each new one
    /// copies, with the properties to copy; all else is constant at `rest`. Numbers are copied
    /// as they are. Where floats are among them, a block's other numbers become floats as well.
    pub(crate) fn arranged(&self, columns: &[Option<(usize, [bool; 3])>], rest: &[Trs]) -> Self {
        let copied = |to: usize, property: Property| {
            columns[to].filter(|(_, copied)| copied[property as usize]).map(|(from, _)| from)
        };
        let mut floats = vec![[false; 3]; columns.len().div_ceil(BLOCK)];
        let (mut ranges, mut worst) = (Vec::new(), Vec::new());
        for (to, rest) in rest.iter().enumerate() {
            ranges.push(Property::ALL.map(|property| match copied(to, property) {
                Some(from) => self.ranges[from][property as usize],
                None => Range::still(property.of(rest)),
            }));
            worst.push(Property::ALL.map(|property| {
                copied(to, property).map_or(0.0, |from| self.worst[from][property as usize])
            }));
            for property in Property::ALL {
                let from = copied(to, property).map(|from| &self.blocks[from / BLOCK]);
                floats[to / BLOCK][property as usize] |=
                    from.is_some_and(|block| planes(block, property).1 & ROW_FLOATS != 0);
            }
        }
        let row_count = self.words.len() / self.stride.max(1);
        let stored = Self::encode(row_count, ranges, &floats, |row, to, property| {
            let from = copied(to, property).unwrap_or_default();
            self.values(self.row(row), from, property)
        });
        Self { worst, error_m: self.error_m, ..stored }
    }

    /// Converts a pose to the words of a row of floats; properties that do not move are left out.
    pub(crate) fn row_of(&self, pose: &[Trs]) -> Vec<u32> {
        let mut words = vec![0; self.stride];
        for (column, trs) in pose.iter().enumerate().take(self.ranges.len()) {
            for property in
                Property::ALL.into_iter().filter(|p| self.ranges[column][*p as usize].step > 0.0)
            {
                for (component, value) in
                    property.of(trs).into_iter().take(property.width()).enumerate()
                {
                    if let Location::Float(word) = self.location(column, property, component) {
                        words[word] = value.to_bits();
                    }
                }
            }
        }
        words
    }

    /// Converts the words of a row to a pose.
    pub(crate) fn pose_of(&self, words: &[u32]) -> Vec<Trs> {
        let pose = |column| {
            let values = |property| f64math::to_f32(self.values(words, column, property));
            let vector = |property| {
                let [x, y, z, _] = values(property);
                [x, y, z]
            };
            Trs {
                translation: vector(Property::Translation),
                rotation: values(Property::Rotation),
                scale: vector(Property::Scale),
            }
        };
        (0..self.ranges.len()).map(pose).collect()
    }

    fn put(&mut self, row: usize, column: usize, property: Property, values: [f64; 4]) {
        let range = self.ranges[column][property as usize];
        let first = row * self.stride;
        for (component, value) in values.into_iter().take(property.width()).enumerate() {
            match self.location(column, property, component) {
                Location::Float(word) => {
                    let [value] = f64math::to_f32([value]);
                    self.words[first + word] = value.to_bits();
                }
                Location::Half(word, shift) => {
                    let n = (value - f64::from(range.offset[component])) / f64::from(range.step);
                    #[expect(clippy::cast_possible_truncation, reason = "clamped on the line")]
                    let n = n.round().clamp(-GREATEST, GREATEST) as i16;
                    self.words[first + word] |= u32::from(n.cast_unsigned()) << shift;
                }
            }
        }
    }

    /// Returns the location of a component within a row.
    fn location(&self, column: usize, property: Property, component: usize) -> Location {
        let (first, lanes) = planes(&self.blocks[column / BLOCK], property);
        let lane = column % BLOCK;
        if lanes & ROW_FLOATS != 0 {
            return Location::Float(first as usize + component * BLOCK + lane);
        }
        let plane = first as usize + component / 2 * lanes as usize;
        if component == 2 && property != Property::Rotation {
            Location::Half(plane + lane / 2, 16 * (lane % 2))
        } else {
            Location::Half(plane + lane, 16 * (component % 2))
        }
    }

    /// Returns the words of a row.
    fn row(&self, row: usize) -> &[u32] {
        &self.words[row * self.stride..][..self.stride]
    }

    /// Decodes a property of a stored row as devices do. The fourth component of vectors is 0.
    fn values(&self, words: &[u32], column: usize, property: Property) -> [f64; 4] {
        let range = &self.ranges[column][property as usize];
        let mut values = range.offset.map(f64::from);
        if range.step == 0.0 {
            return values;
        }
        for (component, value) in values.iter_mut().enumerate().take(property.width()) {
            let n = match self.location(column, property, component) {
                Location::Float(at) => f64::from(f32::from_bits(words[at])),
                #[expect(clippy::cast_possible_truncation, reason = "16 bits are left")]
                Location::Half(at, shift) => f64::from(((words[at] >> shift) as u16).cast_signed()),
            };
            *value += f64::from(range.step) * n;
        }
        values
    }

    /// Interpolates a joint's local transform between two stored rows as devices do, which round
    /// `u` to whole parts of 32,767. `u` is 0 at the first row and 1 at the second.
    pub(crate) fn local(&self, joint: JointIndex, [row, next]: [usize; 2], u: f64) -> Local {
        let mix = |property| {
            let first = self.values(self.row(row), joint.index(), property);
            if u == 0.0 {
                return first;
            }
            let second = self.values(self.row(next), joint.index(), property);
            std::array::from_fn(|c| first[c] * (1.0 - u) + second[c] * u)
        };
        let vector = |property| DVec4::from_array(mix(property)).truncate();
        Local {
            rotation: DQuat::from_array(mix(Property::Rotation)).normalize(),
            translation: vector(Property::Translation),
            scale: vector(Property::Scale),
        }
    }

    /// Returns the bytes of the ranges of all properties that move.
    pub(crate) fn range_bytes(&self) -> usize {
        let moving = |property: Property| {
            self.ranges.iter().filter(|column| column[property as usize].step > 0.0).count()
        };
        Property::ALL
            .into_iter()
            .map(|property| (property.width() + 1) * 4 * moving(property))
            .sum()
    }

    /// Measures the difference between stored and exact rows.
    fn measure(&mut self, rows: &[Row], judge: &Judge) {
        let parents = judge.skeleton.parents();
        let mut worst = vec![[0.0; 3]; parents.len()];
        let mut stored = Vec::with_capacity(parents.len());
        for (at, row) in rows.iter().enumerate() {
            stored.clear();
            for joint in judge.skeleton.joints() {
                let local = self.local(joint, [at, at], 0.0);
                let exact = &row.pose[joint.index()];
                // A quaternion and its negative are the same rotation.
                let side = if exact.rotation.dot(local.rotation) < 0.0 { -1.0 } else { 1.0 };
                let turned = (exact.rotation - local.rotation * side).to_array().map(f64::abs);
                let [t, r, s] = worst[joint.index()];
                worst[joint.index()] = [
                    f64::max(t, (exact.translation - local.translation).abs().max_element()),
                    turned.into_iter().fold(r, f64::max),
                    f64::max(s, (exact.scale - local.scale).abs().max_element()),
                ];
                stored.push(local.affine());
            }
            let exact = f64math::model_from_joints(parents, row.pose.iter().map(Local::affine));
            let found = f64math::model_from_joints(parents, stored.iter().copied());
            for ((a, b), &probe) in exact.iter().zip(&found).zip(judge.probes) {
                self.error_m = self.error_m.max(distance_at_probes(a, b, probe));
            }
        }
        self.worst = worst.into_iter().map(f64math::to_f32).collect();
    }
}

/// Location of a component: a word, or the half of a word that starts at a bit.
enum Location {
    Float(usize),
    Half(usize, usize),
}

/// Returns the first word and the lanes of a property in a block.
pub(crate) fn planes(block: &RowBlock, property: Property) -> (u32, u32) {
    match property {
        Property::Rotation => (block.rotation_first, block.rotation_lanes),
        Property::Translation => (block.translation_first, block.translation_lanes),
        Property::Scale => (block.scale_first, block.scale_lanes),
    }
}

/// Returns the range of each column and property. Values that hardly move become constant, at the
/// rest value if they stay close to it.
fn ranges(poses: &[Vec<Trs>], judge: &Judge) -> Vec<[Range; 3]> {
    let range = |joint: JointIndex, property: Property| {
        let value = |trs: &Trs| property.of(trs);
        let still = STILL * judge.allowed
            / match property {
                Property::Translation => 1.0,
                // Four components that are each off by `e` add up to a difference of length `2 e`,
                // which rotates by at most `4 e`.
                Property::Rotation => 4.0 * judge.reach[joint.index()],
                Property::Scale => judge.reach[joint.index()],
            };
        let [low, high] = bounds(poses.iter().map(|pose| value(&pose[joint.index()])));
        let within = |at: [f32; 4]| {
            (0..4)
                .all(|c| f64::from(high[c] - at[c]) <= still && f64::from(at[c] - low[c]) <= still)
        };
        let rest = value(judge.skeleton.rest(joint));
        let first = poses.first().map_or(rest, |pose| value(&pose[joint.index()]));
        if let Some(constant) = [rest, first].into_iter().find(|&at| within(at)) {
            return Range::still(constant);
        }
        Range::over([low, high])
    };
    let all = |joint| Property::ALL.map(|property| range(joint, property));
    judge.skeleton.joints().map(all).collect()
}

/// Returns minimum and maximum of each component.
fn bounds(values: impl Iterator<Item = [f32; 4]>) -> [[f32; 4]; 2] {
    let none = [[f32::INFINITY; 4], [f32::NEG_INFINITY; 4]];
    values.fold(none, |[low, high], value| {
        [
            std::array::from_fn(|c| low[c].min(value[c])),
            std::array::from_fn(|c| high[c].max(value[c])),
        ]
    })
}

/// Returns the location of each block's planes within a row and the length of a row, both in words.
fn lay_out(ranges: &[[Range; 3]], floats: &[[bool; 3]]) -> (Vec<RowBlock>, usize) {
    let mut stride = 0u32;
    let mut blocks = vec![RowBlock::STILL; ranges.len().div_ceil(BLOCK)];
    for property in [Property::Rotation, Property::Translation, Property::Scale] {
        for ((block, columns), floats) in blocks.iter_mut().zip(ranges.chunks(BLOCK)).zip(floats) {
            let moves = |column: &[Range; 3]| column[property as usize].step > 0.0;
            let Some(last) = columns.iter().rposition(moves) else {
                continue;
            };
            #[expect(clippy::cast_possible_truncation, reason = "at most 16")]
            let (block_lanes, used) = (BLOCK as u32, last as u32 + 1);
            let is_float = floats[property as usize];
            let lanes = if is_float { block_lanes | ROW_FLOATS } else { used };
            let words = match (is_float, property) {
                (true, Property::Rotation) => 4 * block_lanes,
                (true, _) => 3 * block_lanes,
                (false, Property::Rotation) => 2 * used,
                (false, _) => used + used.div_ceil(2),
            };
            let (first_word, lanes_word) = match property {
                Property::Rotation => (&mut block.rotation_first, &mut block.rotation_lanes),
                Property::Translation => {
                    (&mut block.translation_first, &mut block.translation_lanes)
                }
                Property::Scale => (&mut block.scale_first, &mut block.scale_lanes),
            };
            (*first_word, *lanes_word) = (stride, lanes);
            stride += words;
        }
    }
    // Rows become whole blocks if that adds at most an eighth. Most planes are then whole cache
    // lines where the table begins a line, as OpenCL buffers do.
    let (stride, whole) = (stride as usize, (stride as usize).next_multiple_of(BLOCK));
    (blocks, if whole - stride <= stride / 8 { whole } else { stride })
}
