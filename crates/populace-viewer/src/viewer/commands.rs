//! Commands of keys and panels.

use egui::Key;
use populace::Devices;

use super::Viewer;
use crate::Error;
use crate::camera::{Mode, Rig};
use crate::desk::{Command, Desk};
use crate::film::Recording;
use crate::show::{ShowError, Wish};
use crate::stage::Stage;

impl Viewer<'_> {
    /// Does what the panels or a key wished for.
    pub(super) fn carry_out(&mut self, command: Command) -> Result<(), Error> {
        match command {
            Command::Seek(secs) => self.seek(secs)?,
            Command::Step { later } => {
                self.desk.clock.plays = false;
                let secs = self.stage.neighbour_secs(later);
                self.seek(secs)?;
            }
            Command::Refresh => {}
            Command::Frame(member) => {
                if let (Some(at), Ok(shown)) =
                    (self.stage.followed(member), self.stage.shown_camera())
                {
                    let center = at.feet + glam::Vec3::Y * 0.5 * at.height_m;
                    self.desk.rig.frame(center, 0.6 * at.height_m, &shown);
                }
            }
            Command::Follow(member) => {
                if let (Some(at), Ok(shown)) =
                    (self.stage.followed(member), self.stage.shown_camera())
                {
                    self.desk.rig.begin_to_follow(&at, &shown);
                }
            }
            Command::Drive(member) => self.drive(member),
            Command::Fall(member) => {
                let yaw_rad = self.desk.rig.yaw_rad();
                #[expect(clippy::disallowed_methods, reason = "a shove of the host alone")]
                let away = [yaw_rad.sin(), yaw_rad.cos()];
                let result = self.stage.falls.fall(&self.stage.crowd, member, away);
                self.say_error(result.map_err(Into::into));
                self.desk.clock.plays = true;
            }
            Command::GetUp(member) => {
                let Stage { falls, crowd, .. } = &mut self.stage;
                let result = falls.get_up(crowd, member);
                self.say_error(result.map_err(Into::into));
                self.desk.clock.plays = true;
            }
            Command::Reopen { members, device, schedule } => {
                let devices = device.and_then(|name| name.parse::<Devices>().ok());
                let old = self.wish.clone();
                self.reopen(Wish {
                    dropped: old.dropped,
                    members: members.or(old.members),
                    devices: devices.or(old.devices),
                    schedule: schedule.or(old.schedule),
                });
            }
            Command::Record => self.record(),
        }
        Ok(())
    }

    /// Begins to go to a time in seconds.
    fn seek(&mut self, secs: f64) -> Result<(), Error> {
        if self.stage.seek(secs)? {
            self.desk.forget_layers();
        }
        Ok(())
    }

    /// Lets the keyboard drive a member, or lets go of the one that it drives.
    fn drive(&mut self, member: populace::MemberId) {
        if self.stage.you() == Some(member) {
            self.stage.leave();
            return;
        }
        match self.stage.drive(member) {
            Ok(you) => {
                self.desk.picked = Some(you);
                self.desk.wish(Command::Follow(you));
                self.desk.clock.plays = true;
                self.desk.say("The arrow keys walk and turn; Shift runs", self.now_secs);
            }
            Err(error) => self.desk.say(format!("nobody can drive it: {error}"), self.now_secs),
        }
    }

    /// Does what a key is for.
    pub(super) fn press(&mut self, key: Key) {
        let picked = self.desk.picked;
        let desk = &mut self.desk;
        let of_picked = |desk: &mut Desk, command: fn(populace::MemberId) -> Command| match picked {
            Some(member) => desk.wish(command(member)),
            None => desk.say("click somebody first", self.now_secs),
        };
        match key {
            Key::Space => desk.clock.plays = !desk.clock.plays,
            Key::Comma => desk.wish(Command::Step { later: false }),
            Key::Period => desk.wish(Command::Step { later: true }),
            Key::Home => desk.wish(Command::Seek(0.0)),
            Key::OpenBracket => desk.clock.change(false),
            Key::CloseBracket => desk.clock.change(true),
            Key::Num1 => self.set_mode(Mode::Shown),
            Key::Num2 => self.set_mode(Mode::Orbit),
            Key::Num3 => self.set_mode(Mode::Fly),
            Key::Num4 => of_picked(desk, Command::Follow),
            Key::F => of_picked(desk, Command::Frame),
            Key::Y => match self.stage.you() {
                Some(member) => desk.wish(Command::Drive(member)),
                None => of_picked(desk, Command::Drive),
            },
            Key::R => of_picked(desk, Command::Fall),
            Key::G => of_picked(desk, Command::GetUp),
            Key::K => desk.layout.skeletons = !desk.layout.skeletons,
            Key::B => desk.layout.bounds = !desk.layout.bounds,
            Key::L => desk.layout.levels = !desk.layout.levels,
            Key::T => desk.layout.times = !desk.layout.times,
            Key::V => desk.wish(Command::Record),
            Key::Tab => desk.layout.panels = !desk.layout.panels,
            Key::Questionmark | Key::F1 => desk.help = !desk.help,
            Key::Escape if desk.help => desk.help = false,
            Key::Escape => desk.picked = None,
            _ => {}
        }
    }

    fn set_mode(&mut self, mode: Mode) {
        if let Ok(shown) = self.stage.shown_camera() {
            self.desk.rig.set_mode(mode, &shown);
        }
    }

    /// Opens a show in place of the present one, which stays if that fails.
    pub(super) fn reopen(&mut self, wish: Wish) {
        self.end_film();
        match Stage::open(&mut *self.opener, &wish, &mut self.renderer) {
            Ok(stage) => {
                let is_other = wish.dropped != self.wish.dropped;
                let secs = if is_other { 0.0 } else { self.stage.secs() };
                (self.stage, self.wish, self.aspect) = (stage, wish, None);
                self.desk.forget();
                let count = self.stage.crowd.member_count();
                self.desk.members = u32::try_from(count).unwrap_or(u32::MAX);
                if is_other {
                    self.desk.rig = Rig::default();
                }
                self.desk.wish(Command::Seek(secs));
            }
            Err(error) => self.desk.say(error.to_string(), self.now_secs),
        }
        self.drawn = None;
    }

    fn record(&mut self) {
        if self.film.is_some() {
            return self.end_film();
        }
        let (path, size, rate) = (&self.film_path, self.renderer.size(), self.stage.rate());
        match Recording::begin(path, size, rate) {
            Ok(film) => {
                self.desk.film = Some((film.path().display().to_string(), 0));
                self.film = Some(film);
                self.desk.clock.plays = true;
            }
            Err(error) => self.desk.say(error.to_string(), self.now_secs),
        }
    }

    /// Completes the film, if one is being made.
    pub(crate) fn end_film(&mut self) {
        self.desk.film = None;
        let Some(film) = self.film.take() else { return };
        let words = match film.end() {
            Ok(Some(path)) => format!("recorded {}", path.display()),
            Ok(None) => "no film, since no time has passed".to_owned(),
            Err(error) => error.to_string(),
        };
        self.desk.say(words, self.now_secs);
    }

    fn say_error(&mut self, result: Result<(), ShowError>) {
        if let Err(error) = result {
            self.desk.say(error.to_string(), self.now_secs);
        }
    }
}
