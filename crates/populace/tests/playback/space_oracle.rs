//! Blend spaces beside an oracle in double precision, through random moves.
//!
//! The weights at a point are found by trying all triangles of samples: the one that holds the
//! point, and whose circumcircle holds no other sample, is that of the Delaunay triangulation.
//! Outside of all triangles, the nearest point on any line between two samples counts. The phase is
//! the sum of the rates of all frames.

use glam::DVec2;
use populace::clip::TICKS_PER_SEC;
use populace::{BlendSpace, BlendSpacePlayback, ClipId, Crowd, Device, MemberId};
use populace_testkit::Rng;

use crate::fixture::one_member;
use crate::spaces::motions;

/// Ticks of a frame.
const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;
/// The largest error of a weight. Ramps are in single precision, over at most half a second.
const WEIGHT_BOUND: f64 = 1e-5;
/// The largest error of a phase, in cycles, after 240 frames.
const PHASE_BOUND: f64 = 1e-5;

/// Samples of a space, on axes divided by their extents.
struct Samples {
    points: Vec<DVec2>,
    low: DVec2,
    extent: DVec2,
    durations_secs: Vec<f64>,
}

impl Samples {
    fn new(points: &[[f32; 2]], durations_secs: Vec<f64>) -> Self {
        let wide = |p: &[f32; 2]| DVec2::new(f64::from(p[0]), f64::from(p[1]));
        let points: Vec<DVec2> = points.iter().map(wide).collect();
        let low = points.iter().copied().reduce(DVec2::min).unwrap();
        let extent = points.iter().copied().reduce(DVec2::max).unwrap() - low;
        let points = points.into_iter().map(|point| (point - low) / extent).collect();
        Self { points, low, extent, durations_secs }
    }

    /// Returns the weight of each sample at a point.
    fn weights(&self, at: [f32; 2]) -> Vec<f64> {
        let at = (DVec2::new(f64::from(at[0]), f64::from(at[1])) - self.low) / self.extent;
        self.in_triangle(at).unwrap_or_else(|| self.on_edge(at))
    }

    fn in_triangle(&self, at: DVec2) -> Option<Vec<f64>> {
        let count = self.points.len();
        for i in 0..count {
            for j in i + 1..count {
                for k in j + 1..count {
                    let corners = [i, j, k];
                    let parts = parts(corners.map(|corner| self.points[corner]), at);
                    if parts.iter().all(|part| *part >= 0.0) && self.has_empty_circle(corners) {
                        let mut weights = vec![0.0; count];
                        corners.iter().zip(parts).for_each(|(at, part)| weights[*at] = part);
                        return Some(weights);
                    }
                }
            }
        }
        None
    }

    fn has_empty_circle(&self, corners: [usize; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| self.points[corner]);
        let (b, c) = (b - a, c - a);
        let center = DVec2::new(
            c.y * b.length_squared() - b.y * c.length_squared(),
            b.x * c.length_squared() - c.x * b.length_squared(),
        ) / (2.0 * b.perp_dot(c));
        let others = self.points.iter().enumerate().filter(|(nth, _)| !corners.contains(nth));
        let mut distances = others.map(|(_, point)| (*point - a - center).length());
        distances.all(|distance| distance > center.length())
    }

    fn on_edge(&self, at: DVec2) -> Vec<f64> {
        let mut nearest = (f64::INFINITY, 0, 0, 0.0);
        for (i, from) in self.points.iter().enumerate() {
            for (j, to) in self.points.iter().enumerate().skip(i + 1) {
                let along = *to - *from;
                let part = ((at - *from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                let away = (*from + along * part).distance(at);
                if away < nearest.0 {
                    nearest = (away, i, j, part);
                }
            }
        }
        let (_, from, to, part) = nearest;
        let mut weights = vec![0.0; self.points.len()];
        (weights[from], weights[to]) = (1.0 - part, part);
        weights
    }

    /// Returns cycles per second: the weighted mean of those of the clips that have a duration.
    fn rate(&self, weights: &[f64]) -> f64 {
        let moving = || weights.iter().zip(&self.durations_secs).filter(|(_, secs)| **secs > 0.0);
        let total: f64 = moving().map(|(weight, _)| weight).sum();
        if total > 0.0 { moving().map(|(w, secs)| w / secs).sum::<f64>() / total } else { 0.0 }
    }
}

/// Returns the barycentric coordinates of a point; not numbers for a triangle without area.
fn parts([a, b, c]: [DVec2; 3], at: DVec2) -> [f64; 3] {
    let area = (b - a).perp_dot(c - a);
    let part = |from: DVec2, to: DVec2| (to - from).perp_dot(at - from) / area;
    [part(b, c), part(c, a), part(a, b)]
}

/// Weights that run linearly from one set to another.
struct Ramp {
    from: Vec<f64>,
    to: Vec<f64>,
    begun_tick: u64,
    ticks: u64,
}

impl Ramp {
    fn at(&self, tick: u64) -> Vec<f64> {
        let past = (tick - self.begun_tick) as f64;
        let part = if self.ticks == 0 { 1.0 } else { (past / self.ticks as f64).min(1.0) };
        self.from.iter().zip(&self.to).map(|(from, to)| from + (to - from) * part).collect()
    }
}

#[test]
fn space_follows_its_oracle_through_random_moves() {
    let mut rng = Rng::new(91);
    for _ in 0..12 {
        let points: Vec<[f32; 2]> = (0..9).map(|_| [2.0 * rng.unit(), rng.unit()]).collect();
        follow(&mut rng, &points);
    }
}

fn follow(rng: &mut Rng, points: &[[f32; 2]]) {
    let builder = Crowd::builder().device(Device::native()).slots_per_member(8);
    let (mut crowd, clips, member) = one_member(&builder, &motions());
    let durations = motions().iter().map(|motion| f64::from(motion.duration_secs)).collect();
    let samples = Samples::new(points, durations);
    let space: Vec<_> = clips.iter().copied().zip(points.iter().copied()).collect();
    let space = crowd.add_blend_space(BlendSpace::plane(&space).unwrap()).unwrap();
    let start = [0.5, 0.5];
    let playback = BlendSpacePlayback::new().phase(0.3);
    crowd.member_mut(member).unwrap().play_blend_space(space, start, playback).unwrap();
    let at_start = samples.weights(start);
    let mut ramp = Ramp { from: at_start.clone(), to: at_start, begun_tick: 0, ticks: 0 };
    let (mut tick, mut phase) = (0, f64::from(0.3_f32));
    for frame in 0..240 {
        // A move ends before the next begins, so that no clip runs out of slots.
        if frame % 16 == 0 {
            let at = [2.4 * rng.unit() - 0.2, 1.4 * rng.unit() - 0.2];
            let over_ticks = [0, TICKS_PER_SEC / 8, TICKS_PER_SEC / 4][frame / 16 % 3];
            let over_secs = over_ticks as f32 / TICKS_PER_SEC as f32;
            crowd.member_mut(member).unwrap().set_blend_parameter(at, over_secs).unwrap();
            let from = ramp.at(tick);
            ramp = Ramp { from, to: samples.weights(at), begun_tick: tick, ticks: over_ticks };
        }
        crowd.update(FRAME_TICKS as f32 / TICKS_PER_SEC as f32).unwrap();
        tick += FRAME_TICKS;
        phase += samples.rate(&ramp.to) * FRAME_TICKS as f64 / TICKS_PER_SEC as f64;
        let seen = Seen { weights: &ramp.at(tick), phase };
        seen.compare(&crowd, member, &clips, &samples.durations_secs, frame);
    }
}

/// The state of a blend space in a frame.
struct Seen<'a> {
    weights: &'a [f64],
    phase: f64,
}

impl Seen<'_> {
    fn compare(
        &self,
        crowd: &Crowd,
        member: MemberId,
        clips: &[ClipId],
        durations_secs: &[f64],
        frame: usize,
    ) {
        let active = crowd.member(member).unwrap().active_clips();
        for (nth, clip) in clips.iter().enumerate() {
            let found = active.iter().filter(|playing| playing.clip == *clip);
            let weight: f64 = found.map(|playing| f64::from(playing.weight)).sum();
            let off = (weight - self.weights[nth]).abs();
            assert!(
                off < WEIGHT_BOUND,
                "frame {frame}, clip {nth}: weight {weight} is not {}",
                self.weights[nth]
            );
        }
        for playing in active.iter() {
            let nth = clips.iter().position(|clip| *clip == playing.clip).unwrap();
            if durations_secs[nth] > 0.0 {
                let cycles = f64::from(playing.time_secs) / durations_secs[nth] - self.phase;
                let off = (cycles - cycles.round()).abs();
                assert!(off < PHASE_BOUND, "frame {frame}, clip {nth}: {off} cycles off");
            }
        }
    }
}
