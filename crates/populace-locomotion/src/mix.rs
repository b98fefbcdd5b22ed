//! Mixes of clips in one phase, as blend spaces play them.

use std::sync::Arc;

use populace::clip::Clip;

/// A clip of a mix.
#[derive(Clone, Debug)]
pub struct MixedClip {
    /// The clip. One without length is held.
    pub clip: Arc<Clip>,
    /// Its weight, 0 to 1, relative to that of the others.
    pub weight: f32,
    /// Its phase at the start of the shared cycle, in cycles.
    pub offset: f32,
}

impl MixedClip {
    /// Returns a clip with a weight, 0 to 1, that starts with the shared cycle.
    #[must_use]
    pub fn new(clip: &Arc<Clip>, weight: f32) -> Self {
        Self { clip: Arc::clone(clip), weight, offset: 0.0 }
    }

    /// Sets the phase at the start of the shared cycle, in cycles, as
    /// [`BlendSpace::with_offset`](populace::BlendSpace::with_offset) does.
    #[must_use]
    pub fn with_offset(mut self, cycles: f32) -> Self {
        self.offset = cycles;
        self
    }

    /// Returns the time on the clip's own axis at a phase of the shared cycle, 0 to 1.
    pub(crate) fn secs_at(&self, phase: f32) -> f32 {
        let own = phase + self.offset;
        let own = if (0.0..=1.0).contains(&own) { own } else { own - own.floor() };
        self.clip.start_secs() + self.clip.duration_secs() * own
    }
}

/// Returns the length of the shared cycle in seconds: its rate is the weighted mean of those of the
/// clips with a length. `None` if no such clip has a weight.
pub(crate) fn cycle_secs(clips: &[MixedClip]) -> Option<f32> {
    let (mut cycles_per_sec, mut weights) = (0.0, 0.0);
    for mixed in clips.iter().filter(|mixed| mixed.clip.duration_secs() > 0.0) {
        cycles_per_sec += mixed.weight / mixed.clip.duration_secs();
        weights += mixed.weight;
    }
    Some(weights / cycles_per_sec).filter(|secs| secs.is_normal() && *secs > 0.0)
}
