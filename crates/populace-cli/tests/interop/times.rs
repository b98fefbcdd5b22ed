//! Measures the time of each transport. Run it by `cargo test --release -p populace-cli --test
//! interop times -- --ignored --nocapture`.

use std::time::Instant;

use populace::{Device, Devices};

use crate::fixture::{PeopleCrowd, RenderSession};

const MEMBERS: u16 = 10_000;
const FRAMES: usize = 21;

/// Returns the median milliseconds of a finished update, and of acquiring its palettes.
fn frame_ms(device: &Devices, by_copy: bool) -> [f64; 2] {
    let mut session = RenderSession::new();
    let mut people = PeopleCrowd::new(device, MEMBERS, &session);
    let mut times = [Vec::new(), Vec::new()];
    for frame in 0..FRAMES + 3 {
        let start = Instant::now();
        people.update();
        people.crowd.finish().unwrap();
        let updated = Instant::now();
        if by_copy {
            session.renderer.acquire_palettes(&mut people.by_copy()).unwrap();
        } else {
            session.renderer.acquire_palettes(&mut people.crowd).unwrap();
        }
        if frame >= 3 {
            times[0].push((updated - start).as_secs_f64() * 1e3);
            times[1].push(updated.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[FRAMES / 2]
    })
}

#[expect(clippy::print_stdout, reason = "a measurement prints its results")]
#[ignore = "a measurement, not a test"]
#[test]
fn times_of_each_transport() {
    let both = [Device::native(), Device::opencl(0)];
    for device in [both[0].into(), both[1].into(), Devices::from(both)] {
        for (name, by_copy) in
            [("copied", true), ("mapped", false), ("copied", true), ("mapped", false)]
        {
            let [update, acquire] = frame_ms(&device, by_copy);
            println!(
                "{device}, {MEMBERS} people, {name}: update {update:.2} ms, acquire {acquire:.3} ms"
            );
        }
    }
}
