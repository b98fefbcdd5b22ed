//! Rows as devices hold them: 16-bit steps over each joint's own range, in blocks of 16 columns.
//!
//! A row is a run of 32-bit words. Each block of 16 columns has, for each property that moves in
//! it, planes of one word for each column: rotations two planes, `x | y << 16` and `z | w << 16`;
//! translations and scales one plane `x | y << 16`, then `z` as 16-bit halves, two in a word.
//! Planes end with the last column of the block that moves. A component's value is
//! `offset + step * n` for the stored `n`; a column that stands still has a step of 0, so what lies
//! in its place does not matter. Where 16 bits cannot hold the bound a block's property is stored
//! as floats, one plane for each component, all 16 columns wide: a device may read past a column
//! that moves, and only finite garbage times 0 is 0.

use glam::{DQuat, DVec3};
use populace_model::{JointIndex, Property, Trs, f64math};

use crate::curves::Local;
use crate::probes::{Judge, distance_at_probes};
use crate::row::{PROPERTIES, Row};
use crate::row_block::{BLOCK, NO_PLANES, ROW_FLOATS, RowBlock};

/// Steps over a joint's range.
const STEPS: f64 = 65535.0;
/// Properties of blocks that are made floats one by one.
const ONE_BY_ONE: usize = 6;
/// A value counts as still while it moves no probe by more than this part of what storage may be
/// off by.
const STILL: f64 = 0.01;

/// What a column's stored components mean: `offset + step * n`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Range {
    /// The value of a component that stands still.
    pub offset: [f32; 4],
    /// 0 where the column stands still.
    pub step: f32,
}

impl Range {
    /// A value that does not move. Zeros are positive, as `0 * n + offset` leaves them.
    #[must_use]
    pub fn still(value: [f32; 4]) -> Self {
        Self { offset: value.map(|v| v + 0.0), step: 0.0 }
    }

    /// From the least of each component to the greatest.
    fn over([low, high]: [[f32; 4]; 2]) -> Self {
        let widest = (0..4).map(|c| f64::from(high[c]) - f64::from(low[c])).fold(0.0, f64::max);
        let [step] = f64math::to_f32([widest / STEPS]);
        Self { offset: low.map(|v| v + 0.0), step: step.max(f32::MIN_POSITIVE) }
    }
}

/// Rows of one clip as stored.
#[derive(Clone, Debug, Default)]
pub struct Storage {
    /// All rows, one after the other.
    pub words: Vec<u32>,
    /// Words from one row to the next.
    pub stride: usize,
    /// Where in a row each block of 16 columns stands.
    pub blocks: Vec<RowBlock>,
    /// Per column and [`Property`].
    pub ranges: Vec<[Range; 3]>,
    /// How far a stored component is from the exact one at most, per column and [`Property`]:
    /// metres, quaternion components, factors.
    pub(crate) worst: Vec<[f32; 3]>,
    /// How far that moves any probe, in metres.
    pub(crate) error_m: f64,
}

impl Storage {
    /// Stores rows: as 16-bit steps, and for as long as those move a probe too far, the properties
    /// of blocks that move them most as floats. They are found one by one, and where many are
    /// needed four times as many each time. `poses` are the rows in single precision, neighbouring
    /// rotations in one hemisphere.
    pub(crate) fn new(rows: &[Row], poses: &[Vec<Trs>], judge: &Judge) -> Self {
        let ranges = ranges(poses, judge);
        let mut floats = vec![[false; 3]; ranges.len().div_ceil(BLOCK)];
        let mut found = 0;
        loop {
            let mut stored = Self::encode(poses, ranges.clone(), &floats);
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

    /// The properties of blocks that are not yet floats, those first whose steps move probes most.
    fn coarsest(&self, judge: &Judge, floats: &[[bool; 3]]) -> Vec<(usize, Property)> {
        let moved_m = |block: usize, property: Property| {
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
        let all = (0..floats.len()).flat_map(|block| PROPERTIES.map(|property| (block, property)));
        let coarse = all.filter(|&(block, property)| {
            !floats[block][property as usize]
                && planes(&self.blocks[block], property).0 != NO_PLANES
        });
        let mut coarse: Vec<_> = coarse.map(|(block, p)| (moved_m(block, p), (block, p))).collect();
        coarse.sort_by(|a, b| a.0.total_cmp(&b.0));
        coarse.into_iter().rev().map(|(_, which)| which).collect()
    }

    fn encode(poses: &[Vec<Trs>], mut ranges: Vec<[Range; 3]>, floats: &[[bool; 3]]) -> Self {
        for (column, ranges) in ranges.iter_mut().enumerate() {
            for (range, is_float) in ranges.iter_mut().zip(floats[column / BLOCK]) {
                if is_float && range.step > 0.0 {
                    *range = Range { offset: [0.0; 4], step: 1.0 };
                }
            }
        }
        let (blocks, stride) = lay_out(&ranges, floats);
        let mut stored = Self {
            words: vec![0; stride * poses.len()],
            stride,
            blocks,
            ranges,
            ..Self::default()
        };
        for (row, pose) in poses.iter().enumerate() {
            for (column, trs) in pose.iter().enumerate() {
                stored.put(row, column, Property::Rotation, &trs.rotation);
                stored.put(row, column, Property::Translation, &trs.translation);
                stored.put(row, column, Property::Scale, &trs.scale);
            }
        }
        stored
    }

    /// One row that others will be written over, all that `moves`, per column and [`Property`], as
    /// floats.
    pub(crate) fn live(pose: Vec<Trs>, moves: &[[bool; 3]]) -> Self {
        let range = |(trs, moves): (&Trs, &[bool; 3])| {
            PROPERTIES.map(|property| Range {
                step: if moves[property as usize] { 1.0 } else { 0.0 },
                ..Range::still(property.of(trs))
            })
        };
        let ranges: Vec<_> = pose.iter().zip(moves).map(range).collect();
        let floats = vec![[true; 3]; ranges.len().div_ceil(BLOCK)];
        let worst = vec![[0.0; 3]; ranges.len()];
        Self { worst, ..Self::encode(&[pose], ranges, &floats) }
    }

    /// Rows of nothing but small rotations, a column each, all of which count as moving.
    #[must_use]
    pub fn of_turns(rows: &[Vec<DQuat>]) -> Self {
        let pose = |row: &Vec<DQuat>| -> Vec<Trs> {
            let near = |turn: &DQuat| if turn.w < 0.0 { -*turn } else { *turn };
            let rotation = |turn: &DQuat| f64math::to_f32(near(turn).to_array());
            row.iter().map(|turn| Trs { rotation: rotation(turn), ..Trs::IDENTITY }).collect()
        };
        let poses: Vec<_> = rows.iter().map(pose).collect();
        let columns = rows.first().map_or(0, Vec::len);
        let range = |column: usize| {
            let rotation = Range::over(bounds(poses.iter().map(|pose| pose[column].rotation)));
            PROPERTIES.map(|property| match property {
                Property::Rotation => rotation,
                _ => Range::still(property.of(&Trs::IDENTITY)),
            })
        };
        let ranges: Vec<_> = (0..columns).map(range).collect();
        let floats = vec![[false; 3]; columns.div_ceil(BLOCK)];
        Self::encode(&poses, ranges, &floats)
    }

    /// A pose as the words of a row of floats; what does not move is left out.
    pub(crate) fn row_of(&self, pose: &[Trs]) -> Vec<u32> {
        let mut words = vec![0; self.stride];
        for (column, trs) in pose.iter().enumerate().take(self.ranges.len()) {
            for property in
                PROPERTIES.into_iter().filter(|p| self.ranges[column][*p as usize].step > 0.0)
            {
                for (component, value) in
                    property.of(trs).into_iter().take(property.width()).enumerate()
                {
                    if let Place::Float(word) = self.place(column, property, component) {
                        words[word] = value.to_bits();
                    }
                }
            }
        }
        words
    }

    fn put(&mut self, row: usize, column: usize, property: Property, values: &[f32]) {
        let range = self.ranges[column][property as usize];
        if range.step == 0.0 {
            return;
        }
        let first = row * self.stride;
        for (component, &value) in values.iter().enumerate() {
            match self.place(column, property, component) {
                Place::Float(word) => self.words[first + word] = value.to_bits(),
                Place::Half(word, shift) => {
                    let n = (f64::from(value) - f64::from(range.offset[component]))
                        / f64::from(range.step);
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "held to 16 bits just before"
                    )]
                    let n = n.round().clamp(0.0, STEPS) as u32;
                    self.words[first + word] |= n << shift;
                }
            }
        }
    }

    /// Where in a row a component stands.
    fn place(&self, column: usize, property: Property, component: usize) -> Place {
        let (first, lanes) = planes(&self.blocks[column / BLOCK], property);
        let lane = column % BLOCK;
        if lanes & ROW_FLOATS != 0 {
            return Place::Float(first as usize + component * BLOCK + lane);
        }
        let plane = first as usize + component / 2 * lanes as usize;
        if component == 2 && property != Property::Rotation {
            Place::Half(plane + lane / 2, 16 * (lane % 2))
        } else {
            Place::Half(plane + lane, 16 * (component % 2))
        }
    }

    /// A component of a stored row, as devices decode it.
    fn component(&self, row: usize, column: usize, property: Property, component: usize) -> f64 {
        let range = &self.ranges[column][property as usize];
        let offset = f64::from(range.offset[component]);
        if range.step == 0.0 {
            return offset;
        }
        let word = |word: usize| self.words[row * self.stride + word];
        let n = match self.place(column, property, component) {
            Place::Float(at) => f64::from(f32::from_bits(word(at))),
            Place::Half(at, shift) => f64::from(word(at) >> shift & 0xffff),
        };
        offset + f64::from(range.step) * n
    }

    /// A joint's local transform at `u` of the way from one stored row to another, as devices
    /// interpolate it.
    pub(crate) fn local(&self, joint: JointIndex, [row, next]: [usize; 2], u: f64) -> Local {
        let mix = |property, component| {
            let at = |row| self.component(row, joint.index(), property, component);
            at(row) * (1.0 - u) + at(next) * u
        };
        let vector = |property| DVec3::from_array(std::array::from_fn(|c| mix(property, c)));
        Local {
            rotation: DQuat::from_array(std::array::from_fn(|c| mix(Property::Rotation, c)))
                .normalize(),
            translation: vector(Property::Translation),
            scale: vector(Property::Scale),
        }
    }

    /// Bytes of the ranges of what moves.
    pub(crate) fn range_bytes(&self) -> usize {
        let moving = |property: Property| {
            self.ranges.iter().filter(|column| column[property as usize].step > 0.0).count()
        };
        PROPERTIES.into_iter().map(|property| (property.width() + 1) * 4 * moving(property)).sum()
    }

    /// Finds how far stored rows are from the exact ones.
    fn measure(&mut self, rows: &[Row], judge: &Judge) {
        let parents = judge.skeleton.parents();
        let mut worst = vec![[0.0; 3]; parents.len()];
        let mut stored = Vec::with_capacity(parents.len());
        for (at, row) in rows.iter().enumerate() {
            stored.clear();
            for joint in judge.skeleton.joints() {
                let local = self.local(joint, [at, at], 0.0);
                let exact = &row.pose[joint.index()];
                // A quaternion and its negative are one rotation.
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

/// Where a component stands: a word, or a half of one from a bit on.
enum Place {
    Float(usize),
    Half(usize, usize),
}

/// A block's first word and lanes for a property.
pub(crate) fn planes(block: &RowBlock, property: Property) -> (u32, u32) {
    match property {
        Property::Rotation => (block.rotation_first, block.rotation_lanes),
        Property::Translation => (block.translation_first, block.translation_lanes),
        Property::Scale => (block.scale_first, block.scale_lanes),
    }
}

/// Per column and property the range of its values. What hardly moves stands still, at rest where
/// it hardly strays from that.
fn ranges(poses: &[Vec<Trs>], judge: &Judge) -> Vec<[Range; 3]> {
    let range = |joint: JointIndex, property: Property| {
        let value = |trs: &Trs| property.of(trs);
        let still = STILL * judge.allowed
            / match property {
                Property::Translation => 1.0,
                // A component that is off by one part turns by at most twice as many, and there are
                // four.
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
    let all = |joint| PROPERTIES.map(|property| range(joint, property));
    judge.skeleton.joints().map(all).collect()
}

/// The least and the greatest of each component.
fn bounds(values: impl Iterator<Item = [f32; 4]>) -> [[f32; 4]; 2] {
    let none = [[f32::INFINITY; 4], [f32::NEG_INFINITY; 4]];
    values.fold(none, |[low, high], value| {
        [
            std::array::from_fn(|c| low[c].min(value[c])),
            std::array::from_fn(|c| high[c].max(value[c])),
        ]
    })
}

/// Where each block's planes stand in a row, and the row's length, both in words.
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
            let (first_place, lanes_place) = match property {
                Property::Rotation => (&mut block.rotation_first, &mut block.rotation_lanes),
                Property::Translation => {
                    (&mut block.translation_first, &mut block.translation_lanes)
                }
                Property::Scale => (&mut block.scale_first, &mut block.scale_lanes),
            };
            (*first_place, *lanes_place) = (stride, lanes);
            stride += words;
        }
    }
    (blocks, stride as usize)
}
