//! One test for each file of simulators in the folder `POPULACE_TEST_DATA` (environment variable).

use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use populace_trajectory::{
    Format, Gaps, HeadingSource, Origin, ReadSettings, Recording, Unit, load,
};

const VARIABLE: &str = "POPULACE_TEST_DATA";

/// The contents of a file, counted by other programs.
struct Expected {
    file: &'static str,
    format: Format,
    agents: usize,
    rows: usize,
    /// Distinct times, and the most people at a time.
    frames: [usize; 2],
    fps: f64,
    secs: [f64; 2],
    /// The corners of all positions.
    extent: [[f32; 2]; 2],
    heading: HeadingSource,
    /// The corners of the walkable area's outline, its holes, and obstacles.
    place: [usize; 3],
}

const FILES: [Expected; 7] = [
    Expected {
        file: "jupedsim/jps14_bottleneck_60.sqlite",
        format: Format::JuPedSim,
        agents: 60,
        rows: 47893,
        frames: [1501, 60],
        fps: 25.0,
        secs: [0.0, 60.0],
        extent: [[0.9117, 0.1951], [17.0279, 7.1647]],
        heading: HeadingSource::Data,
        place: [4, 2, 0],
    },
    Expected {
        file: "jupedsim/jps_plaza_1000.sqlite",
        format: Format::JuPedSim,
        agents: 1000,
        rows: 76440,
        frames: [101, 1000],
        fps: 2.5,
        secs: [0.0, 40.0],
        extent: [[1.3483, 0.2386], [58.6289, 37.5727]],
        heading: HeadingSource::Data,
        place: [4, 2, 0],
    },
    Expected {
        file: "jupedsim/pedpy_demo_30.sqlite",
        format: Format::JuPedSim,
        agents: 30,
        rows: 8083,
        frames: [491, 30],
        fps: 25.0,
        secs: [0.0, 19.6],
        extent: [[-7.3788, 1.7950], [7.6100, 8.9292]],
        heading: HeadingSource::Data,
        place: [11, 0, 0],
    },
    Expected {
        file: "jupedsim/jps14_bottleneck_60.h5",
        format: Format::Hdf5,
        agents: 60,
        rows: 47893,
        frames: [1501, 60],
        fps: 25.0,
        secs: [0.0, 60.0],
        extent: [[0.9117, 0.1951], [17.0279, 7.1647]],
        heading: HeadingSource::Data,
        place: [4, 2, 0],
    },
    Expected {
        file: "vadere/postvis.traj",
        format: Format::Vadere,
        agents: 20,
        // 493 steps that join, so one row for each step and one more for each agent.
        rows: 513,
        frames: [494, 20],
        fps: 1.7610,
        secs: [0.4, 25.2660],
        extent: [[1.1626, 1.1062], [6.7947, 8.7976]],
        heading: HeadingSource::Motion,
        place: [4, 0, 2],
    },
    Expected {
        file: "sumo/sumo_fcd_small.xml",
        format: Format::Sumo,
        agents: 60,
        rows: 2673,
        frames: [60, 60],
        fps: 1.0,
        secs: [0.0, 59.0],
        extent: [[-5.44, -5.44], [246.06, 244.29]],
        heading: HeadingSource::Data,
        place: [0, 0, 0],
    },
    Expected {
        file: "sumo/sumo_fcd_grid.xml.gz",
        format: Format::Sumo,
        agents: 600,
        rows: 94125,
        frames: [300, 505],
        fps: 2.0,
        secs: [0.0, 149.5],
        extent: [[-6.08, -6.71], [246.54, 246.72]],
        heading: HeadingSource::Data,
        place: [0, 0, 0],
    },
];

fn main() {
    let arguments = Arguments::from_args();
    let root = std::env::var_os(VARIABLE);
    let trials = root.map_or_else(ignored, |root| trials(&Path::new(&root).join("trajectories")));
    libtest_mimic::run(&arguments, trials).exit();
}

fn ignored() -> Vec<Trial> {
    let name = format!("files (set {VARIABLE} to the folder of test data)");
    vec![Trial::test(name, || Ok(())).with_ignored_flag(true)]
}

fn trials(root: &Path) -> Vec<Trial> {
    let trial = |expected: Expected| {
        let path = root.join(expected.file);
        Trial::test(expected.file, move || {
            let settings = ReadSettings { strict: true, ..ReadSettings::default() };
            check(&load(&path, &settings)?, &expected)
        })
    };
    FILES.into_iter().map(trial).collect()
}

fn check(recording: &Recording, expected: &Expected) -> Result<(), Failed> {
    let source = &recording.source;
    let walkable = recording.place.walkable_at(0.0);
    let corners = walkable.iter().map(|area| area.outline.len()).sum();
    let holes = walkable.iter().map(|area| area.holes.len()).sum();
    let counts = (recording.agents.len(), recording.row_count());
    equal("format", &source.format, &expected.format)?;
    equal("agents and rows", &counts, &(expected.agents, expected.rows))?;
    let summary = recording.summary();
    equal("frames", &[summary.frames, summary.peak_agents], &expected.frames)?;
    equal("gaps", &summary.gaps, &Gaps::default())?;
    equal("unit", &source.unit.value, &Unit::Metres)?;
    equal("origin of the unit", &source.unit.origin, &Origin::File)?;
    equal("heading", &source.heading.value, &expected.heading)?;
    equal("place", &[corners, holes, recording.place.obstacles.len()], &expected.place)?;
    near("fps", &[source.fps.value], &[expected.fps])?;
    near("time", &recording.secs(), &expected.secs)?;
    let numbers = |corners: [[f32; 2]; 2]| -> Vec<f64> {
        corners.as_flattened().iter().map(|v| f64::from(*v)).collect()
    };
    near("extent", &numbers(recording.extent()), &numbers(expected.extent))?;
    headings_follow_motion(recording)
}

/// Headings of those who walk differ little from where they walk to, in the middle of all rows.
fn headings_follow_motion(recording: &Recording) -> Result<(), Failed> {
    let mut differences = Vec::new();
    for agent in &recording.agents {
        let track = recording.track(agent);
        let pairs = track.times.windows(2).zip(track.positions.windows(2));
        for ((times, at), heading) in pairs.zip(track.headings.iter().skip(1)) {
            let way = [0, 1].map(|axis| f64::from(at[1][axis] - at[0][axis]));
            if way[0].hypot(way[1]) > 0.5 * (times[1] - times[0]) && heading.is_finite() {
                let difference = f64::from(*heading) - way[1].atan2(way[0]);
                differences.push(difference.sin().atan2(difference.cos()).abs());
            }
        }
    }
    differences.sort_by(f64::total_cmp);
    match differences.get(differences.len() / 2) {
        Some(middle) if *middle > 0.2 => Err(format!("headings are {middle} rad off").into()),
        None if !recording.track(&recording.agents[0]).headings.is_empty() => {
            Err("nobody walks".into())
        }
        _ => Ok(()),
    }
}

fn equal<T: PartialEq + std::fmt::Debug>(what: &str, got: &T, wanted: &T) -> Result<(), Failed> {
    if got == wanted { Ok(()) } else { Err(format!("{what}: {got:?}, not {wanted:?}").into()) }
}

fn near(what: &str, got: &[f64], wanted: &[f64]) -> Result<(), Failed> {
    let is_near = got.iter().zip(wanted).all(|(got, wanted)| (got - wanted).abs() < 1e-4);
    if is_near { Ok(()) } else { Err(format!("{what}: {got:?}, not {wanted:?}").into()) }
}
