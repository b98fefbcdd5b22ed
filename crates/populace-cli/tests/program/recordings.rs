//! Tests of `populace inspect` and `render` with the real trajectory files in the folder that
//! `POPULACE_TEST_DATA` names.

use std::path::Path;

use serde_json::{Value, json};

use crate::json_of;

/// A file, and what other programs count in it.
struct File {
    path: &'static str,
    format: &'static str,
    agents: u64,
    /// Distinct times, and the most agents at a time.
    frames: [u64; 2],
    fps: f64,
    duration_s: f64,
    unit: &'static str,
    heading: &'static str,
    assumed: &'static [&'static str],
    /// Allowed foot skate: mean and 95th percentile in metres per second.
    skate_m_s: [f64; 2],
    /// Allowed distance from the rows in metres.
    raw_m: f64,
}

/// Files of the same experiments and programs have much in common.
const USUAL: File = File {
    path: "",
    format: "",
    agents: 0,
    frames: [0, 0],
    fps: 25.0,
    duration_s: 0.0,
    unit: "m",
    heading: "motion",
    assumed: &[],
    skate_m_s: [0.02, 0.08],
    raw_m: 0.5,
};

const FILES: [File; 11] = [
    File {
        path: "juelich/040_c_56_h-.txt",
        format: "petrack",
        agents: 75,
        frames: [1657, 75],
        duration_s: 66.24,
        ..USUAL
    },
    File {
        path: "juelich/bi_corr_400_b_03.txt",
        format: "petrack",
        agents: 480,
        frames: [3247, 50],
        duration_s: 129.84,
        unit: "cm",
        ..USUAL
    },
    File {
        path: "juelich/uo-180-180-120.txt",
        format: "petrack",
        agents: 170,
        frames: [1312, 63],
        fps: 16.0,
        duration_s: 81.9375,
        unit: "cm",
        assumed: &["unit", "fps"],
        ..USUAL
    },
    File {
        path: "ucy_students03/obsmat.txt",
        format: "obsmat",
        agents: 428,
        frames: [540, 62],
        duration_s: 215.6,
        ..USUAL
    },
    File {
        path: "jupedsim/jps_plaza_1000.sqlite",
        format: "jupedsim",
        agents: 1000,
        frames: [101, 1000],
        fps: 2.5,
        duration_s: 40.0,
        heading: "data",
        ..USUAL
    },
    File {
        path: "jupedsim/jps14_bottleneck_60.sqlite",
        format: "jupedsim",
        agents: 60,
        frames: [1501, 60],
        duration_s: 60.0,
        heading: "data",
        ..USUAL
    },
    File {
        path: "jupedsim/jps14_bottleneck_60.h5",
        format: "hdf5",
        agents: 60,
        frames: [1501, 60],
        duration_s: 60.0,
        heading: "data",
        ..USUAL
    },
    File {
        path: "jupedsim/pedpy_demo_30.sqlite",
        format: "jupedsim",
        agents: 30,
        frames: [491, 30],
        duration_s: 19.6,
        heading: "data",
        ..USUAL
    },
    File {
        path: "vadere/postvis.traj",
        format: "vadere",
        agents: 20,
        frames: [494, 20],
        fps: 1.7610,
        duration_s: 24.866,
        ..USUAL
    },
    File {
        path: "sumo/sumo_fcd_small.xml",
        format: "sumo",
        agents: 60,
        frames: [60, 60],
        fps: 1.0,
        duration_s: 59.0,
        heading: "data",
        ..USUAL
    },
    File {
        path: "sumo/sumo_fcd_grid.xml.gz",
        format: "sumo",
        agents: 600,
        frames: [300, 505],
        fps: 2.0,
        duration_s: 149.5,
        heading: "data",
        ..USUAL
    },
];

impl File {
    fn full_path(&self) -> String {
        let folder = std::env::var_os("POPULACE_TEST_DATA").expect("ignored without it");
        let path = Path::new(&folder).join("trajectories").join(self.path);
        path.to_string_lossy().into_owned()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[cfg_attr(no_test_data, ignore = "POPULACE_TEST_DATA does not name a folder of test data")]
#[test]
fn inspect_counts_what_is_in_real_files() {
    for file in FILES {
        let d = json_of(&["inspect", &file.full_path(), "--strict", "--json"]);
        let t = &d["trajectory"];
        let path = file.path;
        assert_eq!(t["format"], file.format, "{path}");
        assert_eq!(t["agents"], file.agents, "{path}");
        assert_eq!(t["people"], file.agents, "{path}");
        assert_eq!(t["frames"], file.frames[0], "{path}");
        assert_eq!(t["peak_agents"], file.frames[1], "{path}");
        assert_eq!(t["unit"], file.unit, "{path}");
        assert_eq!(t["heading"], file.heading, "{path}");
        assert_eq!(t["assumed"], json!(file.assumed), "{path}");
        assert!((number(&t["fps"]) - file.fps).abs() < 1e-3, "{path}: {t}");
        assert!((number(&t["duration_s"]) - file.duration_s).abs() < 1e-3, "{path}: {t}");
        let speed = number(&t["median_speed_m_s"]);
        assert!((0.05..2.0).contains(&speed), "{path}: people walk at {speed} m/s");
    }
}

#[cfg_attr(no_test_data, ignore = "POPULACE_TEST_DATA does not name a folder of test data")]
#[test]
fn people_of_real_files_hold_their_feet_and_places() {
    for file in FILES {
        let path = file.full_path();
        let film = ["--no-draw", "--frames", "50", "--fps", "25", "--device", "native"];
        let d = json_of(&[&["render", &path], &film[..]].concat());
        let (skate, error) = (&d["foot_skate"], &d["position_error"]);
        let [mean, p95] = [&skate["mean_m_s"], &skate["p95_m_s"]].map(number);
        let [most, raw] = [&error["max_m"], &error["max_raw_m"]].map(number);
        let path = file.path;
        let [allowed, allowed_p95] = file.skate_m_s;
        assert!(mean <= allowed && p95 <= allowed_p95, "{path}: {skate}");
        assert!(most <= 0.02 && raw <= file.raw_m, "{path}: {error}");
        assert!(raw > 0.0, "{path}: rows are not smoothed");
    }
}
