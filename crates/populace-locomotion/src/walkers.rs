//! Crowds of walkers: goals in, placements, mixes of clips and strides out.

mod goals;
mod members;

use std::time::Instant;

use glam::Vec2;
use populace::{Crowd, Ground, MemberId, Placement, SpacePoint, Stride};
use rayon::prelude::*;

use crate::avoidance::{Agents, Avoidance, LARGEST_M, Stagger};
use crate::error::within;
use crate::walker::{AHEAD_M, Lead, Walker, WalkerSettings, Wish, ground_below};
use crate::{Error, GaitSpace};
pub use goals::Goal;
use goals::{Manner, Orders};

/// Seconds between two changes of what a walker plays, and between two steers around others.
const RENEWED_SECS: f32 = 0.1;
/// Seconds in which a walker changes to another mix of clips.
const BLENDED_SECS: f32 = 0.2;
/// The fewest walkers for one thread.
const FEWEST_PER_THREAD: usize = 256;
/// No walker.
const NONE: u32 = u32::MAX;
/// How much faster than it prefers a walker may go to evade others.
const HASTE: f32 = 1.3;
/// The highest speed, in metres per second, at which a walker goes on that was led.
const MOST_LED_SPEED: f32 = 100.0;
/// How much a slope takes of the speed, up and down: people climb stairs of a slope of 0.5 at 0.61
/// metres per second and descend them at 0.69, horizontally (U. Weidmann, "Transporttechnik der
/// Fussgaenger", ETH Zurich 1993). Gentler slopes are between those and level ground.
const SLOPES: [f32; 2] = [2.4, 1.9];

/// Placements and strides of members.
type Shown = (Vec<(MemberId, Placement)>, Vec<(MemberId, Stride)>);

/// Milliseconds of host time that the parts of the last update took.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateTimes {
    /// Finding velocities that lead to goals.
    pub prefer_ms: f64,
    /// Steering around others.
    pub avoid_ms: f64,
    /// Moving the walkers.
    pub advance_ms: f64,
    /// Telling the crowd.
    pub crowd_ms: f64,
}

/// Walkers of a crowd. They keep all their state themselves: a clone, with a snapshot of the crowd,
/// goes on as the original does.
///
/// Each walker is a member that plays a [`GaitSpace`] and whose feet are planted. In each frame,
/// [`update`](Self::update) moves the walkers, then [`Crowd::update`] poses them.
#[derive(Clone, Debug)]
pub struct Walkers {
    settings: WalkerSettings,
    gaits: Vec<GaitSpace>,
    avoidance: Option<Avoidance>,
    /// `None` for level ground at height 0.
    ground: Option<Ground>,
    frame: u64,
    members: Vec<MemberId>,
    /// Index of the walker of a member, by the member's number.
    by_member: Vec<u32>,
    orders: Vec<Orders>,
    walkers: Vec<Walker>,
    positions: Vec<[f32; 2]>,
    velocities: Vec<[f32; 2]>,
    preferred: Vec<[f32; 2]>,
    steered: Vec<[f32; 2]>,
    /// True for a walker that was last steered to another velocity than it prefers.
    evades: Vec<bool>,
    radii_m: Vec<f32>,
    most_speeds: Vec<f32>,
    groups: Vec<u32>,
    placements: Vec<(MemberId, Placement)>,
    strides: Vec<(MemberId, Stride)>,
    /// New points of blend spaces, for walkers that change theirs in this update.
    points: Vec<(MemberId, SpacePoint)>,
    /// Placements and strides of the walkers that do not rest, if some do.
    shown: Shown,
    /// Strides of the walkers that have begun to rest since the last update.
    let_go: Vec<(MemberId, Stride)>,
    /// The phases of walkers that are led through steps, or that walk over treads.
    phases: Vec<Option<f32>>,
    times: UpdateTimes,
}

impl Walkers {
    /// Returns no walkers, on level ground, without avoidance.
    ///
    /// # Errors
    ///
    /// A setting that is not from 0.001 to 1000.
    pub fn new(settings: WalkerSettings) -> Result<Self, Error> {
        let WalkerSettings { acceleration, deceleration, turn_rate, turn_acceleration, .. } =
            settings;
        for (what, value) in [
            ("the acceleration", acceleration),
            ("the deceleration", deceleration),
            ("the rate of turns", turn_rate),
            ("the acceleration of turns", turn_acceleration),
            ("the share of speed sideways", settings.sideways),
            ("the share of speed backwards", settings.backwards),
        ] {
            within(what, value, 1e-3..=1e3, "from 0.001 to 1000")?;
        }
        Ok(Self {
            settings,
            gaits: Vec::new(),
            avoidance: None,
            ground: None,
            frame: 0,
            members: Vec::new(),
            by_member: Vec::new(),
            orders: Vec::new(),
            walkers: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
            preferred: Vec::new(),
            steered: Vec::new(),
            evades: Vec::new(),
            radii_m: Vec::new(),
            most_speeds: Vec::new(),
            groups: Vec::new(),
            placements: Vec::new(),
            strides: Vec::new(),
            points: Vec::new(),
            shown: (Vec::new(), Vec::new()),
            let_go: Vec::new(),
            phases: Vec::new(),
            times: UpdateTimes::default(),
        })
    }

    /// Gives the gaits of a character, in place of those given before for later walkers.
    pub fn add_gaits(&mut self, gaits: GaitSpace) {
        self.gaits.push(gaits);
    }

    /// Steers walkers around each other and along walls; `None` lets them pass through.
    pub fn set_avoidance(&mut self, avoidance: Option<Avoidance>) {
        self.avoidance = avoidance;
    }

    /// Sets the ground that walkers follow. [`Crowd::set_ground`] sets that of their feet.
    pub fn set_ground(&mut self, ground: Ground) {
        self.ground = (ground != Ground::default()).then_some(ground);
    }

    /// The walkers, in the order of slices.
    #[must_use]
    pub fn members(&self) -> &[MemberId] {
        &self.members
    }

    /// The positions `[x, z]` of the walkers in metres, in the order of [`members`](Self::members).
    #[must_use]
    pub fn positions(&self) -> &[[f32; 2]] {
        &self.positions
    }

    /// The velocities `[x, z]` of the walkers in metres per second, in the order of
    /// [`members`](Self::members).
    #[must_use]
    pub fn velocities(&self) -> &[[f32; 2]] {
        &self.velocities
    }

    /// Returns for how long a foot of a walker has been down when the body is over it, as a part of
    /// a [`LedStep`](crate::LedStep); 0 if that is not known.
    ///
    /// # Errors
    ///
    /// A member that is no walker.
    pub fn steps_from_touch_down(&self, member: MemberId) -> Result<f32, Error> {
        let index = self.index_of(member)?;
        let gaits = &self.gaits[self.orders[index].gaits as usize];
        Ok(self.walkers[index].steps_from_touch_down(gaits))
    }

    /// The strides that members were told last, in the order of [`members`](Self::members).
    pub(crate) fn strides(&self) -> &[(MemberId, Stride)] {
        &self.strides
    }

    /// The cycles in a second at which the first walker steps; 0 without any.
    pub(crate) fn cycles_per_sec(&self) -> f32 {
        self.walkers.first().map_or(0.0, |walker| walker.step.cycles_per_sec)
    }

    /// Moves all walkers on by `secs`, and sets what their members show; 0 seconds change nothing.
    /// A walker that was led at more than 100 metres per second goes on at 100. Coordinates of
    /// -1e6 and 1e6 metres stop walkers as walls do.
    ///
    /// # Errors
    ///
    /// A time that is not from 0 to 1, or [`Error::Despawned`] for a walker whose member was
    /// despawned: nothing has moved then. Errors of the crowd for a member that was attached to
    /// another or that plays something else: all have moved then, and some do not show it.
    pub fn update(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Error> {
        let Some(share) = self.begin(crowd, secs)? else { return Ok(()) };
        let mut times = [Instant::now(); 5];
        self.prefer(secs);
        times[1] = Instant::now();
        self.steer(share)?;
        times[2] = Instant::now();
        self.phases.clear();
        if self.ground.is_some() {
            let phase = |member: &MemberId| crowd.member(*member).ok()?.blend_space_phase();
            self.phases.extend(self.members.iter().map(phase));
        } else {
            self.phases.resize(self.members.len(), None);
        }
        self.advance(secs);
        times[3] = Instant::now();
        self.frame += 1;
        self.show(crowd, share)?;
        times[4] = Instant::now();
        let [prefer_ms, avoid_ms, advance_ms, crowd_ms] =
            [0, 1, 2, 3].map(|nth| (times[nth + 1] - times[nth]).as_secs_f64() * 1e3);
        self.times = UpdateTimes { prefer_ms, avoid_ms, advance_ms, crowd_ms };
        Ok(())
    }

    /// Leads all walkers: each is where and how its lead says after `secs`, and steps accordingly;
    /// 0 seconds change nothing. In place of [`update`](Self::update); goals, avoidance and limits
    /// have no effect. Walkers that [rest](Self::rest) stay where they are.
    ///
    /// # Errors
    ///
    /// As [`update`](Self::update). A slice of another length than [`members`](Self::members), or a
    /// lead with a number that is not from -1e6 to 1e6: nothing has moved then.
    pub fn follow(&mut self, crowd: &mut Crowd, leads: &[Lead], secs: f32) -> Result<(), Error> {
        if leads.len() != self.members.len() {
            let (found, walkers) = (leads.len(), self.members.len());
            return Err(Error::UnequalLengths { found, walkers });
        }
        leads.iter().try_for_each(Lead::check)?;
        let Some(share) = self.begin(crowd, secs)? else { return Ok(()) };
        self.phases.clear();
        for (lead, member) in leads.iter().zip(&self.members) {
            let phase = || crowd.member(*member).ok()?.blend_space_phase();
            self.phases.push(lead.step.and_then(|_| phase()));
        }
        let Self { gaits, .. } = self;
        let places = self.positions.par_iter_mut().zip(&mut self.velocities);
        let shown = self.placements.par_iter_mut().zip(&mut self.strides);
        let walkers = self.walkers.par_iter_mut().zip(shown).zip(places);
        let leads = leads.par_iter().zip(&self.phases).zip(&self.orders);
        walkers.zip(leads).with_min_len(FEWEST_PER_THREAD).for_each(
            |(((walker, (placement, stride)), (position, velocity)), ((lead, phase), orders))| {
                if orders.manner == Manner::Rests {
                    return;
                }
                walker.follow(lead, *phase, secs);
                walker.step(&gaits[orders.gaits as usize], secs, None);
                (placement.1, stride.1) = (walker.placement(), walker.stride);
                (*position, *velocity) = (lead.position, lead.velocity);
            },
        );
        self.frame += 1;
        self.show(crowd, share)
    }

    /// Checks a step, and returns the share of walkers whose mix of clips is renewed in it; `None`
    /// if no time passes.
    fn begin(&self, crowd: &Crowd, secs: f32) -> Result<Option<Stagger>, Error> {
        within("the time of an update", secs, 0.0..=1.0, "from 0 to 1 second")?;
        let gone = self.members.iter().find(|member| crowd.member(**member).is_err());
        if let Some(member) = gone {
            return Err(Error::Despawned { member: member.number() });
        }
        if secs == 0.0 {
            return Ok(None);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1000")]
        let count = (RENEWED_SECS / secs).round().clamp(1.0, 1000.0) as usize;
        let nth = usize::try_from(self.frame % count as u64).unwrap_or(0);
        Ok(Some(Stagger { count, nth }))
    }

    /// The times of the last update.
    #[must_use]
    pub fn update_times(&self) -> UpdateTimes {
        self.times
    }

    /// Finds the velocities that walkers would take if they were alone.
    fn prefer(&mut self, secs: f32) {
        let (settings, ground, avoids) = (&self.settings, &self.ground, self.avoidance.is_some());
        let walkers = self.walkers.par_iter_mut().zip(&mut self.velocities).zip(&mut self.orders);
        let wishes = self.preferred.par_iter_mut().zip(&mut self.most_speeds);
        walkers.zip(wishes).with_min_len(FEWEST_PER_THREAD).for_each(
            |(((walker, present), orders), (preferred, most))| {
                if walker.velocity.length_squared() > MOST_LED_SPEED * MOST_LED_SPEED {
                    walker.velocity = walker.velocity.clamp_length_max(MOST_LED_SPEED);
                    *present = walker.velocity.to_array();
                }
                let velocity = orders.velocity(walker.position, settings.deceleration, secs);
                let share = ground
                    .as_ref()
                    .map_or(1.0, |ground| slope_share(ground, walker.position, velocity));
                *preferred = (velocity * share).to_array();
                if avoids {
                    // A walker that is faster already need not brake at once.
                    let most_speed = HASTE * share * velocity.length();
                    *most = most_speed.max(walker.velocity.length()).min(MOST_LED_SPEED);
                }
            },
        );
    }

    /// Steers a share of the walkers around others.
    fn steer(&mut self, share: Stagger) -> Result<(), Error> {
        let Some(avoidance) = &mut self.avoidance else {
            self.evades.fill(false);
            return Ok(());
        };
        let agents = Agents {
            positions: &self.positions,
            velocities: &self.velocities,
            preferred: &self.preferred,
            radii_m: &self.radii_m,
            most_speeds: &self.most_speeds,
            groups: &self.groups,
        };
        avoidance.steer(&agents, share, &mut self.steered)?;
        for index in (share.nth..self.members.len()).step_by(share.count) {
            self.evades[index] = self.orders[index].manner == Manner::Heeds
                && self.steered[index] != self.preferred[index];
        }
        Ok(())
    }

    /// Moves all walkers.
    fn advance(&mut self, secs: f32) {
        let Self { settings, gaits, avoidance, .. } = self;
        let ground = self.ground.as_ref();
        let places = self.positions.par_iter_mut().zip(&mut self.velocities);
        let orders = self.orders.par_iter().zip(&self.radii_m).zip(&self.phases);
        let wishes = self.preferred.par_iter().zip(&self.steered).zip(&self.evades).zip(orders);
        let shown = self.placements.par_iter_mut().zip(&mut self.strides);
        let walkers = self.walkers.par_iter_mut().zip(shown).zip(places);
        walkers.zip(wishes).with_min_len(FEWEST_PER_THREAD).for_each(
            |(
                ((walker, (placement, stride)), (position, velocity)),
                (steers, ((orders, radius), phase)),
            )| {
                if orders.manner == Manner::Rests {
                    return;
                }
                let ((preferred, steered), evades) = steers;
                // Who need not evade follows its goal in each update, as without avoidance.
                let wanted = Vec2::from(if *evades { *steered } else { *preferred });
                let wish = Wish { velocity: wanted, facing_rad: orders.facing_rad };
                let wanted = walker.advance(wish, settings, secs);
                let at = avoidance.as_ref().map_or(wanted, |avoidance| {
                    let from = walker.position.to_array();
                    avoidance.slide(from, wanted.to_array(), *radius).into()
                });
                let at = at.clamp(Vec2::splat(-LARGEST_M), Vec2::splat(LARGEST_M));
                walker.arrive(at, wanted, ground, secs);
                walker.step(&gaits[orders.gaits as usize], secs, ground.zip(*phase));
                (placement.1, stride.1) = (walker.placement(), walker.stride);
                (*position, *velocity) = (walker.position.to_array(), walker.velocity.to_array());
            },
        );
    }

    /// Sets the blend space of each walker that has begun to rest to standing. A member that plays
    /// something else by now keeps it.
    fn let_walks_go(&mut self, crowd: &Crowd) {
        self.let_go.clear();
        for (index, orders) in self.orders.iter().enumerate() {
            let (walker, member) = (&mut self.walkers[index], self.members[index]);
            if orders.manner != Manner::Rests || walker.told == Some(walker.step) {
                continue;
            }
            let walks = crowd.member(member).is_ok_and(|view| view.blend_space_phase().is_some());
            if walks {
                self.points.push((member, walker.step.point()));
                self.let_go.push((member, walker.stride));
            }
            walker.told = Some(walker.step);
        }
    }

    /// Tells the crowd where walkers are and how they step, and what a share of them plays.
    fn show(&mut self, crowd: &mut Crowd, share: Stagger) -> Result<(), Error> {
        self.points.clear();
        for index in (share.nth..self.members.len()).step_by(share.count) {
            let walker = &self.walkers[index];
            let is_moved = self.orders[index].manner != Manner::Rests;
            if is_moved && walker.told != Some(walker.step) {
                self.points.push((self.members[index], walker.step.point()));
            }
        }
        self.let_walks_go(crowd);
        let all_move = self.orders.iter().all(|orders| orders.manner != Manner::Rests);
        let (placements, strides) = if all_move {
            (&self.placements, &self.strides)
        } else {
            let moves = |index: &usize| self.orders[*index].manner != Manner::Rests;
            let moving = || (0..self.orders.len()).filter(moves);
            let (placements, strides) = &mut self.shown;
            placements.clear();
            placements.extend(moving().map(|index| self.placements[index]));
            strides.clear();
            strides.extend(moving().map(|index| self.strides[index]));
            strides.extend(&self.let_go);
            (&*placements, &*strides)
        };
        // A member that the crowd refuses keeps as little as possible from the others.
        let placed = crowd.set_placements(placements);
        let blended = crowd.set_blend_parameters(&self.points, BLENDED_SECS);
        let stepped = crowd.set_strides(strides);
        if blended.is_ok() {
            for (member, _) in &self.points {
                let walker = &mut self.walkers[self.by_member[member.number() as usize] as usize];
                walker.told = Some(walker.step);
            }
        }
        Ok(placed.and(blended).and(stepped)?)
    }
}

/// Returns the share of a speed that the slope of the ground leaves.
fn slope_share(ground: &Ground, at: Vec2, velocity: Vec2) -> f32 {
    let Some(direction) = velocity.try_normalize() else { return 1.0 };
    let at = at + direction * AHEAD_M;
    let ahead = ground_below(ground, at + direction * 0.5, direction);
    let slope = 2.0 * (ahead - ground_below(ground, at, direction));
    1.0 / (1.0 + if slope > 0.0 { SLOPES[0] * slope } else { -SLOPES[1] * slope })
}
