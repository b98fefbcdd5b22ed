//! Measures the foot skate of one of the people made by code on the standard course:
//! `cargo run --release --example skate -- [NAME]`. `populace bench --skate` does so for all of
//! them, and for files.

#![expect(clippy::print_stdout, reason = "an example prints what it finds")]

use std::error::Error;
use std::sync::Arc;

use populace_locomotion::{GaitClips, Skate};

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1);
    let mut people = populace_cast::cast()?.into_iter();
    let person = people.find(|person| name.as_ref().is_none_or(|name| person.name == *name));
    let person = Arc::new(person.ok_or("nobody has this name")?);
    let clips = GaitClips::of(&person).ok_or("no clips to walk with")?;
    println!("segment       planting  mean, m/s  95 %, m/s  speed error");
    for skate in Skate::measure(&person, &clips)? {
        println!(
            "{:12}  {:8}  {:9.3}  {:9.3}  {:11.3}",
            skate.segment,
            skate.planting,
            skate.mean_m_per_sec,
            skate.p95_m_per_sec,
            skate.speed_error
        );
    }
    Ok(())
}
