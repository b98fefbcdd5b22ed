//! A crowd with ragdolls that is stepped frame by frame.
#![allow(dead_code, reason = "each test binary uses a part of this module")]

use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::model::{Affine, JointSource, Skeleton, Trs};
use populace::{
    CharacterId, ClipPlayback, Crowd, CrowdBuilder, Device, JointIndex, MemberId, Placement,
};
use populace_physics::{JointAngles, Limits, RagdollPlan, Ragdolls};

pub(crate) const DT: f32 = 1.0 / 60.0;
pub(crate) const GRAVITY: [f32; 3] = [0.0, -9.81, 0.0];

/// A crowd with one member, its ragdoll plan, and the ragdolls.
pub(crate) struct Scene {
    pub(crate) crowd: Crowd,
    pub(crate) ragdolls: Ragdolls,
    pub(crate) plan: Arc<RagdollPlan>,
    pub(crate) character: CharacterId,
    pub(crate) member: MemberId,
}

impl Scene {
    /// Spawns one member that plays `clip` from phase 0.2, and updates once.
    pub(crate) fn new(character: Character, clip: Option<&str>, placement: Placement) -> Self {
        let builder = Crowd::builder().device(Device::native());
        Self::built(builder, character, clip, placement)
    }

    fn built(
        builder: CrowdBuilder,
        character: Character,
        clip: Option<&str>,
        placement: Placement,
    ) -> Self {
        let mut crowd = builder.capacity(8).build().unwrap();
        let character = crowd.add_character(character).unwrap();
        let member = crowd.spawn(character, placement).unwrap();
        if let Some(clip) = clip {
            let clip = crowd.clip(character, clip).unwrap();
            crowd
                .member_mut(member)
                .unwrap()
                .play(clip, ClipPlayback::looping().phase(0.2))
                .unwrap();
        }
        let plan = Arc::new(RagdollPlan::from_skeleton(
            &crowd.character(character).unwrap().asset().skeleton,
        ));
        let mut scene =
            Self { crowd, ragdolls: Ragdolls::new(GRAVITY).unwrap(), plan, character, member };
        scene.crowd.update(0.3).unwrap();
        scene
    }

    /// Spawns the built-in man with his full rig, walking.
    pub(crate) fn walking_man() -> Self {
        Self::walking_man_on(Crowd::builder().device(Device::native()))
    }

    pub(crate) fn walking_man_on(builder: CrowdBuilder) -> Self {
        let man = populace_cast::person(&populace_cast::Look::man()).unwrap();
        Self::built(builder, man, Some("Walk"), Placement::at([2.0, 0.0, -1.0]).facing(0.7))
    }

    pub(crate) fn frame(&mut self) {
        self.ragdolls.step(&mut self.crowd, DT).unwrap();
        self.crowd.update(DT).unwrap();
    }

    pub(crate) fn frames(&mut self, count: usize) {
        for _ in 0..count {
            self.frame();
        }
    }

    pub(crate) fn go_limp(&mut self) {
        self.ragdolls.go_limp(&self.crowd, self.member, &self.plan).unwrap();
    }

    pub(crate) fn skeleton(&self) -> &Skeleton {
        &self.crowd.character(self.character).unwrap().asset().skeleton
    }

    pub(crate) fn joint(&self, name: &str) -> JointIndex {
        self.skeleton().find(name).unwrap()
    }

    pub(crate) fn joints(&mut self) -> Vec<Affine> {
        self.crowd.member_mut(self.member).unwrap().model_from_joints().unwrap()
    }

    /// Returns the positions of all joints in world space.
    pub(crate) fn positions(&mut self) -> Vec<[f32; 3]> {
        let world_from_model =
            self.crowd.member(self.member).unwrap().placement().world_from_model();
        self.joints().iter().map(|m| world_from_model.mul(m).transform_point([0.0; 3])).collect()
    }

    pub(crate) fn position(&mut self, joint: JointIndex) -> [f32; 3] {
        self.positions()[joint.index()]
    }
}

pub(crate) fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn length(a: [f32; 3]) -> f32 {
    a.iter().map(|v| v * v).sum::<f32>().powf(0.5)
}

/// Returns by how much joint angles exceed their limits in radians; negative if they are within.
pub(crate) fn beyond_limits(angles: &JointAngles) -> f32 {
    match angles.limits {
        Limits::Hinge { min_rad, max_rad } => {
            (angles.twist_rad - max_rad).max(min_rad - angles.twist_rad).max(angles.swing_rad)
        }
        Limits::Cone { swing_rad, twist_rad: [least, most] } => (angles.swing_rad - swing_rad)
            .max(angles.twist_rad - most)
            .max(least - angles.twist_rad),
        _ => unreachable!(),
    }
}

/// Returns a character whose joints form a chain, with the translations in `steps`.
pub(crate) fn chain(steps: &[[f32; 3]]) -> Character {
    let joint = |(index, step): (usize, &[f32; 3])| JointSource {
        name: format!("joint {index}"),
        parent: index.checked_sub(1),
        rest: Trs { translation: *step, ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&steps.iter().enumerate().map(joint).collect::<Vec<_>>()).unwrap();
    let palette = vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }];
    let (name, nothing) = ("chain".into(), || vec![]);
    let (materials, images, skins, clips) = (vec![], vec![], vec![], vec![]);
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts: nothing(),
        materials,
        images,
        skins,
        clips,
    })
    .unwrap()
}
