//! Calls for many members at once. A batch checks everything first: on an error, nothing is
//! changed.

use populace_device::layout::{Float4, PAGE_ENTRIES};
use populace_device::{ConstraintFault, Schedule, StageBuffer};
use populace_model::{Affine, JointIndex};
use populace_settings::parts::{Check, bounded, check_secs, stride_row};

use super::base::Base;
use super::state::State;
use super::{CharacterId, Crowd, MemberId, ParameterId};
use crate::{Allowed, Error, Placement, SpacePoint, Stride};

impl Crowd {
    /// Adds a member for each placement, as [`spawn`](Self::spawn) does.
    ///
    /// # Errors
    ///
    /// As for [`spawn`](Self::spawn). Nothing is added then.
    pub fn spawn_many(
        &mut self,
        character: CharacterId,
        placements: &[Placement],
    ) -> Result<Vec<MemberId>, Error> {
        placements.iter().try_for_each(Placement::check)?;
        let (player, base) = self.state.player();
        base.check_room_for(placements.len())?;
        let mut members = Vec::with_capacity(placements.len());
        for placement in placements {
            match base.add_member(character, *placement) {
                Ok(member) => members.push(member),
                Err(error) => {
                    members.into_iter().for_each(|member| base.remove_member(member));
                    return Err(error);
                }
            }
        }
        player.set_slot_count(base.members.all.len() * base.tables.slots_per_member());
        Ok(members)
    }

    /// Sets the placements of members, as
    /// [`MemberMut::set_placement`](crate::MemberMut::set_placement) does.
    ///
    /// # Errors
    ///
    /// As for [`MemberMut::set_placement`](crate::MemberMut::set_placement). Nothing is changed
    /// then.
    pub fn set_placements(&mut self, placements: &[(MemberId, Placement)]) -> Result<(), Error> {
        self.state.set_placements(placements)
    }

    /// Sets a parameter of the state machines of members, as
    /// [`MemberMut::set_parameter`](crate::MemberMut::set_parameter) does. Members that do not run
    /// the machine are left alone.
    ///
    /// # Errors
    ///
    /// A stale member, a parameter of another crowd, or a value that is not finite. Nothing is
    /// changed then.
    pub fn set_parameters(
        &mut self,
        parameter: ParameterId,
        values: &[(MemberId, f32)],
    ) -> Result<(), Error> {
        let (player, base) = self.state.player();
        for (member, value) in values {
            base.check(*member)?;
            bounded("a parameter of a state machine", &[*value])?;
        }
        player.write_parameters(base, parameter, values)
    }

    /// Moves the blend spaces of members to other positions within `over_secs`, as
    /// [`MemberMut::set_blend_parameter`](crate::MemberMut::set_blend_parameter) does.
    ///
    /// # Errors
    ///
    /// A stale member, a position that is not finite, or a time that is out of its range: nothing
    /// is changed then. [`Error::BadBlendSpace`] for a member that plays no blend space, after the
    /// members before it have been moved.
    pub fn set_blend_parameters(
        &mut self,
        points: &[(MemberId, SpacePoint)],
        over_secs: f32,
    ) -> Result<(), Error> {
        check_secs("the time to move in a blend space", over_secs)?;
        let (player, base) = self.state.player();
        for (member, point) in points {
            base.check(*member)?;
            point.check()?;
        }
        for (member, point) in points {
            player.set_blend_parameter(base, *member, *point, over_secs)?;
        }
        Ok(())
    }

    /// Sets how the planted feet of members step, as
    /// [`MemberMut::set_stride`](crate::MemberMut::set_stride) does.
    ///
    /// # Errors
    ///
    /// A stale member, or a number that is not finite. Nothing is changed then.
    pub fn set_strides(&mut self, strides: &[(MemberId, Stride)]) -> Result<(), Error> {
        let base = &mut self.state.base;
        for (member, stride) in strides {
            base.check(*member)?;
            stride.check()?;
        }
        for (member, stride) in strides {
            base.tables.set_stride(member.number(), stride_row(stride))?;
        }
        Ok(())
    }

    /// Reads joints of members after the last update into `models`: joint to model space, one for
    /// each of `joints`. Joints that a member's level of detail leaves out hang from the others as
    /// at rest; see [`model_from_joints`](crate::MemberMut::model_from_joints). Waits for the last
    /// update, once.
    ///
    /// # Errors
    ///
    /// A stale member, a joint that does not exist, a slice of another length than `joints`,
    /// [`BackendError::NotEvaluated`](crate::BackendError::NotEvaluated) for a member that the last
    /// update did not evaluate, or a failing device.
    pub fn read_joints(
        &mut self,
        joints: &[(MemberId, JointIndex)],
        models: &mut [Affine],
    ) -> Result<(), Error> {
        if joints.len() != models.len() {
            let (what, value) = ("the length of the slice of joints", models.len() as f32);
            return Err(Error::BadValue { what, value, allowed: Allowed::Exactly(joints.len()) });
        }
        let mut firsts = Vec::with_capacity(joints.len());
        let mut hanging = Vec::new();
        for (nth, (member, joint)) in joints.iter().enumerate() {
            let (first, rests) = self.place_of_joint(*member, *joint)?;
            firsts.push(first);
            hanging.extend((!rests.is_empty()).then_some((nth, rests)));
        }
        self.read_models(&firsts, models)?;
        self.update_offsets()?;
        for (nth, rests) in hanging {
            models[nth] = rests.iter().fold(models[nth], |model, rest| model.mul(rest));
        }
        Ok(())
    }

    /// Returns the index on the device of a member's joint or, if its level of detail leaves that
    /// out, of the lowest evaluated joint above it, and the rests of the joints from there on.
    fn place_of_joint(
        &self,
        member: MemberId,
        joint: JointIndex,
    ) -> Result<(usize, Vec<Affine>), Error> {
        let (row, body) = self.device_member(member)?;
        let skeleton = self.skeleton_of(member)?;
        if joint.index() >= skeleton.joint_count() {
            let count = skeleton.joint_count();
            return Err(Error::Tables(ConstraintFault::NoJoint { joint: joint.0, count }.into()));
        }
        let (mut evaluated, mut rests) = (joint, Vec::new());
        while evaluated.0 >= body.joint_count
            && let Some(parent) = skeleton.parent(evaluated)
        {
            rests.push(Affine::from_trs(skeleton.rest(evaluated)));
            evaluated = parent;
        }
        rests.reverse();
        Ok(((row.joint_first + evaluated.0) as usize, rests))
    }

    /// Reads the matrices of joints, which are at `firsts` on the device.
    fn read_models(&mut self, firsts: &[usize], models: &mut [Affine]) -> Result<(), Error> {
        let Self { state: State { base, .. }, device, .. } = self;
        let backend = device.backend_mut();
        // Fused schedules store no joints: each member is evaluated as it is read.
        let at_once = backend.runs_ahead() && backend.schedule() == Schedule::Staged;
        let order = in_order(firsts);
        let mut rows = Vec::new();
        base.tables.with_taken_over(|tables| {
            for run in runs(&order, firsts, if at_once { READ_ALONG } else { 0 }) {
                let [first, last] = [run[0], run[run.len() - 1]].map(|nth| firsts[nth]);
                rows.resize(last - first + 1, Float4::default());
                for (row, buffer) in ROWS.into_iter().enumerate() {
                    backend.read(tables, buffer, first, &mut rows)?;
                    for nth in run {
                        models[*nth].rows[row] = rows[firsts[*nth] - first].0;
                    }
                }
            }
            Ok(())
        })
    }
}

/// Elements that a device that runs ahead reads along rather than begin another read, which costs
/// more.
const READ_ALONG: usize = 4096;

/// Returns the numbers of elements in the order of their places.
fn in_order(places: &[usize]) -> Vec<usize> {
    let mut order: Vec<_> = (0..places.len()).collect();
    order.sort_unstable_by_key(|nth| places[*nth]);
    order
}

/// Divides elements in order into runs whose neighbours are at most `gap` apart.
fn runs<'a>(order: &'a [usize], places: &[usize], gap: usize) -> impl Iterator<Item = &'a [usize]> {
    order.chunk_by(move |a, b| places[*b] - places[*a] <= gap)
}

/// The rows of the matrices from joints to model space.
const ROWS: [StageBuffer; 3] =
    [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2];

impl Crowd {
    /// Calls `reader` with the palette of each member that the last update evaluated, in order of
    /// their places in memory: one matrix from bind pose to model space for each palette entry
    /// of the character. Waits for the last update, once. Nothing is copied if the device shares
    /// memory with the host.
    ///
    /// # Errors
    ///
    /// [`BackendError::NotEvaluated`](crate::BackendError::NotEvaluated) if no update has evaluated
    /// the crowd on this device, or a failing device.
    pub fn palettes(&mut self, reader: &mut dyn FnMut(MemberId, &[Affine])) -> Result<(), Error> {
        let base = &self.state.base;
        let Base { tables, members, .. } = base;
        let evaluated = (0u32..)
            .zip(&members.all)
            .filter(|(index, state)| state.character.is_some() && base.is_evaluated(*index));
        let mut places: Vec<_> = evaluated
            .map(|(index, _)| {
                let row = &tables.members().as_slice()[index as usize];
                let entries = tables.bodies().as_slice()[row.body as usize].entry_count as usize;
                (row.palette_first as usize, entries, base.member_id(index))
            })
            .filter(|(_, entries, _)| *entries > 0)
            .collect();
        places.sort_unstable_by_key(|(first, ..)| *first);
        let page_of = |first: usize| first / PAGE_ENTRIES as usize;
        for in_page in places.chunk_by(|a, b| page_of(a.0) == page_of(b.0)) {
            let page = page_of(in_page[0].0);
            self.with_page(page, &mut |elements| {
                let all: &[Affine] = bytemuck::must_cast_slice(elements.as_chunks::<3>().0);
                for (first, entries, member) in in_page {
                    let first = first - page * PAGE_ENTRIES as usize;
                    reader(*member, &all[first..first + entries]);
                }
            })?;
        }
        Ok(())
    }
}

impl State {
    fn set_placements(&mut self, placements: &[(MemberId, Placement)]) -> Result<(), Error> {
        for (member, placement) in placements {
            self.base.check(*member)?;
            placement.check()?;
        }
        if self.attachments.is_empty() && self.motion.is_empty() {
            // Only constraint programs read placements.
            if self.constraints.is_empty() {
                for (member, placement) in placements {
                    self.base.members.all[member.number() as usize].placement = *placement;
                }
                return Ok(());
            }
            return placements
                .iter()
                .try_for_each(|(member, placement)| self.base.move_member(*member, *placement));
        }
        for (member, _) in placements {
            self.attachments.check_placeable(*member)?;
        }
        for (member, placement) in placements {
            self.place(*member, *placement)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_that_are_far_apart_are_read_apart() {
        let far = 6_400_000;
        let places = [far + 1, 10, far, 10 + READ_ALONG, 10];
        let order = in_order(&places);
        let found: Vec<Vec<usize>> = runs(&order, &places, READ_ALONG)
            .map(|run| run.iter().map(|nth| places[*nth]).collect())
            .collect();
        assert_eq!(found, [vec![10, 10, 10 + READ_ALONG], vec![far, far + 1]]);
    }
}
