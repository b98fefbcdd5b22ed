//! Settings of avoidance.

use super::Error;
use super::grid::Grid;
use super::persons::MOST_NEIGHBOURS;

/// How walkers avoid each other. The defaults are for people on foot.
#[derive(Clone, Debug, PartialEq)]
pub struct AvoidanceSettings {
    /// The time ahead in which walkers do not collide with each other if both keep their
    /// velocities, in seconds, 0.1 to 10.
    pub horizon_secs: f32,
    /// The same for two who hardly move. Shorter, so that a queue closes up.
    pub slow_horizon_secs: f32,
    /// The time ahead in which a walker does not meet a wall, in seconds, 0.1 to 10.
    pub wall_horizon_secs: f32,
    /// The most neighbours that a walker heeds, 1 to 16.
    pub neighbours: usize,
    /// The largest distance of neighbours in metres, 1 to 14. Slow walkers look less far.
    pub sight_m: f32,
    /// The gap in metres that strangers like to keep between each other, 0 to 1. It gives way in a
    /// crowd. Wider gaps let fewer people through a door.
    pub comfort_m: f32,
    /// How strongly walkers who meet head on keep to the right, in metres per second of sideways
    /// velocity, -1 to 1. Negative to keep to the left.
    pub keep_right: f32,
    /// Groups.
    pub groups: GroupSettings,
}

/// How groups walk together.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupSettings {
    /// Distance between the centres of members side by side, in metres, 0.3 to 3.
    pub spacing_m: f32,
    /// The time ahead in which members of one group do not collide, in seconds, 0.1 to 10.
    pub horizon_secs: f32,
    /// Whether strangers walk around a group where they can, rather than through it.
    pub is_walked_around: bool,
}

impl Default for AvoidanceSettings {
    fn default() -> Self {
        Self {
            horizon_secs: 2.0,
            slow_horizon_secs: 0.4,
            wall_horizon_secs: 0.8,
            neighbours: 10,
            sight_m: 8.0,
            comfort_m: 0.08,
            keep_right: 0.45,
            groups: GroupSettings::default(),
        }
    }
}

impl Default for GroupSettings {
    fn default() -> Self {
        Self { spacing_m: 0.75, horizon_secs: 0.4, is_walked_around: true }
    }
}

impl AvoidanceSettings {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let within = |what, value: f32, least: f32, most: f32, rule| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(Error::BadSetting { what, value, rule })
            }
        };
        let secs = "from 0.1 to 10";
        within("horizon_secs", self.horizon_secs, 0.1, 10.0, secs)?;
        within("slow_horizon_secs", self.slow_horizon_secs, 0.1, 10.0, secs)?;
        within("wall_horizon_secs", self.wall_horizon_secs, 0.1, 10.0, secs)?;
        within("sight_m", self.sight_m, 1.0, Grid::FARTHEST_M, "from 1 to 14")?;
        within("comfort_m", self.comfort_m, 0.0, 1.0, "from 0 to 1")?;
        within("keep_right", self.keep_right, -1.0, 1.0, "from -1 to 1")?;
        within("groups.spacing_m", self.groups.spacing_m, 0.3, 3.0, "from 0.3 to 3")?;
        within("groups.horizon_secs", self.groups.horizon_secs, 0.1, 10.0, secs)?;
        let most = MOST_NEIGHBOURS as f32;
        within("neighbours", self.neighbours as f32, 1.0, most, "from 1 to 16")
    }
}
