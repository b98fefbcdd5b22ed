//! `populace plan`

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::built_in;
use crate::cli::{FrameRange, PlanArgs};
use crate::failure::Failure;
use crate::film_length;
use crate::report;
use crate::scene;
use crate::trajectory;

pub(crate) fn run(args: &PlanArgs) -> Result<(), Failure> {
    let chunks = chunks(&frames(args)?, args.chunk);
    if args.json {
        return report::json(&as_json(&chunks));
    }
    let lines = chunks.iter().map(|[first, last]| format!("--frames {first}..{last}\n"));
    report::text(&lines.collect::<String>())
}

/// Returns the frames of the film. Without a trajectory file or a scene nothing says how many
/// there are.
fn frames(args: &PlanArgs) -> Result<FrameRange, Failure> {
    for input in &args.inputs {
        check_exists(input)?;
    }
    if let Some(frames) = &args.frames {
        return Ok(frames.clone());
    }
    if let [input] = args.inputs.as_slice()
        && scene::is_scene(input)
    {
        let plan = scene::read(input)?;
        let rate = scene::film_rate(&plan, args.fps)?;
        return Ok(FrameRange(0..=scene::frame_count(&plan, rate) - 1));
    }
    let is_trajectory = |input: &&PathBuf| trajectory::is_trajectory(input);
    let Some(file) = args.inputs.iter().find(is_trajectory) else {
        return Err(Failure::usage(
            "none of the inputs is a trajectory file or a scene, which would say how long the film \
             is; give the path of one, or say with --frames N how many frames it has",
        ));
    };
    let recording = args.read.load(file)?;
    let rate = film_length::film_rate(args.fps)?;
    Ok(FrameRange(0..=film_length::frame_count(&recording, rate) - 1))
}

fn check_exists(input: &Path) -> Result<(), Failure> {
    if input == Path::new("-") || built_in::name_of(input).is_some() {
        return Ok(());
    }
    let cannot = |e| Failure::Input(anyhow::anyhow!("cannot read {}: {e}", input.display()));
    input.metadata().map(drop).map_err(cannot)
}

/// Returns the first and the last frame of each chunk of `length` frames.
fn chunks(FrameRange(frames): &FrameRange, length: u32) -> Vec<[u32; 2]> {
    let last = *frames.end();
    let end = |first: u32| first.saturating_add(length - 1).min(last);
    frames.clone().step_by(length as usize).map(|first| [first, end(first)]).collect()
}

fn as_json(chunks: &[[u32; 2]]) -> Value {
    let count: u32 = chunks.iter().map(|[first, last]| last - first + 1).sum();
    let chunk = |[first, last]: &[u32; 2]| json!({"first": first, "last": last});
    json!({
        "schema": 1,
        "frame_count": count,
        "chunks": chunks.iter().map(chunk).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_each_frame_once() {
        let of = |frames, length| chunks(&FrameRange(frames), length);
        assert_eq!(of(0..=9, 4), [[0, 3], [4, 7], [8, 9]]);
        assert_eq!(of(5..=5, 50), [[5, 5]]);
        assert_eq!(of(10..=19, 5), [[10, 14], [15, 19]]);
        assert_eq!(of(999_998..=999_999, 1_000_000), [[999_998, 999_999]]);
        assert_eq!(as_json(&of(10..=19, 8))["frame_count"], 10);
    }
}
