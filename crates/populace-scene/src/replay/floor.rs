//! The floor on which feet are planted, and how far feet of people at other elevations are.

use populace_trajectory::{Kind, Recording};

/// Elevations within this height in metres are of one floor.
const ONE_FLOOR_M: f32 = 0.04;
/// Distances from the floor in metres up to which feet are planted, and from which on they follow
/// their clips alone.
const PLANTED_M: [f32; 2] = [0.02, 0.1];
/// Steps of the weight of planted feet.
pub(super) const STEPS: u8 = 8;

/// Returns the elevation in metres at which most rows of people are; 0 if there are none.
pub(super) fn floor_m(recording: &Recording) -> f32 {
    let people = recording.agents.iter().filter(|agent| agent.kind == Kind::Person);
    let tracks = people.map(|agent| recording.track(agent).elevations);
    let mut all: Vec<f32> = tracks.flatten().copied().collect();
    all.sort_unstable_by(f32::total_cmp);
    let (mut most, mut low) = (0..0, 0);
    for (high, elevation) in all.iter().enumerate() {
        while elevation - all[low] > ONE_FLOOR_M {
            low += 1;
        }
        if high + 1 - low > most.len() {
            most = low..high + 1;
        }
    }
    // The middle one, so that a few that are off do not move the floor.
    all[most.clone()].get(most.len() / 2).copied().unwrap_or(0.0)
}

/// Returns the weight at which feet are planted that are some metres off the floor, in `STEPS`.
pub(super) fn weight(off_m: f32) -> u8 {
    let [planted, free] = PLANTED_M;
    let part = ((free - off_m.abs()) / (free - planted)).clamp(0.0, 1.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 8")]
    let steps = (part * f32::from(STEPS)).round() as u8;
    steps
}
