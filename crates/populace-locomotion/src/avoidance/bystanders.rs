//! People who stand and evade nobody: walkers steer around them, and do not walk through them.

use glam::Vec2;

use super::grid::{Grid, Seen};
use super::{Agents, Error};

/// Somebody who stands where it is and evades nobody: a disc on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bystander {
    /// The position `[x, z]` in metres, each coordinate from -1e6 to 1e6.
    pub position: [f32; 2],
    /// The radius in metres, above 0 and at most 3.
    pub radius_m: f32,
}

/// The bit of an index that marks a bystander among the neighbours of a walker.
const BYSTANDER: u32 = 1 << 31;
/// The part of the distance at which two people touch that is kept in any case: people who squeeze
/// through a crowd turn their shoulders.
const CORE: f32 = 0.8;
/// How often a step is corrected that leads to several bystanders.
const MOST_CORRECTIONS: usize = 3;
/// A distance in metres that rounding may take from one that is kept.
const SLACK_M: f32 = 1e-4;

impl Seen {
    /// Returns true for somebody who evades nobody.
    pub(crate) fn is_bystander(&self) -> bool {
        self.index & BYSTANDER != 0
    }
}

/// All bystanders, in the cells of a grid of their own that is built once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bystanders {
    pub(crate) grid: Grid,
}

impl Bystanders {
    pub(crate) fn new(bystanders: &[Bystander]) -> Result<Self, Error> {
        let positions: Vec<_> = bystanders.iter().map(|of| of.position).collect();
        let radii_m: Vec<_> = bystanders.iter().map(|of| of.radius_m).collect();
        let (count, zeros) = (positions.len(), vec![[0.0; 2]; positions.len()]);
        let agents = Agents {
            positions: &positions,
            velocities: &zeros,
            preferred: &zeros,
            radii_m: &radii_m,
            most_speeds: &vec![0.0; count],
            groups: &vec![0; count],
        };
        agents.check(count).map_err(Error::of_bystander)?;
        let mut grid = Grid::default();
        grid.rebuild(&agents);
        grid.mark(BYSTANDER);
        Ok(Self { grid })
    }

    /// Leads the end of a step around bystanders: it is no nearer to any than the core of both, or
    /// than the step began.
    pub(crate) fn slide(&self, from: Vec2, to: Vec2, radius: f32) -> Vec2 {
        let mut at = to;
        let mut is_free = false;
        for _ in 0..MOST_CORRECTIONS {
            is_free = true;
            self.grid.around(at, radius + self.grid.largest_radius(), |_, other| {
                let core = CORE * (radius + other.radius);
                let least = core.min(from.distance(other.position));
                let away = at - other.position;
                if away.length() < least - SLACK_M {
                    let outwards = (from - other.position).normalize_or(Vec2::X);
                    at = other.position + away.normalize_or(outwards) * least;
                    is_free = false;
                }
            });
            if is_free {
                break;
            }
        }
        if is_free { at } else { from }
    }
}
