//! The choice of clips to walk with.

use std::sync::Arc;

use populace::MotionSettings;
use populace::character::Character;
use populace::clip::Clip;
use populace::model::Side;

use crate::soles::Treadmill;
use crate::{Gait, MixedClip};

/// How fast people walk, in heights of the hips per second, and run, in heights of the body.
const WALK_PACE: f32 = 1.4;
const RUN_PACE: f32 = 1.66;
/// The shares of the cycle in which a foot stands, of people that walk and run.
const WALK: f32 = 0.62;
const RUN: f32 = 0.36;
/// The height of the hips as a fraction of the body's, if they are not known.
const HIPS: f32 = 0.53;
/// Weight of a difference in this share against one in the logarithm of speed.
const SHARE: f32 = 4.0;
/// Speeds of walks and runs, in body heights per second.
const MOVES: (f32, f32) = (0.15, 4.5);
/// Shares of the cycle in which a foot of a walk stands, and of a run.
const WALK_STANDS: (f32, f32) = (0.42, 0.8);
const RUN_STANDS: (f32, f32) = (0.1, 0.6);
/// By how much these shares of the two feet differ at most.
const UNEVEN: f32 = 0.2;
/// How far the middles of the two feet's contacts are from half a cycle apart at most, in cycles.
const OFF_BEAT: f32 = 0.15;
/// The most that soles may slide, as a fraction of the speed.
const SLIDES: f32 = 0.6;
/// The direction of a clip that goes forwards: at most this far aside, as a fraction of the speed.
const ASIDE: f32 = 0.25;
/// Hips of an upright body are at least this high, as a fraction of their height at rest.
const UPRIGHT: f32 = 0.85;
/// A run is at least this much faster than the walk.
const FASTER: f32 = 1.3;
/// A clip that goes no faster than this stands, and one that carries the body along faster than
/// this travels, in body heights per second.
const STANDS: f32 = 0.03;

/// Clips to walk with.
#[derive(Clone, Debug)]
pub struct GaitClips {
    /// A clip that stands.
    pub idle: Arc<Clip>,
    /// Clips that walk or run forwards in place; at least one.
    pub moving: Vec<Arc<Clip>>,
}

/// A clip and what it does on the body.
struct Candidate {
    clip: Arc<Clip>,
    gait: Gait,
    /// The height of the hips at rest, in metres.
    hips_m: f32,
}

impl GaitClips {
    /// Chooses among the character's own clips; see [`among`](Self::among).
    #[must_use]
    pub fn of(character: &Arc<Character>) -> Option<Self> {
        Self::among(character, &character.clips)
    }

    /// Chooses an idle, a walk and a run by their gait on a character's body, upright all. `None`
    /// if no clip stands or none moves.
    ///
    /// - The idle is a clip in which both feet stand throughout. Of several, those with the word
    ///   "idle" in their names are preferred, then the shortest name, then the first.
    /// - Walks and runs go forwards in two even steps. A foot of a walk stands for 42 to 80 % of
    ///   the cycle and that of a run for 10 to 60 %. Those are chosen in which this share and the
    ///   speed are nearest to those of people, and soles slide least: 62 % and 1.4 heights of the
    ///   hips a second, for a run 36 % and 1.66 heights of the body. The run is faster than the
    ///   walk by 30 %. One of the two is enough.
    ///
    /// A clip that carries the body along is returned in place: its root motion is taken out. Clips
    /// that do not fit the body are passed over. Of characters with clips named `Idle` and `Walk`,
    /// only these and `Run` are measured if they fit.
    #[must_use]
    pub fn among(character: &Arc<Character>, clips: &[Arc<Clip>]) -> Option<Self> {
        Self::among_on(&mut Treadmill::new(character, 1).ok()??, clips)
    }

    /// As [`among`](Self::among), on a treadmill.
    pub(crate) fn among_on(treadmill: &mut Treadmill, clips: &[Arc<Clip>]) -> Option<Self> {
        let named = |names: &[&str]| -> Vec<Arc<Clip>> {
            clips.iter().filter(|clip| names.contains(&clip.name())).cloned().collect()
        };
        // A clip may be there twice: with and without root motion.
        let has = |name: &str| clips.iter().any(|clip| clip.name() == name);
        if has("Idle")
            && has("Walk")
            && let Some(chosen) = Self::choose(treadmill, &named(&["Idle", "Walk", "Run"]))
        {
            return Some(chosen);
        }
        Self::choose(treadmill, clips)
    }

    /// Chooses among clips that are all measured.
    fn choose(treadmill: &mut Treadmill, clips: &[Arc<Clip>]) -> Option<Self> {
        let height_m = treadmill.character().height_m();
        let all: Vec<_> = clips.iter().filter_map(|clip| Candidate::new(treadmill, clip)).collect();
        let idle = all.iter().filter(|one| one.stands(height_m)).min_by_key(|one| {
            let name = one.clip.name();
            (!name.to_lowercase().contains("idle"), name.len())
        })?;
        let best = |stands: (f32, f32), least: f32, distance: &dyn Fn(&Candidate) -> f32| {
            let moves = |one: &&Candidate| {
                one.moves(height_m, stands) && one.gait.speed_m_per_sec() >= least
            };
            let fits = all.iter().filter(moves);
            fits.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let walk = best(WALK_STANDS, 0.0, &|one| one.distance(WALK, WALK_PACE * one.hips_m));
        let least = walk.map_or(0.0, |walk| FASTER * walk.gait.speed_m_per_sec());
        let run = best(RUN_STANDS, least, &|one| one.distance(RUN, RUN_PACE * height_m));
        let moving: Vec<_> = walk.into_iter().chain(run).map(|one| Arc::clone(&one.clip)).collect();
        (!moving.is_empty()).then(|| Self { idle: Arc::clone(&idle.clip), moving })
    }
}

impl Candidate {
    /// Measures a clip in place. `None` if it has no gait, or bends down.
    fn new(treadmill: &mut Treadmill, clip: &Arc<Clip>) -> Option<Self> {
        let height_m = treadmill.character().height_m();
        let mut sample =
            |clip: &Arc<Clip>| treadmill.sample(&[MixedClip::new(clip, 1.0)]).ok().flatten();
        let most = STANDS * height_m;
        let mut clip = Arc::clone(clip);
        let mut soles = sample(&clip)?;
        let hips_m = match soles.hips {
            // Taking the motion out leaves the height of the hips.
            Some(hips) if hips.mean_m < UPRIGHT * hips.rest_m => return None,
            Some(hips) => hips.rest_m,
            None => HIPS * height_m,
        };
        if soles.travel.length() > most {
            clip = Arc::new(clip.with_root_motion(&MotionSettings::default()).ok()?);
            soles = sample(&clip).filter(|soles| soles.travel.length() <= most)?;
        }
        Some(Self { clip, gait: Gait::of(&soles)?, hips_m })
    }

    fn stands(&self, height_m: f32) -> bool {
        let still = self.gait.speed_m_per_sec() <= STANDS * height_m;
        still && [Side::Left, Side::Right].iter().all(|foot| self.share(*foot) >= 0.999)
    }

    /// Returns whether it goes forwards in two even steps of a cycle.
    fn moves(&self, height_m: f32, stands: (f32, f32)) -> bool {
        let gait = &self.gait;
        let [x, z] = gait.velocity_m_per_sec;
        let speed = gait.speed_m_per_sec();
        let shares = [Side::Left, Side::Right].map(|foot| self.share(foot));
        let within = |range: (f32, f32), value: f32| value >= range.0 && value <= range.1;
        within(MOVES, speed / height_m)
            && z > 0.0
            && x.abs() <= ASIDE * speed
            && within(stands, gait.contact_share())
            && (shares[0] - shares[1]).abs() <= UNEVEN
            && gait.skate_m_per_sec <= SLIDES * speed
            && self.is_on_beat()
    }

    fn is_on_beat(&self) -> bool {
        let [a, b] = self.gait.contacts.as_slice() else { return false };
        let middle = |contact: &crate::Contact| 0.5 * (contact.from_secs + contact.until_secs);
        let apart = ((middle(b) - middle(a)) / self.gait.duration_secs).rem_euclid(1.0);
        a.foot != b.foot && (apart - 0.5).abs() <= OFF_BEAT
    }

    fn share(&self, foot: Side) -> f32 {
        self.gait.contact_share_of(foot)
    }

    /// Returns how far it is from a share of the cycle in which feet stand and from a speed, and
    /// how much it slides.
    fn distance(&self, share: f32, speed: f32) -> f32 {
        let own = self.gait.speed_m_per_sec();
        let slides = self.gait.skate_m_per_sec / own;
        SHARE * (self.gait.contact_share() - share).abs() + (own / speed).ln().abs() + slides
    }
}
