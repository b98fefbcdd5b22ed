//! The clips shared by a crowd.

use std::sync::Arc;

use crate::Clip;

/// Index of a clip in an [`AnimationSet`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClipIndex(pub u32);

/// Clips that all members sample (Lister & Day 2012, section 3.2, fig. 4). They are not bound to a
/// model and can be added at any time, unlike palettes baked in advance (section 2 there).
#[derive(Clone, Debug, Default)]
pub struct AnimationSet {
    clips: Vec<Arc<Clip>>,
}

impl AnimationSet {
    /// Adds a clip and returns its index. A clip that was added before keeps its index.
    ///
    /// # Panics
    ///
    /// If there are more than 2^32 clips.
    pub fn add(&mut self, clip: &Arc<Clip>) -> ClipIndex {
        self.find(clip).unwrap_or_else(|| {
            self.clips.push(Arc::clone(clip));
            index(self.clips.len() - 1)
        })
    }

    /// The index of a clip, if it was added.
    #[must_use]
    pub fn find(&self, clip: &Arc<Clip>) -> Option<ClipIndex> {
        self.clips.iter().position(|c| Arc::ptr_eq(c, clip)).map(index)
    }

    /// The clip with this index.
    #[must_use]
    pub fn get(&self, clip: ClipIndex) -> Option<&Arc<Clip>> {
        self.clips.get(clip.0 as usize)
    }

    /// All clips, in the order in which they were added.
    #[must_use]
    pub fn clips(&self) -> &[Arc<Clip>] {
        &self.clips
    }
}

fn index(position: usize) -> ClipIndex {
    ClipIndex(u32::try_from(position).expect("fewer than 2^32 clips"))
}
