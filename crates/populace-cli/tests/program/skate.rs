//! Tests of `populace bench --skate`: its document, its table, and refused arguments.

use std::collections::BTreeSet;

use crate::post::Folder;
use crate::{json_of, populace, refused};

/// The columns of the document, besides "character", "clips", "segment" and "planting".
const NUMBERS: [&str; 6] =
    ["mean_m_s", "p95_m_s", "speed_error", "sole_error", "acceleration_ratio", "contact_share"];

#[test]
fn bench_skate_measures_every_part_with_and_without_planting() {
    let d = json_of(&["bench", "--skate", "@child", "--json"]);
    assert_eq!(d["schema"], 1);
    let rows = d["skate"].as_array().expect("rows");
    let of = |planting: bool| {
        let rows = rows.iter().filter(move |row| row["planting"] == planting);
        rows.map(|row| row["segment"].as_str().expect("a name")).collect::<BTreeSet<_>>()
    };
    let (planted, bare) = (of(true), of(false));
    assert!(planted == bare && rows.len() == 2 * planted.len(), "{planted:?} {bare:?}");
    for part in ["start", "straight 0.3", "straight 4", "curve", "stop", "turn", "stairs", "all"] {
        assert!(planted.contains(part), "no {part} in {planted:?}");
    }
    for row in rows {
        assert!(row["character"] == "child" && row["clips"] == "own", "{row}");
        for name in NUMBERS {
            let number = row[name].as_f64();
            assert!(number.is_some_and(|number| number >= 0.0 && number.is_finite()), "{row}");
        }
    }
    let all = |planting: bool| {
        let of_all = |row: &&serde_json::Value| row["segment"] == "all";
        let found = rows.iter().filter(of_all).find(|row| row["planting"] == planting);
        found.expect("a row")["mean_m_s"].as_f64().expect("a number")
    };
    assert!(all(true) < 0.01 && all(false) > 0.05, "{} {}", all(true), all(false));

    let text = String::from_utf8(populace(&["bench", "--skate", "@child"]).stdout).expect("text");
    assert!(text.starts_with("| character | clips | segment | planting | mean, m/s |"), "{text}");
    assert_eq!(text.lines().count(), 2 + rows.len(), "{text}");
    let line = text.lines().find(|line| line.contains("| all | yes |")).expect("a line");
    assert!(line.starts_with("| child | own | all | yes | 0.00"), "{line}");
}

#[test]
fn bench_skate_refuses_what_it_cannot_walk_or_does_not_use() {
    let folder = Folder::new();
    let post = folder.text("post.gltf");
    refused(&["bench", "--skate", &post], 1, &["post.gltf", "no names that are known"]);
    refused(&["bench", "--skate", "@nobody"], 2, &["@nobody", "@child"]);
    refused(&["bench", "--skate", "--members", "5"], 2, &["--members"]);
}
