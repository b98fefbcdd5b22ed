//! Members that are picked, moved, thrown over and driven.

use std::collections::{HashMap, HashSet};

use libtest_mimic::Failed;

use super::{Desk, SIZE, differing, ensure};

/// The crowd of these tests.
const CROWD: [&str; 3] = ["@people", "--members", "12"];

pub(super) fn opens(desk: &Desk) -> Result<(), Failed> {
    desk.view(
        &CROWD,
        "at 0.2 shot window.png\nat 0.2 key ?\nat 0.4 shot help.png\n\
                       at 0.4 key ?\nat 0.5 key space\nat 0.6 shot plain.png\nat 0.6 key k\n\
                       at 0.7 shot skeletons.png\n",
    )?;
    let window = desk.image("window.png")?;
    let picture: HashSet<_> = (0..500)
        .step_by(5)
        .flat_map(|x| (0..600).step_by(5).map(move |y| (x, y)))
        .map(|(x, y)| window.get_pixel(x, y).0)
        .collect();
    ensure(picture.len() > 100, || format!("the picture has {} colours", picture.len()))?;
    let panel = window.get_pixel(755, 730).0;
    ensure(panel == [28, 31, 37, 255], || format!("the panel has the colour {panel:?}"))?;
    let help = differing(&window, &desk.image("help.png")?);
    ensure(help.len() > 50_000, || format!("help covers {} pixels", help.len()))?;
    let lines = differing(&desk.image("plain.png")?, &desk.image("skeletons.png")?);
    let lines = lines.iter().filter(|[x, y]| *x < 500 && *y > 60).count();
    ensure(lines > 500, || format!("skeletons cover {lines} pixels"))
}

/// Returns the pixels of each person at 0.5 s by their numbers, in a picture of a size.
fn pixels(desk: &Desk, size: [u32; 2]) -> Result<HashMap<u32, Vec<[u32; 2]>>, Failed> {
    let args = [&CROWD[..], &["--at", "0.5", "--images", "id"]].concat();
    desk.render(&args, size, "people.png")?;
    let mut pixels: HashMap<u32, Vec<[u32; 2]>> = HashMap::new();
    for (x, y, pixel) in desk.image("people.id.png")?.enumerate_pixels() {
        let [red, green, blue, _] = pixel.0.map(u32::from);
        let number = 65536 * red + 256 * green + blue;
        if number > 0 {
            pixels.entry(number - 1).or_default().push([x, y]);
        }
    }
    Ok(pixels)
}

/// Returns the pixel that is nearest to the middle of all.
fn middle(pixels: &[[u32; 2]]) -> [u32; 2] {
    let count = u32::try_from(pixels.len()).unwrap_or(u32::MAX).max(1);
    let mean = [0, 1].map(|axis| pixels.iter().map(|p| p[axis]).sum::<u32>() / count);
    let off = |p: &&[u32; 2]| p[0].abs_diff(mean[0]) + p[1].abs_diff(mean[1]);
    pixels.iter().min_by_key(off).copied().unwrap_or(mean)
}

/// Each person is picked by a click on a pixel that shows them, and nobody by one on the sky.
pub(super) fn picks(desk: &Desk) -> Result<(), Failed> {
    let mut people: Vec<_> = pixels(desk, SIZE)?.into_iter().collect();
    people.retain(|(_, pixels)| pixels.len() > 250);
    people.sort_unstable();
    ensure(people.len() >= 6, || format!("only {} people are large", people.len()))?;
    let mut script = "at 0 key space\nat 0 key tab\nat 0.2 seek 0.5\n".to_owned();
    for (number, pixels) in &people {
        let [x, y] = middle(pixels);
        script += &format!("at 0.2 click {x} {y}\nat 0.2 expect picked {number}\n");
    }
    script += "at 0.2 click 5 5\nat 0.2 expect picked none\n";
    desk.view(&CROWD, &script).map(|_| ())
}

/// Somebody raises an arm. Only pixels around this person change.
pub(super) fn slides(desk: &Desk) -> Result<(), Failed> {
    // The panels take a part of the window, so that the picture is smaller.
    desk.view(&CROWD, "at 0 key space\nat 0.1 seek 0.5\nat 0.1 picture small.png\n")?;
    let small = desk.image("small.png")?;
    let people = pixels(desk, [small.width(), small.height()])?;
    let (number, mine) = people.iter().max_by_key(|(_, pixels)| pixels.len()).ok_or("nobody")?;
    let [x, y] = middle(mine);
    let script = format!(
        "at 0 key space\nat 0.1 seek 0.5\nat 0.1 click {x} {y}\nat 0.1 expect picked {number}\n\
         at 0.1 picture before.png\nat 0.1 slide \"left hand weight\" 1\nat 0.1 picture after.png\n\
         at 0.1 slide \"left hand weight\" 0\nat 0.1 picture back.png\nat 0.1 expect frames 2\n"
    );
    desk.view(&CROWD, &script)?;
    let before = desk.image("before.png")?;
    let moved = differing(&before, &desk.image("after.png")?);
    ensure(moved.len() > 150, || format!("only {} pixels moved", moved.len()))?;
    // An arm reaches as far to the side as a person is wide, and so does its shadow.
    let columns = mine.iter().map(|p| p[0]);
    let (low, high) = (columns.clone().min().unwrap_or(0), columns.max().unwrap_or(0));
    let reach = 2 * (high - low);
    let far = moved.iter().filter(|p| p[0] + reach < low || p[0] > high + reach).count();
    ensure(far == 0, || format!("{far} pixels changed elsewhere"))?;
    let left = differing(&before, &desk.image("back.png")?).len();
    ensure(left == 0, || format!("{left} pixels stay changed"))
}

pub(super) fn falls(desk: &Desk) -> Result<(), Failed> {
    let [x, y] = places_beside_panels();
    let script = format!(
        "at 0.1 click {x} {y}\nat 0.2 expect picked any\nat 0.2 expect up\n\
         at 0.3 press Ragdoll\nat 1.5 expect down\nat 1.5 press \"Get up\"\nat 8 expect up\n"
    );
    desk.view(&["@woman", "--members", "1"], &script).map(|_| ())
}

/// Returns where a single member is in a window with panels: in the middle of the picture.
fn places_beside_panels() -> [u32; 2] {
    [(SIZE[0] - 250) / 2, (SIZE[1] - 40) / 2]
}

/// A driven member walks while a key is held, and stands when it is not.
pub(super) fn drives(desk: &Desk) -> Result<(), Failed> {
    let [x, y] = places_beside_panels();
    let script = format!(
        "at 0.1 click {x} {y}\nat 0.2 key y\nat 0.3 expect you\nat 2 picture stand.png\n\
         at 2 hold up 1.5\nat 3.5 expect walked 1.2\nat 5 key y\nat 5.2 expect others\n"
    );
    desk.view(&["@woman", "--members", "1", "--clip", "Idle"], &script).map(|_| ())
}

/// A driven member walks while the left stick of a gamepad is pushed, and not within its dead zone;
/// the right stick turns the view, as a drag does.
pub(super) fn drives_by_stick(desk: &Desk) -> Result<(), Failed> {
    let [x, y] = places_beside_panels();
    let script = format!(
        "at 0.1 click {x} {y}\nat 0.2 key y\nat 0.3 expect you\nat 0.5 stick left 0.1 0.1 1\n\
         at 1.6 key space\nat 1.7 picture still.png\nat 1.8 stick right 0.1 0.1 0.5\n\
         at 2.4 picture rest.png\nat 2.5 stick right 1 0 0.5\nat 3.1 picture turned.png\n\
         at 3.2 key space\nat 3.3 stick left 0 1 1.5\nat 4.9 expect walked 1.2\n"
    );
    desk.view(&["@woman", "--members", "1", "--clip", "Idle"], &script)?;
    let still = desk.image("still.png")?;
    let moved = |name: &str| Ok::<_, Failed>(differing(&still, &desk.image(name)?).len());
    let (rest, turned) = (moved("rest.png")?, moved("turned.png")?);
    ensure(rest == 0, || format!("{rest} pixels moved in the dead zone"))?;
    ensure(turned > 5000, || format!("the view did not turn: {turned} pixels moved"))?;
    let early = script.replace("at 3.3 stick left 0 1 1.5", "at 3.3 stick left 0.1 0.1 1.5");
    let stays = early.replace("expect walked 1.2", "expect walked 0.1");
    let walks = desk.view(&["@woman", "--members", "1", "--clip", "Idle"], &stays).is_ok();
    ensure(!walks, || "somebody walks in the dead zone".into())
}
