//! Places for people who begin in the middle of what they do.

use std::f32::consts::TAU;

use glam::Vec2;
use populace::{Crowd, Ground, Placement};
use populace_locomotion::Lead;

use super::footways::{Footway, Place};
use super::places::{PlacePlan, Places};
use super::taken::Taken;
use super::world::World;
use crate::Error;
use crate::place::is_inside;
use crate::plan::WallPlan;

/// Tries to find a free place.
const TRIES: usize = 24;

/// Places for people who begin.
pub(crate) struct Settling<'a> {
    /// The footways on which they stroll.
    pub(crate) footways: &'a [usize],
    ground: &'a Ground,
    /// Closed walls.
    walls: Vec<Vec<[f64; 2]>>,
    taken: Taken,
}

impl<'a> Settling<'a> {
    /// `taken` are the points at which others are already.
    pub(crate) fn new(
        footways: &'a [usize],
        ground: &'a Ground,
        walls: &[WallPlan],
        taken: Taken,
    ) -> Self {
        let points = |wall: &WallPlan| wall.points.iter().map(|at| at.map(f64::from)).collect();
        let walls = walls.iter().filter(|wall| wall.closed).map(points).collect();
        Self { footways, ground, walls, taken }
    }

    /// Returns the first free place from a part of all on that is beside one of the footways, and
    /// the footway.
    pub(crate) fn free(
        &self,
        world: &World,
        places: &Places<impl PlacePlan>,
        part: f32,
    ) -> Option<(usize, usize)> {
        let first = index_at(places.len(), part);
        let turned = (first..places.len()).chain(0..first);
        let beside = |nth: usize| {
            let at = places.is_free(nth).then(|| places[nth].at())?;
            let own = self.footways.iter().copied();
            let footway = own.min_by(|a, b| {
                let [a, b] = [a, b].map(|footway| world.footways[*footway].distance_m(at));
                a.total_cmp(&b)
            })?;
            (world.footways[footway].distance_m(at) < 1.5).then_some((nth, footway))
        };
        turned.into_iter().find_map(beside)
    }

    /// Finds a place on one of the footways, `edge_m` from its edge and from walls that stand on
    /// it, and `apart_m` from others. Returns the footway, the point, and the direction of the
    /// footway there.
    pub(crate) fn place(
        &self,
        world: &mut World,
        who: usize,
        edge_m: f32,
        apart_m: f32,
    ) -> Option<(usize, Vec2, Vec2)> {
        let all: f32 = self.footways.iter().map(|nth| world.footways[*nth].length_m()).sum();
        for _ in 0..TRIES {
            let random = &mut world.people[who].random;
            let (mut along_m, aside) = (random.unit() * all, random.between_f32(-1.0, 1.0));
            for footway in self.footways.iter().copied() {
                let strip = &world.footways[footway];
                if along_m > strip.length_m() {
                    along_m -= strip.length_m();
                    continue;
                }
                let aside_m = aside * (strip.half_m - edge_m).max(0.0);
                let (at, line) = strip.at(Place { along_m, aside_m });
                if self.is_free(at, apart_m) && self.is_open(strip, at, edge_m) {
                    return Some((footway, at, line));
                }
                break;
            }
        }
        None
    }

    /// Returns true if nobody is within a distance of a point.
    pub(crate) fn is_free(&self, at: Vec2, apart_m: f32) -> bool {
        !self.taken.is_near(at, apart_m)
    }

    /// Returns true if no closed wall shuts a point, and those at a distance around it, off from
    /// the beginning of a footway.
    fn is_open(&self, strip: &Footway, at: Vec2, around_m: f32) -> bool {
        let (begin, _) = strip.at(Place { along_m: 0.0, aside_m: 0.0 });
        let around = |nth: u8| at + around_m * Vec2::from_angle(TAU * f32::from(nth) / 8.0);
        self.walls.iter().all(|wall| {
            let is_in = |at: Vec2| is_inside(wall, at.to_array().map(f64::from));
            let is_enclosed = is_in(begin);
            is_in(at) == is_enclosed && (0..8).all(|nth| is_in(around(nth)) == is_enclosed)
        })
    }

    /// Puts somebody who is on foot to a point, with a heading and a speed ahead in metres per
    /// second.
    pub(crate) fn put(
        &mut self,
        world: &mut World,
        crowd: &mut Crowd,
        who: usize,
        (at, yaw_rad, speed): (Vec2, f32, f32),
    ) -> Result<(), Error> {
        let (member, scale) = (world.member(who), world.people[who].scale);
        let height_m = self.ground.height_at(at.x, at.y);
        let placement = Placement::at([at.x, height_m, at.y]).facing(yaw_rad).scaled(scale);
        crowd.member_mut(member)?.set_placement(placement)?;
        let (sin, cos) = yaw_rad.sin_cos();
        if speed > 0.0 {
            let phase = world.people[who].random.unit();
            let lead = Lead {
                position: at.to_array(),
                velocity: [sin * speed, cos * speed],
                soon_m_per_sec: speed,
                yaw_rad,
                height_m,
                step: None,
            };
            world.walkers.add_led(crowd, member, &lead, phase)?;
        } else {
            world.walkers.add(crowd, member)?;
        }
        world.people[who].goal = at;
        self.taken.take(at);
        Ok(())
    }
}

/// Returns the index at a part, 0 to 1, of a list.
pub(crate) fn index_at(count: usize, part: f32) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let nth = (part * count as f32) as usize;
    nth.min(count.saturating_sub(1))
}
