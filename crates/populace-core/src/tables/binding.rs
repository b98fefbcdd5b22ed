//! Clips bound to bodies: what a joint's stored components mean, and where its column is.

use super::{BodyIndex, Tables, padded, u32_from};
use crate::Error;
use crate::clip::Binding;
use crate::layout::{
    Body, BoundBlock, BoundClip, JOINT_BLOCK, MAP_COLUMN, MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION, NONE,
    RANGE_PLANES, REST_SCALE, REST_TRANSLATION, Source,
};

impl Tables {
    /// Binds a clip to a body and returns the index that slots name.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] past 32-bit offsets; [`Error::BadPlayback`] for a clip or body that is not there, or a
    /// binding to another skeleton.
    pub fn add_bound_clip(&mut self, clip: u32, body: BodyIndex, binding: &Binding) -> Result<u32, Error> {
        let joints = self.all.bodies.as_slice().get(body.0 as usize).map(|b| b.joint_count as usize);
        if clip as usize >= self.all.clips.len() || joints != Some(binding.joint_map().len()) {
            return Err(Error::BadPlayback { what: "clip or body to bind", value: clip });
        }
        let body_row = self.all.bodies.as_slice()[body.0 as usize];
        let map_first = self.all.joint_maps.extend(binding.joint_map().iter().copied())?;
        let range_first = self.add_ranges(binding)?;
        let block_first = u32_from(self.all.bound_blocks.len());
        for joints in (0..body_row.padded_count).step_by(JOINT_BLOCK as usize) {
            let block = self.bind_block(clip, &body_row, binding, range_first, joints as usize)?;
            self.all.bound_blocks.extend([block])?;
        }
        self.all.bound_clips.extend([BoundClip { clip, map_first, range_first, block_first, body: body.0 }])
    }

    fn add_ranges(&mut self, binding: &Binding) -> Result<u32, Error> {
        let padded = padded(binding.ranges().len());
        let mut planes = vec![0.0; RANGE_PLANES * padded];
        for (joint, [translation, rotation, scale]) in binding.ranges().iter().enumerate() {
            let ([qx, qy, qz, qw], [tx, ty, tz, _], [sx, sy, sz, _]) =
                (rotation.offset, translation.offset, scale.offset);
            let (q, t, s) = (rotation.step, translation.step, scale.step);
            for (plane, value) in [qx, qy, qz, qw, q, tx, ty, tz, t, sx, sy, sz, s].into_iter().enumerate() {
                planes[plane * padded + joint] = value;
            }
        }
        self.all.poses.extend(planes)
    }

    /// Where the 16 joints from `first` on find their columns.
    fn bind_block(
        &mut self,
        clip: u32,
        body: &Body,
        binding: &Binding,
        range_first: u32,
        first: usize,
    ) -> Result<BoundBlock, Error> {
        const BLOCK: usize = JOINT_BLOCK as usize;
        let moves = MAP_ROTATION | MAP_TRANSLATION | MAP_SCALE;
        let maps = &binding.joint_map()[first..binding.joint_map().len().min(first + BLOCK)];
        let mut sources: Vec<(u32, [u32; BLOCK])> = Vec::new();
        for (lane, map) in maps.iter().enumerate().filter(|(_, map)| **map & moves != 0) {
            let column = map & MAP_COLUMN;
            let (block, from) = (column / JOINT_BLOCK, column % JOINT_BLOCK);
            let at = sources.iter().position(|(known, _)| *known == block).unwrap_or_else(|| {
                sources.push((block, [NONE; BLOCK]));
                sources.len() - 1
            });
            sources[at].1[lane] = from;
        }
        let own_lane = |(lane, from): (u32, &u32)| *from == NONE || *from == lane;
        let straight = sources.len() == 1 && (0..).zip(&sources[0].1).all(own_lane);
        let source_first = u32_from(self.all.sources.len());
        let blocks = self.all.clips.as_slice()[clip as usize].block_first;
        for (block, lanes) in &sources {
            let lanes_first = self.all.source_lanes.extend(lanes.iter().copied())?;
            self.all.sources.extend([Source { block: blocks + block, lanes_first }])?;
        }
        let flags = self.rest_flags(body, range_first, first);
        Ok(BoundBlock {
            source_first,
            source_count: u32_from(sources.len()),
            straight: u32::from(straight),
            flags,
        })
    }

    /// Whether the translations and scales of 16 joints from `first` on stand where the body's rest has them.
    fn rest_flags(&self, body: &Body, range_first: u32, first: usize) -> u32 {
        let (padded, joints) = (body.padded_count as usize, first..first + JOINT_BLOCK as usize);
        let poses = self.all.poses.as_slice();
        let plane = |table: u32, plane: usize| {
            let start = table as usize + plane * padded;
            &poses[start + joints.start..start + joints.end]
        };
        let same = |range_plane: usize, rest_plane: usize| {
            let offsets =
                (0..3).all(|c| plane(range_first, range_plane + c) == plane(body.rest_first, rest_plane + c));
            offsets && plane(range_first, range_plane + 3).iter().all(|&step| step == 0.0)
        };
        (u32::from(same(5, 4)) * REST_TRANSLATION) | (u32::from(same(9, 7)) * REST_SCALE)
    }
}
