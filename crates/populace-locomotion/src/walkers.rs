//! Crowds of walkers: goals in, placements, mixes of clips and strides out.

mod goals;
mod members;
mod motion;
mod show;

use std::time::Instant;

use populace::{Crowd, Ground, MemberId, Placement, SpacePoint, Stride};
use rayon::prelude::*;

use crate::avoidance::{Avoidance, Stagger};
use crate::error::within;
use crate::walker::{Lead, Walker, WalkerSettings};
use crate::{Error, GaitSpace};
pub use goals::Goal;
use goals::{Manner, Orders};

/// Seconds between two changes of what a walker plays, and between two steers around others.
const RENEWED_SECS: f32 = 0.1;
/// The fewest walkers for one thread.
const FEWEST_PER_THREAD: usize = 256;
/// No walker.
const NONE: u32 = u32::MAX;

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
}
