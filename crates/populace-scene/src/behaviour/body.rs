//! A character as behaviours see it: clips by their use, masks, and its ragdoll.

use std::collections::BTreeMap;
use std::sync::Arc;

use populace::model::{Role, RoleMap, Side};
use populace::{CharacterId, ClipId, Crowd, JointIndex, Mask, MaskId};
use populace_physics::{GetUp, RagdollPlan};

use super::grips::Grips;
use crate::Error;
use crate::plan::MaskPlan;

/// The use of a clip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    SitDown,
    Sit,
    StandUp,
    LookIn,
    Talk,
    Listen,
    Phone,
    Text,
    Wave,
    Lean,
    Point,
    Carry,
    Clap,
    Cheer,
    OpenDoor,
    GetIn,
    Drive,
    GetOut,
    Hit,
    Shield,
    Spear,
    Thrust,
}

/// Each use with the key by which scene files name it and the name of its clip.
const USES: [(Use, &str, &str); 22] = [
    (Use::SitDown, "sit_down", "Sit_Down"),
    (Use::Sit, "sit", "Sit"),
    (Use::StandUp, "stand_up", "Stand_Up"),
    (Use::LookIn, "look_in", "Look_In"),
    (Use::Talk, "talk", "Talk"),
    (Use::Listen, "listen", "Talk_Listen"),
    (Use::Phone, "phone", "Phone"),
    (Use::Text, "text", "Text"),
    (Use::Wave, "wave", "Wave"),
    (Use::Lean, "lean", "Lean"),
    (Use::Point, "point", "Point"),
    (Use::Carry, "carry", "Carry"),
    (Use::Clap, "clap", "Clap"),
    (Use::Cheer, "cheer", "Cheer"),
    (Use::OpenDoor, "open_door", "Open_Door"),
    (Use::GetIn, "get_in", "Get_In"),
    (Use::Drive, "drive", "Drive"),
    (Use::GetOut, "get_out", "Get_Out"),
    (Use::Hit, "hit", "Hit"),
    (Use::Shield, "shield", "Shield"),
    (Use::Spear, "spear", "Spear"),
    (Use::Thrust, "thrust", "Spear_Thrust"),
];

/// Returns the keys by which scene files name the uses of clips.
pub(crate) fn use_keys() -> impl Iterator<Item = &'static str> {
    USES.iter().map(|(_, key, _)| *key)
}

/// Returns the name that the clip for a use has unless a scene file says otherwise.
pub(crate) fn clip_name(usage: Use) -> &'static str {
    USES.iter().find(|(other, ..)| *other == usage).map_or("", |(_, _, name)| name)
}

/// A clip and its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UsedClip {
    pub(crate) id: ClipId,
    pub(crate) secs: f32,
}

/// A character as behaviours see it.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) character: CharacterId,
    /// The names of clips that were given, by the keys of their uses.
    names: BTreeMap<String, String>,
    clips: [Option<UsedClip>; USES.len()],
    /// The spine and all above it.
    pub(crate) upper: Option<MaskId>,
    /// The left arm from the shoulder on.
    pub(crate) left_arm: Option<MaskId>,
    /// The right arm from the shoulder on.
    right_arm: Option<MaskId>,
    pub(crate) ragdoll: Arc<RagdollPlan>,
    pub(crate) get_up: GetUp,
    pub(crate) chest: Option<JointIndex>,
    pub(crate) right_hand: Option<JointIndex>,
    pub(crate) grips: Grips,
    pub(crate) can_look: bool,
    /// Height in metres, at scale 1.
    pub(crate) height_m: f32,
}

impl Body {
    /// Finds what a character of a crowd brings. `names` has the names of clips by the keys of
    /// their uses, where they differ from those of the built-in people.
    pub(crate) fn new(
        crowd: &mut Crowd,
        character: CharacterId,
        names: &BTreeMap<String, String>,
    ) -> Result<Self, Error> {
        let asset = Arc::clone(crowd.character(character)?.asset());
        let mut clips = [None; USES.len()];
        for (clip, (_, key, usual)) in clips.iter_mut().zip(USES) {
            let named = names.get(key);
            let found = crowd.clip(character, named.map_or(usual, String::as_str));
            // A clip that is named must be there; the usual ones may be missing.
            let id = if named.is_some() { Some(found?) } else { found.ok() };
            *clip = match id {
                Some(id) => {
                    Some(UsedClip { id, secs: crowd.clip_mut(id)?.asset().duration_secs() })
                }
                None => None,
            };
        }
        let roles = crowd.character(character)?.roles().cloned();
        let joint = |role| roles.as_ref().and_then(|roles: &RoleMap| roles.joint(role));
        let mut mask = |root: Option<JointIndex>| {
            let Some(root) = root else { return Ok::<_, Error>(None) };
            let root = asset.skeleton.name(root);
            let mask = Mask::of_subtrees(&asset.skeleton, [root]).map_err(populace::Error::from)?;
            Ok(Some(crowd.character_mut(character)?.add_mask(&mask)?))
        };
        let upper = mask(joint(Role::Spine))?;
        let left_arm = mask(joint(Role::UpperArm(Side::Left)))?;
        let right_arm = mask(joint(Role::UpperArm(Side::Right)))?;
        let carry = match clip_for(&clips, Use::Carry) {
            Some(carry) => Some(Arc::clone(crowd.clip_mut(carry.id)?.asset())),
            None => None,
        };
        let chest = joint(Role::Chest).or_else(|| joint(Role::Spine));
        Ok(Self {
            character,
            names: names.clone(),
            clips,
            upper,
            left_arm,
            right_arm,
            ragdoll: Arc::new(RagdollPlan::from_skeleton(&asset.skeleton)),
            get_up: GetUp::find(crowd, character),
            chest,
            right_hand: joint(Role::Hand(Side::Right)),
            grips: Grips::new(&asset, roles.as_ref(), carry.as_deref()),
            can_look: joint(Role::Head).is_some(),
            height_m: asset.height_m(),
        })
    }

    /// Returns true for the body of a character whose clips have these names, by the keys of their
    /// uses.
    pub(crate) fn is_of(&self, character: CharacterId, names: &BTreeMap<String, String>) -> bool {
        self.character == character && self.names == *names
    }

    /// Returns the clip for a use, if the character has one.
    pub(crate) fn clip(&self, usage: Use) -> Option<UsedClip> {
        clip_for(&self.clips, usage)
    }

    /// Returns the mask of a part of the body: `None` for the whole of it.
    pub(crate) fn mask(&self, crowd: &Crowd, part: MaskPlan) -> Result<Option<MaskId>, Error> {
        let (mask, name) = match part {
            MaskPlan::WholeBody => return Ok(None),
            MaskPlan::UpperBody => (self.upper, "upper_body"),
            MaskPlan::LeftArm => (self.left_arm, "left_arm"),
            MaskPlan::RightArm => (self.right_arm, "right_arm"),
        };
        if mask.is_none() {
            let character = crowd.character(self.character)?.asset().name.clone();
            return Err(Error::NoSuchPart { character, part: name });
        }
        Ok(mask)
    }

    /// Returns true if the character has clips for all of some uses.
    pub(crate) fn has(&self, uses: &[Use]) -> bool {
        uses.iter().all(|usage| self.clip(*usage).is_some())
    }
}

fn clip_for(clips: &[Option<UsedClip>; USES.len()], usage: Use) -> Option<UsedClip> {
    let at = USES.iter().position(|(other, ..)| *other == usage)?;
    clips[at]
}
