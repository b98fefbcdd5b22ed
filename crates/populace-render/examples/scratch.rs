//! x
#[path = "../tests/drawing/fixture.rs"]
#[allow(dead_code, unreachable_pub, missing_docs)]
mod fixture;
use fixture::*;
use populace_render::*;
use std::time::Instant;
fn main() {
    let t = Instant::now();
    let mut r = Renderer::headless([1280, 720]).unwrap();
    println!("{} {:?}", r.driver(), t.elapsed());
    let h = r
        .add_character(&person([0.7, 0.72, 0.7], [0.8, 0.5, 0.35]), &|_| false)
        .unwrap();
    let n: u32 = std::env::args().nth(1).map_or(200, |a| a.parse().unwrap());
    let mut pal = Vec::new();
    let mut list = Vec::new();
    let side = (n as f32).sqrt().ceil() as u32;
    let (mut lo, mut hi) = ([0f32; 3], [0f32, 1.8, 0.]);
    let mut seed = 1u32;
    let mut rnd = move || {
        seed = seed.wrapping_mul(1664525).wrapping_add(1013904223);
        (seed >> 8) as f32 / 16777216.0
    };
    for i in 0..n {
        let lean = rnd() * 0.3 - 0.15;
        let body = place([0.0; 3], lean, [1.0; 3]);
        let head = body
            .mul(&place([0.0, 1.45, 0.0], rnd() - 0.5, [1.0; 3]))
            .mul(&at(0.0, -1.45, 0.0));
        pal.extend(palette(&[body, head]));
        let x = ((i % side) as f32 - side as f32 / 2.0) * 1.3 + rnd() * 0.8;
        let z = -((i / side) as f32) * 1.3 + rnd() * 0.8;
        let yaw = glam::Quat::from_rotation_y(rnd() * 1.6 - 0.8).to_array();
        let s = 0.9 + 0.2 * rnd();
        let w = populace_core::Affine::from_trs(&populace_core::Trs {
            translation: [x, 0.0, z],
            rotation: yaw,
            scale: [s; 3],
        });
        for (k, v) in [(0, x), (2, z)] {
            lo[k] = lo[k].min(v - 0.4);
            hi[k] = hi[k].max(v + 0.4);
        }
        list.push(Instance {
            character: h,
            world_from_model: w,
            palette_first: i * 2,
            tint: [0.3 + 0.7 * rnd(), 0.3 + 0.7 * rnd(), 0.3 + 0.7 * rnd()],
        });
    }
    r.upload_page(0, &pal).unwrap();
    let scene = Scene {
        camera: Camera::framing(lo, hi, 16.0 / 9.0),
        ..Scene::default()
    };
    println!("{:?}", scene.camera);
    for _ in 0..4 {
        let t = Instant::now();
        r.draw(&scene, &list).unwrap();
        let d = t.elapsed();
        let im = r.read_image().unwrap();
        println!("draw {d:?} all {:?}", t.elapsed());
        write_png("/tmp/render_scratch.png", &im).unwrap();
    }
}
