//! Real text files in the folder `POPULACE_TEST_DATA` (environment variable).

use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use populace_trajectory::{Fact, Format, ReadSettings, Recording, Unit, Values, load};

const VARIABLE: &str = "POPULACE_TEST_DATA";

/// A file and what it holds.
#[derive(Clone, Copy)]
struct Case {
    file: &'static str,
    format: Format,
    agents: usize,
    rows: usize,
    unit: Fact<Unit>,
    fps: Fact<f64>,
    /// The first and the last time in seconds.
    secs: [f64; 2],
    /// The least and the greatest position in metres.
    extent: [[f32; 2]; 2],
    /// The least and the greatest body height in metres.
    heights: Option<[f32; 2]>,
}

const CASES: [Case; 4] = [
    Case {
        file: "juelich/040_c_56_h-.txt",
        format: Format::PeTrack,
        agents: 75,
        rows: 63_110,
        unit: Fact::of_file(Unit::Metres),
        fps: Fact::of_file(25.0),
        secs: [0.0, 66.24],
        extent: [[-2.6042, -1.8723], [2.2641, 5.98]],
        heights: Some([1.76, 1.76]),
    },
    Case {
        file: "juelich/bi_corr_400_b_03.txt",
        format: Format::PeTrack,
        agents: 480,
        rows: 120_790,
        unit: Fact::of_file(Unit::Centimetres),
        fps: Fact::of_file(25.0),
        secs: [3.76, 133.6],
        extent: [[-5.624_65, -0.084_737_4], [4.545_17, 4.272_22]],
        heights: Some([1.76, 1.76]),
    },
    Case {
        file: "juelich/uo-180-180-120.txt",
        format: Format::PeTrack,
        agents: 170,
        rows: 54_981,
        unit: Fact::assumed(Unit::Centimetres),
        fps: Fact::assumed(16.0),
        secs: [3.75, 85.6875],
        extent: [[-0.498_304, -6.127_83], [2.441_4, 7.979_41]],
        heights: Some([1.505_82, 1.989_6]),
    },
    Case {
        file: "ucy_students03/obsmat.txt",
        format: Format::Obsmat,
        agents: 428,
        rows: 21_846,
        unit: Fact::of_file(Unit::Metres),
        fps: Fact::of_file(25.0),
        secs: [0.04, 215.64],
        extent: [[0.0; 2]; 2],
        heights: None,
    },
];

fn main() {
    let arguments = Arguments::from_args();
    let trials = match std::env::var_os(VARIABLE) {
        Some(root) => trials(&Path::new(&root).join("trajectories")),
        None => vec![
            Trial::test(format!("text data (set {VARIABLE})"), || Ok(())).with_ignored_flag(true),
        ],
    };
    libtest_mimic::run(&arguments, trials).exit();
}

fn trials(root: &Path) -> Vec<Trial> {
    let one = |case: Case| {
        let path = root.join(case.file);
        Trial::test(case.file, move || check(&case, &path))
    };
    let mut trials: Vec<_> = CASES.into_iter().map(one).collect();
    let path = root.join("ucy_students03/obsmat.txt");
    trials.push(Trial::test("groups beside", move || groups(&path)));
    trials.extend(REFUSED.map(|(file, hint)| {
        let path = root.join(file);
        Trial::test(format!("{file} is refused"), move || refused(&path, hint))
    }));
    trials
}

/// Files that are no trajectories in metres, with what the error says.
const REFUSED: [(&str, &str); 2] =
    [("ucy_students03/annotation.vsp", "obsmat.txt"), ("ucy_students03/H.txt", "id,frame,x,y")];

fn check(case: &Case, path: &Path) -> Result<(), Failed> {
    let recording = load(path, &ReadSettings::default())?;
    let source = &recording.source;
    assert_eq!(source.format, case.format);
    assert_eq!((recording.agents.len(), recording.row_count()), (case.agents, case.rows));
    assert_eq!((source.unit, source.fps), (case.unit, case.fps));
    assert_eq!(recording.secs(), case.secs);
    let extent = recording.extent();
    if case.extent != [[0.0; 2]; 2] {
        near(extent, case.extent);
    }
    let heights = recording.agents.iter().filter_map(|agent| agent.height_m);
    let range = heights.fold([f32::MAX, f32::MIN], |[a, b], h| [a.min(h), b.max(h)]);
    let range = Some(range).filter(|[least, most]| least <= most);
    assert_eq!(range.is_some(), case.heights.is_some());
    for (height, expected) in range.iter().flatten().zip(case.heights.iter().flatten()) {
        assert!((height - expected).abs() < 1e-5, "{height} m for {expected} m");
    }
    assert_eq!(recording.warnings, []);
    walking(&recording);
    Ok(())
}

fn near(a: [[f32; 2]; 2], b: [[f32; 2]; 2]) {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} for {b:?}");
}

/// Checks that people walk as people do.
fn walking(recording: &Recording) {
    let mut speeds = Vec::new();
    for agent in &recording.agents {
        let track = recording.track(agent);
        let pairs = track.times.windows(2).zip(track.positions.windows(2));
        speeds.extend(pairs.map(|(times, at)| {
            let length = f64::from((at[1][0] - at[0][0]).hypot(at[1][1] - at[0][1]));
            length / (times[1] - times[0])
        }));
    }
    speeds.sort_by(f64::total_cmp);
    let median = speeds[speeds.len() / 2];
    assert!((0.1..2.0).contains(&median), "people walk at {median} m/s");
}

fn groups(path: &Path) -> Result<(), Failed> {
    let recording = load(path, &ReadSettings::default())?;
    let Some(Values::Words { words, indices }) = recording.column("group").map(|c| &c.values)
    else {
        return Err("no groups".into());
    };
    let of = |id: &str| {
        let agent = recording.agents.iter().find(|agent| agent.id == id);
        let row = agent.map(|agent| recording.rows(agent).start);
        row.and_then(|row| words.get(indices[row] as usize)).map(String::as_str)
    };
    assert_eq!((of("7"), of("8"), of("9"), of("1")), (Some("2"), Some("2"), Some("3"), None));
    assert_eq!(of("14"), of("16"));
    Ok(())
}

fn refused(path: &Path, hint: &str) -> Result<(), Failed> {
    match load(path, &ReadSettings::default()) {
        Ok(recording) => Err(format!("read as {}", recording.source.format).into()),
        Err(error) if error.to_string().contains(hint) => Ok(()),
        Err(error) => Err(error.to_string().into()),
    }
}
