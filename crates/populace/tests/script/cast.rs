//! The characters and clips of the script.

use std::sync::Arc;

use populace::MotionSettings;
use populace::character::Character;
use populace::clip::Clip;
use populace::model::{Role, RoleMap, Side};
use populace::{CharacterId, ClipId, Crowd, Error, JointIndex, MemberId, Placement};
use populace_cast::{Look, person};

/// Two built-in people with different skeletons, and their clips.
pub(crate) struct Cast {
    /// On the skeleton of 54 joints.
    pub(crate) man: CharacterId,
    /// On the skeleton of 25 joints.
    pub(crate) child: CharacterId,
    pub(crate) idle: ClipId,
    pub(crate) walk: ClipId,
    pub(crate) run: ClipId,
    /// The walk with root motion.
    pub(crate) walk_on: ClipId,
    roles: RoleMap,
    pub(crate) joints: usize,
}

impl Cast {
    pub(crate) fn new(crowd: &mut Crowd) -> Result<Self, Error> {
        let man: Arc<Character> = Arc::new(person(&Look::man())?);
        let child = crowd.add_character(person(&Look::child())?)?;
        let roles = RoleMap::detect(&man.skeleton).expect("a humanoid");
        let joints = man.skeleton.joint_count();
        let clip: &Clip =
            man.clips.iter().find(|clip| clip.name() == "Walk").expect("a built-in clip");
        let walk_on = Arc::new(clip.with_root_motion(&MotionSettings::default())?);
        let man = crowd.add_character(man)?;
        let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(man, name));
        let walk_on = crowd.character_mut(man)?.add_clip(&walk_on)?;
        Ok(Self { man, child, idle: idle?, walk: walk?, run: run?, walk_on, roles, joints })
    }

    /// The man's joint of a role.
    pub(crate) fn joint(&self, role: Role) -> JointIndex {
        self.roles.joint(role).expect("a joint of a built-in person")
    }

    pub(crate) fn hand(&self) -> JointIndex {
        self.joint(Role::Hand(Side::Left))
    }

    /// `count` men in a row, 1 m apart, each turned by 0.7 radians from the one before.
    pub(crate) fn men(&self, crowd: &mut Crowd, count: usize) -> Result<Vec<MemberId>, Error> {
        let at = |n: usize| Placement::at([n as f32, 0.0, 0.0]).facing(0.7 * n as f32);
        (0..count).map(|n| crowd.spawn(self.man, at(n))).collect()
    }
}
