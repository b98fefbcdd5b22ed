//! Blend spaces: clips at points of speed, or of speed and turn, and how much each weighs at a
//! point between them.

mod plane;

use populace_model::convert::single;

use crate::error::bounded;
use crate::{ClipId, Error};
use plane::Plane;

/// The most clips that weigh at once: the corners of a triangle.
pub(crate) const MOST: usize = 3;
/// Clips and their weights at a point; those of weight 0 are places left over.
pub(crate) type Weights = [(usize, f32); MOST];

/// A point of a blend space: a speed, or a speed and a turn, in the units of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpacePoint {
    /// Along the first axis; a line has no other.
    pub speed: f32,
    /// Along the second axis; not looked at in a line.
    pub turn: f32,
}

impl From<f32> for SpacePoint {
    fn from(speed: f32) -> Self {
        Self { speed, turn: 0.0 }
    }
}

impl From<[f32; 2]> for SpacePoint {
    fn from([speed, turn]: [f32; 2]) -> Self {
        Self { speed, turn }
    }
}

impl SpacePoint {
    pub(crate) fn check(self) -> Result<Self, Error> {
        bounded("the point of a blend space", &[self.speed, self.turn])?;
        Ok(self)
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Values and the samples that stand there, in ascending order.
    Line(Vec<(f32, usize)>),
    Plane(Plane),
}

/// Clips at points of a line or a plane, mixed by where a member is between them: an idle, a walk
/// and a run by speed, or turns to either side too.
///
/// At a sample its clip alone plays; between samples the two or three around the point do, and
/// their weights run evenly from one to the other. Outside of all samples the nearest point among
/// them counts.
///
/// All clips of a space share one phase, so that feet that touch the ground together stay together.
/// It runs at the mean of the clips' own cycles per second, by their weights; clips of no length
/// have none and follow. Where a clip begins with another foot than the others,
/// [`with_offset`](Self::with_offset) says how far into the cycle.
///
/// ```
/// # use populace::{BlendSpace, Crowd, Device, Placement, Play};
/// # use populace::character::{Character, CharacterSource, PaletteEntry};
/// # use populace::clip::Clip;
/// # use populace::model::{Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs};
/// # let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
/// # let skeleton = Skeleton::new(&[joint])?;
/// # let clip = |name: &str, secs| { let track = Track { joint: "hips".into(), property: Property::Translation,
/// #     interpolation: Interpolation::Linear, times: vec![0.0, secs], values: vec![0.0; 6] };
/// #     Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, &skeleton) };
/// # let clips = vec![clip("Idle", 4.0)?.into(), clip("Walk", 1.0)?.into(), clip("Run", 0.5)?.into()];
/// # let knight = Character::new(CharacterSource { name: "knight".into(), palette: vec![],
/// #     skeleton: skeleton.clone(), parts: vec![], materials: vec![], images: vec![], skins: vec![], clips })?;
/// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
/// # let knight = crowd.add_character(knight)?;
/// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
/// let (idle, walk, run) = (crowd.clip(knight, "Idle")?, crowd.clip(knight, "Walk")?, crowd.clip(knight, "Run")?);
/// let gait = BlendSpace::line(&[(idle, 0.0), (walk, 1.5), (run, 3.5)])?;
/// assert_eq!(gait.weights(2.5)?, [(walk, 0.5), (run, 0.5)]);
///
/// let gait = crowd.add_space(gait)?;
/// crowd.play_space(member, gait, 1.5, Play::looping())?;
/// crowd.update(0.1)?;
/// crowd.steer(member, 3.5, 0.5)?; // from a walk into a run in half a second
/// crowd.update(0.25)?;
/// assert_eq!(crowd.playing(member)?.len(), 2);
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
    /// Clips at values of one axis, such as speeds in metres per second, in any order.
    ///
    /// # Errors
    ///
    /// [`Error::BadBlendSpace`] without samples, with more than 1,000, or where two are at one
    /// value; a value that is not finite.
    pub fn line(samples: &[(ClipId, f32)]) -> Result<Self, Error> {
        let mut values: Vec<_> =
            samples.iter().enumerate().map(|(index, (_, at))| (*at, index)).collect();
        bounded(
            "a sample of a blend space",
            &values.iter().map(|(at, _)| *at).collect::<Vec<_>>(),
        )?;
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        if values.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return Err(bad("has two samples at one value; put each at its own"));
        }
        Self::new(samples.iter().map(|(clip, _)| *clip), Shape::Line(values))
    }

    /// Clips at points of two axes, such as speed in metres per second and turn in radians per
    /// second, in any order.
    ///
    /// Points are joined to triangles (Delaunay's, with each axis measured by how far the samples
    /// spread along it). Where all stand on one line, the plane is that line.
    ///
    /// # Errors
    ///
    /// As for [`line`](Self::line).
    pub fn plane(samples: &[(ClipId, [f32; 2])]) -> Result<Self, Error> {
        let points: Vec<_> = samples.iter().map(|(_, at)| *at).collect();
        bounded("a sample of a blend space", points.as_flattened())?;
        if points.iter().enumerate().any(|(nth, at)| points[..nth].contains(at)) {
            return Err(bad("has two samples at one point; put each at its own"));
        }
        check_count(points.len())?;
        Self::new(samples.iter().map(|(clip, _)| *clip), Shape::Plane(Plane::new(&points)))
    }

    fn new(clips: impl Iterator<Item = ClipId>, shape: Shape) -> Result<Self, Error> {
        let clips: Vec<_> = clips.collect();
        check_count(clips.len())?;
        Ok(Self { offsets: vec![0.0; clips.len()], clips, shape })
    }

    /// Says how far into its own cycle a clip is when the space's phase begins, from 0 to 1, so
    /// that its feet fall with those of the others.
    ///
    /// # Errors
    ///
    /// [`Error::BadBlendSpace`] where the space has no such clip; an offset that is not finite.
    pub fn with_offset(mut self, clip: ClipId, cycles: f32) -> Result<Self, Error> {
        bounded("the phase offset of a clip", &[cycles])?;
        if !self.clips.contains(&clip) {
            return Err(bad("does not have the clip that an offset is given for"));
        }
        let own = self.clips.iter().zip(&mut self.offsets).filter(|(own, _)| **own == clip);
        own.for_each(|(_, offset)| *offset = cycles);
        Ok(self)
    }

    /// The clips, in the order they were given.
    #[must_use]
    pub fn clips(&self) -> &[ClipId] {
        &self.clips
    }

    /// The clips that play at a point with their weights, which sum to 1; at most two in a line and
    /// three in a plane.
    ///
    /// # Errors
    ///
    /// A point that is not finite.
    pub fn weights(&self, at: impl Into<SpacePoint>) -> Result<Vec<(ClipId, f32)>, Error> {
        let weights = self.weights_at(at.into().check()?);
        let weighing = weights.iter().filter(|(_, weight)| *weight > 0.0);
        Ok(weighing.map(|(index, weight)| (self.clips[*index], *weight)).collect())
    }

    /// Slots that are needed to stand still at any point.
    pub(crate) fn slots_needed(&self) -> usize {
        let most = match self.shape {
            Shape::Line(_) => 2,
            Shape::Plane(_) => MOST,
        };
        most.min(self.clips.len())
    }

    pub(crate) fn offset(&self, sample: usize) -> f32 {
        self.offsets[sample]
    }

    pub(crate) fn weights_at(&self, at: SpacePoint) -> Weights {
        match &self.shape {
            Shape::Line(values) => on_line(values, at.speed),
            Shape::Plane(plane) => plane.weights([at.speed, at.turn].map(f64::from)),
        }
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
    if (1..=1000).contains(&count) { Ok(()) } else { Err(bad("needs 1 to 1,000 samples")) }
}

pub(crate) fn bad(reason: &str) -> Error {
    Error::BadBlendSpace { reason: reason.to_owned() }
}
