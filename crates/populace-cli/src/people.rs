//! Gaits of the people of any scene.

use populace::Crowd;
use populace_locomotion::GaitSpace;

use crate::failure::Failure;
use crate::roles::{self, CrowdRole};

/// Returns the gaits of each role. A humanoid without clips that walk gets those of the built-in
/// people.
pub(crate) fn gaits(crowd: &mut Crowd, roles: &[CrowdRole]) -> Result<Vec<GaitSpace>, Failure> {
    let ids: Vec<_> = roles.iter().map(|role| role.id).collect();
    let own = GaitSpace::of_all(crowd, &ids);
    let or_built_in = |(role, own): (&CrowdRole, Result<GaitSpace, _>)| {
        if let Ok(gaits) = own {
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
    };
    roles.iter().zip(own).map(or_built_in).collect()
}
