//! Gaits of clips made by hand. One test per clip of the characters in the folder
//! `POPULACE_TEST_DATA` (environment variable).

#![expect(clippy::print_stdout, reason = "tests print measurements")]

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use libtest_mimic::{Arguments, Failed, Trial};
use populace::model::Side;
use populace_assets::load;
use populace_locomotion::Gait;

const VARIABLE: &str = "POPULACE_TEST_DATA";

/// What a foot does in most of the cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Walk,
    Run,
    Idle,
}

use Kind::{Idle, Run, Walk};

/// A clip and its gait: the body, the file of the clip, its name, the direction in degrees from
/// the front to the left, and plausible speeds in body heights per second.
struct Case(&'static str, &'static str, &'static str, Kind, f32, Range<f32>);

const KNIGHT: &str = "kaykit_knight.glb";
const MAGE: &str = "kaykit_mage.glb";
const HUMAN: &str = "m2m_human_base.glb";
const ROBOT: &str = "quaternius_robot.glb";
const GIRL: &str = "girl.glb";
const ZOMBIE: &str = "m2m_zombie_noclips.glb";
const MANNEQUIN: &str = "kaykit_mannequin/manny_med_mod.gltf";
const MOVEMENT: &str = "kaykit_mannequin/Med_MovementBasic.glb";
const CESIUM: &str = "cesium_man.gltf";
const FIGURE: &str = "rigged_figure.glb";
const KENNEY: &str = "kenney_platformer/character.glb";

const WALKS: Range<f32> = 0.2..1.1;
const RUNS: Range<f32> = 0.8..3.6;
const STILL: Range<f32> = 0.0..0.02;

const CASES: &[Case] = &[
    Case(KNIGHT, KNIGHT, "Idle", Idle, 0.0, STILL),
    Case(KNIGHT, KNIGHT, "Walking_A", Walk, 0.0, WALKS),
    Case(KNIGHT, KNIGHT, "Walking_B", Walk, 0.0, WALKS),
    Case(KNIGHT, KNIGHT, "Walking_C", Walk, 0.0, WALKS),
    Case(KNIGHT, KNIGHT, "Walking_Backwards", Walk, 180.0, WALKS),
    Case(KNIGHT, KNIGHT, "Running_A", Run, 0.0, RUNS),
    Case(KNIGHT, KNIGHT, "Running_B", Run, 0.0, RUNS),
    Case(KNIGHT, KNIGHT, "Running_Strafe_Left", Run, 60.0, RUNS),
    Case(KNIGHT, KNIGHT, "Running_Strafe_Right", Run, -60.0, RUNS),
    Case(MAGE, MAGE, "Walking_A", Walk, 0.0, WALKS),
    Case(MAGE, MAGE, "Walking_C", Walk, 0.0, WALKS),
    Case(MAGE, MAGE, "Running_A", Run, 0.0, RUNS),
    Case(MAGE, MAGE, "Running_B", Run, 0.0, RUNS),
    Case(HUMAN, HUMAN, "Idle_Loop", Idle, 0.0, STILL),
    Case(HUMAN, HUMAN, "Walk_Loop", Walk, 0.0, WALKS),
    Case(HUMAN, HUMAN, "Walk_Formal_Loop", Walk, 0.0, WALKS),
    Case(HUMAN, HUMAN, "Crouch_Fwd_Loop", Walk, 0.0, WALKS),
    Case(HUMAN, HUMAN, "Jog_Fwd_Loop", Run, 0.0, RUNS),
    Case(HUMAN, HUMAN, "Sprint_Loop", Run, 0.0, RUNS),
    Case(ROBOT, ROBOT, "Robot_Idle", Idle, 0.0, STILL),
    Case(ROBOT, ROBOT, "Robot_Walking", Walk, 0.0, WALKS),
    Case(ROBOT, ROBOT, "Robot_Running", Run, 0.0, RUNS),
    Case(GIRL, GIRL, "IdleTrack", Idle, 0.0, STILL),
    Case(GIRL, GIRL, "RunTrack", Run, 0.0, RUNS),
    Case(MANNEQUIN, MOVEMENT, "Rig_Medium|Walking_A", Walk, 0.0, WALKS),
    Case(MANNEQUIN, MOVEMENT, "Rig_Medium|Walking_B", Walk, 0.0, WALKS),
    Case(MANNEQUIN, MOVEMENT, "Rig_Medium|Walking_C", Walk, 0.0, WALKS),
    Case(MANNEQUIN, MOVEMENT, "Rig_Medium|Running_A", Run, 0.0, RUNS),
    Case(MANNEQUIN, MOVEMENT, "Rig_Medium|Running_B", Run, 0.0, RUNS),
    Case(ZOMBIE, HUMAN, "Walk_Loop", Walk, 0.0, WALKS),
    Case(KNIGHT, HUMAN, "Walk_Loop", Walk, 0.0, WALKS),
    Case(HUMAN, KNIGHT, "Running_A", Run, 0.0, RUNS),
    // Without known names: the feet are found by touch. Cesium's man faces +X, and the figure moves
    // only its arms.
    Case(CESIUM, CESIUM, "", Walk, 90.0, WALKS),
    Case(FIGURE, FIGURE, "", Idle, 0.0, STILL),
    Case(KENNEY, KENNEY, "idle", Idle, 0.0, STILL),
    Case(KENNEY, KENNEY, "walk", Run, 0.0, RUNS),
];

fn main() {
    let arguments = Arguments::from_args();
    let trials = match std::env::var_os(VARIABLE) {
        Some(root) => trials(Path::new(&root)),
        None => {
            vec![Trial::test(format!("clips (set {VARIABLE})"), || Ok(())).with_ignored_flag(true)]
        }
    };
    libtest_mimic::run(&arguments, trials).exit();
}

fn trials(root: &Path) -> Vec<Trial> {
    let folder = root.join("characters");
    let of_case = |case: &'static Case| {
        let folder = folder.clone();
        let name = format!("{} of {} on {}", case.2, case.1, case.0);
        Trial::test(name, move || check(&folder, case))
    };
    let mut trials: Vec<_> = CASES.iter().map(of_case).collect();
    for fox in ["fox.glb", "m2m_fox.glb"] {
        let path = root.join("animals").join(fox);
        trials.push(Trial::test(format!("{fox} has no gait"), move || no_gait(&path)));
    }
    trials
}

fn measure(folder: &Path, case: &Case) -> Result<(Gait, f32), Failed> {
    let Case(body, file, name, ..) = case;
    let character = Arc::new(load(folder.join(body))?.character);
    let clips = load(folder.join(file))?.character.clips.clone();
    let clip = clips.iter().find(|clip| clip.name() == *name).ok_or("no such clip")?;
    let gait = Gait::measure(&character, clip)?.ok_or("no gait")?;
    Ok((gait, character.height_m()))
}

fn check(folder: &Path, case: &Case) -> Result<(), Failed> {
    let (gait, height_m) = measure(folder, case)?;
    let Case(body, _, name, kind, degrees, speeds) = case;
    let shares = [Side::Left, Side::Right].map(|foot| gait.contact_share_of(foot));
    println!(
        "| {body} | {name} | {:.2} m/s | {:.0} % | {:.0} % | {:.2} m/s |",
        gait.speed_m_per_sec(),
        100.0 * shares[0],
        100.0 * shares[1],
        gait.skate_m_per_sec
    );
    let fail = |what: &str| Err(Failed::from(format!("{what}: {gait:?}")));
    if !speeds.contains(&(gait.speed_m_per_sec() / height_m)) {
        return fail("the speed");
    }
    if let [Some(left), Some(right)] = gait.stance_center_m {
        // Cesium's man faces +X, so that his left is -Z.
        let left_of = if *body == CESIUM { right[1] - left[1] } else { left[0] - right[0] };
        if left_of < 0.0 {
            return fail("the sides");
        }
    }
    let stands = match kind {
        Walk => 0.4..0.75,
        Run => 0.13..0.48,
        Idle => return if shares == [1.0; 2] { Ok(()) } else { fail("a foot lifts") },
    };
    if !shares.iter().all(|share| stands.contains(share)) {
        return fail("the contacts");
    }
    let [left, forward] = gait.velocity_m_per_sec;
    let off = (left.atan2(forward).to_degrees() - degrees).rem_euclid(360.0);
    if off.min(360.0 - off) > 8.0 {
        return fail("the direction");
    }
    if gait.step_count() != 2 {
        return fail("the steps");
    }
    let middle = |contact: usize| {
        let contact = &gait.contacts[contact];
        0.5 * (contact.from_secs + contact.until_secs) / gait.duration_secs
    };
    let apart = (middle(1) - middle(0)).rem_euclid(1.0);
    if (0.4..0.6).contains(&apart) { Ok(()) } else { fail("the phases of the feet") }
}

fn no_gait(path: &Path) -> Result<(), Failed> {
    let character = Arc::new(load(path)?.character);
    for clip in &character.clips {
        if let Some(gait) = Gait::measure(&character, clip)? {
            return Err(format!("{}: {gait:?}", clip.name()).into());
        }
    }
    Ok(())
}
