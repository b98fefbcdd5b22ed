//! The example `own_renderer` runs without a window and draws people who stand on the ground.

use std::path::Path;
use std::process::Command;

use image::RgbImage;

/// Draws the example's picture.
fn picture() -> RgbImage {
    // `cargo test` builds the examples beside the folder of the tests. `cargo test --test
    // own_renderer` alone needs `cargo build --examples` first.
    let test = std::env::current_exe().expect("a path");
    let build = test.parent().and_then(Path::parent).expect("a folder");
    let example =
        build.join("examples/own_renderer").with_extension(std::env::consts::EXE_EXTENSION);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let file = folder.path().join("picture.png");
    let output = Command::new(&example).arg(&file).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", example.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.starts_with("40 members, drawn to "), "{said}");
    image::open(&file).expect("a PNG").to_rgb8()
}

/// Red shirts are the only red in the picture.
fn is_red(pixel: &image::Rgb<u8>) -> bool {
    let [r, g, b] = pixel.0.map(i16::from);
    r > 2 * g.max(b) && r > 60
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn draws_shirts_above_dark_trousers() {
    let picture = picture();
    assert_eq!(picture.dimensions(), (960, 400));
    let red = picture.pixels().filter(|pixel| is_red(pixel)).count();
    assert!((3000..20_000).contains(&red), "{red} pixels are red");
    // The lowest red pixel of the front row is well above the lowest pixel of a trouser leg.
    let lowest = |wanted: &dyn Fn(&image::Rgb<u8>) -> bool| {
        let at = picture.enumerate_pixels().filter(|(_, _, pixel)| wanted(pixel));
        at.map(|(_, y, _)| y).max().expect("a pixel")
    };
    let (shirts, trousers) = (lowest(&is_red), lowest(&|p| p.0.iter().all(|c| *c < 100)));
    assert!(shirts + 30 < trousers, "shirts end at {shirts}, trousers at {trousers}");
}
