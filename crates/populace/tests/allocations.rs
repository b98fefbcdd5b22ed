//! Allocations of frames, counted over all threads. On OpenCL devices, checks of debug builds and
//! the driver allocate too, so only the native device is counted.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

use std::alloc::System;

use populace::{
    CharacterId, ClipId, ClipPlayback, Crowd, Device, MemberId, Placement, Schedule, doc_fixture,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static COUNTED: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

const FRAMES: usize = 40;

/// The change of some members before a frame.
type Change = fn(&mut Scene, usize);

struct Scene {
    crowd: Crowd,
    knight: CharacterId,
    clips: [ClipId; 2],
    members: Vec<MemberId>,
}

impl Scene {
    fn new(schedule: Schedule) -> Self {
        let builder = Crowd::builder().device(Device::native()).schedule(schedule);
        let mut crowd = builder.build().unwrap();
        let knight = doc_fixture::knight(&mut crowd).unwrap();
        let clips = ["Idle", "Walk"].map(|name| crowd.clip(knight, name).unwrap());
        let spawn = |_| crowd.spawn(knight, Placement::at([0.0; 3])).unwrap();
        let members = (0..600).map(spawn).collect();
        let mut scene = Self { crowd, knight, clips, members };
        (0..scene.members.len()).for_each(|nth| scene.play(nth, 0));
        scene
    }

    fn play(&mut self, nth: usize, clip: usize) {
        let play = ClipPlayback::looping().fade_in_secs(0.05);
        let mut member = self.crowd.member_mut(self.members[nth]).unwrap();
        member.play(self.clips[clip], play).unwrap();
    }

    fn exchange(&mut self, nth: usize) {
        self.crowd.despawn(self.members[nth]).unwrap();
        let place = Placement::at([nth as f32, 0.0, 0.0]);
        self.members[nth] = self.crowd.spawn(self.knight, place).unwrap();
    }

    /// Returns the allocations of a frame in which every seventh member changes, in turn.
    fn allocations(&mut self, frame: usize, change: Change) -> usize {
        let region = Region::new(COUNTED);
        for nth in (frame % 7..self.members.len()).step_by(7) {
            change(self, nth);
        }
        self.crowd.update(1.0 / 60.0).unwrap();
        self.crowd.finish().unwrap();
        let counted = region.change();
        counted.allocations + counted.reallocations
    }
}

#[test]
fn frames_allocate_nothing() {
    let changes: [(&str, Change); 3] = [
        ("no changes", |_, _| ()),
        ("crossfades", |scene, nth| scene.play(nth, nth % 2)),
        ("members that go and come", |scene, nth| {
            scene.exchange(nth);
            scene.play(nth, 1);
        }),
    ];
    for schedule in [Schedule::Fused, Schedule::Staged] {
        let mut scene = Scene::new(schedule);
        for (what, change) in changes {
            for frame in 0..FRAMES {
                scene.allocations(frame, change);
            }
            let all: Vec<_> = (0..FRAMES).map(|frame| scene.allocations(frame, change)).collect();
            // The queue of threads' jobs allocates a block in some frames.
            let allocating = all.iter().filter(|count| **count > 0).count();
            assert!(allocating <= FRAMES / 4, "{schedule}, {what}: {all:?}");
            assert!(all.iter().all(|count| *count <= 1), "{schedule}, {what}: {all:?}");
        }
    }
}
