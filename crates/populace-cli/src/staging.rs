//! A crowd on its ground: who stands where, playing what, and where that takes them.

use populace::clip::RootMotion;
use populace::{Crowd, Placement, Play};

use crate::cast::Role;
use crate::failure::Failure;
use crate::placement::{Random, places};
use crate::progress::Progress;
use crate::skin::skinned;

/// How much further apart members stand than they are wide.
const ELBOW_ROOM: f32 = 1.3;

/// A member and where it goes.
struct Walker {
    placement: Placement,
    /// Root motion of its clip, in parts of that how far it goes, and where in the clip it begins.
    motion: Option<(RootMotion, f32, f32)>,
}

impl Walker {
    /// Where the member is after so many seconds.
    fn after(&self, secs: f32) -> [f32; 3] {
        let way = self.motion.as_ref().map_or([0.0; 3], |(motion, part, phase)| {
            motion.looped(*phase, secs).0.map(|metres| metres * part)
        });
        self.placement.world_from_model().transform_point(way)
    }
}

/// The members of a crowd on their ground.
pub(crate) struct Staging {
    walkers: Vec<Walker>,
    height: f32,
    spacing: f32,
}

/// How a crowd is to be staged.
pub(crate) struct Plan<'a> {
    pub(crate) members: u32,
    pub(crate) seed: u64,
    /// Names of nodes whose parts are not drawn.
    pub(crate) hide: &'a [String],
    /// Out of a hundred members, how many walk away from the camera.
    pub(crate) away_percent: usize,
}

impl Staging {
    /// Spawns members apart from each other, each at its own point of one of its role's clips.
    pub(crate) fn new(crowd: &mut Crowd, roles: &[Role], plan: &Plan) -> Result<Self, Failure> {
        let mut random = Random::new(plan.seed);
        let height = roles.iter().map(|r| r.character.height_m() * r.scale).fold(0.0, f32::max);
        let mut spacing: f32 = 0.0;
        for role in roles {
            spacing = spacing.max(footprint_m(crowd, role, plan.hide)? * ELBOW_ROOM);
        }
        let places = places(plan.members as usize, spacing, &mut random);
        let mut walkers = Vec::with_capacity(places.len());
        let mut progress = Progress::new("members", places.len());
        for (index, &position) in places.iter().enumerate() {
            // By turns while there are few, then by chance, so that no pattern shows.
            let role = &roles[if index < roles.len() { index } else { random.below(roles.len()) }];
            let away =
                if random.below(100) < plan.away_percent { std::f32::consts::PI } else { 0.0 };
            let yaw_rad = away + random.signed() * 0.5;
            let placement = Placement::at(position).facing(yaw_rad).scaled(role.scale);
            let member = crowd.spawn(role.id, placement)?;
            let phase = random.unit();
            let mut motion = None;
            if !role.clips.is_empty() {
                let clip = &role.clips[random.below(role.clips.len())];
                crowd.play(member, clip.id, Play::looping().phase(phase))?;
                motion = clip.motion.clone().map(|(motion, part)| (motion, part, phase));
            }
            crowd.move_by_clips(member, motion.is_some())?;
            walkers.push(Walker { placement, motion });
            progress.step();
        }
        Ok(Self { walkers, height, spacing })
    }

    /// Feet, heads and elbows of all members at two times in seconds, for the camera.
    pub(crate) fn framed(&self, secs: [f32; 2]) -> Vec<[f32; 3]> {
        self.walkers.iter().flat_map(|walker| self.around(walker, secs)).collect()
    }

    /// The same of the member in the middle of the first row.
    pub(crate) fn closest(&self, secs: [f32; 2]) -> Vec<[f32; 3]> {
        let first_row = self.walkers.iter().take(6);
        let middle = first_row.min_by(|a, b| {
            a.placement.position()[0].abs().total_cmp(&b.placement.position()[0].abs())
        });
        middle.into_iter().flat_map(|walker| self.around(walker, secs)).collect()
    }

    fn around(&self, walker: &Walker, secs: [f32; 2]) -> impl Iterator<Item = [f32; 3]> + use<> {
        let (height, half) = (self.height, self.spacing / 2.0);
        secs.map(|secs| walker.after(secs)).into_iter().flat_map(move |[x, _, z]| {
            [[x, height, z], [x - half, 0.0, z], [x + half, 0.0, z], [x, 0.0, z + half]]
        })
    }
}

/// How much ground a member takes: the larger side of what it shows, playing its first clip. Many
/// rest with their arms spread, which says nothing of how they stand, so a member is posed and
/// looked at.
fn footprint_m(crowd: &mut Crowd, role: &Role, hide: &[String]) -> Result<f32, Failure> {
    let member = crowd.spawn(role.id, Placement::at([0.0; 3]))?;
    if let Some(clip) = role.clips.first() {
        crowd.play(member, clip.id, Play::looping())?;
    }
    crowd.update(0.0)?;
    let palette = crowd.palette(member)?;
    crowd.despawn(member)?;
    let shown = role.character.parts.iter().filter(|part| !hide.contains(&part.node_name));
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for part in shown {
        for vertex in 0..part.mesh.positions.len() {
            let at = skinned(part, vertex, &palette);
            low = std::array::from_fn(|axis| low[axis].min(at[axis]));
            high = std::array::from_fn(|axis| high[axis].max(at[axis]));
        }
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "rounding to the nearest f32 is what is wanted"
    )]
    let side = (high[0] - low[0]).max(high[2] - low[2]) as f32;
    Ok((side * role.scale).max(1e-3))
}
