//! Clips bound to bodies: the rows that they follow, and the ranges and the first pose of their
//! joints.

use populace_model::Trs;
use populace_model::convert::u32_from;
use populace_model::math::quat;
use populace_retarget::Binding;

use super::runs::{Asset, Runs};
use super::table::Table;
use super::{BLOCK, BodyIndex, Tables, in_blocks, numbers_of};
use crate::Error;
use crate::layout::{
    BOUND_PLANES, Body, BoundBlock, BoundClip, Contact, FIRST_POSE_PLANE, NEAR_REST, NONE,
    POSE_PLANES, REST_SCALE, REST_TRANSLATION, ROW_PARTS,
};

impl Tables {
    /// Binds a clip to a body and returns the index of the bound clip, for use in slots.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if offsets exceed 32 bits; [`Error::BadPlayback`] if the clip or body
    /// does not exist or the binding is for another skeleton.
    pub fn add_bound_clip(
        &mut self,
        clip: u32,
        body: BodyIndex,
        binding: &Binding,
    ) -> Result<u32, Error> {
        let joints =
            self.all.bodies.as_slice().get(body.0 as usize).map(|b| b.joint_count as usize);
        let known = self.asset_runs.contains_key(&(Asset::Clip, clip));
        let fits = binding.converted().is_none_or(|converted| self.can_follow(clip, converted));
        if !known || !fits || joints != Some(binding.ranges().len()) {
            return Err(Error::BadPlayback { what: "clip or body to bind", value: clip });
        }
        self.add_asset(Asset::BoundClip, |tables, runs| tables.bind(clip, body, binding, runs))
    }

    /// Sets the contacts of a bound clip, in place of those that it had.
    ///
    /// # Errors
    ///
    /// [`Error::BadPlayback`] if the bound clip does not exist; [`Error::TooLarge`] if offsets
    /// exceed 32 bits.
    pub fn set_contacts(&mut self, bound: u32, contacts: &[Contact]) -> Result<(), Error> {
        let row = self.all.bound_clips.as_slice().get(bound as usize).copied();
        let unknown = Error::BadPlayback { what: "bound clip", value: bound };
        let row = row.filter(|row| row.body != NONE).ok_or(unknown)?;
        let mut runs = Runs::default();
        let contact_first = runs.add(&mut self.all.contacts, contacts.iter().copied())?;
        self.release_contacts(bound);
        self.asset_runs.insert((Asset::Contacts, bound), runs);
        let row = BoundClip { contact_first, contact_count: u32_from(contacts.len()), ..row };
        self.all.bound_clips.set(bound as usize, row);
        Ok(())
    }

    /// Frees the contacts of a bound clip.
    pub(super) fn release_contacts(&mut self, bound: u32) {
        if let Some(runs) = self.asset_runs.remove(&(Asset::Contacts, bound)) {
            runs.release(&mut self.all);
        }
    }

    fn bind(
        &mut self,
        clip: u32,
        body: BodyIndex,
        binding: &Binding,
        runs: &mut Runs,
    ) -> Result<u32, Error> {
        let body_row = self.all.bodies.as_slice()[body.0 as usize];
        let rows = match binding.converted() {
            Some(converted) => self.add_converted(clip, &converted.clip, runs)?,
            None => clip,
        };
        let plane_first = runs.add(&mut self.all.poses, bound_planes(binding))?;
        let first_joints = (0..).step_by(BLOCK);
        let blocks: Vec<_> = first_joints
            .zip(binding.blocks())
            .map(|(first, rows)| {
                BoundBlock::new(rows, self.rest_flags(&body_row, plane_first, first))
            })
            .collect();
        let bound = BoundClip {
            clip,
            rows,
            plane_first,
            block_first: runs.add(&mut self.all.bound_blocks, blocks)?,
            body: body.0,
            motion_scale: binding.motion_scale(),
            ..BoundClip::default()
        };
        let index = runs.add(&mut self.all.bound_clips, [bound])?;
        if let Some(converted) = binding.converted() {
            self.follow_live(clip, index, rows, converted);
        }
        self.store_first_pose(index);
        Ok(index)
    }

    /// Returns flags that tell whether the translations and scales of 16 joints from `first` on
    /// equal those of the body's rest, and whether their rotations are near it.
    fn rest_flags(&self, body: &Body, plane_first: u32, first: usize) -> u32 {
        let poses = self.all.poses.as_slice();
        let planes = |table: u32, planes: u32| {
            poses[table as usize + first * planes as usize..].as_chunks::<BLOCK>().0
        };
        let (ranges, rest) =
            (planes(plane_first, BOUND_PLANES), planes(body.rest_first, POSE_PLANES));
        let same = |range_plane: usize, rest_plane: usize| {
            ranges[range_plane..range_plane + 3] == rest[rest_plane..rest_plane + 3]
                && ranges[range_plane + 3] == [0.0; BLOCK]
        };
        let joints = (body.joint_count as usize).saturating_sub(first).min(BLOCK);
        let near = (0..joints).all(|joint| least_cosine(ranges, rest, joint) > LEAST_COSINE);
        (u32::from(same(5, 4)) * REST_TRANSLATION)
            | (u32::from(same(9, 7)) * REST_SCALE)
            | (u32::from(near) * NEAR_REST)
    }
}

/// A cosine above this is positive on every device, however it rounds.
const LEAST_COSINE: f32 = 1e-3;

/// Returns the least cosine of half the angle between a joint's rest rotation and a rotation that
/// its range can express. `ranges` and `rest` are planes of a block.
fn least_cosine(ranges: &[[f32; BLOCK]], rest: &[[f32; BLOCK]], joint: usize) -> f32 {
    let reach = ranges[4][joint] * ROW_PARTS * -f32::from(i16::MIN);
    let cosine = |c: usize| rest[c][joint] * ranges[c][joint] - rest[c][joint].abs() * reach;
    cosine(0) + cosine(1) + cosine(2) + cosine(3)
}

fn bound_planes(binding: &Binding) -> Vec<f32> {
    let joints = binding.ranges().iter().zip(binding.first_pose());
    in_blocks(joints.map(|([translation, rotation, scale], first)| {
        let ([qx, qy, qz, qw], [tx, ty, tz, _], [sx, sy, sz, _]) =
            (rotation.offset, translation.offset, scale.offset);
        let [q, t, s] = [rotation, translation, scale].map(|range| range.step * (1.0 / ROW_PARTS));
        let mut planes = [0.0; BOUND_PLANES as usize];
        let (ranges, pose) = planes.split_at_mut(FIRST_POSE_PLANE as usize);
        ranges.copy_from_slice(&[qx, qy, qz, qw, q, tx, ty, tz, t, sx, sy, sz, s]);
        pose.copy_from_slice(&numbers_of(first));
        planes
    }))
}

/// Stores the first pose in the planes of a bound clip. Properties that the clip does not move stay
/// as they are.
pub(super) fn set_first_pose(poses: &mut Table<f32>, plane_first: u32, pose: &[Trs]) {
    for (joint, trs) in pose.iter().enumerate() {
        let rotation = quat::normalize_or(trs.rotation, quat::identity());
        let numbers = numbers_of(&Trs { rotation, ..*trs });
        let block = plane_first as usize + joint / BLOCK * BLOCK * BOUND_PLANES as usize;
        let place = |plane: usize| block + plane * BLOCK + joint % BLOCK;
        // The plane of a property's part, and the property's planes in a pose.
        for (part, planes) in [(4, 0..4), (8, 4..7), (12, 7..10)] {
            if poses.as_slice()[place(part)] == 0.0 {
                continue;
            }
            for plane in planes {
                poses.set(place(FIRST_POSE_PLANE as usize + plane), numbers[plane]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_cosine_is_that_of_the_farthest_rotation_of_a_range() {
        let (mut ranges, mut rest) = ([[0.0; BLOCK]; 5], [[0.0; BLOCK]; 4]);
        (ranges[0][3], ranges[3][3]) = (0.6, 0.8);
        ranges[4][3] = 0.1 / (32768.0 * ROW_PARTS);
        rest[3][3] = 1.0;
        assert!((least_cosine(&ranges, &rest, 3) - 0.7).abs() < 1e-6);
        (rest[0][3], rest[3][3]) = (-0.8, 0.6);
        assert!((least_cosine(&ranges, &rest, 3) - -0.14).abs() < 1e-6);
    }
}
