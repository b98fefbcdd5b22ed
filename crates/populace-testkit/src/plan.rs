//! Members under test, planned in plain words.

use populace_clip::TICKS_PER_SEC;
use populace_device::LayerMode;

use crate::oracle::{Timing, Weighting};

/// Ticks of one frame at 60 Hz.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;

/// A playing clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Index into [`Scene::clips`](crate::scenes::Scene::clips).
    pub clip: usize,
    /// When it shows what.
    pub timing: Timing,
    /// How much it weighs.
    pub weighting: Weighting,
    /// Its layer.
    pub layer: u32,
}

impl Play {
    /// A clip that stands at a time, of weight 1, in layer 0.
    #[must_use]
    pub fn held(clip: usize, secs: f32) -> Self {
        Self { clip, timing: Timing::Held { secs }, weighting: Weighting::Constant(1.0), layer: 0 }
    }

    /// With another weight.
    #[must_use]
    pub fn weighing(self, weight: f32) -> Self {
        let weighting = Weighting::Constant(weight);
        Self { weighting, ..self }
    }

    /// On another layer.
    #[must_use]
    pub fn on_layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }
}

/// A clip that was left at once, and still inertializes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertialization {
    /// What was left; it does not play on.
    pub left: Play,
    /// What took its place.
    pub taking: Play,
    /// The clock then.
    pub tick: u64,
    /// In which it inertializes.
    pub ticks: u64,
    /// Its part of what the layer showed.
    pub share: f32,
    /// By how much that changed in a second.
    pub share_per_sec: f32,
}

/// A layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerPlan {
    /// How it meets what lies beneath.
    pub mode: LayerMode,
    /// From 0 to 1.
    pub weight: f32,
    /// A weight per joint, in the order of the source.
    pub mask: Option<Vec<f32>>,
}

impl Default for LayerPlan {
    fn default() -> Self {
        Self { mode: LayerMode::Override, weight: 1.0, mask: None }
    }
}

/// A member.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberPlan {
    /// Index into [`Scene::bodies`](crate::scenes::Scene::bodies).
    pub body: usize,
    /// Its slots, in order.
    pub plays: Vec<Play>,
    /// The slots after those, each in the layer of what was left.
    pub inertialization: Vec<Inertialization>,
    /// Its layers, at least one.
    pub layers: Vec<LayerPlan>,
}

impl MemberPlan {
    /// All of whose clips something shows, and the clock for those whose time stands.
    pub(crate) fn shown(&self, tick: u64) -> impl Iterator<Item = (&Play, u64)> {
        let stand =
            self.inertialization.iter().flat_map(|s| [(&s.left, s.tick), (&s.taking, s.tick)]);
        self.plays.iter().map(move |play| (play, tick)).chain(stand)
    }

    /// A member with one plain layer.
    #[must_use]
    pub fn plain(body: usize, plays: Vec<Play>) -> Self {
        let layers = vec![LayerPlan::default()];
        Self { body, plays, inertialization: Vec::new(), layers }
    }
}
