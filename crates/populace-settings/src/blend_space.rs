//! Blend spaces: clips at points of a line or a plane, and their weights at points between.

mod plane;

use populace_model::convert::single;

use crate::check::{Check, bounded};
use crate::error::Error;
use crate::fault::BlendSpaceFault;
use crate::ids::ClipId;
use plane::Plane;

/// The most clips with a weight at one point: the corners of a triangle.
pub const MOST: usize = 3;
/// Clips and their weights at a point; entries of weight 0 are unused.
pub type Weights = [(usize, f32); MOST];

/// A point of a blend space: a speed, or a speed and a turn rate, in the units of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// The coordinate on the first axis, the only one of a line.
    pub speed: f32,
    /// The coordinate on the second axis; ignored by a line.
    pub turn: f32,
    /// Cycles per second of the shared phase; negative plays backwards. `None` for the weighted
    /// mean of the clips' own, times
    /// [`BlendSpacePlayback::speed`](crate::BlendSpacePlayback::speed).
    pub cycles_per_sec: Option<f32>,
}

impl From<f32> for SpacePoint {
    fn from(speed: f32) -> Self {
        Self::from([speed, 0.0])
    }
}

impl From<[f32; 2]> for SpacePoint {
    fn from([speed, turn]: [f32; 2]) -> Self {
        Self { speed, turn, cycles_per_sec: None }
    }
}

impl SpacePoint {
    /// Sets the cycles per second of the shared phase.
    #[must_use]
    pub const fn at_cycles_per_sec(mut self, cycles_per_sec: f32) -> Self {
        self.cycles_per_sec = Some(cycles_per_sec);
        self
    }
}

impl Check for SpacePoint {
    fn check(&self) -> Result<(), Error> {
        bounded("the point of a blend space", &[self.speed, self.turn])?;
        let rate = self.cycles_per_sec.unwrap_or_default();
        bounded("the cycles per second of a blend space", &[rate])
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Values and the indices of their samples, in ascending order.
    Line(Vec<(f32, usize)>),
    Plane(Plane),
}

/// Clips at points of a line or a plane, mixed by the position of a member between them: idle, walk
/// and run by speed, or by speed and turn rate.
///
/// At a sample its clip plays alone. Between samples the two or three nearest clips play, with
/// linear weights. Outside of the samples the nearest point among them counts.
///
/// All clips share one phase, so that their feet touch the ground together. The phase advances at
/// the weighted mean of the clips' own cycles per second. Clips of no length do not count towards
/// it. [`with_offset`](Self::with_offset) aligns a clip that starts with the other foot.
///
/// ```
/// # use populace::{BlendSpace, BlendSpacePlayback, Crowd, Device, Placement};
/// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
/// # let knight = populace::doc_fixture::knight(&mut crowd)?;
/// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
/// let idle = crowd.clip(knight, "Idle")?;
/// let walk = crowd.clip(knight, "Walk")?;
/// let run = crowd.clip(knight, "Run")?;
/// let gait = BlendSpace::line(&[(idle, 0.0), (walk, 1.5), (run, 3.5)])?;
/// assert_eq!(gait.weights(2.5)?, [(walk, 0.5), (run, 0.5)]);
///
/// let gait = crowd.add_blend_space(gait)?;
/// let mut knight = crowd.member_mut(member)?;
/// knight.play_blend_space(gait, 1.5, BlendSpacePlayback::new())?;
/// knight.set_blend_parameter(3.5, 0.5)?; // from a walk into a run in half a second
/// crowd.update(0.25)?;
/// assert_eq!(crowd.member(member)?.active_clips().len(), 2);
/// # Ok::<(), populace::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BlendSpace {
    clips: Vec<ClipId>,
    /// Of a cycle, for each clip.
    offsets: Vec<f32>,
    shape: Shape,
}

impl BlendSpace {
    /// Returns a blend space of clips at values of one axis, such as speeds in metres per second,
    /// in any order.
    ///
    /// # Errors
    ///
    /// [`Error::BadBlendSpace`] without samples, with more than 1,000, or with two samples at one
    /// value; a value that is not finite.
    pub fn line(samples: &[(ClipId, f32)]) -> Result<Self, Error> {
        let mut values: Vec<_> =
            samples.iter().enumerate().map(|(index, (_, at))| (*at, index)).collect();
        bounded(
            "a sample of a blend space",
            &values.iter().map(|(at, _)| *at).collect::<Vec<_>>(),
        )?;
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(pair) = values.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(bad(BlendSpaceFault::SameValue(pair[0].0)));
        }
        Self::new(samples.iter().map(|(clip, _)| *clip), Shape::Line(values))
    }

    /// Returns a blend space of clips at points of two axes, such as speed in metres per second and
    /// turn rate in radians per second, in any order.
    ///
    /// The points are triangulated (Delaunay, each axis divided by the extent of the samples). If
    /// all points lie on one line, the blend space is that line.
    ///
    /// # Errors
    ///
    /// As for [`line`](Self::line). Points that differ by less than a millionth of the extent of
    /// the samples along each axis are one point.
    pub fn plane(samples: &[(ClipId, [f32; 2])]) -> Result<Self, Error> {
        let points: Vec<_> = samples.iter().map(|(_, at)| *at).collect();
        bounded("a sample of a blend space", points.as_flattened())?;
        check_count(points.len())?;
        if let Some(at) = plane::doubled(&points) {
            return Err(bad(BlendSpaceFault::SamePoint(at)));
        }
        Self::new(samples.iter().map(|(clip, _)| *clip), Shape::Plane(Plane::new(&points)))
    }

    fn new(clips: impl Iterator<Item = ClipId>, shape: Shape) -> Result<Self, Error> {
        let clips: Vec<_> = clips.collect();
        check_count(clips.len())?;
        Ok(Self { offsets: vec![0.0; clips.len()], clips, shape })
    }

    /// Sets the phase of a clip, 0 to 1, at the start of the shared cycle, so that its feet touch
    /// the ground together with those of the other clips.
    ///
    /// # Errors
    ///
    /// [`Error::BadBlendSpace`] if the space has no such clip; an offset that is not finite.
    pub fn with_offset(mut self, clip: ClipId, cycles: f32) -> Result<Self, Error> {
        bounded("the phase offset of a clip", &[cycles])?;
        if !self.clips.contains(&clip) {
            return Err(bad(BlendSpaceFault::NoSuchClip));
        }
        let own = self.clips.iter().zip(&mut self.offsets).filter(|(own, _)| **own == clip);
        own.for_each(|(_, offset)| *offset = cycles);
        Ok(self)
    }

    /// The clips, in the order in which they were given.
    #[must_use]
    pub fn clips(&self) -> &[ClipId] {
        &self.clips
    }

    /// Returns the clips that play at a point and their weights, which sum to 1: at most two on a
    /// line and three on a plane.
    ///
    /// # Errors
    ///
    /// A point that is not finite.
    pub fn weights(&self, at: impl Into<SpacePoint>) -> Result<Vec<(ClipId, f32)>, Error> {
        let at = at.into();
        at.check()?;
        let weights = weights_at(self, at);
        let weighing = weights.iter().filter(|(_, weight)| *weight > 0.0);
        Ok(weighing.map(|(index, weight)| (self.clips[*index], *weight)).collect())
    }
}

/// The number of slots that any one point of a blend space needs.
#[must_use]
pub fn slots_needed(space: &BlendSpace) -> usize {
    let most = match space.shape {
        Shape::Line(_) => 2,
        Shape::Plane(_) => MOST,
    };
    most.min(space.clips.len())
}

/// The phase of a sample's clip at the start of the shared cycle.
#[must_use]
pub fn phase_offset(space: &BlendSpace, sample: usize) -> f32 {
    space.offsets[sample]
}

/// Returns the samples that play at a point of a blend space, and their weights.
#[must_use]
pub fn weights_at(space: &BlendSpace, at: SpacePoint) -> Weights {
    match &space.shape {
        Shape::Line(values) => on_line(values, at.speed),
        Shape::Plane(plane) => plane.weights([at.speed, at.turn].map(f64::from)),
    }
}

fn on_line(values: &[(f32, usize)], at: f32) -> Weights {
    let above = values.partition_point(|(value, _)| *value <= at);
    let mut weights = [(0, 0.0); MOST];
    match (above.checked_sub(1).map(|below| values[below]), values.get(above)) {
        (Some((low, below)), Some(&(high, above))) => {
            let [at, low, high] = [at, low, high].map(f64::from);
            let share = (at - low) / (high - low);
            weights[..2].copy_from_slice(&[(below, single(1.0 - share)), (above, single(share))]);
        }
        (Some((_, only)), None) | (None, Some(&(_, only))) => weights[0] = (only, 1.0),
        (None, None) => {}
    }
    weights
}

fn check_count(count: usize) -> Result<(), Error> {
    if (1..=1000).contains(&count) { Ok(()) } else { Err(bad(BlendSpaceFault::SampleCount(count))) }
}

fn bad(fault: BlendSpaceFault) -> Error {
    Error::BadBlendSpace(fault)
}
