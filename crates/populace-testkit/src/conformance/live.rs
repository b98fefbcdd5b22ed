//! Checks of live clips.
//!
//! What streams in is a clip of the scene, so a member that shows the stream with a delay looks as if
//! it held that clip at the time of the stream that it sees.

use populace_clip::{Clip, LiveRing, LiveSettings, Streamed, TICKS_PER_SEC, ticks_from_secs};
use populace_device::layout::Slot;
use populace_device::{Backend, Frame, LiveNewest};
use populace_model::convert::single;
use populace_model::{JointIndex, Trs};
use populace_retarget::Binding;

use super::plans;
use crate::compare::Judge;
use crate::oracle::{OracleSlot, evaluate};
use crate::scenes::{Scene, clip};
use crate::{LayerPlan, MemberPlan, Play, Rng, TestCrowd};

/// Clips whose keys are evenly spaced from 0 s.
const STREAMED: [usize; 2] = [clip::EVEN, clip::LARGE];
const ROWS_PER_SEC: f32 = 30.0;
/// Time for which rows are kept.
const KEPT_SECS: f32 = 0.5;
/// The clock at the first pose.
const START_SECS: f64 = 6.0;
const FRAMES: u64 = 30;
/// Frames after which no pose arrives.
const LAST_POSE: u64 = 24;

/// A clip that streams in.
struct Stream {
    clip: usize,
    /// Indices of the clip and of the bound clip in the tables.
    index: u32,
    bound: u32,
    ring: LiveRing,
    /// Ticks from the first pose to the newest.
    newest: u64,
    /// The multiple of the rows' spacing at or after the newest pose.
    row: u64,
}

/// A member that shows a stream.
struct Watcher {
    member: usize,
    stream: usize,
    delay: u64,
    /// What it plays besides, after the stream.
    beside: Vec<Play>,
    weight: f32,
    layer: u32,
}

impl Stream {
    fn new(crowd: &mut TestCrowd<'_>, clip: usize) -> Self {
        let body = crowd.scene.clips[clip].body;
        let skeleton = &crowd.scene.bodies[body].skeleton;
        let settings = LiveSettings {
            rows_per_sec: ROWS_PER_SEC,
            secs: KEPT_SECS,
            translations: Streamed::All,
            scales: Streamed::All,
        };
        let live = Clip::live("stream", skeleton, &settings).expect("the settings are valid");
        let index = crowd.tables.add_clip(&live).expect("the clip fits in the tables");
        let binding = Binding::new(&live, skeleton);
        let of_body = crowd.body_index(body);
        let bound = crowd.tables.add_bound_clip(index, of_body, &binding);
        let ring = live.ring().expect("the clip is live");
        let bound = bound.expect("the clip fits in the tables");
        Self { clip, index, bound, ring, newest: 0, row: 0 }
    }

    /// Returns the clip's pose at a time of the stream, in level order.
    fn pose(&self, scene: &Scene, ticks: u64) -> Vec<Trs> {
        let made = &scene.clips[self.clip];
        let body = &scene.bodies[made.body];
        let time_secs = ticks as f64 / TICKS_PER_SEC as f64;
        let clip = made.clip.source();
        let slot = OracleSlot { clip, time_secs, weight: 1.0, layer: 0, retarget: None };
        let locals = evaluate(&body.oracle, &[slot], &[]).locals;
        let transform = |joint: JointIndex| {
            let local = &locals[body.skeleton.source_from_joint(joint)];
            Trs {
                translation: local.translation.to_array().map(single),
                rotation: local.rotation.to_array().map(single),
                scale: local.scale.to_array().map(single),
            }
        };
        body.skeleton.joints().map(transform).collect()
    }

    fn write(&self, crowd: &mut TestCrowd<'_>, nth: Option<u64>, ticks: u64) {
        let row = nth.map(|nth| u32::try_from(nth % u64::from(self.ring.rows)).expect("a row"));
        let pose = self.pose(crowd.scene, ticks);
        let set = crowd.tables.set_live_row(self.index, row, &pose);
        set.expect("the row exists");
    }

    /// Streams up to a time: rows at multiples of their spacing, and the newest pose.
    fn arrive(&mut self, crowd: &mut TestCrowd<'_>, until: u64) {
        let spacing = u64::from(self.ring.row_ticks);
        while self.row * spacing < until {
            self.write(crowd, Some(self.row), self.row * spacing);
            self.row += 1;
        }
        self.write(crowd, Some(self.row), until);
        self.newest = until;
        let rows = u64::from(self.ring.rows);
        let newest = LiveNewest {
            tick: ticks_from_secs(START_SECS) + until,
            row: u32::try_from(self.row % rows).expect("a row"),
            row_count: u32::try_from((self.row + 1).min(rows)).expect("few rows"),
            ticks: u32::try_from(until + spacing - self.row * spacing).expect("a short time"),
        };
        crowd.tables.set_live_newest(self.index, newest).expect("the row exists");
    }

    /// Returns the time of the stream that is seen with a delay, in seconds.
    fn seen_secs(&self, since_first: u64, delay: u64) -> f32 {
        let spacing = u64::from(self.ring.row_ticks);
        let oldest = (self.row + 1).saturating_sub(u64::from(self.ring.rows)) * spacing;
        let seen = since_first.saturating_sub(delay).clamp(oldest, self.newest);
        single(seen as f64 / TICKS_PER_SEC as f64)
    }
}

impl Watcher {
    fn new(rng: &mut Rng, crowd: &mut TestCrowd<'_>, streams: &[Stream], nth: usize) -> Self {
        let (stream, scene) = (nth % streams.len(), crowd.scene);
        let body = scene.clips[streams[stream].clip].body;
        let mut layers = vec![LayerPlan::default()];
        layers.extend((0..nth % 3).map(|_| plans::layer(rng, scene.bodies[body].joints.len())));
        let layer = u32::try_from(layers.len() - 1).expect("few layers");
        let beside: Vec<Play> = (0..nth / 2 % 3)
            .map(|_| plans::play(rng, &scene.tight_clips()).on_layer(layer))
            .collect();
        let plan = MemberPlan { body, plays: Vec::new(), inertialization: Vec::new(), layers };
        let member = crowd.add(plan);
        let delay = ticks_from_secs([0.0, 0.06, 0.21, 0.9][nth % 4]);
        let weight = single(rng.between(0.3, 1.0));
        let index = crowd.index(member);
        let live = Slot::live(streams[stream].bound, 0, delay).with_weight(weight).on_layer(layer);
        crowd.tables.set_slot(index, 0, &live).expect("the slot is valid");
        for (nth, play) in beside.iter().enumerate() {
            let slot = crowd.slot(play, body);
            crowd.tables.set_slot(index, 1 + nth, &slot).expect("the slot is valid");
        }
        Self { member, stream, delay, beside, weight, layer }
    }
}

/// Checks streams that arrive unevenly while members show them with delays: none, within the rows
/// that are kept and longer, and after the last pose; alone, beside other clips and in layers.
///
/// # Panics
///
/// If the backend is wrong.
pub fn check_live_clips(backend: &mut dyn Backend) {
    let (scene, mut rng) = (Scene::new(), Rng::new(80));
    let mut judge = Judge::new("live clips");
    let mut crowd = plans::crowd(&scene, 3, None);
    let mut streams = STREAMED.map(|clip| Stream::new(&mut crowd, clip));
    for stream in &streams {
        // Additive layers measure from the first pose.
        stream.write(&mut crowd, None, 0);
    }
    let watchers: Vec<Watcher> =
        (0..12).map(|nth| Watcher::new(&mut rng, &mut crowd, &streams, nth)).collect();
    let mut since_first = 0;
    for frame in 0..FRAMES {
        since_first += ticks_from_secs(rng.between(0.01, 0.07));
        for stream in &mut streams {
            let late = ticks_from_secs(rng.between(0.0, 0.03)).min(since_first);
            let arrives = (since_first - late).max(stream.newest);
            if frame < LAST_POSE && (frame == 0 || rng.chance(0.8)) {
                stream.arrive(&mut crowd, arrives);
            }
        }
        for watcher in &watchers {
            let stream = &streams[watcher.stream];
            let secs = stream.seen_secs(since_first, watcher.delay);
            let seen = Play::held(stream.clip, secs).with_weight(watcher.weight);
            let mut plays = vec![seen.on_layer(watcher.layer)];
            plays.extend(&watcher.beside);
            crowd.show(watcher.member, plays);
        }
        let tick = ticks_from_secs(START_SECS) + since_first;
        crowd.update(backend);
        backend.run(&crowd.tables, Frame::of_all(tick)).expect("the backend runs a frame");
        judge.members(backend, &crowd, tick);
    }
    judge.done();
}
