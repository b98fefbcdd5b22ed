//! A scene in a crowd, and the cameras that film it.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Instant;

use glam::{Quat, Vec3};
use populace::character::{Character, Region};
use populace::{Crowd, MemberId};
use populace_locomotion::GaitSpace;
use populace_render::Camera;
use populace_scene::plan::{BehaviourPlan, CastPlan, ScenePlan};
use populace_scene::{Behaviours, Counts, EYES, Person, Stage};

use super::past::Past;
use super::{SceneSource, clips};
use crate::built_in::Clothes;
use crate::camera::{Cameras, Pose, Subject, View, figure};
use crate::failure::Failure;
use crate::frame_loop::{Action, in_foot_steps};
use crate::levels::Levels;
use crate::people::{appearances, eyes, gaits};
use crate::roles::{self, ClipChoice, CrowdRole, LoadedRoles};

/// Half the width of a person in metres, for framing.
const HALF_M: f32 = 0.4;
/// Number of characters that an error names, at most.
const NAMED: usize = 3;

/// A scene in a crowd.
pub(super) struct LiveScene {
    behaviours: Behaviours,
    stage: Stage,
    people: Vec<MemberId>,
    numbers: HashMap<MemberId, u64>,
    /// Positions, headings and heights of the eyes of people.
    poses: Past,
    eyes_m: Vec<f32>,
    /// The person that the camera goes with.
    filmed: Option<usize>,
    /// Its eyes; `None` before they were evaluated.
    eyes: Option<Eyes>,
    /// Corners of the boxes around things.
    things: Vec<[f32; 3]>,
}

/// The eyes of a person after an evaluation.
#[derive(Clone, Copy)]
struct Eyes {
    /// The person, or the vehicle that carries it.
    on: MemberId,
    /// Where they are from there, in metres along its axes.
    from_there_m: Vec3,
}

/// The roles of each cast, by its name.
type Casts = BTreeMap<String, Vec<CrowdRole>>;

/// The characters of the members of a crowd of the plan.
struct Players<'a> {
    cast: &'a CastPlan,
    /// Indices among the roles of the cast.
    chosen: Vec<usize>,
    /// The seed of how they look; `None` if they look like their characters.
    seed: Option<u64>,
}

impl LiveScene {
    /// Brings the props and people of a scene into a crowd.
    pub(super) fn new(
        crowd: &mut Crowd,
        source: &SceneSource<'_>,
    ) -> Result<(Self, LoadedRoles), Failure> {
        let (plan, args) = (&source.plan, source.picture);
        let (casts, mut files) = casts(crowd, source)?;
        let props = source.prop_files(&mut files)?;
        let levels = !args.full_detail;
        let prepare = |character: Character| {
            let wanted = levels && character.levels().is_empty();
            let character = if wanted { populace_lod::with_levels(character)? } else { character };
            Ok(Arc::new(character))
        };
        let stage = Stage::new(crowd, plan, &props, &prepare)?;
        let things = things(crowd)?;
        let gaits = walks(crowd, plan, &casts)?;
        clips::check(crowd, source, |cast| casts.get(cast).map_or(&[][..], Vec::as_slice))?;
        let players = players(source, &casts);
        let people: Vec<Vec<Person>> = players.iter().map(|of| of.people(&casts)).collect();
        let behaviours = Behaviours::new(crowd, plan, &stage, &people, gaits)?;
        if source.file.is_some() {
            source.warn(behaviours.doubts(plan));
        }
        let people: Vec<MemberId> = behaviours.people().collect();
        dress(crowd, &players, &casts, &people)?;
        let mut eyes_m = Vec::new();
        for member in &people {
            let view = crowd.member(*member)?;
            let height = crowd.character(view.character())?.asset().height_m();
            eyes_m.push(EYES * height * view.placement().scale());
        }
        source.announce(crowd, people.len());
        let roles = casts.into_values().flatten().collect();
        let numbers = people.iter().copied().zip(0..).collect();
        let mut scene = Self {
            numbers,
            behaviours,
            stage,
            people,
            poses: Past::default(),
            eyes_m,
            filmed: None,
            eyes: None,
            things,
        };
        scene.note_poses(crowd, 0.0)?;
        Ok((scene, LoadedRoles { roles, files }))
    }

    /// Notes where people have moved to, `secs` after the last time. Until they are evaluated, the
    /// eyes of the person that the camera goes with have moved with its body or its vehicle.
    fn note_poses(&mut self, crowd: &Crowd, secs: f64) -> Result<(), Failure> {
        let mut poses = Vec::with_capacity(self.people.len());
        for (member, eye_m) in self.people.iter().zip(&self.eyes_m) {
            let placement = crowd.member(*member)?.placement();
            let (position, heading_rad) = (placement.position(), placement.yaw_rad());
            poses.push(Pose { position, heading_rad, eye_m: *eye_m });
        }
        self.poses.pass(secs, poses);
        if let Some(Eyes { on, from_there_m }) = self.eyes {
            let placement = crowd.member(on)?.placement();
            let turn = Quat::from_rotation_y(placement.yaw_rad());
            self.see_from(Vec3::from(placement.position()) + turn * from_there_m);
        }
        Ok(())
    }

    /// Notes where the eyes of the person that the camera goes with are, after an evaluation.
    fn note_eyes(&mut self, crowd: &mut Crowd) -> Result<(), Failure> {
        let Some(member) = self.filmed.and_then(|nth| self.people.get(nth).copied()) else {
            return Ok(());
        };
        if let Some(eyes) = eyes(crowd, member)? {
            self.see_from(eyes);
            let on = crowd.member(member)?.attached_to().map_or(member, |(vehicle, _)| vehicle);
            let placement = crowd.member(on)?.placement();
            let back = Quat::from_rotation_y(-placement.yaw_rad());
            let from_there_m = back * (eyes - Vec3::from(placement.position()));
            self.eyes = Some(Eyes { on, from_there_m });
        }
        Ok(())
    }

    /// Puts the person that the camera goes with below its eyes: who sits, rides or lies sees from
    /// elsewhere than over its placement.
    fn see_from(&mut self, eyes: Vec3) {
        if let Some(pose) = self.filmed.and_then(|nth| self.poses.now.get_mut(nth)) {
            pose.position = (eyes - pose.eye_m * Vec3::Y).to_array();
        }
    }
}

/// Returns the corners of the boxes around all members at rest.
fn things(crowd: &Crowd) -> Result<Vec<[f32; 3]>, Failure> {
    let mut points = Vec::new();
    for member in crowd.members() {
        let Some(around) = crowd.character(member.character())?.asset().rest_bounds() else {
            continue;
        };
        let world_from_model = member.placement().world_from_model();
        let sides = [around.low, around.high];
        points.extend((0..8).map(|corner: usize| {
            let axis = |axis: usize| sides[corner >> axis & 1][axis];
            world_from_model.transform_point([axis(0), axis(1), axis(2)])
        }));
    }
    Ok(points)
}

/// Loads the characters of all casts, and names the files that they refer to.
fn casts(
    crowd: &mut Crowd,
    source: &SceneSource<'_>,
) -> Result<(Casts, Vec<std::path::PathBuf>), Failure> {
    let args = source.picture;
    let (mut casts, mut files) = (Casts::new(), Vec::new());
    for cast in &source.plan.casts {
        let clips = cast.clips_from.iter().map(|file| source.path(file));
        let clips: Vec<_> = clips.chain(args.clips.iter().cloned()).collect();
        let clothes = Clothes {
            options: cast.varied && !args.plain,
            no_hats: cast.holds.iter().any(|thing| thing == "helmet"),
            top: cast.top,
        };
        let loaded = roles::load(
            crowd,
            &args.input,
            &source.inputs(cast),
            &clips,
            ClipChoice::Scene,
            args.height.or(cast.height_m),
            Levels::wanted(args),
            clothes,
        )?;
        files.extend(loaded.files);
        casts.insert(cast.name.clone(), loaded.roles);
    }
    Ok((casts, files))
}

/// Returns the gaits of all characters that have some. Refuses a character that has to walk and
/// cannot.
fn walks(crowd: &mut Crowd, plan: &ScenePlan, casts: &Casts) -> Result<Vec<GaitSpace>, Failure> {
    let mut all = Vec::new();
    for (cast, roles) in casts {
        let mut refused: Vec<(&str, anyhow::Error)> = Vec::new();
        for (nth, gaits) in gaits(crowd, roles, "`clips_from`")?.into_iter().enumerate() {
            match (gaits, walk_of(plan, cast, nth)) {
                (Ok(gaits), _) => all.push(gaits),
                (Err(reason), Some(does)) => refused.push((does, reason)),
                (Err(_), None) => {}
            }
        }
        if let [(does, _), ..] = refused[..] {
            let more = refused.len().saturating_sub(NAMED);
            let more =
                if more > 0 { format!("; {more} more cannot either") } else { String::new() };
            let reasons = refused.iter().take(NAMED).map(|(_, reason)| reason.to_string());
            let reasons = reasons.collect::<Vec<_>>().join("; ");
            return Err(Failure::Input(anyhow::anyhow!(
                "the cast \"{cast}\" has people who cannot walk, and a [[crowd]] of it does \
                 `{does}`: {reasons}{more}"
            )));
        }
    }
    Ok(all)
}

/// Returns how a character of a cast has to walk, by its number; `None` if it does not.
fn walk_of(plan: &ScenePlan, cast: &str, nth: usize) -> Option<&'static str> {
    // Members are the characters of their cast in turn.
    let mut of = plan.crowds.iter().filter(|crowd| crowd.cast == cast && nth < crowd.count);
    of.find_map(|crowd| match crowd.does {
        BehaviourPlan::Stroll(_) => Some("stroll"),
        BehaviourPlan::Fight(_) => Some("fight"),
        _ => None,
    })
}

/// Chooses who plays the members of each crowd of the plan: the characters of its cast in turn.
fn players<'a>(source: &'a SceneSource<'_>, casts: &Casts) -> Vec<Players<'a>> {
    let plan = &source.plan;
    let of = |(nth, crowd): (usize, &populace_scene::plan::CrowdPlan)| {
        let cast = plan.casts.iter().find(|cast| cast.name == crowd.cast)?;
        let roles = casts.get(&cast.name)?.len().max(1);
        let seed = plan.seed.wrapping_add(source.picture.seed).wrapping_add(nth as u64);
        let varied = cast.varied && !source.picture.plain;
        let chosen = (0..crowd.count).map(|member| member % roles).collect();
        Some(Players { cast, chosen, seed: varied.then_some(seed) })
    };
    plan.crowds.iter().enumerate().filter_map(of).collect()
}

impl Players<'_> {
    /// Returns the bodies of members. Their looks follow once it is known who is near whom.
    fn people(&self, casts: &Casts) -> Vec<Person> {
        let roles = &casts[&self.cast.name];
        // Heights depend on the seed alone.
        let places: Vec<[f32; 3]> =
            (0..self.chosen.len()).map(|nth| [0.0, 0.0, nth as f32]).collect();
        let appearances = appearances(roles, &self.chosen, &places, self.seed);
        let person = |(member, role): (usize, &usize)| Person {
            character: roles[*role].id,
            scale: roles[*role].scale * appearances.get(member).map_or(1.0, |of| of.height),
            look: None,
        };
        self.chosen.iter().enumerate().map(person).collect()
    }
}

/// Gives members looks that differ from those around them.
fn dress(
    crowd: &mut Crowd,
    players: &[Players<'_>],
    casts: &Casts,
    people: &[MemberId],
) -> Result<(), Failure> {
    let mut from = 0;
    for of in players {
        let members = &people[from..from + of.chosen.len()];
        from += of.chosen.len();
        let places = members
            .iter()
            .map(|member| Ok(crowd.member(*member)?.placement().position()))
            .collect::<Result<Vec<_>, populace::Error>>()?;
        let roles = &casts[&of.cast.name];
        let looks = appearances(roles, &of.chosen, &places, of.seed);
        for (nth, member) in members.iter().enumerate() {
            let mut member = crowd.member_mut(*member)?;
            let mut look = looks.get(nth).map_or_else(|| member.look(), |of| of.look);
            if let Some(color) = of.cast.top {
                // The clothes of built-in people have the colour.
                let is_built_in = roles[of.chosen[nth]].is_built_in;
                look = look.tinted(Region::Top, if is_built_in { [1.0; 3] } else { color });
            }
            member.set_look(look);
        }
    }
    Ok(())
}

impl Subject for LiveScene {
    /// The people; without any, the things.
    fn bounds(&self) -> Vec<[f32; 3]> {
        if self.poses.now.is_empty() {
            return self.things.clone();
        }
        let around = |pose: &Pose| figure(pose.position, [pose.eye_m / EYES, HALF_M]);
        self.poses.now.iter().flat_map(around).collect()
    }

    fn elevation_rad(&self) -> Option<f32> {
        Some(0.5)
    }

    fn figure_m(&self) -> [f32; 2] {
        [self.eyes_m.iter().copied().fold(0.0, f32::max) / EYES, HALF_M]
    }

    fn closest(&self) -> Option<u64> {
        (!self.poses.now.is_empty()).then_some(0)
    }

    /// The pose of the last step, whatever the time: nobody knows where people will walk.
    fn pose(&self, id: u64, _secs: f64) -> Option<Pose> {
        self.poses.now.get(usize::try_from(id).ok()?).copied()
    }

    fn describe_ids(&self) -> String {
        format!("people have the numbers from 0 to {}", self.poses.now.len().saturating_sub(1))
    }
}

/// A scene and the cameras that film it.
pub(super) struct FilmedScene {
    live: LiveScene,
    view: View,
    /// `None` before the aspect of pictures is known.
    cameras: Option<Cameras>,
    behave_ms: f64,
    /// The scene before frame 0.
    #[cfg(feature = "viewer")]
    first: (Behaviours, Stage),
}

impl FilmedScene {
    pub(super) fn new(mut live: LiveScene, view: View) -> Self {
        live.filmed = match &view {
            View::Follow { id } | View::Eye { id } => id.parse().ok(),
            _ => None,
        };
        #[cfg(feature = "viewer")]
        let first = (live.behaviours.clone(), live.stage.clone());
        Self {
            live,
            view,
            cameras: None,
            behave_ms: 0.0,
            #[cfg(feature = "viewer")]
            first,
        }
    }

    fn step(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        let start = Instant::now();
        self.live.behaviours.advance(crowd, secs)?;
        self.live.stage.light(crowd, self.live.behaviours.lights())?;
        self.behave_ms += start.elapsed().as_secs_f64() * 1e3;
        self.live.note_poses(crowd, f64::from(secs))
    }

    /// The things that have happened.
    pub(super) fn counts(&self) -> Counts {
        self.live.behaviours.counts()
    }
}

impl Action for FilmedScene {
    fn set_aspect(&mut self, aspect: f32) -> Result<(), Failure> {
        self.cameras = Some(Cameras::new(&self.view, &self.live, aspect)?);
        Ok(())
    }

    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, Failure> {
        in_foot_steps(self, crowd, secs, Self::step)
    }

    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), Failure> {
        crowd.update(secs)?;
        self.live.note_eyes(crowd)
    }

    fn take_behave_ms(&mut self) -> f64 {
        std::mem::take(&mut self.behave_ms)
    }

    fn cameras(&self) -> Option<&Cameras> {
        self.cameras.as_ref()
    }

    fn camera(&self, secs: f64) -> Result<Camera, Failure> {
        let poses = |id, at: f64| self.live.poses.before(id, secs - at);
        let cameras = self.cameras.as_ref();
        Ok(cameras.map_or_else(Camera::default, |cameras| cameras.at(&poses, secs)))
    }

    fn person(&self, member: MemberId) -> Option<u64> {
        self.live.numbers.get(&member).copied()
    }
}

#[cfg(feature = "viewer")]
impl crate::watched::Watched for FilmedScene {
    fn rewind(&mut self) {
        (self.live.behaviours, self.live.stage) = self.first.clone();
        self.live.poses.forget();
        self.live.eyes = None;
    }

    fn leads_members(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests;
