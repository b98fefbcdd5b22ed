//! Crowds on several devices give the same results as on one.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

use std::process::Command;
use std::sync::Arc;

use populace::character::{Character, CharacterSource, PaletteEntry};
use populace::clip::Clip;
use populace::interop::PaletteSource;
use populace::model::{ClipSource, Interpolation, JointSource, Property, Skeleton, Track};
use populace::{Affine, JointIndex};
use populace::{
    CharacterId, ClipPlayback, Crowd, Device, Devices, DevicesError, Error, Instance, MemberId,
    Placement, Schedule, Split, Trs,
};
use populace_device::layout::Float4;
use populace_testkit::Rng;

/// A chain of joints, and a clip that lifts each by its index in metres.
fn chain(joint_count: u16) -> Arc<Character> {
    let name = |joint: u16| format!("joint {joint}");
    let joint = |index: u16| JointSource {
        name: name(index),
        parent: index.checked_sub(1).map(usize::from),
        rest: Trs { translation: [0.0, 0.1, 0.0], ..Trs::IDENTITY },
    };
    let skeleton = Skeleton::new(&(0..joint_count).map(joint).collect::<Vec<_>>()).unwrap();
    let track = |joint: u16| Track {
        joint: name(joint),
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, f32::from(joint), 0.0, 1.0, f32::from(joint) + 0.5, 0.0],
    };
    let source = ClipSource { name: "Lift".into(), tracks: (0..joint_count).map(track).collect() };
    let clips = vec![Arc::new(Clip::new(source, &skeleton).unwrap())];
    let entry = |joint: u16| PaletteEntry {
        joint: JointIndex(joint.into()),
        joint_from_bind: Affine::IDENTITY,
    };
    let palette = (0..joint_count).map(entry).collect();
    let (parts, materials, images, skins) = (vec![], vec![], vec![], vec![]);
    let name = format!("a chain of {joint_count}");
    let source =
        CharacterSource { name, skeleton, palette, parts, materials, images, skins, clips };
    Arc::new(Character::new(source).unwrap())
}

/// A crowd in which members are spawned and despawned at random, in the same order in each scene.
struct Scene {
    crowd: Crowd,
    characters: Vec<CharacterId>,
    members: Vec<MemberId>,
    random: Rng,
}

impl Scene {
    fn new(devices: &Devices, schedule: Schedule, split: Split) -> Self {
        let builder = Crowd::builder().devices(devices.clone()).schedule(schedule).split(split);
        let mut crowd = builder.capacity(5000).build().unwrap();
        let characters =
            [1, 5, 40].map(|joints| crowd.add_character(chain(joints)).unwrap()).to_vec();
        Self { crowd, characters, members: Vec::new(), random: Rng::new(11) }
    }

    fn step(&mut self) {
        for _ in 0..self.random.below(200) {
            let character = self.characters[self.random.below(self.characters.len())];
            let member = self.crowd.spawn(character, Placement::at([0.0; 3])).unwrap();
            let lift = self.crowd.clip(character, "Lift").unwrap();
            let phase = f32::from(u16::try_from(self.random.below(100)).unwrap()) / 100.0;
            self.crowd
                .member_mut(member)
                .unwrap()
                .play(lift, ClipPlayback::looping().phase(phase))
                .unwrap();
            self.members.push(member);
        }
        for _ in 0..self.random.below(self.members.len().min(180) + 1) {
            let member = self.members.swap_remove(self.random.below(self.members.len()));
            self.crowd.despawn(member).unwrap();
        }
        self.crowd.update(0.03).unwrap();
    }

    /// Asserts that palettes and joints equal those of a twin on one device: palettes of all
    /// members from their pages, and palettes, joints and poses of every seventh member by itself.
    #[track_caller]
    fn assert_same(&mut self, twin: &mut Self, when: &str) {
        let mut pages: [Vec<Vec<Float4>>; 2] = Default::default();
        for (crowd, pages) in [&mut self.crowd, &mut twin.crowd].into_iter().zip(&mut pages) {
            for page in 0..crowd.page_lengths().len() {
                crowd.with_page(page, &mut |elements| pages.push(elements.to_vec())).unwrap();
            }
        }
        let places = |crowd: &Crowd| -> Vec<_> {
            let entries = |i: &Instance| i.character.palette.len();
            crowd.instances().map(|i| (i.palette_first as usize, entries(&i))).collect()
        };
        let found = places(&self.crowd);
        assert_eq!(found, places(&twin.crowd));
        let ids = |crowd: &Crowd| crowd.members().map(|m| m.id()).collect::<Vec<_>>();
        let pairs = ids(&self.crowd).into_iter().zip(ids(&twin.crowd));
        for (nth, ((ours, theirs), (first, entries))) in pairs.zip(found).enumerate() {
            let elements = first * 3..(first + entries) * 3;
            let [page, twin_page] = [0, 1].map(|of| &pages[of][0][elements.clone()]);
            assert!(page == twin_page, "{when}: member {nth} in its page");
            if nth % 7 == 0 {
                let palette = twin.crowd.member_mut(theirs).unwrap().palette().unwrap();
                assert!(
                    self.crowd.member_mut(ours).unwrap().palette().unwrap() == palette,
                    "{when}: member {nth}"
                );
                let rows = palette.iter().flat_map(|matrix| matrix.rows);
                assert!(rows.eq(page.iter().map(|e| e.0)), "{when}: palette of member {nth}");
                let joints = self.crowd.member_mut(ours).unwrap().model_from_joints().unwrap();
                assert!(
                    joints == twin.crowd.member_mut(theirs).unwrap().model_from_joints().unwrap(),
                    "{when}: member {nth}"
                );
                let pose = self.crowd.member_mut(ours).unwrap().local_pose().unwrap();
                assert!(
                    pose == twin.crowd.member_mut(theirs).unwrap().local_pose().unwrap(),
                    "{when}: member {nth}"
                );
            }
        }
    }
}

/// Asserts that a split crowd gives the results of one device, while members come and go and the
/// split changes, including shares of 0 and 1.
fn assert_equals_one_device(devices: &Devices, schedule: Schedule) {
    let mut scene = Scene::new(devices, schedule, Split::Measured);
    let mut twin = Scene::new(&Device::native().into(), schedule, Split::Measured);
    let (count, mut random) = (devices.as_slice().len(), Rng::new(3));
    for step in 0..60 {
        let mut parts: Vec<f64> =
            (0..count).map(|_| f64::from(u16::try_from(random.below(4)).unwrap())).collect();
        parts[random.below(count)] += 1.0;
        let split = if step % 4 == 3 { Split::Measured } else { Split::Fixed(parts) };
        scene.crowd.set_split(&split).unwrap();
        scene.step();
        twin.step();
        // Not after each frame, so that some comparisons follow frames without a read.
        if step % 3 > 0 {
            scene.assert_same(&mut twin, &format!("{devices}, step {step}, {split}"));
        }
    }
}

#[test]
fn several_native_devices_give_the_results_of_one() {
    let threads = |threads| Device::Native { threads };
    for schedule in [Schedule::Fused, Schedule::Staged] {
        assert_equals_one_device(&[threads(1), threads(2), threads(3)].into(), schedule);
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn native_and_opencl_devices_give_the_results_of_one() {
    for schedule in [Schedule::Fused, Schedule::Staged] {
        assert_equals_one_device(&[Device::native(), Device::opencl(0)].into(), schedule);
        assert_equals_one_device(
            &[Device::opencl(0), Device::Native { threads: 1 }].into(),
            schedule,
        );
    }
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn parts_of_an_opencl_device_give_the_results_of_one() {
    let (first, second) = (Device::opencl_part(0, 1, 2), Device::opencl_part(0, 2, 2));
    assert_equals_one_device(&[first, second].into(), Schedule::Fused);
    assert_equals_one_device(
        &[second, Device::Native { threads: 1 }, first].into(),
        Schedule::Fused,
    );
}

#[test]
fn devices_and_load_shares_can_be_changed_at_any_time() {
    let [one, two] = [1, 2].map(|threads| Device::Native { threads });
    let mut scene = Scene::new(&[one, two].into(), Schedule::Fused, Split::Fixed(vec![30.0, 10.0]));
    assert_eq!(
        (scene.crowd.device_info().devices.to_string(), scene.crowd.device_info().shares),
        ("native:1+native:2".into(), vec![0.75, 0.25])
    );
    scene.step();
    assert_eq!(scene.crowd.device_info().shares, [0.75, 0.25], "fixed shares changed");
    let error = scene.crowd.set_split(&Split::Fixed(vec![1.0])).unwrap_err();
    assert!(matches!(&error, Error::Devices(DevicesError::BadSplit(_))), "{error}");
    assert_eq!(scene.crowd.device_info().shares, [0.75, 0.25]);
    scene.crowd.move_to(one).unwrap();
    assert_eq!(
        (scene.crowd.device_info().devices, scene.crowd.device_info().shares),
        (Devices::from(one), vec![1.0])
    );
    scene.step();
    scene.crowd.move_to([two, one]).unwrap();
    assert_eq!(scene.crowd.device_info().shares, [0.5, 0.5]);
    let error = scene.crowd.move_to([two, two]).unwrap_err();
    assert!(matches!(&error, Error::Devices(DevicesError::BadDevices { .. })), "{error}");
    let error = Crowd::builder().devices([]).build().map(|_| ()).unwrap_err();
    assert_eq!(error.to_string(), "no device is named; name at least one");
    assert!(Crowd::builder().device(one).split(Split::Fixed(vec![1.0, 1.0])).build().is_err());
    let mut twin = Scene::new(&Device::native().into(), Schedule::Fused, Split::Measured);
    (0..2).for_each(|_| twin.step());
    scene.step();
    twin.step();
    scene.assert_same(&mut twin, "after all moves");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn unsupported_device_part_is_refused() {
    let error =
        Crowd::builder().device(Device::opencl_part(0, 1, 1000)).build().map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("cannot be cut into 1000 equal parts"), "{error}");
    assert!(error.to_string().contains("name the whole device"), "{error}");
}

/// The native device has no form for GPUs, and nobody asked for it by name.
#[test]
fn crowds_without_opencl_fall_back_to_a_schedule_that_the_native_device_has() {
    const INNER: &str = "POPULACE_TEST_WITHOUT_OPENCL";
    if std::env::var_os(INNER).is_none() {
        let this_test = "crowds_without_opencl_fall_back_to_a_schedule_that_the_native_device_has";
        let mut process = Command::new(std::env::current_exe().unwrap());
        process.args(["--exact", this_test]).env(INNER, "1");
        process.env("OCL_ICD_VENDORS", "/nonexistent").env("OPENCL_VENDOR_PATH", "/nonexistent");
        assert!(process.status().unwrap().success());
        return;
    }
    let crowd = Crowd::builder().schedule(Schedule::FusedGrouped).build().unwrap();
    let info = crowd.device_info();
    assert_eq!((info.devices, info.schedule), (Device::native().into(), Schedule::Fused));
    assert!(info.fallback.is_some());
}
