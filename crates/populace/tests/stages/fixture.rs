//! A character with more than one block of joints, a crowd of it, and a user stage in Rust and in
//! OpenCL C.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::model::math::quat;
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{
    Affine, After, CharacterId, ClipPlayback, Crowd, Device, Devices, JointIndex, MemberId,
    MemberMut, Placement, Schedule, Split, StageId, StageJoint, Trs, UserStage,
};

/// Joints of the character. Joint 2 has three children, so that there are several branches.
pub(crate) const JOINTS: usize = 21;
/// Members of the crowd.
pub(crate) const MEMBERS: usize = 6;

/// Text of the stage in OpenCL C. Most tests add it twice, so that they use one program, which is
/// built once. A member's third value chooses what it does.
pub(crate) const TEXT: &str = "
static float4 product(float4 a, float4 b)
{
    return (float4)(a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                    a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                    a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
                    a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}

static void bend(StageJoint *joint)
{
    joint->rotation = product(joint->rotation, vload4(0, joint->parameters));
    joint->translation.y += joint->values.x;
    joint->scale.z *= joint->parameters[4];
}

static void lift(StageJoint *joint)
{
    stage_rotate(joint, vload4(0, joint->parameters));
    joint->row1.w += joint->parameters[4] + joint->values.y;
}

static void report(StageJoint *joint)
{
    const float4 east = stage_to_model(joint, (float4)(1.0f, 0.0f, 0.0f, 0.0f));
    joint->row0 = (float4)(joint->place.x, joint->place.w, joint->facing.x, joint->facing.y);
    joint->row1 = (float4)(stage_phase(joint, 0.7f), joint->elapsed_secs, east.x, east.z);
    joint->row2 = (float4)(joint->joint, joint->member, joint->values.w, joint->parameters[15]);
}

static void divide(StageJoint *joint)
{
    const float quotient = joint->values.x / joint->values.y;
    joint->translation.x = joint->row0.x = quotient;
    joint->rotation.w = joint->row1.w = quotient;
}

void act(StageJoint *joint)
{
    const int action = (int)joint->values.z;
    if (action == 0) bend(joint);
    if (action == 1) lift(joint);
    if (action == 2) report(joint);
    if (action == 3) divide(joint);
}
";

fn bend(joint: &mut StageJoint) {
    let p = joint.parameters;
    joint.local.rotation = quat::mul(joint.local.rotation, [p[0], p[1], p[2], p[3]]);
    joint.local.translation[1] += joint.values[0];
    joint.local.scale[2] *= p[4];
}

fn lift(joint: &mut StageJoint) {
    let p = joint.parameters;
    joint.rotate([p[0], p[1], p[2], p[3]]);
    joint.model.rows[1][3] += p[4] + joint.values[1];
}

fn report(joint: &mut StageJoint) {
    let ([x, _, _], [sin, cos]) = (joint.place.position, joint.place.sin_cos);
    let east = joint.to_model([1.0, 0.0, 0.0]);
    joint.model.rows = [
        [x, joint.place.scale, sin, cos],
        [joint.phase(0.7), joint.elapsed_secs, east[0], east[2]],
        [joint.joint.0 as f32, joint.member as f32, joint.values[3], joint.parameters[15]],
    ];
}

fn divide(joint: &mut StageJoint) {
    let quotient = joint.values[0] / joint.values[1];
    (joint.local.translation[0], joint.model.rows[0][0]) = (quotient, quotient);
    (joint.local.rotation[3], joint.model.rows[1][3]) = (quotient, quotient);
}

fn act(joint: &mut StageJoint) {
    let action = joint.values[2];
    for (own, function) in
        [(BEND, bend as fn(&mut StageJoint)), (LIFT, lift), (REPORT, report), (DIVIDE, divide)]
    {
        if action == own {
            function(joint);
        }
    }
}

/// After [`After::Pose`](populace::After::Pose): rotates, moves and scales joints.
pub(crate) const BEND: f32 = 0.0;
/// After [`After::Transform`](populace::After::Transform): rotates and lifts joints.
pub(crate) const LIFT: f32 = 1.0;
/// Writes the stage's inputs into a joint's matrix.
pub(crate) const REPORT: f32 = 2.0;
/// Writes the quotient of the first two values into a joint, which may not be finite.
pub(crate) const DIVIDE: f32 = 3.0;

/// The stage, in Rust and in OpenCL C.
pub(crate) fn stage() -> UserStage {
    UserStage::new("act").opencl_c(TEXT).rust(act)
}

pub(crate) fn skeleton() -> Skeleton {
    let joint = |index: usize| JointSource {
        name: format!("joint{index}"),
        parent: match index {
            0 => None,
            5 | 11 => Some(2),
            _ => Some(index - 1),
        },
        rest: Trs {
            translation: [0.05 * (index % 3) as f32, 0.1, 0.02],
            rotation: quat::normalize_or([0.1, 0.2, index as f32 * 0.02, 1.0], quat::identity()),
            scale: [1.0, 1.0 + 0.01 * index as f32, 1.0],
        },
    };
    Skeleton::new(&(0..JOINTS).map(joint).collect::<Vec<_>>()).expect("valid joints")
}

fn character() -> Character {
    let skeleton = skeleton();
    let turns =
        [[0.0, 0.0, 0.0, 1.0], [0.3, 0.1, -0.2, 0.9], [-0.1, 0.4, 0.0, 0.9], [0.0, 0.0, 0.0, 1.0]];
    let values = turns.into_iter().flat_map(|turn| quat::normalize_or(turn, quat::identity()));
    let values: Vec<f32> = values.collect();
    let track = |index: usize| Track {
        joint: format!("joint{index}"),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.4, 0.8, 1.2],
        values: values.clone(),
    };
    let source =
        ClipSource { name: "sway".into(), tracks: (0..JOINTS).step_by(2).map(track).collect() };
    let clips = vec![Arc::new(Clip::new(source, &skeleton).expect("a good clip"))];
    let palette =
        skeleton.joints().map(|joint| PaletteEntry { joint, joint_from_bind: Affine::IDENTITY });
    Character::new(CharacterSource {
        name: "body".into(),
        palette: palette.collect(),
        skeleton,
        parts: vec![],
        materials: vec![],
        images: vec![],
        skins: vec![],
        clips,
    })
    .expect("a good character")
}

/// A crowd of swaying members, each with a different phase.
pub(crate) struct Scene {
    pub(crate) crowd: Crowd,
    pub(crate) members: Vec<MemberId>,
}

impl Scene {
    pub(crate) fn on(devices: impl Into<Devices>, schedule: Schedule) -> Self {
        let devices = devices.into();
        let shares = vec![1.0; devices.as_slice().len()];
        let builder =
            Crowd::builder().devices(devices).split(Split::Fixed(shares)).schedule(schedule);
        let mut crowd = builder.capacity(16).build().expect("a crowd");
        let body: CharacterId = crowd.add_character(character()).expect("enough capacity");
        let clip = crowd.clip(body, "sway").expect("a clip of that name");
        let mut member = |nth: usize| {
            let placement = Placement::at([nth as f32, 0.0, 2.0]).facing(0.3 * nth as f32);
            let member = crowd.spawn(body, placement).expect("enough capacity");
            crowd
                .member_mut(member)
                .expect("a clip that plays")
                .play(clip, ClipPlayback::looping().phase(nth as f32 / 7.0))
                .expect("a clip that plays");
            member
        };
        let members = (0..MEMBERS).map(&mut member).collect();
        Self { crowd, members }
    }

    /// The same crowd with the stage after Pose and after Transform.
    pub(crate) fn staged(devices: impl Into<Devices>, schedule: Schedule) -> (Self, [StageId; 2]) {
        let mut scene = Self::on(devices, schedule);
        let stages = scene.add_stages([After::Pose, After::Transform]);
        (scene, stages)
    }

    pub(crate) fn add_stages(&mut self, after: [After; 2]) -> [StageId; 2] {
        after.map(|after| self.crowd.add_stage(after, stage()).expect("a stage"))
    }

    pub(crate) fn update(&mut self, secs: f32) {
        self.crowd.update(secs).expect("a frame");
    }

    /// Returns mutable access to a member.
    pub(crate) fn edit(&mut self, member: MemberId) -> MemberMut<'_> {
        self.crowd.member_mut(member).expect("a member")
    }

    /// Returns the model-space transforms of all joints of the nth member.
    pub(crate) fn models(&mut self, nth: usize) -> Vec<Affine> {
        self.edit(self.members[nth]).model_from_joints().expect("joints that can be read")
    }

    /// Returns the local pose of the nth member.
    pub(crate) fn locals(&mut self, nth: usize) -> Vec<Trs> {
        self.edit(self.members[nth]).local_pose().expect("joints that can be read")
    }

    /// Returns the bits of the palettes of all members.
    pub(crate) fn bits(&mut self) -> Vec<Vec<u32>> {
        let palettes = self
            .members
            .iter()
            .map(|member| self.crowd.member_mut(*member).and_then(|mut m| m.palette()));
        let palettes: Result<Vec<_>, _> = palettes.collect();
        let numbers = |palette: &Vec<Affine>| {
            palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits).collect::<Vec<_>>()
        };
        palettes.expect("palettes that can be read").iter().map(numbers).collect()
    }
}

/// Returns all devices and schedules, and some pairs of devices for one crowd.
pub(crate) fn everywhere() -> Vec<(Devices, Schedule)> {
    let native = || Devices::from(Device::Native { threads: 2 });
    #[cfg_attr(
        any(not(feature = "opencl"), skip_opencl),
        expect(unused_mut, reason = "nothing is added")
    )]
    let mut all = vec![(native(), Schedule::Staged), (native(), Schedule::Fused)];
    #[cfg(all(feature = "opencl", not(skip_opencl)))]
    {
        let both = || Devices::from([Device::Native { threads: 1 }, Device::opencl(0)]);
        for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
            all.push((Device::opencl(0).into(), schedule));
        }
        all.extend([(both(), Schedule::Staged), (both(), Schedule::Fused)]);
    }
    all
}

/// Returns the joint of an index in level order.
pub(crate) fn at(index: u32) -> JointIndex {
    JointIndex(index)
}

pub(crate) fn affine(trs: &Trs) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::from(trs.scale.map(f64::from)),
        DQuat::from_array(trs.rotation.map(f64::from)).normalize(),
        DVec3::from(trs.translation.map(f64::from)),
    )
}

/// Asserts that transforms agree with their values in double precision.
#[track_caller]
pub(crate) fn assert_models(found: &[Affine], wanted: &[DAffine3], context: &str) {
    assert_eq!(found.len(), wanted.len());
    for (joint, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        for row in 0..3 {
            let wanted = [
                wanted.x_axis[row],
                wanted.y_axis[row],
                wanted.z_axis[row],
                wanted.translation[row],
            ];
            for (found, wanted) in found.rows[row].into_iter().zip(wanted) {
                assert!(
                    (f64::from(found) - wanted).abs() < 2e-5,
                    "{context}, joint {joint}: {found}, not {wanted}"
                );
            }
        }
    }
}
