//! A backend with one wrong number, to test that every check can fail.

use populace_device::layout::{Float4, NONE};
use populace_device::{
    Backend, BackendError, Frame, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};
use populace_model::convert::single;

use crate::tolerance::{COARSE, LOCAL_CAP, MODEL_CAP, ROUNDING_CAP};

/// The error of a [`Broken`] backend: one wrong number of the last member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corruption {
    buffer: StageBuffer,
    component: usize,
    amount: Amount,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Amount {
    By(f32),
    OneUnitIfManyMembers,
}

impl Corruption {
    /// Adds more than twice the cap: the correct value itself may be off by up to the cap in the
    /// other direction.
    fn by(buffer: StageBuffer, component: usize, cap: f64) -> Self {
        Self { buffer, component, amount: Amount::By(single(2.5 * cap)) }
    }

    /// One component of one joint's local rotation, off by more than any check allows.
    #[must_use]
    pub fn rotation() -> Self {
        Self::by(StageBuffer::Rotations, 1, LOCAL_CAP)
    }

    /// One component of one joint's local rotation, for checks with wide caps.
    #[must_use]
    pub fn coarse_rotation() -> Self {
        Self::by(StageBuffer::Rotations, 1, COARSE * LOCAL_CAP)
    }

    /// One component of one joint's local translation.
    #[must_use]
    pub fn translation() -> Self {
        Self::by(StageBuffer::Translations, 1, LOCAL_CAP)
    }

    /// One component of one joint's local scale.
    #[must_use]
    pub fn scale() -> Self {
        Self::by(StageBuffer::Scales, 1, LOCAL_CAP)
    }

    /// One element of the linear part of one joint's `model_from_joint`.
    #[must_use]
    pub fn model() -> Self {
        Self::by(StageBuffer::ModelRow1, 1, MODEL_CAP)
    }

    /// One joint's position in model space.
    #[must_use]
    pub fn position() -> Self {
        Self::by(StageBuffer::ModelRow1, 3, MODEL_CAP)
    }

    /// One element of one palette entry.
    #[must_use]
    pub fn palette() -> Self {
        Self::by(StageBuffer::Palette, 1, MODEL_CAP)
    }

    /// One element of one joint's `model_from_joint`, off by a rounding error: for the check of
    /// Transform alone.
    #[must_use]
    pub fn model_rounding() -> Self {
        Self::by(StageBuffer::ModelRow1, 1, ROUNDING_CAP)
    }

    /// One element of one palette entry, off by a rounding error: for the check of Write-back
    /// alone.
    #[must_use]
    pub fn palette_rounding() -> Self {
        Self::by(StageBuffer::Palette, 1, ROUNDING_CAP)
    }

    /// One element of one palette entry, off by one unit in the last place, in crowds of more than
    /// one member.
    #[must_use]
    pub fn palette_bit() -> Self {
        Self { amount: Amount::OneUnitIfManyMembers, ..Self::palette() }
    }

    /// One slot's weight.
    #[must_use]
    pub fn weight() -> Self {
        Self::by(StageBuffer::Samples, 3, LOCAL_CAP)
    }
}

/// A decorator that forwards to a backend and corrupts the data read back.
pub struct Broken<B> {
    inner: B,
    corruption: Corruption,
    target: Option<usize>,
}

impl<B: Backend> Broken<B> {
    /// Wraps a backend.
    pub fn new(inner: B, corruption: Corruption) -> Self {
        Self { inner, corruption, target: None }
    }

    /// Chooses the element to corrupt: in the middle of the last member's range.
    fn choose_target(&mut self, tables: &Tables) {
        let members = tables.members().as_slice();
        let used = || members.iter().enumerate().filter(|(_, m)| m.body != NONE);
        let body =
            |m: &populace_device::layout::Member| tables.bodies().as_slice()[m.body as usize];
        let alone = used().count() < 2;
        let target = match self.corruption.buffer {
            StageBuffer::Samples => {
                used().next_back().map(|(place, _)| place * tables.slots_per_member())
            }
            StageBuffer::Palette => used()
                .rfind(|(_, m)| body(m).entry_count > 0)
                .map(|(_, m)| 3 * (m.palette_first + body(m).entry_count / 2) as usize + 1),
            _ => {
                used().next_back().map(|(_, m)| (m.joint_first + body(m).joint_count / 2) as usize)
            }
        };
        self.target =
            target.filter(|_| !(alone && self.corruption.amount == Amount::OneUnitIfManyMembers));
    }
}

impl<B: Backend> Backend for Broken<B> {
    fn device_name(&self) -> String {
        format!("broken {}", self.inner.device_name())
    }

    fn schedule(&self) -> Schedule {
        self.inner.schedule()
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.inner.update(tables)
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        self.inner.set_stages(stages)
    }

    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError> {
        self.choose_target(tables);
        self.inner.run_stage(tables, frame, stage)
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.choose_target(tables);
        self.inner.run(tables, frame)
    }

    fn undo_frame(&mut self) {
        self.inner.undo_frame();
    }

    fn runs_ahead(&self) -> bool {
        self.inner.runs_ahead()
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError> {
        self.inner.read(tables, buffer, first, into)?;
        let within = self.target.and_then(|target| target.checked_sub(first));
        if let Some(element) = within.and_then(|at| into.get_mut(at))
            && buffer == self.corruption.buffer
        {
            let value = &mut element.0[self.corruption.component];
            *value = match self.corruption.amount {
                Amount::By(amount) => *value + amount,
                Amount::OneUnitIfManyMembers => f32::from_bits(value.to_bits() ^ 1),
            };
        }
        Ok(())
    }

    fn write(
        &mut self,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), BackendError> {
        self.inner.write(buffer, first, from)
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        self.inner.finish()
    }

    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        self.inner.fetch_watched(tables, tick)
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        self.inner.fetched()
    }

    fn forget_fetched(&mut self) {
        self.inner.forget_fetched();
    }

    fn frame_time_ms(&mut self) -> Option<f64> {
        self.inner.frame_time_ms()
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        self.inner.stage_times_ms()
    }

    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError> {
        self.inner.write_floor(tables)
    }

    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

impl<B: Backend> PaletteSource for Broken<B> {
    fn page_lengths(&self) -> Vec<usize> {
        self.inner.page_lengths()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        self.inner.refuses(transport, context)
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.inner.set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        self.inner.release_palettes()
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        self.inner.with_page(page, reader)
    }
}
