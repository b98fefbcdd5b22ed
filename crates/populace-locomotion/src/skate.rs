//! Foot skate: how fast planted soles move over the ground, on a standard course.

mod body;
mod course;
mod meter;
mod samples;
mod walk;

use std::sync::Arc;

use populace::character::Character;

use crate::{Error, GaitClips};
use course::{COURSE, Course};
pub use meter::{FootSkate, SkateMeter};
use samples::Samples;

/// Measurements on one part of the standard course, or on all of it.
///
/// # How it is measured
///
/// The course goes straight at 0.3, 0.8, 1.3, 2, 3 and 4 m/s, round a circle of 3 m radius, from
/// standing to 1.3 m/s and back, through three quarters of half a turn on the spot and back, and up
/// stairs of 0.15 m by 0.3 m. A [`Walkers`](crate::Walkers) walks it on the native device at 60
/// frames a second and at the character's own size. The first seconds of a part, in which it comes
/// to its speed, are not measured; a start, a stop and turns are measured as they are.
///
/// A foot is *planted* in frames in which the clips have it in contact: contacts are those of
/// [`Gait`](crate::Gait), and the seconds to their nearest ends are averaged by the weights of the
/// clips that play. What the device does with the foot does not matter. The *planted point* is the
/// lowest point of the sole. From each planted frame to the next one, the skate is the distance in
/// the world, along X and Z, that the planted point of the first covers, divided by the time.
///
/// Planting is done by the feet's constraint of the device
/// ([`MemberMut::plant_feet`](populace::MemberMut::plant_feet)), which applies the member's
/// [`Stride`](populace::Stride) too. Without planting neither is applied: steps have the length of
/// the mixed clips.
#[derive(Clone, Debug, PartialEq)]
pub struct Skate {
    /// The part of the course; `all` for all of it.
    pub segment: &'static str,
    /// True if the device plants the feet.
    pub planting: bool,
    /// Mean speed of planted points, in metres per second.
    pub mean_m_per_sec: f32,
    /// The speed below which 95 % of planted points are, in metres per second.
    pub p95_m_per_sec: f32,
    /// The error of the speed on straight parts, as a fraction of the requested speed; 0 for other
    /// parts. It is the larger error of two speeds: that of the body, by the distance it covers,
    /// and that of the gait. The speed of the gait is that at which the ground passes beneath the
    /// body before feet are locked to it: the median, over all planted points of whole cycles, of
    /// their velocity backwards in model space. With planting it includes the stride. Straight
    /// parts are walked four times for it, each a quarter of a frame later in the cycle.
    pub speed_error: f32,
    /// The distance from the ground within which 95 % of planted points are, above or below, as a
    /// fraction of the body's height.
    pub sole_error: f32,
    /// The largest acceleration of a joint of the legs, from hips to ankles, in model space, as a
    /// multiple of the largest in the moving clips, each played alone without planting. It is taken
    /// from three frames in a row.
    pub acceleration_ratio: f32,
    /// The share of all frames in which a foot is planted, mean of both feet, 0 to 1.
    pub contact_share: f32,
}

impl Skate {
    /// Walks a character over the course, once with its feet planted and once without, on the
    /// native device. Returns both results for each part and for `all`. In `all` every planted
    /// frame counts alike, and errors of speed and accelerations are the largest of all parts.
    ///
    /// # Errors
    ///
    /// Clips that do not walk on the character ([`GaitSpace::new`](crate::GaitSpace::new)), and a
    /// character whose feet cannot be planted
    /// ([`MemberMut::plant_feet`](populace::MemberMut::plant_feet)).
    pub fn measure(character: &Arc<Character>, clips: &GaitClips) -> Result<Vec<Self>, Error> {
        let mut course = Course::new(character, clips)?;
        let own = course.clip_acceleration()?;
        let height_m = character.height_m();
        let mut all: [Samples; 2] = Default::default();
        let mut found = Vec::new();
        for (segment, part, secs) in COURSE {
            let samples = course.walk(part, secs)?;
            for ((all, samples), planting) in all.iter_mut().zip(samples).zip([false, true]) {
                all.add(&samples);
                found.push(samples.sum_up((segment, planting), height_m, own));
            }
        }
        let sums = all.into_iter().zip([false, true]);
        found.extend(sums.map(|(all, planting)| all.sum_up(("all", planting), height_m, own)));
        Ok(found)
    }
}
