use populace::*;
use populace_locomotion::*;
use populace_scene::*;
use populace_trajectory::*;
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let secs: f32 = std::env::args().nth(2).map_or(20.0, |s| s.parse().unwrap());
    let fps: f32 = std::env::args().nth(3).map_or(25.0, |s| s.parse().unwrap());
    let t = Instant::now();
    let rec = load(path.as_ref(), &ReadSettings::default()).unwrap();
    println!("load {:?} {} agents", t.elapsed(), rec.agents.len());
    let mut crowd = Crowd::builder().device(Device::native()).capacity(1200).build().unwrap();
    let t = Instant::now();
    let cast = populace_cast::cast().unwrap();
    let mut ids = vec![];
    let mut gaits = vec![];
    for c in cast {
        let id = crowd.add_character(Arc::new(c)).unwrap();
        gaits.push(GaitSpace::of(&mut crowd, id).unwrap());
        ids.push(id);
    }
    println!("cast {:?}", t.elapsed());
    let people: Vec<_> = (0..rec.agents.len())
        .map(|i| Person { character: ids[i % ids.len()], scale: 1.0, look: None })
        .collect();
    let t = Instant::now();
    let mut replay = Replay::new(&rec, &people, gaits, rec.secs()[0]).unwrap();
    println!(
        "motions {:?} cutoff {} sway {}",
        t.elapsed(),
        replay.motions().cutoff_hz,
        replay.motions().sway_m
    );
    let mut meter = SkateMeter::new();
    let (mut a, mut u, mut m) = (0.0, 0.0, 0.0);
    let mut peak = 0;
    let frames = (secs * fps) as usize;
    replay.advance(&mut crowd, 0.0).unwrap();
    crowd.update(0.0).unwrap();
    for _ in 0..frames {
        let t = Instant::now();
        replay.advance(&mut crowd, 1.0 / fps).unwrap();
        a += t.elapsed().as_secs_f64();
        let t = Instant::now();
        crowd.update(1.0 / fps).unwrap();
        crowd.finish().unwrap();
        u += t.elapsed().as_secs_f64();
        let t = Instant::now();
        let present: Vec<_> = replay.present().collect();
        peak = peak.max(present.len());
        for (agent, member) in present {
            if agent % 10 == 0 {
                meter.sample(&mut crowd, member, 1.0 / fps).unwrap();
            }
        }
        m += t.elapsed().as_secs_f64();
    }
    println!(
        "advance {:.2} update {:.2} meter {:.2} ms, real time x {:.1}, peak {}",
        a * 1e3 / frames as f64,
        u * 1e3 / frames as f64,
        m * 1e3 / frames as f64,
        secs as f64 / (a + u + m),
        peak
    );
    println!("{:?} {:?}", meter.skate(), replay.position_error());
}
