//! The timeline, files, films, the layout and the times of input.

use std::process::Command;

use libtest_mimic::Failed;

use super::{Desk, SIZE, differing, ensure};

/// The crowd of these tests.
const CROWD: [&str; 3] = ["@people", "--members", "40"];

/// Plays on and back, and compares pictures with those of `render --at`.
fn seeks(desk: &Desk, args: &[&str], times: &[&str]) -> Result<(), Failed> {
    let mut script = "at 0 key tab\n".to_owned();
    for secs in times {
        script += &format!("at 0.5 seek {secs}\nat 0.5 picture view-{secs}.png\n");
    }
    desk.view(args, &script)?;
    for secs in times {
        let wanted =
            desk.render(&[args, &["--at", secs]].concat(), SIZE, &format!("{secs}.png"))?;
        let off = differing(&desk.image(&format!("view-{secs}.png"))?, &wanted).len();
        ensure(off == 0, || format!("at {secs} s, {off} pixels differ"))?;
    }
    Ok(())
}

pub(super) fn seeks_crowds(desk: &Desk) -> Result<(), Failed> {
    seeks(desk, &CROWD, &["1.5", "2.04", "0.7"])
}

/// Writes a recording of people who cross a place, and returns its path.
pub(super) fn recording(desk: &Desk) -> Result<String, Failed> {
    let mut table = "id,t,x,y\n".to_owned();
    for row in 0..=60 {
        let secs = f64::from(row) / 10.0;
        for id in 0..6 {
            let across = f64::from(id) * 1.1;
            let along = 1.3 * secs + 0.4 * f64::from(id % 3);
            let along = if id % 2 == 0 { along } else { 8.0 - along };
            table += &format!("{id},{secs},{along:.3},{across:.3}\n");
        }
    }
    let path = desk.path("crossing.csv");
    std::fs::write(&path, table)?;
    Ok(path.to_string_lossy().into_owned())
}

pub(super) fn seeks_recordings(desk: &Desk) -> Result<(), Failed> {
    let file = recording(desk)?;
    seeks(desk, &[&file, "--clock", "--ids"], &["2", "4.5", "1.3"])
}

pub(super) fn steps(desk: &Desk) -> Result<(), Failed> {
    let script = "at 0.5 key space\nat 0.6 seek 1\nat 0.8 expect time 1\n\
                  at 0.8 key .\nat 1 expect time 1.033333\nat 1 key ,\nat 1 key ,\n\
                  at 1.2 expect time 0.966667\nat 1.2 picture still.png\nat 2 picture later.png\n\
                  at 2 key home\nat 2.1 expect time 0\nat 2.1 slide Time 0.5\n\
                  at 2.2 picture half.png\nat 2.3 key ]\nat 2.3 press Play\n\
                  at 2.8 picture on.png\n";
    desk.view(&CROWD, script)?;
    let still = differing(&desk.image("still.png")?, &desk.image("later.png")?).len();
    ensure(still == 0, || format!("{still} pixels change in a pause"))?;
    for other in ["half.png", "on.png"] {
        let moved = differing(&desk.image("still.png")?, &desk.image(other)?).len();
        ensure(moved > 1000, || format!("{other}: only {moved} pixels moved"))?;
    }
    Ok(())
}

pub(super) fn drops(desk: &Desk) -> Result<(), Failed> {
    let file = recording(desk)?;
    let script = format!(
        "at 0.1 expect members 40\nat 0.1 drop {file}\nat 0.3 expect members 6\n\
         at 0.4 drop no-such-file.glb\nat 0.6 expect members 6\nat 0.6 shot error.png\n"
    );
    desk.view(&CROWD, &script).map(|_| ())
}

/// Size, schedule and the moment stay what they are when one of them changes.
pub(super) fn reopens(desk: &Desk) -> Result<(), Failed> {
    let script = "at 0 key space\nat 0.2 seek 1.2\nat 0.2 picture before.png\n\
                  at 0.3 press Schedule\nat 0.5 press staged\nat 0.8 expect time 1.2\n\
                  at 0.8 expect members 40\nat 0.8 picture after.png\nat 0.8 shot staged.png\n";
    desk.view(&CROWD, script)?;
    let off = differing(&desk.image("before.png")?, &desk.image("after.png")?).len();
    ensure(off < 2000, || format!("{off} pixels differ with another schedule"))
}

pub(super) fn records(desk: &Desk) -> Result<(), Failed> {
    if !cfg!(feature = "mp4") {
        return Ok(());
    }
    desk.view(&CROWD, "at 0.1 key v\nat 0.6 key v\nat 0.7 press Record\nat 1 quit\n")?;
    for name in ["populace-1.mp4", "populace-2.mp4"] {
        let bytes = std::fs::metadata(desk.path(name))?.len();
        ensure(bytes > 5_000, || format!("{name} has {bytes} bytes"))?;
    }
    Ok(())
}

/// With as many people as were measured, who go about what they do.
pub(super) fn opens_the_street(desk: &Desk) -> Result<(), Failed> {
    let script = "at 0.1 picture first.png\nat 1 picture later.png\nat 1.1 quit\n";
    std::fs::write(desk.path("script.txt"), script)?;
    let output = Command::new(env!("CARGO_BIN_EXE_populace"))
        .args(["demo", "--size", "480x270", "--json", "--script"])
        .arg(desk.path("script.txt"))
        .current_dir(desk.path(""))
        .env("DISPLAY", desk.display.name())
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_CONFIG_HOME", desk.path("config"))
        .output()?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure(output.status.success(), || stderr.clone().into_owned())?;
    ensure(stderr.contains("ms a frame here:"), || format!("nothing was measured: {stderr}"))?;
    ensure(!desk.path("populace-demo.png").exists(), || "a picture was drawn".into())?;
    let moved = differing(&desk.image("first.png")?, &desk.image("later.png")?).len();
    ensure(moved > 300, || format!("{moved} pixels move in the street"))
}

pub(super) fn remembers(desk: &Desk) -> Result<(), Failed> {
    let file = desk.path("config/viewer.toml");
    let name = file.to_string_lossy().into_owned();
    let args = [&CROWD[..], &["--layout", &name]].concat();
    desk.view(&args, "at 0 key tab\nat 0 key k\nat 0.1 shot first.png\n")?;
    let text = std::fs::read_to_string(&file)?;
    ensure(text.contains("panels = false") && text.contains("skeletons = true"), || text)?;
    desk.view(&args, "at 0.1 shot second.png\nat 0.1 key tab\n")?;
    let corner = desk.image("second.png")?.get_pixel(755, 735).0;
    ensure(corner != [28, 31, 37, 255], || "the panels are shown again".into())
}

/// By the time stamps of the script.
pub(super) fn shows_input_at_once(desk: &Desk) -> Result<(), Failed> {
    let script = "at 0 pace real\nat 0.5 drag 300 300 420 340\nat 0.6 wheel 400 300 2\n\
                  at 0.7 drag 400 300 460 320 middle\nat 0.8 key k\nat 0.9 press Member\n\
                  at 1 drag 300 300 340 300 right\nat 1 hold w 0.2\nat 1.5 expect frames 2\n";
    let report = desk.view(&CROWD, script)?;
    let inputs = report["inputs"].as_array().ok_or("no inputs")?;
    ensure(inputs.len() == 7, || format!("{} inputs", inputs.len()))?;
    for input in inputs {
        let frames = input["frames"].as_u64().unwrap_or(u64::MAX);
        ensure(frames <= 2, || format!("{input}"))?;
    }
    Ok(())
}

pub(super) fn misses_a_display() -> Result<(), Failed> {
    let output = Command::new(env!("CARGO_BIN_EXE_populace"))
        .args(["view", "@woman"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure(output.status.code() == Some(3), || format!("{:?}: {stderr}", output.status))?;
    for words in ["no display", "DISPLAY", "populace render", "--out"] {
        ensure(stderr.contains(words), || format!("no {words:?} in: {stderr}"))?;
    }
    ensure(!stderr.contains(".rs:"), || format!("a line of source in: {stderr}"))
}
