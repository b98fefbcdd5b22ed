//! Feet that stand on the footsteps of a file, and one test with a file in the folder
//! `POPULACE_TEST_DATA` (environment variable).

mod plants;

use std::fmt::Write;
use std::path::Path;

use libtest_mimic::{Arguments, Failed, Trial};
use populace_trajectory::{ReadSettings, Recording, load, parse};

use plants::Walked;

const VARIABLE: &str = "POPULACE_TEST_DATA";
const FILE: &str = "trajectories/vadere/postvis.traj";

fn main() {
    let arguments = Arguments::from_args();
    let data = std::env::var_os(VARIABLE);
    let file = data.as_ref().map(|folder| Path::new(folder).join(FILE)).filter(|at| at.is_file());
    let name = match (&data, &file) {
        (None, _) => format!("{FILE} ({VARIABLE} is not set)"),
        (_, None) => format!("{FILE} (missing)"),
        _ => FILE.to_owned(),
    };
    let ignored = file.is_none();
    let real = move || {
        file.map_or(Ok(()), |file| {
            let recording = load(&file, &ReadSettings::default())?;
            crowded(&Walked::through(&recording)?)
        })
    };
    let trials = vec![
        Trial::test("straight steps are taken to the centimetre", straight),
        Trial::test("steps of several lengths and directions are taken", winding),
        Trial::test("feet come together where somebody waits", waiting),
        Trial::test(name, real).with_ignored_flag(ignored),
    ];
    libtest_mimic::run(&arguments, trials).exit();
}

/// Returns the footsteps of one agent, each of `secs` and with an advance in metres.
fn steps(secs: f64, advances: impl IntoIterator<Item = [f64; 2]>) -> Result<Recording, Failed> {
    let mut text = "pedestrianId simTime endTime startX startY endX endY\n".to_owned();
    let mut at = [2.0, 3.0];
    for (nth, [dx, dy]) in (0_u32..).zip(advances) {
        let [from, until] = [nth, nth + 1].map(|nth| 1.0 + f64::from(nth) * secs);
        let to = [at[0] + dx, at[1] + dy];
        writeln!(text, "1 {from} {until} {} {} {} {}", at[0], at[1], to[0], to[1])?;
        at = to;
    }
    Ok(parse(Path::new("steps.traj"), text.into_bytes(), &ReadSettings::default())?)
}

fn straight() -> Result<(), Failed> {
    let walked = Walked::through(&steps(0.6, vec![[0.75, 0.1]; 20])?)?;
    walked.expect([0.02, 0.03], 0.0)
}

fn winding() -> Result<(), Failed> {
    let advance = |nth: u32| {
        let angle = 0.5 * (f64::from(nth) * 0.4).sin();
        let length = 0.6 + 0.2 * (f64::from(nth) * 0.7).cos();
        [length * angle.cos(), length * angle.sin()]
    };
    let walked = Walked::through(&steps(0.6, (0..40).map(advance))?)?;
    walked.expect([0.03, 0.06], 0.0)
}

fn waiting() -> Result<(), Failed> {
    let walks = |count| vec![[0.6, 0.0]; count];
    let advances = [walks(6), vec![[0.0; 2]; 5], walks(7)].concat();
    let walked = Walked::through(&steps(0.65, advances)?)?;
    walked.expect([0.04, 0.1], 0.1)
}

fn crowded(walked: &Walked) -> Result<(), Failed> {
    walked.expect([0.05, 0.15], 0.1)
}
