//! A legend, trails, ids and a clock over pictures of trajectories, and people in the legend's colours.

mod colours;
mod corner;
mod density;
mod trails;

use populace::character::Image;
use populace::{CharacterId, Crowd, MemberLook};
use populace_overlay::{Canvas, Corner, Label, TextStyle};
use populace_render::Camera;
use populace_scene::{Moment, Motions, Person, Replay};
use populace_trajectory::Recording;
use populace_variety::Dye;

use crate::cli::OverlayArgs;
use crate::failure::Failure;
use crate::roles::CrowdRole;
use colours::Colours;

/// Height of labels above heads, in metres.
const LABEL_M: f32 = 0.12;

/// Drawings over pictures, and the colours of people.
pub(super) struct Overlays {
    colours: Option<Colours>,
    /// The clothes of each character, and each agent's character and look.
    dyes: Vec<(CharacterId, Dye)>,
    people: Vec<Person>,
    /// Heights of bodies in metres.
    heights: Vec<f32>,
    trail_secs: Option<f64>,
    ids: bool,
    /// The time in seconds that the clock counts from, if it is shown.
    clock_from_secs: Option<f64>,
}

impl Overlays {
    /// Prepares what was asked for. Refuses a column that the file does not have.
    pub(super) fn new(
        args: &OverlayArgs,
        recording: &Recording,
        motions: &Motions,
        roles: &[CrowdRole],
        (people, heights): (Vec<Person>, Vec<f32>),
    ) -> Result<Self, Failure> {
        let colours = args.colour_by.as_deref().map(|name| Colours::new(name, recording, motions));
        let colours = colours.transpose()?;
        let dye = |role: &CrowdRole| (role.id, Dye::of(&role.character));
        let dyes = if colours.is_some() { roles.iter().map(dye).collect() } else { Vec::new() };
        let OverlayArgs { trails: trail_secs, ids, clock, .. } = *args;
        let clock_from_secs = clock.then(|| recording.secs()[0]);
        Ok(Self { colours, dyes, people, heights, trail_secs, ids, clock_from_secs })
    }

    /// Returns true if something is drawn over pictures.
    #[cfg(feature = "viewer")]
    pub(super) fn draw_something(&self) -> bool {
        self.colours.is_some()
            || self.trail_secs.is_some()
            || self.ids
            || self.clock_from_secs.is_some()
    }

    /// Dresses the people who are there.
    pub(super) fn dress(
        &self,
        crowd: &mut Crowd,
        recording: &Recording,
        replay: &Replay,
    ) -> Result<(), Failure> {
        let Some(colours) = &self.colours else { return Ok(()) };
        let values = colours.values(recording, replay);
        for ((agent, member), value) in replay.present().zip(values) {
            let person = &self.people[agent];
            let dye = self.dyes.iter().find(|(character, _)| *character == person.character);
            let Some((_, dye)) = dye else { continue };
            let look = person.look.unwrap_or(MemberLook::PLAIN);
            let color = colours.legend.scale.color(value).linear();
            let look = dye.dyed(look, color).with_opacity(replay.opacity(agent));
            crowd.member_mut(member)?.set_look(look);
        }
        Ok(())
    }

    /// Puts the legend to the corner in which it covers the fewest people of some pictures of a
    /// size, at times in seconds of the recording with a camera each.
    pub(super) fn place_legend(
        &mut self,
        size: [u32; 2],
        views: Vec<(f64, Camera)>,
        motions: &Motions,
    ) {
        let Some(colours) = &mut self.colours else { return };
        let seen = |(secs, camera): (f64, Camera)| {
            let all = motions.agents.iter().zip(&self.heights);
            let people = all.filter_map(|(motion, height_m)| {
                let Moment { position: [x, y], elevation_m, .. } = motion.at(secs)?;
                Some(([x, elevation_m, -y], *height_m))
            });
            (camera, people.collect())
        };
        let pictures: Vec<_> = views.into_iter().map(seen).collect();
        let has_clock = self.clock_from_secs.is_some();
        colours.corner = corner::free(&colours.legend, size, &pictures, has_clock);
    }

    /// Returns true if drawings need the depths of pixels.
    pub(super) fn needs_depths(&self) -> bool {
        self.trail_secs.is_some()
    }

    /// Draws over a picture of the replay's present time, which was taken by a camera and whose
    /// pixels have depths in metres.
    pub(super) fn draw(
        &self,
        picture: &mut Image,
        (camera, depths_m): (&Camera, &[f32]),
        recording: &Recording,
        replay: &Replay,
    ) -> Result<(), Failure> {
        let size = [picture.width, picture.height];
        let failed = |error: populace_overlay::Error| Failure::Run(error.into());
        let mut canvas = Canvas::new(&mut picture.rgba, size).map_err(failed)?;
        if let Some(secs) = self.trail_secs {
            canvas.trails(&self.trails(secs, camera, size, recording, replay), depths_m);
        }
        if self.ids {
            let style = TextStyle::new(0.8 * canvas.text_size());
            canvas.labels(&self.labels(camera, size, recording, replay), &style);
        }
        if let Some(colours) = &self.colours {
            canvas.legend(&colours.legend, colours.corner);
        }
        if let Some(from_secs) = self.clock_from_secs {
            canvas.clock(replay.secs() - from_secs, Corner::TopLeft);
        }
        Ok(())
    }

    /// Returns the ids of people above their heads.
    fn labels(
        &self,
        camera: &Camera,
        size: [u32; 2],
        recording: &Recording,
        replay: &Replay,
    ) -> Vec<Label> {
        let mut present: Vec<_> = replay.present().map(|(agent, _)| agent).collect();
        present.sort_unstable();
        let label = |agent: usize| {
            let moment = replay.motions().agents[agent].at(replay.secs())?;
            let [x, y] = moment.position;
            let top = moment.elevation_m + self.heights[agent] + LABEL_M;
            let at = camera.project([x, top, -y], size)?.map(f64::from);
            Some(Label { text: recording.agents[agent].id.clone(), at })
        };
        present.into_iter().filter_map(label).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn recording(text: &str) -> Recording {
        let settings = populace_trajectory::ReadSettings::default();
        let parsed = populace_trajectory::parse("rows.csv".as_ref(), text.into(), &settings);
        parsed.expect("a recording")
    }
}
