//! Walks of real bodies on each other, of the folder that `POPULACE_TEST_DATA` names, and of
//! built-in people.

#![expect(
    clippy::print_stdout,
    reason = "what was measured is for those who run tests with --nocapture"
)]

mod soles;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use libtest_mimic::{Arguments, Failed, Trial};
use populace::character::Character;
use populace::model::{Affine, JointIndex, Role, RoleMap, Side};
use populace::{
    CharacterId, ClipId, Crowd, Device, Member, MotionSettings, MotionSource, Placement, Play,
};
use populace_cast::{Look, person};
use soles::Soles;

const WALKS: [(&str, &str); 3] = [
    ("kaykit_knight", "Walking_A"),
    ("m2m_human_base", "Walk_Loop"),
    ("quaternius_robot", "Robot_Walking"),
];
/// Of limbs, between the body that the walk was made for and the other.
const LIMB_DEGREES: f64 = 5.0;
/// How far ankles and toes, and feet as they are drawn, may sink below where they rest, in parts of
/// the body's height.
const SINKS: f64 = 0.01;
/// How much faster than on its own body a clip may turn feet.
const FLIPS: f64 = 1.5;
/// The hips' mean height over that at rest, between bodies.
const HIPS: f64 = 0.05;
/// How far toes, or ankles where there are none, of feet that bear a walker slide, in parts of the
/// way it goes.
const SLIDES: f64 = 0.12;

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
    trials.push(Trial::test("built-in people on each other", people));
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trials(folder: &Path) -> Vec<Trial> {
    let mut trials = Vec::new();
    for (from, clip) in WALKS {
        for (onto, _) in WALKS {
            let folder = folder.join("characters");
            trials.push(Trial::test(format!("{clip} of {from} on {onto}"), move || {
                if from != onto {
                    walk(&folder, (from, clip), onto)?;
                    drawn(&load(&folder, from)?, clip, &load(&folder, onto)?)?;
                }
                walk_on(&folder, (from, clip), onto)
            }));
        }
    }
    let others: [(&str, Check); 4] = [
        ("clips of one rig keep their binding by name", by_name),
        ("clips of no humanoid are refused with what was looked for", refused),
        ("pose finds clips of another file", pose),
        ("feet of a rig for IK hang on its legs and stand on a slope", feet_on_legs),
    ];
    for (name, check) in others {
        let folder = folder.join("characters");
        trials.push(Trial::test(name, move || check(&folder)));
    }
    trials
}

/// A knight cannot walk as a fox does.
fn refused(folder: &Path) -> Result<(), Failed> {
    let (knight, fox) = (load(folder, "kaykit_knight")?, load(folder, "../animals/fox")?);
    let (mut crowd, [(id, member), _]) = crowd_of([&knight, &fox])?;
    let walk = fox.clips.iter().find(|c| c.name() == "Walk").ok_or("no walk")?;
    let clip = crowd.add_clip(id, walk)?;
    let refused = crowd.play(member, clip, Play::looping());
    let text = refused.err().ok_or("a knight walks like a fox")?.to_string();
    let says = text.contains("\"Walk\" cannot move this skeleton")
        && text.contains("which this skeleton has");
    if says { Ok(()) } else { Err(text.into()) }
}

/// A robot whose feet hang on its root walks the same with feet on its legs, and these keep to a
/// slope.
fn feet_on_legs(folder: &Path) -> Result<(), Failed> {
    const SLOPE: f32 = 0.2;
    let loose = load(folder, "quaternius_robot")?;
    let roles = RoleMap::detect(&loose.skeleton).ok_or("a body without roles")?;
    let hung = loose.with_feet_on_legs(&roles).map_err(|e| e.to_string())?;
    let hung_roles = RoleMap::detect(&hung.skeleton).ok_or("a body without roles")?;
    let height = f64::from(loose.height_m());
    let (mut crowd, members) = crowd_of([&loose, &hung])?;
    for (id, member) in members {
        let walk = crowd.clip(id, "Robot_Walking")?;
        crowd.play(member, walk, Play::looping())?;
    }
    let feet = [Side::Left, Side::Right].map(Role::Foot);
    let mut apart: f64 = 0.0;
    for planted in [false, true] {
        if planted {
            crowd.set_ground(&populace::Ground::plane(0.0, [SLOPE, 0.0])?)?;
            crowd.plant_feet(members[1].1, populace::Weight::FULL)?;
        }
        for _ in 0..MOMENTS {
            crowd.update(0.03)?;
            let [was, now] = [(members[0].1, &roles), (members[1].1, &hung_roles)];
            let was = places(&crowd.model_from_joints(was.0)?, was.1);
            let now = places(&crowd.model_from_joints(now.0)?, now.1);
            for foot in feet {
                let ground = if planted { f64::from(SLOPE) * now[&foot][0] } else { 0.0 };
                let off = now[&foot][1] - was[&foot][1] - ground;
                apart = apart.max(off.abs() / height);
            }
        }
        println!(
            "robot, planted {planted}: feet are {apart} of the height from where the clip and \
             ground have them"
        );
        if apart > 0.02 {
            return Err(format!("feet are off by {apart} of the body's height").into());
        }
    }
    Ok(())
}

/// The program's own way, on the native device and, where there is one, on OpenCL: the same
/// numbers.
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

/// A crowd with a member of each body.
fn crowd_of(bodies: [&Character; 2]) -> Result<(Crowd, [(CharacterId, Member); 2]), Failed> {
    let mut crowd =
        Crowd::builder().device(Device::native()).capacity(2).slots_per_member(1).build()?;
    let mut add = |body: &Character| -> Result<_, Failed> {
        let id = crowd.add_character(body.clone())?;
        Ok((id, crowd.spawn(id, Placement::at([0.0; 3]))?))
    };
    let members = [add(bodies[0])?, add(bodies[1])?];
    Ok((crowd, members))
}

/// Places of a body's joints by role.
fn places(models: &[Affine], roles: &RoleMap) -> BTreeMap<Role, [f64; 3]> {
    let place = |joint: JointIndex| models[joint.index()].rows.map(|row| f64::from(row[3]));
    roles.iter().map(|(role, joint)| (role, place(joint))).collect()
}

/// Between the directions of the limb of a role on two bodies.
fn angle_degrees(bodies: [&BTreeMap<Role, [f64; 3]>; 2], from: Role, to: Role) -> f64 {
    let [a, b] = bodies.map(|places| {
        let v: [f64; 3] = std::array::from_fn(|axis| places[&to][axis] - places[&from][axis]);
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    });
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().clamp(-1.0, 1.0).acos().to_degrees()
}

/// What a walk was found to do.
#[derive(Default)]
struct Found {
    limb_degrees: f64,
    /// In parts of the height.
    sinks: f64,
    hips: [f64; 2],
    /// How far knees lead in front of the line from hip to ankle, at least, in parts of the height.
    knees: f64,
}

const MOMENTS: u32 = 48;

fn walk(folder: &Path, (from, clip): (&str, &str), onto: &str) -> Result<(), Failed> {
    let (source, target) = (load(folder, from)?, load(folder, onto)?);
    let (mut crowd, members) = crowd_of([&source, &target])?;
    let clip = crowd.clip(members[0].0, clip)?;
    let roles = [source, target].map(|body| RoleMap::detect(&body.skeleton).ok_or("no roles"));
    let [Ok(from_roles), Ok(onto_roles)] = roles else {
        return Err("a body without roles".into());
    };
    let found = look(&mut crowd, members, clip, [&from_roles, &onto_roles])?;
    println!(
        "limbs {:.2} degrees, sinks {:.2} %, hips at {:.3} of rest where the source's are at \
         {:.3}, knees {:.3}",
        found.limb_degrees,
        100.0 * found.sinks,
        found.hips[1],
        found.hips[0],
        found.knees
    );
    let checks = [
        (
            found.limb_degrees <= LIMB_DEGREES,
            format!("a limb is {:.2} degrees off", found.limb_degrees),
        ),
        (
            found.sinks <= SINKS,
            format!("a foot sinks by {:.2} % of the height", 100.0 * found.sinks),
        ),
        (
            (found.hips[0] - found.hips[1]).abs() <= HIPS,
            format!("hips stand at {:?} of their rest", found.hips),
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

fn look(
    crowd: &mut Crowd,
    members: [(CharacterId, Member); 2],
    clip: ClipId,
    roles: [&RoleMap; 2],
) -> Result<Found, Failed> {
    let height = f64::from(crowd.character(members[1].0)?.height_m());
    crowd.update(0.0)?;
    let at = |crowd: &mut Crowd| -> Result<_, Failed> {
        let mut one = |n: usize| -> Result<_, Failed> {
            Ok(places(&crowd.model_from_joints(members[n].1)?, roles[n]))
        };
        Ok([one(0)?, one(1)?])
    };
    let rest = at(crowd)?;
    let clips = crowd.clips(members[0].0)?;
    let (_, motion) = clips.iter().find(|(id, _)| *id == clip).ok_or("the clip is gone")?;
    let mut found = Found { knees: f64::MAX, ..Found::default() };
    for moment in 0..MOMENTS {
        let part = moment as f32 / MOMENTS as f32;
        for (_, member) in members {
            let secs = motion.start_secs() + part * motion.duration_secs();
            crowd.play(member, clip, Play::held_at_secs(secs))?;
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
                found.sinks = found.sinks.max((rest[1][&role][1] - now[1][&role][1]) / height);
            }
            let [hip, knee, ankle] = [Role::UpperLeg(side), Role::LowerLeg(side), Role::Foot(side)]
                .map(|role| now[1][&role]);
            let along = (hip[1] - knee[1]) / (hip[1] - ankle[1]);
            found.knees =
                found.knees.min((knee[2] - (hip[2] + along * (ankle[2] - hip[2]))) / height);
        }
        for n in 0..2 {
            found.hips[n] += now[n][&Role::Hips][1] / rest[n][&Role::Hips][1] / f64::from(MOMENTS);
        }
    }
    Ok(found)
}

/// A body that another's walk carries on by its feet does not slide over the ground: the foot that
/// bears it stays where it is.
fn walk_on(folder: &Path, (from, clip): (&str, &str), onto: &str) -> Result<(), Failed> {
    let (source, target) = (load(folder, from)?, load(folder, onto)?);
    let roles = RoleMap::detect(&target.skeleton).ok_or("a body without roles")?;
    let walk = source.clips.iter().find(|c| c.name() == clip).ok_or("no walk")?;
    let by_feet = MotionSettings { from: MotionSource::Feet, ..MotionSettings::default() };
    let walk = walk.with_root_motion(&by_feet).map_err(|e| e.to_string())?;
    let (mut crowd, [_, (id, member)]) = crowd_of([&source, &target])?;
    let step_secs = walk.duration_secs() / MOMENTS as f32;
    let clip = crowd.add_clip(id, &walk.into())?;
    crowd.play(member, clip, Play::looping())?;
    crowd.move_by_clips(member, true)?;
    crowd.update(0.0)?;
    let sole = |side| {
        if roles.joint(Role::Toes(side)).is_some() { Role::Toes(side) } else { Role::Foot(side) }
    };
    let feet = [Side::Left, Side::Right].map(sole);
    let mut before = places(&crowd.model_from_joints(member)?, &roles);
    let start = before[&Role::Hips][2];
    let mut slid = 0.0;
    for _ in 0..MOMENTS {
        crowd.update(step_secs)?;
        let now = places(&crowd.model_from_joints(member)?, &roles);
        let bears = |role: &Role| now[role][1] + before[role][1];
        let foot =
            feet.into_iter().min_by(|a, b| bears(a).total_cmp(&bears(b))).ok_or("no feet")?;
        slid += now[&foot][2] - before[&foot][2];
        before = now;
    }
    let part = slid / (before[&Role::Hips][2] - start);
    println!("feet slide by {:.1} % of the way", 100.0 * part);
    if part.abs() <= SLIDES {
        Ok(())
    } else {
        Err(format!("feet slide by {:.1} % of the way", 100.0 * part).into())
    }
}

/// No foot is drawn in the ground, whatever shoes the body has, and none flips to stay out of it.
fn drawn(source: &Character, clip: &str, target: &Character) -> Result<(), Failed> {
    let walk = source.clips.iter().find(|c| c.name() == clip).ok_or("no walk")?;
    let (mut crowd, members) = crowd_of([source, target])?;
    let mut seen = Vec::new();
    for (body, (id, member)) in [source, target].into_iter().zip(members) {
        let roles = RoleMap::detect(&body.skeleton).ok_or("a body without roles")?;
        let clip = crowd.add_clip(id, walk)?;
        seen.push(Soles::of(body, &roles).watch(&mut crowd, member, (clip, walk))?);
    }
    let [own, lent] = &seen[..] else { return Err("two bodies were watched".into()) };
    let sunk = format!(
        "a foot is drawn {:.2} % of the height deep at {:.2} of the cycle, and {:.2} % on its own \
         body",
        100.0 * lent.sunk,
        lent.at,
        100.0 * own.sunk
    );
    let turned = format!(
        "feet turn by up to {:.2} radians at once, and {:.2} there",
        lent.turned, own.turned
    );
    println!("{sunk}; {turned}");
    if lent.sunk > SINKS {
        return Err(sunk.into());
    }
    if lent.turned > FLIPS * own.turned { Err(turned.into()) } else { Ok(()) }
}

/// Built-in people of other builds and rigs.
fn people() -> Result<(), Failed> {
    let looks = [Look::woman(), Look::man(), Look::child()];
    let people =
        looks.iter().map(person).collect::<Result<Vec<_>, _>>().map_err(|e| e.to_string())?;
    for (from, onto) in [(0, 1), (0, 2), (1, 0), (2, 1)] {
        for clip in ["Walk", "Run"] {
            drawn(&people[from], clip, &people[onto])?;
        }
    }
    Ok(())
}

/// The mage shares the knight's rig: its members get the same bits as if clips knew nothing of
/// roles.
fn by_name(folder: &Path) -> Result<(), Failed> {
    let (knight, mage) = (load(folder, "kaykit_knight")?, load(folder, "kaykit_mage")?);
    let walk = |body: &Character| body.clips.iter().find(|c| c.name() == "Walking_A").cloned();
    let (own, lent) = (walk(&mage).ok_or("no walk")?, walk(&knight).ok_or("no walk")?);
    if !lent.is_made_for(&mage.skeleton) {
        return Err("the knight's walk is not bound by name".into());
    }
    let (mut crowd, [(id, member), _]) = crowd_of([&mage, &knight])?;
    let mut pose = |clip| -> Result<_, Failed> {
        let clip = crowd.add_clip(id, clip)?;
        crowd.play(member, clip, Play::held_at_secs(0.4))?;
        crowd.update(0.0)?;
        Ok(crowd.model_from_joints(member)?)
    };
    let (a, b) = (pose(&own)?, pose(&lent)?);
    let far = a.iter().zip(&b).any(|(a, b)| {
        a.rows.iter().flatten().zip(b.rows.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-3)
    });
    if far { Err("the same walk looks different".into()) } else { Ok(()) }
}
