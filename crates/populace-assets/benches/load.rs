//! Time to load each character of the folder that `POPULACE_TEST_DATA` names:
//! `cargo bench -p populace-assets --bench load`.

#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use std::error::Error;
use std::path::Path;
use std::time::Instant;

const ROUNDS: usize = 15;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::var("POPULACE_TEST_DATA").map_err(|_| "set POPULACE_TEST_DATA")?;
    let entries = std::fs::read_dir(Path::new(&folder).join("characters"))?;
    let mut files: Vec<_> =
        entries.map(|entry| Ok(entry?.path())).collect::<Result<_, Box<dyn Error>>>()?;
    files.retain(|file| file.extension().is_some_and(|extension| extension == "glb"));
    files.sort();
    println!("{:<32} {:>5} {:>6} {:>9} {:>10}", "file", "clips", "rows", "first, ms", "median, ms");
    for file in files {
        let (mut times, mut clips) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            let start = Instant::now();
            let imported = populace_assets::load(&file)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
            clips.clone_from(&imported.character.clips);
        }
        let rows: usize = clips.iter().map(|clip| clip.row_count()).sum();
        let (name, first) = (file.file_name().unwrap_or_default().display().to_string(), times[0]);
        times.sort_by(f64::total_cmp);
        println!(
            "{name:<32} {:>5} {rows:>6} {first:>9.1} {:>10.1}",
            clips.len(),
            times[ROUNDS / 2]
        );
    }
    Ok(())
}
