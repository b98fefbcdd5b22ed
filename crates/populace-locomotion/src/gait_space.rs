//! The gaits of a character by speed: which mix of clips goes at a speed, and how fast it steps.

use std::sync::Arc;

use populace::character::Character;
use populace::clip::Clip;
use populace::model::Side;
use populace::{BlendSpace, BlendSpaceId, CharacterId, ClipId, Crowd};

use rayon::prelude::*;

use crate::footing::Landing;
use crate::soles::Treadmill;
use crate::step::Step;
use crate::steps::{Mixes, Row, STANDS, Sample};
use crate::{Contact, Error, Gait, GaitClips, MixedClip};

/// Clips that play at the same time between two samples of a space.
const MIXED_CLIPS: usize = 2;
/// A clip that is slower than this, in body heights per second, does not walk.
const WALKS: f32 = 0.1;
/// By how much outfits of one body differ in height at most, as a fraction of it.
const OUTFITS: f32 = 0.1;

/// The gaits of a character by speed: a blend space from standing over walking to running, measured
/// on that character's body.
#[derive(Clone, Debug)]
pub struct GaitSpace {
    character: CharacterId,
    space: BlendSpaceId,
    samples: Vec<Sample>,
    /// How it steps at speeds, in their order.
    rows: Vec<Row>,
    /// How the feet of mixes touch down, by the mix.
    landings: Vec<(f32, [Landing; 2])>,
    on_the_spot: Step,
    idle_cycles_per_sec: f32,
}

impl GaitSpace {
    /// Measures clips on a character, tells the crowd the contacts of their feet, and adds a blend
    /// space of them. `idle` stands, and `moving` are one or more clips that walk or run forwards,
    /// in any order.
    ///
    /// # Errors
    ///
    /// [`Error::NoGait`] for a body without two feet or a clip whose feet do not walk forwards,
    /// [`Error::SameSpeed`] for two clips of one speed, [`Error::NoClips`] for no moving clip, and
    /// errors of the crowd, such as a clip that does not fit the character.
    pub fn new(
        crowd: &mut Crowd,
        character: CharacterId,
        idle: ClipId,
        moving: &[ClipId],
    ) -> Result<Self, Error> {
        let asset = Arc::clone(crowd.character(character)?.asset());
        let known = crowd.character(character)?.clips();
        let find = |id: &ClipId| {
            let of_character = known.iter().find(|(own, _)| own == id);
            of_character.map(|(_, clip)| Arc::clone(clip)).ok_or(Error::NotItsClip)
        };
        let clips = GaitClips {
            idle: find(&idle)?,
            moving: moving.iter().map(find).collect::<Result<_, _>>()?,
        };
        let Some(mut treadmill) = Treadmill::new(&asset, MIXED_CLIPS)? else {
            let first = clips.moving.first().ok_or(Error::NoClips)?;
            return Err(Error::NoGait { clip: first.name().to_owned() });
        };
        let measured = Measured::new(&mut treadmill, &clips)?;
        let ids: Vec<ClipId> = std::iter::once(idle).chain(moving.iter().copied()).collect();
        measured.tell(crowd, character, &ids)
    }

    /// Chooses among the clips of a character as [`GaitClips::among`] does, and measures them as
    /// [`new`](Self::new) does. A clip that is taken out of its root motion is added to the crowd.
    ///
    /// # Errors
    ///
    /// [`Error::NoGaitClips`] if no clip stands or none moves, and those of [`new`](Self::new).
    pub fn of(crowd: &mut Crowd, character: CharacterId) -> Result<Self, Error> {
        let mut all = Self::of_all(crowd, &[character]);
        all.pop().unwrap_or(Err(Error::NoClips))
    }

    /// Measures several characters as [`of`](Self::of) does one, on all cores. Characters whose
    /// skeletons are equal, soles included, and that have the same clips are measured once, as long
    /// as what they wear makes none a tenth higher than another.
    pub fn of_all(crowd: &mut Crowd, characters: &[CharacterId]) -> Vec<Result<Self, Error>> {
        let bodies: Vec<Result<Body, Error>> =
            characters.iter().map(|character| Body::of(crowd, *character)).collect();
        let same = |nth: usize| {
            let body = bodies[nth].as_ref().ok();
            let first = bodies[..nth].iter().position(|other| {
                body.zip(other.as_ref().ok()).is_some_and(|(body, other)| body.moves_as(other))
            });
            first.unwrap_or(nth)
        };
        let firsts: Vec<usize> = (0..bodies.len()).map(same).collect();
        let measure = |(nth, body): (usize, &Result<Body, Error>)| {
            body.as_ref().ok().filter(|_| firsts[nth] == nth).map(Body::measured)
        };
        let measured: Vec<_> = bodies.par_iter().enumerate().map(measure).collect();
        let all = characters.iter().zip(bodies).zip(firsts);
        all.map(|((character, body), first)| {
            let clips = body?.clips;
            match &measured[first] {
                Some(Ok((chosen, measured))) => {
                    let ids = chosen.ids(crowd, *character, &clips)?;
                    measured.tell(crowd, *character, &ids)
                }
                Some(Err(error)) => Err(error.clone()),
                None => Err(Error::NoClips),
            }
        })
        .collect()
    }

    /// The character that it was measured on.
    #[must_use]
    pub const fn character(&self) -> CharacterId {
        self.character
    }

    /// The blend space: 0 stands, 1 is the slowest clip, 2 the next.
    #[must_use]
    pub const fn space(&self) -> BlendSpaceId {
        self.space
    }

    /// The speeds of the slowest and of the fastest clip, in metres per second at the scale of 1.
    /// Beyond the fastest, strides and cadence both grow with the root of the speed, and strides no
    /// further than legs reach.
    #[must_use]
    pub fn speeds_m_per_sec(&self) -> [f32; 2] {
        let of = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.speed);
        [of(self.samples.first()), of(self.samples.last())]
    }

    /// Returns how a member steps at a speed in metres per second, 0 or more.
    #[must_use]
    pub fn at_speed(&self, speed: f32) -> Step {
        if speed <= STANDS * self.samples[0].speed {
            return Step {
                mix: 0.0,
                cycles_per_sec: self.idle_cycles_per_sec,
                stride_m: 0.0,
                ankle_m: 0.0,
            };
        }
        let above = self.rows.partition_point(|row| row.speed <= speed);
        let (low, high) = match (above.checked_sub(1), self.rows.get(above)) {
            (Some(below), Some(high)) => (&self.rows[below], high),
            (None, _) => (&self.rows[0], &self.rows[0]),
            (Some(last), None) => (&self.rows[last], &self.rows[last]),
        };
        let span = high.speed - low.speed;
        let part = if span > 0.0 { (speed - low.speed) / span } else { 0.0 };
        let mix = |low: f32, high: f32| low + (high - low) * part;
        let stride = match self.rows.get(above) {
            Some(_) => mix(low.stride, high.stride),
            None => low.stride * (speed / low.speed).powf(0.5),
        };
        Step {
            mix: mix(low.mix, high.mix),
            cycles_per_sec: speed / stride,
            stride_m: mix(low.own.sole_m, high.own.sole_m),
            ankle_m: mix(low.own.ankle_m, high.own.ankle_m),
        }
    }

    /// Returns how the feet of a mix touch down; `None` if that is not known.
    pub(crate) fn landings(&self, mix: f32) -> Option<[Landing; 2]> {
        let above = self.landings.partition_point(|(own, _)| *own <= mix);
        let low = self.landings.get(above.saturating_sub(1))?;
        let high = self.landings.get(above).unwrap_or(low);
        let span = high.0 - low.0;
        let part = if span > 0.0 { ((mix - low.0) / span).clamp(0.0, 1.0) } else { 0.0 };
        Some([0, 1].map(|foot: usize| low.1[foot].towards(&high.1[foot], part)))
    }

    /// Returns how a member steps that turns on the spot or finds its stance.
    #[must_use]
    pub const fn on_the_spot(&self) -> Step {
        self.on_the_spot
    }
}

/// A character and its clips, as measured.
struct Body {
    asset: Arc<Character>,
    clips: Vec<(ClipId, Arc<Clip>)>,
}

impl Body {
    fn of(crowd: &Crowd, character: CharacterId) -> Result<Self, Error> {
        let view = crowd.character(character)?;
        Ok(Self { asset: Arc::clone(view.asset()), clips: view.clips() })
    }

    /// Returns true if another has the same gaits.
    fn moves_as(&self, other: &Self) -> bool {
        let mut clips = self.clips.iter().zip(&other.clips);
        self.clips.len() == other.clips.len()
            && clips.all(|((_, own), (_, other))| Arc::ptr_eq(own, other))
            && self.asset.skeleton == other.asset.skeleton
            && self.is_as_high_as(other)
    }

    /// Returns true if heights differ by hair and hats alone, which no foot touches.
    fn is_as_high_as(&self, other: &Self) -> bool {
        let [own, its] = [self, other].map(|body| body.asset.height_m());
        (own - its).abs() <= OUTFITS * own
    }

    /// Chooses among the clips, and measures the choice.
    fn measured(&self) -> Result<(GaitClips, Measured), Error> {
        let clips: Vec<_> = self.clips.iter().map(|(_, clip)| Arc::clone(clip)).collect();
        let no_clips = || Error::NoGaitClips { character: self.asset.name.clone() };
        let mut treadmill = Treadmill::new(&self.asset, MIXED_CLIPS)?.ok_or_else(no_clips)?;
        let chosen = GaitClips::among_on(&mut treadmill, &clips).ok_or_else(no_clips)?;
        let measured = Measured::new(&mut treadmill, &chosen)?;
        Ok((chosen, measured))
    }
}

impl GaitClips {
    /// Returns the ids of the clips for a character that has others too, idle first. Clips that it
    /// does not have are added.
    fn ids(
        &self,
        crowd: &mut Crowd,
        character: CharacterId,
        known: &[(ClipId, Arc<Clip>)],
    ) -> Result<Vec<ClipId>, Error> {
        let mut id_of = |chosen: &Arc<Clip>| {
            let own = known.iter().find(|(_, clip)| Arc::ptr_eq(clip, chosen));
            match own {
                Some((id, _)) => Ok(*id),
                None => Ok::<_, Error>(crowd.character_mut(character)?.add_clip(chosen)?),
            }
        };
        std::iter::once(&self.idle).chain(&self.moving).map(&mut id_of).collect()
    }
}

/// Measurements of clips on a body.
struct Measured {
    /// The clips, idle first and the others by their speeds, each with its gait.
    mixed: Vec<(MixedClip, Gait)>,
    /// The place of each among the clips that were given, idle first.
    given: Vec<usize>,
    samples: Vec<Sample>,
    rows: Vec<Row>,
    on_the_spot: Step,
}

impl Measured {
    /// Measures clips on a body.
    fn new(treadmill: &mut Treadmill, clips: &GaitClips) -> Result<Self, Error> {
        let idle_gait = Gait::on(treadmill, &clips.idle)?;
        let idle_gait = idle_gait.unwrap_or_else(|| standing(&clips.idle));
        let mut gaits = Vec::new();
        for (nth, clip) in clips.moving.iter().enumerate() {
            let gait = Gait::on(treadmill, clip)?;
            let gait = gait.filter(|gait| walks(gait, treadmill.character()));
            let no_gait = || Error::NoGait { clip: clip.name().to_owned() };
            gaits.push((nth + 1, gait.ok_or_else(no_gait)?, clip));
        }
        gaits.sort_by(|a, b| a.1.speed_m_per_sec().total_cmp(&b.1.speed_m_per_sec()));
        let sample = |gait: &Gait| Sample {
            speed: gait.speed_m_per_sec(),
            stride: gait.speed_m_per_sec() * gait.duration_secs,
        };
        let samples: Vec<Sample> = gaits.iter().map(|(_, gait, _)| sample(gait)).collect();
        if samples.windows(2).any(|pair| pair[1].speed < 1.05 * pair[0].speed) {
            return Err(Error::SameSpeed);
        }
        let Some((_, first, _)) = gaits.first() else { return Err(Error::NoClips) };
        // All clips touch down with the left foot at the phase at which the slowest does.
        let lead = left_phase(first);
        let mut given = vec![0];
        let mut mixed = vec![(MixedClip::new(&clips.idle, 1.0), idle_gait)];
        for (nth, gait, clip) in gaits {
            let offset = (left_phase(&gait) - lead).rem_euclid(1.0);
            given.push(nth);
            mixed.push((MixedClip::new(clip, 1.0).with_offset(offset), gait));
        }
        let mut mixes = Mixes::new(treadmill, &mixed, &samples)?;
        let (rows, on_the_spot) = (mixes.rows()?, mixes.on_the_spot()?);
        Ok(Self { mixed, given, samples, rows, on_the_spot })
    }

    /// Tells the crowd the contacts of the clips, whose ids are in the order given, and adds a
    /// blend space of them.
    fn tell(
        &self,
        crowd: &mut Crowd,
        character: CharacterId,
        ids: &[ClipId],
    ) -> Result<GaitSpace, Error> {
        let ids: Vec<ClipId> = self.given.iter().map(|nth| ids[*nth]).collect();
        let gaits = self.mixed.iter().map(|(_, gait)| gait);
        tell_contacts(crowd, character, ids.iter().zip(gaits))?;
        let idle_secs = self.mixed[0].0.clip.duration_secs();
        let landings = self.rows.iter().filter_map(|row| Some((row.mix, row.landings?)));
        let mut landings: Vec<_> = landings.collect();
        landings.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(GaitSpace {
            landings,
            character,
            space: add_space(crowd, &ids, &self.mixed)?,
            samples: self.samples.clone(),
            rows: self.rows.clone(),
            on_the_spot: self.on_the_spot,
            idle_cycles_per_sec: if idle_secs > 0.0 { 1.0 / idle_secs } else { 0.0 },
        })
    }
}

/// Returns the phase in the middle of the left foot's longest contact, 0 to 1.
fn left_phase(gait: &Gait) -> f32 {
    let lasts = |contact: &&Contact| contact.until_secs - contact.from_secs;
    let left = gait.contacts.iter().filter(|contact| contact.foot == Side::Left);
    let longest = left.max_by(|a, b| lasts(a).total_cmp(&lasts(b)));
    longest.map_or(0.0, |c| 0.5 * (c.from_secs + c.until_secs) / gait.duration_secs)
}

/// Returns whether a clip goes forwards.
fn walks(gait: &Gait, body: &Character) -> bool {
    let [x, z] = gait.velocity_m_per_sec;
    z > WALKS * body.height_m() && z > x.abs() && gait.stride_m().is_some()
}

/// Returns the gait of a clip that holds a pose: both feet stand.
fn standing(clip: &Clip) -> Gait {
    let until_secs = clip.duration_secs();
    let contacts =
        [Side::Left, Side::Right].map(|foot| Contact { foot, from_secs: 0.0, until_secs });
    Gait {
        contacts: contacts.to_vec(),
        velocity_m_per_sec: [0.0; 2],
        skate_m_per_sec: 0.0,
        duration_secs: until_secs,
        stance_center_m: [None; 2],
        sole_height_m: [None; 2],
    }
}

/// Adds the blend space of clips in the order of their speeds.
fn add_space(
    crowd: &mut Crowd,
    ids: &[ClipId],
    mixed: &[(MixedClip, Gait)],
) -> Result<BlendSpaceId, Error> {
    let points = ids.iter().copied().zip((0_u16..).map(f32::from));
    let mut space = BlendSpace::line(&points.collect::<Vec<_>>())?;
    for (id, (mixed, _)) in ids.iter().zip(mixed).skip(1) {
        space = space.with_offset(*id, mixed.offset)?;
    }
    Ok(crowd.add_blend_space(space)?)
}

/// Sets the contacts of clips on a character.
fn tell_contacts<'a>(
    crowd: &mut Crowd,
    character: CharacterId,
    clips: impl Iterator<Item = (&'a ClipId, &'a Gait)>,
) -> Result<(), Error> {
    for (id, gait) in clips {
        gait.set_contacts(crowd, character, *id)?;
    }
    Ok(())
}
