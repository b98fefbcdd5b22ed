//! The feet of a member in one frame, and whether its clips plant them.

use glam::Vec3;
use populace::model::Side;
use populace::{ActiveClip, Affine, CharacterId, ClipId, Crowd, MemberId};

use crate::feet::Feet;
use crate::strides::Planting;
use crate::{Error, Gait};

/// A clip of a character that has played.
#[derive(Clone, Debug)]
struct KnownClip {
    id: ClipId,
    /// The time on its own axis at which it starts; its gait starts at 0.
    start_secs: f32,
    /// `None` for a clip whose feet never stand.
    gait: Option<Gait>,
}

/// The feet of a character, and the gaits of the clips that it has played.
#[derive(Clone, Debug)]
pub(super) struct Body {
    id: CharacterId,
    pub(super) feet: Feet,
    clips: Vec<KnownClip>,
}

/// A foot in one frame.
#[derive(Clone, Debug)]
pub(super) struct Sole {
    pub(super) planted: bool,
    /// The ankle in model space.
    pub(super) ankle: Vec3,
    /// The points of the sole in model space and in the world.
    pub(super) points: Vec<Vec3>,
    pub(super) in_world: Vec<Vec3>,
}

impl Sole {
    /// The index of the point that stands.
    pub(super) fn lowest(&self) -> usize {
        let points = &self.in_world;
        let order = |a: &usize, b: &usize| points[*a].y.total_cmp(&points[*b].y);
        (0..points.len()).min_by(order).unwrap_or(0)
    }

    /// Returns the distance in metres, along X and Z, that the point which stood covered until
    /// `now`; `None` unless the foot is planted in both frames.
    pub(super) fn slid_m(&self, now: &Self) -> Option<f32> {
        let point = self.lowest();
        let moved = *now.in_world.get(point)? - *self.in_world.get(point)?;
        (self.planted && now.planted).then(|| moved.x.hypot(moved.z))
    }
}

impl Body {
    /// Finds the feet of a character of a crowd. `None` for a body without two feet.
    pub(super) fn new(crowd: &Crowd, id: CharacterId) -> Result<Option<Self>, Error> {
        let feet = Feet::find(crowd.character(id)?.asset());
        Ok(feet.map(|feet| Self { id, feet, clips: Vec::new() }))
    }

    /// Returns the gait of a clip, which is measured when it is first asked for.
    pub(super) fn gait(&mut self, crowd: &Crowd, clip: ClipId) -> Result<Option<&Gait>, Error> {
        let index = self.known(crowd, clip)?;
        Ok(self.clips[index].gait.as_ref())
    }

    fn known(&mut self, crowd: &Crowd, clip: ClipId) -> Result<usize, Error> {
        if let Some(index) = self.clips.iter().position(|known| known.id == clip) {
            return Ok(index);
        }
        let view = crowd.character(self.id)?;
        let found = view.clips().into_iter().find(|(id, _)| *id == clip);
        let (start_secs, gait) = match found {
            Some((_, clip)) => (clip.start_secs(), Gait::measure(view.asset(), &clip)?),
            None => (0.0, None),
        };
        self.clips.push(KnownClip { id: clip, start_secs, gait });
        Ok(self.clips.len() - 1)
    }

    /// Returns whether the clips that play have each foot in contact.
    fn planted(&mut self, crowd: &Crowd, playing: &[ActiveClip]) -> Result<[bool; 2], Error> {
        let mut plantings = [Planting::default(); 2];
        for active in playing.iter().filter(|active| active.weight > 0.0) {
            let index = self.known(crowd, active.clip)?;
            let KnownClip { start_secs, gait, .. } = &self.clips[index];
            let Some(gait) = gait else { continue };
            let secs = active.time_secs - start_secs;
            for (planting, foot) in plantings.iter_mut().zip([Side::Left, Side::Right]) {
                planting.add(gait, foot, secs, active.weight);
            }
        }
        Ok(plantings.map(Planting::is_planted))
    }

    /// Returns both feet of a member whose joints are at transforms of model space.
    pub(super) fn soles(
        &mut self,
        crowd: &Crowd,
        member: MemberId,
        model_from_joints: &[Affine],
    ) -> Result<[Sole; 2], Error> {
        let member = crowd.member(member)?;
        let world = member.placement().world_from_model();
        let planted = self.planted(crowd, &member.active_clips())?;
        Ok([0, 1].map(|nth: usize| {
            let foot = &self.feet.feet[nth];
            let place = |point: &crate::feet::Carried| point.place(model_from_joints);
            let points: Vec<Vec3> = foot.sole.iter().map(place).collect();
            let in_world =
                points.iter().map(|at| Vec3::from(world.transform_point((*at).into()))).collect();
            Sole { planted: planted[nth], ankle: place(&foot.ankle), points, in_world }
        }))
    }
}
