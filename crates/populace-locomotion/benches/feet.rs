//! Cost of planted feet: `cargo bench -p populace-locomotion --bench feet`.
//!
//! Two crowds of 10,000 walking people take turns frame by frame, one with planted feet. Bodies have
//! soles, and clips have contacts. The native device and the best OpenCL device are measured. Times
//! are medians in milliseconds, from the call of `Crowd::update` to the end of the frame.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::error::Error;
use std::time::Instant;

use populace::{ClipPlayback, Crowd, Device, Placement};
use populace_locomotion::GaitSpace;

const PEOPLE: u16 = 10_000;
const FRAME_SECS: f32 = 1.0 / 60.0;
const WARM_UP: usize = 10;
const FRAMES: usize = 60;

/// Returns people who mix a walk and a run, each at a phase of its own.
fn people(device: Device, are_planted: bool) -> Result<Crowd, Box<dyn Error>> {
    let mut crowd =
        Crowd::builder().device(device).capacity(PEOPLE.into()).slots_per_member(2).build()?;
    let person = populace_cast::cast()?.into_iter().next().ok_or("the cast is empty")?;
    let person = crowd.add_character(person)?;
    let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(person, name));
    let (walk, run) = (walk?, run?);
    // Contacts of the clips are set here.
    GaitSpace::new(&mut crowd, person, idle?, &[walk, run])?;
    let mut random = fastrand::Rng::with_seed(1);
    for nth in 0..PEOPLE {
        let at = [f32::from(nth % 100), 0.0, f32::from(nth / 100)];
        let member = crowd.spawn(person, Placement::at(at))?;
        let (phase, share) = (random.f32(), random.f32());
        let mut member = crowd.member_mut(member)?;
        member.blend(walk, ClipPlayback::looping().phase(phase).weight(share))?;
        member.blend(run, ClipPlayback::looping().phase(phase).weight(1.0 - share))?;
        if are_planted {
            member.plant_feet(1.0)?;
        }
    }
    Ok(crowd)
}

fn frame_ms(crowd: &mut Crowd) -> Result<f64, Box<dyn Error>> {
    let start = Instant::now();
    crowd.update(FRAME_SECS)?;
    crowd.finish()?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{PEOPLE} people, milliseconds: {:>10} {:>10} {:>8}", "without", "planted", "ratio");
    for device in [Device::native(), Device::best_opencl()?] {
        let mut crowds = [people(device, false)?, people(device, true)?];
        let mut times = [vec![], vec![]];
        for frame in 0..WARM_UP + FRAMES {
            for (crowd, times) in crowds.iter_mut().zip(&mut times) {
                let ms = frame_ms(crowd)?;
                if frame >= WARM_UP {
                    times.push(ms);
                }
            }
        }
        let [without, planted] = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[FRAMES / 2]
        });
        let name = crowds[0].device_info().name.clone();
        println!("{name:<30} {without:>10.2} {planted:>10.2} {:>8.2}", planted / without);
    }
    Ok(())
}
