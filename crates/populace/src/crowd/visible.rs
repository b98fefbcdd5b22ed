//! The list of members to draw, for renderers of your own.

use populace_device::layout::PAGE_ENTRIES;
use populace_device::{MemberLook, Visibility};
use populace_model::Affine;
use populace_settings::parts::Parts as _;

use super::Crowd;
use crate::{CharacterId, MemberId};

/// A member to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleMember {
    /// Its handle.
    pub member: MemberId,
    /// Its character.
    pub character: CharacterId,
    /// Its level of detail: 0 for the character's own meshes, else one more than the index of its
    /// [`levels`](populace_character::Character::levels).
    pub level: u32,
    /// The part of the view that it takes; never [`Visibility::Hidden`].
    pub visibility: Visibility,
    /// Its first palette entry: page times [`PAGE_ENTRIES`] plus the index within the page.
    pub palette_first: u32,
    /// Its placement in the world.
    pub world_from_model: Affine,
    /// Offset in world space, in metres, by which root motion has taken it from its placement.
    /// Palettes hold it already.
    pub moved: [f32; 3],
    /// Its tints, and the options of its character that it does not show.
    pub look: MemberLook,
    /// Centre in world space of the sphere around all its poses, in metres; see
    /// [`bounding_sphere`](crate::MemberRef::bounding_sphere), also for root motion.
    pub center: [f32; 3],
    /// Radius of that sphere, in metres.
    pub radius_m: f32,
}

impl Crowd {
    /// Fills `list` with all members that were present at the last update and not hidden by it, and
    /// keeps its allocation. Without a [view](Self::view) they are in full detail. Before the first
    /// update all members are listed, although they have no palettes yet.
    ///
    /// The list is sorted by character, palette page and level, so that each of its runs is one
    /// instanced draw. In a run, members keep the order of [`members`](Self::members).
    pub fn visible_members(&self, list: &mut Vec<VisibleMember>) {
        list.clear();
        list.extend(self.members().filter_map(|member| {
            let instance = member.instance();
            if instance.visibility == Visibility::Hidden {
                return None;
            }
            let (center, radius_m) = member.bounding_sphere();
            Some(VisibleMember {
                member: member.id(),
                character: member.character(),
                level: instance.level,
                visibility: instance.visibility,
                palette_first: instance.palette_first,
                world_from_model: instance.world_from_model,
                moved: instance.moved,
                look: instance.look,
                center,
                radius_m,
            })
        }));
        list.sort_by_key(|visible| {
            let (character, page, level) = visible.run();
            (character.parts().index, page, level)
        });
    }
}

impl VisibleMember {
    /// The key of an instanced draw: character, palette page and level of detail. Split the list
    /// by it with [`slice::chunk_by`].
    #[must_use]
    pub const fn run(&self) -> (CharacterId, u32, u32) {
        (self.character, self.palette_first / PAGE_ENTRIES, self.level)
    }
}
