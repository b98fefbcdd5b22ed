//! The crowd of a show on its way through time, and what people do to it.

use std::collections::{HashMap, HashSet};
use std::time::Instant;

use glam::Vec3;
use populace::model::Role;
use populace::{CharacterId, Crowd, Mask, MaskId, MemberId, Placement, Snapshot};
use populace_film::FrameRate;
use populace_render::{Camera, Renderer, Scene};

use crate::Error;
use crate::camera::{Followed, Mode, Rig};
use crate::falls::Falls;
use crate::show::{Opened, Opener, Show, ShowError, Wish};
use crate::you::{Steering, You};

/// Longest time that a replay may take before a picture is drawn, in milliseconds.
const REPLAY_MS: f64 = 60.0;
/// Times that are nearer to each other are the same, in seconds.
const SAME_SECS: f64 = 1e-9;
/// How far beside the camera's target a visitor appears, in metres.
const BESIDE_M: f32 = 0.9;

/// The view that a frame is evaluated for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Seen {
    pub(crate) rig: Rig,
    /// The member that the rig follows, if it follows one.
    pub(crate) member: Option<MemberId>,
    /// Seconds for which the rig has not come up with that member yet.
    pub(crate) secs: f32,
    /// Width and height of the picture in pixels.
    pub(crate) size: [u32; 2],
}

/// A crowd and its show.
pub(crate) struct Stage {
    pub(crate) crowd: Crowd,
    pub(crate) show: Box<dyn Show>,
    pub(crate) falls: Falls,
    you: Option<You>,
    /// Members that the keyboard drove, until they stand.
    leaving: Vec<You>,
    /// Members that were spawned for the keyboard.
    visitors: HashSet<MemberId>,
    /// Masks that were added, by the role of their highest joint.
    masks: HashMap<(CharacterId, Role), MaskId>,
    start: Snapshot,
    scene: Scene,
    secs: f64,
    /// Where a replay goes that has not arrived.
    target_secs: Option<f64>,
    /// Milliseconds of the last step.
    animate_ms: f64,
}

impl Stage {
    /// Opens a show and evaluates its beginning.
    pub(crate) fn open(
        opener: &mut dyn Opener,
        wish: &Wish,
        renderer: &mut Renderer,
    ) -> Result<Self, Error> {
        let mut opened = opener.open(wish, renderer).map_err(Error::Show)?;
        let size = renderer.size();
        #[expect(clippy::cast_precision_loss, reason = "no window is 2^24 pixels wide")]
        let [width, height] = size.map(|side| side as f32);
        opened.show.set_aspect(width / height).map_err(Error::Show)?;
        Self::new(opened, &mut Seen { size, ..Seen::default() })
    }

    /// Evaluates the beginning of a show.
    fn new(opened: Opened, seen: &mut Seen) -> Result<Self, Error> {
        let Opened { mut crowd, show } = opened;
        let start = crowd.snapshot()?;
        let scene = show.scene();
        let falls = Falls::new(show.floor_m()).map_err(|e| Error::Show(e.into()))?;
        let mut stage = Self {
            crowd,
            show,
            falls,
            you: None,
            leaving: Vec::new(),
            visitors: HashSet::new(),
            masks: HashMap::new(),
            start,
            scene,
            secs: 0.0,
            target_secs: None,
            animate_ms: 0.0,
        };
        stage.begin(seen)?;
        Ok(stage)
    }

    pub(crate) fn secs(&self) -> f64 {
        self.secs
    }

    /// Chooses the cameras of pictures whose width is `aspect` times their height.
    pub(crate) fn set_aspect(&mut self, aspect: f32) -> Result<(), ShowError> {
        self.show.set_aspect(aspect)?;
        self.scene = self.show.scene();
        Ok(())
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(crate) fn rate(&self) -> FrameRate {
        self.show.rate()
    }

    pub(crate) fn animate_ms(&self) -> f64 {
        self.animate_ms
    }

    /// Returns the time that a replay goes to, if it has not arrived.
    pub(crate) fn target_secs(&self) -> Option<f64> {
        self.target_secs
    }

    pub(crate) fn you(&self) -> Option<MemberId> {
        self.you.as_ref().map(You::member)
    }

    /// Returns how far the driven member is from where it was taken over, in metres; 0 without one.
    pub(crate) fn walked_m(&self) -> f32 {
        let Some(you) = &self.you else { return 0.0 };
        let at = self.crowd.member(you.member()).map(|view| view.placement().position());
        at.map_or(0.0, |at| Vec3::from(at).distance(Vec3::from(you.began_at())))
    }

    /// Returns the camera of the show at the present time.
    pub(crate) fn shown_camera(&self) -> Result<Camera, Error> {
        self.show.camera(self.secs).map_err(Error::Show)
    }

    /// Evaluates frame 0.
    fn begin(&mut self, seen: &mut Seen) -> Result<(), Error> {
        self.advance(0.0, 0.0, seen)?;
        self.secs = 0.0;
        Ok(())
    }

    /// Moves the show on by `step_secs`, and evaluates the crowd for the camera of the time `secs`.
    fn advance(&mut self, step_secs: f32, secs: f64, seen: &mut Seen) -> Result<(), Error> {
        let left_secs = self.show.behave(&mut self.crowd, step_secs).map_err(Error::Show)?;
        self.look(secs, seen)?;
        self.show.evaluate(&mut self.crowd, left_secs).map_err(Error::Show)
    }

    /// Sets the view that the crowd is evaluated for.
    fn look(&mut self, secs: f64, seen: &mut Seen) -> Result<(), Error> {
        self.follow(seen);
        if let Some(detail_px) = self.show.detail_px() {
            let camera = seen.rig.camera(&self.show.camera(secs).map_err(Error::Show)?);
            self.crowd.set_view(Some(camera.view(seen.size, &self.scene, detail_px)?))?;
        }
        Ok(())
    }

    /// Brings the camera up with the member that it follows, which the show may have moved. One
    /// that its clips move is where the last evaluation left it.
    pub(crate) fn follow(&mut self, seen: &mut Seen) {
        let secs = std::mem::take(&mut seen.secs);
        let member = seen.member.filter(|_| seen.rig.mode() == Mode::Follow);
        if let Some(followed) = member.and_then(|member| self.followed(member)) {
            seen.rig.follow(&followed, secs);
        }
    }

    /// Goes on to a later time in one step.
    fn step(&mut self, secs: f64, steering: Steering, seen: &mut Seen) -> Result<(), Error> {
        let start = Instant::now();
        let step_secs = single(secs - self.secs);
        self.walk(steering, step_secs).map_err(|e| Error::Show(e.into()))?;
        self.falls.step(&mut self.crowd, step_secs).map_err(|e| Error::Show(e.into()))?;
        self.advance(step_secs, secs, seen)?;
        self.crowd.finish()?;
        self.secs = secs;
        self.animate_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Moves the driven member as it is steered, and those that were let go until they stand.
    fn walk(&mut self, steering: Steering, secs: f32) -> Result<(), populace_locomotion::Error> {
        let Self { crowd, falls, you, leaving, .. } = self;
        let mut go = |you: &mut You, steering| {
            if falls.is_down(you.member()) {
                you.rest();
                return Ok(());
            }
            you.step(crowd, steering, secs)
        };
        if let Some(you) = you {
            go(you, steering)?;
        }
        // Those that are gone need no steps.
        leaving.retain_mut(|you| go(you, Steering::default()).is_ok() && you.is_moving());
        Ok(())
    }

    /// Plays on by a time in seconds, until the end of the show. Returns false at its end.
    pub(crate) fn play(
        &mut self,
        secs: f64,
        steering: Steering,
        seen: &mut Seen,
    ) -> Result<bool, Error> {
        let end_secs = self.show.length_secs().unwrap_or(f64::INFINITY);
        let next_secs = (self.secs + secs).min(end_secs);
        if next_secs <= self.secs + SAME_SECS {
            return Ok(secs <= 0.0);
        }
        let frame_secs = self.neighbour_secs(true);
        let is_frame = (frame_secs - next_secs).abs() < SAME_SECS;
        self.step(if is_frame { frame_secs } else { next_secs }, steering, seen)?;
        Ok(next_secs < end_secs)
    }

    /// Evaluates the present time again, for changes that are seen in a pause.
    pub(crate) fn refresh(&mut self, seen: &mut Seen) -> Result<(), Error> {
        self.look(self.secs, seen)?;
        self.crowd.update(0.0)?;
        self.crowd.finish()?;
        Ok(())
    }

    /// Begins to replay to a time: from frame to frame, as films are made. An earlier time is
    /// reached from the beginning, which undoes what people did to the crowd. Returns true then.
    pub(crate) fn seek(&mut self, secs: f64) -> Result<bool, Error> {
        let end_secs = self.show.length_secs().unwrap_or(f64::INFINITY);
        let secs = secs.clamp(0.0, end_secs);
        let is_earlier = secs < self.secs - SAME_SECS;
        if is_earlier {
            self.rewind()?;
        }
        self.target_secs = Some(secs);
        Ok(is_earlier)
    }

    /// Returns to the time before frame 0.
    fn rewind(&mut self) -> Result<(), Error> {
        self.you = None;
        self.leaving.clear();
        self.visitors.clear();
        self.masks.clear();
        self.falls = Falls::new(self.show.floor_m()).map_err(|e| Error::Show(e.into()))?;
        self.crowd.restore(&self.start)?;
        self.show.rewind();
        self.secs = -1.0;
        Ok(())
    }

    /// Goes on with a replay for a while. Returns true if there is none, or if it has arrived.
    pub(crate) fn replay(&mut self, seen: &mut Seen) -> Result<bool, Error> {
        let Some(target_secs) = self.target_secs else { return Ok(true) };
        let start = Instant::now();
        if self.secs < 0.0 {
            self.begin(seen)?;
        }
        while self.secs < target_secs - SAME_SECS {
            let frame_secs = self.neighbour_secs(true);
            let is_on_the_way = frame_secs <= target_secs + SAME_SECS;
            let next_secs = if is_on_the_way { frame_secs } else { target_secs };
            seen.secs = single(next_secs - self.secs);
            self.step(next_secs, Steering::default(), seen)?;
            if start.elapsed().as_secs_f64() * 1e3 > REPLAY_MS {
                return Ok(false);
            }
        }
        self.target_secs = None;
        Ok(true)
    }

    /// Returns the time of the frame before or after the present time in seconds.
    pub(crate) fn neighbour_secs(&self, later: bool) -> f64 {
        let place = self.secs * self.rate().per_sec();
        let frame = if later { (place + 1e-6).floor() + 1.0 } else { (place - 1e-6).ceil() - 1.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least 0, and floats saturate"
        )]
        let frame = frame.max(0.0) as u32;
        self.rate().secs(frame)
    }

    /// Lets the keyboard drive a member; a visitor beside it if the show leads its members. Returns
    /// the member.
    pub(crate) fn drive(&mut self, member: MemberId) -> Result<MemberId, ShowError> {
        let is_led = self.show.leads_members() && !self.visitors.contains(&member);
        let driven = if is_led { self.visitor(member)? } else { member };
        let you = You::new(&mut self.crowd, driven);
        if is_led {
            if you.is_err() {
                self.crowd.despawn(driven)?;
            } else {
                self.visitors.insert(driven);
            }
        }
        let you = you?;
        self.leave();
        self.leaving.retain(|leaving| leaving.member() != driven);
        self.you = Some(you);
        Ok(driven)
    }

    /// Releases the member that the keyboard drives, which slows down and stands.
    pub(crate) fn leave(&mut self) {
        self.leaving.extend(self.you.take());
    }

    /// Spawns a person that looks like a member, at its side.
    fn visitor(&mut self, member: MemberId) -> Result<MemberId, populace::Error> {
        let view = self.crowd.member(member)?;
        let (character, look, at) = (view.character(), view.look(), view.placement());
        let side = at.world_from_model().transform_point([BESIDE_M / at.scale(), 0.0, 0.0]);
        let placement = Placement::at(side).facing(at.yaw_rad()).scaled(at.scale());
        let visitor = self.crowd.spawn(character, placement)?;
        self.crowd.member_mut(visitor)?.set_look(look);
        Ok(visitor)
    }

    /// Returns the mask of a character's joints from one with a role on; `None` for bodies that
    /// lack it.
    pub(crate) fn mask(&mut self, character: CharacterId, role: Role) -> Option<MaskId> {
        if let Some(mask) = self.masks.get(&(character, role)) {
            return Some(*mask);
        }
        let view = self.crowd.character(character).ok()?;
        let root = view.roles()?.joint(role)?;
        let mask = Mask::subtree(&view.asset().skeleton, root);
        let id = self.crowd.character_mut(character).ok()?.add_mask(&mask).ok()?;
        self.masks.insert((character, role), id);
        Some(id)
    }

    /// Returns where a member is; `None` for one that is gone.
    pub(crate) fn followed(&mut self, member: MemberId) -> Option<Followed> {
        let height_m = self.height_m(member)?;
        let placement = self.placement(member)?;
        let feet = Vec3::from(placement.position());
        Some(Followed { feet, yaw_rad: placement.yaw_rad(), height_m })
    }

    /// Returns the height of a member in metres; `None` for one that is gone.
    pub(crate) fn height_m(&self, member: MemberId) -> Option<f32> {
        let view = self.crowd.member(member).ok()?;
        let height_m = self.crowd.character(view.character()).ok()?.asset().height_m();
        Some((height_m * view.placement().scale()).max(0.1))
    }

    /// Returns the placement to which a member has moved; `None` for one that is gone.
    pub(crate) fn placement(&mut self, member: MemberId) -> Option<Placement> {
        let mut view = self.crowd.member_mut(member).ok()?;
        if view.has_root_motion() {
            return view.moved_placement().ok();
        }
        Some(view.placement())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
pub(crate) fn single(secs: f64) -> f32 {
    secs as f32
}

#[cfg(test)]
mod tests;
