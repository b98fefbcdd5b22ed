//! The files that a window writes: films, pictures and layouts.

use std::path::Path;

use libtest_mimic::Failed;

use super::time::recording;
use super::{Desk, ensure};

/// The crowd of these tests.
const CROWD: [&str; 3] = ["@woman", "--members", "1"];

/// Returns the number of frames of a film: the table of their sizes counts them.
fn frames(film: &Path) -> Result<u32, Failed> {
    let bytes = std::fs::read(film)?;
    let table = bytes.windows(4).position(|word| word == b"stsz").ok_or("no table of sizes")?;
    // The version and a size that all frames might have lie between.
    let count = bytes.get(table + 12..table + 16).ok_or("the table is cut off")?;
    Ok(u32::from_be_bytes(count.try_into()?))
}

/// One film goes on to the end of a recording, and one goes to a later time on its way.
pub(super) fn records_each_frame_once(desk: &Desk) -> Result<(), Failed> {
    if !cfg!(feature = "mp4") {
        return Ok(());
    }
    let file = recording(desk)?;
    let script = "at 0 key space\nat 0.2 seek 5.5\nat 0.2 expect time 5.5\nat 0.2 key v\n\
                  at 1.5 expect time 6\nat 1.5 key v\n\
                  at 1.7 seek 2\nat 1.7 expect time 2\nat 1.7 key v\nat 2.3 expect time 2.5\n\
                  at 2.3 seek 4\nat 2.7 expect time 4.3\nat 2.7 key v\n";
    desk.view(&[&file, "--fps", "10"], script)?;
    for (name, wanted) in [("populace-1.mp4", 5), ("populace-2.mp4", 8)] {
        let found = frames(&desk.path(name))?;
        ensure(found == wanted, || format!("{name} has {found} frames in place of {wanted}"))?;
    }
    Ok(())
}

pub(super) fn refuses_other_files(desk: &Desk) -> Result<(), Failed> {
    let model = b"glTF\x02\x00\x00\x00\xff\xfe";
    for (name, content, fault) in [
        ("model.glb", &model[..], "it is no text"),
        ("scene.toml", b"[ground]\nheight_m = 1.0\n", "line 1: unknown field `ground`"),
        ("broken.toml", b"panels = true\nwidth = \"broken\n", "line 2: "),
    ] {
        let file = desk.path(name);
        std::fs::write(&file, content)?;
        let args = [&CROWD[..], &["--layout", name]].concat();
        let output = desk.try_view(&args, "at 0.1 shot opened.png\n")?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        ensure(output.status.code() == Some(1), || format!("{:?}: {stderr}", output.status))?;
        for words in [name, fault, "name another file after --layout"] {
            ensure(stderr.contains(words), || format!("no {words:?} in: {stderr}"))?;
        }
        ensure(std::fs::read(&file)? == content, || format!("{name} was changed"))?;
        ensure(!desk.path("opened.png").exists(), || format!("{name}: a window was opened"))?;
    }
    Ok(())
}

pub(super) fn warns_of_a_lost_layout(desk: &Desk) -> Result<(), Failed> {
    // The folder that the link leads to is missing.
    std::os::unix::fs::symlink("missing/layout.toml", desk.path("link.toml"))?;
    let args = [&CROWD[..], &["--layout", "link.toml"]].concat();
    let output = desk.try_view(&args, "at 0.1 quit\n")?;
    let stderr = String::from_utf8_lossy(&output.stderr);
    ensure(output.status.success(), || stderr.clone().into_owned())?;
    for words in ["warning: ", "cannot write", "link.toml"] {
        ensure(stderr.contains(words), || format!("no {words:?} in: {stderr}"))?;
    }
    Ok(())
}

/// The recording is 300 km from the origin.
pub(super) fn warns_of_cameras(desk: &Desk) -> Result<(), Failed> {
    std::fs::write(desk.path("far.csv"), "id,t,x,y\n1,0,300000,5\n1,1,300001,5\n")?;
    let far = ["far.csv", "--cast", "@child"];
    for (input, camera, warning) in [
        (&far, "300000,2,0,300000,0,-5", "warning: the camera sees nobody in any frame"),
        (&CROWD, "0,-2,5,0,1,0", "warning: the camera is below the ground: it is at 0.00, -2.00"),
    ] {
        let args = [&input[..], &["--camera", camera]].concat();
        let output = desk.try_view(&args, "at 0.1 quit\n")?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        ensure(output.status.success() && stderr.contains(warning), || stderr.into_owned())?;
    }
    Ok(())
}

/// Another name of the file that was there shows that nobody wrote into it.
pub(super) fn replaces_files_whole(desk: &Desk) -> Result<(), Failed> {
    let names = ["shot.png", "picture.png", "layout.toml"];
    let other = |name: &str| desk.path(&format!("other-{name}"));
    for name in names {
        std::fs::write(desk.path(name), "")?;
        std::fs::hard_link(desk.path(name), other(name))?;
    }
    let args = [&CROWD[..], &["--layout", "layout.toml"]].concat();
    desk.view(&args, "at 0.1 shot shot.png\nat 0.1 picture picture.png\n")?;
    for name in names {
        ensure(std::fs::metadata(desk.path(name))?.len() > 0, || format!("{name} is empty"))?;
        let is_kept = std::fs::metadata(other(name))?.len() == 0;
        ensure(is_kept, || format!("{name} was written piece by piece"))?;
    }
    Ok(())
}

pub(super) fn refuses_other_formats(desk: &Desk) -> Result<(), Failed> {
    for (args, script, words) in [
        (
            &[][..],
            "at 0 quit\nat 1 shot a.glb\n",
            "line 2 of the script: a.glb does not end in .png",
        ),
        (&["--film", "film.avi"], "at 0 quit\n", "film.avi does not end in .mp4 or .gif"),
    ] {
        let output = desk.try_view(&[&CROWD[..], args].concat(), script)?;
        let stderr = String::from_utf8_lossy(&output.stderr);
        ensure(output.status.code() == Some(2), || format!("{:?}: {stderr}", output.status))?;
        ensure(stderr.contains(words), || format!("no {words:?} in: {stderr}"))?;
    }
    Ok(())
}
