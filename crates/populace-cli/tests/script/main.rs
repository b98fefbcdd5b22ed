//! A long scripted run of all features, whose palettes keep their bits.
//!
//! The hashes below change only in a commit of their own that says which features compute
//! something else, and why.

mod cast;
mod scenes;

use populace::{Crowd, Device, Devices, Error, MemberId, Schedule};

use cast::Cast;

/// Seconds of a frame; an odd step among even ones.
const STEPS: [f32; 4] = [1.0 / 30.0, 1.0 / 30.0, 1.0 / 60.0, 0.041];
const FRAMES: usize = 24;

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

/// Runs one scene and returns the hash of the palettes of all its frames.
fn hash_of(scene: &scenes::Scene, devices: &Devices, schedule: Schedule) -> Result<u64, Error> {
    let builder = Crowd::builder().devices(devices.clone()).schedule(schedule);
    let mut crowd = builder.capacity(32).build()?;
    let cast = Cast::new(&mut crowd)?;
    let mut run = (scene.start)(&mut crowd, &cast)?;
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    for frame in 0..FRAMES {
        (run.step)(&mut crowd, frame)?;
        crowd.update(STEPS[frame % STEPS.len()])?;
        hash.add_palettes(&mut crowd, &run.members)?;
    }
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

#[test]
fn palettes_keep_their_bits_on_opencl_staged() {
    check(&Device::opencl(0).into(), Schedule::Staged);
}

#[test]
fn palettes_keep_their_bits_on_opencl_fused_wide() {
    check(&Device::opencl(0).into(), Schedule::FusedWide);
}

#[test]
fn palettes_keep_their_bits_on_opencl_fused_grouped() {
    check(&Device::opencl(0).into(), Schedule::FusedGrouped);
}
