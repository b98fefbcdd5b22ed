//! The people who play the agents of a recording.

use populace::Crowd;
use populace::character::Character;
use populace_locomotion::GaitSpace;
use populace_scene::Person;
use populace_testkit::Rng;
use populace_trajectory::{Agent, Kind, Recording};
use populace_variety::Variety;

use crate::failure::Failure;
use crate::roles::{self, CrowdRole};

/// Heights that are equal for all of so many agents are an assumption of the file.
const MEASURED: usize = 3;
/// Characters that are within this part of an agent's height may play it.
const FITS: f32 = 0.1;

/// Settings of a cast.
pub(crate) struct CastSettings {
    pub(crate) seed: u64,
    /// True if all people of a character look like it.
    pub(crate) plain: bool,
    /// Height of everybody in metres, if it was asked for.
    pub(crate) height_m: Option<f32>,
}

/// Returns the gaits of each role. A humanoid without clips that walk gets those of the built-in
/// people.
pub(crate) fn gaits(crowd: &mut Crowd, roles: &[CrowdRole]) -> Result<Vec<GaitSpace>, Failure> {
    roles
        .iter()
        .map(|role| {
            if let Ok(gaits) = GaitSpace::of(crowd, role.id) {
                return Ok(gaits);
            }
            for clip in &roles::built_in_clips("people")? {
                // Clips that do not fit the body add nothing.
                let _ = crowd.character_mut(role.id)?.add_clip(clip);
            }
            let cannot = |error: populace_locomotion::Error| {
                let name = &role.character.name;
                Failure::Input(anyhow::anyhow!("\"{name}\" cannot walk: {error}"))
            };
            GaitSpace::of(crowd, role.id).map_err(cannot)
        })
        .collect()
}

/// Returns a person for each agent.
pub(crate) fn cast(
    recording: &Recording,
    roles: &[CrowdRole],
    settings: &CastSettings,
) -> Vec<Person> {
    let heights: Vec<Option<f32>> = heights(recording, settings.height_m);
    let mut random = Rng::from_state(settings.seed);
    let chosen: Vec<usize> =
        heights.iter().map(|height| role_of_height(roles, *height, &mut random)).collect();
    let places = recording.agents.iter().map(|agent| {
        let at = recording.track(agent).positions.first().copied().unwrap_or_default();
        [at[0], 0.0, -at[1]]
    });
    let members: Vec<_> = chosen.iter().copied().zip(places).collect();
    let appearances = if settings.plain {
        Vec::new()
    } else {
        let characters: Vec<&Character> = roles.iter().map(|role| &*role.character).collect();
        Variety { seed: settings.seed, ..Variety::default() }.appearances(&characters, &members)
    };
    let person = |(agent, role): (usize, &usize)| {
        let role = &roles[*role];
        let appearance = appearances.get(agent);
        let scale = match heights[agent] {
            Some(height_m) => height_m / role.character.height_m().max(1e-3),
            None => role.scale * appearance.map_or(1.0, |appearance| appearance.height),
        };
        Person { character: role.id, scale, look: appearance.map(|appearance| appearance.look) }
    };
    chosen.iter().enumerate().map(person).collect()
}

/// Returns the heights of agents in metres, where they are known.
fn heights(recording: &Recording, asked_m: Option<f32>) -> Vec<Option<f32>> {
    let of = |agent: &Agent| agent.height_m.filter(|_| agent.kind == Kind::Person);
    let known: Vec<f32> = recording.agents.iter().filter_map(of).collect();
    let differ = known.windows(2).any(|pair| pair[0] != pair[1]);
    let measured = differ || known.len() < MEASURED;
    let height = |agent| asked_m.or_else(|| of(agent).filter(|_| measured));
    recording.agents.iter().map(height).collect()
}

/// Returns a role at random among those whose height is near that of an agent; the nearest one if
/// there is none.
fn role_of_height(roles: &[CrowdRole], height_m: Option<f32>, random: &mut Rng) -> usize {
    let Some(height_m) = height_m else { return random.below(roles.len()) };
    let off = |role: &CrowdRole| (role.character.height_m() * role.scale / height_m - 1.0).abs();
    let fitting: Vec<usize> = (0..roles.len()).filter(|nth| off(&roles[*nth]) < FITS).collect();
    if fitting.is_empty() {
        let order = |a: &usize, b: &usize| off(&roles[*a]).total_cmp(&off(&roles[*b]));
        return (0..roles.len()).min_by(order).unwrap_or(0);
    }
    fitting[random.below(fitting.len())]
}

/// Returns the largest number of agents who are there at the same time.
pub(crate) fn peak(spans: impl Iterator<Item = [f64; 2]>) -> usize {
    let mut changes: Vec<(f64, i32)> =
        spans.flat_map(|[from, until]| [(from, 1), (until, -1)]).collect();
    // At equal times, those who come count before those who leave.
    changes.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let counts = changes.iter().scan(0, |count, (_, change)| {
        *count += change;
        Some(*count)
    });
    usize::try_from(counts.max().unwrap_or(0)).unwrap_or(0)
}
