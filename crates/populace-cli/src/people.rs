//! Gaits and looks of the people of any scene.

use populace::Crowd;
use populace::character::Character;
use populace_locomotion::GaitSpace;
use populace_variety::{Appearance, Variety};

use crate::built_in;
use crate::failure::Failure;
use crate::roles::CrowdRole;

/// Height of a person's eyes as a share of its own (Pheasant, "Bodyspace", 1996).
pub(crate) const EYES: f32 = 0.935;

/// Returns the gaits of each role. A humanoid without clips that walk gets those of the built-in
/// people.
pub(crate) fn gaits(crowd: &mut Crowd, roles: &[CrowdRole]) -> Result<Vec<GaitSpace>, Failure> {
    let ids: Vec<_> = roles.iter().map(|role| role.id).collect();
    let own = GaitSpace::of_all(crowd, &ids);
    let or_built_in = |(role, own): (&CrowdRole, Result<GaitSpace, _>)| {
        if let Ok(gaits) = own {
            return Ok(gaits);
        }
        for clip in &built_in::clips("people")? {
            // Clips that do not fit the body add nothing.
            let _ = crowd.character_mut(role.id)?.add_clip(clip);
        }
        let cannot = |error: populace_locomotion::Error| {
            let name = &role.character.name;
            Failure::Input(match error {
                populace_locomotion::Error::NoGaitClips { .. } => anyhow::anyhow!(
                    "\"{name}\" has no clips to walk with: one in which both feet stand, and one \
                     that walks or runs forwards; add some with --clips FILE"
                ),
                error => anyhow::anyhow!("\"{name}\" cannot walk: {error}"),
            })
        };
        GaitSpace::of(crowd, role.id).map_err(cannot)
    };
    roles.iter().zip(own).map(or_built_in).collect()
}

/// Returns how members look, by their roles and places; nothing without a seed.
pub(crate) fn appearances(
    roles: &[CrowdRole],
    chosen: &[usize],
    places: &[[f32; 3]],
    seed: Option<u64>,
) -> Vec<Appearance> {
    let Some(seed) = seed else { return Vec::new() };
    let characters: Vec<&Character> = roles.iter().map(|role| &*role.character).collect();
    let members: Vec<_> = chosen.iter().copied().zip(places.iter().copied()).collect();
    Variety { seed, ..Variety::default() }.appearances(&characters, &members)
}
