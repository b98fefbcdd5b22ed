//! Numbers about a whole recording.

use crate::{Agent, Kind, Recording, Track, most_present};

/// Times nearer to each other than this, in seconds, are one.
const SAME_SECS: f64 = 1e-6;
/// Distance between rows, in usual intervals, above which there is a gap between them.
const GAP_INTERVALS: f64 = 1.5;

/// Numbers about a whole recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The number of agents.
    pub agents: usize,
    /// The number of distinct times at which somebody has a row.
    pub frames: usize,
    /// Frames per second of the file.
    pub fps: f64,
    /// The usual number of rows of an agent in a second; see [`Recording::rows_per_sec`].
    pub rows_per_sec: f64,
    /// Seconds from the first row to the last.
    pub duration_s: f64,
    /// The most agents that are there at the same time, people and vehicles. Each counts at all
    /// times from its first row to its last, both included, and in gaps between its rows.
    pub peak_agents: usize,
    /// The median speed of people in metres per second; 0 if nobody has two rows.
    pub median_speed_m_s: f64,
    /// The speed in metres per second that 95 of 100 rows of people do not exceed.
    pub p95_speed_m_s: f64,
    /// The greatest speed of a person from a row to the next, in metres per second.
    pub max_speed_m_s: f64,
    /// The corners with the least and the greatest coordinates of all positions, in metres.
    pub extent_m: [[f32; 2]; 2],
    /// The least and the greatest elevation of the ground in metres, if the file has some.
    pub elevations_m: Option<[f32; 2]>,
    /// Interruptions of agents' rows.
    pub gaps: Gaps,
}

/// Interruptions of agents' rows: longer than one and a half of the usual interval between rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gaps {
    /// The number of agents with an interruption.
    pub agents: usize,
    /// The longest interruption in seconds.
    pub longest_s: f64,
}

impl Recording {
    /// Returns numbers about the whole recording.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let secs = self.secs();
        let interval_secs = self.usual_interval_secs();
        let (gaps, mut speeds) = self.gaps_and_speeds(interval_secs);
        Summary {
            agents: self.agents.len(),
            frames: frames(self.times.clone()),
            fps: self.source.fps.value,
            rows_per_sec: self.rows_per_sec_of(interval_secs),
            duration_s: (secs[1] - secs[0]).max(0.0),
            peak_agents: self.peak_agents(),
            median_speed_m_s: percentile(&mut speeds, 50),
            p95_speed_m_s: percentile(&mut speeds, 95),
            max_speed_m_s: percentile(&mut speeds, 100),
            extent_m: self.extent(),
            elevations_m: self.elevation_range(),
            gaps,
        }
    }

    /// Returns the usual number of rows of an agent in a second. It is that of the file's frames,
    /// unless agents have a row in every other frame or in fewer.
    #[must_use]
    pub fn rows_per_sec(&self) -> f64 {
        self.rows_per_sec_of(self.usual_interval_secs())
    }

    fn rows_per_sec_of(&self, interval_secs: f64) -> f64 {
        let fps = self.source.fps.value;
        if interval_secs * fps > GAP_INTERVALS { 1.0 / interval_secs } else { fps }
    }

    /// Returns the median time from a row of an agent to the next; 0 if nobody has two rows.
    fn usual_interval_secs(&self) -> f64 {
        let tracks = self.agents.iter().map(|agent| self.track(agent));
        let mut intervals: Vec<f64> =
            tracks.flat_map(|track| track.times.windows(2)).map(|pair| pair[1] - pair[0]).collect();
        percentile(&mut intervals, 50)
    }

    fn elevation_range(&self) -> Option<[f32; 2]> {
        let elevations = self.elevations.iter().filter(|elevation| elevation.is_finite());
        elevations.map(|z| [*z; 2]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    fn peak_agents(&self) -> usize {
        let times = self.agents.iter().map(|agent| self.track(agent).times);
        most_present(times.filter_map(|times| Some([*times.first()?, *times.last()?])))
    }

    /// Returns the gaps, and the speeds of people elsewhere.
    fn gaps_and_speeds(&self, interval_secs: f64) -> (Gaps, Vec<f64>) {
        let longest = GAP_INTERVALS * interval_secs;
        let (mut gaps, mut speeds) = (Gaps::default(), Vec::new());
        for agent in &self.agents {
            let widest = self.add_speeds(agent, longest, &mut speeds);
            gaps.agents += usize::from(widest > 0.0);
            gaps.longest_s = gaps.longest_s.max(widest);
        }
        (gaps, speeds)
    }

    /// Adds the speeds of an agent, if it is a person, and returns its longest gap in seconds.
    fn add_speeds(&self, agent: &Agent, longest: f64, speeds: &mut Vec<f64>) -> f64 {
        let track = self.track(agent);
        let mut widest = 0.0_f64;
        for (times, at) in track.times.windows(2).zip(track.positions.windows(2)) {
            let secs = times[1] - times[0];
            if secs > longest && !is_step(&track, times[0]) {
                widest = widest.max(secs);
            } else if agent.kind == Kind::Person {
                let way = [0, 1].map(|axis| f64::from(at[1][axis]) - f64::from(at[0][axis]));
                speeds.push(way[0].hypot(way[1]) / secs);
            }
        }
        widest
    }
}

/// Returns true if a footstep begins at a time: the rows around it are no gap, however long it is.
fn is_step(track: &Track<'_>, secs: f64) -> bool {
    let next = track.steps.partition_point(|step| step.secs[0] < secs - SAME_SECS);
    track.steps.get(next).is_some_and(|step| step.secs[0] < secs + SAME_SECS)
}

/// Returns the number of distinct times.
fn frames(mut times: Vec<f64>) -> usize {
    times.sort_unstable_by(f64::total_cmp);
    times.dedup_by(|time, before| *time - *before < SAME_SECS);
    times.len()
}

/// Returns the value that `hundredth` of 100 values do not exceed; 0 without values.
fn percentile(values: &mut [f64], hundredth: usize) -> f64 {
    let rank = (values.len() * hundredth).div_ceil(100).max(1) - 1;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(rank, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{ReadSettings, parse};

    fn summary(text: &str) -> Summary {
        let name = Path::new("rows.txt");
        parse(name, text.into(), &ReadSettings::default()).unwrap().summary()
    }

    #[test]
    fn numbers_are_those_of_the_rows() {
        let mut text = "# framerate: 10 fps\n# id frame x/m y/m z/m\n".to_owned();
        for frame in 0..21 {
            text += &format!("1 {frame} {} 0 1.7\n", 0.1 * f64::from(frame));
        }
        // The second walks twice as fast, comes when the first goes, and is away for 0.8 s.
        for frame in (20..31).chain(38..41) {
            text += &format!("2 {frame} {} 3 1.7\n", 0.2 * f64::from(frame));
        }
        let summary = summary(&text);
        assert_eq!((summary.agents, summary.frames, summary.peak_agents), (2, 34, 2));
        assert_eq!((summary.fps, summary.duration_s), (10.0, 4.0));
        assert!((summary.median_speed_m_s - 1.0).abs() < 1e-4, "{summary:?}");
        assert!((summary.p95_speed_m_s - 2.0).abs() < 1e-4, "{summary:?}");
        assert!((summary.max_speed_m_s - 2.0).abs() < 1e-4, "{summary:?}");
        assert_eq!(summary.elevations_m, None);
        assert_eq!(summary.extent_m, [[0.0, 0.0], [8.0, 3.0]]);
        assert_eq!(summary.gaps.agents, 1);
        assert!((summary.gaps.longest_s - 0.8).abs() < 1e-9, "{summary:?}");
    }

    #[test]
    fn a_single_row_has_no_speed_and_no_gap() {
        let summary = summary("# framerate: 10 fps\n# id frame x/m y/m z/m\n1 5 2 3 1.7\n");
        assert_eq!((summary.frames, summary.peak_agents, summary.duration_s), (1, 1, 0.0));
        assert_eq!((summary.median_speed_m_s, summary.p95_speed_m_s), (0.0, 0.0));
        assert_eq!(summary.gaps, Gaps::default());
    }

    #[test]
    fn long_footsteps_are_no_gaps() {
        let header =
            "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1";
        let steps = "1 0 0.5 0 0 1 0\n1 0.5 1 1 0 2 0\n1 1 4 2 0 3 0\n1 4 4.5 3 0 4 0\n\
                     2 0 0.5 0 0 1 0\n2 2 2.5 1 0 2 0\n";
        let summary = summary(&format!("{header}\n{steps}"));
        assert_eq!(summary.gaps, Gaps { agents: 1, longest_s: 1.5 });
    }
}
