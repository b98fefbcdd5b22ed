//! Draws scenes: `populace render street.toml`, and the street of `populace demo`.

mod cast;
mod clips;
mod counts;
mod live;
mod past;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use populace::Crowd;
use populace::character::Character;
use populace_film::FrameRate;
use populace_render::{Preset, Scene};
use populace_scene::plan::{CastPlan, PropPlan, ScenePlan};
use populace_scene::{SceneFileError, StreetSettings};
use serde_json::json;

use crate::built_in;
use crate::camera::{Keys, View};
use crate::cli::{FrameRange, MOST_FRAMES, PictureArgs};
use crate::crowd_renderer::{CrowdRenderer, devices_and_shares};
use crate::failure::Failure;
use crate::filming::{Filming, check_hidden};
use crate::frame_loop::Action;
use crate::frames::{Frames, Shutter};
use crate::names::hint;
use crate::report::message;
use crate::roles::{self, LoadedRoles};
use crate::text_file;
use live::{FilmedScene, LiveScene};

/// Clips that a member plays at the same time: three of a gait and two on each layer above.
const SLOTS: usize = 8;
/// How far the plain ground is drawn below that of the scene where props cover it, in metres.
const GROUND_BELOW_M: f32 = 0.4;
/// Height of the sun in degrees below which its light fades, to none at the horizon.
const SUNSET_DEG: f32 = 2.0;

/// A scene, as the command line describes it.
pub(crate) struct SceneSource<'a> {
    pub(crate) plan: ScenePlan,
    /// The scene file; `None` for one made by code.
    pub(crate) file: Option<&'a Path>,
    /// Characters in place of those of the plan, if there are some.
    pub(crate) cast: &'a [PathBuf],
    pub(crate) picture: &'a PictureArgs,
}

/// A job of drawing a scene.
pub(crate) struct SceneJob<'a> {
    pub(crate) source: SceneSource<'a>,
    pub(crate) out: &'a Path,
}

/// Returns the street of `populace demo`.
pub(crate) fn street(members: u32, seed: u64) -> ScenePlan {
    populace_scene::street(StreetSettings { members: members as usize, seed })
}

/// Reads a scene file.
pub(crate) fn read(file: &Path) -> Result<ScenePlan, Failure> {
    let named = |reason: &dyn std::fmt::Display| {
        Failure::Input(anyhow::anyhow!("{}: {reason}", file.display()))
    };
    let text = text_file::read(file).map_err(|error| named(&error))?;
    ScenePlan::parse(&text).map_err(|error| named(&error))
}

/// Returns true for the name of a scene file.
pub(crate) fn is_scene(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Returns the rate of a scene's films: the one that was asked for, or the scene's own.
pub(crate) fn film_rate(plan: &ScenePlan, asked: Option<FrameRate>) -> Result<FrameRate, Failure> {
    Ok(asked.map_or_else(|| FrameRate::nearest(plan.output.fps), Ok)?)
}

/// Returns the height at which the plain ground is drawn, in metres. Roads reach below the ground, and
/// surfaces at its height or below would be hidden by it.
fn plain_ground_m(plan: &ScenePlan) -> f32 {
    let height_m = plan.ground.height_m;
    let covers = |prop: &PropPlan| match prop.kind.as_str() {
        "road" => true,
        "earth" | "lawn" | "meadow" => prop.at[1] <= height_m,
        _ => false,
    };
    if plan.props.iter().any(covers) { height_m - GROUND_BELOW_M } else { height_m }
}

/// Returns the number of frames of a scene's film at a rate, at least 1.
pub(crate) fn frame_count(plan: &ScenePlan, rate: FrameRate) -> u32 {
    let frames = f64::from(plan.output.seconds.clamp(0.0, 1e4)) * rate.per_sec();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let count = frames.round().max(1.0) as u32;
    count.min(MOST_FRAMES)
}

/// Puts the sun of a scene at a height above the horizon and a facing. Its light fades at sunset,
/// and none comes through the ground.
fn place_sun(scene: &mut Scene, height_deg: f32, facing_deg: f32) {
    let (up, level) = height_deg.to_radians().sin_cos();
    let (sin, cos) = facing_deg.to_radians().sin_cos();
    scene.sun.to_sun = [level * sin, up, level * cos];
    let share = (height_deg / SUNSET_DEG).clamp(0.0, 1.0);
    scene.sun.color = scene.sun.color.map(|channel| channel * share);
    scene.sun.casts_shadows &= share > 0.0;
    scene.ambient.glow = scene.ambient.glow.map(|channel| channel * share);
}

impl SceneJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(self) -> Result<(), Failure> {
        let source = &self.source;
        let args = source.picture;
        let frames = self.frames()?;
        let given = source.given();
        let given: Vec<&Path> = given.iter().map(PathBuf::as_path).collect();
        let filming = Filming::new(args, self.out, (frames, self.is_film()), &given)?;
        let sink = filming.sink()?;
        let renderer = filming.renderer();
        let mut scene = filming.scene();
        source.light(&mut scene)?;
        let mut crowd = filming.crowd(&renderer, source.sizes())?;
        let (live, loaded) = source.live(&mut crowd)?;
        filming.check(&loaded.files)?;
        let mut action = FilmedScene::new(live, source.view()?);
        let [width, height] = args.size();
        action.set_aspect(width as f32 / height as f32)?;
        let renderer = renderer.map_err(Failure::from).and_then(|renderer| {
            CrowdRenderer::new(renderer, &mut crowd, &loaded.roles, &args.hide)
        });
        let played = (&mut action as &mut dyn Action, &scene);
        let filmed = filming.shoot(&mut crowd, played, renderer, sink)?;
        let counts = counts::as_json(action.counts());
        let more = json!({"counts": counts, "crowds": counts::crowds(&source.plan)});
        filmed.report((&crowd, &action), args.json, more)
    }

    fn frames(&self) -> Result<Frames, Failure> {
        let film = &self.source.picture.film;
        let plan = &self.source.plan;
        let rate = film_rate(plan, film.fps)?;
        let shutter = Shutter::degrees(film.shutter);
        Ok(match &film.frames {
            Some(FrameRange(range)) => Frames::film(range, rate, shutter),
            None if self.is_film() && film.at.is_none() => {
                Frames::film(&(0..=frame_count(plan, rate) - 1), rate, shutter)
            }
            None => {
                let secs = film.at.unwrap_or(f64::from(plan.output.lead_in_s));
                Frames { shutter, ..Frames::still(secs, rate) }
            }
        })
    }

    fn is_film(&self) -> bool {
        let film = &self.source.picture.film;
        film.frames.is_some() || populace_film::Format::of(self.out).is_some()
    }
}

impl SceneSource<'_> {
    /// Brings the scene into a crowd for a window.
    #[cfg(feature = "viewer")]
    pub(crate) fn stage(
        &self,
        builder: populace::CrowdBuilder,
    ) -> Result<crate::watched::Staged, Failure> {
        let [capacity, slots] = self.sizes();
        let builder = builder.capacity(capacity).slots_per_member(slots);
        let mut crowd = crate::filming::build_crowd(builder)?;
        let (live, loaded) = self.live(&mut crowd)?;
        let mut scene = crate::filming::scene(self.picture);
        self.light(&mut scene)?;
        let action = Box::new(FilmedScene::new(live, self.view()?));
        let rate = film_rate(&self.plan, self.picture.film.fps)?;
        Ok(crate::watched::Staged {
            crowd,
            action,
            roles: loaded.roles,
            scene,
            floor_m: self.plan.ground.height_m,
            rate,
            length_secs: None,
        })
    }

    /// Brings the plan into a crowd. Errors and warnings begin with the scene file's name.
    fn live(&self, crowd: &mut Crowd) -> Result<(LiveScene, LoadedRoles), Failure> {
        self.warn(self.plan.doubts());
        let (live, loaded) = LiveScene::new(crowd, self).map_err(|failure| match failure {
            Failure::Input(reason) | Failure::Usage(reason) if self.cast.is_empty() => {
                self.named(format!("{reason:#}"))
            }
            other => other,
        })?;
        check_hidden(&loaded.roles, &self.picture.hide)?;
        Ok((live, loaded))
    }

    /// Warns of what looks wrong in the plan.
    fn warn(&self, doubts: Vec<String>) {
        for doubt in doubts {
            message!("warning: {}{doubt}", self.prefix());
        }
    }

    /// Returns an error about the scene file, if there is one.
    fn named(&self, reason: String) -> Failure {
        Failure::Input(anyhow::anyhow!("{}{reason}", self.prefix()))
    }

    /// Returns the scene file's name before a message, if there is one.
    fn prefix(&self) -> String {
        self.file.map_or_else(String::new, |file| format!("{}: ", file.display()))
    }

    /// The members that the crowd has room for, and the slots of each.
    fn sizes(&self) -> [usize; 2] {
        let holds = self.plan.casts.iter().map(|cast| cast.holds.len()).max().unwrap_or(0);
        let people = self.plan.member_count();
        // Everybody may carry a parcel or hold a phone, but not both.
        let with_things = people * (2 + holds);
        let driven: usize = self.plan.lanes.iter().map(|lane| lane.vehicles).sum();
        let things = self.plan.props.len() + self.plan.bays.len();
        [with_things + driven + things, SLOTS]
    }

    /// The camera that was asked for: one of the scene by its name, or the scene's first.
    fn view(&self) -> Result<View, Failure> {
        let cameras = &self.plan.cameras;
        let of = |camera| View::Keys(Keys::of_plan(camera));
        match &self.picture.camera {
            View::Crowd => Ok(cameras.first().map_or(View::Crowd, of)),
            View::Named { name } => {
                let camera = cameras.iter().find(|camera| camera.name == *name);
                camera.map(of).ok_or_else(|| {
                    let names = cameras.iter().map(|camera| camera.name.as_str());
                    let hint = hint(name, names);
                    Failure::usage(format!("the scene has no camera \"{name}\"{hint}"))
                })
            }
            view => Ok(view.clone()),
        }
    }

    /// The files that the scene reads, as far as they are known.
    fn given(&self) -> Vec<PathBuf> {
        let casts = self.plan.casts.iter().flat_map(|cast| self.inputs(cast));
        let files = casts.filter(|file| built_in::name_of(file).is_none());
        let clips = self.picture.clips.iter().cloned();
        let props = self.plan.props.iter().filter_map(|prop| prop.file.as_deref());
        let props = props.map(|file| self.path(file));
        files.chain(clips).chain(props).chain(self.file.map(Path::to_owned)).collect()
    }

    /// Loads the props that are files, by their names in the plan, and notes the files that they
    /// refer to. What cannot be read is named with its line.
    fn prop_files(
        &self,
        referenced: &mut Vec<PathBuf>,
    ) -> Result<BTreeMap<String, Character>, Failure> {
        let mut loader = roles::Loader::new(&self.picture.input);
        let mut props = BTreeMap::new();
        for (nth, prop) in self.plan.props.iter().enumerate() {
            let Some(file) = prop.file.as_ref().filter(|file| !props.contains_key(*file)) else {
                continue;
            };
            let character = loader.load(&self.path(file)).and_then(|character| {
                let is_empty = character.parts.is_empty();
                let nothing = || Failure::Input(anyhow::anyhow!("{file} contains no mesh to draw"));
                if is_empty { Err(nothing()) } else { Ok(character) }
            });
            let character = character.map_err(|failure| self.at_prop(nth, failure))?;
            props.insert(file.clone(), character);
        }
        referenced.extend(loader.into_referenced());
        Ok(props)
    }

    /// Names the line of the prop `nth` in an error about its file.
    fn at_prop(&self, nth: usize, failure: Failure) -> Failure {
        let (Failure::Input(reason), Some(file)) = (&failure, self.file) else { return failure };
        let text = text_file::read(file).unwrap_or_default();
        let error = SceneFileError::of_prop_file(&text, nth, &format!("{reason:#}"));
        Failure::Input(anyhow::anyhow!("{}: {error}", file.display()))
    }

    /// The inputs of a cast.
    fn inputs(&self, cast: &CastPlan) -> Vec<PathBuf> {
        if !self.cast.is_empty() {
            return self.cast.to_vec();
        }
        cast.from.iter().map(|from| self.path(from)).collect()
    }

    /// Returns a path of the plan, which is relative to the scene file.
    fn path(&self, from: &str) -> PathBuf {
        let folder = self.file.and_then(Path::parent);
        match folder.filter(|_| !from.starts_with('@')) {
            Some(folder) => folder.join(from),
            None => PathBuf::from(from),
        }
    }

    /// Says who is there, if anybody is.
    fn announce(&self, crowd: &Crowd, people: usize) {
        if people == 0 {
            return;
        }
        message!(
            "{} on {}, {}",
            if people == 1 { "1 person".into() } else { format!("{people} people") },
            devices_and_shares(crowd),
            crowd.device_info().schedule
        );
    }

    /// Sets the light of the plan, unless the command line says otherwise.
    fn light(&self, scene: &mut Scene) -> Result<(), Failure> {
        let light = &self.plan.light;
        if self.picture.sky.is_none() {
            let sky = light.sky.parse::<Preset>();
            let sky = sky.map_err(|e| self.named(format!("`sky` of [light]: {e}")))?;
            *scene = crate::filming::scene_of(self.picture, sky);
        }
        if let Some(height_deg) = light.sun_height_deg {
            place_sun(scene, height_deg, light.sun_facing_deg.unwrap_or(0.0));
        }
        scene.floor_m = self.plan.ground.height_m;
        if !self.plan.ground.shown {
            scene.ground = None;
        } else if let Some(ground) = &mut scene.ground {
            ground.height_m = plain_ground_m(&self.plan);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_fades_at_the_horizon_and_lights_nothing_from_below() {
        let day = Preset::Day.scene();
        let lit = |height_deg| {
            let mut scene = day;
            place_sun(&mut scene, height_deg, 30.0);
            let share = scene.sun.color[0] / day.sun.color[0];
            assert_eq!(scene.ambient.glow, day.ambient.glow.map(|channel| channel * share));
            (share, scene.sun.casts_shadows)
        };
        assert_eq!(lit(60.0), (1.0, true));
        assert_eq!(lit(1.0), (0.5, true));
        assert_eq!([0.0, -1.0, -30.0, -90.0].map(lit), [(0.0, false); 4]);
    }
}
