//! Local avoidance: from the velocities that walkers prefer to velocities that do not collide.
//!
//! Optimal reciprocal collision avoidance (ORCA) after van den Berg, Guy, Lin and Manocha,
//! "Reciprocal n-body collision avoidance", 2011. Each walker heeds the neighbours that it would
//! meet soonest, and takes the velocity nearest to the preferred one that avoids them all, while
//! they do the same. Members of groups walk side by side and wait for each other.
//!
//! All is in the ground plane: points and velocities are `[x, z]`, in metres and metres per second.
//! Seen along +Z, +X is to the left. A walker is a disc.
//!
//! Results depend on the arguments alone, neither on earlier calls nor on the number of threads.
//! Work is done on the threads of the rayon pool of the caller.
//!
//! ```
//! use populace_locomotion::avoidance::{Agents, Avoidance, AvoidanceSettings, Obstacle, Stagger};
//!
//! # fn main() -> Result<(), populace_locomotion::avoidance::Error> {
//! let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
//! avoidance.set_obstacles(&[Obstacle::line([[-5.0, 1.0], [5.0, 1.0]])])?;
//! let mut positions = [[-2.0, 0.0], [2.0, 0.0]];
//! let mut velocities = [[0.0; 2]; 2];
//! for frame in 0..360 {
//!     let agents = Agents {
//!         positions: &positions,
//!         velocities: &velocities.clone(),
//!         preferred: &[[1.3, 0.0], [-1.3, 0.0]],
//!         radii_m: &[0.25; 2],
//!         most_speeds: &[1.8; 2],
//!         groups: &[0; 2],
//!     };
//!     // Each walker takes a new velocity ten times a second.
//!     avoidance.steer(&agents, Stagger { count: 6, nth: frame % 6 }, &mut velocities)?;
//!     for (position, velocity) in positions.iter_mut().zip(velocities) {
//!         let to = [position[0] + velocity[0] / 60.0, position[1] + velocity[1] / 60.0];
//!         *position = avoidance.slide(*position, to, 0.25);
//!     }
//! }
//! assert!(positions[0][0] > 2.0 && positions[1][0] < -2.0, "they passed each other");
//! # Ok(())
//! # }
//! ```

mod barriers;
mod bystanders;
mod error;
mod geometry;
mod grid;
mod groups;
mod linear;
mod persons;
mod settings;
mod slide;
mod steer;
mod walls;

use glam::Vec2;
use rayon::prelude::*;

pub use bystanders::Bystander;
use bystanders::Bystanders;
pub use error::Error;
use grid::Grid;
use groups::Groups;
pub use settings::{AvoidanceSettings, GroupSettings};
use walls::Walls;

/// The largest coordinate, in metres.
pub(crate) const LARGEST_M: f32 = 1e6;
const WITHIN_LARGEST: &str = "from -1e6 to 1e6";
/// The fewest walkers for one thread.
const FEWEST_PER_THREAD: usize = 64;

/// Walkers, one element of each slice for each. Slices have equal lengths.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agents<'a> {
    /// Positions `[x, z]` in metres, each coordinate from -1e6 to 1e6.
    pub positions: &'a [[f32; 2]],
    /// Velocities in metres per second.
    pub velocities: &'a [[f32; 2]],
    /// Velocities that walkers would take if they were alone, in metres per second.
    pub preferred: &'a [[f32; 2]],
    /// Radii in metres, above 0 and at most 3.
    pub radii_m: &'a [f32],
    /// The highest speeds in metres per second, 0 to 100.
    pub most_speeds: &'a [f32],
    /// Groups that walk together: equal numbers are one group, 0 is none.
    pub groups: &'a [u32],
}

/// The walkers that one call steers: those whose index leaves the rest `nth` when divided by
/// `count`. The others are avoided all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stagger {
    /// Number of shares, at least 1.
    pub count: usize,
    /// The share, less than `count`.
    pub nth: usize,
}

impl Stagger {
    /// All walkers.
    pub const ALL: Self = Self { count: 1, nth: 0 };
}

/// Walls on the ground. They stop walkers on both sides, so a closed obstacle keeps those outside
/// out and those inside in.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    points: Vec<[f32; 2]>,
    closed: bool,
}

impl Obstacle {
    /// An outline through points and back to the first, in either direction, convex or not.
    pub fn polygon(points: impl IntoIterator<Item = [f32; 2]>) -> Self {
        Self { points: points.into_iter().collect(), closed: true }
    }

    /// A line through points.
    pub fn line(points: impl IntoIterator<Item = [f32; 2]>) -> Self {
        Self { points: points.into_iter().collect(), closed: false }
    }
}

/// Steers walkers. Holds settings, obstacles, bystanders, and memory that calls use again.
#[derive(Clone, Debug)]
pub struct Avoidance {
    settings: AvoidanceSettings,
    walls: Walls,
    bystanders: Bystanders,
    grid: Grid,
    groups: Groups,
    /// Places in the grid of the walkers to steer.
    steered: Vec<u32>,
    /// Their new velocities.
    results: Vec<Vec2>,
}

/// The walker that is steered.
#[derive(Clone, Copy, Debug)]
struct Body {
    position: Vec2,
    velocity: Vec2,
    ahead: Vec2,
    radius: f32,
    most_speed: f32,
    index: u32,
    group: u32,
}

impl Avoidance {
    /// Makes an avoidance without obstacles.
    ///
    /// # Errors
    ///
    /// A setting out of its range.
    pub fn new(settings: AvoidanceSettings) -> Result<Self, Error> {
        settings.check()?;
        Ok(Self {
            settings,
            walls: Walls::default(),
            bystanders: Bystanders::default(),
            grid: Grid::default(),
            groups: Groups::default(),
            steered: Vec::new(),
            results: Vec::new(),
        })
    }

    /// Replaces all obstacles.
    ///
    /// # Errors
    ///
    /// An obstacle of fewer than 2 points, with a coordinate that is not finite or beyond 1e6 m, or
    /// with two equal points in a row. The obstacles from before stay.
    pub fn set_obstacles(&mut self, obstacles: &[Obstacle]) -> Result<(), Error> {
        self.walls = Walls::new(obstacles)?;
        Ok(())
    }

    /// Replaces all bystanders. Walkers steer around them as around each other, and make the whole
    /// change of velocity. The cost of a step does not grow with the number of bystanders, but with
    /// how many are near.
    ///
    /// # Errors
    ///
    /// A coordinate that is not from -1e6 to 1e6, or a radius that is not above 0 and at most 3.
    /// The bystanders from before stay.
    pub fn set_bystanders(&mut self, bystanders: &[Bystander]) -> Result<(), Error> {
        self.bystanders = Bystanders::new(bystanders)?;
        Ok(())
    }

    /// Writes the new velocities of a share of the walkers to `velocities`. The elements of other
    /// walkers stay as they are. Allocates nothing once the number of walkers has been seen.
    ///
    /// # Errors
    ///
    /// Slices of unequal lengths, values out of range, or a share that does not exist. Nothing is
    /// written then.
    pub fn steer(
        &mut self,
        agents: &Agents<'_>,
        stagger: Stagger,
        velocities: &mut [[f32; 2]],
    ) -> Result<(), Error> {
        agents.check(velocities.len())?;
        let Stagger { count, nth } = stagger;
        if nth >= count {
            return Err(Error::BadStagger { count, nth });
        }
        self.grid.rebuild(agents);
        self.groups.rebuild(agents);
        self.steered.clear();
        let walkers = self.grid.walkers().iter().enumerate();
        let due = walkers.filter(|(_, walker)| walker.index as usize % count == nth);
        self.steered.extend(due.map(|(place, _)| geometry::index(place)));
        let mut results = std::mem::take(&mut self.results);
        results.clear();
        results.resize(self.steered.len(), Vec2::ZERO);
        let places = self.steered.par_iter().with_min_len(FEWEST_PER_THREAD);
        let pairs = results.par_iter_mut().zip(places);
        pairs.for_each(|(result, place)| *result = self.velocity(agents, *place));
        for (place, result) in self.steered.iter().zip(&results) {
            let walker = self.grid.walkers()[*place as usize].index;
            velocities[walker as usize] = result.to_array();
        }
        self.results = results;
        Ok(())
    }

    /// Moves a disc from one point towards another and returns where it comes to. It slides along
    /// walls and never crosses one, however long the step. A disc that is not in a wall at `from`
    /// is not in one afterwards. A disc that is in a wall comes no nearer to it, and is led out by
    /// up to 5 cm in a call. It slides along bystanders too: where no wall is near, it ends no
    /// nearer to one than 0.8 of the sum of both radii, or than it was.
    ///
    /// Returns `from` if an argument is not finite. A negative radius counts as 0.
    #[must_use]
    pub fn slide(&self, from: [f32; 2], to: [f32; 2], radius_m: f32) -> [f32; 2] {
        let numbers = [from[0], from[1], to[0], to[1], radius_m];
        if !numbers.iter().all(|number| number.is_finite()) {
            return from;
        }
        let (from, radius_m) = (from.into(), radius_m.max(0.0));
        let to = self.bystanders.slide(from, to.into(), radius_m);
        self.walls.slide(from, to, radius_m).to_array()
    }
}

impl Agents<'_> {
    fn check(&self, results: usize) -> Result<(), Error> {
        let positions = self.positions.len();
        let lengths = [
            ("velocities", self.velocities.len()),
            ("preferred velocities", self.preferred.len()),
            ("radii", self.radii_m.len()),
            ("highest speeds", self.most_speeds.len()),
            ("groups", self.groups.len()),
            ("results", results),
        ];
        for (what, found) in lengths {
            if found != positions {
                return Err(Error::UnequalLengths { what, found, positions });
            }
        }
        let vectors = |what, vectors: &[[f32; 2]], most: f32, rule| {
            let bad = |value: &f32| value.is_nan() || value.abs() > most;
            let at = vectors.iter().flatten().position(bad);
            at.map_or(Ok(()), |at| {
                let (walker, value) = (at / 2, vectors.as_flattened()[at]);
                Err(Error::BadValue { what, walker, value, rule })
            })
        };
        vectors("the position", self.positions, LARGEST_M, WITHIN_LARGEST)?;
        vectors("the velocity", self.velocities, 1e3, "from -1000 to 1000")?;
        vectors("the preferred velocity", self.preferred, 1e3, "from -1000 to 1000")?;
        let numbers = |what, numbers: &[f32], allowed: fn(f32) -> bool, rule| {
            let bad = numbers.iter().enumerate().find(|(_, value)| !allowed(**value));
            bad.map_or(Ok(()), |(walker, &value)| {
                Err(Error::BadValue { what, walker, value, rule })
            })
        };
        let radius = |value| value > 0.0 && value <= 3.0;
        numbers("the radius", self.radii_m, radius, "above 0 and at most 3")?;
        let speed = |value| (0.0..=100.0).contains(&value);
        numbers("the highest speed", self.most_speeds, speed, "from 0 to 100")
    }
}
