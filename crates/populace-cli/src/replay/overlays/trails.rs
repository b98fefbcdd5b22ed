//! Ways behind people.

use populace_overlay::Trail;
use populace_render::Camera;
use populace_scene::{Moment, Motion, Replay};
use populace_trajectory::Recording;

use super::Overlays;

/// Seconds between two points of a trail.
const TRAIL_STEP_SECS: f64 = 0.1;
/// Height of trails above the ground in metres.
const TRAIL_M: f32 = 0.02;

impl Overlays {
    /// Returns the ways that people have come, the nearest person last.
    pub(super) fn trails(
        &self,
        secs: f64,
        camera: &Camera,
        size: [u32; 2],
        recording: &Recording,
        replay: &Replay,
    ) -> Vec<Trail> {
        #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels high")]
        let width_px = f64::from(size[1] as f32) / 240.0;
        let trail = |(agent, now): (usize, Option<f64>)| {
            let motion: &Motion = &replay.motions().agents[agent];
            let (mut points, mut depths_m, mut colors) = (Vec::new(), Vec::new(), Vec::new());
            for (at_secs, moment) in way(motion, [replay.secs() - secs, replay.secs()]) {
                let Some(moment) = moment else {
                    depths_m.push(f64::NAN);
                    points.push([f64::NAN; 2]);
                    colors.extend(colors.last().copied());
                    continue;
                };
                let [x, y] = moment.position;
                let place = [x, moment.elevation_m + TRAIL_M, -y];
                let at = camera.project(place, size);
                depths_m.push(f64::from(camera.depth_m(place)));
                points.push(at.map_or([f64::NAN; 2], |at| at.map(f64::from)));
                colors.extend(self.colours.as_ref().map(|of| {
                    let then = of.value_then(recording, (agent, at_secs), &moment).or(now);
                    of.legend.scale.color(then.unwrap_or(f64::NAN)).srgb()
                }));
            }
            Trail { points, colors, depths_m, opacity: 0.9, width_px }
        };
        let colours = self.colours.as_ref();
        let values = colours.map_or_else(Vec::new, |of| of.values(recording, replay));
        let values = values.into_iter().map(Some).chain(std::iter::repeat(None));
        let present = replay.present().map(|(agent, _)| agent);
        let mut present: Vec<(usize, Option<f64>)> = present.zip(values).collect();
        present.sort_unstable_by_key(|(agent, _)| *agent);
        present.into_iter().map(trail).collect()
    }
}

/// Returns where somebody was in a time, from the first moment on, with the times; `None` where they
/// were not there, and where they jumped.
fn way(
    motion: &Motion,
    [from, until]: [f64; 2],
) -> impl Iterator<Item = (f64, Option<Moment>)> + '_ {
    let times = (0_u32..).map(move |nth| from + f64::from(nth) * TRAIL_STEP_SECS);
    let times = times.take_while(move |at| *at < until).chain([until]);
    let mut last = None;
    let moments = times.flat_map(move |at| {
        let now = motion.unbroken(at);
        let has_jumped = last.replace(now).is_some_and(|last| last != now);
        let gap = has_jumped.then_some((at, None));
        gap.into_iter().chain([(at, motion.at(at))])
    });
    moments.skip_while(|(_, moment)| moment.is_none())
}

#[cfg(test)]
mod tests {
    use populace_scene::Motions;

    use super::super::tests::recording;
    use super::*;

    #[test]
    fn trails_have_gaps_where_somebody_jumped() {
        let rows = "id,t,x/m,y/m\n1,0,0,0\n1,1,1,0\n1,2,40,9\n1,3,41,9\n";
        let motions = Motions::new(&recording(rows));
        let seen: Vec<_> = way(&motions.agents[0], [0.0, 3.0]).map(|(_, moment)| moment).collect();
        let gaps = seen.split(Option::is_none).map(<[_]>::len).collect::<Vec<_>>();
        assert_eq!(gaps, [15, 16]);
    }

    #[test]
    fn trails_have_gaps_where_nobody_was() {
        let mut text = "id,t,x,y\n".to_owned();
        for second in [2, 3, 4, 8, 9, 10] {
            text += &format!("1,{second},{second},0\n");
        }
        let motions = Motions::new(&recording(&text));
        let seen: Vec<_> = way(&motions.agents[0], [0.0, 10.0]).map(|(_, moment)| moment).collect();
        assert!(seen.first().is_some_and(Option::is_some), "nothing before the first moment");
        let changes = seen.windows(2).filter(|pair| pair[0].is_some() != pair[1].is_some());
        assert_eq!(changes.count(), 2, "one gap");
    }
}
