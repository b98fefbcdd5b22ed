//! Spawns a crowd's members on the ground, and tracks their positions for the camera.

use populace::clip::RootMotion;
use populace::{ClipPlayback, Crowd, Placement};
use populace_testkit::Rng;

use crate::failure::Failure;
use crate::placement::positions;
use crate::progress::Progress;
use crate::roles::CrowdRole;
use crate::skin::skinned;

/// Distance between members in units of their width.
const SPACING_FACTOR: f32 = 1.3;

/// A member's placement and motion.
struct PlacedMember {
    placement: Placement,
    /// Root motion of its clip, the factor that scales it, and the starting phase in the clip.
    motion: Option<(RootMotion, f32, f32)>,
}

impl PlacedMember {
    /// Returns the member's position at a time.
    fn position_at(&self, secs: f32) -> [f32; 3] {
        let offset = self.motion.as_ref().map_or([0.0; 3], |(motion, scale, phase)| {
            motion.looped(*phase, secs).0.map(|metres| metres * scale)
        });
        self.placement.world_from_model().transform_point(offset)
    }
}

/// The placed members of a crowd.
pub(crate) struct Population {
    members: Vec<PlacedMember>,
    height: f32,
    spacing: f32,
}

/// Settings of a population.
pub(crate) struct PopulationSettings<'a> {
    pub(crate) members: u32,
    pub(crate) seed: u64,
    /// Names of nodes with hidden parts.
    pub(crate) hide: &'a [String],
    /// Percentage of members that face away from the camera.
    pub(crate) away_percent: usize,
}

impl Population {
    /// Spawns members apart from each other, each with a random clip of its role at a random phase.
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
        let positions = positions(settings.members as usize, spacing, &mut random);
        let mut members = Vec::with_capacity(positions.len());
        let mut progress = Progress::new("members", positions.len());
        for (index, &position) in positions.iter().enumerate() {
            // Each role once, then at random, so that no pattern shows.
            let role = &roles[if index < roles.len() { index } else { random.below(roles.len()) }];
            let away =
                if random.below(100) < settings.away_percent { std::f32::consts::PI } else { 0.0 };
            let yaw_rad = away + random.signed() * 0.5;
            let placement = Placement::at(position).facing(yaw_rad).scaled(role.scale);
            let member = crowd.spawn(role.id, placement)?;
            let phase = random.unit();
            let mut motion = None;
            if !role.clips.is_empty() {
                let clip = &role.clips[random.below(role.clips.len())];
                let mut view = crowd.member_mut(member)?;
                view.play(clip.id, ClipPlayback::looping().phase(phase))?;
                if clip.motion.is_some() {
                    view.start_root_motion()?;
                }
                motion = clip.motion.clone().map(|(motion, scale)| (motion, scale, phase));
            }
            members.push(PlacedMember { placement, motion });
            progress.step();
        }
        Ok(Self { members, height, spacing })
    }

    /// Returns bounding points of all members at two times in seconds, for the camera.
    pub(crate) fn bounding_points(&self, secs: [f32; 2]) -> Vec<[f32; 3]> {
        self.members.iter().flat_map(|member| self.around(member, secs)).collect()
    }

    /// Returns bounding points of the member in the middle of the first row.
    pub(crate) fn closest_bounding_points(&self, secs: [f32; 2]) -> Vec<[f32; 3]> {
        let first_row = self.members.iter().take(6);
        let middle = first_row.min_by(|a, b| {
            a.placement.position()[0].abs().total_cmp(&b.placement.position()[0].abs())
        });
        middle.into_iter().flat_map(|member| self.around(member, secs)).collect()
    }

    fn around(
        &self,
        member: &PlacedMember,
        secs: [f32; 2],
    ) -> impl Iterator<Item = [f32; 3]> + use<> {
        let (height, half) = (self.height, self.spacing / 2.0);
        secs.map(|secs| member.position_at(secs)).into_iter().flat_map(move |[x, _, z]| {
            [[x, height, z], [x - half, 0.0, z], [x + half, 0.0, z], [x, 0.0, z + half]]
        })
    }
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
