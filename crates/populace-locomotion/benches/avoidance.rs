//! Avoidance for 10,000 walkers: `cargo bench -p populace-locomotion --bench avoidance`.
//!
//! Two opposing streams at 0.5 people a square metre walk for 20 s at 60 frames a second, and a
//! sixth of them is steered in each frame. The table shows milliseconds for a frame: the grid,
//! steering, and the steps along walls.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::time::Instant;

use populace_locomotion::avoidance::{
    Agents, Avoidance, AvoidanceSettings, Error, Obstacle, Stagger,
};

const WALKERS: usize = 10_000;
const FRAMES: usize = 1200;
const FRAME_SECS: f32 = 1.0 / 60.0;
const LENGTH_M: f32 = 400.0;
const WIDTH_M: f32 = 50.0;
const RADIUS_M: f32 = 0.25;

/// The sum of the squares of two speeds below which somebody stands, in (m/s)².
const STANDS: f32 = 0.01;

/// One street, filled evenly with people who are shifted at random.
fn places() -> Vec<[f32; 2]> {
    let mut random = fastrand::Rng::with_seed(5);
    let edge = (LENGTH_M * WIDTH_M / WALKERS as f32).powf(0.5);
    let columns = LENGTH_M / edge;
    let place = |nth: usize| {
        let row = (nth as f32 / columns).floor();
        let at = [nth as f32 - row * columns, row];
        at.map(|c| (c + 0.5 + 0.5 * (random.f32() - 0.5)) * edge)
    };
    (0..WALKERS).map(place).collect()
}

struct Times {
    steer: Vec<f64>,
    slide: Vec<f64>,
}

fn walk(share_in_groups: u32, count: usize) -> Result<(Times, f32), Error> {
    let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
    avoidance.set_obstacles(&[
        Obstacle::line([[-1e3, 0.0], [1e3, 0.0]]),
        Obstacle::line([[-1e3, WIDTH_M], [1e3, WIDTH_M]]),
    ])?;
    let mut positions = places();
    positions.iter_mut().for_each(|at| at[1] = at[1].clamp(RADIUS_M, WIDTH_M - RADIUS_M));
    let ahead = |nth: usize| if (nth / 7).is_multiple_of(2) { 1.3 } else { -1.3 };
    let preferred: Vec<_> = (0..WALKERS).map(|nth| [ahead(nth), 0.0]).collect();
    let mut velocities = preferred.clone();
    let mut told = preferred.clone();
    let group = |nth: u32| if nth % 7 < share_in_groups { nth / 7 + 1 } else { 0 };
    let groups: Vec<_> = (0..).map(group).take(WALKERS).collect();
    let mut times = Times { steer: Vec::new(), slide: Vec::new() };
    for frame in 0..FRAMES {
        let start = Instant::now();
        let agents = Agents {
            positions: &positions,
            velocities: &velocities,
            preferred: &preferred,
            radii_m: &[RADIUS_M; WALKERS],
            most_speeds: &[1.8; WALKERS],
            groups: &groups,
        };
        avoidance.steer(&agents, Stagger { count, nth: frame % count }, &mut told)?;
        times.steer.push(start.elapsed().as_secs_f64() * 1e3);
        let start = Instant::now();
        for ((at, velocity), told) in positions.iter_mut().zip(&mut velocities).zip(&told) {
            let to = [at[0] + told[0] * FRAME_SECS, at[1] + told[1] * FRAME_SECS];
            let now = avoidance.slide(*at, to, RADIUS_M);
            *velocity = [(now[0] - at[0]) / FRAME_SECS, (now[1] - at[1]) / FRAME_SECS];
            // The street is endless.
            *at = [now[0].rem_euclid(LENGTH_M), now[1]];
        }
        times.slide.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let standing = velocities.iter().filter(|v| v[0] * v[0] + v[1] * v[1] < STANDS).count();
    Ok((times, standing as f32 / WALKERS as f32))
}

fn main() -> Result<(), Error> {
    println!(
        "{:<34} {:>7} {:>7} {:>7} {:>7} {:>9}",
        "ms for a frame of 10,000", "mean", "worst", "steer", "slide", "standing"
    );
    let scenes =
        [("strangers, a sixth steered", 0, 6), ("3 of 7 in groups, a sixth", 3, 6), ("all", 0, 1)];
    for (name, share_in_groups, count) in scenes {
        let (times, standing) = walk(share_in_groups, count)?;
        let mean = |times: &[f64]| times.iter().sum::<f64>() / times.len() as f64;
        let both = times.steer.iter().zip(&times.slide).map(|(steer, slide)| steer + slide);
        let worst = both.fold(0.0, f64::max);
        let (steer, slide) = (mean(&times.steer), mean(&times.slide));
        println!(
            "{name:<34} {:>7.2} {worst:>7.2} {steer:>7.2} {slide:>7.2} {:>8.1} %",
            steer + slide,
            100.0 * standing
        );
    }
    Ok(())
}
