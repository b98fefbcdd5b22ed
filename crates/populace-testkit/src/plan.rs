//! Descriptions of the members under test.

use populace_clip::TICKS_PER_SEC;
use populace_device::LayerMode;

use crate::oracle::{Timing, Weighting};

/// Ticks per frame at 60 Hz.
pub(crate) const FRAME_TICKS: u64 = TICKS_PER_SEC / 60;

/// A playing clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Play {
    /// Index into [`Scene::clips`](crate::scenes::Scene::clips).
    pub clip: usize,
    /// Clip time by the clock.
    pub timing: Timing,
    /// Weight by the clock.
    pub weighting: Weighting,
    /// Index of the layer.
    pub layer: u32,
}

impl Play {
    /// Holds a clip at a time, with weight 1 in layer 0.
    #[must_use]
    pub fn held(clip: usize, secs: f32) -> Self {
        Self { clip, timing: Timing::Held { secs }, weighting: Weighting::Constant(1.0), layer: 0 }
    }

    /// Replaces the weight.
    #[must_use]
    pub fn with_weight(self, weight: f32) -> Self {
        let weighting = Weighting::Constant(weight);
        Self { weighting, ..self }
    }

    /// Replaces the layer.
    #[must_use]
    pub fn on_layer(self, layer: u32) -> Self {
        Self { layer, ..self }
    }
}

/// A transition by inertialization from one clip to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertialization {
    /// The outgoing clip, held at `tick`.
    pub outgoing: Play,
    /// The incoming clip, held at `tick`.
    pub incoming: Play,
    /// The clock at the start.
    pub tick: u64,
    /// Ticks in which the offset decays.
    pub ticks: u64,
    /// The outgoing clip's share of the layer at the start.
    pub share: f32,
    /// The rate of change of that share.
    pub share_per_sec: f32,
}

/// A layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerPlan {
    /// The combination with the layers below.
    pub mode: LayerMode,
    /// From 0 to 1.
    pub weight: f32,
    /// A weight per joint, in source order.
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
    /// Its slots after `plays`, each in the layer of the outgoing clip.
    pub inertialization: Vec<Inertialization>,
    /// Its layers, at least one.
    pub layers: Vec<LayerPlan>,
}

impl MemberPlan {
    /// Returns all plays that affect the pose, each with the tick at which it is sampled.
    pub(crate) fn shown(&self, tick: u64) -> impl Iterator<Item = (&Play, u64)> {
        let held = self
            .inertialization
            .iter()
            .flat_map(|of| [(&of.outgoing, of.tick), (&of.incoming, of.tick)]);
        self.plays.iter().map(move |play| (play, tick)).chain(held)
    }

    /// Describes a member with one default layer.
    #[must_use]
    pub fn plain(body: usize, plays: Vec<Play>) -> Self {
        let layers = vec![LayerPlan::default()];
        Self { body, plays, inertialization: Vec::new(), layers }
    }
}
