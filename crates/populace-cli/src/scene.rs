//! Draws scenes: `populace render street.toml`, and the street of `populace demo`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use populace::character::Character;
use populace::{Crowd, MemberId};
use populace_film::FrameRate;
use populace_locomotion::GaitSpace;
use populace_render::{Camera, Preset, Scene};
use populace_scene::plan::{CastPlan, ScenePlan};
use populace_scene::{Behaviours, Person, Stage};
use populace_variety::{Appearance, Variety};
use serde_json::json;

use crate::camera::{Cameras, Keys, Pose, Subject, View};
use crate::cli::{FrameRange, PictureArgs};
use crate::crowd_renderer::{CrowdRenderer, devices_and_shares};
use crate::failure::Failure;
use crate::filming::Filming;
use crate::frame_loop::Action;
use crate::frames::{Frames, Shutter};
use crate::people::gaits;
use crate::report::message;
use crate::roles::{self, ClipChoice, CrowdRole};

/// Members besides people: props, and vehicles.
const BESIDES: usize = 4096;
/// Clips that a member plays at the same time: three of a gait and two on each layer above.
const SLOTS: usize = 8;
/// Longest step in seconds. Feet need several steps in each contact, at any frame rate.
const STEP_SECS: f32 = 0.041;
/// Height of a person's eyes as a share of its own (Pheasant, "Bodyspace", 1996).
const EYES: f32 = 0.935;

/// A job of drawing a scene.
pub(crate) struct SceneJob<'a> {
    pub(crate) plan: ScenePlan,
    /// The scene file; `None` for one made by code.
    pub(crate) file: Option<&'a Path>,
    /// Characters in place of those of the plan, if there are some.
    pub(crate) cast: &'a [PathBuf],
    pub(crate) out: &'a Path,
    pub(crate) picture: &'a PictureArgs,
}

/// Reads a scene file.
pub(crate) fn read(file: &Path) -> Result<ScenePlan, Failure> {
    let named = |reason: &dyn std::fmt::Display| {
        Failure::Input(anyhow::anyhow!("{}: {reason}", file.display()))
    };
    let text = std::fs::read_to_string(file).map_err(|error| named(&error))?;
    ScenePlan::parse(&text).map_err(|error| named(&error))
}

/// Returns true for the name of a scene file.
pub(crate) fn is_scene(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

impl SceneJob<'_> {
    /// Runs the job. Checks all arguments and inputs before it evaluates and draws.
    pub(crate) fn run(self) -> Result<(), Failure> {
        let args = self.picture;
        let frames = self.frames()?;
        let given = self.given();
        let given: Vec<&Path> = given.iter().map(PathBuf::as_path).collect();
        let filming = Filming::new(args, self.out, (frames, self.is_film()), &given)?;
        let sink = filming.sink()?;
        let renderer = filming.renderer();
        let capacity = self.plan.member_count() + self.plan.props.len() + BESIDES;
        let mut crowd = filming.crowd(&renderer, [capacity, SLOTS])?;
        let (live, roles) = LiveScene::new(&mut crowd, &self, &filming)?;
        message!(
            "{} people on {}, {}",
            live.people.len(),
            devices_and_shares(&crowd),
            crowd.device_info().schedule
        );
        let mut scene = filming.scene();
        self.light(&mut scene)?;
        let [width, height] = args.size.0;
        let view = match (&args.camera, self.plan.cameras.first()) {
            (View::Crowd, Some(camera)) => View::Keys(Keys::of_plan(camera)),
            (view, _) => view.clone(),
        };
        let cameras = Cameras::new(&view, &live, width as f32 / height as f32)?;
        let mut action = FilmedScene { live, cameras };
        let renderer = renderer
            .map_err(Failure::from)
            .and_then(|renderer| CrowdRenderer::new(renderer, &mut crowd, &roles, &args.hide));
        let played = (&mut action as &mut dyn Action, &scene, 0);
        let filmed = filming.shoot(&mut crowd, played, renderer, sink)?;
        let counts = action.live.behaviours.counts();
        filmed.report(&crowd, args.json, json!({"happened": format!("{counts:?}")}))
    }

    /// The files that the job reads, as far as they are known.
    fn given(&self) -> Vec<PathBuf> {
        let casts = self.plan.casts.iter().flat_map(|cast| self.inputs(cast));
        let files = casts.filter(|file| roles::built_in_name(file).is_none());
        files.chain(self.file.map(Path::to_owned)).collect()
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

    fn frames(&self) -> Result<Frames, Failure> {
        let film = &self.picture.film;
        let output = &self.plan.output;
        let rate = match film.fps {
            Some(rate) => rate,
            None => FrameRate::new(output.fps, 1)?,
        };
        let shutter = Shutter::degrees(film.shutter);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
        let count = (output.seconds.clamp(0.0, 1e4) * output.fps as f32).round().max(1.0) as u32;
        Ok(match &film.frames {
            Some(FrameRange(range)) => Frames::film(range, rate, shutter),
            None if self.is_film() && film.at.is_none() => {
                Frames::film(&(0..=count - 1), rate, shutter)
            }
            None => {
                let secs = film.at.unwrap_or(f64::from(output.lead_in_s));
                Frames { shutter, ..Frames::still(secs, rate) }
            }
        })
    }

    fn is_film(&self) -> bool {
        let film = &self.picture.film;
        film.frames.is_some() || film.at.is_some() || populace_film::Format::of(self.out).is_some()
    }

    /// Sets the light of the plan, unless the command line says otherwise.
    fn light(&self, scene: &mut Scene) -> Result<(), Failure> {
        let light = &self.plan.light;
        if self.picture.sky == Preset::default() {
            let preset: Preset = light
                .sky
                .parse()
                .map_err(|reason| Failure::Input(anyhow::anyhow!("`sky` of [light]: {reason}")))?;
            *scene = Scene { sun: scene.sun, ..preset.scene() };
            scene.sun = preset.scene().sun;
        }
        if let Some(height_deg) = light.sun_height_deg {
            let (up, level) = height_deg.to_radians().sin_cos();
            let facing = light.sun_facing_deg.unwrap_or(0.0).to_radians();
            scene.sun.to_sun = [level * facing.sin(), up, level * facing.cos()];
        }
        if !self.plan.ground.shown {
            scene.ground = None;
        } else if let Some(ground) = &mut scene.ground {
            ground.height_m = self.plan.ground.height_m - GROUND_BELOW_M;
        }
        Ok(())
    }
}

/// How far the plain ground is drawn below that of the scene, in metres: roads cover it.
const GROUND_BELOW_M: f32 = 0.4;

/// A scene in a crowd.
struct LiveScene {
    behaviours: Behaviours,
    stage: Stage,
    people: Vec<MemberId>,
    /// Positions, headings and heights of the eyes of people.
    poses: Vec<Pose>,
    eyes_m: Vec<f32>,
}

impl LiveScene {
    fn new(
        crowd: &mut Crowd,
        job: &SceneJob<'_>,
        filming: &Filming<'_>,
    ) -> Result<(Self, Vec<CrowdRole>), Failure> {
        let (plan, args) = (&job.plan, job.picture);
        let casts = job.casts(crowd, filming)?;
        let mut prepare = |character: Character| {
            let wanted = !args.full_detail && character.levels().is_empty();
            let character = if wanted { populace_lod::with_levels(character)? } else { character };
            Ok(Arc::new(character))
        };
        let stage = Stage::new(crowd, plan, &BTreeMap::new(), &mut prepare)?;
        let mut all_gaits: Vec<GaitSpace> = Vec::new();
        for roles in casts.values() {
            all_gaits.extend(gaits(crowd, roles)?);
        }
        let mut people = Vec::new();
        let mut looks = Vec::new();
        for (nth, of) in plan.crowds.iter().enumerate() {
            let roles = &casts[&of.cast];
            let seed = plan.seed.wrapping_add(args.seed).wrapping_add(nth as u64);
            let chosen: Vec<usize> = (0..of.count).map(|member| member % roles.len()).collect();
            let varied = plan.casts.iter().any(|cast| cast.name == of.cast && cast.varied);
            let apart = |nth: usize| [0.0, 0.0, nth as f32];
            let places = (0..of.count).map(apart).collect::<Vec<_>>();
            let varied = varied && !args.plain;
            let appearances = appearances(roles, &chosen, &places, varied.then_some(seed));
            let person = |(member, role): (usize, &usize)| Person {
                character: roles[*role].id,
                scale: roles[*role].scale * appearances.get(member).map_or(1.0, |of| of.height),
                look: None,
            };
            people.push(chosen.iter().enumerate().map(person).collect::<Vec<_>>());
            looks.push((of.cast.clone(), chosen, varied.then_some(seed)));
        }
        let behaviours = Behaviours::new(crowd, plan, &stage, &people, all_gaits)?;
        let people: Vec<MemberId> = behaviours.people().collect();
        let mut from = 0;
        for (cast, chosen, seed) in looks {
            let members = &people[from..from + chosen.len()];
            from += chosen.len();
            let places = members
                .iter()
                .map(|member| Ok(crowd.member(*member)?.placement().position()))
                .collect::<Result<Vec<_>, populace::Error>>()?;
            let appearances = appearances(&casts[&cast], &chosen, &places, seed);
            for (member, appearance) in members.iter().zip(appearances) {
                crowd.member_mut(*member)?.set_look(appearance.look);
            }
        }
        let mut eyes_m = Vec::new();
        for member in &people {
            let view = crowd.member(*member)?;
            let height = crowd.character(view.character())?.asset().height_m();
            eyes_m.push(EYES * height * view.placement().scale());
        }
        let roles = casts.into_values().flatten().collect();
        let mut scene = Self { behaviours, stage, people, poses: Vec::new(), eyes_m };
        scene.note_poses(crowd)?;
        Ok((scene, roles))
    }

    /// Notes where people are.
    fn note_poses(&mut self, crowd: &Crowd) -> Result<(), Failure> {
        self.poses.clear();
        for (member, eye_m) in self.people.iter().zip(&self.eyes_m) {
            let placement = crowd.member(*member)?.placement();
            let (position, heading_rad) = (placement.position(), placement.yaw_rad());
            self.poses.push(Pose { position, heading_rad, eye_m: *eye_m });
        }
        Ok(())
    }
}

impl SceneJob<'_> {
    /// Loads the characters of all casts.
    fn casts(
        &self,
        crowd: &mut Crowd,
        filming: &Filming<'_>,
    ) -> Result<BTreeMap<String, Vec<CrowdRole>>, Failure> {
        let args = self.picture;
        let mut casts = BTreeMap::new();
        for cast in &self.plan.casts {
            let clips: Vec<_> = cast.clips_from.iter().map(|file| self.path(file)).collect();
            let clips: Vec<_> = clips.into_iter().chain(args.clips.iter().cloned()).collect();
            let loaded = roles::load(
                crowd,
                &args.input,
                &self.inputs(cast),
                &clips,
                ClipChoice::default(),
                args.height,
                !args.full_detail,
                cast.varied && !args.plain,
            )?;
            filming.check(&loaded.roles, &loaded.files)?;
            casts.insert(cast.name.clone(), loaded.roles);
        }
        Ok(casts)
    }
}

/// Returns how members look, by their roles and places; nothing without a seed.
fn appearances(
    roles: &[CrowdRole],
    chosen: &[usize],
    places: &[[f32; 3]],
    seed: Option<u64>,
) -> Vec<Appearance> {
    let Some(seed) = seed else { return Vec::new() };
    let characters: Vec<&Character> = roles.iter().map(|role| &*role.character).collect();
    let members: Vec<_> = chosen.iter().copied().zip(places.iter().copied()).collect();
    Variety { seed, ..Variety::default() }.appearances(&characters, &members)
}

impl Subject for LiveScene {
    fn bounds(&self) -> Vec<[f32; 3]> {
        let around = |pose: &Pose| {
            let [x, y, z] = pose.position;
            [[x, y, z], [x, y + pose.eye_m, z]]
        };
        self.poses.iter().flat_map(around).collect()
    }

    fn elevation_rad(&self) -> Option<f32> {
        Some(0.5)
    }

    fn figure_m(&self) -> [f32; 2] {
        [self.eyes_m.iter().copied().fold(0.0, f32::max) / EYES, 0.4]
    }

    fn closest(&self) -> Option<u64> {
        (!self.poses.is_empty()).then_some(0)
    }

    /// The pose of the last step, whatever the time: nobody knows where people will walk.
    fn pose(&self, id: u64, _secs: f64) -> Option<Pose> {
        self.poses.get(usize::try_from(id).ok()?).copied()
    }

    fn describe_ids(&self) -> String {
        format!("people have the numbers from 0 to {}", self.poses.len().saturating_sub(1))
    }
}

/// A scene and the cameras that film it.
struct FilmedScene {
    live: LiveScene,
    cameras: Cameras,
}

impl Action for FilmedScene {
    fn advance(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let steps = (secs / STEP_SECS).ceil().max(1.0);
        let mut done = 0.0;
        while done < steps {
            let secs = secs / steps;
            self.live.behaviours.advance(crowd, secs)?;
            self.live.stage.light(crowd, self.live.behaviours.lights())?;
            crowd.update(secs)?;
            done += 1.0;
        }
        self.live.note_poses(crowd)
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        Ok(self.cameras.at(&self.live, secs))
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        let at = self.live.people.iter().position(|other| *other == member);
        at.map(|at| at as u64)
    }
}
