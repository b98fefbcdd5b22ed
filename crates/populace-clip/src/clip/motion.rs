//! Root motion: the motion of the whole body over the ground, taken out of a clip's pose.

use glam::{DQuat, DVec3};
use populace_model::humanoid::{Role, RoleMap};
use populace_model::{ClipSource, Interpolation, JointIndex, Property, Track, f64math};

use super::Clip;
use crate::curves::{Curves, Side};
use crate::{Error, MotionFault};

/// Minimum rows per second, within the limits below; rows divide the clip's length evenly.
const ROWS_PER_SEC: f64 = 60.0;
/// Limits on the rows of a motion: this many per row of the clip, plus this many, or this many poses
/// of one joint in total. A clip of few keys that is longer than ten minutes has fewer rows per
/// second instead of a disproportionate amount of memory.
const ROWS_PER_ROW: usize = 8;
const FREE_ROWS: usize = 36_000;
const FREE_POSES: usize = 64 * FREE_ROWS;
/// A body counts as standing if it ends no further from its start than this fraction of its size,
/// or of its size per second. The same limit holds for the speed of its feet.
const STANDING: f64 = 0.05;
/// A body counts as not turning if its heading changes by no more than this, in radians.
const TURNING_RAD: f64 = 0.25;

/// The source of root motion.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum MotionSource {
    /// [`Root`](Self::Root) if the root travels or turns; [`Feet`](Self::Feet) for a clip that
    /// walks in place; no motion for a clip that stands still, whose sway stays in the pose.
    /// [`RootMotion::origin`] tells which was chosen.
    #[default]
    Auto,
    /// The first moving joint from the root down to the hips. Without hips, the first joint whose
    /// translation moves.
    Root,
    /// The joint of this name; its ancestors must not move.
    Joint(String),
    /// The feet of a clip that walks in place: straight ahead along +Z, at the speed at which
    /// planted feet move backwards
    /// ([`ClipStats::ground_speed_m_per_sec`](crate::ClipStats::ground_speed_m_per_sec)).
    Feet,
}

/// The source that root motion was taken from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionOrigin {
    /// The joint of this name.
    Joint(String),
    /// The feet of a clip that walks in place.
    Feet,
    /// Nothing: the body stands still and has no motion.
    Nothing,
}

/// Settings for taking root motion out of a clip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionSettings {
    /// The source of the motion.
    pub from: MotionSource,
    /// True if the heading is part of the motion. Otherwise turns stay in the pose.
    pub turns: bool,
    /// True if the height is part of the motion. Otherwise it stays in the pose.
    pub rises: bool,
}

impl Default for MotionSettings {
    /// Any source, with heading, without height.
    fn default() -> Self {
        Self { from: MotionSource::Auto, turns: true, rises: false }
    }
}

/// A rotation about +Y followed by a translation, of the whole body in model space.
#[derive(Clone, Copy, Debug)]
struct Rigid {
    shift: DVec3,
    /// Sine and cosine of the heading. Heading 0 faces +Z, a quarter turn +X.
    heading: [f64; 2],
}

impl Rigid {
    const NONE: Self = Self { shift: DVec3::ZERO, heading: [0.0, 1.0] };

    fn rotation(&self) -> DQuat {
        DQuat::from_rotation_y(self.heading[0].atan2(self.heading[1]))
    }

    /// Composes two transforms: `next` is applied first.
    fn then(&self, next: &Self) -> Self {
        let ([s, c], [t, d]) = (self.heading, next.heading);
        Self {
            shift: self.shift + self.rotation() * next.shift,
            heading: [s * d + c * t, c * d - s * t],
        }
    }

    fn inverse(&self) -> Self {
        let back = Self { shift: DVec3::ZERO, heading: [-self.heading[0], self.heading[1]] };
        Self { shift: -(back.rotation() * self.shift), ..back }
    }

    /// Applies the transform `count` times; `count` is a whole number.
    fn times(&self, count: f64) -> Self {
        let yaw = self.heading[0].atan2(self.heading[1]);
        // About the fixed point of the transform, or straight ahead if there is none.
        let turn = DQuat::from_rotation_y(yaw * count);
        let [across, along] = [1.0 - self.heading[1], self.heading[0]];
        let squared = across * across + along * along;
        let heading = [(yaw * count).sin(), (yaw * count).cos()];
        if squared < 1e-12 {
            return Self { shift: self.shift * count, heading };
        }
        let DVec3 { x, y, z } = self.shift;
        let middle = DVec3::new(x * across + z * along, 0.0, z * across - x * along) / squared;
        Self { shift: middle - turn * middle + DVec3::Y * (y * count), heading }
    }

    /// Interpolates as devices do.
    fn mix(&self, to: &Self, part: f64) -> Self {
        let [sin, cos] = [0, 1].map(|i| self.heading[i] + (to.heading[i] - self.heading[i]) * part);
        let length = sin.hypot(cos);
        Self { shift: self.shift.lerp(to.shift, part), heading: [sin / length, cos / length] }
    }
}

/// The root motion of a clip: evenly spaced rows, relative to the first.
#[derive(Clone, Debug)]
pub struct RootMotion {
    rows: Vec<Rigid>,
    duration_secs: f64,
    origin: MotionOrigin,
}

impl RootMotion {
    /// Returns the motion after `secs` seconds of the clip, clamped to its length, relative to its
    /// start: metres in the clip's own model space, and heading about +Y in radians.
    #[must_use]
    pub fn at(&self, secs: f32) -> ([f32; 3], f32) {
        position_and_yaw(&self.rigid(f64::from(secs)))
    }

    /// Like [`at`](Self::at), after playing the clip in a loop for `secs` seconds, starting at
    /// `phase` from 0 to 1.
    #[must_use]
    pub fn looped(&self, phase: f32, secs: f32) -> ([f32; 3], f32) {
        let finite = |value: f32| if value.is_finite() { f64::from(value).max(0.0) } else { 0.0 };
        let begun = finite(phase) * self.duration_secs;
        let end = begun + finite(secs);
        let cycles =
            if self.duration_secs > 0.0 { (end / self.duration_secs).floor() } else { 0.0 };
        let moved = self.rigid(begun).inverse().then(&self.rigid(self.duration_secs).times(cycles));
        position_and_yaw(&moved.then(&self.rigid(end - cycles * self.duration_secs)))
    }

    /// The source that the motion was taken from.
    #[must_use]
    pub fn origin(&self) -> &MotionOrigin {
        &self.origin
    }

    /// Mean speed along the path in metres per second; 0 for a clip of length 0.
    #[must_use]
    pub fn metres_per_sec(&self) -> f32 {
        let distance_m: f64 =
            self.rows.windows(2).map(|pair| pair[0].shift.distance(pair[1].shift)).sum();
        if self.duration_secs > 0.0 {
            f64math::to_f32([distance_m / self.duration_secs])[0]
        } else {
            0.0
        }
    }

    /// Returns whether the motion moves a body of this size noticeably, or turns it.
    fn travels(&self, size: f64) -> bool {
        let end = self.rows[self.rows.len() - 1];
        let farthest = self.rows.iter().map(|row| row.shift.length()).fold(0.0, f64::max);
        let turned = end.heading[0].atan2(end.heading[1]).abs();
        end.shift.length() > STANDING * size * self.duration_secs.max(1.0)
            || farthest > size
            || turned > TURNING_RAD
    }

    fn rigid(&self, secs: f64) -> Rigid {
        let last = self.rows.len() - 1;
        let place =
            if self.duration_secs > 0.0 { secs / self.duration_secs * last as f64 } else { 0.0 };
        let place = place.clamp(0.0, last as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "held to the rows"
        )]
        let row = (place as usize).min(last.saturating_sub(1));
        self.rows[row].mix(&self.rows[last.min(row + 1)], place - row as f64)
    }

    /// Rows in the form that devices read: `x y z 0`, then sine and cosine of the heading.
    pub fn device_rows(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        self.rows.iter().flat_map(|rigid| {
            let [sin, cos] = f64math::to_f32(rigid.heading);
            let [x, y, z] = f64math::to_f32(rigid.shift.to_array());
            [[x, y, z, 0.0], [sin, cos, 0.0, 0.0]]
        })
    }

    /// The number of rows; at least two.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Rows per second; 0 for a clip of no length.
    #[must_use]
    pub fn rows_per_sec(&self) -> f32 {
        let per_sec = (self.rows.len() - 1) as f64 / self.duration_secs;
        if self.duration_secs > 0.0 { f64math::to_f32([per_sec])[0] } else { 0.0 }
    }
}

/// Converts to metres and radians.
fn position_and_yaw(rigid: &Rigid) -> ([f32; 3], f32) {
    let [yaw] = f64math::to_f32([rigid.heading[0].atan2(rigid.heading[1])]);
    (f64math::to_f32(rigid.shift.to_array()), yaw)
}

impl Clip {
    /// Returns the clip with the motion of the whole body taken out of its pose. Members with root
    /// motion enabled follow it; others play the clip in place. [`RootMotion::origin`] of its
    /// [`root_motion`](Self::root_motion) tells where the motion was taken from.
    ///
    /// # Errors
    ///
    /// [`Error::NoMotion`] if the chosen source does not move the body or has a moving ancestor,
    /// for a clip that is live or has its root motion already, and for one that was converted to
    /// another skeleton ([`converted`](Self::converted), [`arranged`](Self::arranged));
    /// [`UnknownJoints`](populace_model::Error::UnknownJoints) with the nearest names.
    pub fn with_root_motion(&self, settings: &MotionSettings) -> Result<Self, Error> {
        if self.ring.is_some() || self.motion.is_some() {
            return self.no_motion(MotionFault::Taken);
        }
        let moves = self.ranges().iter().flatten().any(|range| range.step > 0.0);
        if moves && self.source.tracks.is_empty() {
            return self.no_motion(MotionFault::NoSource);
        }
        match &settings.from {
            MotionSource::Auto => self.with_automatic_motion(settings),
            MotionSource::Feet => match self.contacts.speed {
                Some(speed) => Ok(self.with_even_motion(f64::from(speed), MotionOrigin::Feet)),
                None => self.no_motion(MotionFault::NoTouchDown),
            },
            from => {
                let taken = self.with_motion_of(self.carrier(from)?, settings, |_| true)?;
                Ok(taken.unwrap_or_else(|| self.clone()))
            }
        }
    }

    /// Takes out the motion of the first source that moves the body, if any does.
    fn with_automatic_motion(&self, settings: &MotionSettings) -> Result<Self, Error> {
        let size = f64::from(self.skeleton.size_m());
        if let Ok(joint) = self.carrier(&MotionSource::Root)
            && let Some(taken) =
                self.with_motion_of(joint, settings, |motion| motion.travels(size))?
        {
            return Ok(taken);
        }
        match self.contacts.speed.filter(|speed| f64::from(speed.abs()) > STANDING * size) {
            Some(speed) => Ok(self.with_even_motion(f64::from(speed), MotionOrigin::Feet)),
            None => Ok(self.with_even_motion(0.0, MotionOrigin::Nothing)),
        }
    }

    /// Takes out the motion of a joint if `wanted` accepts it.
    fn with_motion_of(
        &self,
        joint: JointIndex,
        settings: &MotionSettings,
        wanted: impl Fn(&RootMotion) -> bool,
    ) -> Result<Option<Self>, Error> {
        let curves = Curves::new(&self.source, &self.skeleton)?;
        let carrier = Carrier::new(self, &curves, joint);
        let (start, duration) = (f64::from(self.start_secs()), f64::from(self.duration_secs()));
        let last = self.motion_rows(duration);
        let times = (0..=last).map(|row| start + duration * row as f64 / last as f64);
        let motion = RootMotion {
            rows: carrier.rows(times.clone(), settings),
            duration_secs: duration,
            origin: MotionOrigin::Joint(self.skeleton.name(joint).to_owned()),
        };
        if !wanted(&motion) {
            return Ok(None);
        }
        let tracks = carrier.in_place(&motion, times, settings.turns);
        let of_joint = |track: &&Track| track.joint == self.skeleton.name(joint);
        let replaced = |track: &Track| tracks.iter().any(|new| new.property == track.property);
        let kept = self
            .source
            .tracks
            .iter()
            .filter(|track| !(of_joint(track) && replaced(track)))
            .cloned();
        let source = ClipSource {
            name: self.source.name.clone(),
            tracks: kept.chain(tracks.clone()).collect(),
        };
        Ok(Some(Self { motion: Some(motion), ..Self::new(source, &self.skeleton)? }))
    }

    /// The number of rows of a motion of this length, less the first.
    fn motion_rows(&self, duration_secs: f64) -> usize {
        let free = FREE_ROWS.min(FREE_POSES / self.skeleton.joint_count().max(1));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; `as` saturates"
        )]
        let wanted = (duration_secs * ROWS_PER_SEC).ceil().max(1.0) as usize;
        wanted.min(ROWS_PER_ROW * self.row_count() + free)
    }

    /// The root motion that was taken out of the clip, if any.
    #[must_use]
    pub fn root_motion(&self) -> Option<&RootMotion> {
        self.motion.as_ref()
    }

    fn no_motion<T>(&self, fault: MotionFault) -> Result<T, Error> {
        Err(Error::NoMotion { clip: self.name().to_owned(), fault })
    }

    /// Adds a motion straight ahead at a speed in metres per second.
    fn with_even_motion(&self, speed: f64, origin: MotionOrigin) -> Self {
        let duration_secs = f64::from(self.duration_secs());
        let end = Rigid { shift: DVec3::new(0.0, 0.0, speed * duration_secs), ..Rigid::NONE };
        let motion = RootMotion { rows: vec![Rigid::NONE, end], duration_secs, origin };
        Self { motion: Some(motion), ..self.clone() }
    }

    /// Returns the joint that carries the body.
    fn carrier(&self, from: &MotionSource) -> Result<JointIndex, Error> {
        let moves = |joint: &JointIndex| {
            let [translation, rotation, _] = self.rows.storage.ranges[joint.index()];
            translation.step > 0.0 || rotation.step > 0.0
        };
        let above = |joint: JointIndex| {
            let mut path: Vec<_> =
                std::iter::successors(Some(joint), |joint| self.skeleton.parent(*joint)).collect();
            path.reverse();
            path
        };
        if let MotionSource::Joint(name) = from {
            let [joint] = self.skeleton.find_all(std::slice::from_ref(name))?[..] else {
                return self.no_motion(MotionFault::AmbiguousJoint);
            };
            let path = above(joint);
            return match path[..path.len() - 1].iter().find(|joint| moves(joint)) {
                Some(moving) => self.no_motion(MotionFault::MovingAncestor {
                    ancestor: self.skeleton.name(*moving).to_owned(),
                    joint: name.clone(),
                }),
                None => Ok(joint),
            };
        }
        let hips = RoleMap::detect(&self.skeleton).and_then(|roles| roles.joint(Role::Hips));
        let shifts = |joint: &JointIndex| self.rows.storage.ranges[joint.index()][0].step > 0.0;
        let found = match hips {
            Some(hips) => above(hips).into_iter().find(moves),
            None => self.skeleton.joints().find(|joint| {
                shifts(joint) && !above(*joint).iter().any(|a| a != joint && moves(a))
            }),
        };
        match found {
            Some(joint) => Ok(joint),
            None => self.no_motion(MotionFault::NoMovingJoint),
        }
    }
}

/// The joint whose motion is taken out, with the source curves.
struct Carrier<'a> {
    clip: &'a Clip,
    curves: &'a Curves<'a>,
    joint: JointIndex,
    /// Model transform of the joint's parent, which does not move.
    parent_model: glam::DAffine3,
    /// Rotation of the parent in model space.
    parent_rotation: DQuat,
}

impl<'a> Carrier<'a> {
    fn new(clip: &'a Clip, curves: &'a Curves<'a>, joint: JointIndex) -> Self {
        let (skeleton, start) = (&clip.skeleton, f64::from(clip.start_secs()));
        let local = |joint| curves.local(joint, start, Side::After);
        let models = f64math::model_from_joints(
            skeleton.parents(),
            skeleton.joints().map(|j| local(j).affine()),
        );
        let turns = f64math::model_rotations(
            skeleton.parents(),
            skeleton.joints().map(|j| local(j).rotation),
        );
        let parent = skeleton.parent(joint);
        let parent_model = parent.map_or(glam::DAffine3::IDENTITY, |parent| models[parent.index()]);
        let parent_rotation = parent.map_or(DQuat::IDENTITY, |parent| turns[parent.index()]);
        Self { clip, curves, joint, parent_model, parent_rotation }
    }

    /// Returns position and rotation of the joint in model space.
    fn model(&self, secs: f64) -> (DVec3, DQuat) {
        let local = self.curves.local(self.joint, secs, Side::After);
        (
            self.parent_model.transform_point3(local.translation),
            self.parent_rotation * local.rotation,
        )
    }

    fn rows(&self, times: impl Iterator<Item = f64>, settings: &MotionSettings) -> Vec<Rigid> {
        let mut rows: Vec<Rigid> = Vec::new();
        let mut first = None;
        for secs in times {
            let (place, turn) = self.model(secs);
            let (place0, turn0) = *first.get_or_insert((place, turn));
            let mut rigid = Rigid {
                heading: rows.last().map_or([0.0, 1.0], |last| last.heading),
                ..Rigid::NONE
            };
            let DQuat { y, w, .. } = turn * turn0.inverse();
            // An upside-down body has no heading and keeps the last one.
            if settings.turns && y * y + w * w > 1e-6 {
                let length = y * y + w * w;
                rigid.heading = [2.0 * y * w / length, (w * w - y * y) / length];
            }
            rigid.shift = place - rigid.rotation() * place0;
            if !settings.rises {
                rigid.shift.y = 0.0;
            }
            rows.push(rigid);
        }
        rows
    }

    /// Returns tracks of the joint's motion without the root motion.
    fn in_place(
        &self,
        motion: &RootMotion,
        times: impl Iterator<Item = f64>,
        turns: bool,
    ) -> Vec<Track> {
        let own =
            [Property::Translation, Property::Rotation].map(|p| self.curves.track(self.joint, p));
        let keys = own.into_iter().flatten().flat_map(|track| &track.times).copied();
        let mut times: Vec<f32> =
            times.map(|secs| f64math::to_f32([secs])[0]).chain(keys).collect();
        times.sort_by(f32::total_cmp);
        times.dedup();
        let track = |property: Property, values: Vec<f32>| Track {
            joint: self.clip.skeleton.name(self.joint).to_owned(),
            property,
            interpolation: Interpolation::Linear,
            times: times.clone(),
            values,
        };
        let (mut places, mut rotations) = (Vec::new(), Vec::new());
        let below = self.parent_model.inverse();
        for secs in &times {
            let (place, turn) = self.model(f64::from(*secs));
            let rigid = motion.rigid(f64::from(*secs) - f64::from(self.clip.start_secs()));
            let back = rigid.rotation().inverse();
            places.extend(f64math::to_f32(
                below.transform_point3(back * (place - rigid.shift)).to_array(),
            ));
            let rotation = self.parent_rotation.inverse() * back * turn;
            rotations.extend(f64math::to_f32(rotation.normalize().to_array()));
        }
        let mut tracks = vec![track(Property::Translation, places)];
        if turns {
            tracks.push(track(Property::Rotation, rotations));
        }
        tracks
    }
}

#[cfg(test)]
mod tests;
