//! `populace cast`

use std::path::PathBuf;

use populace::character::Character;
use populace_assets::{WriteOptions, to_glb};
use populace_bodies::{BodySystem, COPYRIGHT, CREDITS, Person};
use populace_lod::{reduced, with_levels};

use crate::cli::CastArgs;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::report;

/// The most by which surfaces may be moved to save triangles, as a part of the height.
const MOST_ERROR: f32 = 0.0015;

pub(crate) fn run(args: &CastArgs) -> Result<(), Failure> {
    let mut bodies = BodySystem::open(&args.from)?;
    std::fs::create_dir_all(&args.out).map_err(|e| {
        let out = args.out.display();
        Failure::Run(anyhow::anyhow!("cannot create the folder {out}: {e}"))
    })?;
    let credits = args.out.join("CREDITS");
    output::check_writable(&credits)?;
    let mut progress = Progress::new("people", args.count as usize);
    let mut paths: Vec<PathBuf> = Vec::new();
    for index in 0..args.count {
        let person = Person::random(args.seed, index);
        let path = args.out.join(format!("{}.glb", person.name));
        let character = bodies.character(&person)?;
        let character =
            detailed(&character, args.triangles as usize).map_err(|e| Failure::Run(e.into()))?;
        let options = WriteOptions { generator: GENERATOR, copyright: COPYRIGHT };
        output::write(&path, &to_glb(&character, &options)?)?;
        paths.push(path);
        progress.step();
    }
    output::write(&credits, credits_text(args, &bodies).as_bytes())?;
    drop(progress);
    paths.iter().try_for_each(|path| report::path(path))
}

const GENERATOR: &str = concat!("populace ", env!("CARGO_PKG_VERSION"));

/// Returns the person with few enough triangles and with levels of detail.
fn detailed(
    character: &Character,
    triangles: usize,
) -> Result<Character, populace::character::Error> {
    with_levels(reduced(character, triangles, MOST_ERROR * character.height_m())?)
}

fn credits_text(args: &CastArgs, bodies: &BodySystem) -> String {
    let from = bodies.path().file_name().unwrap_or_default().to_string_lossy();
    let (count, seed) = (args.count, args.seed);
    format!("{count} people made by `populace cast --seed {seed}` from {from}.\n\n{CREDITS}",)
}
