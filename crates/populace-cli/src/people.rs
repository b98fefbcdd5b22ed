//! Gaits and looks of the people of any scene.

use glam::Vec3;
use populace::character::Character;
use populace::model::Role;
use populace::{Affine, BackendError, Crowd, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::EYES;
use populace_variety::{Appearance, Variety};

use crate::built_in;
use crate::failure::Failure;
use crate::roles::CrowdRole;

/// Returns where somebody's eyes are after the last update, in metres of world space; `None` for
/// who has no head, and before the first update.
pub(crate) fn eyes(crowd: &mut Crowd, member: MemberId) -> Result<Option<Vec3>, populace::Error> {
    let view = crowd.member(member)?;
    let (Some(head), placement) = (view.joint(Role::Head), view.placement()) else {
        return Ok(None);
    };
    let asset = crowd.character(view.character())?.asset();
    let [_, rest_m, _] = asset.skeleton.in_bind_pose().rest_model(head).origin();
    let above_m = (EYES * asset.height_m() - rest_m) * placement.scale();
    let mut models = [Affine::IDENTITY];
    match crowd.read_joints(&[(member, head)], &mut models) {
        Err(populace::Error::Backend(BackendError::NotEvaluated)) => Ok(None),
        read => {
            read?;
            let at = placement.world_from_model().transform_point(models[0].origin());
            Ok(Some(Vec3::from(at) + above_m * Vec3::Y))
        }
    }
}

/// Returns the gaits of each role, or why it cannot walk. A humanoid without clips that walk gets
/// those of the built-in people. `source` is where users name files with more clips.
pub(crate) fn gaits(
    crowd: &mut Crowd,
    roles: &[CrowdRole],
    source: &str,
) -> Result<Vec<Result<GaitSpace, anyhow::Error>>, Failure> {
    let ids: Vec<_> = roles.iter().map(|role| role.id).collect();
    let own = GaitSpace::of_all(crowd, &ids);
    let or_built_in = |(role, own): (&CrowdRole, Result<GaitSpace, _>)| {
        if let Ok(gaits) = own {
            return Ok(Ok(gaits));
        }
        for clip in &built_in::clips("people")? {
            // Clips that do not fit the body add nothing.
            let _ = crowd.character_mut(role.id)?.add_clip(clip);
        }
        let name = &role.character.name;
        let cure = if crowd.character(role.id)?.roles().is_some() {
            format!("add some with {source}")
        } else {
            "its joints have no names that are known, so that clips of other rigs do not fit it: \
             name them as in a known rig, such as Mixamo's, or take clips that were made for it"
                .to_owned()
        };
        Ok(GaitSpace::of(crowd, role.id).map_err(|error| match error {
            populace_locomotion::Error::NoGaitClips { .. } => anyhow::anyhow!(
                "\"{name}\" has no clips to walk with: one in which both feet stand, and one \
                 that walks or runs forwards; {cure}"
            ),
            error => anyhow::anyhow!("\"{name}\" cannot walk: {error}"),
        }))
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use populace::{ClipPlayback, Device, JointIndex, Placement, Trs};
    use populace_cast::Look;

    use super::*;

    #[test]
    fn eyes_go_down_with_who_sits_and_along_with_who_is_carried() {
        let mut crowd = Crowd::builder().device(Device::Native { threads: 1 }).build().unwrap();
        let man = Arc::new(populace_cast::person(&Look::man()).unwrap());
        let standing_m = EYES * man.height_m();
        let man = crowd.add_character(man).unwrap();
        let [stands, sits, rides] =
            [0.0, 1.0, 2.0].map(|x| crowd.spawn(man, Placement::at([x, 0.0, 0.0])).unwrap());
        assert_eq!(eyes(&mut crowd, stands).unwrap(), None);
        let sit = crowd.clip(man, "Sit").unwrap();
        crowd.member_mut(sits).unwrap().play(sit, ClipPlayback::looping()).unwrap();
        let offset = Trs { translation: [5.0, 0.5, 0.0], ..Trs::IDENTITY };
        let mut member = crowd.member_mut(rides).unwrap();
        member.attach_to(stands, JointIndex(0), offset).unwrap();
        crowd.update(0.0).unwrap();
        let [stand, sit, ride] =
            [stands, sits, rides].map(|member| eyes(&mut crowd, member).unwrap().unwrap());
        assert!(stand.distance(Vec3::Y * standing_m) < 0.1, "{stand}");
        assert!((sit.x - 1.0).abs() < 0.1 && sit.y < standing_m - 0.3, "{sit}");
        assert!(ride.x > 4.0 && ride.y > standing_m + 0.3, "{ride}");
    }
}
