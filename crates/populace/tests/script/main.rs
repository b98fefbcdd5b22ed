//! A long scripted run of all features, whose palettes keep their bits, also when frames are played
//! again from a snapshot.
//!
//! The hashes below change only in a commit of their own that says which features compute
//! something else, and why.

mod cast;
mod scenes;

use std::ops::Range;

use populace::{Crowd, Device, Devices, Error, MemberId, Schedule};

use cast::Cast;

/// Seconds of a frame; an odd step among even ones.
const STEPS: [f32; 4] = [1.0 / 30.0, 1.0 / 30.0, 1.0 / 60.0, 0.041];
const FRAMES: usize = 24;
/// The frame before which a snapshot is taken. The frames from it on are played twice.
const SNAPSHOT: usize = 9;

/// FNV-1a over 64 bits.
struct Hash(u64);

impl Hash {
    fn add(&mut self, bits: u32) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn add_palettes(&mut self, crowd: &mut Crowd, members: &[MemberId]) -> Result<(), Error> {
        for member in members {
            let palette = crowd.member_mut(*member)?.palette()?;
            assert!(!palette.is_empty(), "a member without a palette proves nothing");
            for number in palette.iter().flat_map(|entry| entry.rows).flatten() {
                assert!(number.is_finite());
                self.add(number.to_bits());
            }
        }
        Ok(())
    }
}

/// Runs one scene and returns the hash of the palettes of all its frames. Then plays the last frames
/// once more from a snapshot.
fn hash_of(scene: &scenes::Scene, devices: &Devices, schedule: Schedule) -> Result<u64, Error> {
    let builder = Crowd::builder().devices(devices.clone()).schedule(schedule);
    let mut crowd = builder.capacity(32).build()?;
    let cast = Cast::new(&mut crowd)?;
    let mut run = (scene.start)(&mut crowd, &cast)?;
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    let mut play = |crowd: &mut Crowd, hash: &mut Hash, frames: Range<usize>| {
        for frame in frames {
            (run.step)(crowd, frame)?;
            crowd.update(STEPS[frame % STEPS.len()])?;
            hash.add_palettes(crowd, &run.members)?;
        }
        Ok::<_, Error>(())
    };
    play(&mut crowd, &mut hash, 0..SNAPSHOT)?;
    let (snapshot, mut replayed) = (crowd.snapshot()?, Hash(hash.0));
    play(&mut crowd, &mut hash, SNAPSHOT..FRAMES)?;
    crowd.restore(&snapshot)?;
    play(&mut crowd, &mut replayed, SNAPSHOT..FRAMES)?;
    assert_eq!(replayed.0, hash.0, "{}: another run from the snapshot", scene.name);
    Ok(hash.0)
}

fn check(devices: &Devices, schedule: Schedule) {
    let hashes: Vec<(&str, u64)> = scenes::ALL
        .iter()
        .map(|scene| (scene.name, hash_of(scene, devices, schedule).expect(scene.name)))
        .collect();
    let wanted: Vec<(&str, u64)> =
        scenes::ALL.iter().map(|scene| (scene.name, scene.hash)).collect();
    assert_eq!(hashes, wanted, "{devices}, {schedule}: palettes changed");
}

#[test]
fn palettes_keep_their_bits_on_native_fused() {
    check(&Device::Native { threads: 2 }.into(), Schedule::Fused);
}

#[test]
fn palettes_keep_their_bits_on_native_staged() {
    check(&Device::Native { threads: 1 }.into(), Schedule::Staged);
}

#[test]
fn palettes_keep_their_bits_on_two_native_devices() {
    let devices = [Device::Native { threads: 1 }, Device::Native { threads: 2 }];
    check(&devices.into(), Schedule::Fused);
}

/// On OpenCL, whose kernels with users' stages take long to build.
#[cfg(not(skip_opencl))]
mod slow {
    use super::*;

    #[test]
    #[ignore = "make test-slow"]
    fn palettes_keep_their_bits_on_opencl_staged() {
        check(&Device::opencl(0).into(), Schedule::Staged);
    }

    #[test]
    #[ignore = "make test-slow"]
    fn palettes_keep_their_bits_on_opencl_fused_wide() {
        check(&Device::opencl(0).into(), Schedule::FusedWide);
    }

    #[test]
    #[ignore = "make test-slow"]
    fn palettes_keep_their_bits_on_opencl_fused_grouped() {
        check(&Device::opencl(0).into(), Schedule::FusedGrouped);
    }
}
