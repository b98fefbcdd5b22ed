//! The smoothed motion of recorded agents, at any time.

use std::ops::Range;
use std::sync::Arc;

use populace_trajectory::{Agent, Footstep, Kind, Recording, Track, most_present};

use crate::heading;
use crate::smoothing::{at_even_times, hermite, low_pass};

/// Cut-off frequencies of the filter in hertz: for heads that sway as people step, and for agents
/// that do not, such as simulated ones.
const SWAYING_HZ: f64 = 0.5;
const STEADY_HZ: f64 = 1.0;
/// Mean sway in metres from which on agents sway.
const SWAYS_M: f64 = 0.006;
/// Agents by which sway is measured.
const MEASURED: usize = 60;
/// Speed in metres per second from which on somebody walks and sways.
const WALKS_M_PER_SEC: f64 = 0.5;
/// Shortest and longest step of stored motions in seconds, where rows are not far apart.
const STEP_SECS: [f64; 2] = [1.0 / 30.0, 0.1];
/// Most steps in the usual interval between rows. Agents leave in gaps of a few intervals, so the
/// number of rows bounds that of steps, however far apart rows are.
const STEPS_PER_INTERVAL: f64 = 20.0;
/// An agent that is not seen for this time in seconds, and for as many intervals, has left.
const LEFT_SECS: f64 = 1.5;
const LEFT_INTERVALS: f64 = 3.0;
/// The way in metres from which on a step that no sprinter could take is a jump. Shorter ones are
/// faults of a camera, such as a head that is taken for another.
const JUMP_M: f64 = 2.0;
/// Speeds in metres per second below which somebody comes to stand, and above which somebody who
/// stands walks on.
const STANDS_M_PER_SEC: f64 = 0.1;
const SETS_OFF_M_PER_SEC: f64 = 0.2;
/// The distance in metres by which somebody who stands may drift before taking a step.
const DRIFT_M: f64 = 0.12;
/// Seconds for which somebody who drifted steps.
const STEPS_SECS: f64 = 0.6;

/// Position and motion of an agent at one time, on the plan of its recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Position `[x, y]` in metres.
    pub position: [f32; 2],
    /// Velocity `[x, y]` in metres per second.
    pub velocity: [f32; 2],
    /// Heading in radians, counter-clockwise from +x.
    pub heading_rad: f32,
    /// Height of the ground in metres.
    pub elevation_m: f32,
    /// Direction of view in radians, if the file has one.
    pub view_rad: Option<f32>,
    /// True for somebody who stands, though the position may drift by centimetres.
    pub stands: bool,
}

/// The motion of one agent.
#[derive(Clone, Debug)]
pub struct Motion {
    spans: Vec<Span>,
    /// Empty if the file has no footsteps.
    steps: Vec<Footstep>,
}

/// A time in which an agent is there and does not jump. The next one begins when it ends if the agent
/// jumps then.
#[derive(Clone, Debug)]
struct Span {
    secs: [f64; 2],
    step_secs: f64,
    positions: Vec<[f32; 2]>,
    headings: Vec<f32>,
    /// Empty on level ground.
    elevations: Vec<f32>,
    /// Empty if the file has no directions of view.
    views: Vec<f32>,
    stands: Vec<bool>,
}

/// The motions of all agents of a recording.
#[derive(Clone, Debug)]
pub struct Motions {
    /// The motions, in the order of the agents. Vehicles are never there.
    pub agents: Arc<[Motion]>,
    /// The cut-off frequency of the filter in hertz.
    pub cutoff_hz: f64,
    /// Mean sway of the agents in metres: the distance aside from the filtered path.
    pub sway_m: f64,
}

impl Motions {
    /// Smooths the tracks of a recording.
    #[must_use]
    pub fn new(recording: &Recording) -> Self {
        let rows_per_sec = recording.rows_per_sec();
        let step_secs = step_secs(rows_per_sec);
        let sway_m = sway_m(recording, rows_per_sec);
        let cutoff_hz = if sway_m > SWAYS_M { SWAYING_HZ } else { STEADY_HZ };
        let motion = |agent: &Agent| {
            if agent.kind == Kind::Vehicle {
                return Motion { spans: Vec::new(), steps: Vec::new() };
            }
            let track = recording.track(agent);
            let spans = spans(&track, rows_per_sec);
            let span = |(rows, secs)| Span::new(&track, rows, (secs, step_secs), cutoff_hz);
            let spans = spans.into_iter().map(span).collect();
            Motion { spans, steps: track.steps.to_vec() }
        };
        let agents = recording.agents.iter().map(motion).collect();
        Self { agents, cutoff_hz, sway_m }
    }

    /// The largest number of agents who are there at the same time: the capacity that a crowd needs
    /// for all people of a [`Replay`](crate::Replay). Agents count until [`Motion::PAST_SECS`]
    /// after their last rows.
    #[must_use]
    pub fn peak(&self) -> usize {
        let spans = self.agents.iter().flat_map(Motion::secs);
        most_present(spans.map(|[from, until]| [from, until + Motion::PAST_SECS]))
    }
}

impl Motion {
    /// Seconds after its last row in which an agent is still there: times that add up from frame to
    /// frame are not exact.
    pub const PAST_SECS: f64 = 1e-3;
    /// Speed in metres per second that no step has: one that is faster, and longer than two metres,
    /// is a jump. The fastest of all sprinters kept 12.1 m/s up for 20 m (M. Čoh and others,
    /// "Kinematics of Usain Bolt's maximal sprint velocity", Kinesiology 50 (2018), 172-180).
    pub const SPRINT_M_PER_SEC: f64 = 12.0;

    /// Returns where the agent is; `None` while it is not there.
    #[must_use]
    pub fn at(&self, secs: f64) -> Option<Moment> {
        let (span, secs) = self.span_at(secs)?;
        Some(span.at(secs))
    }

    /// Returns the time in which the agent is there around a time, and that time within it.
    fn span_at(&self, secs: f64) -> Option<(&Span, f64)> {
        let next = self.spans.partition_point(|span| span.secs[0] <= secs);
        let span = self.spans.get(next.checked_sub(1)?)?;
        let is_there = secs <= span.secs[1] + Self::PAST_SECS;
        is_there.then(|| (span, secs.min(span.secs[1])))
    }

    /// Returns the filtered position at a time in seconds, on a line between the two nearest stored
    /// ones; `None` while the agent is not there.
    #[must_use]
    pub fn filtered_at(&self, secs: f64) -> Option<[f32; 2]> {
        let (span, secs) = self.span_at(secs)?;
        Some(span.filtered_at(secs))
    }

    /// The footsteps that the file has, in the order of time.
    #[must_use]
    pub fn steps(&self) -> &[Footstep] {
        &self.steps
    }

    /// Returns from when and until when the agent is there around a time, in seconds; `None` while
    /// it is not there.
    pub(crate) fn secs_around(&self, secs: f64) -> Option<[f64; 2]> {
        let [from, _] = self.unbroken(secs)?;
        self.secs().find(|[_, until]| from < *until)
    }

    /// Returns from when and until when the agent is there around a time without a jump, in
    /// seconds; `None` while it is not there. It jumps in the middle between two rows.
    #[must_use]
    pub fn unbroken(&self, secs: f64) -> Option<[f64; 2]> {
        self.span_at(secs).map(|(span, _)| span.secs)
    }

    /// Returns the times from when and until when the agent is there, in seconds.
    pub fn secs(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let visits = self.spans.chunk_by(|span, next| span.secs[1] == next.secs[0]);
        visits.map(|visit| [visit[0].secs[0], visit[visit.len() - 1].secs[1]])
    }

    /// Returns the times at which the agent comes or has jumped, in seconds.
    pub(crate) fn begins(&self) -> impl Iterator<Item = f64> + '_ {
        self.spans.iter().map(|span| span.secs[0])
    }
}

impl Span {
    fn new(
        track: &Track<'_>,
        rows: Range<usize>,
        ([from, until], step_secs): ([f64; 2], f64),
        cutoff_hz: f64,
    ) -> Self {
        let times = &track.times[rows.clone()];
        let (count, step_secs) = steps(from, until, step_secs);
        let even = |values: &[f64]| at_even_times(times, values, from, step_secs, count);
        let [x, y] = [0, 1].map(|axis| {
            let of = track.positions[rows.clone()].iter();
            let mut values = even(&of.map(|at| f64::from(at[axis])).collect::<Vec<_>>());
            low_pass(&mut values, step_secs, cutoff_hz);
            values
        });
        let velocities: Vec<[f64; 2]> =
            (0..count).map(|nth| [slope(&x, nth), slope(&y, nth)].map(|v| v / step_secs)).collect();
        let nearest = |values: &[f32]| -> Vec<f64> {
            let row = |nth: usize| {
                let at = from + nth as f64 * step_secs;
                times.partition_point(|time| *time <= at).saturating_sub(1)
            };
            (0..count).map(|nth| f64::from(values[row(nth)])).collect()
        };
        let headings = match track.headings.get(rows.clone()) {
            Some(headings) if headings.iter().any(|heading| heading.is_finite()) => {
                heading::of_data(&nearest(headings), &velocities, step_secs)
            }
            _ => heading::of_motion(&velocities, step_secs),
        };
        let views = match track.views.get(rows.clone()) {
            Some(views) if views.iter().any(|view| view.is_finite()) => {
                heading::of_views(&nearest(views), step_secs)
            }
            _ => Vec::new(),
        };
        let elevations = track.elevations.get(rows).map_or_else(Vec::new, |elevations| {
            let mut values = even(&elevations.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
            low_pass(&mut values, step_secs, STEADY_HZ);
            values
        });
        let positions: Vec<[f64; 2]> = x.iter().zip(&y).map(|(x, y)| [*x, *y]).collect();
        let stands = stands(&positions, &velocities, step_secs);
        Self {
            secs: [from, until],
            step_secs,
            positions: positions.into_iter().map(|at| at.map(rounded)).collect(),
            headings: headings.into_iter().map(rounded).collect(),
            elevations: elevations.into_iter().map(rounded).collect(),
            views: views.into_iter().map(rounded).collect(),
            stands,
        }
    }

    /// Returns the stored rows around a time, and the part of the way from one to the other.
    fn around(&self, secs: f64) -> ([usize; 2], f64) {
        let last = self.positions.len() - 1;
        let steps = ((secs - self.secs[0]) / self.step_secs).clamp(0.0, last as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within rows")]
        let nth = (steps as usize).min(last.saturating_sub(1));
        ([nth, (nth + 1).min(last)], steps - nth as f64)
    }

    fn filtered_at(&self, secs: f64) -> [f32; 2] {
        let ([nth, next], part) = self.around(secs);
        let [a, b] = [self.positions[nth], self.positions[next]];
        [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * rounded(part))
    }

    fn at(&self, secs: f64) -> Moment {
        let last = self.positions.len() - 1;
        let ([nth, next], part) = self.around(secs);
        let curve = |axis: usize| {
            let value = |nth: usize| f64::from(self.positions[nth][axis]);
            let slope = |nth: usize| {
                let (before, after) = (nth.saturating_sub(1), (nth + 1).min(last));
                (value(after) - value(before)) / ((after - before).max(1) as f64)
            };
            let ends = [value(nth), value(next)];
            let slopes = [slope(nth), slope(next)];
            let change = slopes[0] + (slopes[1] - slopes[0]) * part;
            (hermite(ends, slopes, part), change / self.step_secs)
        };
        let [(x, vx), (y, vy)] = [curve(0), curve(1)];
        let line = |values: &[f32]| {
            let [a, b] = [nth, next].map(|nth| values.get(nth).copied().unwrap_or(0.0));
            a + (b - a) * rounded(part)
        };
        Moment {
            position: [rounded(x), rounded(y)],
            velocity: [rounded(vx), rounded(vy)],
            heading_rad: line(&self.headings),
            elevation_m: line(&self.elevations),
            view_rad: (!self.views.is_empty()).then(|| line(&self.views)),
            stands: self.stands[nth],
        }
    }
}

/// Returns the step of stored motions in seconds, for a number of rows of an agent in a second.
fn step_secs(rows_per_sec: f64) -> f64 {
    let interval_secs = 1.0 / rows_per_sec;
    interval_secs.clamp(STEP_SECS[0], STEP_SECS[1]).max(interval_secs / STEPS_PER_INTERVAL)
}

/// Returns the number of even times from one time to another, both included, and the step between
/// them in seconds, which is near the one given.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "times are in order")]
fn steps(from: f64, until: f64, step_secs: f64) -> (usize, f64) {
    let steps = ((until - from) / step_secs).round().max(1.0);
    (steps as usize + 1, ((until - from) / steps).max(1e-6))
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
fn rounded(value: f64) -> f32 {
    value as f32
}

/// Returns the change of values per step around one of them.
fn slope(values: &[f64], nth: usize) -> f64 {
    let (before, after) = (nth.saturating_sub(1), (nth + 1).min(values.len() - 1));
    (values[after] - values[before]) / (after - before).max(1) as f64
}

/// Returns the ranges of rows in which an agent is there without a long gap or a jump, and from when
/// and until when.
fn spans(track: &Track<'_>, rows_per_sec: f64) -> Vec<(Range<usize>, [f64; 2])> {
    let (times, longest) = (track.times, LEFT_SECS.max(LEFT_INTERVALS / rows_per_sec));
    let parts = |next: usize| {
        let [before, after] = [times[next - 1], times[next]];
        if after - before > longest {
            return Some((next, [before, after]));
        }
        let middle = f64::midpoint(before, after);
        jumps(track, next).then_some((next, [middle; 2]))
    };
    let parts: Vec<_> = (1..times.len()).filter_map(parts).collect();
    let begins = parts.iter().map(|(next, [_, from])| (*next, *from));
    let ends = parts.iter().map(|(next, [until, _])| (*next, *until));
    let begins = std::iter::once((0, times[0])).chain(begins);
    let ends = ends.chain([(times.len(), times[times.len() - 1])]);
    let around_secs = 0.5 / rows_per_sec;
    let span = |((first, from), (end, until)): ((usize, f64), (usize, f64))| {
        // Somebody with one row is there around it, for the usual time between rows.
        let is_alone = |secs: f64| end - first == 1 && secs == times[first];
        let from = if is_alone(from) { from - around_secs } else { from };
        let until = if is_alone(until) { until + around_secs } else { until };
        (first..end, [from, until])
    };
    begins.zip(ends).map(span).collect()
}

/// Returns true if an agent cannot have gone to a row from the one before.
fn jumps(track: &Track<'_>, row: usize) -> bool {
    let [from, to] = [row - 1, row].map(|row| track.positions[row].map(f64::from));
    let way_m = (to[0] - from[0]).hypot(to[1] - from[1]);
    let secs = track.times[row] - track.times[row - 1];
    way_m > JUMP_M.max(Motion::SPRINT_M_PER_SEC * secs)
}

/// Returns when somebody stands. Positions that drift are followed by a few steps now and then.
fn stands(positions: &[[f64; 2]], velocities: &[[f64; 2]], step_secs: f64) -> Vec<bool> {
    let smooth = crate::smoothing::bell(velocities, step_secs, 0.3);
    let mut anchor: Option<[f64; 2]> = None;
    let mut steps_secs = 0.0;
    let one = |(at, velocity): (&[f64; 2], &[f64; 2])| {
        let speed = velocity[0].hypot(velocity[1]);
        steps_secs -= step_secs;
        match anchor {
            Some(_) if speed > SETS_OFF_M_PER_SEC => anchor = None,
            Some(from) if (at[0] - from[0]).hypot(at[1] - from[1]) > DRIFT_M => {
                steps_secs = STEPS_SECS;
                anchor = Some(*at);
            }
            None if speed < STANDS_M_PER_SEC => anchor = Some(*at),
            _ => {}
        }
        anchor.is_some() && steps_secs <= 0.0
    };
    positions.iter().zip(&smooth).map(one).collect()
}

/// Returns the mean distance in metres of agents who walk from their filtered paths, aside from the
/// direction in which they go.
fn sway_m(recording: &Recording, rows_per_sec: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    // Rows further apart than a quarter of a second cannot show steps.
    if rows_per_sec < 4.0 {
        return 0.0;
    }
    let step_secs = step_secs(rows_per_sec);
    let every = recording.agents.len().div_ceil(MEASURED);
    for agent in recording.agents.iter().step_by(every) {
        let track = recording.track(agent);
        let Some((rows, _)) = spans(&track, rows_per_sec).into_iter().next() else {
            continue;
        };
        let times = &track.times[rows.clone()];
        let (even, step_secs) = steps(times[0], times[times.len() - 1], step_secs);
        let raw = [0, 1].map(|axis| {
            let of = track.positions[rows.clone()].iter();
            let values: Vec<f64> = of.map(|at| f64::from(at[axis])).collect();
            at_even_times(times, &values, times[0], step_secs, even)
        });
        let mut smooth = raw.clone();
        smooth.iter_mut().for_each(|values| low_pass(values, step_secs, SWAYING_HZ));
        for nth in 0..even {
            let velocity = [0, 1].map(|axis| slope(&smooth[axis], nth) / step_secs);
            let speed = velocity[0].hypot(velocity[1]);
            if speed > WALKS_M_PER_SEC {
                let [dx, dy] = [0, 1].map(|axis| raw[axis][nth] - smooth[axis][nth]);
                sum += ((dx * velocity[1] - dy * velocity[0]) / speed).abs();
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use populace_trajectory::{ReadSettings, parse};

    use super::*;

    fn recording(text: &str) -> Recording {
        parse(Path::new("rows.csv"), text.into(), &ReadSettings::default()).unwrap()
    }

    #[test]
    fn rows_far_apart_need_no_more_memory_than_others() {
        let days = "id,t,x,y\n1,0,0,0\n1,100000,1,1\n1,300000,2,1\n1,400000,3,1\n";
        let motions = Motions::new(&recording(days));
        let spans = &motions.agents[0].spans;
        let stored: usize = spans.iter().map(|span| span.positions.len()).sum();
        assert!((40..=100).contains(&stored), "{stored} stored rows");
        let at = motions.agents[0].at(300_000.0).unwrap();
        assert!((at.position[0] - 2.0).abs() < 1e-3, "{at:?}");
    }

    /// Frames count 25 in a second, and agents have a row in each fiftieth.
    #[test]
    fn agents_stay_between_rows_many_frames_apart() {
        let rows = "id,frame,x,y\n1,0,0,0\n1,50,1,0\n1,100,2,0\n1,150,3,0\n2,0,0,5\n2,100,2,5\n";
        let motions = Motions::new(&recording(rows));
        for (agent, expected) in [(0, 1.25), (1, 1.25)] {
            let at = motions.agents[agent].at(2.5).map(|moment| moment.position[0]);
            assert!(at.is_some_and(|x| (x - expected).abs() < 0.1), "{agent}: {at:?}");
        }
    }

    /// Ten times a tenth of a second, as `f32`, is a little more than a second.
    #[test]
    fn agents_are_there_when_added_times_reach_their_last_row() {
        let motions = Motions::new(&recording("id,t,x,y\n1,0,0,0\n1,1,1,0\n"));
        let secs = 10.0 * f64::from(0.1_f32);
        assert!(secs > 1.0);
        assert_eq!(motions.agents[0].at(secs), motions.agents[0].at(1.0));
        assert!(motions.agents[0].at(1.0).is_some() && motions.agents[0].at(1.01).is_none());
    }

    /// The second one comes within the time for which the first is still there.
    #[test]
    fn peaks_count_agents_until_they_are_gone() {
        let peak = |second: &str| {
            let rows = format!("id,t,x,y\n1,0,0,0\n1,1,1,0\n2,{second},0,5\n2,3,1,5\n");
            Motions::new(&recording(&rows)).peak()
        };
        assert_eq!(["1", "1.0005", "1.1"].map(peak), [2, 2, 1]);
    }

    #[test]
    fn agents_with_one_row_are_there_for_the_time_between_rows() {
        let rows = "id,t,x,y\n1,0,0,0\n1,0.5,1,0\n1,1,2,0\n1,1.5,2,0\n2,0.5,7,5\n";
        let motions = Motions::new(&recording(rows));
        let one = &motions.agents[1];
        assert_eq!(one.secs().collect::<Vec<_>>(), [[0.25, 0.75]]);
        assert_eq!([0.3, 0.7].map(|at| one.at(at).map(|at| at.position)), [Some([7.0, 5.0]); 2]);
        assert!(one.at(0.2).is_none() && one.at(0.8).is_none());
    }

    #[test]
    fn agents_jump_between_rows_that_nobody_could_reach() {
        let rows = "id,t,x/m,y/m\n1,0,0,0\n1,0.1,0.1,0\n1,0.2,9,5\n1,0.3,0.3,0\n1,0.4,0.4,0\n\
                    2,0,0,0\n2,0.1,1.9,0\n2,0.2,3.8,0\n3,0,0,0\n3,1,11,0\n";
        let motions = Motions::new(&recording(rows));
        let [jumps, fast, far] = [0, 1, 2].map(|agent| &motions.agents[agent]);
        let tenths = |at| jumps.at(at).map(|moment| (10.0 * moment.position[0]).round());
        let [near, there] = [Some(1.0), Some(90.0)];
        assert_eq!([0.14, 0.16, 0.24, 0.26].map(tenths), [near, there, there, Some(3.0)]);
        assert_eq!(jumps.secs().collect::<Vec<_>>(), [[0.0, 0.4]]);
        assert_eq!(jumps.secs_around(0.2), Some([0.0, 0.4]));
        assert_eq!(motions.peak(), 3);
        for (agent, until) in [(fast, 0.2), (far, 1.0)] {
            assert_eq!(agent.unbroken(0.0), Some([0.0, until]));
        }
    }

    #[test]
    fn rows_up_to_two_seconds_apart_have_steps_of_a_tenth_of_a_second_at_most() {
        for (interval_secs, expected) in
            [(0.02, 1.0 / 30.0), (0.04, 0.04), (0.1, 0.1), (0.4, 0.1), (1.0, 0.1), (2.0, 0.1)]
        {
            assert_eq!(step_secs(1.0 / interval_secs), expected, "{interval_secs}");
        }
        assert_eq!(step_secs(0.01), 5.0);
    }
}
