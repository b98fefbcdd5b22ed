//! `populace render`

use std::fs::OpenOptions;
use std::path::Path;

use populace::{Crowd, Device, Placement, Play};
use populace_render::{Camera, CharacterHandle, Renderer, Scene, write_png};

use crate::cast::{self, Role};
use crate::cli::RenderArgs;
use crate::failure::Failure;
use crate::placement::{Random, places};
use crate::skin::skinned;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    check_output(&args.out)?;
    let device = args.device.device.unwrap_or_else(Device::best);
    let mut crowd =
        Crowd::builder().device(device).capacity(args.members as usize).slots_per_member(1).build()?;
    let roles = cast::load(&mut crowd, &args.files, args.clip.as_deref())?;
    check_hidden(&roles, &args.hide)?;
    let framed = populate(&mut crowd, &roles, args)?;
    crowd.update(0.0)?;

    let mut renderer = Renderer::headless(args.size.0)?;
    let hidden = |part: &populace::core::Part| args.hide.contains(&part.node_name);
    let handles: Result<Vec<_>, _> =
        roles.iter().map(|r| renderer.add_character(&r.character, &hidden)).collect();
    draw(&mut crowd, &mut renderer, &handles?, framed, args.size.0)?;
    write_png(&args.out, &renderer.read_image()?)?;
    eprintln!(
        "populace: {} members on {} ({}), drawn by {}, written to {}",
        crowd.member_count(),
        crowd.device(),
        crowd.schedule(),
        renderer.driver(),
        args.out.display()
    );
    Ok(())
}

/// Opens the output before the work, so that a wrong path costs no waiting; what stands there is left as it is.
fn check_output(path: &Path) -> Result<(), Failure> {
    let existed = path.exists();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    opened.map_err(|e| Failure::Run(anyhow::anyhow!("cannot write {}: {e}", path.display())))?;
    if !existed {
        std::fs::remove_file(path)?;
    }
    Ok(())
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

/// Spawns the members apart from each other, each at its own point of its clip; returns points that the picture must
/// show.
fn populate(crowd: &mut Crowd, roles: &[Role], args: &RenderArgs) -> Result<Vec<[f32; 3]>, Failure> {
    let mut random = Random::new(args.seed);
    let height = roles.iter().map(|r| r.character.height_m() * r.scale).fold(0.0, f32::max);
    let mut spacing: f32 = 0.0;
    for role in roles {
        spacing = spacing.max(footprint_m(crowd, role, args)? * 1.3);
    }
    let places = places(args.members as usize, spacing, &mut random);
    for (index, position) in places.iter().enumerate() {
        let role = &roles[index % roles.len()];
        let placement = Placement::at(*position).facing(random.signed() * 0.5).scaled(role.scale);
        let member = crowd.spawn(role.id, placement)?;
        let phase = random.unit();
        if !role.clips.is_empty() {
            let clip = role.clips[random.below(role.clips.len())];
            crowd.play(member, clip, Play::looping().phase(phase))?;
        }
    }
    let tops = places.iter().map(|p| [p[0], height, p[2]]);
    let beside =
        places.iter().flat_map(|p| [[p[0] - spacing / 2.0, 0.0, p[2]], [p[0] + spacing / 2.0, 0.0, p[2]]]);
    Ok(tops.chain(beside).collect())
}

/// How much ground a member takes: the larger side of what it shows, playing its first clip. Many rest with their arms
/// spread, which says nothing of how they stand, so a member is posed and looked at.
fn footprint_m(crowd: &mut Crowd, role: &Role, args: &RenderArgs) -> Result<f32, Failure> {
    let member = crowd.spawn(role.id, Placement::at([0.0; 3]))?;
    if let Some(clip) = role.clips.first() {
        crowd.play(member, *clip, Play::looping())?;
    }
    crowd.update(0.0)?;
    let palette = crowd.palette(member)?;
    crowd.despawn(member)?;
    let shown = role.character.parts.iter().filter(|part| !args.hide.contains(&part.node_name));
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for part in shown {
        for vertex in 0..part.mesh.positions.len() {
            let at = skinned(part, vertex, &palette);
            low = std::array::from_fn(|axis| low[axis].min(at[axis]));
            high = std::array::from_fn(|axis| high[axis].max(at[axis]));
        }
    }
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is what is wanted")]
    let side = (high[0] - low[0]).max(high[2] - low[2]) as f32;
    Ok((side * role.scale).max(1e-3))
}

fn draw(
    crowd: &mut Crowd,
    renderer: &mut Renderer,
    handles: &[CharacterHandle],
    framed: Vec<[f32; 3]>,
    [width, height]: [u32; 2],
) -> Result<(), Failure> {
    for page in 0..crowd.page_count() {
        let mut result = Ok(());
        crowd.with_page(page, &mut |palettes| result = renderer.upload_page(page, palettes))?;
        result?;
    }
    let instances: Vec<_> = crowd
        .instances()
        .map(|i| populace_render::Instance {
            character: handles[i.character.index()],
            world_from_model: i.world_from_model,
            palette_first: i.palette_first,
            tint: [1.0; 3],
        })
        .collect();
    let camera = Camera::framing(framed, width as f32 / height as f32);
    Ok(renderer.draw(&Scene { camera, ..Scene::default() }, &instances)?)
}
