//! Retargeting of walks between real bodies in the folder that `POPULACE_TEST_DATA` names, and
//! between built-in people.

#![expect(clippy::print_stdout, reason = "measurements are printed for runs with --nocapture")]

mod soles;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial};
use populace::character::Character;
use populace::model::{Affine, JointIndex, Role, RoleMap, Side};
use populace::{
    CharacterId, ClipId, ClipPlayback, Crowd, Device, MemberId, MotionSettings, MotionSource,
    Placement,
};
use populace_cast::{Look, person};
use soles::Feet;

/// Bodies, each with the name of its walk.
const WALKS: [(&str, &str); 3] = [
    ("kaykit_knight", "Walking_A"),
    ("m2m_human_base", "Walk_Loop"),
    ("quaternius_robot", "Robot_Walking"),
];
/// Largest angle between limbs of the source and of the target.
const MAX_LIMB_DEGREES: f64 = 5.0;
/// Largest sinking of ankles, toes and drawn feet below rest, in units of the body's height.
const MAX_SINKING: f64 = 0.01;
/// Largest rotation speed of feet in units of that on the clip's own body.
const MAX_FOOT_ROTATION: f64 = 1.5;
/// Largest difference between bodies of the hips' mean height in units of their rest height.
const MAX_HIPS_DIFFERENCE: f64 = 0.05;
/// Largest sliding of the supporting foot in units of the distance walked.
const MAX_SLIDING: f64 = 0.12;

type Check = fn(&Path) -> Result<(), Failed>;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = match std::env::var_os("POPULACE_TEST_DATA") {
        Some(folder) => trials(Path::new(&folder)),
        None => {
            let name = "retarget (POPULACE_TEST_DATA does not name a folder of test data)";
            vec![Trial::test(name, || Ok(())).with_ignored_flag(true)]
        }
    };
    trials.push(Trial::test("built-in people retargeted to each other", people));
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trials(folder: &Path) -> Vec<Trial> {
    let mut trials = Vec::new();
    for (from, clip) in WALKS {
        for (target_name, _) in WALKS {
            let folder = folder.join("characters");
            trials.push(Trial::test(format!("{clip} of {from} on {target_name}"), move || {
                if from != target_name {
                    walk(&folder, (from, clip), target_name)?;
                    check_drawn_feet(&load(&folder, from)?, clip, &load(&folder, target_name)?)?;
                }
                check_sliding(&folder, (from, clip), target_name)
            }));
        }
    }
    let others: [(&str, Check); 4] = [
        ("clips of the same rig are bound by name", by_name),
        ("non-humanoid clip is refused with the missing joints", refused),
        ("pose plays clips of another file", pose),
        ("feet of an IK rig are attached to its legs and follow a slope", feet_on_legs),
    ];
    for (name, check) in others {
        let folder = folder.join("characters");
        trials.push(Trial::test(name, move || check(&folder)));
    }
    trials
}

/// The clips of a fox are refused for a knight.
fn refused(folder: &Path) -> Result<(), Failed> {
    let (knight, fox) = (load(folder, "kaykit_knight")?, load(folder, "../animals/fox")?);
    let (mut crowd, [(id, member), _]) = crowd_of([&knight, &fox])?;
    let walk = fox.clips.iter().find(|c| c.name() == "Walk").ok_or("no walk")?;
    let clip = crowd.character_mut(id)?.add_clip(walk)?;
    let refused = crowd.member_mut(member).and_then(|mut m| m.play(clip, ClipPlayback::looping()));
    let text = refused.err().ok_or("a knight walks like a fox")?.to_string();
    let explains = text.contains("\"Walk\" cannot move this skeleton")
        && text.contains("this skeleton has them");
    if explains { Ok(()) } else { Err(text.into()) }
}

/// A robot whose feet are children of its root walks the same with feet as children of its legs,
/// and these follow a slope.
fn feet_on_legs(folder: &Path) -> Result<(), Failed> {
    const SLOPE: f32 = 0.2;
    let loose = load(folder, "quaternius_robot")?;
    let roles = RoleMap::detect(&loose.skeleton).ok_or("a body without roles")?;
    let attached = loose.with_feet_on_legs(&roles).map_err(|e| e.to_string())?;
    let attached_roles = RoleMap::detect(&attached.skeleton).ok_or("a body without roles")?;
    let height = f64::from(loose.height_m());
    let (mut crowd, members) = crowd_of([&loose, &attached])?;
    for (id, member) in members {
        let walk = crowd.clip(id, "Robot_Walking")?;
        crowd.member_mut(member)?.play(walk, ClipPlayback::looping())?;
    }
    let feet = [Side::Left, Side::Right].map(Role::Foot);
    let mut apart: f64 = 0.0;
    for planted in [false, true] {
        if planted {
            crowd.set_ground(&populace::Ground::plane(0.0, [SLOPE, 0.0])?)?;
            crowd.member_mut(members[1].1)?.plant_feet(1.0)?;
        }
        for _ in 0..SAMPLES {
            crowd.update(0.03)?;
            let [was, now] = [(members[0].1, &roles), (members[1].1, &attached_roles)];
            let was = positions(&crowd.member_mut(was.0)?.model_from_joints()?, was.1);
            let now = positions(&crowd.member_mut(now.0)?.model_from_joints()?, now.1);
            for foot in feet {
                let ground = if planted { f64::from(SLOPE) * now[&foot][0] } else { 0.0 };
                let off = now[&foot][1] - was[&foot][1] - ground;
                apart = apart.max(off.abs() / height);
            }
        }
        println!("robot, planted {planted}: feet are off by {apart} of the height");
        if apart > 0.02 {
            return Err(format!("feet are off by {apart} of the body's height").into());
        }
    }
    Ok(())
}

/// Retargeting in the program gives the same numbers on the native device and on OpenCL.
fn pose(folder: &Path) -> Result<(), Failed> {
    let devices: &[&str] = if cfg!(skip_opencl) { &["native"] } else { &["native", "opencl"] };
    let mut documents = Vec::new();
    for device in devices {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_populace"));
        command.arg("pose").arg(folder.join("quaternius_robot.glb"));
        command.arg("--clips").arg(folder.join("kaykit_knight.glb"));
        command.args(["--clip", "Walking_A", "--time", "0.3", "--json", "--device", device]);
        let output = command.output().map_err(|e| e.to_string())?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        let document: serde_json::Value =
            serde_json::from_slice(&output.stdout).map_err(|e| e.to_string())?;
        documents.push(document["joints"].clone());
    }
    if documents.iter().any(|joints| *joints != documents[0]) {
        return Err("devices differ".into());
    }
    Ok(())
}

fn load(folder: &Path, name: &str) -> Result<Character, Failed> {
    let file: PathBuf = folder.join(format!("{name}.glb"));
    Ok(populace_assets::load(&file).map_err(|e| e.to_string())?.character)
}

/// Creates a crowd with a member of each body.
fn crowd_of(bodies: [&Character; 2]) -> Result<(Crowd, [(CharacterId, MemberId); 2]), Failed> {
    let mut crowd =
        Crowd::builder().device(Device::native()).capacity(2).slots_per_member(1).build()?;
    let mut add = |body: &Character| -> Result<_, Failed> {
        let id = crowd.add_character(body.clone())?;
        Ok((id, crowd.spawn(id, Placement::at([0.0; 3]))?))
    };
    let members = [add(bodies[0])?, add(bodies[1])?];
    Ok((crowd, members))
}

/// Returns the positions of a body's joints by role.
fn positions(models: &[Affine], roles: &RoleMap) -> BTreeMap<Role, [f64; 3]> {
    let position = |joint: JointIndex| models[joint.index()].rows.map(|row| f64::from(row[3]));
    roles.iter().map(|(role, joint)| (role, position(joint))).collect()
}

/// Returns the angle between the directions of a limb on two bodies.
fn angle_degrees(bodies: [&BTreeMap<Role, [f64; 3]>; 2], from: Role, to: Role) -> f64 {
    let [a, b] = bodies.map(|positions| {
        let v: [f64; 3] = std::array::from_fn(|axis| positions[&to][axis] - positions[&from][axis]);
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    });
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().clamp(-1.0, 1.0).acos().to_degrees()
}

/// Measurements of a walk.
#[derive(Default)]
struct Measured {
    limb_degrees: f64,
    /// In units of the height.
    sinking: f64,
    hips: [f64; 2],
    /// The smallest distance of knees in front of the line from hip to ankle, in units of the
    /// height.
    knees: f64,
}

/// Samples of a walk cycle.
const SAMPLES: u32 = 48;

/// Checks limbs, feet, hips and knees of a retargeted walk.
fn walk(folder: &Path, (from, clip): (&str, &str), target_name: &str) -> Result<(), Failed> {
    let (source, target) = (load(folder, from)?, load(folder, target_name)?);
    let (mut crowd, members) = crowd_of([&source, &target])?;
    let clip = crowd.clip(members[0].0, clip)?;
    let roles = [source, target].map(|body| RoleMap::detect(&body.skeleton).ok_or("no roles"));
    let [Ok(source_roles), Ok(target_roles)] = roles else {
        return Err("a body without roles".into());
    };
    let found = measure(&mut crowd, members, clip, [&source_roles, &target_roles])?;
    println!(
        "limbs {:.2} degrees, sinking {:.2} %, hips at {:.3} of rest (source: {:.3}), knees {:.3}",
        found.limb_degrees,
        100.0 * found.sinking,
        found.hips[1],
        found.hips[0],
        found.knees
    );
    let checks = [
        (
            found.limb_degrees <= MAX_LIMB_DEGREES,
            format!("a limb is {:.2} degrees off", found.limb_degrees),
        ),
        (
            found.sinking <= MAX_SINKING,
            format!("a foot sinks by {:.2} % of the height", 100.0 * found.sinking),
        ),
        (
            (found.hips[0] - found.hips[1]).abs() <= MAX_HIPS_DIFFERENCE,
            format!("hips are at {:?} of their rest height", found.hips),
        ),
        (
            found.knees > -0.005,
            format!("a knee bends backwards by {:.3} of the height", -found.knees),
        ),
    ];
    match checks.into_iter().find(|(holds, _)| !holds) {
        Some((_, what)) => Err(what.into()),
        None => Ok(()),
    }
}

fn measure(
    crowd: &mut Crowd,
    members: [(CharacterId, MemberId); 2],
    clip: ClipId,
    roles: [&RoleMap; 2],
) -> Result<Measured, Failed> {
    let height = f64::from(crowd.character(members[1].0)?.asset().height_m());
    crowd.update(0.0)?;
    let at = |crowd: &mut Crowd| -> Result<_, Failed> {
        let mut one = |n: usize| -> Result<_, Failed> {
            Ok(positions(&crowd.member_mut(members[n].1)?.model_from_joints()?, roles[n]))
        };
        Ok([one(0)?, one(1)?])
    };
    let rest = at(crowd)?;
    let clips = crowd.character(members[0].0)?.clips();
    let (_, motion) = clips.iter().find(|(id, _)| *id == clip).ok_or("the clip is gone")?;
    let mut found = Measured { knees: f64::MAX, ..Measured::default() };
    for sample in 0..SAMPLES {
        let part = sample as f32 / SAMPLES as f32;
        for (_, member) in members {
            let secs = motion.start_secs() + part * motion.duration_secs();
            crowd.member_mut(member)?.play(clip, ClipPlayback::held_at_secs(secs))?;
        }
        crowd.update(0.0)?;
        let now = at(crowd)?;
        for side in [Side::Left, Side::Right] {
            let limbs = [
                (Role::UpperArm(side), Role::LowerArm(side)),
                (Role::LowerArm(side), Role::Hand(side)),
                (Role::UpperLeg(side), Role::LowerLeg(side)),
                (Role::LowerLeg(side), Role::Foot(side)),
            ];
            for (a, b) in limbs {
                found.limb_degrees =
                    found.limb_degrees.max(angle_degrees([&now[0], &now[1]], a, b));
            }
            for role in
                [Role::Foot(side), Role::Toes(side)].into_iter().filter(|r| now[1].contains_key(r))
            {
                found.sinking = found.sinking.max((rest[1][&role][1] - now[1][&role][1]) / height);
            }
            let [hip, knee, ankle] = [Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side)]
                .map(|role| now[1][&role]);
            let along = (hip[1] - knee[1]) / (hip[1] - ankle[1]);
            found.knees =
                found.knees.min((knee[2] - (hip[2] + along * (ankle[2] - hip[2]))) / height);
        }
        for n in 0..2 {
            found.hips[n] += now[n][&Role::Hips][1] / rest[n][&Role::Hips][1] / f64::from(SAMPLES);
        }
    }
    Ok(found)
}

/// With root motion from the feet of another body's walk, the supporting foot does not slide.
fn check_sliding(
    folder: &Path,
    (from, clip): (&str, &str),
    target_name: &str,
) -> Result<(), Failed> {
    let (source, target) = (load(folder, from)?, load(folder, target_name)?);
    let roles = RoleMap::detect(&target.skeleton).ok_or("a body without roles")?;
    let walk = source.clips.iter().find(|c| c.name() == clip).ok_or("no walk")?;
    let by_feet = MotionSettings { from: MotionSource::Feet, ..MotionSettings::default() };
    let walk = walk.with_root_motion(&by_feet).map_err(|e| e.to_string())?;
    let (mut crowd, [_, (id, member)]) = crowd_of([&source, &target])?;
    let step_secs = walk.duration_secs() / SAMPLES as f32;
    let clip = crowd.character_mut(id)?.add_clip(&walk.into())?;
    crowd.member_mut(member)?.play(clip, ClipPlayback::looping())?;
    crowd.member_mut(member)?.start_root_motion()?;
    crowd.update(0.0)?;
    let sole = |side| {
        if roles.joint(Role::Toes(side)).is_some() { Role::Toes(side) } else { Role::Foot(side) }
    };
    let feet = [Side::Left, Side::Right].map(sole);
    let mut before = positions(&crowd.member_mut(member)?.model_from_joints()?, &roles);
    let start = before[&Role::Hips][2];
    let mut sliding = 0.0;
    for _ in 0..SAMPLES {
        crowd.update(step_secs)?;
        let now = positions(&crowd.member_mut(member)?.model_from_joints()?, &roles);
        let height = |role: &Role| now[role][1] + before[role][1];
        let foot =
            feet.into_iter().min_by(|a, b| height(a).total_cmp(&height(b))).ok_or("no feet")?;
        sliding += now[&foot][2] - before[&foot][2];
        before = now;
    }
    let part = sliding / (before[&Role::Hips][2] - start);
    println!("feet slide by {:.1} % of the distance", 100.0 * part);
    if part.abs() <= MAX_SLIDING {
        Ok(())
    } else {
        Err(format!("feet slide by {:.1} % of the distance", 100.0 * part).into())
    }
}

/// No foot is drawn below the ground, whatever the shoes, and no foot flips to avoid that.
fn check_drawn_feet(source: &Character, clip: &str, target: &Character) -> Result<(), Failed> {
    let walk = source.clips.iter().find(|c| c.name() == clip).ok_or("no walk")?;
    let (mut crowd, members) = crowd_of([source, target])?;
    let mut seen = Vec::new();
    for (body, (id, member)) in [source, target].into_iter().zip(members) {
        let roles = RoleMap::detect(&body.skeleton).ok_or("a body without roles")?;
        let clip = crowd.character_mut(id)?.add_clip(walk)?;
        seen.push(Feet::new(body, &roles).measure(&mut crowd, member, (clip, walk))?);
    }
    let [own, retargeted] = &seen[..] else { return Err("two bodies were measured".into()) };
    let sunk = format!(
        "a foot sinks by {:.2} % of the height at {:.2} of the cycle, and by {:.2} % on the clip's \
         own body",
        100.0 * retargeted.sinking,
        retargeted.phase,
        100.0 * own.sinking
    );
    let turned = format!(
        "feet rotate by up to {:.2} rad per sample, and {:.2} rad there",
        retargeted.rotation_rad, own.rotation_rad
    );
    println!("{sunk}; {turned}");
    if retargeted.sinking > MAX_SINKING {
        return Err(sunk.into());
    }
    if retargeted.rotation_rad > MAX_FOOT_ROTATION * own.rotation_rad {
        Err(turned.into())
    } else {
        Ok(())
    }
}

/// Checks built-in people of different builds and rigs.
fn people() -> Result<(), Failed> {
    let looks = [Look::woman(), Look::man(), Look::child()];
    let people =
        looks.iter().map(person).collect::<Result<Vec<_>, _>>().map_err(|e| e.to_string())?;
    for (from, target_name) in [(0, 1), (0, 2), (1, 0), (2, 1)] {
        for clip in ["Walk", "Run"] {
            check_drawn_feet(&people[from], clip, &people[target_name])?;
        }
    }
    Ok(())
}

/// The mage has the knight's rig, so the knight's walk is bound by name and looks the same.
fn by_name(folder: &Path) -> Result<(), Failed> {
    let (knight, mage) = (load(folder, "kaykit_knight")?, load(folder, "kaykit_mage")?);
    let walk = |body: &Character| body.clips.iter().find(|c| c.name() == "Walking_A").cloned();
    let (own, foreign) = (walk(&mage).ok_or("no walk")?, walk(&knight).ok_or("no walk")?);
    if !foreign.is_made_for(&mage.skeleton) {
        return Err("the knight's walk is not bound by name".into());
    }
    let (mut crowd, [(id, member), _]) = crowd_of([&mage, &knight])?;
    let mut pose = |clip| -> Result<_, Failed> {
        let clip = crowd.character_mut(id)?.add_clip(clip)?;
        crowd.member_mut(member)?.play(clip, ClipPlayback::held_at_secs(0.4))?;
        crowd.update(0.0)?;
        Ok(crowd.member_mut(member)?.model_from_joints()?)
    };
    let (a, b) = (pose(&own)?, pose(&foreign)?);
    let far = a.iter().zip(&b).any(|(a, b)| {
        a.rows.iter().flatten().zip(b.rows.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-3)
    });
    if far { Err("the same walk looks different".into()) } else { Ok(()) }
}
