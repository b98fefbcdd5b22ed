//! The choice of visibility and levels of detail: `cargo bench -p populace --bench view`.
//!
//! People stand around the eye and turn slowly before it, so that some change their level and some
//! leave the view in each update; or all of them are seen from above by an eye that rises. The table
//! shows medians of the milliseconds of `FrameTimes::view_ms`.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::error::Error;
use std::sync::Arc;

use populace::character::Level;
use populace::interop::{VIEW_PLANES, View};
use populace::{Crowd, Device, Placement};

const UPDATES: u16 = 30;
/// Members in a row, a metre apart.
const ROW: u16 = 400;

/// Returns the middle of the milliseconds of some updates, from the view of each.
fn choice_ms(members: u32, view: impl Fn(u16) -> View) -> Result<f64, Box<dyn Error>> {
    let man = populace_cast::cast()?.swap_remove(1);
    let meshes: Vec<_> = man.parts.iter().map(|part| part.mesh.clone()).collect();
    let joint_count = man.skeleton.joint_count();
    let level = |error_m| Level { error_m, meshes: meshes.clone(), joint_count };
    let man = man.with_levels([0.003, 0.006, 0.01, 0.02, 0.04].map(level).to_vec())?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(members as usize).build()?;
    let id = crowd.add_character(Arc::new(man))?;
    for nth in 0..members {
        let [x, z] = [nth % u32::from(ROW), nth / u32::from(ROW)].map(|at| at as f32);
        crowd.spawn(id, Placement::at([x - 0.5 * f32::from(ROW), 0.0, -z]))?;
    }
    let mut all_ms = Vec::new();
    for update in 0..UPDATES {
        crowd.set_view(Some(view(update)))?;
        crowd.update(0.0)?;
        all_ms.push(crowd.frame_times().view_ms);
    }
    all_ms.sort_by(f64::total_cmp);
    Ok(all_ms[all_ms.len() / 2])
}

/// A view from the edge of the crowd, a quarter turn wide and high, that turns.
fn turning(update: u16) -> View {
    let k = std::f32::consts::FRAC_1_SQRT_2;
    let turn_rad = 0.01 * f32::from(update);
    let turned = |[x, y, z]: [f32; 3]| {
        let (sin, cos) = turn_rad.sin_cos();
        [cos * x + sin * z, y, cos * z - sin * x, 0.0]
    };
    let normals = [[k, 0.0, -k], [-k, 0.0, -k], [0.0, k, -k], [0.0, -k, -k], [0.0, 0.0, -1.0]];
    seen_from([0.0; 3], normals.map(turned))
}

/// A view of all people from above, that rises.
fn rising(update: u16) -> View {
    seen_from([0.0, 200.0 + f32::from(update), 0.0], [[0.0, 1.0, 0.0, 1000.0]; VIEW_PLANES])
}

fn seen_from(eye: [f32; 3], planes: [[f32; 4]; VIEW_PLANES]) -> View {
    let to_sun = Some([0.6, 0.8, 0.0]);
    View { eye, planes, pixels_per_metre: 1000.0, to_sun, error_px: 1.0 }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:>10} {:>18} {:>12}", "members", "a quarter in view", "all in view");
    for members in [1_000, 10_000, 100_000] {
        let ms = [choice_ms(members, turning)?, choice_ms(members, rising)?];
        println!("{members:>10} {:>18.3} {:>12.3}", ms[0], ms[1]);
    }
    Ok(())
}
