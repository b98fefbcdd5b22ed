//! Compiles constraints into the form that devices read: the steps of each joint, and the data of
//! each step.

use populace_model::convert::{not_finite, u32_from};
use populace_model::{JointIndex, LARGEST, Skeleton, Trs, f64math};

use super::super::soles::Soles;
use super::foot::foot_row;
use super::limb::{bad, float4, limb_links};
use crate::Error;
use crate::control::{
    Chain, Constraint, Controls, Feet, Gaze, JointOverride, Limb, Space, in_joint, path,
};
use crate::fault::{ConstraintFault, ConstraintPart};
use crate::layout::{
    self, Float4, Link, MAX_FEET, MAX_STEP_ROTATIONS, NONE, Override, STEP_ATTACH, STEP_CARRY,
    STEP_CHAIN, STEP_FOOT, STEP_GAZE, STEP_MOTION, STEP_OVERRIDE, STEP_PELVIS, STEP_REACH,
    STEP_ROTATION, STEP_STAGE, STEP_WATCH, Step, Target,
};

/// The joints by which planted feet differ from others: the pelvis, and the hip of each foot.
pub(super) type FeetJoints = [u32; 1 + MAX_FEET as usize];

/// The compiled constraint program of one member. Indices count from the program's own first
/// elements until [`move_own`](Self::move_own) and [`move_shared`](Self::move_shared) are called.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    /// Steps by joint: those that run during Transform, then those that run after Pose.
    pub(super) steps: Vec<Step>,
    pub(super) pose_step_count: usize,
    /// Overrides in local space, then those in model space, then the attachment offset.
    pub(super) overrides: Vec<Override>,
    pub(super) local_count: usize,
    pub(super) constraints: Vec<layout::Constraint>,
    pub(super) links: Vec<Link>,
    pub(super) targets: Vec<Target>,
    /// The member's values for the stages that it uses.
    pub(super) values: Vec<Float4>,
    pub(super) scale_first: u32,
    pub(super) motion_epoch: u32,
    pub(super) feet: Option<FeetJoints>,
    rotation_count: usize,
}

fn check_finite(part: ConstraintPart, values: &[f32]) -> Result<(), Error> {
    match not_finite(values) {
        None => Ok(()),
        Some(_) => bad(ConstraintFault::NotFinite { part }),
    }
}

fn check_bounded(part: ConstraintPart, values: &[f32]) -> Result<(), Error> {
    if values.iter().all(|v| v.abs() <= LARGEST) {
        Ok(())
    } else {
        bad(ConstraintFault::NotBounded { part })
    }
}

/// Refuses targets with numbers that are not finite or too large.
pub(super) fn check_targets(targets: &[Target]) -> Result<(), Error> {
    for target in targets {
        check_bounded(ConstraintPart::Target, &target.point.0)?;
        check_finite(
            ConstraintPart::TargetWeight,
            &[target.start_weight, target.weight_rate, target.end_weight],
        )?;
    }
    Ok(())
}

/// Returns the vector with length 1, or unchanged if its length is 0.
#[expect(clippy::cast_possible_truncation, reason = "to the nearest")]
fn direction(of: [f32; 3]) -> [f32; 3] {
    let wide = of.map(f64::from);
    let length = wide.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > 0.0 { wide.map(|v| (v / length) as f32) } else { of }
}

/// Converts a transform that the host sets.
fn transform(part: ConstraintPart, given: &Trs, weight: f32) -> Result<Override, Error> {
    let length: f32 = given.rotation.iter().map(|v| v * v).sum();
    if !given.is_bounded() || !(0.9..1.1).contains(&length) {
        return bad(ConstraintFault::Transform { part });
    }
    let [x, y, z] = given.translation;
    Ok(Override {
        translation_and_weight: Float4([x, y, z, weight]),
        rotation: Float4(f64math::normalized(given.rotation)),
        scale: Float4::from_xyz(given.scale),
        ..Override::default()
    })
}

/// Returns the tangent of an angle below a quarter turn, or the largest number for larger angles.
fn tangent(angle_rad: f32) -> f32 {
    if angle_rad < std::f32::consts::FRAC_PI_2 { angle_rad.tan() } else { f32::MAX }
}

impl Program {
    pub(super) fn compile(
        skeleton: &Skeleton,
        soles: &Soles,
        controls: &Controls,
    ) -> Result<Self, Error> {
        let mut program = Self {
            scale_first: controls.proportions.unwrap_or(NONE),
            motion_epoch: controls.motion.unwrap_or(0),
            ..Self::default()
        };
        for constraint in &controls.constraints {
            match constraint {
                Constraint::Gaze(gaze) => program.gaze(skeleton, gaze)?,
                Constraint::Limb(limb) => program.limb(skeleton, limb)?,
                Constraint::Chain(chain) => program.chain(skeleton, chain)?,
                Constraint::Feet(feet) => program.feet(skeleton, soles, feet)?,
            }
        }
        if controls.motion.is_some() {
            for root in skeleton.joints().filter(|joint| skeleton.parent(*joint).is_none()) {
                program.step(root, STEP_MOTION, 0, 0);
            }
        }
        program.overrides(skeleton, &controls.overrides)?;
        let pose_steps = program.stages(skeleton, &controls.stages)?;
        for (kind, watches) in [(STEP_WATCH, &controls.watches), (STEP_CARRY, &controls.carries)] {
            for &(joint, watched) in watches {
                path(skeleton, joint, joint)?;
                program.step(joint, kind, watched, 0);
            }
        }
        program.attach(skeleton, controls.attached)?;
        program.solve_legs_with_pelvis();
        if program.rotation_count > MAX_STEP_ROTATIONS as usize {
            return bad(ConstraintFault::TooManyRotations { count: program.rotation_count });
        }
        // Stable sort. Root motion comes first, then attachments. Constraints of one joint keep
        // their order, followed by stages, overrides and watched joints.
        program.steps.sort_by_key(|step| (step.joint, rank(step.kind)));
        program.pose_step_count = pose_steps.len();
        program.steps.extend(pose_steps);
        Ok(program)
    }

    fn step(&mut self, joint: JointIndex, kind: u32, index: u32, operand: usize) {
        self.steps.push(Step { joint: joint.0, kind, index, operand: u32_from(operand) });
    }

    /// Returns how many joints the program needs, counted from the first. What changes local
    /// transforms may change those of any joint.
    pub(super) fn joints_needed(&self) -> u32 {
        if self.local_count > 0 || self.pose_step_count > 0 || self.scale_first != NONE {
            return NONE;
        }
        let steps = self.steps.iter().map(|step| step.joint);
        steps.chain(self.links.iter().map(|link| link.joint)).max().map_or(0, |last| last + 1)
    }

    /// Returns the shape of the program: all that programs must have in common so that several
    /// members can take each step side by side. That is the kinds and joints of steps, and the
    /// chains, soles and rotations of constraints.
    pub(super) fn shape(&self) -> Vec<u32> {
        let mut shape = Vec::new();
        for step in &self.steps[..self.steps.len() - self.pose_step_count] {
            shape.extend([step.kind, step.joint]);
            let feet = match step.kind {
                STEP_PELVIS => self.constraints[step.index as usize].target_count as usize,
                STEP_GAZE | STEP_REACH | STEP_CHAIN | STEP_FOOT => 1,
                STEP_ROTATION => 0,
                _ => continue,
            };
            shape.push(step.operand);
            for constraint in &self.constraints[step.index as usize..][..feet] {
                self.shape_of_constraint(constraint, &mut shape);
            }
        }
        shape
    }

    fn shape_of_constraint(&self, constraint: &layout::Constraint, shape: &mut Vec<u32>) {
        let layout::Constraint { link_first, link_count, middle, upper, .. } = *constraint;
        let layout::Constraint { toe_links, at_once, sole_first, sole_count, .. } = *constraint;
        let layout::Constraint { toe_first, toe_count, .. } = *constraint;
        shape.extend([link_count, middle, upper, toe_links, at_once]);
        shape.extend([sole_first, sole_count, toe_first, toe_count]);
        let links = &self.links[link_first as usize..][..link_count as usize];
        shape.extend(links.iter().map(|link| link.joint));
    }

    /// Allocates `count` rotations that later steps apply, and returns the first index.
    fn allocate_rotations(&mut self, count: usize) -> usize {
        self.rotation_count += count;
        self.rotation_count - count
    }

    fn add(
        &mut self,
        row: layout::Constraint,
        links: &[Link],
        targets: &[Target],
    ) -> Result<u32, Error> {
        check_targets(targets)?;
        let (link_first, target_first) = (u32_from(self.links.len()), u32_from(self.targets.len()));
        self.links.extend(links);
        self.targets.extend(targets);
        let target_count =
            if targets.is_empty() { row.target_count } else { u32_from(targets.len()) };
        let link_count = u32_from(links.len());
        self.constraints.push(layout::Constraint {
            link_first,
            link_count,
            target_first,
            target_count,
            ..row
        });
        Ok(u32_from(self.constraints.len() - 1))
    }

    fn gaze(&mut self, skeleton: &Skeleton, gaze: &Gaze) -> Result<(), Error> {
        let (Some(&(first, _)), Some(&(last, _))) = (gaze.chain.first(), gaze.chain.last()) else {
            return bad(ConstraintFault::EmptyGaze);
        };
        let sum: f32 = gaze.chain.iter().map(|(_, share)| share).sum();
        let good =
            gaze.chain.iter().all(|(_, share)| *share >= 0.0) && sum.is_finite() && sum > 0.0;
        let limits = gaze.limits;
        let half = std::f32::consts::PI;
        let in_range = (0.0..half).contains(&limits.yaw_rad)
            && [limits.up_rad, limits.down_rad].iter().all(|v| (0.0..half / 2.0).contains(v));
        if !good || !in_range {
            return bad(ConstraintFault::GazeRange);
        }
        check_finite(ConstraintPart::GazeFacing, &gaze.facing)?;
        if gaze.facing == [0.0; 3] {
            return bad(ConstraintFault::GazeFacing);
        }
        let joints = path(skeleton, first, last)?;
        let share_of = |joint: &JointIndex| {
            let parts = gaze.chain.iter().filter(|(j, _)| j == joint);
            parts.map(|(_, share)| share / sum).sum::<f32>()
        };
        let links: Vec<Link> =
            joints.iter().map(|joint| Link { joint: joint.0, share: share_of(joint) }).collect();
        let parent = skeleton.parent(first);
        let row = layout::Constraint {
            axis: float4(
                in_joint(skeleton, Some(last), direction(gaze.facing)),
                tangent(limits.yaw_rad),
            ),
            front: float4(in_joint(skeleton, parent, [0.0, 0.0, 1.0]), tangent(limits.up_rad)),
            up: float4(in_joint(skeleton, parent, [0.0, 1.0, 0.0]), tangent(limits.down_rad)),
            limits: Float4([limits.yaw_rad, limits.up_rad, limits.down_rad, 0.0]),
            ..layout::Constraint::default()
        };
        let index = self.add(row, &links, &gaze.targets)?;
        let first_rotation = self.allocate_rotations(joints.len() - 1);
        self.step(first, STEP_GAZE, index, first_rotation);
        for (at, link) in links.iter().enumerate().skip(1).filter(|(_, link)| link.share > 0.0) {
            self.step(JointIndex(link.joint), STEP_ROTATION, index, first_rotation + at - 1);
        }
        Ok(())
    }

    fn limb(&mut self, skeleton: &Skeleton, limb: &Limb) -> Result<(), Error> {
        let (links, middle) =
            limb_links(skeleton, limb.first, [limb.first, limb.middle, limb.end])?;
        if !(limb.soft > 0.0 && limb.soft <= 0.5) {
            return bad(ConstraintFault::LimbSoft { soft: limb.soft });
        }
        check_finite(ConstraintPart::LimbBend, &limb.bend)?;
        let pole = limb.pole.unwrap_or([0.0; 3]);
        check_finite(ConstraintPart::Pole, &pole)?;
        let row = layout::Constraint {
            axis: float4(in_joint(skeleton, Some(limb.first), direction(limb.bend)), 0.0),
            front: float4(direction(pole), f32::from(u8::from(limb.pole.is_some()))),
            limits: Float4([limb.soft, 1.0, 0.0, 0.0]),
            middle,
            keeps_end: u32::from(limb.keeps_end),
            ..layout::Constraint::default()
        };
        let index = self.add(row, &links, &limb.targets)?;
        let first_rotation = self.allocate_rotations(2);
        self.step(limb.first, STEP_REACH, index, first_rotation);
        self.step(limb.middle, STEP_ROTATION, index, first_rotation);
        self.step(limb.end, STEP_ROTATION, index, first_rotation + 1);
        Ok(())
    }

    fn chain(&mut self, skeleton: &Skeleton, chain: &Chain) -> Result<(), Error> {
        let joints = path(skeleton, chain.first, chain.end)?;
        if joints.len() < 2 {
            return bad(ConstraintFault::ShortChain);
        }
        if !(chain.soft > 0.0 && chain.soft <= 0.5) {
            return bad(ConstraintFault::ChainSoft { soft: chain.soft });
        }
        let links: Vec<Link> =
            joints.iter().map(|joint| Link { joint: joint.0, share: 0.0 }).collect();
        let row = layout::Constraint {
            limits: Float4([chain.soft, 1.0, 0.0, 0.0]),
            ..layout::Constraint::default()
        };
        let index = self.add(row, &links, &chain.targets)?;
        let first_rotation = self.allocate_rotations(joints.len() - 1);
        self.step(chain.first, STEP_CHAIN, index, first_rotation);
        for (at, joint) in joints.iter().enumerate().skip(1) {
            self.step(*joint, STEP_ROTATION, index, first_rotation + at - 1);
        }
        Ok(())
    }

    fn feet(&mut self, skeleton: &Skeleton, soles: &Soles, feet: &Feet) -> Result<(), Error> {
        if feet.feet.is_empty() || feet.feet.len() > MAX_FEET as usize {
            return bad(ConstraintFault::FootCount { count: feet.feet.len() });
        }
        if !(0.0..=1.0).contains(&feet.weight) {
            return bad(ConstraintFault::FeetWeight { weight: feet.weight });
        }
        if self.steps.iter().any(|step| step.kind == STEP_PELVIS) {
            return bad(ConstraintFault::SecondFeet);
        }
        let first_rotation = self.allocate_rotations(3 * feet.feet.len());
        let first = u32_from(self.constraints.len());
        for (nth, foot) in feet.feet.iter().enumerate() {
            let (row, links) = foot_row(skeleton, feet, foot, soles)?;
            let row = layout::Constraint { target_count: u32_from(feet.feet.len()), ..row };
            let index = self.add(row, &links, &[])?;
            let first_rotation = first_rotation + 3 * nth;
            self.step(foot.hip, STEP_FOOT, index, first_rotation);
            self.step(foot.knee, STEP_ROTATION, index, first_rotation + 1);
            self.step(foot.ankle, STEP_ROTATION, index, first_rotation + 2);
        }
        self.step(feet.pelvis, STEP_PELVIS, first, first_rotation);
        let mut joints = [NONE; 1 + MAX_FEET as usize];
        let hips = feet.feet.iter().map(|foot| foot.hip);
        for (own, joint) in joints.iter_mut().zip(std::iter::once(feet.pelvis).chain(hips)) {
            *own = joint.0;
        }
        self.feet = Some(joints);
        Ok(())
    }

    /// Solves the legs together with the pelvis if no other step moves the joints between it and
    /// the knees.
    fn solve_legs_with_pelvis(&mut self) {
        let is_foot = |step: &&mut Step| step.kind == STEP_FOOT;
        let chains = self.steps.iter().filter(|step| step.kind == STEP_FOOT).flat_map(|step| {
            let foot = &self.constraints[step.index as usize];
            &self.links[foot.link_first as usize..][..=foot.upper as usize]
        });
        let carriers: Vec<u32> = chains.map(|link| link.joint).collect();
        let moves = |step: &Step| {
            !matches!(step.kind, STEP_FOOT | STEP_PELVIS | STEP_WATCH | STEP_CARRY | STEP_MOTION)
        };
        if self.steps.iter().any(|step| moves(step) && carriers.contains(&step.joint)) {
            return;
        }
        for step in self.steps.iter_mut().filter(is_foot) {
            self.constraints[step.index as usize].at_once = 1;
            step.kind = STEP_ROTATION;
        }
    }

    fn overrides(&mut self, skeleton: &Skeleton, overrides: &[JointOverride]) -> Result<(), Error> {
        let of = |space: Space| overrides.iter().filter(move |o| o.space == space);
        for given in of(Space::Local).chain(of(Space::Model)) {
            path(skeleton, given.joint, given.joint)?;
            let (joint, weight) = (skeleton.name(given.joint).to_owned(), given.weight);
            if !(0.0..=1.0).contains(&weight) {
                return bad(ConstraintFault::OverrideWeight { joint, weight });
            }
            let row = transform(ConstraintPart::Override { joint }, &given.transform, weight)?;
            self.overrides.push(Override { joint: given.joint.0, ..row });
            if given.space == Space::Model {
                self.step(given.joint, STEP_OVERRIDE, u32_from(self.overrides.len() - 1), 0);
            } else {
                self.local_count += 1;
            }
        }
        Ok(())
    }

    /// Adds steps that make all roots follow the joint that the member is attached to.
    fn attach(&mut self, skeleton: &Skeleton, attached: Option<(u32, Trs)>) -> Result<(), Error> {
        let Some((watched, offset)) = attached else { return Ok(()) };
        let at = self.overrides.len();
        self.overrides.push(transform(ConstraintPart::AttachmentOffset, &offset, 1.0)?);
        for root in skeleton.joints().filter(|joint| skeleton.parent(*joint).is_none()) {
            self.step(root, STEP_ATTACH, watched, at);
        }
        Ok(())
    }

    /// Offsets the indices of overrides and values to where the member has its own.
    pub(super) fn move_own(&mut self, overrides: usize, values: usize) {
        for step in &mut self.steps {
            match step.kind {
                STEP_OVERRIDE => step.index += u32_from(overrides),
                STEP_ATTACH => step.operand += u32_from(overrides),
                STEP_STAGE => step.operand += u32_from(values),
                _ => {}
            }
        }
    }

    /// Offsets the indices of constraints and links to the rows that equal programs share.
    pub(super) fn move_shared(&mut self, constraints: usize, links: usize) {
        for step in &mut self.steps {
            step.index += match step.kind {
                STEP_OVERRIDE | STEP_WATCH | STEP_CARRY | STEP_ATTACH | STEP_STAGE
                | STEP_MOTION => 0,
                _ => u32_from(constraints),
            };
        }
        for constraint in &mut self.constraints {
            constraint.link_first += u32_from(links);
        }
    }
}

/// Order of the steps of one joint.
fn rank(kind: u32) -> u32 {
    match kind {
        STEP_MOTION => 0,
        STEP_ATTACH => 1,
        STEP_PELVIS => 2,
        STEP_STAGE => 4,
        STEP_OVERRIDE => 5,
        STEP_WATCH | STEP_CARRY => 6,
        _ => 3,
    }
}
