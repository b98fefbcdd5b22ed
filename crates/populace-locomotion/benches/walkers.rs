//! Host time of walkers at 10,000 members: `cargo bench -p populace-locomotion --bench walkers`.
//! A name after `--` runs one scene alone: `paths` or `streams`.
//!
//! The crowd is updated in each frame but not timed, so that the figures hold for walkers whose data
//! has left the caches. Times are in milliseconds of a frame.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use populace::{CharacterId, Crowd, Device, Placement};
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings};
use populace_locomotion::{GaitSpace, Goal, Path, WalkerSettings, Walkers};

const WALKERS: u16 = 10_000;
const FRAME_SECS: f32 = 1.0 / 60.0;
/// Frames before the first that is timed: everybody walks by then.
const WARM_UP: usize = 90;
const FRAMES: usize = 240;
/// Edge of the square of the paths, in metres.
const SQUARE_M: f32 = 200.0;
/// Length and width of the streams in metres: 0.5 people on each square metre.
const CORRIDOR_M: [f32; 2] = [400.0, 50.0];

struct Scene {
    crowd: Crowd,
    walkers: Walkers,
    person: CharacterId,
}

impl Scene {
    fn new() -> Result<Self, Box<dyn Error>> {
        let capacity = usize::from(WALKERS);
        let mut crowd = Crowd::builder().device(Device::native()).capacity(capacity).build()?;
        let person = populace_cast::cast()?.into_iter().next().ok_or("the cast is empty")?;
        let person = crowd.add_character(person)?;
        let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(person, name));
        let mut walkers = Walkers::new(WalkerSettings::default())?;
        walkers.add_gaits(GaitSpace::new(&mut crowd, person, idle?, &[walk?, run?])?);
        Ok(Self { crowd, walkers, person })
    }

    fn add(&mut self, at: [f32; 2], speed: f32, goal: Goal) -> Result<(), Box<dyn Error>> {
        let member = self.crowd.spawn(self.person, Placement::at([at[0], 0.0, at[1]]))?;
        self.walkers.add(&mut self.crowd, member)?;
        self.walkers.set_speed(member, speed)?;
        Ok(self.walkers.set_goal(member, goal)?)
    }

    /// Walkers on random closed paths at random speeds, who pass through each other.
    fn paths() -> Result<Self, Box<dyn Error>> {
        let mut scene = Self::new()?;
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..WALKERS {
            let points = [(); 4].map(|()| [(); 2].map(|()| SQUARE_M * random.f32()));
            let path = Path::new(&points)?.closed();
            scene.add(points[0], 0.5 + 2.5 * random.f32(), Goal::Path(Arc::new(path)))?;
        }
        Ok(scene)
    }

    /// Two streams that pass through each other and around each other's walkers.
    fn streams() -> Result<Self, Box<dyn Error>> {
        let mut scene = Self::new()?;
        let settings = AvoidanceSettings::default();
        scene.walkers.set_avoidance(Some(Avoidance::new(settings)?));
        let mut random = fastrand::Rng::with_seed(2);
        let [length, width] = CORRIDOR_M;
        let columns = 283_u16;
        let rows = WALKERS.div_ceil(columns);
        for nth in 0..WALKERS {
            let cell = [f32::from(nth % columns), f32::from(nth / columns)];
            let edges = [length / f32::from(columns), width / f32::from(rows)];
            let at = [0, 1].map(|i: usize| edges[i] * (cell[i] + 0.6 * random.f32()));
            let speed = 1.0 + 0.7 * random.f32();
            let velocity = [if random.bool() { speed } else { -speed }, 0.0];
            scene.add(at, speed, Goal::Velocity(velocity))?;
        }
        Ok(scene)
    }

    /// Times frames, and prints the mean, the median and the worst of all parts.
    fn measure(&mut self, name: &str) -> Result<(), Box<dyn Error>> {
        let mut parts =
            ["update", "prefer", "avoid", "advance", "crowd"].map(|part| (part, vec![]));
        for frame in 0..WARM_UP + FRAMES {
            let start = Instant::now();
            self.walkers.update(&mut self.crowd, FRAME_SECS)?;
            let update_ms = start.elapsed().as_secs_f64() * 1e3;
            let times = self.walkers.update_times();
            let all =
                [update_ms, times.prefer_ms, times.avoid_ms, times.advance_ms, times.crowd_ms];
            if frame >= WARM_UP {
                parts.iter_mut().zip(all).for_each(|((_, ms), time)| ms.push(time));
            }
            self.crowd.update(FRAME_SECS)?;
        }
        for (part, mut ms) in parts {
            ms.sort_by(f64::total_cmp);
            let mean = ms.iter().sum::<f64>() / FRAMES as f64;
            let (median, worst) = (ms[FRAMES / 2], ms[FRAMES - 1]);
            println!("{name:<10} {part:<10} {mean:>8.3} {median:>8.3} {worst:>8.3}");
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let is_wanted = |name: &str| only.as_deref().is_none_or(|only| only == name);
    println!("{WALKERS} walkers, {} threads", rayon::current_num_threads());
    println!("{:<21} {:>8} {:>8} {:>8}", "milliseconds", "mean", "median", "worst");
    if is_wanted("paths") {
        Scene::paths()?.measure("paths")?;
    }
    if is_wanted("streams") {
        Scene::streams()?.measure("streams")?;
    }
    Ok(())
}
