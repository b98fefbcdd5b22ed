//! Bodies with fewer joints, for members that are seen small.

use populace_character::PaletteEntry;
use populace_model::convert::u32_from;
use populace_model::{Affine, Skeleton};

use super::runs::Runs;
use super::set::TableSet;
use super::{Tables, device_entry};
use crate::Error;
use crate::layout::{Body, Member};

/// Adds what a body has with its first `joint_count` joints only, and returns its row.
pub(super) fn add(
    all: &mut TableSet,
    runs: &mut Runs,
    (skeleton, palette): (&Skeleton, &[PaletteEntry]),
    whole: &Body,
    joint_count: usize,
) -> Result<Body, Error> {
    assert!(
        (1..=skeleton.joint_count()).contains(&joint_count),
        "{joint_count} of {} joints",
        skeleton.joint_count()
    );
    let levels = skeleton.levels();
    let starts = levels.iter().map(|level| level.start).take_while(|start| *start < joint_count);
    let starts: Vec<u32> = starts.chain([joint_count]).map(u32_from).collect();
    let level_count = u32_from(starts.len() - 1);
    let level_first = runs.add(&mut all.levels, starts)?;
    let entries = palette.iter().map(|entry| {
        let PaletteEntry { mut joint, mut joint_from_bind } = *entry;
        // A joint's parent comes before it, so the first joints hold an ancestor of all others.
        while let Some(parent) = skeleton.parent(joint).filter(|_| joint.index() >= joint_count) {
            joint_from_bind = Affine::from_trs(skeleton.rest(joint)).mul(&joint_from_bind);
            joint = parent;
        }
        device_entry(&PaletteEntry { joint, joint_from_bind })
    });
    let entry_first = runs.add(&mut all.entries, entries)?;
    let joint_count = u32_from(joint_count);
    Ok(Body { joint_count, level_first, level_count, entry_first, ..*whole })
}

impl Tables {
    /// Evaluates a member with one of its body's reduced bodies, counted from 1, or with the whole
    /// body (0). If the member's constraint program needs more joints, the nearest body that has
    /// them is taken.
    ///
    /// # Panics
    ///
    /// If there is no such member or reduced body.
    pub fn set_reduced(&mut self, member_index: u32, reduced: u32) {
        let mut member = self.all.members.as_slice()[member_index as usize];
        let posed = self.reduced_body(&member, reduced);
        if member.posed != posed {
            member.posed = posed;
            self.all.members.set(member_index as usize, member);
            self.mix_page(member_index);
        }
    }

    /// Returns the body that [`set_reduced`](Self::set_reduced) takes for a member.
    pub(super) fn reduced_body(&self, member: &Member, reduced: u32) -> u32 {
        let needed = self.control_spaces.joints_needed(member.control);
        let bodies = self.all.bodies.as_slice();
        let mut posed = member.body + reduced;
        while posed > member.body && bodies[posed as usize].joint_count < needed {
            posed -= 1;
        }
        posed
    }
}
