//! Readback of a member's pose from a backend.

use populace_device::layout::Float4;
use populace_device::{Backend, StageBuffer};

use crate::TestCrowd;

/// The results of a backend for one member; joints in source order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemberReading {
    /// Local translations, metres.
    pub translations: Vec<[f32; 3]>,
    /// Local rotations.
    pub rotations: Vec<[f32; 4]>,
    /// Local scales.
    pub scales: Vec<[f32; 3]>,
    /// `model_from_joint`, 3x4, row-major.
    pub models: Vec<[f32; 12]>,
    /// `model_from_bind` of each palette entry, 3x4, row-major.
    pub palette: Vec<[f32; 12]>,
}

impl TestCrowd<'_> {
    /// Reads a member's palette.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn read_palette(&self, backend: &mut dyn Backend, member: usize) -> Vec<[f32; 12]> {
        let plan = self.plan(member);
        let first = 3 * self.tables.members().as_slice()[self.index(member) as usize].palette_first
            as usize;
        let mut rows = vec![Float4::default(); 3 * self.scene.bodies[plan.body].palette.len()];
        if !rows.is_empty() {
            backend
                .read(&self.tables, StageBuffer::Palette, first, &mut rows)
                .expect("palettes can be read");
        }
        rows.chunks(3).map(|r| flat([r[0], r[1], r[2]])).collect()
    }

    /// Reads all results of a backend for a member.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn read(&self, backend: &mut dyn Backend, member: usize) -> MemberReading {
        let mut joints = |buffer| self.read_joints(backend, member, buffer);
        let translations = joints(StageBuffer::Translations);
        let rotations = joints(StageBuffer::Rotations);
        let scales = joints(StageBuffer::Scales);
        let model_rows =
            [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2].map(joints);
        MemberReading {
            translations: translations.into_iter().map(Float4::xyz).collect(),
            rotations: rotations.into_iter().map(|q| q.0).collect(),
            scales: scales.into_iter().map(Float4::xyz).collect(),
            models: (0..model_rows[0].len())
                .map(|joint| flat([0, 1, 2].map(|row: usize| model_rows[row][joint])))
                .collect(),
            palette: self.read_palette(backend, member),
        }
    }

    /// Reads a member's elements of a per-joint buffer, in source order.
    fn read_joints(
        &self,
        backend: &mut dyn Backend,
        member: usize,
        buffer: StageBuffer,
    ) -> Vec<Float4> {
        let skeleton = &self.scene.bodies[self.plan(member).body].skeleton;
        let first =
            self.tables.members().as_slice()[self.index(member) as usize].joint_first as usize;
        let mut by_level = vec![Float4::default(); skeleton.joint_count()];
        backend.read(&self.tables, buffer, first, &mut by_level).expect("joints can be read");
        (0..skeleton.joint_count())
            .map(|source| by_level[skeleton.joint_from_source(source).index()])
            .collect()
    }

    /// Writes a member's elements of a per-joint buffer, given in source order.
    ///
    /// # Panics
    ///
    /// If the backend fails, or there is no such member.
    pub fn write_joints(
        &self,
        backend: &mut dyn Backend,
        member: usize,
        buffer: StageBuffer,
        by_source: &[[f32; 4]],
    ) {
        let skeleton = &self.scene.bodies[self.plan(member).body].skeleton;
        let first =
            self.tables.members().as_slice()[self.index(member) as usize].joint_first as usize;
        let by_level: Vec<_> =
            skeleton.joints().map(|j| Float4(by_source[skeleton.source_from_joint(j)])).collect();
        backend.write(buffer, first, &by_level).expect("joints can be written");
    }
}

fn flat(rows: [Float4; 3]) -> [f32; 12] {
    std::array::from_fn(|element| rows[element / 4].0[element % 4])
}
