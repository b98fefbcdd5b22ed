//! What became of a run that drew: its message, and its document.

use std::path::Path;

use populace::Crowd;
use populace_render::Drawn;
use serde_json::{Value, json};

use crate::frame_loop::FrameTimes;
use crate::frames::Frames;
use crate::report::message;

/// A run whose frames are all written.
pub(crate) struct Outcome<'a> {
    pub(crate) crowd: &'a Crowd,
    /// What the last picture shows.
    pub(crate) drawn: Drawn,
    pub(crate) times: &'a FrameTimes,
    pub(crate) frames: Frames,
    /// Number of frames that existed.
    pub(crate) skipped: usize,
    pub(crate) out: &'a Path,
}

impl Outcome<'_> {
    /// Prints what was drawn, and how long it took.
    pub(crate) fn describe(&self) {
        message!(
            "{} drawn, {}",
            counted(self.drawn.instances, "member"),
            counted(self.drawn.triangles, "triangle")
        );
        let count = self.frames.count();
        let [total, animate, draw] = self.times.medians();
        let median = if count == 1 { "" } else { ", median" };
        let mut text = counted(count as usize, "frame");
        if self.skipped > 0 {
            text += &format!(" ({} existed)", self.skipped);
        }
        if self.frames.shutter.samples > 1 {
            text += &format!(" of {} pictures each", self.frames.shutter.samples);
        }
        message!("{text}{median}: {total:.2} ms, {animate:.2} to animate, {draw:.2} to draw");
    }

    /// Returns the document of `--json`.
    pub(crate) fn as_json(&self) -> Value {
        let (crowd, drawn, times) = (self.crowd, &self.drawn, self.times);
        let [total, animate, draw] = times.medians();
        let view = crowd.view_statistics();
        json!({
            "schema": 1,
            "device": crowd.device_info().devices.to_string(),
            "schedule": crowd.device_info().schedule.name(),
            "members": crowd.member_count(),
            "frames": self.frames.count(),
            "skipped": self.skipped,
            "ms_median": {
                "total": total,
                "animate": animate,
                "draw": draw,
                "shadow": times.pass(|pass| pass.shadow_ms),
                "members": times.pass(|pass| pass.members_ms),
                "surroundings": times.pass(|pass| pass.surroundings_ms),
            },
            "drawn_members": drawn.instances,
            "triangles": drawn.triangles,
            "shadow": {"members": drawn.shadow_instances, "triangles": drawn.shadow_triangles},
            "draw_calls": drawn.draw_calls,
            "levels": view.levels,
            "shadow_only": view.shadow_only,
            "hidden": view.hidden,
            "out": self.out.to_string_lossy(),
        })
    }
}

/// Returns a number of things in words: "1 frame", "2 frames".
pub(crate) fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}
