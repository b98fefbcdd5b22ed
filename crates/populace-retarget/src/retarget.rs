//! Conversion of poses from one skeleton to another.

use glam::DQuat;
use populace_clip::{Clip, Local, RowPlace};
use populace_model::{JointIndex, Property, Skeleton, Trs};

use crate::common::{Chain, Common, Soles};

/// Converts poses of a clip's own skeleton to poses of another.
#[derive(Clone, Debug)]
pub struct Retarget {
    /// Number of joints of the clip's own skeleton.
    joint_count: usize,
    /// For each joint of the other skeleton its rest, and where its pose comes from.
    joints: Vec<(Local, Way)>,
}

/// Where a joint's local transform comes from.
#[derive(Clone, Debug)]
enum Way {
    Rest,
    /// The properties that the clip drives come from a joint of its own skeleton.
    Joint(JointIndex, [bool; 3]),
    Chain(Chain),
}

impl Retarget {
    /// Joints follow those of the clip's own skeleton in `columns`.
    pub(crate) fn by_names(
        clip: &Clip,
        skeleton: &Skeleton,
        columns: &[Option<JointIndex>],
    ) -> Self {
        let way = |from| {
            let drives = |property| clip.drives_property(from, property);
            Way::Joint(from, Property::ALL.map(drives))
        };
        let joint = |(joint, from): (JointIndex, &Option<JointIndex>)| {
            (Local::of(skeleton.rest(joint)), from.map_or(Way::Rest, way))
        };
        let joints = skeleton.joints().zip(columns).map(joint).collect();
        Self { joint_count: clip.skeleton().joint_count(), joints }
    }

    pub(crate) fn by_roles(common: &Common<'_>) -> Self {
        let skeleton = common.target.skeleton;
        let joint = |joint: JointIndex| {
            (Local::of(skeleton.rest(joint)), common.chain(joint).map_or(Way::Rest, Way::Chain))
        };
        let joint_count = common.source.skeleton.joint_count();
        Self { joint_count, joints: skeleton.joints().map(joint).collect() }
    }

    /// Number of joints of the poses that are converted.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joint_count
    }

    /// Converts local transforms of all joints of the clip's own skeleton, in level order, to those
    /// of the other.
    ///
    /// # Panics
    ///
    /// If `pose` has fewer than [`joint_count`](Self::joint_count) joints.
    #[must_use]
    pub fn pose(&self, pose: &[Trs]) -> Vec<Trs> {
        let pose: Vec<Local> = pose.iter().map(Local::of).collect();
        self.locals(&pose).iter().map(Local::trs).collect()
    }

    fn locals(&self, pose: &[Local]) -> Vec<Local> {
        let local = |(rest, way): &(Local, Way)| match way {
            Way::Rest => *rest,
            Way::Joint(from, [translation, rotation, scale]) => {
                let from = &pose[from.index()];
                Local {
                    translation: if *translation { from.translation } else { rest.translation },
                    rotation: if *rotation { from.rotation } else { rest.rotation },
                    scale: if *scale { from.scale } else { rest.scale },
                }
            }
            Way::Chain(chain) => chain.local(rest, pose),
        };
        self.joints.iter().map(local).collect()
    }

    /// Returns for each joint and [`Property`] whether it follows the clip.
    fn moves(&self) -> Vec<[bool; 3]> {
        let of = |way: &Way| match way {
            Way::Rest => [false; 3],
            Way::Joint(_, driven) => *driven,
            Way::Chain(chain) => [chain.moves(), true, false],
        };
        self.joints.iter().map(|(_, way)| of(way)).collect()
    }

    /// Converts all poses of a clip, with the roll of the feet.
    pub(crate) fn clip(&self, clip: &Clip, common: &Common<'_>, soles: Option<&Soles<'_>>) -> Clip {
        let feet = soles.and_then(|soles| FootRolls::new(clip, soles));
        let mut moves = self.moves();
        // Toes roll even if the source has none.
        for joint in feet.iter().flat_map(|feet| &feet.joints) {
            moves[joint.index()][Property::Rotation as usize] = true;
        }
        clip.converted(common.target.skeleton, moves, |place, pose| {
            let mut locals = self.locals(pose);
            if let Some(feet) = &feet {
                feet.apply(place, &mut locals);
            }
            locals
        })
    }
}

/// Rolls of feet and toes that keep them above the ground, for each row of a clip.
struct FootRolls {
    joints: Vec<JointIndex>,
    rows: Vec<Vec<DQuat>>,
}

impl FootRolls {
    /// Returns `None` if no foot needs to roll, and for live clips, whose rows are not known.
    fn new(clip: &Clip, soles: &Soles<'_>) -> Option<Self> {
        if clip.ring().is_some() {
            return None;
        }
        let rows: Vec<_> = clip.row_poses(1).map(|pose| soles.rotations(&pose)).collect();
        let rolls = !rows.iter().all(|row| Soles::are_negligible(row));
        rolls.then(|| Self { joints: soles.joints(), rows })
    }

    fn apply(&self, RowPlace { row, between }: RowPlace, locals: &mut [Local]) {
        let next = self.rows.get(row + 1).unwrap_or(&self.rows[row]);
        for ((joint, from), to) in self.joints.iter().zip(&self.rows[row]).zip(next) {
            let roll = from.lerp(*to, between);
            let rotation = &mut locals[joint.index()].rotation;
            *rotation = (*rotation * roll).normalize();
        }
    }
}
