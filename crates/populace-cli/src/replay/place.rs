//! The place of a recording in the crowd.

use populace::{CharacterId, Crowd, MemberId, Placement};
use populace_scene::{PlaceModel, PlaceSettings};
use populace_trajectory::Recording;

use crate::cli::OverlayArgs;
use crate::failure::Failure;
use crate::report::message;

/// Thickness of the floor in metres. The ground around lies lower by it.
pub(super) const SLAB_M: f32 = 0.15;

/// Returns the height of the floor in metres: the least elevation of an agent. One row between two
/// higher ones is no floor.
pub(super) fn floor_m(recording: &Recording) -> f32 {
    let tracks = recording.agents.iter().map(|agent| recording.track(agent).elevations);
    tracks.filter_map(least).reduce(f32::min).unwrap_or(0.0)
}

/// Returns the least of the greatest of each two neighbouring elevations; none if there are none.
fn least(elevations: &[f32]) -> Option<f32> {
    match elevations {
        [only] => Some(*only),
        _ => elevations.windows(2).map(|pair| pair[0].max(pair[1])).reduce(f32::min),
    }
}

/// The place, which may change.
#[derive(Default)]
pub(super) struct Place {
    /// Height of its floor in metres.
    floor_m: f32,
    /// Times in seconds from which its parts are there.
    parts: Vec<(f64, CharacterId)>,
    /// The part that is there, and its member.
    present: Option<(usize, MemberId)>,
}

impl Place {
    /// Brings the place of a recording to a crowd, with walls of the height that was asked for. The
    /// place is buildable.
    pub(super) fn new(
        crowd: &mut Crowd,
        recording: &Recording,
        overlay: &OverlayArgs,
    ) -> Result<Self, Failure> {
        let settings = PlaceSettings {
            wall_height_m: overlay.walls_m(),
            slab_m: f64::from(SLAB_M),
            ..PlaceSettings::default()
        };
        let model = PlaceModel::of_buildable(recording, &settings);
        for warning in &model.warnings {
            message!("warning: {warning}");
        }
        if model.parts.is_empty() && overlay.walls.is_some() {
            message!("warning: there is no walkable area, so --walls has no effect");
        }
        let mut parts = Vec::new();
        for part in model.parts {
            parts.push((part.from_secs, crowd.add_character(part.character)?));
        }
        Ok(Self { floor_m: floor_m(recording), parts, present: None })
    }

    /// Returns whether there is a floor.
    pub(super) fn is_known(&self) -> bool {
        !self.parts.is_empty()
    }

    /// Forgets the part that is there, whose member is gone.
    #[cfg(feature = "viewer")]
    pub(super) fn forget(&mut self) {
        self.present = None;
    }

    /// Shows the part of a time in seconds.
    pub(super) fn change(&mut self, crowd: &mut Crowd, secs: f64) -> Result<(), Failure> {
        let next = self.parts.partition_point(|(from, _)| *from <= secs);
        let wanted = next.saturating_sub(1);
        let Some((_, character)) = self.parts.get(wanted) else { return Ok(()) };
        if self.present.is_some_and(|(part, _)| part == wanted) {
            return Ok(());
        }
        if let Some((_, member)) = self.present.take() {
            crowd.despawn(member)?;
        }
        let member = crowd.spawn(*character, Placement::at([0.0, self.floor_m, 0.0]))?;
        self.present = Some((wanted, member));
        Ok(())
    }
}
