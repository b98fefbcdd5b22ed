//! The feet of a member in one frame, and whether its clips plant them.

use glam::Vec3;
use populace::model::Side;
use populace::{ActiveClip, Affine, CharacterId, ClipId, Crowd, MemberId};

use crate::feet::Feet;
use crate::strides::Planting;
use crate::{Error, Gait};

/// A clip of a character.
#[derive(Clone, Debug)]
struct KnownClip {
    id: ClipId,
    /// The time on its own axis at which it starts; its gait starts at 0.
    start_secs: f32,
    gait: Gait,
}

/// The feet of a character, and the gaits of its clips.
#[derive(Clone, Debug)]
pub(super) struct Body {
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
    /// Measures the clips that a character has in a crowd. `None` for a body without two feet.
    pub(super) fn new(crowd: &Crowd, id: CharacterId) -> Result<Option<Self>, Error> {
        let view = crowd.character(id)?;
        let character = view.asset();
        let Some(feet) = Feet::find(character) else { return Ok(None) };
        let mut clips = Vec::new();
        for (id, clip) in view.clips() {
            let start_secs = clip.start_secs();
            let gait = Gait::measure(character, &clip)?;
            clips.extend(gait.map(|gait| KnownClip { id, start_secs, gait }));
        }
        Ok(Some(Self { feet, clips }))
    }

    /// Returns the gait of a clip.
    pub(super) fn gait(&self, clip: ClipId) -> Option<&Gait> {
        self.clips.iter().find(|known| known.id == clip).map(|known| &known.gait)
    }

    /// Returns whether the clips that play have each foot in contact.
    fn planted(&self, playing: &[ActiveClip]) -> [bool; 2] {
        [Side::Left, Side::Right].map(|foot| {
            let mut planting = Planting::default();
            for active in playing.iter().filter(|active| active.weight > 0.0) {
                let known = self.clips.iter().find(|known| known.id == active.clip);
                if let Some(KnownClip { start_secs, gait, .. }) = known {
                    let secs = active.time_secs - start_secs;
                    planting.add(gait, foot, secs, active.weight);
                }
            }
            planting.is_planted()
        })
    }

    /// Returns both feet of a member whose joints are at transforms of model space.
    pub(super) fn soles(
        &self,
        crowd: &Crowd,
        member: MemberId,
        model_from_joints: &[Affine],
    ) -> Result<[Sole; 2], Error> {
        let member = crowd.member(member)?;
        let world = member.placement().world_from_model();
        let planted = self.planted(&member.active_clips());
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
