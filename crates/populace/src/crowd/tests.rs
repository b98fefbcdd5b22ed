use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use populace_character::{Character, CharacterSource, PaletteEntry};
use populace_clip::Clip;
use populace_device::layout::Float4;
use populace_device::{
    Backend, BackendError, Frame, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, Schedule, Stage, StageBuffer, Tables, TargetMark,
};
use populace_model::{
    Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs,
};
use populace_native::NativeBackend;
use populace_settings::parts::{Key, Parts};

use super::*;
use crate::{ClipPlayback, Device, Placement};
use populace_backends::Engine;
use populace_backends::SplitBackend;

/// A backend whose operation `lost_in` fails like a lost device while `is_lost` is set.
struct FailingBackend {
    inner: NativeBackend,
    lost_in: &'static str,
    is_lost: Arc<AtomicBool>,
}

impl FailingBackend {
    fn check(&self, operation: &str) -> Result<(), BackendError> {
        if self.lost_in == operation && self.is_lost.load(Ordering::Relaxed) {
            let cause = "CL_DEVICE_NOT_AVAILABLE".into();
            return Err(BackendError::Failed {
                device: self.device_name(),
                operation: operation.into(),
                cause,
            });
        }
        Ok(())
    }
}

impl Backend for FailingBackend {
    fn device_name(&self) -> String {
        "the failing device".into()
    }

    fn schedule(&self) -> Schedule {
        self.inner.schedule()
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.check("update")?;
        self.inner.update(tables)
    }

    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError> {
        self.inner.run_stage(tables, frame, stage)
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.check("run")?;
        self.inner.run(tables, frame)
    }

    fn undo_frame(&mut self) {
        self.inner.undo_frame();
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), BackendError> {
        self.inner.read(tables, buffer, first, into)
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

    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError> {
        self.inner.write_floor(tables)
    }

    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

impl PaletteSource for FailingBackend {
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

/// A character of one joint, with a clip "Lift" that lifts it by 1 m.
pub(super) fn lift() -> Character {
    let joint = JointSource { name: "base".into(), parent: None, rest: Trs::IDENTITY };
    let skeleton = Skeleton::new(&[joint]).unwrap();
    let track = Track {
        joint: "base".into(),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    };
    let clip =
        Clip::new(ClipSource { name: "Lift".into(), tracks: vec![track] }, &skeleton).unwrap();
    let palette = vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }];
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let (name, clips) = ("lift".into(), vec![Arc::new(clip)]);
    Character::new(CharacterSource {
        name,
        skeleton,
        palette,
        parts,
        materials,
        images,
        skins,
        clips,
    })
    .unwrap()
}

fn spawn(crowd: &mut Crowd, count: u8) {
    let key = Key { crowd: crowd.state.base.number, index: 0, generation: 0 };
    let id = CharacterId::from_parts(key);
    let clip = crowd.clip(id, "Lift").unwrap();
    for nth in 0..count {
        let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
        crowd
            .member_mut(member)
            .unwrap()
            .play(clip, ClipPlayback::looping().phase(f32::from(nth) / 256.0))
            .unwrap();
    }
}

fn palettes(crowd: &mut Crowd) -> Vec<Vec<Affine>> {
    let members: Vec<_> = crowd.members().map(|m| m.id()).collect();
    members.into_iter().map(|member| crowd.member_mut(member).unwrap().palette().unwrap()).collect()
}

fn crowd() -> Crowd {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    crowd.add_character(lift()).unwrap();
    spawn(&mut crowd, 100);
    crowd
}

/// A crowd on a native device and a [`FailingBackend`] one, and the flag that makes the latter
/// fail.
fn crowd_with_failing_backend(operation: &'static str) -> (Crowd, Arc<AtomicBool>) {
    let lost = Arc::new(AtomicBool::new(false));
    let native = || NativeBackend::new(1, Schedule::Fused).unwrap();
    let second = FailingBackend { inner: native(), lost_in: operation, is_lost: Arc::clone(&lost) };
    let backends: Vec<Box<dyn Backend>> = vec![Box::new(native()), Box::new(second)];
    let mut crowd = crowd();
    crowd.device.opened.engine = Engine::Split(Box::new(SplitBackend::new(backends, None)));
    (crowd, lost)
}

#[test]
fn lost_device_is_named_in_the_error() {
    for operation in ["update", "run"] {
        let (mut crowd, lost) = crowd_with_failing_backend(operation);
        (0..3).for_each(|_| crowd.update(0.1).unwrap());
        lost.store(true, Ordering::Relaxed);
        for _ in 0..2 {
            let error = crowd.update(0.1).unwrap_err().to_string();
            assert_eq!(
                error,
                format!("the failing device failed to {operation}: CL_DEVICE_NOT_AVAILABLE")
            );
        }
    }
}

#[test]
fn crowd_continues_after_a_move_or_the_return_of_a_lost_device() {
    for operation in ["update", "run"] {
        for moves in [true, false] {
            let (mut crowd, lost) = crowd_with_failing_backend(operation);
            let mut twin = self::crowd();
            (0..3).for_each(|_| crowd.update(0.1).unwrap());
            (0..3).for_each(|_| twin.update(0.1).unwrap());
            [&mut crowd, &mut twin].into_iter().for_each(|crowd| spawn(crowd, 30));
            lost.store(true, Ordering::Relaxed);
            (0..2).for_each(|_| drop(crowd.update(0.1).unwrap_err()));
            if moves {
                crowd.move_to(Device::native()).unwrap();
            } else {
                lost.store(false, Ordering::Relaxed);
            }
            crowd.update(0.1).unwrap();
            twin.update(0.1).unwrap();
            let found = palettes(&mut crowd);
            assert!(found == palettes(&mut twin), "lost in {operation}, moved: {moves}");
            assert_eq!(found.len(), 130);
        }
    }
}

#[test]
fn reads_are_refused_after_a_failed_update() {
    for operation in ["update", "run"] {
        let (mut crowd, lost) = crowd_with_failing_backend(operation);
        crowd.update(0.1).unwrap();
        let member = crowd.members().map(|m| m.id()).next().unwrap();
        assert!(
            crowd.member_mut(member).and_then(|mut m| m.palette()).is_ok()
                && crowd.member_mut(member).and_then(|mut m| m.local_pose()).is_ok()
        );
        lost.store(true, Ordering::Relaxed);
        crowd.update(0.1).unwrap_err();
        let refused = Error::Backend(BackendError::NotEvaluated);
        assert_eq!(
            crowd.member_mut(member).and_then(|mut m| m.palette()),
            Err(refused.clone()),
            "lost in {operation}"
        );
        assert_eq!(
            crowd.member_mut(member).and_then(|mut m| m.model_from_joints()),
            Err(refused.clone()),
            "lost in {operation}"
        );
        assert_eq!(
            crowd.member_mut(member).and_then(|mut m| m.local_pose()),
            Err(refused.clone()),
            "lost in {operation}"
        );
        assert_eq!(crowd.with_page(0, &mut |_| {}), Err(refused), "lost in {operation}");
        let released = crowd.release_palettes().map(|_| ());
        assert_eq!(released, Err(BackendError::NotEvaluated), "lost in {operation}");
        assert_eq!(
            crowd.member_mut(member).and_then(|mut m| m.moved_placement()),
            Ok(Placement::at([0.0; 3]))
        );
        lost.store(false, Ordering::Relaxed);
        crowd.update(0.1).unwrap();
        assert!(
            crowd.member_mut(member).and_then(|mut m| m.palette()).is_ok()
                && crowd.member_mut(member).and_then(|mut m| m.local_pose()).is_ok()
        );
    }
}

#[test]
fn gaze_that_changes_targets_keeps_few_watches() {
    use crate::Gaze;
    use populace_device::GazeLimits;
    let mut crowd = crowd();
    let members: Vec<_> = crowd.members().map(|m| m.id()).collect();
    let joint = JointIndex(0);
    let limits = GazeLimits { yaw_rad: 1.0, up_rad: 0.5, down_rad: 0.5 };
    let gaze = Gaze { chain: vec![(joint, 1.0)], facing: [0.0, 0.0, 1.0], limits };
    for other in &members[1..] {
        let target = crate::Target::Joint { member: *other, joint };
        crowd
            .member_mut(members[0])
            .unwrap()
            .look_at_with(&gaze, target, crate::Weight::FULL.over_secs(0.1))
            .unwrap();
        crowd.update(0.2).unwrap();
    }
    assert!(
        crowd.state.constraints.watch_count() <= 2,
        "{} joints are watched",
        crowd.state.constraints.watch_count()
    );
    crowd.member_mut(members[0]).unwrap().clear_look_at(0.0).unwrap();
    crowd.member_mut(members[0]).unwrap().clear_look_at(0.0).unwrap();
    assert_eq!(crowd.state.constraints.watch_count(), 0, "joints are still watched");
    assert_eq!(crowd.state.base.tables.watched_elements(), 0);
    assert!(crowd.state.constraints.is_empty(), "programs that do nothing are kept");
}

#[test]
fn refused_constraints_watch_nothing() {
    let mut crowd = crowd();
    let members: Vec<_> = crowd.members().map(|m| m.id()).collect();
    let target = crate::Target::Joint { member: members[1], joint: JointIndex(0) };
    let mut view = crowd.member_mut(members[0]).unwrap();
    let (first, beyond) = (JointIndex(0), JointIndex(99));
    view.reach_with_chain(first, beyond, target, crate::Weight::FULL).unwrap_err();
    assert_eq!(crowd.state.constraints.watch_count(), 0, "a joint is still watched");
    assert!(crowd.state.constraints.is_empty(), "programs that do nothing are kept");
    assert_eq!(crowd.state.base.tables.watched_elements(), 0);
    assert_eq!(crowd.seek(1.0).unwrap().inexact, []);
}

#[test]
fn refused_proportions_name_what_is_wrong() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(lift()).unwrap();
    let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
    let mut view = crowd.member_mut(member).unwrap();
    for (factors, text) in [
        (&[1.0, 1.0][..], "the number of factors of proportions is 2; it must be 1"),
        (&[-0.5], "a factor of proportions is -0.5; it must be above zero and at most 1e4"),
        (&[f32::NAN], "a factor of proportions is NaN; it must be above zero and at most 1e4"),
    ] {
        assert_eq!(view.set_proportions(factors).unwrap_err().to_string(), text);
    }
}

#[test]
fn proportions_stay_as_long_as_any_member_has_them() {
    let mut crowd = Crowd::builder().device(Device::native()).build().unwrap();
    let id = crowd.add_character(lift()).unwrap();
    let clip = crowd.clip(id, "Lift").unwrap();
    let with = |crowd: &mut Crowd, factor| {
        let member = crowd.spawn(id, Placement::at([0.0; 3])).unwrap();
        let mut view = crowd.member_mut(member).unwrap();
        view.play(clip, ClipPlayback::held_at_secs(1.0)).unwrap();
        view.set_proportions(&[factor]).unwrap();
        member
    };
    let [first, second] = [2.0, 2.0].map(|factor| with(&mut crowd, factor));
    crowd.despawn(first).unwrap();
    let [third, fourth] = [3.0, 3.0].map(|factor| with(&mut crowd, factor));
    for factor in [5.0, 5.0, 4.0] {
        crowd.member_mut(third).unwrap().set_proportions(&[factor]).unwrap();
    }
    crowd.update(0.0).unwrap();
    for (member, height) in [(second, 2.0), (third, 4.0), (fourth, 3.0)] {
        let joints = crowd.member_mut(member).unwrap().model_from_joints().unwrap();
        assert!((joints[0].rows[1][3] - height).abs() < 1e-3, "{joints:?} instead of {height} m");
    }
    for member in [second, third, fourth] {
        crowd.despawn(member).unwrap();
    }
    assert!(crowd.state.base.tables.joint_scales().as_slice().is_empty(), "factors are kept");
}
