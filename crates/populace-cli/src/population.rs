//! Spawns a crowd's members on the ground, and tracks their positions for the camera.

use std::collections::HashMap;

use populace::clip::RootMotion;
use populace::{ClipPlayback, Crowd, MemberId, Placement};
use populace_random::Rng;
use populace_scene::EYES;
use populace_variety::Appearance;

use crate::camera::Pose;
use crate::failure::Failure;
use crate::people::appearances;
use crate::placement::{Place, places};
use crate::progress::Progress;
use crate::roles::{CrowdRole, RoleClip};
use crate::skin::skinned;

/// Distance between members in units of their width.
const SPACING_FACTOR: f32 = 1.3;

/// A member's placement and motion.
struct PlacedMember {
    id: MemberId,
    placement: Placement,
    /// Heading of the placement.
    yaw_rad: f32,
    /// Root motion of its clip, the factor that scales it, and the starting phase in the clip.
    motion: Option<(RootMotion, f32, f32)>,
    /// Speed at which its clip plays.
    pace: f32,
    height_m: f32,
}

impl PlacedMember {
    /// Returns the member's position and heading at a time.
    fn at(&self, secs: f32) -> ([f32; 3], f32) {
        let (offset, yaw_rad) =
            self.motion.as_ref().map_or(([0.0; 3], 0.0), |(motion, scale, phase)| {
                let (metres, yaw_rad) = motion.looped(*phase, secs * self.pace);
                (metres.map(|metres| metres * scale), yaw_rad)
            });
        let position = self.placement.world_from_model().transform_point(offset);
        (position, self.yaw_rad + yaw_rad)
    }
}

/// The placed members of a crowd.
pub(crate) struct Population {
    members: Vec<PlacedMember>,
    numbers: HashMap<MemberId, usize>,
    height: f32,
    spacing: f32,
}

/// Settings of a population.
pub(crate) struct PopulationSettings<'a> {
    pub(crate) members: u32,
    pub(crate) seed: u64,
    /// Names of nodes with hidden parts.
    pub(crate) hide: &'a [String],
    /// True if all members of a character look like it.
    pub(crate) plain: bool,
}

impl Population {
    /// Spawns members in groups, each with a random clip that fits at a random phase.
    pub(crate) fn new(
        crowd: &mut Crowd,
        roles: &[CrowdRole],
        settings: &PopulationSettings,
    ) -> Result<Self, Failure> {
        let mut random = Rng::from_state(settings.seed);
        let height = roles.iter().map(|r| r.character.height_m() * r.scale).fold(0.0, f32::max);
        let mut spacing: f32 = 0.0;
        for role in roles {
            spacing = spacing.max(footprint_m(crowd, role, settings.hide)? * SPACING_FACTOR);
        }
        let mut places = places(settings.members as usize, spacing, &mut random);
        // From front to back, so that the first members are those that a close picture shows.
        places.sort_by(|a, b| b.position[2].total_cmp(&a.position[2]));
        // Each role once, then at random, so that no pattern shows.
        let chosen = |index: usize, random: &mut Rng| {
            if index < roles.len() { index } else { random.below(roles.len()) }
        };
        let chosen: Vec<usize> =
            (0..places.len()).map(|index| chosen(index, &mut random)).collect();
        let seed = (!settings.plain).then_some(settings.seed);
        let positions: Vec<[f32; 3]> = places.iter().map(|place| place.position).collect();
        let appearances = appearances(roles, &chosen, &positions, seed);
        let mut members = Vec::with_capacity(places.len());
        let mut progress = Progress::new("members", places.len());
        for (index, place) in places.iter().enumerate() {
            let role = &roles[chosen[index]];
            let appearance = appearances.get(index);
            members.push(spawn(crowd, role, place, appearance, &mut random)?);
            progress.step();
        }
        let numbers = members.iter().enumerate().map(|(number, member)| (member.id, number));
        Ok(Self { numbers: numbers.collect(), members, height, spacing })
    }

    /// Returns bounding points of all members at some times in seconds, for the camera.
    pub(crate) fn bounding_points(&self, secs: &[f32]) -> Vec<[f32; 3]> {
        let (height, half) = (self.height, self.spacing / 2.0);
        let around = |[x, _, z]: [f32; 3]| {
            [[x, height, z], [x - half, 0.0, z], [x + half, 0.0, z], [x, 0.0, z + half]]
        };
        self.members
            .iter()
            .flat_map(|member| secs.iter().flat_map(move |secs| around(member.at(*secs).0)))
            .collect()
    }

    /// Returns one of the nearest members, the one that is nearest to the middle.
    pub(crate) fn closest(&self) -> Option<usize> {
        let front = self.members.first().map_or(0.0, |member| member.placement.position()[2]);
        let distance = |member: &PlacedMember| {
            let [x, _, z] = member.placement.position();
            x.abs() + 2.0 * (front - z)
        };
        let numbered = self.members.iter().enumerate();
        numbered.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map(|(number, _)| number)
    }

    /// Returns where a member is at a time.
    pub(crate) fn pose(&self, number: usize, secs: f32) -> Option<Pose> {
        let member = self.members.get(number)?;
        let (position, heading_rad) = member.at(secs);
        Some(Pose { position, heading_rad, eye_m: EYES * member.height_m })
    }

    /// Returns the number of a member, in the order in which they were spawned.
    pub(crate) fn number(&self, member: MemberId) -> Option<usize> {
        self.numbers.get(&member).copied()
    }

    /// Returns the number of members.
    pub(crate) fn len(&self) -> usize {
        self.members.len()
    }

    /// Returns height and half the width of the largest member in metres.
    pub(crate) fn figure_m(&self) -> [f32; 2] {
        [self.height, self.spacing / 2.0]
    }
}

/// Spawns a member that plays one of its role's clips: of those that walk or of those that stand,
/// as its place says, if there are both.
fn spawn(
    crowd: &mut Crowd,
    role: &CrowdRole,
    place: &Place,
    appearance: Option<&Appearance>,
    random: &mut Rng,
) -> Result<PlacedMember, Failure> {
    let (height, pace) = appearance.map_or((1.0, 1.0), |a| (a.height, a.pace));
    let placement = Placement::at(place.position).facing(place.yaw_rad).scaled(role.scale * height);
    let member = crowd.spawn(role.id, placement)?;
    let mut view = crowd.member_mut(member)?;
    if let Some(appearance) = appearance {
        view.set_look(appearance.look);
    }
    let phase = random.unit();
    let fitting: Vec<&RoleClip> =
        role.clips.iter().filter(|clip| clip.motion.is_some() == place.walks).collect();
    let all: Vec<&RoleClip> = role.clips.iter().collect();
    let clips = if fitting.is_empty() { all } else { fitting };
    let mut motion = None;
    if !clips.is_empty() {
        let clip = clips[random.below(clips.len())];
        view.play(clip.id, ClipPlayback::looping().phase(phase).speed(pace))?;
        if clip.motion.is_some() {
            view.start_root_motion()?;
        }
        motion = clip.motion.clone().map(|(motion, scale)| (motion, scale, phase));
    }
    let height_m = role.character.height_m() * role.scale * height;
    Ok(PlacedMember { id: member, placement, yaw_rad: place.yaw_rad, motion, pace, height_m })
}

/// Returns the larger horizontal side of a member's visible parts at the start of its first clip.
/// The rest pose is not used, because many characters rest with their arms spread.
fn footprint_m(crowd: &mut Crowd, role: &CrowdRole, hide: &[String]) -> Result<f32, Failure> {
    let member = crowd.spawn(role.id, Placement::at([0.0; 3]))?;
    if let Some(clip) = role.clips.first() {
        crowd.member_mut(member)?.play(clip.id, ClipPlayback::looping())?;
    }
    crowd.update(0.0)?;
    let palette = crowd.member_mut(member)?.palette()?;
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
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
    let side = (high[0] - low[0]).max(high[2] - low[2]) as f32;
    Ok((side * role.scale).max(1e-3))
}
