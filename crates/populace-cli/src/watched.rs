//! Actions that can be watched in a window.

use populace::Crowd;
use populace_film::FrameRate;
use populace_render::Scene;

use crate::frame_loop::Action;
use crate::roles::CrowdRole;

/// An action that can be watched in a window.
pub(crate) trait Watched: Action {
    /// Returns to the time before frame 0. The crowd has been brought back to it.
    fn rewind(&mut self);

    /// Returns true if it places its members in each frame.
    fn leads_members(&self) -> bool;

    /// Returns true if it draws over pictures.
    fn has_overlay(&self) -> bool {
        false
    }
}

/// A crowd that is ready to be watched.
pub(crate) struct Staged {
    pub(crate) crowd: Crowd,
    pub(crate) action: Box<dyn Watched>,
    pub(crate) roles: Vec<CrowdRole>,
    pub(crate) scene: Scene,
    /// The height on which people stand, in metres. The ground of the scene may be drawn lower.
    pub(crate) floor_m: f32,
    pub(crate) rate: FrameRate,
    /// `None` if it goes on for ever.
    pub(crate) length_secs: Option<f64>,
}
