//! `populace cast`

use std::path::{Path, PathBuf};

use populace::character::Character;
use populace_assets::{WriteOptions, to_glb};
use populace_bodies::{BodySystem, COPYRIGHT, CREDITS, Person};
use populace_lod::{reduced, with_levels};

use crate::cli::CastArgs;
use crate::failure::Failure;
use crate::folder::paths_in;
use crate::output;
use crate::progress::Progress;
use crate::report::{self, message};

/// The most by which surfaces may be moved to save triangles, as a part of the height.
const MOST_ERROR: f32 = 0.0015;

pub(crate) fn run(args: &CastArgs) -> Result<(), Failure> {
    let credits = args.out.join("CREDITS");
    check_own(&credits)?;
    let mut bodies = BodySystem::open(&args.from)?;
    std::fs::create_dir_all(&args.out).map_err(|e| {
        let out = args.out.display();
        Failure::Run(anyhow::anyhow!("cannot create the folder {out}: {e}"))
    })?;
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
    match others(&args.out, &paths) {
        Ok(0) => {}
        Ok(others) => message!(
            "warning: {} also holds {others} .glb files of other runs, which CREDITS does not \
             name; delete them, or choose another folder with --out",
            args.out.display()
        ),
        Err(error) => message!("warning: {error}; it may hold .glb files of other runs"),
    }
    paths.iter().try_for_each(|path| report::path(path))
}

/// The beginning of what CREDITS says, after the number.
const MADE: &str = "people made by `populace cast";

const GENERATOR: &str = concat!("populace ", env!("CARGO_PKG_VERSION"));

/// Refuses to replace a file that this command did not write.
fn check_own(credits: &Path) -> Result<(), Failure> {
    let is_own = |text: Vec<u8>| String::from_utf8_lossy(&text).contains(MADE);
    if std::fs::read(credits).is_ok_and(|text| !is_own(text)) {
        return Err(Failure::usage(format!(
            "{} was not written by `populace cast`, and would be replaced; choose another folder \
             with --out",
            credits.display()
        )));
    }
    Ok(())
}

/// Returns the number of characters in the folder that were not made now.
fn others(out: &Path, made: &[PathBuf]) -> Result<usize, Failure> {
    let is_other = |path: &&PathBuf| {
        path.extension().is_some_and(|extension| extension == "glb") && !made.contains(path)
    };
    Ok(paths_in(out)?.iter().filter(is_other).count())
}

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
    format!("{count} {MADE} --seed {seed}` from {from}.\n\n{CREDITS}",)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_of_other_runs_are_counted() {
        let folder = tempfile::TempDir::new().expect("a folder");
        let paths =
            ["man-001.glb", "woman-001.glb", "CREDITS"].map(|name| folder.path().join(name));
        for path in &paths {
            std::fs::write(path, "").expect("written");
        }
        assert_eq!(others(folder.path(), &paths[..1]).expect("a folder"), 1);
        assert_eq!(others(folder.path(), &paths).expect("a folder"), 0);
        others(&folder.path().join("none"), &paths).expect_err("a folder that cannot be read");
    }
}
