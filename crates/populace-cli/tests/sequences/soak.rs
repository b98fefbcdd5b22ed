//! A soak: two large crowds on different devices that get the same calls for a long time, while
//! members and clips come and go. Their palettes and return values must be equal bit for bit and
//! finite, attachments and planted feet must stay where they are, and memory must not grow.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use populace::interop::PAGE_ENTRIES;
use populace::{ClipId, ClipPlayback, MemberId};
use populace_testkit::Rng;

use crate::calls::{ALL, CallKind, placement};
use crate::draw::Draw;
use crate::fixture::{characters, rotating, soak_setups};
use crate::long::{number, report, resident_kib};
use crate::watched::{Drift, Watched};
use crate::world::{Outcome, World};

/// The flag of a soak; its value is the time in minutes.
pub(crate) const FLAG: &str = "--soak-minutes";

/// Memory may be larger by this share than it was at first: in the first minute, and in ten lives of
/// members.
const GROWTH: f64 = 0.01;
const FIRST_FRAMES: usize = 3000;
const SLOTS: usize = 8;
const STEP_SECS: f32 = 1.0 / 60.0;
/// Members live for about this many frames, and get this many calls in their life.
const LIFE_FRAMES: usize = 300;
const CALLS_IN_A_LIFE: usize = 6;
/// Frames between two moves to other devices.
const MOVE_FRAMES: usize = 30;
/// Frames between two comparisons of palettes, and of the members that are watched.
const COMPARE_FRAMES: usize = 5;
const WATCH_FRAMES: usize = 30;
/// Frames between two clips that are added, frames that each stays, and frames in which its members
/// fade to another.
const CLIP_FRAMES: usize = 12;
const CLIP_LIFE_FRAMES: usize = 60;
const CLIP_FADE_FRAMES: usize = 90;

/// Calls that a soak leaves out: those that it makes itself, ragdolls, which have no counterpart on
/// devices, and handles that are dropped but still watched.
const LEFT_OUT: [CallKind; 15] = [
    CallKind::Update,
    CallKind::Spawn,
    CallKind::Despawn,
    CallKind::SetGround,
    CallKind::GoLimp,
    CallKind::GoLimpFrom,
    CallKind::Push,
    CallKind::GetUp,
    CallKind::Watch,
    CallKind::Page,
    CallKind::Instances,
    CallKind::MoveTo,
    CallKind::SetSplit,
    CallKind::NameMoment,
    CallKind::AddStage,
];

/// A clip that was added, and the members that were told to play it.
struct Added {
    /// In either crowd.
    clips: [ClipId; 2],
    body: usize,
    players: [Vec<MemberId>; 2],
    since: usize,
    is_leaving: bool,
}

/// What a soak did.
#[derive(Debug, Default)]
struct Counts {
    frames: usize,
    calls: usize,
    spawned: usize,
    despawned: usize,
    clips_added: usize,
    clips_removed: usize,
    moves: usize,
    numbers_compared: usize,
}

struct Soak {
    worlds: [World; 2],
    watched: [Watched; 2],
    members: usize,
    rng: Rng,
    kinds: Vec<CallKind>,
    added: Vec<Added>,
    counts: Counts,
    drift: Drift,
}

/// Returns what both crowds answer, or an error if they differ.
fn same<T: PartialEq + std::fmt::Debug>(what: &str, [a, b]: [T; 2]) -> Result<T, String> {
    if a == b { Ok(a) } else { Err(format!("{what}: the crowds return {a:?} and {b:?}")) }
}

impl Soak {
    fn new(members: usize, seed: u64) -> Result<Self, String> {
        let say = |error: populace::Error| error.to_string();
        // Watched members take some of the room.
        let world = |setup| World::new(setup, SLOTS, members + 100).map_err(say);
        let [first, second] = &soak_setups();
        let mut worlds = [world(first)?, world(second)?];
        let [a, b] = &mut worlds;
        let watched = [Watched::spawn(a).map_err(say)?, Watched::spawn(b).map_err(say)?];
        let kinds = ALL.iter().filter(|(kind, _)| !LEFT_OUT.contains(kind));
        let kinds = kinds.flat_map(|(kind, weight)| std::iter::repeat_n(*kind, *weight)).collect();
        let (counts, drift) = (Counts::default(), Drift::default());
        let rng = Rng::new(seed);
        let mut soak = Self { worlds, watched, members, rng, kinds, added: vec![], counts, drift };
        for _ in 0..members {
            soak.spawn()?;
        }
        for _ in 0..members * CALLS_IN_A_LIFE / 2 {
            soak.call()?;
        }
        Ok(soak)
    }

    /// Makes the same call on each crowd.
    fn each<T>(&mut self, mut call: impl FnMut(&mut World, &mut Draw) -> T) -> [T; 2] {
        let seed = self.rng.bits();
        self.worlds.each_mut().map(|world| call(world, &mut Draw::new(seed, false, false)))
    }

    /// Makes the same call on both crowds, which must answer alike.
    fn both<T: PartialEq + std::fmt::Debug>(
        &mut self,
        what: &str,
        call: impl FnMut(&mut World, &mut Draw) -> T,
    ) -> Result<T, String> {
        let answers = self.each(call);
        same(what, answers)
    }

    fn spawn(&mut self) -> Result<(), String> {
        self.counts.spawned += 1;
        self.both("spawn", |world, draw| {
            let body = draw.index("body", world.bodies.len());
            let spawned = world.crowd.spawn(world.bodies[body].id, placement(draw));
            let member = spawned.map_err(|error| error.to_string())?;
            world.members.push((member, body));
            let clip = world.bodies[body].clips[draw.index("clip", 2)];
            let playing = world.crowd.member_mut(member).and_then(|mut m| {
                m.play(clip, ClipPlayback::looping().phase(draw.number("phase", 0.0, 1.0)))
            });
            playing.map_err(|error| error.to_string()).map(|_| ())
        })?
    }

    fn despawn(&mut self) -> Result<(), String> {
        self.counts.despawned += 1;
        self.both("despawn", |world, draw| {
            let at = draw.index("member", world.members.len());
            let (member, _) = world.members.swap_remove(at);
            world.crowd.despawn(member).map_err(|error| error.to_string())
        })?
    }

    fn call(&mut self) -> Result<(), String> {
        self.counts.calls += 1;
        let kind = self.kinds[self.rng.below(self.kinds.len())];
        self.both(&format!("{kind:?}"), |world, draw| kind.run(world, draw)).map(|_| ())
    }

    /// Adds a clip to a body and lets members play it.
    fn add_clip(&mut self) -> Result<(), String> {
        let now = self.counts.frames;
        let body = self.rng.below(characters().len());
        let character = &characters()[body];
        let name = ["arm", "snake", "person", "ghost"][body];
        let joints = if name == "person" { 0 } else { character.skeleton.joint_count() };
        let clip = if joints == 0 {
            Arc::clone(&character.clips[self.rng.below(character.clips.len())])
        } else {
            Arc::new(rotating(name, joints, &character.skeleton))
        };
        let [first, second] = self.each(|world, draw| {
            let id = world.bodies[body].id;
            let clip = world.crowd.character_mut(id).and_then(|mut view| view.add_clip(&clip));
            let clip = clip.map_err(|error| error.to_string())?;
            let mut players = Vec::new();
            for _ in 0..8 {
                let (member, _) = world.members[draw.index("member", world.members.len())];
                let fade = ClipPlayback::looping().fade_in_secs(0.2);
                let playing = world.crowd.member_mut(member).and_then(|mut m| m.play(clip, fade));
                players.extend(playing.is_ok().then_some(member));
            }
            Ok::<_, String>((clip, players))
        });
        let [(a, few), (b, others)] = [first?, second?];
        same("players of a clip", [few.len(), others.len()])?;
        self.counts.clips_added += 1;
        let (clips, players) = ([a, b], [few, others]);
        self.added.push(Added { clips, body, players, since: now, is_leaving: false });
        Ok(())
    }

    /// Lets members leave clips that were added long ago, and removes those that nobody plays.
    fn remove_clips(&mut self) -> Result<(), String> {
        let now = self.counts.frames;
        let mut kept = Vec::new();
        for mut added in std::mem::take(&mut self.added) {
            let age = now - added.since;
            if age >= CLIP_LIFE_FRAMES && !added.is_leaving {
                added.is_leaving = true;
                for (world, players) in self.worlds.iter_mut().zip(&added.players) {
                    leave_clips(world, players, added.body);
                }
            }
            let removed = age >= CLIP_LIFE_FRAMES + CLIP_FADE_FRAMES && {
                let worlds = self.worlds.each_mut().into_iter().zip(added.clips);
                let removed: Vec<bool> =
                    worlds.map(|(world, clip)| world.crowd.remove(clip).is_ok()).collect();
                same("remove a clip", [removed[0], removed[1]])?
            };
            if removed {
                self.counts.clips_removed += 1;
            } else {
                kept.push(added);
            }
        }
        self.added = kept;
        Ok(())
    }

    /// Makes one frame's calls, updates both crowds, and compares them.
    fn frame(&mut self) -> Result<(), String> {
        let now = self.counts.frames;
        for _ in 0..self.members.div_ceil(LIFE_FRAMES) {
            self.despawn()?;
            self.spawn()?;
            for _ in 0..CALLS_IN_A_LIFE {
                self.call()?;
            }
        }
        if now.is_multiple_of(CLIP_FRAMES) {
            self.add_clip()?;
            self.remove_clips()?;
        }
        if now.is_multiple_of(MOVE_FRAMES) {
            self.move_one()?;
        }
        let update = |world: &mut World, _: &mut Draw| Outcome::of(world.crowd.update(STEP_SECS));
        let updated = self.both("update", update)?;
        if updated != Outcome::Done {
            return Err(format!("{updated:?}"));
        }
        if now.is_multiple_of(COMPARE_FRAMES) {
            self.compare_palettes()?;
        }
        // Feet have been locked by then.
        if now >= 2 * WATCH_FRAMES && now.is_multiple_of(WATCH_FRAMES) {
            self.watch()?;
        }
        self.counts.frames += 1;
        Ok(())
    }

    /// Moves one crowd, in turn, to its next devices.
    fn move_one(&mut self) -> Result<(), String> {
        let world = &mut self.worlds[self.counts.moves % 2];
        self.counts.moves += 1;
        world.device = (world.device + 1) % world.setup.devices.len();
        let devices = world.setup.devices[world.device].clone();
        world.crowd.move_to(devices).map_err(|error| format!("move: {error}"))
    }

    fn compare_palettes(&mut self) -> Result<(), String> {
        let mut palettes = [Vec::new(), Vec::new()];
        for (world, found) in self.worlds.iter_mut().zip(&mut palettes) {
            read_palettes(world, found)?;
        }
        let [first, second] = &palettes;
        if first.len() != second.len() {
            return Err(format!("{} and {} numbers", first.len(), second.len()));
        }
        if let Some(at) = first.iter().zip(second).position(|(a, b)| a.to_bits() != b.to_bits()) {
            let [a, b] = [first[at], second[at]];
            return Err(format!("number {at} of all palettes is {a} and {b}"));
        }
        if let Some(at) = first.iter().position(|number| !number.is_finite()) {
            return Err(format!("number {at} of all palettes is {}", first[at]));
        }
        self.counts.numbers_compared += first.len();
        Ok(())
    }

    fn watch(&mut self) -> Result<(), String> {
        let [a, b] = &mut self.worlds;
        let [first, second] = &mut self.watched;
        let found = [first.drift(&mut a.crowd), second.drift(&mut b.crowd)];
        let found = same("drift", found.map(|drift| drift.map_err(|error| error.to_string())))??;
        self.drift = self.drift.worst(found);
        if self.drift.is_within(Drift::MOST) {
            return Ok(());
        }
        Err(format!("{found:?} is more than {:?}", Drift::MOST))
    }
}

/// Lets members fade out what they play and play a clip of a body's own.
fn leave_clips(world: &mut World, players: &[MemberId], body: usize) {
    let other = world.bodies[body].clips[0];
    for member in players {
        // Some were despawned since.
        let _gone = world.crowd.member_mut(*member).and_then(|mut m| {
            (0..4).try_for_each(|layer| m.stop(layer, 0.1))?;
            m.play(other, ClipPlayback::looping())
        });
    }
}

/// Reads the palettes of all members, in the order of instances.
fn read_palettes(world: &mut World, into: &mut Vec<f32>) -> Result<(), String> {
    let places: Vec<(usize, usize)> = world
        .crowd
        .instances()
        .map(|i| (i.palette_first as usize, i.character.palette.len()))
        .collect();
    let entries = PAGE_ENTRIES as usize;
    let pages = places.iter().map(|(first, _)| first / entries).max().map_or(0, |last| last + 1);
    for page in 0..pages {
        let read = world.crowd.with_page(page, &mut |elements| {
            let here = places.iter().filter(|(first, _)| first / entries == page);
            for (first, count) in here {
                let first = 3 * (first % entries);
                into.extend(elements[first..first + 3 * count].iter().flat_map(|row| row.0));
            }
        });
        read.map_err(|error| format!("page {page}: {error}"))?;
    }
    Ok(())
}

/// Runs two crowds for some frames.
pub(crate) fn check_small() -> Result<(), libtest_mimic::Failed> {
    let mut soak = Soak::new(60, 1)?;
    for _ in 0..400 {
        soak.frame().map_err(|fault| format!("frame {}: {fault}", soak.counts.frames))?;
    }
    let Counts { clips_removed, moves, numbers_compared, .. } = soak.counts;
    if clips_removed == 0 || moves < 4 || numbers_compared == 0 {
        return Err(format!("{:?}", soak.counts).into());
    }
    Ok(())
}

/// Runs two crowds of `--members` members for as many minutes as [`FLAG`] says.
pub(crate) fn run() -> ExitCode {
    let (minutes, seed) = (number(FLAG, 60), number("--soak-seed", 1));
    let members = usize::try_from(number("--members", 10_000)).unwrap_or(usize::MAX);
    match soak(minutes, members, seed) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            report(&format!("soak failed, seed {seed}: {fault}\n"));
            ExitCode::FAILURE
        }
    }
}

fn soak(minutes: u64, members: usize, seed: u64) -> Result<(), String> {
    let mut soak = Soak::new(members, seed)?;
    let [first, second] = soak.worlds.each_ref().map(|world| {
        let names: Vec<String> = world.setup.devices.iter().map(ToString::to_string).collect();
        names.join(", then ")
    });
    report(&format!("{members} members on {first}; and on {second}\n"));
    let start = Instant::now();
    let mut first_kib = 0;
    for minute in 1..=minutes {
        let (begun, mut here_kib) = (soak.counts.frames, 0);
        while start.elapsed().as_secs() < 60 * minute {
            soak.frame().map_err(|fault| format!("frame {}: {fault}", soak.counts.frames))?;
            here_kib = here_kib.max(resident_kib());
        }
        let Drift { held_m, planted_m } = soak.drift;
        report(&format!(
            "minute {minute}: {} MiB at most; {:?}; held things {held_m} m off, feet \
             {planted_m} m\n",
            here_kib / 1024,
            soak.counts
        ));
        let is_first = minute == 1 || begun < FIRST_FRAMES;
        if is_first {
            first_kib = here_kib.max(first_kib);
        } else if here_kib as f64 > first_kib as f64 * (1.0 + GROWTH) {
            return Err(format!("{here_kib} KiB of memory, at first {first_kib}"));
        }
    }
    Ok(())
}
