//! `populace demo`

use std::time::Instant;

use populace::Crowd;
use populace_render::{Camera, Renderer};

use crate::cast::{Wanted, built_in, role};
use crate::cli::{DemoArgs, build};
use crate::failure::Failure;
use crate::staging::{Plan, Staging};
use crate::studio::{Studio, check_output, devices_and_shares, drawn_with};

/// Frames that are timed.
const FRAMES: usize = 20;
const FRAME_SECS: f32 = 1.0 / 60.0;

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    check_output(&args.out, "png")?;
    let members = args.members;
    let renderer = Renderer::headless(args.size.0);
    let builder = args.device.crowd().capacity(members as usize).slots_per_member(1);
    let mut crowd = build(drawn_with(builder, &renderer))?;
    crate::report::talk!("{members} people made by code, on {}", crowd.device_name());
    let people = built_in("people")?;
    let roles = people
        .into_iter()
        .map(|person| role(&mut crowd, person, &[], Wanted::default()))
        .collect::<Result<Vec<_>, _>>()?;
    let plan = Plan { members, seed: args.seed, hide: &[], away_percent: 15 };
    let staging = Staging::new(&mut crowd, &roles, &plan)?;
    let frame_ms = time_frames(&mut crowd)?;
    let devices = devices_and_shares(&crowd);
    crate::report::talk!(
        "evaluating all of them on {devices} takes {frame_ms:.2} ms a frame, the median of {FRAMES}"
    );

    let [width, height] = args.size.0;
    let camera =
        Camera::framing(staging.framed([FRAMES as f32 * FRAME_SECS; 2]), width as f32 / height as f32);
    let renderer = renderer.inspect_err(|_| {
        crate::report::talk!("the crowd was evaluated, but there is nothing to draw it with:");
    })?;
    let mut studio = Studio::new(renderer, &mut crowd, &roles, &[], camera)?;
    let start = Instant::now();
    studio.shoot(&mut crowd, &args.out)?;
    let secs = start.elapsed().as_secs_f64();
    crate::report::talk!("drawn by {} in {secs:.1} s, written to {}", studio.driver(), args.out.display());
    Ok(())
}

/// The median time of a frame in milliseconds: members walk on, the device evaluates every joint.
fn time_frames(crowd: &mut Crowd) -> Result<f64, Failure> {
    let mut times = Vec::with_capacity(FRAMES);
    crowd.update(0.0)?;
    crowd.finish()?;
    for _ in 0..FRAMES {
        let start = Instant::now();
        crowd.update(FRAME_SECS)?;
        crowd.finish()?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[FRAMES / 2])
}
