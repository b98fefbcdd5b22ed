//! Walkers who go to places, 60 frames a second, a sixth of them steered in each frame.

use populace_locomotion::avoidance::{
    Agents, Avoidance, AvoidanceSettings, Error, Obstacle, Stagger,
};

pub(crate) const FRAME_SECS: f32 = 1.0 / 60.0;

/// Walkers and their surroundings.
#[derive(Clone)]
pub(crate) struct Walk {
    pub(crate) avoidance: Avoidance,
    pub(crate) positions: Vec<[f32; 2]>,
    pub(crate) velocities: Vec<[f32; 2]>,
    pub(crate) preferred: Vec<[f32; 2]>,
    pub(crate) radii_m: Vec<f32>,
    pub(crate) most_speeds: Vec<f32>,
    pub(crate) groups: Vec<u32>,
    /// What walkers were last told to do.
    pub(crate) told: Vec<[f32; 2]>,
    pub(crate) frame: usize,
}

impl Walk {
    pub(crate) fn new(settings: AvoidanceSettings, obstacles: &[Obstacle]) -> Result<Self, Error> {
        let mut avoidance = Avoidance::new(settings)?;
        avoidance.set_obstacles(obstacles)?;
        Ok(Self {
            avoidance,
            positions: Vec::new(),
            velocities: Vec::new(),
            preferred: Vec::new(),
            radii_m: Vec::new(),
            most_speeds: Vec::new(),
            groups: Vec::new(),
            told: Vec::new(),
            frame: 0,
        })
    }

    pub(crate) fn add(&mut self, position: [f32; 2], radius_m: f32, group: u32) {
        self.positions.push(position);
        for list in [&mut self.velocities, &mut self.preferred, &mut self.told] {
            list.push([0.0; 2]);
        }
        self.radii_m.push(radius_m);
        self.most_speeds.push(1.8);
        self.groups.push(group);
    }

    /// Takes a walker away, in constant time: the last one takes its place.
    pub(crate) fn remove(&mut self, nth: usize) {
        let lists = [&mut self.positions, &mut self.velocities, &mut self.preferred];
        for list in lists.into_iter().chain([&mut self.told]) {
            list.swap_remove(nth);
        }
        self.radii_m.swap_remove(nth);
        self.most_speeds.swap_remove(nth);
        self.groups.swap_remove(nth);
    }

    /// Sets preferred velocities from positions and walks through one frame.
    pub(crate) fn step(&mut self, wish: impl Fn(usize, [f32; 2]) -> [f32; 2]) -> Result<(), Error> {
        for (nth, preferred) in self.preferred.iter_mut().enumerate() {
            *preferred = wish(nth, self.positions[nth]);
        }
        let agents = Agents {
            positions: &self.positions,
            velocities: &self.velocities,
            preferred: &self.preferred,
            radii_m: &self.radii_m,
            most_speeds: &self.most_speeds,
            groups: &self.groups,
        };
        let stagger = Stagger { count: 6, nth: self.frame % 6 };
        self.avoidance.steer(&agents, stagger, &mut self.told)?;
        for nth in 0..self.positions.len() {
            let (at, told) = (self.positions[nth], self.told[nth]);
            let to = [at[0] + told[0] * FRAME_SECS, at[1] + told[1] * FRAME_SECS];
            let now = self.avoidance.slide(at, to, self.radii_m[nth]);
            self.velocities[nth] = [(now[0] - at[0]) / FRAME_SECS, (now[1] - at[1]) / FRAME_SECS];
            self.positions[nth] = now;
        }
        self.frame += 1;
        Ok(())
    }

    /// Counts pairs that overlap by more than a depth in metres.
    pub(crate) fn overlaps(&self, depth_m: f32) -> usize {
        let pairs = |a: usize| {
            let deep = move |b: &usize| {
                let apart = distance(self.positions[a], self.positions[*b]);
                apart < self.radii_m[a] + self.radii_m[*b] - depth_m
            };
            (0..a).filter(deep).count()
        };
        (0..self.positions.len()).map(pairs).sum()
    }
}

pub(crate) fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A velocity towards a place, slower where it is near.
pub(crate) fn towards(from: [f32; 2], to: [f32; 2], speed: f32) -> [f32; 2] {
    let away = distance(from, to);
    let rate = speed.min(away * 2.0) / away.max(1e-6);
    [(to[0] - from[0]) * rate, (to[1] - from[1]) * rate]
}

/// People at random places of a rectangle, at least a diameter apart.
pub(crate) fn scatter(
    random: &mut fastrand::Rng,
    count: usize,
    low: [f32; 2],
    high: [f32; 2],
) -> Vec<[f32; 2]> {
    let mut places: Vec<[f32; 2]> = Vec::new();
    while places.len() < count {
        let between =
            |random: &mut fastrand::Rng, c: usize| low[c] + (high[c] - low[c]) * random.f32();
        let place = [between(random, 0), between(random, 1)];
        if places.iter().all(|other| distance(*other, place) > 0.52) {
            places.push(place);
        }
    }
    places
}
