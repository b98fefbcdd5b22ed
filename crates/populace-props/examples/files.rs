//! Writes props as GLB files.
//!
//! `cargo run -p populace-props --example files [FOLDER]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::error::Error;
use std::path::PathBuf;

use populace_assets::{WriteOptions, to_glb};
use populace_props as props;
use populace_props::{CarKind, GroundKind, RoadPlan};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    let things = [
        ("shopfront", props::shopfront(3, 7.0)?.character),
        ("road", props::road(&RoadPlan::default())?.character),
        ("traffic_light", props::traffic_light()?),
        ("walk_light", props::walk_light()?),
        ("bench", props::bench()?.character),
        ("tree", props::tree(1)?),
        ("street_lamp", props::street_lamp()?),
        ("bollard", props::bollard()?),
        ("planter", props::planter(1)?),
        ("bin", props::bin()?),
        ("cafe_table", props::cafe_table()?.character),
        ("hatchback", props::car(CarKind::Hatchback, 1)?.character),
        ("saloon", props::car(CarKind::Saloon, 1)?.character),
        ("van", props::car(CarKind::Van, 1)?.character),
        ("shield", props::shield(1)?),
        ("spear", props::spear()?),
        ("helmet", props::helmet(1)?),
        ("parcel", props::box_parcel()?),
        ("phone", props::phone()?),
        ("stand", props::stand(10, 20)?.character),
        ("lawn", props::ground(GroundKind::Lawn, 50.0)?),
    ];
    for (name, character) in things {
        let path = folder.join(format!("{name}.glb"));
        std::fs::write(&path, to_glb(&character, &WriteOptions::default())?)?;
        println!("{}", path.display());
    }
    Ok(())
}
