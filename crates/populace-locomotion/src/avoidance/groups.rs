//! Groups that walk together, after Moussaïd, Perozo, Garnier, Helbing and Theraulaz, "The walking
//! behaviour of pedestrian social groups and its impact on crowd dynamics", PLoS ONE 5(4), 2010.
//!
//! Their three forces act on the preferred velocity here. Those who are ahead of the others slow
//! down, so that they need not turn their heads; all draw near when the group is wider than its
//! members side by side; and members give each other room.

use glam::{DVec2, Vec2};

use super::geometry::index;
use super::grid::Seen;
use super::walls::NONE;
use super::{Agents, Body, GroupSettings};

/// Change of pace, as a share, for each metre that a walker is behind the others of its group.
const PACE_PER_M: f32 = 0.35;
/// The slowest and the fastest pace of those who wait and those who catch up.
const PACES: (f32, f32) = (0.35, 1.25);
/// Groups wider than this from their centre, in metres, are not walked around.
const WIDEST_M: f32 = 2.0;
/// Drawing near: metres per second for each metre too wide, and at most.
const COHESION: (f32, f32) = (0.6, 0.45);
/// Giving room: metres per second sideways, at most.
const ROOM: f32 = 0.4;
/// Members farther ahead or behind than this, in metres, need no room at the side.
const BESIDE_M: f32 = 1.5;
/// Slower walkers, in metres per second, stand.
const STANDING: f32 = 0.05;

/// The members of one group, summed.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    count: f32,
    positions: DVec2,
    velocities: Vec2,
    /// Sum of preferred speeds.
    speeds: f32,
    /// Distance of the farthest member's edge from the centre.
    reach: f32,
}

/// All groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    /// The ids for which the tables below were made.
    ids: Vec<u32>,
    /// Pairs of group id and walker, sorted.
    members: Vec<(u32, u32)>,
    /// The group of each walker in `all`, or [`NONE`].
    group_of: Vec<u32>,
    all: Vec<Group>,
}

impl Groups {
    /// Sums all groups, in order of indices.
    pub(crate) fn rebuild(&mut self, agents: &Agents<'_>) {
        if self.ids != agents.groups {
            self.sort(agents.groups);
        }
        self.all.fill(Group::default());
        for (_, walker) in &self.members {
            let nth = *walker as usize;
            let group = &mut self.all[self.group_of[nth] as usize];
            group.count += 1.0;
            group.positions += Vec2::from(agents.positions[nth]).as_dvec2();
            group.velocities += Vec2::from(agents.velocities[nth]);
            group.speeds += Vec2::from(agents.preferred[nth]).length();
        }
        for (_, walker) in &self.members {
            let nth = *walker as usize;
            let group = &mut self.all[self.group_of[nth] as usize];
            let distance = Vec2::from(agents.positions[nth]).distance(group.centre());
            group.reach = group.reach.max(distance + agents.radii_m[nth]);
        }
    }

    fn sort(&mut self, ids: &[u32]) {
        self.ids.clear();
        self.ids.extend_from_slice(ids);
        self.members.clear();
        let all = ids.iter().enumerate().filter(|(_, id)| **id != 0);
        self.members.extend(all.map(|(nth, id)| (*id, index(nth))));
        self.members.sort_unstable();
        self.group_of.clear();
        self.group_of.resize(ids.len(), NONE);
        let mut last = 0;
        self.all.clear();
        for (id, walker) in &self.members {
            if *id != last {
                self.all.push(Group::default());
                last = *id;
            }
            self.group_of[*walker as usize] = index(self.all.len() - 1);
        }
    }

    fn of(&self, walker: u32) -> Option<&Group> {
        self.all.get(self.group_of[walker as usize] as usize).filter(|group| group.count > 1.0)
    }

    /// Returns another walker's group as one disc to walk around; `None` if it is spread out, or
    /// the walker is among its members.
    pub(crate) fn disc(&self, body: &Body, other: &Seen) -> Option<Seen> {
        let group = self.of(other.index)?;
        let position = group.centre();
        let outside = position.distance(body.position) > group.reach + body.radius;
        (group.reach <= WIDEST_M && outside).then_some(Seen {
            position,
            velocity: group.velocities / group.count,
            radius: group.reach,
            ..*other
        })
    }

    /// Returns the velocity that a walker prefers as a member of its group.
    pub(crate) fn preferred<'a>(
        &self,
        body: &Body,
        preferred: Vec2,
        neighbours: impl Iterator<Item = &'a Seen>,
        settings: &GroupSettings,
    ) -> Vec2 {
        let speed = preferred.length();
        let Some(group) = self.of(body.index).filter(|_| speed > STANDING) else {
            return preferred;
        };
        let ahead = preferred / speed;
        let to_others = (group.positions - body.position.as_dvec2() * f64::from(group.count))
            / f64::from(group.count - 1.0);
        let to_others = to_others.as_vec2();
        let behind = to_others.dot(ahead);
        let usual = (group.speeds / group.count / speed).clamp(PACES.0.max(0.6), PACES.1);
        let pace = (usual * (1.0 + PACE_PER_M * behind)).clamp(PACES.0, PACES.1);
        let across = to_others - ahead * behind;
        // Side by side, the outermost is half of the whole width away from the others' centre.
        let too_wide = across.length() - 0.5 * group.count * settings.spacing_m;
        let inwards = (COHESION.0 * too_wide.max(0.0)).min(COHESION.1);
        let right = ahead.perp();
        let sideways = neighbours
            .filter(|other| other.group == body.group)
            .map(|other| room(body, other, ahead, settings.spacing_m));
        let sideways = sideways.sum::<f32>().clamp(-ROOM, ROOM);
        preferred * pace + across.normalize_or_zero() * inwards + right * sideways
    }
}

impl Group {
    fn centre(&self) -> Vec2 {
        (self.positions / f64::from(self.count)).as_vec2()
    }
}

/// Returns how fast a walker moves to its right to walk beside another member, in metres per
/// second.
fn room(body: &Body, other: &Seen, ahead: Vec2, spacing_m: f32) -> f32 {
    let apart = body.position - other.position;
    let right = apart.dot(ahead.perp());
    let along = apart.dot(ahead).abs();
    let lacks = 1.0 - right.abs() / spacing_m;
    if lacks <= 0.0 || along >= BESIDE_M {
        return 0.0;
    }
    let side = if right.abs() > 1e-3 {
        right.signum()
    } else if body.index < other.index {
        1.0
    } else {
        -1.0
    };
    side * ROOM * lacks * (1.0 - along / BESIDE_M)
}
