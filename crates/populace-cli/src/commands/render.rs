//! `populace render`

use populace_render::{Camera, Renderer};

use crate::cast::{self, Role, Wanted};
use crate::cli::{RenderArgs, View};
use crate::failure::Failure;
use crate::staging::{Plan, Staging};
use crate::studio::{Studio, check_kind, check_output, devices_and_shares, drawn_with, frame_path};

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    check_kind(&args.out, "png")?;
    let first = args.frames.map_or(args.out.clone(), |_| frame_path(&args.out, 0));
    check_output(&first, "png")?;
    // Without OpenGL the inputs are still checked first: what is wrong with them is of more use.
    let renderer = Renderer::headless(args.size.0);
    let builder = args.device.crowd().capacity(args.members as usize).slots_per_member(1);
    let mut crowd = drawn_with(builder, &renderer).build()?;
    let wanted = Wanted { clip: args.clip.as_deref(), root_motion: args.root_motion };
    let roles = cast::load(&mut crowd, &args.input, &args.inputs, &args.clips, wanted, args.height)?;
    check_hidden(&roles, &args.hide)?;
    let plan = Plan { members: args.members, seed: args.seed, hide: &args.hide, away_percent: 0 };
    let staging = Staging::new(&mut crowd, &roles, &plan)?;
    let camera = camera(args, &staging);
    let mut studio = Studio::new(renderer?, &mut crowd, &roles, &args.hide, camera)?;
    crowd.update(0.0)?;
    studio.shoot(&mut crowd, &first)?;
    for frame in 1..args.frames.unwrap_or(1) {
        crowd.update(1.0 / args.fps)?;
        studio.shoot(&mut crowd, &frame_path(&args.out, frame))?;
    }
    let written = match args.frames {
        Some(frames) => format!("{frames} frames from {} on", first.display()),
        None => first.display().to_string(),
    };
    let (members, schedule) = (crowd.member_count(), crowd.schedule());
    crate::report::talk!(
        "{members} members on {} ({schedule}), drawn by {}, written to {written}",
        devices_and_shares(&crowd),
        studio.driver()
    );
    Ok(())
}

fn camera(args: &RenderArgs, staging: &Staging) -> Camera {
    let [width, height] = args.size.0;
    let aspect = width as f32 / height as f32;
    // The whole film must show what it is about, and walkers walk.
    let film_secs = [0.0, args.frames.map_or(0.0, |frames| (frames - 1) as f32 / args.fps)];
    match args.camera {
        View::Crowd => Camera::framing(staging.framed(film_secs), aspect),
        View::Close => Camera::framing(staging.closest(film_secs), aspect),
        View::At { eye, target } => {
            let framed = Camera::framing(staging.framed(film_secs), aspect);
            Camera { eye, target, near: 0.05, ..framed }
        }
    }
}

fn check_hidden(roles: &[Role], hide: &[String]) -> Result<(), Failure> {
    let names = || roles.iter().flat_map(|r| &r.character.parts).map(|p| p.node_name.as_str());
    match hide.iter().find(|wanted| !names().any(|n| n == wanted.as_str())) {
        None => Ok(()),
        Some(unknown) => {
            let nearest = populace::nearest_names(unknown, names());
            let hint = if nearest.is_empty() {
                String::new()
            } else {
                format!("; did you mean {}?", nearest.join(" or "))
            };
            Err(Failure::usage(format!("no node \"{unknown}\" draws anything{hint}")))
        }
    }
}
